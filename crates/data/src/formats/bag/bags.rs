//! Recordings of robots: each a bag of ROS 2, of which topics are chosen, brought to equal steps of time.

use crate::formats::bag::path::is_bag;
use crate::formats::bag::topics;
use crate::formats::bag::tracks::{Track, tracks};
use crate::formats::clock::{Timing, places};
use crate::formats::timed::Timed;
use crate::layout::listing::Found;
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Recorded, Sample};
use crate::{Error, Result};
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

    fn layout(&self, _: usize) -> Option<Layout> {
        None
    }

    fn takes_option(&self, option: &str) -> bool {
        option == "resize"
    }

    /// Of several together, which have one clock.
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Sample> {
        Err(Error::OneBag { file: path.display().to_string() })
    }

    fn read_together(&self, root: &Path, found: &Found, options: &ReadOptions) -> Option<Result<Recorded>> {
        Some(read(root, found, options))
    }
}

/// One recording: readings of all topics at the times of the first.
struct Recording {
    name: String,
    /// Of one reading: its channels, or height and width.
    shape: Vec<usize>,
    /// Numbers of each topic.
    channels: Vec<usize>,
    /// Messages of the first topic before all others have begun or after one has ended.
    alone: usize,
}

/// Reads the bags that were `found` below `root`.
fn read(root: &Path, found: &Found, options: &ReadOptions) -> Result<Recorded> {
    let file = root.display().to_string();
    let first = found.files.first().ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let topics = match options.topics.is_empty() {
        true => vec![topics::only(first)?],
        false => options.topics.clone(),
    };
    let mut all: Vec<Recording> = vec![];
    let mut timed = Timed::default();
    let mut last: Option<(&PathBuf, Vec<Track>)> = None;
    for (row, bag) in found.files.iter().enumerate() {
        let is_read = last.as_ref().is_some_and(|(path, _)| *path == bag);
        let left = options.limits.max_values.saturating_sub(timed.values.len() as u64);
        if !is_read {
            // Before the next is read.
            drop(last.take());
            last = Some((bag, tracks(bag, &topics, options, left)?));
        }
        let span = found.spans.as_ref().map(|spans| spans[row]);
        let own = last.as_mut().map_or(&mut [][..], |(_, tracks)| tracks);
        let name = bag.strip_prefix(root).unwrap_or(bag).display().to_string();
        let recording = joined(&name, own, &topics, span, found.files.len(), left, &mut timed)
            .map_err(|why| Error::Bag { file: bag.display().to_string(), why })?;
        refuse_shape(&file, &recording, timed.rows[row], all.first(), timed.rows[0])?;
        all.push(recording);
        if timed.values.len() as u64 > options.limits.max_values {
            return Err(too_large(&file, timed.values.len(), options));
        }
    }
    drop(last);
    collected(&file, all, timed, topics, options)
}

/// Refuses a recording that differs from the first in more than time.
fn refuse_shape(
    file: &str,
    own: &Recording,
    readings: usize,
    first: Option<&Recording>,
    first_readings: usize,
) -> Result<()> {
    let Some(first) = first.filter(|first| first.shape != own.shape) else { return Ok(()) };
    let is_image = own.shape.len() == 2;
    let of = |shape: &[usize], time: usize| match is_image {
        true => [&[time], shape].concat(),
        false => [shape, &[time]].concat(),
    };
    let hint = match is_image {
        true => " but for time: set resize = [height, width]",
        false => " but for time (channels, time)",
    };
    Err(Error::SampleShape {
        file: format!("{file}/{}", own.name),
        shape: of(&own.shape, readings),
        first: format!("{file}/{}", first.name),
        first_shape: of(&first.shape, first_readings),
        hint,
    })
}

fn too_large(file: &str, values: usize, options: &ReadOptions) -> Error {
    Error::TooLarge {
        at: file.into(),
        shape: vec![values as u64],
        limit: options.limits.max_values,
        hint: "take fewer recordings or raise limits.max_values",
    }
}

/// All recordings at equal steps of the same length.
fn collected(
    file: &str,
    all: Vec<Recording>,
    timed: Timed,
    topics: Vec<String>,
    options: &ReadOptions,
) -> Result<Recorded> {
    let timing = Timing::of(&timed.stamps(), options.stamped);
    let mut read_as = vec![described(&topics, &all, &timed.rows)];
    read_as.extend(timing.map(|timing| timing.to_string()));
    let shape = all.first().map_or(&[][..], |one| &one.shape);
    let (layout, shape) = match shape {
        [_, _] => (Layout::Sequence, shape),
        _ => (Layout::Series, &[][..]),
    };
    let refuse = |why| Error::Bag { file: file.into(), why };
    let x = timed.into_recordings(timing, shape, file, options, refuse)?;
    let row_hash = x.hashes();
    let origins = all.into_iter().map(|own| own.name).collect();
    let (dtype, rate) = ("mcap".into(), timing.map(|timing| timing.rate()));
    Ok(Recorded { x, dtype, layout: Some(layout), row_hash, origins, rate, read_as, topics })
}

