//! From a path to a data set, or to a card of what is wrong with it.

use crate::check::card::Card;
use crate::dataset::assemble::assemble;
use crate::dataset::dataset::Dataset;
use crate::dataset::one_hot::Columns;
use crate::dataset::raw::Raw;
use crate::formats::bag::path::is_bag;
use crate::formats::ucr::names_pair;
use crate::formats::{READERS, npy_file};
use crate::options::ReadOptions;
use crate::reader::{Place, Purpose};
use crate::{Error, Result};
use ndarray::ArrayD;
use std::io;
use std::path::Path;

/// Reads the data set at `path`: a file or folder in one of the [`formats`](crate::formats), whose rows say what lies how
/// and what it becomes; `docs/data.md` has the same table.
///
/// Recordings may differ in length along time; [`ReadOptions::length`] says what becomes of them. Steps at the end
/// of a sample in which every value is NaN are padding and no readings.
///
/// # Errors
///
/// The first thing that is wrong: the path, the archive, types and shapes, labels out of range or
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
/// Only what keeps the file from being read at all; everything else is in [`Card::problems`].
pub fn check(path: &Path) -> Result<Card> {
    check_with(path, &ReadOptions::default())
}

/// [`check`] with other than default options.
///
/// # Errors
///
/// As [`check`], and options that do not fit the file.
pub fn check_with(path: &Path, options: &ReadOptions) -> Result<Card> {
    survey(path, options).map(|survey| survey.card)
}

/// A data set with all that is known of it, usable or not.
#[derive(Debug)]
pub struct Survey {
    /// What it holds, and what is wrong with it.
    pub card: Card,
    /// Its samples; where recordings are unequal and nobody has said what to do, under the proposed rule. Where the
    /// card has problems it may break what [`Dataset`] promises: labels without a class, values that are not finite.
    pub dataset: Dataset,
    /// Readings of each recording along time before a rule, where there is one.
    pub readings: Option<Vec<usize>>,
}

/// [`check_with`], and the samples to look at.
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
    card.labels = match checked.columns {
        Columns::One | Columns::Unsaid => card.labels,
        Columns::OneHot => {
            Some(format!("labels are one-hot: {} classes", checked.dataset.output_names().len()))
        }
        Columns::Attributes => checked.dataset.targets.columns().map(|columns| {
            let count = columns.attributes().len();
            match (options.attributes.is_empty(), options.attribute.unwrap_or(0)) {
                (true, own) => format!("labels are {count} attributes, of which column {own} is the class"),
                (false, _) => format!("labels are {count} attributes"),
            }
        }),
    };
    card.problems = checked.problems.iter().map(ToString::to_string).collect();
    Ok(Survey { card, dataset: checked.dataset, readings: checked.readings })
}

/// Reads what lies at a path with the first reader that recognises it.
pub(crate) fn open(path: &Path, purpose: Purpose, options: &ReadOptions) -> Result<Raw> {
    let place = Place { path, purpose, readers: READERS };
    let reader = READERS.iter().find(|reader| reader.recognises(&place, options));
    let raw = reader.ok_or_else(|| refuse(&place))?.read(&place, options)?;
    if !options.topics.is_empty() && raw.topics.is_empty() {
        let why = "names topics of bags, of which there are none; leave it out";
        return Err(Error::Option { file: raw.file, option: "topics", why });
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
        Err(e) => Error::Io { file, kind: e.kind() },
        Ok(_) if is_bag(place.path) => Error::OneBag { file },
        Ok(about) if about.is_file() && !place.needs_labels() => place.unknown_extension(file),
        Ok(_) => Error::NotADataset { file, endings: place.endings(|reader| reader.reads_sets()) },
    }
}
