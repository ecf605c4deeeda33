//! Rules that bring recordings of unequal length to one length.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// A rule that makes recordings of any length samples of one length: `to` time steps.
///
/// As text, on a command line: `resample:300`, `pad:300`, `pad:300,edge,crop`, `crop:300,centre`,
/// `window:300,150`.
///
/// ```
/// use taxel_data::{Length, Padding, Longer};
///
/// let rule: Length = "pad:300,edge".parse()?;
/// assert_eq!(rule, Length::Pad { to: 300, value: Padding::Edge, longer: Longer::Refuse });
/// assert_eq!(rule.to_string(), "pad:300,edge");
/// assert_eq!(rule.key(), r#"length = { kind = "pad", to = 300, value = "edge" }"#);
/// # Ok::<(), taxel_data::NotALength>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Length {
    /// The whole recording at `to` equally spaced times from its first time step to its last. Values between are linearly
    /// interpolated. Where it shrinks, they are means of the values around each time, with weights that fall linearly
    /// to 0 over one step (against aliasing).
    Resample {
        /// Time steps of a sample, from 2.
        to: usize,
    },
    /// The recording from its start, filled up at its end.
    Pad {
        /// Time steps of a sample, from 1.
        to: usize,
        /// The values that fill it up. Default zero.
        #[serde(default, skip_serializing_if = "is_default")]
        value: Padding,
        /// The treatment of a longer recording. Default refused.
        #[serde(default, skip_serializing_if = "is_default")]
        longer: Longer,
    },
    /// A part of the recording; a shorter one is refused.
    Crop {
        /// Time steps of a sample, from 1.
        to: usize,
        /// Which part. Default the start.
        #[serde(default, skip_serializing_if = "is_default")]
        from: CropPart,
    },
    /// Every whole window of the recording, each a sample of its own; the rest at the end is dropped.
    Window {
        /// Time steps of a sample, from 1.
        to: usize,
        /// Time steps from the start of a window to that of the next, from 1. Default `to`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        hop: Option<usize>,
    },
}

/// The values that fill up a short recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Padding {
    /// Zeros.
    #[default]
    Zero,
    /// Its last time step.
    Edge,
}

/// The treatment of a recording that is longer than others are filled up to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Longer {
    /// It is refused by name.
    #[default]
    Refuse,
    /// Its end is cut off.
    Crop,
}

/// The part of a recording that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum CropPart {
    /// The first time steps.
    #[default]
    Start,
    /// The middle; of an odd rest one time step more is cut off at the end.
    Centre,
    /// The last time steps.
    End,
}

/// A text that is no rule.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{text:?} is no length rule; write resample:300, pad:300[,edge][,crop], crop:300[,centre or ,end] or window:300[,150]"
)]
pub struct NotALength {
    text: String,
}

impl Padding {
    /// Fills up a sample of which the first `known` time steps are there. `before` and `after` are the numbers of its
    /// values before and after the time axis, in row-major order. Nothing is allocated.
    pub fn fill(self, sample: &mut [f32], (before, after): (usize, usize), known: usize) {
        let each = sample.len() / before.max(1);
        for channel in sample.chunks_exact_mut(each.max(1)) {
            let from = (known * after).min(channel.len());
            match self {
                Self::Edge if from > 0 => {
                    for at in from..channel.len() {
                        channel[at] = channel[at - after];
                    }
                }
                Self::Zero | Self::Edge => channel[from..].fill(0.0),
            }
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Length {
    /// Returns the time steps of a sample.
    pub fn to(&self) -> usize {
        match *self {
            Self::Resample { to }
            | Self::Pad { to, .. }
            | Self::Crop { to, .. }
            | Self::Window { to, .. } => to,
        }
    }

    /// Returns the first value that is out of its range, with its key and the values that work.
    pub fn problem(&self) -> Option<(&'static str, usize, &'static str)> {
        match *self {
            Self::Resample { to: to @ (0 | 1) } => Some(("to", to, "is the number of readings, from 2")),
            Self::Window { hop: Some(0), .. } => {
                Some(("hop", 0, "is the number of readings from one window to the next, from 1"))
            }
            _ if self.to() == 0 => Some(("to", 0, "is the number of readings, from 1")),
            _ => None,
        }
    }

    /// Writes the rule as in a config: `length = { kind = "resample", to = 300 }`.
    pub fn key(&self) -> String {
        let more: String = self.extras().iter().map(|(key, _, value)| format!(", {key} = {value}")).collect();
        format!("length = {{ kind = \"{}\", to = {}{more} }}", self.kind(), self.to())
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Resample { .. } => "resample",
            Self::Pad { .. } => "pad",
            Self::Crop { .. } => "crop",
            Self::Window { .. } => "window",
        }
    }

    /// Lists the settings beside kind and `to` that are not the default: key, as text, as a TOML value.
    fn extras(&self) -> Vec<(&'static str, String, String)> {
        let word = |key, word: &str| (key, word.to_string(), format!("\"{word}\""));
        let mut extras = vec![];
        match *self {
            Self::Resample { .. } | Self::Window { hop: None, .. } => {}
            Self::Pad { value, longer, .. } => {
                extras.extend((value == Padding::Edge).then(|| word("value", "edge")));
                extras.extend((longer == Longer::Crop).then(|| word("longer", "crop")));
            }
            Self::Crop { from: CropPart::Start, .. } => {}
            Self::Crop { from: CropPart::Centre, .. } => extras.push(word("from", "centre")),
            Self::Crop { from: CropPart::End, .. } => extras.push(word("from", "end")),
            Self::Window { hop: Some(hop), .. } => extras.push(("hop", hop.to_string(), hop.to_string())),
        }
        extras
    }
}

impl Display for Length {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.kind(), self.to())?;
        self.extras().iter().try_for_each(|(_, text, _)| write!(f, ",{text}"))
    }
}

impl FromStr for Length {
    type Err = NotALength;

    fn from_str(text: &str) -> Result<Self, NotALength> {
        let refuse = || NotALength { text: text.into() };
        let (kind, rest) = text.split_once(':').ok_or_else(refuse)?;
        let mut words = rest.split(',').map(str::trim);
        let to = words.next().and_then(|to| to.parse().ok()).ok_or_else(refuse)?;
        let mut rule = match kind.trim() {
            "resample" => Self::Resample { to },
            "pad" => Self::Pad { to, value: Padding::Zero, longer: Longer::Refuse },
            "crop" => Self::Crop { to, from: CropPart::Start },
            "window" => Self::Window { to, hop: None },
            _ => return Err(refuse()),
        };
        for word in words {
            match (&mut rule, word) {
                (Self::Pad { value, .. }, "edge") => *value = Padding::Edge,
                (Self::Pad { value, .. }, "zero") => *value = Padding::Zero,
                (Self::Pad { longer, .. }, "crop") => *longer = Longer::Crop,
                (Self::Pad { longer, .. }, "refuse") => *longer = Longer::Refuse,
                (Self::Crop { from, .. }, "start") => *from = CropPart::Start,
                (Self::Crop { from, .. }, "centre") => *from = CropPart::Centre,
                (Self::Crop { from, .. }, "end") => *from = CropPart::End,
                (Self::Window { hop: hop @ None, .. }, word) => {
                    *hop = Some(word.parse().map_err(|_| refuse())?)
                }
                _ => return Err(refuse()),
            }
        }
        match rule.problem() {
            None => Ok(rule),
            Some(_) => Err(refuse()),
        }
    }
}
