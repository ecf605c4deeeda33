//! Reads the messages of chosen topics of a bag.

use crate::dataset::channel_names::places;
use crate::dataset::precision::Precision;
use crate::formats::bag::file::{self, Topic};
use crate::formats::bag::message::Decoder;
use crate::formats::bag::path::parts;
use crate::formats::bag::topics::{Count, counted, described};
use crate::formats::stamps::{Mended, TOO_MANY};
use crate::formats::table::column_kind::{ColumnCells, ColumnKind};
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::path::Path;

/// Messages of one topic, in the order of time.
#[derive(Debug, Default)]
pub(crate) struct Track {
    /// Time at which each was recorded, in nanoseconds.
    pub stamps: Vec<u64>,
    /// `[time, ...]`.
    pub values: Vec<f32>,
    /// Shape of one message: `[channels]`, or `[H, W]` or `[3, H, W]` of an image.
    pub shape: Vec<usize>,
    /// Name of the topic.
    pub topic: String,
    /// Names of the channels; none of images.
    pub names: Vec<String>,
    /// Bits of a pixel.
    pub depth: Option<u8>,
    /// Its stamps that were mended.
    pub mended: Mended,
    /// Numbers that are no channels, and why.
    pub left_out: Vec<String>,
}

impl Track {
    /// Returns the times in seconds after `zero`, which is in nanoseconds.
    pub fn seconds(&self, zero: u64) -> Vec<f64> {
        self.stamps.iter().map(|stamp| (i128::from(*stamp) - i128::from(zero)) as f64 * 1e-9).collect()
    }

    /// Reserves memory for `messages` like the first, up to `most` values.
    fn reserve(&mut self, messages: u64, most: u64) {
        let values = messages.saturating_mul(self.values.len() as u64).min(most) as usize;
        // Where this fails, memory grows step by step.
        let _ = self.values.try_reserve_exact(values.saturating_sub(self.values.len()));
        let _ = self.stamps.try_reserve_exact(messages as usize);
    }

    /// Sorts messages by time.
    fn sorted(mut self) -> Self {
        if self.stamps.is_sorted() {
            return self;
        }
        let mut order: Vec<usize> = (0..self.stamps.len()).collect();
        order.sort_by_key(|at| self.stamps[*at]);
        let size = self.values.len() / self.stamps.len();
        self.values = order.iter().flat_map(|at| &self.values[at * size..(at + 1) * size]).copied().collect();
        self.stamps.sort_unstable();
        self
    }

    /// Drops all but the first of messages of one time, or says that there are too many.
    fn without_repeats(mut self) -> Result<Self, String> {
        let steps = self.stamps.len();
        let size = self.values.len() / steps;
        let mut kept = 0;
        for at in 0..steps {
            if at > 0 && self.stamps[at] == self.stamps[kept - 1] {
                continue;
            }
            if kept < at {
                self.stamps[kept] = self.stamps[at];
                self.values.copy_within(at * size..(at + 1) * size, kept * size);
            }
            kept += 1;
        }
        self.stamps.truncate(kept);
        self.values.truncate(kept * size);
        self.mended = Mended { steps, repeated: steps - kept, wraps: 0 };
        self.mended.checked()?;
        Ok(self)
    }

