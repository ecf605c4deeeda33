//! The axes of one raw sample.
//!
//! # Reference
//!
//! None: the five kinds of recordings of the five papers, and a row of numbers.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::names;

/// The axes of one raw sample, by kebab-case name in files and settings.
///
/// ```
/// use taxel_base::Layout;
///
/// let layout: Layout = "sequence".parse()?;
/// assert_eq!((layout.rank(), layout.axes()), (3, "time × rows × columns"));
/// assert!(layout.fits(&[10, 14, 25]) && !layout.fits(&[14, 25]));
/// # Ok::<(), taxel_base::UnknownLayout>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// `[F]`: one row of numbers.
    Features,
    /// `[C, T]`: channels over time; each channel is a sensor of its own, such as a finger's.
    Series,
    /// `[H, W]`: one image of an array of taxels.
    Image,
    /// `[3, H, W]`: one colour image of a camera-based sensor, red, green, blue; a taxel is a pixel.
    Colour,
    /// `[T, H, W]`: an array of taxels over time.
    Sequence,
    /// `[F, C, T]`: fingers of several channels over time; each finger is a sensor of its own.
    Fingers,
}

impl Layout {
    /// Every layout.
    pub const ALL: [Self; 6] =
        [Self::Features, Self::Series, Self::Image, Self::Colour, Self::Sequence, Self::Fingers];

    /// Returns the number of axes of one sample.
    pub fn rank(self) -> usize {
        match self {
            Self::Features => 1,
            Self::Series | Self::Image => 2,
            Self::Colour | Self::Sequence | Self::Fingers => 3,
        }
    }

    /// Returns the axes in words, slowest first: `channels × time`.
    pub fn axes(self) -> &'static str {
        match self {
            Self::Features => "features",
            Self::Series => "channels × time",
            Self::Image => "rows × columns",
            Self::Colour => "colours × rows × columns",
            Self::Sequence => "time × rows × columns",
            Self::Fingers => "fingers × channels × time",
        }
    }

    /// Returns the name in files and settings: `series`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Features => "features",
            Self::Series => "series",
            Self::Image => "image",
            Self::Colour => "colour",
            Self::Sequence => "sequence",
            Self::Fingers => "fingers",
        }
    }

    /// Describes a sample and its axes in messages: `a series [C, T]`.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Features => "a row of features [F]",
            Self::Series => "a series [C, T]",
            Self::Image => "an image [H, W]",
            Self::Colour => "a colour image [3, H, W]",
            Self::Sequence => "a sequence of images [T, H, W]",
            Self::Fingers => "a series of several fingers [F, C, T]",
        }
    }

    /// Checks whether one sample may have this shape: as many axes, and three planes of a colour image.
    pub fn fits(self, shape: &[usize]) -> bool {
        shape.len() == self.rank() && (self != Self::Colour || shape[0] == 3)
    }

    /// Checks whether a sample goes on in time; a row of features counts as one channel.
    pub fn has_time(self) -> bool {
        !matches!(self, Self::Image | Self::Colour)
    }

    /// Returns the time axis of a sample; none for features and single images.
    pub fn time_axis(self) -> Option<usize> {
        match self {
            Self::Series => Some(1),
            Self::Sequence => Some(0),
            Self::Fingers => Some(2),
            Self::Features | Self::Image | Self::Colour => None,
        }
    }

    /// Checks whether taxels lie on a surface, in rows and columns.
    pub fn has_area(self) -> bool {
        matches!(self, Self::Image | Self::Colour | Self::Sequence)
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no layout has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no layout `{name}`; {hint}")]
pub struct UnknownLayout {
    name: String,
    hint: String,
}

impl FromStr for Layout {
    type Err = UnknownLayout;

    fn from_str(name: &str) -> Result<Self, UnknownLayout> {
        let named = Self::ALL.into_iter().find(|layout| layout.name() == name);
        named.ok_or_else(|| UnknownLayout {
            name: name.into(),
            hint: names::hint(name, Self::ALL.map(Self::name)),
        })
    }
}
