//! Which topics a bag holds, and which one is meant where nobody says it.

use crate::error::plural;
use crate::formats::bag::file::{self, Topic};
use crate::formats::bag::message::is_measured;
use crate::formats::bag::path::parts;
use crate::{Error, Result};
use std::path::Path;

/// Topics that a message lists.
const LIST: usize = 16;

/// How many messages a topic has, and when the first and the last was recorded, in nanoseconds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Count {
    pub messages: u64,
    first: u64,
    last: u64,
}

impl Count {
    /// Counts one message; `counts` goes by the places of the topics.
    pub fn add(counts: &mut Vec<Self>, topic: usize, time: u64) {
        if counts.len() <= topic {
            counts.resize(topic + 1, Self { messages: 0, first: u64::MAX, last: 0 });
        }
        let own = &mut counts[topic];
        *own = Self { messages: own.messages + 1, first: own.first.min(time), last: own.last.max(time) };
    }
}

/// The topics of a bag, and the messages of each.
pub(crate) fn counted(bag: &Path) -> Result<(Vec<Topic>, Vec<Count>)> {
    let (mut topics, mut counts) = (vec![], vec![]);
    for part in parts(bag)? {
        file::each(&part, &mut topics, |_, message| {
            Count::add(&mut counts, message.topic, message.time);
            Ok(())
        })?;
    }
    Ok((topics, counts))
}

/// The one topic of a bag with readings of a sensor.
pub(crate) fn only(bag: &Path) -> Result<String> {
    let (topics, counts) = counted(bag)?;
    let has_messages = |at: usize| counts.get(at).is_some_and(|own| own.messages > 0);
    let measured: Vec<&Topic> = topics
        .iter()
        .enumerate()
        .filter(|(at, own)| has_messages(*at) && is_measured(own))
        .map(|(_, own)| own)
        .collect();
    match measured.as_slice() {
        [one] => Ok(one.name.clone()),
        several => {
            let what = if several.is_empty() { "no topic with numbers or images" } else { "several topics" };
            let name = several.first().map_or("/tactile", |topic| &topic.name);
            let why = format!(
                "has {what}; name one or more with topics = [{name:?}]. It has {}",
                described(&topics, &counts)
            );
            Err(Error::Bag { file: bag.display().to_string(), why })
        }
    }
}

/// What a bag holds: name, type, number of messages and rate of each topic.
pub(crate) fn described(topics: &[Topic], counts: &[Count]) -> String {
    let of = |(at, topic): (usize, &Topic)| {
        let Topic { name, kind, .. } = topic;
        let kind = if kind.is_empty() { &topic.encoding } else { kind };
        match counts.get(at).filter(|own| own.messages > 0) {
            None => format!("{name} ({kind}, no messages)"),
            Some(own) if own.messages > 1 && own.last > own.first => {
                let rate = (own.messages - 1) as f64 * 1e9 / (own.last - own.first) as f64;
                format!("{name} ({kind}, {} messages, {rate:.1} Hz)", own.messages)
            }
            Some(own) => format!("{name} ({kind}, {})", plural(own.messages as usize, "message")),
        }
    };
    let mut own: Vec<String> = topics.iter().enumerate().take(LIST).map(of).collect();
    match topics.len().saturating_sub(LIST) {
        0 if own.is_empty() => "no topics".into(),
        0 => own.join(", "),
        more => {
            own.push(format!("and {more} more"));
            own.join(", ")
        }
    }
}
