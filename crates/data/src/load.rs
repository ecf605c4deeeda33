//! Reads a path as a data set, or as a card that lists its problems.

use crate::check::card::Card;
use crate::dataset::assemble::assemble;
use crate::dataset::channel_facts::name_channels;
use crate::dataset::dataset::Dataset;
use crate::dataset::one_hot::LabelForm;
use crate::dataset::raw::Raw;
use crate::formats::bag::path::{how_to_convert, is_bag};
use crate::formats::ucr::ucr::{names_pair, without_partner};
use crate::formats::{READERS, npy_file};
use crate::layout::resting::tare_by_readings;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{Place, Purpose};
use crate::tare::Tare;
use crate::{Error, Result};
use ndarray::ArrayD;
use std::io;
use std::path::Path;

/// Reads the data set at `path`: a file or folder in one of the [`formats`](crate::formats). `docs/data.md` has the
/// same table.
///
/// Recordings may differ in length along time; [`ReadOptions::length`] makes them equal. Time steps at the end of a
/// sample in which every value is NaN are padding and are left out.
///
/// # Errors
///
/// The first problem: the path, the archive, types and shapes, labels out of range or
/// missing, a value that is not finite, a class without samples, recordings of unequal length without a rule,
/// options that do not fit.
/// [`check`] lists all of them.
pub fn load(path: &Path, options: &ReadOptions) -> Result<Dataset> {
    let checked = assemble(open(path, Purpose::Learn, options)?, options)?;
    match checked.problems.into_iter().next() {
        Some(problem) => Err(problem.first),
        None => Ok(checked.dataset),
    }
}

/// Reads the data set at `path` with default options and describes it, problems included.
///
/// # Errors
///
/// A file that cannot be read at all; every other problem is in [`Card::problems`].
pub fn check(path: &Path) -> Result<Card> {
    check_with(path, &ReadOptions::default())
}

/// Reads the data set at `path` and describes it, problems included.
///
/// # Errors
///
/// As [`check`], and options that do not fit the file.
pub fn check_with(path: &Path, options: &ReadOptions) -> Result<Card> {
    survey(path, options).map(|survey| survey.card)
}

/// A data set and its description, usable or not.
#[derive(Debug)]
pub struct Survey {
    /// Its description, problems included.
    pub card: Card,
    /// Its samples; unequal recordings without a rule are under the proposed one. Where the card has problems, labels may
    /// have no class and values may not be finite, against the promises of [`Dataset`].
    pub dataset: Dataset,
    /// Time steps of each recording before a rule for its length, where there is one.
    pub readings: Option<Vec<usize>>,
}

/// Reads a data set as [`check_with`], and returns the samples beside the card.
///
/// # Errors
///
/// As [`check_with`].
pub fn survey(path: &Path, options: &ReadOptions) -> Result<Survey> {
    let raw = open(path, Purpose::Learn, options)?;
    let (others, ignored, read_as) = (raw.others.clone(), raw.ignored.clone(), raw.read_as.clone());
    let checked = assemble(raw, options)?;
    let mut card = Card::new(&checked.dataset);
    (card.other_arrays, card.ignored, card.read_as) = (others, ignored, read_as);
    card.lengths = checked.lengths;
    card.without_target = checked.without_target;
    card.labels = match checked.label_form {
        LabelForm::One | LabelForm::Unsaid => card.labels,
        LabelForm::OneHot => {
            Some(format!("labels are one-hot: {} classes", checked.dataset.output_names().len()))
        }
        LabelForm::Attributes => checked.dataset.targets.columns().map(|columns| {
            let count = columns.attributes().len();
            match (options.attributes.is_empty(), options.attribute.unwrap_or(0)) {
                (true, column) => {
                    format!("labels are {count} attributes, of which column {column} is the class")
                }
                (false, _) => format!("labels are {count} attributes"),
            }
        }),
    };
    card.problems = checked.problems.iter().map(ToString::to_string).collect();
    Ok(Survey { card, dataset: checked.dataset, readings: checked.readings })
}

/// Reads a path with the first reader that recognises it.
pub(crate) fn open(path: &Path, purpose: Purpose, options: &ReadOptions) -> Result<Raw> {
    let place = Place { path, purpose, readers: READERS };
    let of_event = options.event.as_ref().map(|event| event.options(options, &place.file())).transpose()?;
    let options = of_event.as_ref().unwrap_or(options);
    let reader = READERS.iter().find(|reader| reader.recognises(&place, options));
    let mut raw = reader.ok_or_else(|| refuse(&place))?.read(&place, options)?;
    let has_no_bags = !options.topics.is_empty() && raw.topics.is_empty();
    let why = "names topics of bags, of which there are none; leave it out";
    refuse_set(&raw.file, &[("topics", has_no_bags)], why)?;
    if let Some(event) = &options.event {
        event.refuse_several(&raw)?;
    }
    name_channels(&mut raw, options)?;
    // What a model takes off is said by the model.
    let stated = raw.facts.tare.take().filter(|_| purpose == Purpose::Learn && options.tare.is_none());
    match stated.as_ref().or(options.tare.as_ref()) {
        None | Some(Tare::Off) => {}
        Some(Tare::Recording { steps }) => tare_by_readings(&mut raw, *steps, options.layout)?,
        Some(Tare::Array(_)) => {
            let why = "names an array beside samples of a file of arrays, of which there are none; write recording:N for the \
                       mean of the first N readings";
            refuse_set(&raw.file, &[("tare", raw.tared.is_none())], why)?;
        }
    }
    if let Some(tare) = stated.and(raw.tared.as_ref()) {
        raw.read_as.push(format!("{} tared by {tare}", raw.facts.file));
    }
    Ok(raw)
}

/// Checks whether anything lies at a path: a file, a folder, or an archive's two files that it names without their endings.
pub fn exists(path: &Path) -> bool {
    path.exists() || names_pair(path)
}

/// Reads a `.npy` of integers or floats as f32, C order, any rank.
///
/// # Errors
///
/// A file that is missing, cut short or no NumPy array, another dtype, or a value that f32 cannot hold.
pub fn read_npy(path: &Path) -> Result<ArrayD<f32>> {
    let place = Place { path, purpose: Purpose::Learn, readers: READERS };
    npy_file::array(path).map_err(|e| place.with_advice(e))
}

/// Says why no reader recognises a place.
fn refuse(place: &Place) -> Error {
    let file = place.file();
    match place.path.metadata() {
        Err(e) if e.kind() == io::ErrorKind::NotFound => place.not_found(),
        Err(e) => Error::io(&file)(e),
        Ok(_) if is_bag(place.path) => Error::file(
            file,
            "is one bag, which says no class; give the folder of several, with labels.csv in it (file,label, and of \
             parts of a bag start,end in seconds)",
        ),
        Ok(about) if about.is_file() && (!place.needs_labels() || how_to_convert(place.path).is_some()) => {
            place.unknown_extension(file)
        }
        Ok(about) => {
            if let Some(why) = without_partner(place.path).filter(|_| about.is_file()) {
                return Error::file(file, why);
            }
            let endings = place.endings(|reader| reader.reads_sets());
            let why = "with labels, or a folder with one sub-folder per class";
            Error::file(file, format!("not a data set; give a {endings} {why}"))
        }
    }
}