    /// Leaves out time and indices, as columns of a table are; not what a model reads. Numbers of images have no names.
    fn without_counters(mut self, model: &[String]) -> Self {
        let width = self.names.len();
        if width == 0 {
            return self;
        }
        let is_kept = |at: usize| -> Result<(), &'static str> {
            let name = &self.names[at];
            let is_of_model = |wanted: &String| {
                wanted
                    .strip_suffix(name.as_str())
                    .is_some_and(|topic| topic.is_empty() || topic.ends_with('.'))
            };
            // Of a list no number has a name of its own.
            if is_of_list(name) || model.iter().any(is_of_model) {
                return Ok(());
            }
            let mut cells = ColumnCells::new(name.rsplit('.').next());
            for (row, values) in self.values.chunks_exact(width).enumerate() {
                cells.add(row as u64, "", Some(values[at].into()));
                if !cells.is_open() {
                    break;
                }
            }
            match cells.kind() {
                ColumnKind::Time(_) => Err("time"),
                ColumnKind::LeftOut(why) => Err(why),
                _ => Ok(()),
            }
        };
        let kept: Vec<Result<(), &'static str>> = (0..width).map(is_kept).collect();
        let channels: Vec<usize> = (0..width).filter(|at| kept[*at].is_ok()).collect();
        if channels.len() == width {
            return self;
        }
        let left = |(name, kept): (&String, &Result<(), &'static str>)| {
            kept.err().map(|why| format!("{} of topic {} ({why})", name, self.topic))
        };
        self.left_out = self.names.iter().zip(&kept).filter_map(left).collect();
        let message = |values: &[f32]| channels.iter().map(|at| values[*at]).collect::<Vec<f32>>();
        self.values = self.values.chunks_exact(width).flat_map(message).collect();
        self.names = channels.iter().map(|at| self.names[*at].clone()).collect();
        self.shape = vec![channels.len()];
        self
    }

    /// Brings the channels into the order of those of another bag, where there are as many.
    pub fn arrange(&mut self, wanted: &[String]) -> Result<(), String> {
        if wanted.len() != self.names.len() {
            return Ok(());
        }
        let Some(places) = places(wanted, &self.names)? else { return Ok(()) };
        let message = |values: &[f32]| places.iter().map(|at| values[*at]).collect::<Vec<f32>>();
        self.values = self.values.chunks_exact(self.names.len()).flat_map(message).collect();
        self.names = wanted.to_vec();
        Ok(())
    }
}

/// Returns the fields below a topic that `chosen` names: an empty list for the topic itself, `["effort"]` for
/// `/joint_states.effort`; none for another topic.
fn fields<'c>(chosen: &'c str, topic: &str) -> Option<Vec<&'c str>> {
    match chosen.strip_prefix(topic)? {
        "" => Some(vec![]),
        below => Some(below.strip_prefix('.')?.split('.').collect()),
    }
}

/// A chosen topic while it is read.
#[derive(Default)]
struct ChosenTopic {
    track: Track,
    /// Place of the topic, and the decoder of its messages.
    decoder: Option<(usize, Decoder)>,
    precision: Precision,
}

/// Reads the messages of the `chosen` topics of a bag, each of one shape; no more than `most` values.
pub(crate) fn tracks(bag: &Path, chosen: &[String], options: &ReadOptions, most: u64) -> Result<Vec<Track>> {
    let file = bag.display().to_string();
    let refuse = |why: String| Error::file(bag, why);
    let mut all: Vec<ChosenTopic> = chosen.iter().map(|_| ChosenTopic::default()).collect();
    let (mut topics, mut counts) = (vec![], vec![]);
    let mut values = 0;
    // Read twice: growing step by step would take twice the memory in the end.
    let (_, expected) = counted(bag)?;
    for part in parts(bag)? {
        file::each(&part, &mut topics, |topics, message| {
            Count::add(&mut counts, message.topic, message.time);
            for (topic, name) in all.iter_mut().zip(chosen) {
                let before = topic.track.values.len();
                topic
                    .add(&topics[message.topic], name, &message, options)
                    .map_err(|why| refuse(format!("topic {why}")))?;
                if before == 0 {
                    let messages = expected.get(message.topic).map_or(0, |count| count.messages);
                    topic.track.reserve(messages, most);
                }
                values += topic.track.values.len() - before;
                if values as u64 > most {
                    let hint = "take fewer recordings or raise limits.max_values";
                    return Err(options.limits.too_large(&file, &[values], hint));
                }
            }
            Ok(())
        })?;
    }
    let mut out = vec![];
    for (ChosenTopic { track, decoder, precision }, chosen) in all.into_iter().zip(chosen) {
        let Some((_, decoder)) = decoder else {
            let held = described(&topics, &counts);
            return Err(refuse(format!("has no messages of topic {chosen}; it has {held}")));
        };
        if track.values.is_empty() {
            return Err(refuse(format!("topic {chosen} holds no numbers")));
        }
        out.push(usable(track, chosen, &decoder, &precision, options).map_err(refuse)?);
    }
    Ok(out)
}

