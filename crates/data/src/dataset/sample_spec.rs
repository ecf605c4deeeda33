//! What one raw sample is.

use crate::formats::table::options::TableOptions;
use crate::length::length::{Length, Padding};
use serde::{Deserialize, Serialize};
use taxel_base::Layout;

/// What one raw sample is: everything that a model must know to read another one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleSpec {
    /// What the axes are.
    pub layout: Layout,
    /// Lengths of the axes, in the order of [`Layout::axes`].
    pub shape: Vec<usize>,
    /// Of a recording with more of them, the indices along its first axis that are kept, in this order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<usize>>,
    /// How a recording of any length became one of this shape; none where recordings are taken as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<Length>,
    /// Of a table what its columns were, channels in their order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<TableOptions>,
    /// Of bags the topics that were read, in the order of their channels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<String>,
    /// Unit of the values, such as `N`, where somebody says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Readings per second (Hz), where somebody says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Of recordings with time stamps the readings per second (Hz) that they were brought to, before `length`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stamped: Option<f64>,
    /// The largest possible reading, in `unit`; above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f32>,
    /// Readings without contact, one for all or one per channel, in `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<Vec<f32>>,
}

impl SampleSpec {
    /// A sample of known axes, and nothing else known.
    pub fn new(layout: Layout, shape: &[usize]) -> Self {
        Self {
            layout,
            shape: shape.to_vec(),
            channels: None,
            length: None,
            topics: vec![],
            table: None,
            unit: None,
            rate: None,
            stamped: None,
            full_scale: None,
            rest: None,
        }
    }

    /// The reading without contact, in `unit`; of many the mean, 0 where nobody says it.
    pub fn mean_at_rest(&self) -> f32 {
        match self.rest.as_deref() {
            Some(rest @ [_, ..]) => rest.iter().sum::<f32>() / rest.len() as f32,
            _ => 0.0,
        }
    }

    /// Readings per second (Hz) of recordings before `length`, where that is known: those with time stamps are brought
    /// to it.
    pub fn recorded_rate(&self) -> Option<f64> {
        let is_resampled = matches!(self.length, Some(Length::Resample { .. }));
        self.stamped.or(self.rate.filter(|_| !is_resampled))
    }

    /// Values of a sample before its time axis, readings along it, and values after it, in row-major order: a reading is
    /// the values before times those after. Of a sample without time all values are one reading.
    pub fn around_time(&self) -> (usize, usize, usize) {
        match self.layout.time_axis() {
            Some(axis) if axis < self.shape.len() => {
                let (before, from) = self.shape.split_at(axis);
                (before.iter().product(), from[0], from[1..].iter().product())
            }
            _ => (1, 1, self.shape.iter().product()),
        }
    }

    /// What a sample is filled up with of which only the start is known: as its own rule does, else its last reading, which
    /// a network mistakes for less than zeros in the middle of a press.
    pub fn padding(&self) -> Padding {
        match self.length {
            Some(Length::Pad { value, .. }) => value,
            _ => Padding::Edge,
        }
    }
}
