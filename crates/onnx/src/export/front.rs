//! The steps from raw samples to the network, as far as ONNX can say them.

use super::code::Code;
use super::history::history;
use super::rocket::RocketFeatures;
use super::sink::{Sink, ints, sizes};
use crate::error::Cause;

/// How raw readings become an input of the network: the ONNX model then takes the readings themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct Front {
    /// Shape of one raw reading, batch axis left out.
    pub shape: Vec<usize>,
    /// The steps, in order; the last one gives the shape of the network's input.
    pub steps: Vec<FrontStep>,
}

/// One step from a raw reading to an input.
#[derive(Debug, Clone, PartialEq)]
pub enum FrontStep {
    /// The same values in another shape.
    Reshape(Vec<usize>),
    /// Axes in another order: new axis i is old axis `order[i]`, counted without the batch axis.
    Transpose(Vec<usize>),
    /// `[C, T]` less the mean of the first so many readings of each channel.
    LessBaseline(usize),
    /// `(v − offset) / divisor` per channel (first axis), or for all where there is one value.
    Scale {
        /// One per channel, or one for all.
        offset: Vec<f32>,
        /// One per channel, or one for all; above 0.
        divisor: Vec<f32>,
    },
    /// `[C, T]` as the last reading of each channel and its differences to readings so many steps before, `[rows, 1]`.
    History(Vec<usize>),
    /// `[C, T]` as its quantile code `[rows, steps]`.
    Code(Code),
    /// `[C, T]` as MiniRocket's features `[features]`.
    Rocket(RocketFeatures),
}

impl Front {
    /// Writes the steps for the input called `name`; the value that comes out, of shape `wanted`.
    pub fn emit(&self, sink: &mut Sink, name: &str, wanted: &[usize]) -> Result<String, Cause> {
        let refuse = |reason: String| Err(Cause::Port { role: "input", name: name.into(), reason });
        let (mut value, mut shape) = (name.to_string(), self.shape.clone());
        for step in &self.steps {
            match step {
                FrontStep::Reshape(to) => {
                    if to.iter().product::<usize>() != shape.iter().product::<usize>() {
                        return refuse(format!("{shape:?} cannot become {to:?}"));
                    }
                    if *to != shape {
                        let to = sink.ints(&format!("{name}/shape"), &[&[0], &sizes(to)[..]].concat());
                        value = sink.step("Reshape", &[&value, &to], &format!("{name}/reshape"), vec![]);
                    }
                    shape.clone_from(to);
                }
                FrontStep::Transpose(order) => {
                    let Some(turned) = turned(order, &shape) else {
                        return refuse(format!("axes {order:?} of {shape:?} are none"));
                    };
                    let perm = std::iter::once(0).chain(order.iter().map(|&axis| axis as i64 + 1)).collect();
                    let base = format!("{name}/transpose");
                    value = sink.step("Transpose", &[&value], &base, vec![ints("perm", perm)]);
                    shape = turned;
                }
                FrontStep::LessBaseline(readings) => {
                    if shape.len() != 2 || *readings == 0 || *readings > shape[1] {
                        return refuse(format!("{shape:?} has no first {readings} readings"));
                    }
                    value = less_baseline(sink, name, &value, *readings);
                }
                FrontStep::Scale { offset, divisor } => {
                    let channels = shape.first().copied().unwrap_or(1);
                    if [offset, divisor].iter().any(|values| values.len() != 1 && values.len() != channels) {
                        return refuse(format!("{} scales for {channels} channels", offset.len()));
                    }
                    value = scaled(sink, name, value, shape.len(), (offset, divisor));
                }
                FrontStep::History(_) | FrontStep::Code(_) | FrontStep::Rocket(_) => {
                    let Some(made) = encoded(step, sink, name, &value, &shape) else {
                        return refuse(format!("{shape:?} is no series of this encoding"));
                    };
                    (value, shape) = made;
                }
            }
        }
        if shape != wanted {
            return refuse(format!("readings become {shape:?}, the network reads {wanted:?}"));
        }
        Ok(value)
    }
}

/// Writes the encoding of a whole series; its value and shape, or none where the series is not one of its.
fn encoded(
    step: &FrontStep,
    sink: &mut Sink,
    name: &str,
    value: &str,
    shape: &[usize],
) -> Option<(String, Vec<usize>)> {
    let series: [usize; 2] = shape.try_into().ok()?;
    let [channels, length] = series;
    match step {
        FrontStep::History(lags) => {
            let fits = lags.iter().all(|lag| *lag < length);
            let rows = vec![channels * (1 + lags.len()), 1];
            fits.then(|| (history(sink, name, value, series, lags), rows))
        }
        FrontStep::Code(code) => {
            let shape = code.shape(series)?;
            Some((code.emit(sink, name, value, length), shape.to_vec()))
        }
        FrontStep::Rocket(rocket) => {
            let width = rocket.width(series)?;
            Some((rocket.emit(sink, name, value, series), vec![width]))
        }
        _ => None,
    }
}

/// Returns the shape with its axes in another order, if `order` names each of them once.
fn turned(order: &[usize], shape: &[usize]) -> Option<Vec<usize>> {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted.iter().copied().eq(0..shape.len()).then(|| order.iter().map(|&axis| shape[axis]).collect())
}

fn less_baseline(sink: &mut Sink, name: &str, value: &str, readings: usize) -> String {
    let base = format!("{name}/baseline");
    let [start, end, axis] =
        [0, readings as i64, 2].map(|number| sink.ints(&format!("{base}/bounds"), &[number]));
    let first = sink.step("Slice", &[value, &start, &end, &axis], &format!("{base}/first"), vec![]);
    let axes = vec![ints("axes", vec![2]), super::sink::int("keepdims", 1)];
    let mean = sink.step("ReduceMean", &[&first], &format!("{base}/mean"), axes);
    sink.step("Sub", &[value, &mean], &base, vec![])
}

/// Leaves out a scaling that changes nothing.
fn scaled(
    sink: &mut Sink,
    name: &str,
    mut value: String,
    axes: usize,
    (offset, divisor): (&[f32], &[f32]),
) -> String {
    for (op, part, values, nothing) in [("Sub", "offset", offset, 0.0), ("Div", "divisor", divisor, 1.0)] {
        if values.iter().all(|v| *v == nothing) {
            continue;
        }
        let mut shape = vec![1; axes];
        if let Some(first) = shape.first_mut() {
            *first = values.len();
        }
        let stored = sink.floats(&format!("{name}/{part}"), &shape, values);
        value = sink.step(op, &[&value, &stored], &format!("{name}/{}", op.to_lowercase()), vec![]);
    }
    value
}
