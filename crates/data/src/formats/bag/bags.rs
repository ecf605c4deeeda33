//! Reads bags of ROS 2: chosen topics of each become one recording at equal steps of time.

use crate::check::rates;
use crate::formats::bag::path::is_bag;
use crate::formats::bag::topics;
use crate::formats::bag::tracks::{Track, tracks};
use crate::formats::clock::{Timing, places};
use crate::formats::stamps::Mended;
use crate::formats::timed::Timed;
use crate::layout::listing::FoundFiles;
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Recorded};
use crate::{Error, Result};
use ndarray::ArrayD;
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Reads bags of ROS 2, each one recording.
pub(crate) struct Bag;

impl FileFormat for Bag {
    fn name(&self) -> &'static str {
        "a bag"
    }

    fn format(&self) -> &'static Format {
        &Format {
            name: "ROS 2 bags",
            endings: &["mcap"],
            holds: "one recording in a file, or in the folder of `ros2 bag record`; in class folders, with `labels.csv`, \
                    or named by class: `cup_03.mcap`, `day1/cup_03.mcap`",
            becomes: "numbers [C, T], images [T, H, W] at equal steps, see [Bags](#bags)",
        }
    }

    fn takes(&self, path: &Path) -> bool {
        is_bag(path)
    }

    fn takes_option(&self, option: &str) -> bool {
        option == "resize"
    }

    fn read_together(
        &self,
        root: &Path,
        found: &FoundFiles,
        options: &ReadOptions,
    ) -> Option<Result<Recorded>> {
        Some(read(root, found, options))
    }
}

/// One recording: values of all topics at the times of the first.
struct BagRecording {
    name: String,
    /// Shape of a time step: its channels, or `[H, W]` or `[3, H, W]` of an image.
    shape: Vec<usize>,
    /// Number of channels of each topic.
    channels: Vec<usize>,
    /// Number of messages of the first topic before all others have begun or after one has ended.
    unmatched: usize,
    /// Names of all channels.
    names: Vec<String>,
    /// Bits of a pixel.
    depth: Option<u8>,
    /// Numbers that are no channels, and why.
    left_out: Vec<String>,
}

/// Reads the bags that were `found` below `root`.
fn read(root: &Path, found: &FoundFiles, options: &ReadOptions) -> Result<Recorded> {
    let file = root.display().to_string();
    let first = found.files.first().ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let topics = if options.topics.is_empty() { vec![topics::only(first)?] } else { options.topics.clone() };
    let mut all: Vec<BagRecording> = vec![];
    let mut mended = Mended::default();
    let mut order: Option<Vec<Vec<String>>> = None;
    let mut timed = Timed::default();
    let mut last: Option<(&PathBuf, Vec<Track>)> = None;
    for (row, bag) in found.files.iter().enumerate() {
        let is_read = last.as_ref().is_some_and(|(path, _)| *path == bag);
        let left = options.limits.max_values.saturating_sub(timed.values.len() as u64);
        if !is_read {
            // Frees its memory before the next is read.
            drop(last.take());
            let mut read = tracks(bag, &topics, options, left)?;
            let wanted = order.get_or_insert_with(|| read.iter().map(|track| track.names.clone()).collect());
            for (track, wanted) in read.iter_mut().zip(wanted) {
                track.arrange(wanted).map_err(|why| Error::file(bag, why))?;
                mended.add(track.mended);
            }
            last = Some((bag, read));
        }
        let span = found.spans.as_ref().map(|spans| spans[row]);
        let tracks = last.as_mut().map_or(&mut [][..], |(_, tracks)| tracks);
        let name = bag.strip_prefix(root).unwrap_or(bag).display().to_string();
        let recording = joined(&name, tracks, &topics, span, found.files.len(), left, &mut timed)
            .map_err(|why| Error::file(bag, why))?;
        refuse_shape(&file, &recording, timed.rows[row], all.first(), timed.rows[0])?;
        all.push(recording);
        options.limits.refuse_values(&file, timed.values.len())?;
    }
    drop(last);
    collected(&file, all, timed, topics, mended, options)
}

/// Refuses a recording that differs from the first in more than time.
fn refuse_shape(
    file: &str,
    recording: &BagRecording,
    steps: usize,
    first: Option<&BagRecording>,
    first_steps: usize,
) -> Result<()> {
    let Some(first) = first.filter(|first| first.shape != recording.shape) else { return Ok(()) };
    let is_image = recording.shape.len() > 1;
    let with_time = |shape: &[usize], time: usize| {
        if is_image { [&[time], shape].concat() } else { [shape, &[time]].concat() }
    };
    Err(Error::SampleShape {
        file: format!("{file}/{}", recording.name),
        shape: with_time(&recording.shape, steps),
        first: format!("{file}/{}", first.name),
        first_shape: with_time(&first.shape, first_steps),
        hint: if is_image {
            " but for time: set resize = [height, width], and use grey or colour throughout"
        } else {
            " but for time (channels, time)"
        },
    })
}

