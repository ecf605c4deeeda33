//! Reads the messages of chosen topics of a bag.

use crate::formats::bag::file::{self, Topic};
use crate::formats::bag::message::Decoder;
use crate::formats::bag::path::parts;
use crate::formats::bag::topics::{Count, counted, described};
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
    /// Shape of one message: `[channels]`, or height and width of an image.
    pub shape: Vec<usize>,
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
    for (ChosenTopic { track, decoder }, chosen) in all.into_iter().zip(chosen) {
        if decoder.is_none() {
            let held = described(&topics, &counts);
            return Err(refuse(format!("has no messages of topic {chosen}; it has {held}")));
        }
        if track.values.is_empty() {
            return Err(refuse(format!("topic {chosen} holds no numbers")));
        }
        let track = track.sorted();
        if let Some(twice) = track.stamps.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(refuse(format!(
                "topic {chosen} has two messages of the same time, {} ns; give each sensor a topic of its own",
                twice[0]
            )));
        }
        out.push(track);
    }
    Ok(out)
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
        let decoder = match &self.decoder {
            Some((place, _)) if *place != message.topic => return Ok(()),
            Some((_, decoder)) => decoder,
            None => {
                let Some(fields) = fields(chosen, &topic.name) else { return Ok(()) };
                let decoder =
                    Decoder::of(topic, &fields, options.resize).map_err(|why| format!("{chosen} {why}"))?;
                if options.resize.is_some() && !decoder.is_image() {
                    return Err(format!("{chosen} holds no images, to which resize applies; leave it out"));
                }
                &self.decoder.insert((message.topic, decoder)).1
            }
        };
        let Track { stamps, values, shape } = &mut self.track;
        let read = decoder.read(message.data, values);
        let read = read.map_err(|why| format!("{chosen}: message {} {why}", stamps.len()))?;
        if stamps.is_empty() {
            *shape = read;
        } else if *shape != read {
            return Err(format!(
                "{chosen}: message {} holds {read:?} numbers, those before it {shape:?}; choose a field that does not \
                 change in size, such as {chosen}.data",
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
