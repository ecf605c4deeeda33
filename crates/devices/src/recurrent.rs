//! Recurrent layers, step by step. Tensors are PyTorch's: input weights, recurrent weights and both biases.

use candle_core::{Result, Tensor};
use candle_nn::ops::sigmoid;
use taxel_graph::Op;

/// Computes the hidden state of a GRU, or else an LSTM, after the last step.
pub(crate) fn last(op: &Op, x: &Tensor, tensors: [&Tensor; 4]) -> Result<Tensor> {
    match op {
        Op::Gru { .. } => gru(x, tensors),
        _ => lstm(x, tensors),
    }
}

/// Computes the hidden state [n, hidden] of an LSTM after the last step of `x` [n, channels, 1…, steps]; gates i, f, g, o.
fn lstm(x: &Tensor, [w_ih, w_hh, b_ih, b_hh]: [&Tensor; 4]) -> Result<Tensor> {
    let projected = projected(x, w_ih, &(b_ih + b_hh)?)?;
    let (n, steps, _) = projected.dims3()?;
    let (hidden, recurrent) = (w_hh.dim(1)?, w_hh.t()?);
    let mut h = Tensor::zeros((n, hidden), x.dtype(), x.device())?;
    let mut c = h.clone();
    for step in 0..steps {
        let gates = (projected.narrow(1, step, 1)?.squeeze(1)? + h.matmul(&recurrent)?)?;
        let gate = |which: usize| gates.narrow(1, which * hidden, hidden)?.contiguous();
        let (i, f, g, o) = (sigmoid(&gate(0)?)?, sigmoid(&gate(1)?)?, gate(2)?.tanh()?, sigmoid(&gate(3)?)?);
        c = ((f * c)? + (i * g)?)?;
        h = (o * c.tanh()?)?;
    }
    Ok(h)
}

/// Computes the hidden state [n, hidden] of a GRU after the last step of `x` [n, channels, 1…, steps]; gates r, z, n.
fn gru(x: &Tensor, [w_ih, w_hh, b_ih, b_hh]: [&Tensor; 4]) -> Result<Tensor> {
    let projected = projected(x, w_ih, b_ih)?;
    let (n, steps, _) = projected.dims3()?;
    let (hidden, recurrent) = (w_hh.dim(1)?, w_hh.t()?);
    let mut h = Tensor::zeros((n, hidden), x.dtype(), x.device())?;
    for step in 0..steps {
        let (seen, kept) =
            (projected.narrow(1, step, 1)?.squeeze(1)?, h.matmul(&recurrent)?.broadcast_add(b_hh)?);
        let part = |of: &Tensor, which: usize| of.narrow(1, which * hidden, hidden)?.contiguous();
        let reset = sigmoid(&(part(&seen, 0)? + part(&kept, 0)?)?)?;
        let update = sigmoid(&(part(&seen, 1)? + part(&kept, 1)?)?)?;
        let new = (part(&seen, 2)? + (reset * part(&kept, 2)?)?)?.tanh()?;
        h = (((1.0 - &update)? * new)? + (update * h)?)?;
    }
    Ok(h)
}

/// Computes what the inputs of all steps give to the gates: [n, steps, gates].
fn projected(x: &Tensor, weights: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let (n, channels) = (x.dim(0)?, x.dim(1)?);
    let steps = x.elem_count() / (n * channels).max(1);
    let rows =
        x.reshape((n, channels, steps))?.transpose(1, 2)?.contiguous()?.reshape((n * steps, channels))?;
    rows.matmul(&weights.t()?)?.broadcast_add(bias)?.reshape((n, steps, weights.dim(0)?))
}
