//! Recordings of robots: each a bag of ROS 2, of which topics are chosen, brought to equal steps of time.

use crate::bag_topics;
use crate::bag_tracks::{Track, tracks};
use crate::clock::{Timing, places};
use crate::hash::RowHash;
use crate::listing::Found;
use crate::options::Options;
use crate::ragged::{Collected, Ragged};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_encodings::Layout;

/// What was recorded.
pub(crate) struct Recorded {
    pub x: Ragged,
    pub layout: Layout,
    pub row_hash: Vec<RowHash>,
    pub origins: Vec<String>,
    /// How bags were taken.
    pub read_as: Vec<String>,
    pub rate: Option<f64>,
    pub topics: Vec<String>,
}

/// One recording: readings of all topics at the times of the first.
struct Recording {
    name: String,
    /// In seconds.
    stamps: Vec<f64>,
    /// `[time, ...]`.
    values: Vec<f32>,
    /// Of one reading: its channels, or height and width.
    shape: Vec<usize>,
    /// Numbers of each topic.
    channels: Vec<usize>,
}

/// Reads the bags that were `found` below `root`.
pub(crate) fn read(root: &Path, found: &Found, options: &Options) -> Result<Recorded> {
    let file = root.display().to_string();
    let first = found.files.first().ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let topics = match options.topics.is_empty() {
        true => vec![bag_topics::only(first)?],
        false => options.topics.clone(),
    };
    let mut all: Vec<Recording> = vec![];
    let mut last: Option<(&PathBuf, Vec<Track>)> = None;
    let mut left = options.limits.max_values;
    for (row, bag) in found.files.iter().enumerate() {
        let is_read = last.as_ref().is_some_and(|(path, _)| *path == bag);
        if !is_read {
            // Before the next is read.
            drop(last.take());
            last = Some((bag, tracks(bag, &topics, options, left)?));
        }
        let span = found.spans.as_ref().map(|spans| spans[row]);
        let own = last.as_mut().map_or(&mut [][..], |(_, tracks)| tracks);
        // Bags that are not read twice are not held twice.
        let is_last = found.files.get(row + 1) != Some(bag);
        let recording = joined(root, bag, &topics, own, span, is_last)?;
        left = left.saturating_sub(recording.values.len() as u64);
        all.push(recording);
    }
    drop(last);
    collected(&file, all, topics, options)
}

/// All recordings at equal steps of the same length.
fn collected(file: &str, all: Vec<Recording>, topics: Vec<String>, options: &Options) -> Result<Recorded> {
    let stamps: Vec<&[f64]> = all.iter().map(|own| own.stamps.as_slice()).collect();
    let timing = Timing::of(&stamps);
    let uneven = timing.filter(|timing| !timing.is_regular);
    if let Some(why) = uneven.and_then(|timing| timing.gaps(&stamps)) {
        return Err(Error::Bag { file: file.into(), why });
    }
    let mut read_as = vec![described(&topics, &all)];
    read_as.extend(timing.map(|timing| timing.to_string()));
    let layout = match all.first().map(|own| own.shape.len()) {
        Some(2) => Layout::Sequence,
        _ => Layout::Series,
    };
    let mut collected = Collected::new(file, options.limits).of_about(all.len());
    let mut origins = vec![];
    for Recording { name, stamps, values, shape, .. } in all {
        let size: usize = shape.iter().product();
        let values = match (layout, uneven) {
            (Layout::Sequence, Some(timing)) => timing.resampled_rows(&stamps, &values, size),
            (Layout::Sequence, None) => values,
            (_, Some(timing)) => timing.resampled(&stamps, &values, size),
            (_, None) => (0..size).flat_map(|own| values.iter().skip(own).step_by(size)).copied().collect(),
        };
        let readings = values.len() / size;
        let at = format!("{file}/{name}");
        match layout {
            Layout::Sequence => {
                let hint = " but for time: set resize = [height, width]";
                collected.push(&at, &[&[readings], &shape[..]].concat(), &values, Some(0), hint)?;
            }
            _ => {
                collected.push(&at, &[size, readings], &values, Some(1), " but for time (channels, time)")?
            }
        }
        origins.push(name);
    }
    let x = collected.finish().ok_or_else(|| Error::NoSamples { at: file.into() })?;
    let row_hash = x.hashes();
    Ok(Recorded { x, layout, row_hash, origins, read_as, rate: timing.map(|timing| timing.rate()), topics })
}