/// Brings all recordings to equal steps of the same length.
fn collected(
    file: &str,
    all: Vec<BagRecording>,
    timed: Timed,
    topics: Vec<String>,
    mended: Mended,
    options: &ReadOptions,
) -> Result<Recorded> {
    let mut read_as = vec![described(&topics, &all, &timed.rows, options)];
    read_as.extend(mended.said());
    let (names, depth) = all.first().map_or((vec![], None), |one| (one.names.clone(), one.depth));
    let ignored = all.first().map_or(vec![], |one| one.left_out.clone());
    if let Some(other) = all.iter().find(|one| one.depth != depth) {
        let why = "has images of other bits than the first bag; record one kind of pixels";
        return Err(Error::file(format!("{file}/{}", other.name), why));
    }
    let shape = all.first().map_or(&[][..], |one| &one.shape);
    if let &[_, height, width] = shape {
        let mut recorded = frames(file, all, timed, [height, width], options)?;
        (recorded.read_as, recorded.topics, recorded.depth) = (read_as, topics, depth);
        return Ok(recorded);
    }
    let timing = Timing::of(&timed.stamps(), options.stamped);
    read_as.extend(timing.map(|timing| timing.to_string()));
    let warnings = rates::doubts(file, &timed.stamps(), |row| all[row].name.clone());
    let (layout, shape) = match shape {
        [_, _] => (Layout::Sequence, shape),
        _ => (Layout::Series, &[][..]),
    };
    let x = timed.into_recordings(timing, shape, file, options)?;
    let origins = all.into_iter().map(|recording| recording.name).collect();
    let rate = timing.map(|timing| timing.rate());
    let dtype = DTYPE.into();
    Ok(Recorded {
        rate,
        read_as,
        warnings,
        topics,
        channel_names: names,
        depth,
        ignored,
        ..Recorded::of(x, dtype, Some(layout), origins)
    })
}

/// The type of values.
const DTYPE: &str = "mcap";

/// Makes a sample of each frame in colour: no layout has colours over time.
fn frames(
    file: &str,
    all: Vec<BagRecording>,
    timed: Timed,
    [height, width]: [usize; 2],
    options: &ReadOptions,
) -> Result<Recorded> {
    let counts = timed.rows;
    let is_single = counts.iter().all(|frames| *frames == 1);
    if let (Some(at), None) = (counts.iter().position(|frames| *frames > 1), options.layout) {
        return Err(Error::file(
            format!("{file}/{}", all[at].name),
            format!(
                "has {} images in colour, and no layout has colours over time; say layout = \"colour\" to make each a sample, \
                 or layout = \"sequence\" to read them over time in grey, in the config or in labels.json beside the bags",
                counts[at]
            ),
        ));
    }
    let samples: usize = counts.iter().sum();
    options.limits.refuse_samples(file, samples as u64)?;
    let no_samples = || Error::NoSamples { at: file.into() };
    let x =
        ArrayD::from_shape_vec(vec![samples, 3, height, width], timed.values).map_err(|_| no_samples())?;
    let named = |(one, frames): (BagRecording, &usize)| {
        (0..*frames)
            .map(move |frame| if is_single { one.name.clone() } else { format!("{}[{frame}]", one.name) })
    };
    let origins = all.into_iter().zip(&counts).flat_map(named).collect();
    let frames = if is_single { vec![] } else { counts };
    Ok(Recorded { frames, ..Recorded::of(x.into(), DTYPE.into(), Some(Layout::Colour), origins) })
}

/// Says for the card how bags were read; `rows` are those of each recording.
fn described(topics: &[String], all: &[BagRecording], rows: &[usize], options: &ReadOptions) -> String {
    let of = |(topic, channels): (&String, &usize)| match all.first().map(|first| first.shape.as_slice()) {
        Some([height, width]) => {
            let is_chosen = options.layout == Some(Layout::Sequence);
            let colours = if is_chosen { "any colours as grey" } else { "grey" };
            format!("{topic} ({colours} images of {height} × {width})")
        }
        Some([_, height, width]) => format!("{topic} (colour images of {height} × {width}, each a sample)"),
        _ => format!("{topic} ({})", crate::error::plural(*channels, "channel")),
    };
    let channels = all.first().map_or(&[][..], |first| &first.channels);
    let each: Vec<String> = topics.iter().zip(channels).map(of).collect();
    let joined = match topics {
        [_] | [] => String::new(),
        [first, ..] => {
            let unmatched: usize = all.iter().map(|recording| recording.unmatched).sum();
            let of = unmatched + rows.iter().sum::<usize>();
            format!(
                ", all at the times of {first}, to which the others are linearly interpolated, cut to the time that all \
                 topics share: {unmatched} of {of} messages of {first} lie outside it"
            )
        }
    };
    format!("bags: {}, messages by the time at which they were recorded{joined}", each.join(", "))
}

