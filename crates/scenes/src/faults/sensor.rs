//! What a fault has to know about the readings: their axes and their range.
//!
//! # Reference
//!
//! None.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// The axes of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// `[C, T]`: channels over time; each channel is a sensor of its own, such as a finger's.
    Series,
    /// `[H, W]`: one image of an array of taxels.
    Image,
    /// `[3, H, W]`: one colour image of a camera-based sensor; a taxel is a pixel.
    Colour,
    /// `[T, H, W]`: an array of taxels over time.
    Sequence,
    /// `[F, C, T]`: fingers of several channels over time; each finger is a sensor of its own.
    Fingers,
}

impl Layout {
    /// Name and axes, for messages.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Series => "a series [C, T]",
            Self::Image => "an image [H, W]",
            Self::Colour => "a colour image [3, H, W]",
            Self::Sequence => "a sequence of images [T, H, W]",
            Self::Fingers => "a series of several fingers [F, C, T]",
        }
    }

    /// Whether a sample goes on in time.
    pub fn has_time(self) -> bool {
        !matches!(self, Self::Image | Self::Colour)
    }

    /// Whether taxels lie on a surface, in rows and columns.
    pub fn has_area(self) -> bool {
        matches!(self, Self::Image | Self::Colour | Self::Sequence)
    }

    /// Number of axes of one sample.
    pub fn axes(self) -> usize {
        match self {
            Self::Series | Self::Image => 2,
            Self::Colour | Self::Sequence | Self::Fingers => 3,
        }
    }
}

/// Axes and range of raw readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// The axes of one sample.
    pub layout: Layout,
    /// The smallest possible reading.
    pub low: f32,
    /// The largest possible reading; above `low`.
    pub high: f32,
    /// Readings without contact: one for all, or one per channel (`F × C` for fingers) or taxel
    /// (row by row), each in `low..=high`.
    pub rest: Vec<f32>,
}

impl Sensor {
    /// A sensor that reads 0 at rest and `full_scale` at most.
    pub fn new(layout: Layout, full_scale: f32) -> Self {
        Self { layout, low: 0.0, high: full_scale, rest: vec![0.0] }
    }

    /// The whole range of readings.
    pub(super) fn span(&self) -> f32 {
        self.high - self.low
    }

    /// Rejects an empty range and rest values outside it or in the wrong number.
    pub(super) fn check(&self, elements: usize) -> Result<()> {
        let reject = |name, value, expected| Err(Error::Parameter { name, value, expected });
        if !(self.span() > 0.0 && self.span().is_finite()) {
            let range = format!("{}..{}", self.low, self.high);
            return reject("range of the readings", range, "must be finite, its low end below its high end");
        }
        if self.rest.len() != 1 && self.rest.len() != elements {
            let expected = "give one rest value for all, or one per channel or taxel";
            return reject("number of rest values", self.rest.len().to_string(), expected);
        }
        match self.rest.iter().find(|rest| !(self.low..=self.high).contains(rest)) {
            Some(rest) => reject("rest", rest.to_string(), "must lie within the range of the readings"),
            None => Ok(()),
        }
    }
}
