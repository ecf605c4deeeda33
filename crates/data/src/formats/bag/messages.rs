//! Reads the messages of one topic of a bag as they were recorded.

use crate::formats::bag::topics;
use crate::formats::bag::tracks::tracks;
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::path::Path;

/// The messages of one topic, each with the values of its channels.
#[derive(Debug, Clone, PartialEq)]
pub struct BagMessages {
    /// The topic, with the fields below it that were chosen.
    pub topic: String,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Times at which messages were recorded, in seconds after the first; they rise.
    pub times: Vec<f64>,
    /// Values `[messages, channels]`.
    pub values: Vec<f32>,
}

/// Reads the messages of the one topic in `options.topics`, or of the only one with values, at the times at which they were recorded:
/// nothing is interpolated.
///
/// # Errors
/// A file that is no bag or is damaged; several topics, one that is not there, one of images.
pub fn bag_messages(bag: &Path, options: &ReadOptions) -> Result<BagMessages> {
    let topic = match options.topics.as_slice() {
        [] => topics::only(bag)?,
        [topic] => topic.clone(),
        several => {
            let why = format!("one topic at a time is replayed, and {} are named; name one", several.len());
            return Err(Error::file(bag, why));
        }
    };
    let mut read = tracks(bag, std::slice::from_ref(&topic), options, options.limits.max_values)?;
    let track = read.pop().ok_or_else(|| Error::NoSamples { at: bag.display().to_string() })?;
    if track.shape.len() != 1 {
        let why = format!("topic {topic} holds images, and channels are replayed; name a topic of numbers");
        return Err(Error::file(bag, why));
    }
    let first = track.stamps.first().copied().unwrap_or(0);
    Ok(BagMessages { topic, times: track.seconds(first), channels: track.names, values: track.values })
}
