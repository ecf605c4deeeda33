//! Recordings to predict: labels, if there are any, only say whether a prediction is right.

use crate::dataset::one_hot::settle;
use crate::dataset::raw::{DATA, Raw};
use crate::dataset::spec_of::likeliest_layout;
use crate::dataset::targets::Values;
use crate::dataset::validate::channels;
use crate::formats::bag::path::is_bag;
use crate::formats::names::is_image;
use crate::layout::listing::{Listing, list};
use crate::length::cut::cut;
use crate::length::length::Length;
use crate::length::lengths::Lengths;
use crate::length::one_length::refuse_channels;
use crate::length::ragged::Ragged;
use crate::load::open;
use crate::options::ReadOptions;
use crate::reader::Purpose;
use crate::{Error, Result};
use ndarray::ArrayD;
use std::path::Path;
use taxel_base::Layout;

/// Facts about recordings that their files say, before a model or an option says more.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordingFacts {
    /// Type of the stored values, such as `<f4`, `csv` or `png/jpeg u8`.
    pub dtype: String,
    /// Bits of a pixel as images are stored, 8 or 16.
    pub depth: Option<u8>,
    /// Unit of the values.
    pub unit: Option<String>,
    /// Time steps per second (Hz).
    pub rate: Option<f64>,
    /// The highest value that the sensor gives.
    pub full_scale: Option<f32>,
    /// Axes of a sample, where the files say them.
    pub layout: Option<Layout>,
    /// Names of all channels in the order of the files; empty where they name none.
    pub channel_names: Vec<String>,
    /// Doubts that arose when the files were read, such as pauses in a recording, and how to fix each.
    pub warnings: Vec<String>,
}

impl RecordingFacts {
    fn of(raw: &Raw) -> Self {
        let facts = &raw.facts;
        Self {
            dtype: raw.dtype.clone(),
            depth: facts.depth,
            unit: facts.unit.clone(),
            rate: facts.rate,
            full_scale: facts.full_scale,
            layout: facts.layout,
            channel_names: raw.channel_names.clone(),
            warnings: raw.warnings.clone(),
        }
    }
}

/// Recordings of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Recordings {
    /// The file or folder name without extension.
    pub name: String,
    /// Samples `[N, ...]` in C order, as stored, or as [`ReadOptions::length`] makes them.
    pub x: ArrayD<f32>,
    /// Where each sample comes from: its file, or `x[17]`.
    pub origins: Vec<String>,
    /// Where samples are windows, the first time step of each, from 0; `origins` name their recordings.
    pub starts: Option<Vec<usize>>,
    /// Names of each sample's classes `[N][attributes]`; none without labels.
    pub truth: Option<Vec<Vec<String>>>,
    /// True values of each sample `[N, quantities]`, NaN where there is none; none for labels.
    pub values: Option<Values>,
    /// The facts that their files say.
    pub facts: RecordingFacts,
}

