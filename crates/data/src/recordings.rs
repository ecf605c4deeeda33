//! Recordings that want an answer: labels, if there are any, only say whether it is right.

use crate::dataset::one_hot::settle;
use crate::dataset::raw::{Raw, name_of};
use crate::dataset::reading_of::time_axis;
use crate::dataset::validate::channels;
use crate::formats::archive::{Archive, DATA};
use crate::formats::array;
use crate::formats::bag::path::is_bag;
use crate::formats::hdf5;
use crate::formats::mat;
use crate::formats::table::table;
use crate::formats::ucr;
use crate::layout::arrays;
use crate::layout::folder;
use crate::layout::lerobot;
use crate::layout::listing::{Listing, list, unsorted};
use crate::layout::roles::{self, Roles};
use crate::layout::sample::Kind;
use crate::length::cut::cut;
use crate::length::length::Length;
use crate::length::lengths::Lengths;
use crate::length::one_length::refuse_channels;
use crate::length::ragged::Ragged;
use crate::load::{is_archive, labelled, refuse_topics};
use crate::options::ReadOptions;
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};
use std::path::Path;

/// Recordings of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Recordings {
    /// The file or folder name without extension.
    pub name: String,
    /// Samples `[N, ...]` in C order, as stored, or as [`ReadOptions::length`] makes them.
    pub x: ArrayD<f32>,
    /// Where each sample comes from: its file, or `x[17]`.
    pub origins: Vec<String>,
    /// Of samples that are windows the first reading of each, from 0; `origins` name their recordings.
    pub starts: Option<Vec<usize>>,
    /// Names of each sample's classes `[N][attributes]`; none where nothing is said of them.
    pub truth: Option<Vec<Vec<String>>>,
}

/// Reads recordings for a model that takes samples of `rank` axes: every layout of [`load`](crate::load), with
/// or without labels, a folder of files without class folders, and a single CSV, NPY, MAT, PNG or JPEG file.
///
/// A CSV file is a table for a model of features, or where a column of it names recordings; otherwise one recording.
///
/// Of a single `.npy`, `rank` axes are one sample and one more are a batch. With the `layout` and the `length`
/// of the model's reading in `options`, recordings may have any length.
///
/// # Errors
///
/// As [`load`](crate::load), labels left aside: classes may be missing, and more may be there than a model knows.
/// A recording without a window.
pub fn recordings(path: &Path, options: &ReadOptions, rank: usize) -> Result<Recordings> {
    let Read { raw, x, time, truth } = read(path, options, rank)?;
    let (x, windows) = one_length(&raw, x, time, options)?;
    let Some(windows) = windows else {
        return Ok(Recordings { name: raw.name, x, origins: raw.origins, starts: None, truth });
    };
    let of = |(row, _): &(usize, usize)| raw.origins[*row].clone();
    Ok(Recordings {
        origins: windows.iter().map(of).collect(),
        truth: truth.map(|truth| windows.iter().map(|(row, _)| truth[*row].clone()).collect()),
        starts: Some(windows.into_iter().map(|(_, start)| start).collect()),
        name: raw.name,
        x,
    })
}

/// One recording, as long as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Where it comes from: its file, or `x[17]`.
    pub origin: String,
    /// Lengths of its axes, in the order of its layout.
    pub shape: Vec<usize>,
    /// Its values, row-major.
    pub values: Vec<f32>,
}

/// Reads what [`recordings`] does and leaves every recording as long as it is: [`ReadOptions::length`] has no part in it.
///
/// # Errors
///
/// As [`recordings`].
pub fn whole_recordings(path: &Path, options: &ReadOptions, rank: usize) -> Result<Vec<Recording>> {
    let Read { raw, x, .. } = read(path, options, rank)?;
    let one = |(at, own): (usize, &[f32])| {
        let origin = raw.origins[at].clone();
        Recording { origin, shape: x.shape_of(at), values: own.to_vec() }
    };
    Ok(x.each().enumerate().map(one).collect())
}

/// Whether the recordings at `path`, a file or a folder of files, classes or sessions, are images.
pub fn are_images(path: &Path) -> bool {
    hold(path, Kind::Image, 3)
}

/// Whether the recordings at `path` are bags of ROS 2.
pub fn are_bags(path: &Path) -> bool {
    hold(path, Kind::Bag, 3)
}

fn hold(path: &Path, kind: Kind, levels: usize) -> bool {
    let own = Kind::of(path);
    if !path.is_dir() || own.is_some() {
        return own == Some(kind);
    }
    let below = |top: Listing| {
        let all = top.files.into_iter().chain(top.folders);
        all.into_iter().any(|path| hold(&path, kind, levels - 1))
    };
    levels > 0 && !path.join(DATA).is_file() && list(path).is_ok_and(below)
}

/// What is at a path, its recordings as long as they are.
struct Read {
    raw: Raw,
    x: Ragged,
    /// Their axis of time.
    time: Option<usize>,
    /// Names of each recording's classes, where they are known.
    truth: Option<Vec<Vec<String>>>,
}

