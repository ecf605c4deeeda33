//! The sensor of a sample, as faults must know it: axes and range of its values.
//!
//! # Reference
//!
//! None.

use crate::{Error, Result};
use taxel_base::Layout;

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
    /// Makes a sensor that reads 0 at rest and `full_scale` at most.
    pub fn new(layout: Layout, full_scale: f32) -> Self {
        Self { layout, low: 0.0, high: full_scale, rest: vec![0.0] }
    }

    /// Returns the whole range of readings.
    pub(crate) fn span(&self) -> f32 {
        self.high - self.low
    }

    /// Rejects an empty range and rest values outside it or in the wrong number.
    pub(crate) fn check(&self, elements: usize) -> Result<()> {
        let reject = |name: &str, value, expected: &str| {
            Err(Error::Parameter { name: name.into(), value, expected: expected.into() })
        };
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