/// How bags were taken, for the card.
fn described(topics: &[String], all: &[Recording]) -> String {
    let of = |(topic, channels): (&String, &usize)| match all.first().map(|own| own.shape.as_slice()) {
        Some([height, width]) => format!("{topic} (grey images of {height} × {width})"),
        _ => format!("{topic} ({})", crate::error::plural(*channels, "channel")),
    };
    let channels = all.first().map_or(&[][..], |own| &own.channels);
    let own: Vec<String> = topics.iter().zip(channels).map(of).collect();
    let joined = match topics {
        [_] | [] => String::new(),
        [first, ..] => {
            format!(", all at the times of {first}, to which the others are linearly interpolated")
        }
    };
    format!("bags: {}, messages by the time at which they were recorded{joined}", own.join(", "))
}

/// The topics of a bag as one recording, cut to the `span` in seconds from the first message; what is read for the
/// last time is not copied.
fn joined(
    root: &Path,
    bag: &Path,
    topics: &[String],
    tracks: &mut [Track],
    span: Option<[f64; 2]>,
    is_last: bool,
) -> Result<Recording> {
    let file = bag.display().to_string();
    let refuse = |why: String| Err(Error::Bag { file: file.clone(), why });
    let name = bag.strip_prefix(root).unwrap_or(bag).display().to_string();
    let [first, others @ ..] = tracks else { return refuse("has no topics".into()) };
    if !others.is_empty() && [&*first].into_iter().chain(&*others).any(|own| own.shape.len() != 1) {
        return refuse("has images on one of the topics; images are read alone, from one topic".into());
    }
    let channels: Vec<usize> =
        [&*first].into_iter().chain(&*others).map(|own| own.shape.iter().product()).collect();
    let seconds = |own: &Track| own.seconds(first.stamps[0]);
    let own = seconds(first);
    // From where to where all topics have messages.
    let mut keep = own.clone();
    let mut spans = vec![];
    for other in &*others {
        let stamps = seconds(other);
        let ends = [stamps[0], stamps[stamps.len() - 1]];
        keep.retain(|time| (ends[0]..=ends[1]).contains(time));
        spans.push(stamps);
    }
    if keep.is_empty() {
        return refuse(format!("has no time at which all of {} have messages", topics.join(", ")));
    }
    if let Some([start, end]) = span {
        keep.retain(|time| (start..end).contains(time));
        if keep.is_empty() {
            return refuse(format!(
                "has no messages from {start} to {end} s after its first, which labels.csv lists"
            ));
        }
    }
    let shape = match others {
        [] => first.shape.clone(),
        _ => vec![channels.iter().sum()],
    };
    let name = match span {
        None => name,
        Some([start, end]) => format!("{name}[{start}..{end} s]"),
    };
    if others.is_empty() {
        let size: usize = shape.iter().product();
        let from = own.partition_point(|time| *time < keep[0]);
        let range = from * size..(from + keep.len()) * size;
        let values = match (range.len() == first.values.len(), is_last) {
            (true, true) => std::mem::take(&mut first.values),
            _ => first.values[range].to_vec(),
        };
        return Ok(Recording { name, stamps: keep, values, shape, channels });
    }
    let mut values = vec![0.0; keep.len() * shape[0]];
    let stamps: Vec<&Vec<f64>> = [&own].into_iter().chain(&spans).collect();
    let mut start = 0;
    for ((track, stamps), channels) in [&*first].into_iter().chain(&*others).zip(stamps).zip(&channels) {
        for (i, place) in places(stamps, keep.iter().copied()).enumerate() {
            for channel in 0..*channels {
                values[i * shape[0] + start + channel] =
                    place.value(|row| track.values[row * channels + channel]);
            }
        }
        start += channels;
    }
    Ok(Recording { name, stamps: keep, values, shape, channels })
}
