//! An event: a value beyond a threshold.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// The class of samples without an event.
const REST: &str = "rest";

/// A threshold of an array or column, beyond which a sample is an event.
///
/// As text: `slip_speed_cm_s > 1`, `gap_mm < 0.5`. A value that equals the threshold is no event.
///
/// ```
/// use taxel_data::Event;
///
/// let event: Event = "slip_speed_cm_s>1".parse()?;
/// assert_eq!(event.to_string(), "slip_speed_cm_s > 1");
/// assert!(event.is_in(1.5) && !event.is_in(1.0));
/// # Ok::<(), taxel_data::NotAnEvent>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "String", into = "String")]
pub struct Event {
    name: String,
    side: Side,
    threshold: f32,
}

/// The values that are events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Above,
    Below,
}

/// A text that says no event.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no event; write the name of an array or column, > or <, and a number: slip_speed_cm_s > 1")]
pub struct NotAnEvent(String);

impl TryFrom<String> for Event {
    type Error = NotAnEvent;

    fn try_from(text: String) -> Result<Self, NotAnEvent> {
        text.parse()
    }
}

impl From<Event> for String {
    fn from(event: Event) -> Self {
        event.to_string()
    }
}

impl FromStr for Event {
    type Err = NotAnEvent;

    fn from_str(text: &str) -> Result<Self, NotAnEvent> {
        let refuse = || NotAnEvent(text.into());
        let at = text.rfind(['>', '<']).ok_or_else(refuse)?;
        let side = if text[at..].starts_with('>') { Side::Above } else { Side::Below };
        let name = text[..at].trim();
        let threshold: f32 = text[at + 1..].trim().parse().map_err(|_| refuse())?;
        let is_sound = threshold.is_finite() && !name.is_empty() && !name.ends_with(['>', '<', '=']);
        if is_sound { Ok(Event { name: name.into(), side, threshold }) } else { Err(refuse()) }
    }
}

impl Display for Event {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let sign = if self.side == Side::Above { '>' } else { '<' };
        write!(f, "{} {sign} {}", self.name, self.threshold)
    }
}

impl Event {
    /// Returns the name of the array or column.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Checks whether a value is an event; NaN is none.
    pub fn is_in(&self, value: f32) -> bool {
        match self.side {
            Side::Above => value > self.threshold,
            Side::Below => value < self.threshold,
        }
    }

    /// Returns the names of both classes: rest, and the event as text.
    pub(crate) fn classes(&self) -> [String; 2] {
        [REST.into(), self.to_string()]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn an_event_is_a_name_a_sign_and_a_number() {
        for (text, written) in [
            ("speed > 1", "speed > 1"),
            (" gap_mm<0.10 ", "gap_mm < 0.1"),
            ("force [N] > -2e-1", "force [N] > -0.2"),
            ("a<b > 3", "a<b > 3"),
        ] {
            let event: Event = text.parse().unwrap();
            assert_eq!(event.to_string(), written);
            assert_eq!(event.to_string().parse::<Event>().unwrap(), event);
        }
        for text in
            ["speed", "speed > fast", "> 1", "speed >= 1", "speed >> 1", "speed > inf", "speed > nan", ""]
        {
            let message = text.parse::<Event>().unwrap_err().to_string();
            assert!(message.contains("slip_speed_cm_s > 1"), "{message}");
        }
    }

    #[test]
    fn the_threshold_is_no_event_and_is_compared_as_stored() {
        let above: Event = "speed > 0.1".parse().unwrap();
        let below: Event = "speed < 0.1".parse().unwrap();
        for (value, is_above, is_below) in [(0.1, false, false), (0.2, true, false), (0.0, false, true)] {
            assert_eq!((above.is_in(value), below.is_in(value)), (is_above, is_below));
        }
        assert!(!above.is_in(f32::NAN) && !below.is_in(f32::NAN));
    }
}
