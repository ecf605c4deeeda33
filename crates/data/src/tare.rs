//! Where the values of a sensor at rest are.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// Where the resting values of a recording are, which are taken off each of its readings.
///
/// As text: `recording`, `recording:18`, `array:tare`, or `off`.
///
/// ```
/// use taxel_data::Tare;
///
/// assert_eq!("recording:18".parse(), Ok(Tare::Recording { steps: 18 }));
/// assert_eq!(Tare::Array("tare".into()).to_string(), "array:tare");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "Written", into = "String")]
pub enum Tare {
    /// The mean of the first readings of each recording, before it is cut to windows.
    Recording {
        /// Number of readings, from 1.
        steps: usize,
    },
    /// An array of that name beside the samples: a row for each, without the time axis.
    Array(String),
    /// Nothing is taken off, whatever the file of names says.
    Off,
}

/// A text that says no tare.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is no tare; write recording, recording:18 (the mean of its first 18 readings), array:NAME or off; the first reading of \
     each window is taken off by encoding.baseline = 1"
)]
pub struct NotATare(String);

/// A tare in a config or a model card.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum Written {
    Text(String),
    Array { array: String },
}

impl TryFrom<Written> for Tare {
    type Error = NotATare;

    fn try_from(written: Written) -> Result<Self, NotATare> {
        match written {
            Written::Text(text) => text.parse(),
            Written::Array { array } => Ok(Tare::Array(array)),
        }
    }
}

impl From<Tare> for String {
    fn from(tare: Tare) -> Self {
        tare.to_string()
    }
}

impl FromStr for Tare {
    type Err = NotATare;

    fn from_str(text: &str) -> Result<Self, NotATare> {
        let refuse = || NotATare(text.into());
        match text.split_once(':') {
            None if text == "recording" => Ok(Tare::Recording { steps: 1 }),
            None if text == "off" => Ok(Tare::Off),
            Some(("recording", steps)) => {
                let steps = steps.parse().ok().filter(|steps| *steps > 0).ok_or_else(refuse)?;
                Ok(Tare::Recording { steps })
            }
            Some(("array", name)) if !name.is_empty() => Ok(Tare::Array(name.into())),
            _ => Err(refuse()),
        }
    }
}

impl Tare {
    /// Returns the name of the array with the resting values, if there is one.
    pub fn array(&self) -> Option<&String> {
        match self {
            Tare::Recording { .. } | Tare::Off => None,
            Tare::Array(name) => Some(name),
        }
    }

    /// Says what is taken off each reading: `the mean of the first 18 readings of its recording`. None where nothing is.
    pub fn words(&self) -> Option<String> {
        match self {
            Tare::Recording { steps: 1 } => Some("the first reading of its recording".into()),
            Tare::Recording { steps } => {
                Some(format!("the mean of the first {steps} readings of its recording"))
            }
            Tare::Array(name) => {
                Some(format!("the resting values of its recording, in training those of the array {name:?}"))
            }
            Tare::Off => None,
        }
    }
}

impl Display for Tare {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Tare::Recording { steps: 1 } => f.write_str("recording"),
            Tare::Recording { steps } => write!(f, "recording:{steps}"),
            Tare::Array(name) => write!(f, "array:{name}"),
            Tare::Off => f.write_str("off"),
        }
    }
}
