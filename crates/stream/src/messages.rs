//! Messages of a bag as time steps.

use std::time::Instant;

use taxel_data::BagMessages;

use crate::columns::LineColumns;
use crate::error::Result;
use crate::pace::Pacer;
use crate::queue::{Closed, Feed, Skip};

/// Hands on every message with its time.
///
/// # Errors
/// None: a message whose values are not finite is skipped, counted and said once.
pub(crate) fn feed(
    label: &str,
    messages: &BagMessages,
    columns: &LineColumns,
    mut pacer: Pacer,
    say: &dyn Fn(&str),
    feed: &mut Feed,
) -> Result<()> {
    columns.found(&messages.channels);
    let rows = messages.values.chunks_exact(messages.channels.len().max(1));
    for (number, (time, values)) in messages.times.iter().zip(rows).enumerate() {
        pacer.wait(*time);
        if values.iter().any(|value| !value.is_finite()) {
            feed.skip();
            if feed.counters.skip(Skip::NotFinite) {
                let topic = &messages.topic;
                say(&format!("{label}: message {number} of {topic} is not finite; skipped. It is said once"));
            }
            continue;
        }
        if let Err(Closed) = feed.reading(values, Some(*time), Instant::now()) {
            break;
        }
    }
    Ok(())
}