/// The times (s) of a recording after its first message.
struct CommonTimes {
    /// Of all messages of each topic.
    of: Vec<Vec<f64>>,
    /// Of the messages of the first topic that are kept.
    keep: Vec<f64>,
    /// Number of messages of the first topic before all others have begun or after one has ended.
    unmatched: usize,
}

/// Finds the time at which all topics have messages, within the `span`, or says why there is none.
fn common_times(tracks: &[Track], topics: &[String], span: Option<[f64; 2]>) -> Result<CommonTimes, String> {
    let [first, ..] = tracks else { return Err("has no topics".into()) };
    let of: Vec<Vec<f64>> = tracks.iter().map(|track| track.seconds(first.stamps[0])).collect();
    let mut keep = of[0].clone();
    if let Some([start, end]) = span {
        keep.retain(|time| (start..end).contains(time));
        if keep.is_empty() {
            return Err(format!(
                "has no messages from {start} to {end} s after its first, which labels.csv lists"
            ));
        }
    }
    let before = keep.len();
    for stamps in &of[1..] {
        let ends = [stamps[0], stamps[stamps.len() - 1]];
        keep.retain(|time| (ends[0]..=ends[1]).contains(time));
    }
    if keep.is_empty() {
        let within = span.map_or(String::new(), |[start, end]| format!(" from {start} to {end} s"));
        return Err(format!("has no time{within} at which all of {} have messages", topics.join(", ")));
    }
    Ok(CommonTimes { of, unmatched: before - keep.len(), keep })
}

/// Joins the topics of a bag to one recording, cut to the `span` in seconds from the first message. Its rows are added to
/// `timed`, which will hold the `expected` recordings and at most `most` values; the values of a single one are not copied.
fn joined(
    name: &str,
    tracks: &mut [Track],
    topics: &[String],
    span: Option<[f64; 2]>,
    expected: usize,
    most: u64,
    timed: &mut Timed,
) -> Result<BagRecording, String> {
    if tracks.len() > 1 && tracks.iter().any(|track| track.shape.len() != 1) {
        return Err("has images on one of the topics; images are read alone, from one topic".into());
    }
    let CommonTimes { of, keep, unmatched } = common_times(tracks, topics, span)?;
    let channels: Vec<usize> = tracks.iter().map(|track| track.shape.iter().product()).collect();
    let width: usize = channels.iter().sum();
    let name = match span {
        None => name.into(),
        Some([start, end]) => format!("{name}[{start}..{end} s]"),
    };
    let shape = match &tracks {
        [one] => one.shape.clone(),
        _ => vec![width],
    };
    if timed.rows.is_empty() {
        timed.width = width;
        if expected > 1 {
            let values = keep.len().saturating_mul(width).saturating_mul(expected).min(most as usize);
            // Growing step by step would take twice the memory in the end.
            let _ = timed.values.try_reserve_exact(values);
        }
    }
    if let [one] = tracks {
        let start = of[0].partition_point(|time| *time < keep[0]);
        let range = start * width..(start + keep.len()) * width;
        if expected == 1 && range.len() == one.values.len() {
            timed.values = std::mem::take(&mut one.values);
        } else {
            timed.values.extend_from_slice(&one.values[range]);
        }
    } else {
        let from = timed.values.len();
        timed.values.resize(from + keep.len() * width, 0.0);
        interpolate(tracks, &of, &keep, &mut timed.values[from..]);
    }
    timed.rows.push(keep.len());
    timed.stamps.extend(keep);
    let depth = tracks.iter().find_map(|track| track.depth);
    let named = |track: &Track| -> Vec<String> {
        let below =
            |name: &String| format!("{}{}{name}", track.topic, if name.starts_with('[') { "" } else { "." });
        if topics.len() == 1 { track.names.clone() } else { track.names.iter().map(below).collect() }
    };
    let names = tracks.iter().flat_map(named).collect();
    let left_out = tracks.iter().flat_map(|track| track.left_out.clone()).collect();
    Ok(BagRecording { name, shape, channels, unmatched, names, depth, left_out })
}

/// Interpolates `tracks`, whose messages lie `at` their times, at common `times`: `out` is `[times, width]`.
fn interpolate(tracks: &[Track], at: &[Vec<f64>], times: &[f64], out: &mut [f32]) {
    let width = out.len() / times.len();
    let mut start = 0;
    for (track, stamps) in tracks.iter().zip(at) {
        let channels = track.shape[0];
        for (row, place) in out.chunks_exact_mut(width).zip(places(stamps, times.iter().copied())) {
            for channel in 0..channels {
                row[start + channel] = place.value(|row| track.values[row * channels + channel]);
            }
        }
        start += channels;
    }
}
