//! From the runtime's steps between floats to layers of C.

use taxel_kernels::Rectifier;
use taxel_runtime::{PlannedFloatConv, PlannedFloatLinear, PlannedLstm, PlannedOp};

use super::layer::{FloatConv, FloatDepthwise, FloatLinear, FloatWork, Fours, Lstm};
use crate::layer::{Row, Taps, Work};

/// The largest count that a layer's tables hold.
const COUNT: usize = u16::MAX as usize;
/// Filters side by side.
const WIDTH: usize = 4;

/// Returns the layer of a step that computes floats from floats, or `None` where the step is of another kind. Scratch of an LSTM
/// has the number `spare`.
///
/// # Errors
/// The reason, where a step has no C.
pub(crate) fn float_work(
    op: &PlannedOp,
    in_floats: bool,
    from: &[Row],
    to: &Row,
    spare: usize,
) -> Result<Option<Work>, String> {
    if from.is_empty() || from.iter().chain([to]).any(|row| row.scale.is_some()) {
        return Ok(None);
    }
    let work = match op {
        PlannedOp::FloatConv(conv) if conv.window.kernel[1] > 1 || from[0].rows > 1 => {
            return Err("it convolves an image of floats, which C does in eight bits alone".into());
        }
        PlannedOp::FloatConv(conv) if conv.has_fewer_products => {
            return Err("its products are saved by transforms (Winograd), which C does not have".into());
        }
        PlannedOp::FloatConv(conv) if conv.is_depthwise => depthwise(conv, &from[0], to)?,
        PlannedOp::FloatConv(conv) => convolution(conv, &from[0], to)?,
        PlannedOp::FloatLinear(linear) => FloatWork::Linear(dense(linear, &from[0], to)?),
        PlannedOp::Lstm(lstm) => FloatWork::Lstm(recurrent(lstm, &from[0], spare)?),
        PlannedOp::Map { affine: None, rectifier: Rectifier::None } if in_floats => {
            return Ok(Some(Work::Copy));
        }
        PlannedOp::Map { affine, rectifier } if in_floats => {
            FloatWork::Map { affine: affine.clone(), rectifier: *rectifier }
        }
        PlannedOp::Deviation(eps) if in_floats => {
            FloatWork::Deviation { share: 1.0 / from[0].positions as f32, eps: *eps }
        }
        PlannedOp::LayerNorm { eps, weight, bias } => {
            contiguous(&from[0])?;
            FloatWork::Norm { eps: *eps, weight: weight.clone(), bias: bias.clone() }
        }
        _ => return Ok(None),
    };
    Ok(Some(Work::Floats(work)))
}

/// Checks that the values of a row lie one after the other.
fn contiguous(from: &Row) -> Result<(), String> {
    if from.rows == 1 && (from.positions == 1 || from.pitch == from.channels) {
        Ok(())
    } else {
        Err("it reads values that do not lie one after the other".into())
    }
}

/// Packs weights, which lie as group × inputs × filters, into fours of filters.
fn fours(weight: &[f32], bias: &[f32], groups: usize) -> Fours {
    let filters = bias.len() / groups;
    let mut fours = Fours { weight: vec![], bias: vec![] };
    let filled = |values: &[f32], at: usize| values.get(at).copied().unwrap_or(0.0);
    for (group, bias) in weight.chunks_exact(weight.len() / groups).zip(bias.chunks_exact(filters)) {
        for first in (0..filters).step_by(WIDTH) {
            fours.bias.extend((first..first + WIDTH).map(|filter| filled(bias, filter)));
            for row in group.chunks_exact(filters) {
                fours.weight.extend((first..first + WIDTH).map(|filter| filled(row, filter)));
            }
        }
    }
    fours
}

fn convolution(conv: &PlannedFloatConv, from: &Row, to: &Row) -> Result<FloatWork, String> {
    let PlannedFloatConv { window, dilation, groups, weight, bias, rectifier, .. } = conv;
    let Taps { kernel, first, step, apart, .. } = Taps::new(window, *dilation, from);
    let channels = from.channels / groups;
    // Channels of neighbouring positions lie one after the other.
    let is_whole = *groups == 1 && dilation[2] == 1 && from.pitch == channels;
    let (segments, run) = if is_whole { (1, kernel * channels) } else { (kernel, channels) };
    fits(&[step, apart, run, segments, to.channels], kernel * channels)?;
    Ok(FloatWork::Conv(FloatConv {
        fours: fours(weight, bias, *groups),
        first,
        step,
        segments,
        apart,
        run,
        groups: *groups,
        channels,
        rectifier: *rectifier,
    }))
}

fn depthwise(conv: &PlannedFloatConv, from: &Row, to: &Row) -> Result<FloatWork, String> {
    let Taps { kernel, first, step, apart, .. } = Taps::new(&conv.window, conv.dilation, from);
    fits(&[step, apart, kernel, to.channels], kernel)?;
    let (weight, bias, rectifier) = (conv.weight.clone(), conv.bias.clone(), conv.rectifier);
    Ok(FloatWork::Depthwise(FloatDepthwise { weight, bias, first, step, taps: kernel, apart, rectifier }))
}

fn fits(numbers: &[usize], weights: usize) -> Result<(), String> {
    if numbers.iter().all(|number| *number <= COUNT) {
        Ok(())
    } else {
        Err(format!("its filters have {weights} weights; {COUNT} are the most"))
    }
}

fn dense(linear: &PlannedFloatLinear, from: &Row, to: &Row) -> Result<FloatLinear, String> {
    contiguous(from)?;
    let PlannedFloatLinear { weight, bias, rectifier } = linear;
    let inputs = weight.len() / bias.len();
    fits(&[inputs, to.channels], inputs)?;
    Ok(FloatLinear { fours: fours(weight, bias, 1), inputs, rectifier: *rectifier })
}

fn recurrent(lstm: &PlannedLstm, from: &Row, spare: usize) -> Result<Lstm, String> {
    let taxel_kernels::lstm::Lstm { channels, steps, hidden } = lstm.sizes;
    let [ih, hh, bias_ih, bias_hh] = &lstm.weights;
    fits(&[channels, steps, 4 * hidden, from.pitch], channels + hidden)?;
    let bias: Vec<f32> = bias_ih.iter().zip(bias_hh).map(|(a, b)| a + b).collect();
    let none = vec![0.0; bias.len()];
    Ok(Lstm {
        inputs: fours(&turned(ih, channels), &bias, 1),
        hidden_weight: fours(&turned(hh, hidden), &none, 1).weight,
        channels,
        steps,
        hidden,
        work: spare,
    })
}

/// Turns rows of `width` weights into columns.
fn turned(weight: &[f32], width: usize) -> Vec<f32> {
    (0..width).flat_map(|column| weight.iter().skip(column).step_by(width).copied()).collect()
}