fn read(path: &Path, options: &ReadOptions, rank: usize) -> Result<Read> {
    let (mut raw, is_labelled) = match batch(path, options, rank)? {
        Some(raw) => raw,
        None => open(path, options, rank)?,
    };
    raw = refuse_topics(raw, options)?;
    settle(&mut raw, options);
    let chosen = channels(&raw, options)?;
    let truth = is_labelled.then(|| truth(&raw)).filter(|rows| rows.len() == raw.x.len());
    let x = std::mem::take(&mut raw.x);
    let all: Vec<usize> = (0..x.len()).collect();
    let time = time_axis(options.layout, raw.facts.layout, raw.format, &raw.dtype, x.sample_shape());
    let x = match time {
        Some(axis) => x.without_padding(axis),
        None => x,
    };
    refuse_channels(&raw, &x, time, chosen.as_deref())?;
    let x = x.select(&all, chosen.as_deref());
    Ok(Read { raw, x, time, truth })
}

/// Recording and first reading of each sample that is a window.
type Windows = Option<Vec<(usize, usize)>>;

/// Samples of one length.
fn one_length(
    raw: &Raw,
    x: Ragged,
    time: Option<usize>,
    options: &ReadOptions,
) -> Result<(ArrayD<f32>, Windows)> {
    let unequal = |axis: usize, x: &Ragged| Lengths::of(&x.lengths(axis), None).refused(&raw.file);
    let (axis, rule) = match (time, &options.length) {
        (Some(axis), Some(rule)) => (axis, rule),
        (axis, _) => {
            let refused = axis.filter(|_| x.is_unequal()).map(|axis| unequal(axis, &x));
            return match (refused, x.into_array()) {
                (None, Some(x)) => Ok((x, None)),
                (Some(error), _) => Err(error),
                (None, None) => Err(Error::NoSamples { at: raw.file.clone() }),
            };
        }
    };
    let lengths = x.lengths(axis);
    let short = lengths.iter().position(|length| *length < rule.to());
    if let (Length::Window { to, .. }, Some(short)) = (*rule, short) {
        let why = "it holds no window, so there is no answer to it; leave it out";
        return Err(Error::RecordingLength {
            sample: raw.sample_name(short),
            length: lengths[short],
            to,
            why,
        });
    }
    let cut = cut(rule, &x, axis, &options.limits, &raw.file, |row| raw.sample_name(row))?;
    Ok((cut.x, cut.windows))
}

/// A `.npy` file of many samples.
fn batch(path: &Path, options: &ReadOptions, rank: usize) -> Result<Option<(Raw, bool)>> {
    if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("npy")) {
        return Ok(None);
    }
    let Some(x) = array::read_batch(path, rank, &options.limits)? else { return Ok(None) };
    let name = name_of(path);
    let origins = (0..x.len_of(Axis(0))).map(|i| format!("{name}[{i}]")).collect();
    Ok(Some((Raw::of_samples(name, path.display().to_string(), x.into(), origins), false)))
}

/// What is at `path`, and whether it says anything of classes.
fn open(path: &Path, options: &ReadOptions, rank: usize) -> Result<(Raw, bool)> {
    if let Some(pair) = ucr::find(path) {
        return Ok((ucr::read(path, &pair, options)?, true));
    }
    let file = path.display().to_string();
    let archive = |path: &Path| {
        let raw = arrays::read_unlabelled(path, options)?;
        let is_labelled = !raw.y.is_empty();
        Ok((raw, is_labelled))
    };
    if is_bag(path) {
        let folder = path.parent().unwrap_or(Path::new(""));
        return Ok((folder::read(folder, unsorted(vec![path.to_path_buf()]), options)?, false));
    }
    if path.is_file() {
        if table::is_table(path, options, rank) {
            let raw = table::read_unlabelled(path, options)?;
            let is_labelled = !raw.y.is_empty();
            return Ok((raw, is_labelled));
        }
        if is_archive(path) && !is_one_recording(path, options, rank) {
            return archive(path);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        return Ok((folder::read(folder, unsorted(vec![path.to_path_buf()]), options)?, false));
    }
    if !path.is_dir() {
        return Err(Error::NotFound { file });
    }
    if lerobot::is_set(path) {
        let raw = lerobot::read(path, options, false)?;
        let is_labelled = !raw.y.is_empty();
        return Ok((raw, is_labelled));
    }
    let data = path.join(DATA);
    if data.is_file() {
        return archive(&data);
    }
    let top = list(path)?;
    if let Some(found) = labelled(path, &top, options)? {
        return Ok((folder::read(path, found, options)?, true));
    }
    match top.files.is_empty() {
        true => Err(Error::NoDatasetInFolder { file, hint: String::new() }),
        false => Ok((folder::read(path, unsorted(top.files), options)?, false)),
    }
}

/// Whether a MATLAB or HDF5 file holds one recording of `rank` axes and not a set of them.
fn is_one_recording(path: &Path, options: &ReadOptions, rank: usize) -> bool {
    if !mat::is_named(path) && !hdf5::is_plain(path) {
        return false;
    }
    let Ok(mut archive) = Archive::open(path) else { return false };
    match Roles::of(&archive.saved(), options, false, |labels| archive.entries(labels)) {
        Ok(Roles { x: roles::Samples::One(x), y: None, .. }) => archive.shape(&x).len() == rank,
        Ok(_) => false,
        Err(_) => true,
    }
}

/// Names of the classes of each sample; a label that has no name goes by its number.
fn truth(raw: &Raw) -> Vec<Vec<String>> {
    let name = |(column, label): (usize, &i64)| {
        let names = raw.names.as_ref().and_then(|names| names.columns.get(column));
        let named = usize::try_from(*label).ok().and_then(|label| names?.get(label));
        named.cloned().unwrap_or_else(|| label.to_string())
    };
    raw.y.chunks_exact(raw.columns).map(|row| row.iter().enumerate().map(name).collect()).collect()
}
