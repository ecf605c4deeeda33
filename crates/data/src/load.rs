//! From a path to a data set, or to a card of what is wrong with it.

use crate::check::card::Card;
use crate::dataset::assemble::assemble;
use crate::dataset::dataset::Dataset;
use crate::dataset::one_hot::Columns;
use crate::dataset::raw::Raw;
use crate::formats::archive::DATA;
use crate::formats::bag::names;
use crate::formats::bag::path::is_bag;
use crate::formats::hdf5;
use crate::formats::mat;
use crate::formats::table::table;
use crate::formats::ucr;
use crate::layout::arrays;
use crate::layout::folder;
use crate::layout::label_table;
use crate::layout::label_table::LABELS;
use crate::layout::lerobot;
use crate::layout::listing;
use crate::layout::listing::{Found, Listing, list};
use crate::layout::names_file::{self, NAMES};
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::io;
use std::path::Path;

/// Reads the data set at `path`: a `.npz` or `.mat`, a table in a `.csv`, a folder with `data.npz`, a folder of recordings, or a set
/// of the UCR and UEA archives.
///
/// - `.npz`: samples `x` `[N, F]`, `[N, C, T]`, `[N, H, W]` or `[N, T, H, W]` of integers, booleans, f16, f32 or
///   f64; labels `y` `[N]` or `[N, k]` of integers, booleans or texts; optional groups `[N]`. Class names
///   come from `<name>.classes.json` or `labels.json` beside it, otherwise they are the texts, or `0`, `1`, ...
///   `X`, `data`, `Y`, `labels` stand for `x` and `y`; `X_train`, `y_train`, `X_test`, `y_test` are an official
///   split; one array per recording beside its labels is a set of recordings.
/// - `.mat` of MATLAB 5 to 7: the same with variables for arrays, samples along the first axis; numbers of
///   any class, labels a row or a column, counted from 1 or from 0, or texts. Of version 7.3 too, which is HDF5.
/// - `.h5`, `.hdf5`: the same as in a `.npz` with data sets for arrays, those of groups by their path (`day1/x`).
/// - folder of recordings: `class/file`, `class/session/file` (the session is the group), or files with
///   `labels.csv` beside them (`file,label[,group]`); files in counting order; bags of ROS 2 in MCAP, a file each or
///   the folder that rosbag2 makes, of which [`ReadOptions::topics`] are read as `[C, T]` or, of images, `[T, H, W]`,
///   at equal steps of time, and whose names may say the class (`cup_03.mcap`); CSV (rows = time, columns =
///   channels) as `[C, T]`, NPY as stored, of a `.mat` or `.h5` its one array or the one named by
///   [`ReadOptions::x`], PNG/JPEG as `[H, W]` (grey) or `[3, H, W]`.
/// - `.csv` or `.tsv` table with a header, or `.parquet`, whose lists are columns `name.0`, `name.1`, ...: wide, a row per sample `[F]`, or long, a row per reading, rows of one
///   recording being its readings over time `[C, T]`; [`ReadOptions::table`] says what its columns are. Long recordings
///   with irregular time stamps are linearly interpolated onto the median step.
/// - folder of LeRobot, with `meta/info.json` and `data/**/*.parquet`: its episodes are the recordings `[C, T]`, its
///   observations the channels, tasks or `labels.csv` (`episode,label`) the classes.
/// - pair of files of the UCR and UEA archives: `GunPoint`, or the folder with both, reads `GunPoint_TRAIN.ts`
///   and `GunPoint_TEST.ts` (or `.tsv`, `.txt`, `.arff`) as `[C, T]`, with their split in [`Dataset::official`].
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
    let checked = assemble(open(path, options)?, options)?;
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
    let raw = open(path, options)?;
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

pub(crate) fn open(path: &Path, options: &ReadOptions) -> Result<Raw> {
    refuse_topics(find(path, options)?, options)
}

fn find(path: &Path, options: &ReadOptions) -> Result<Raw> {
    let file = path.display().to_string();
    if let Some(pair) = ucr::find(path) {
        return ucr::read(path, &pair, options);
    }
    let metadata = path.metadata().map_err(|e| match e.kind() {
        io::ErrorKind::NotFound => Error::NotFound { file: file.clone() },
        kind => Error::Io { file: file.clone(), kind },
    })?;
    if is_bag(path) {
        return Err(Error::OneBag { file });
    }
    if metadata.is_file() {
        return match (is_archive(path), table::is_named(path)) {
            (true, _) => arrays::read(path, options),
            (_, true) => table::read(path, options),
            _ => Err(Error::NotADataset { file }),
        };
    }
    if !metadata.is_dir() {
        return Err(Error::NotADataset { file });
    }
    if lerobot::is_set(path) {
        return lerobot::read(path, options, true);
    }
    let data = path.join(DATA);
    if data.is_file() {
        return arrays::read(&data, options);
    }
    let top = list(path)?;
    if let Some(found) = labelled(path, &top, options)? {
        return folder::read(path, found, options);
    }
    if top.files.iter().any(|own| is_bag(own)) {
        return Err(Error::BagsWithoutClasses { file });
    }
    let archives: Vec<String> = top
        .files
        .iter()
        .filter(|e| is_archive(e) || table::is_named(e))
        .filter_map(|e| Some(e.file_name()?.to_string_lossy().into_owned()))
        .collect();
    let hint = match archives.as_slice() {
        [] => String::new(),
        names => format!("; give one of {}", names.join(", ")),
    };
    Err(Error::NoDatasetInFolder { file, hint })
}

/// The recordings of a folder that says what they are, by a table, by folders of classes or by the names of bags; none
/// otherwise. `labels.json` in it may say what the readings are, and the order of the classes.
pub(crate) fn labelled(path: &Path, top: &Listing, options: &ReadOptions) -> Result<Option<Found>> {
    let found = if path.join(LABELS).is_file() {
        Some(label_table::read(path, top, options)?)
    } else if let Some(found) = names::per_name(path, top)? {
        Some(found)
    } else if top.folders.is_empty() {
        None
    } else {
        Some(listing::per_class(path, top)?)
    };
    let Some(mut found) = found else { return Ok(None) };
    let names = path.join(NAMES);
    found.ignored.retain(|own| own != NAMES);
    let (order, facts) = names_file::of_named(&[names], &found.classes, &options.limits)?;
    found.facts = facts;
    Ok(Some(match order {
        Some(order) => found.in_order(&order),
        None => found,
    }))
}

/// Refuses options that say nothing of what was read.
pub(crate) fn refuse_topics(raw: Raw, options: &ReadOptions) -> Result<Raw> {
    match options.topics.is_empty() || !raw.topics.is_empty() {
        true => Ok(raw),
        false => {
            let why = "names topics of bags, of which there are none; leave it out";
            Err(Error::Option { file: raw.file, option: "topics", why })
        }
    }
}

/// Whether a path is named as a file of arrays.
pub(crate) fn is_archive(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"))
        || mat::is_named(path)
        || hdf5::is_plain(path)
}
