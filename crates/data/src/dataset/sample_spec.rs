//! The description of one raw sample.

use crate::formats::table::options::TableOptions;
use crate::length::length::{Length, Padding};
use crate::tare::Tare;
use serde::{Deserialize, Serialize};
use taxel_base::Layout;

/// Axes, shape, unit, rate and range of one raw sample: all that a model must know to read another one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleSpec {
    /// Meaning of the axes.
    pub layout: Layout,
    /// Lengths of the axes, in the order of [`Layout::axes`].
    pub shape: Vec<usize>,
    /// Names of the channels of a sample, in their order; empty where its files name none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub channel_names: Vec<String>,
    /// Indices along the first axis of a recording that are kept, in this order; none where all are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<usize>>,
    /// Rule that brought recordings to this length; none where they are taken as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<Length>,
    /// Roles of the columns of a table, channels in their order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<TableOptions>,
    /// The array that named the recording of each row, where rows of `x` were readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// The resting values that were taken off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
    /// Topics of bags that were read, in the order of their channels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<String>,
    /// Unit of the values, such as `N`, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Time steps per second (Hz), where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Time steps per second (Hz) that recordings with time stamps were brought to, before `length`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stamped: Option<f64>,
    /// The largest possible value, in `unit`; above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f32>,
    /// Bits of a pixel as images are stored, 8 or 16; none of other data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<u8>,
    /// Values without contact, one for all or one per channel, in `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<Vec<f32>>,
    /// Facts that the options of reading said against the files: `rate`, `layout`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overruled: Vec<String>,
}

impl SampleSpec {
    /// Describes a sample of which only the axes are known.
    pub fn new(layout: Layout, shape: &[usize]) -> Self {
        Self {
            layout,
            shape: shape.to_vec(),
            channel_names: vec![],
            channels: None,
            length: None,
            topics: vec![],
            table: None,
            recording: None,
            tare: None,
            unit: None,
            rate: None,
            stamped: None,
            full_scale: None,
            depth: None,
            rest: None,
            overruled: vec![],
        }
    }

    /// Returns the mean value without contact, in `unit`; 0 where it is not known.
    pub fn mean_at_rest(&self) -> f32 {
        match self.rest.as_deref() {
            Some(rest @ [_, ..]) => rest.iter().sum::<f32>() / rest.len() as f32,
            _ => 0.0,
        }
    }

    /// Returns the time steps per second (Hz) of recordings before `length`, where that is known.
    pub fn recorded_rate(&self) -> Option<f64> {
        let is_resampled = matches!(self.length, Some(Length::Resample { .. }));
        self.stamped.or(self.rate.filter(|_| !is_resampled))
    }

    /// Returns the number of values before the time axis, of time steps, and of values after it, in row-major order. A time
    /// step holds the values before times those after; a sample without time is one time step.
    pub fn around_time(&self) -> (usize, usize, usize) {
        match self.layout.time_axis() {
            Some(axis) if axis < self.shape.len() => {
                let (before, from) = self.shape.split_at(axis);
                (before.iter().product(), from[0], from[1..].iter().product())
            }
            _ => (1, 1, self.shape.iter().product()),
        }
    }

    /// Returns the padding of a sample of which only the start is known: that of its rule for the length, else its last
    /// time step. Zeros in the middle of a press would mislead a network more.
    pub fn padding(&self) -> Padding {
        match self.length {
            Some(Length::Pad { value, .. }) => value,
            _ => Padding::Edge,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_without_a_time_axis_is_one_time_step() {
        let spec = |shape: &[usize]| -> SampleSpec {
            let card = serde_json::json!({ "layout": "series", "shape": shape });
            serde_json::from_value(card).unwrap_or_else(|why| panic!("{why}"))
        };
        assert_eq!(spec(&[3, 4]).around_time(), (3, 4, 1));
        assert_eq!(spec(&[5]).around_time(), (1, 1, 5));
    }
}
