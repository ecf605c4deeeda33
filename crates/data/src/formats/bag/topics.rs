//! Lists the topics of a bag, and chooses one where none is named.

use crate::error::plural;
use crate::formats::bag::file::{self, Topic};
use crate::formats::bag::message::is_measured;
use crate::formats::bag::path::parts;
use crate::{Error, Result};
use std::path::Path;

/// Topics that a message lists.
const LIST: usize = 16;

/// The number of messages of a topic, and the times of the first and the last in nanoseconds.
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
        let count = &mut counts[topic];
        count.messages += 1;
        (count.first, count.last) = (count.first.min(time), count.last.max(time));
    }
}

/// Counts the messages of each topic of a bag.
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

/// Returns the one topic of a bag with values of a sensor.
pub(crate) fn only(bag: &Path) -> Result<String> {
    let (topics, counts) = counted(bag)?;
    let has_messages = |at: usize| counts.get(at).is_some_and(|count| count.messages > 0);
    let measured: Vec<&Topic> = topics
        .iter()
        .enumerate()
        .filter(|(at, topic)| has_messages(*at) && is_measured(topic))
        .map(|(_, topic)| topic)
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
            Err(Error::file(bag, why))
        }
    }
}

/// Describes the topics of a bag: name, type, number of messages and rate of each.
pub(crate) fn described(topics: &[Topic], counts: &[Count]) -> String {
    let of = |(at, topic): (usize, &Topic)| {
        let Topic { name, kind, .. } = topic;
        let kind = if kind.is_empty() { &topic.encoding } else { kind };
        match counts.get(at).copied().filter(|count| count.messages > 0) {
            None => format!("{name} ({kind}, no messages)"),
            Some(Count { messages, first, last }) if messages > 1 && last > first => {
                let rate = (messages - 1) as f64 * 1e9 / (last - first) as f64;
                format!("{name} ({kind}, {messages} messages, {rate:.1} Hz)")
            }
            Some(count) => format!("{name} ({kind}, {})", plural(count.messages as usize, "message")),
        }
    };
    let mut listed: Vec<String> = topics.iter().enumerate().take(LIST).map(of).collect();
    match topics.len().saturating_sub(LIST) {
        0 if listed.is_empty() => return "no topics".into(),
        0 => {}
        more => listed.push(format!("and {more} more")),
    }
    listed.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_one_moment_have_no_rate() {
        let [name, kind, encoding] = ["/skin", "Skin", "json"].map(String::from);
        let topic = Topic { name, kind, encoding, language: String::new(), definition: String::new() };
        let mut counts = vec![];
        Count::add(&mut counts, 0, 5);
        Count::add(&mut counts, 0, 5);
        assert_eq!(described(std::slice::from_ref(&topic), &counts), "/skin (Skin, 2 messages)");
        Count::add(&mut counts, 0, 1_000_000_005);
        assert_eq!(described(&[topic], &counts), "/skin (Skin, 3 messages, 2.0 Hz)");
    }
}