/// Returns the messages of a topic in the order of their time, each time once and without counters; says why not otherwise.
fn usable(
    mut track: Track,
    chosen: &str,
    decoder: &Decoder,
    precision: &Precision,
    options: &ReadOptions,
) -> Result<Track, String> {
    track.names = decoder.names().to_vec();
    track.depth = decoder.depth.filter(|depth| *depth > 0);
    if let Some(lossy) = precision.lossy() {
        let name = track.names.get(lossy.channel).map_or("", String::as_str);
        return Err(format!("topic {chosen}: {name} {lossy}, choosing other fields with topics"));
    }
    let track = track.sorted().without_repeats().map_err(|count| {
        let how = "give each sensor a topic of its own, and record messages at the time at which they come";
        format!("{count} of topic {chosen} {TOO_MANY}; {how}")
    })?;
    // Who names a field means it.
    let track = if *chosen == track.topic { track.without_counters(&options.channel_names) } else { track };
    if track.values.is_empty() {
        let left_out = track.left_out.join(", ");
        return Err(format!("topic {chosen} holds no channel: {left_out}; name a field of it with topics"));
    }
    Ok(track)
}

/// Checks whether a name ends in a place of a list: `data[3]`, and not `Time [s]`.
fn is_of_list(name: &str) -> bool {
    let place = name.strip_suffix(']').and_then(|name| name.rsplit_once('['));
    place.is_some_and(|(_, place)| place.bytes().all(|byte| byte.is_ascii_digit() || byte == b','))
}

impl ChosenTopic {
    /// Adds a message if it is of the chosen topic.
    fn add(
        &mut self,
        topic: &Topic,
        chosen: &str,
        message: &file::BagMessage,
        options: &ReadOptions,
    ) -> Result<(), String> {
        match &self.decoder {
            Some((place, _)) if *place != message.topic => return Ok(()),
            Some(_) => {}
            None => {
                let Some(fields) = fields(chosen, &topic.name) else { return Ok(()) };
                let decoder =
                    Decoder::of(topic, &fields, options).map_err(|why| format!("{chosen} {why}"))?;
                if options.resize.is_some() && !decoder.is_image() {
                    return Err(format!("{chosen} holds no images, to which resize applies; leave it out"));
                }
                self.decoder = Some((message.topic, decoder));
                self.track.topic = topic.name.clone();
            }
        }
        let Some((_, decoder)) = &mut self.decoder else { return Ok(()) };
        let Track { stamps, values, shape, .. } = &mut self.track;
        let read = decoder.read(message.data, values, &mut self.precision);
        let read = read.map_err(|why| format!("{chosen}: message {} {why}", stamps.len()))?;
        if stamps.is_empty() {
            *shape = read;
        } else if *shape != read {
            let how = if decoder.is_image() {
                "set resize = [height, width], and record all in grey or all in colour"
            } else {
                "choose with topics a field that does not change in size, or record lists of one length"
            };
            return Err(format!(
                "{chosen}: message {} holds {read:?} numbers, those before it {shape:?}; {how}",
                stamps.len()
            ));
        }
        stamps.push(message.time);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_may_be_followed_by_fields() {
        assert_eq!(fields("/joint_states", "/joint_states"), Some(vec![]));
        assert_eq!(fields("/ft.wrench.force", "/ft"), Some(vec!["wrench", "force"]));
        assert_eq!((fields("/ft2", "/ft"), fields("/f", "/ft")), (None, None));
    }
}