/// Reads recordings for a model that takes samples of `rank` axes: every layout of [`load`](crate::load), with
/// or without labels, a folder of files without class folders, and a single CSV, NPY, MAT, PNG or JPEG file.
///
/// A CSV file is a table for a model of features, and where one of its columns names recordings; otherwise one recording.
///
/// A single `.npy` with `rank` axes is one sample, one with an axis more a batch. With the `layout` and the `length`
/// of the model's [`SampleSpec`](crate::SampleSpec) in `options`, recordings may have any length.
///
/// # Errors
///
/// As [`load`](crate::load), but for labels: classes may be missing, or unknown to a model.
/// Also a recording that is shorter than a window.
pub fn recordings(path: &Path, options: &ReadOptions, rank: usize) -> Result<Recordings> {
    let Read { raw, x, time, truth, values } = read(path, options, rank)?;
    let steps = raw.steps.as_ref();
    let facts = RecordingFacts::of(&raw);
    let (x, windows) = match time.zip(options.length) {
        None => {
            if let Some(axis) = time.filter(|_| x.is_unequal()) {
                return Err(Lengths::of(&x.lengths(axis), None).refused(&raw.file));
            }
            (x.into_array().ok_or_else(|| Error::NoSamples { at: raw.file.clone() })?, None)
        }
        Some((axis, rule)) => {
            let lengths = x.lengths(axis);
            let short = lengths.iter().position(|length| *length < rule.to());
            if let (Length::Window { to, .. }, Some(short)) = (rule, short) {
                let why = "it holds no window, so there is no answer to it; leave it out";
                let (sample, length) = (raw.sample_name(short), lengths[short]);
                return Err(Error::RecordingLength { sample, length, to, why });
            }
            let cut = cut(&rule, &x, axis, &options.limits, &raw.file, |row| raw.sample_name(row))?;
            (cut.x, cut.windows)
        }
    };
    let Some(windows) = windows else {
        // Of labels that change none is that of the recording.
        let truth = truth.filter(|_| steps.is_none());
        let values = values.filter(|_| steps.is_none());
        return Ok(Recordings {
            name: raw.name,
            x,
            origins: raw.origins,
            starts: None,
            truth,
            values,
            facts,
        });
    };
    let of = |(row, _): &(usize, usize)| raw.origins[*row].clone();
    let to = options.length.map_or(0, |rule| rule.to());
    let rows: Vec<usize> = match steps {
        Some(steps) => steps.at_ends(&windows, to),
        None => windows.iter().map(|(row, _)| *row).collect(),
    };
    Ok(Recordings {
        origins: windows.iter().map(of).collect(),
        truth: truth.map(|truth| rows.iter().map(|row| truth[*row].clone()).collect()),
        values: values.map(|values| Values::new(values.quantities().to_vec(), values.of(&rows))),
        starts: Some(windows.into_iter().map(|(_, start)| start).collect()),
        name: raw.name,
        x,
        facts,
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

/// Reads recordings as [`recordings`] does, and leaves each as long as it is: [`ReadOptions::length`] is ignored. Also returns
/// what their files say.
///
/// # Errors
///
/// As [`recordings`].
pub fn whole_recordings(
    path: &Path,
    options: &ReadOptions,
    rank: usize,
) -> Result<(Vec<Recording>, RecordingFacts)> {
    let Read { raw, x, .. } = read(path, options, rank)?;
    let one = |(at, values): (usize, &[f32])| {
        let origin = raw.origins[at].clone();
        Recording { origin, shape: x.shape_of(at), values: values.to_vec() }
    };
    Ok((x.each().enumerate().map(one).collect(), RecordingFacts::of(&raw)))
}

/// Checks whether the recordings at `path`, a file or a folder of files, classes or sessions, are images.
pub fn are_images(path: &Path) -> bool {
    hold(path, is_image, 3)
}

/// Checks whether the recordings at `path` are bags of ROS 2.
pub fn are_bags(path: &Path) -> bool {
    hold(path, is_bag, 3)
}

fn hold(path: &Path, is_it: fn(&Path) -> bool, levels: usize) -> bool {
    if !path.is_dir() || is_bag(path) || is_image(path) {
        return is_it(path);
    }
    let below = |top: Listing| {
        let all = top.files.into_iter().chain(top.folders);
        all.into_iter().any(|path| hold(&path, is_it, levels - 1))
    };
    levels > 0 && !path.join(DATA).is_file() && list(path).is_ok_and(below)
}

/// The content of a path, its recordings as long as they are.
struct Read {
    raw: Raw,
    x: Ragged,
    /// Their time axis.
    time: Option<usize>,
    /// Names of each recording's classes, where there are labels.
    truth: Option<Vec<Vec<String>>>,
    /// Their values, where there are some; an event has classes in their place.
    values: Option<Values>,
}

fn read(path: &Path, options: &ReadOptions, rank: usize) -> Result<Read> {
    let mut raw = open(path, Purpose::Predict { rank }, options)?;
    settle(&mut raw, options);
    let chosen = channels(&raw, options)?;
    let truth = Some(truth(&raw, options)).filter(|rows| rows.len() == raw.target_rows());
    let values = raw.values.take().filter(|values| values.rows() == raw.target_rows());
    let values = values.filter(|_| options.event.is_none());
    let x = std::mem::take(&mut raw.x);
    let time = likeliest_layout([options.layout, raw.facts.layout, raw.format], &raw.dtype, x.sample_shape())
        .time_axis();
    let mut x = x.without_padding(time);
    refuse_channels(&raw, &x, time, chosen.as_deref())?;
    if let Some(channels) = &chosen {
        let all: Vec<usize> = (0..x.len()).collect();
        x = x.select(&all, Some(channels));
    }
    Ok(Read { raw, x, time, truth, values })
}

/// Returns the names of the classes of each sample; a label without a name goes by its number. An event without a value has
/// none.
fn truth(raw: &Raw, options: &ReadOptions) -> Vec<Vec<String>> {
    if let (Some(event), Some(values)) = (&options.event, &raw.values) {
        let classes = event.classes();
        let class =
            |value: &f32| (!value.is_nan()).then(|| classes[usize::from(event.is_in(*value))].clone());
        return values.values().iter().map(|value| class(value).into_iter().collect()).collect();
    }
    let name = |(column, label): (usize, &i64)| {
        let names = raw.names.as_ref().and_then(|names| names.columns.get(column));
        let named = usize::try_from(*label).ok().and_then(|label| names?.get(label));
        named.cloned().unwrap_or_else(|| label.to_string())
    };
    raw.y.chunks_exact(raw.columns).map(|row| row.iter().enumerate().map(name).collect()).collect()
}