/// How bags were taken, for the card; `rows` are those of each recording.
fn described(topics: &[String], all: &[Recording], rows: &[usize]) -> String {
    let of = |(topic, channels): (&String, &usize)| match all.first().map(|own| own.shape.as_slice()) {
        Some([height, width]) => format!("{topic} (grey images of {height} × {width})"),
        _ => format!("{topic} ({})", crate::error::plural(*channels, "channel")),
    };
    let channels = all.first().map_or(&[][..], |own| &own.channels);
    let own: Vec<String> = topics.iter().zip(channels).map(of).collect();
    let joined = match topics {
        [_] | [] => String::new(),
        [first, ..] => {
            let alone: usize = all.iter().map(|own| own.alone).sum();
            let of = alone + rows.iter().sum::<usize>();
            format!(
                ", all at the times of {first}, to which the others are linearly interpolated, cut to the time that all \
                 topics share: {alone} of {of} messages of {first} lie outside it"
            )
        }
    };
    format!("bags: {}, messages by the time at which they were recorded{joined}", own.join(", "))
}

/// The times (s) of a recording after the first message.
struct Shared {
    /// Of all messages of each topic.
    of: Vec<Vec<f64>>,
    /// Those of the first topic that are kept.
    keep: Vec<f64>,
    /// How many others of it there are, before all topics have begun or after one has ended.
    alone: usize,
}

/// From where to where all topics have messages, within the `span`; why there is none otherwise.
fn shared(tracks: &[Track], topics: &[String], span: Option<[f64; 2]>) -> Result<Shared, String> {
    let [first, ..] = tracks else { return Err("has no topics".into()) };
    let of: Vec<Vec<f64>> = tracks.iter().map(|own| own.seconds(first.stamps[0])).collect();
    let mut keep = of[0].clone();
    if let Some([start, end]) = span {
        keep.retain(|time| (start..end).contains(time));
        if keep.is_empty() {
            return Err(format!(
                "has no messages from {start} to {end} s after its first, which labels.csv lists"
            ));
        }
    }
    let mut alone = keep.len();
    for stamps in &of[1..] {
        let ends = [stamps[0], stamps[stamps.len() - 1]];
        keep.retain(|time| (ends[0]..=ends[1]).contains(time));
    }
    alone -= keep.len();
    if keep.is_empty() {
        let within = span.map_or(String::new(), |[start, end]| format!(" from {start} to {end} s"));
        return Err(format!("has no time{within} at which all of {} have messages", topics.join(", ")));
    }
    Ok(Shared { of, keep, alone })
}

/// The topics of a bag as one recording, cut to the `span` in seconds from the first message. Its readings are added to
/// `timed`, which will hold so many recordings as are `expected`, `most` values at most; those of the only one are not copied.
fn joined(
    name: &str,
    tracks: &mut [Track],
    topics: &[String],
    span: Option<[f64; 2]>,
    expected: usize,
    most: u64,
    timed: &mut Timed,
) -> Result<Recording, String> {
    if tracks.len() > 1 && tracks.iter().any(|own| own.shape.len() != 1) {
        return Err("has images on one of the topics; images are read alone, from one topic".into());
    }
    let Shared { of, keep, alone } = shared(tracks, topics, span)?;
    let channels: Vec<usize> = tracks.iter().map(|own| own.shape.iter().product()).collect();
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
            // Without the room it grows step by step, which takes twice the memory in the end.
            let _ = timed.values.try_reserve_exact(values);
        }
    }
    if let [one] = tracks {
        let start = of[0].partition_point(|time| *time < keep[0]);
        let range = start * width..(start + keep.len()) * width;
        match expected == 1 && range.len() == one.values.len() {
            true => timed.values = std::mem::take(&mut one.values),
            false => timed.values.extend_from_slice(&one.values[range]),
        }
    } else {
        let from = timed.values.len();
        timed.values.resize(from + keep.len() * width, 0.0);
        interpolate(tracks, &of, &keep, &mut timed.values[from..]);
    }
    timed.rows.push(keep.len());
    timed.stamps.extend(keep);
    Ok(Recording { name, shape, channels, alone })
}

/// Lays `tracks` with messages `at` their times side by side as they are at `times`: `out` is `[times, width]`.
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
