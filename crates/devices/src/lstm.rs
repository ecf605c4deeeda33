//! An LSTM layer, step by step.

use candle_core::{Result, Tensor};
use candle_nn::ops::sigmoid;

/// Computes the hidden state [n, hidden] after the last step of `x` [n, channels, steps].
///
/// The tensors are PyTorch's: input weights, recurrent weights and both biases, gates i, f, g, o.
pub(crate) fn last_hidden(x: &Tensor, [w_ih, w_hh, b_ih, b_hh]: [&Tensor; 4]) -> Result<Tensor> {
    let (n, channels, steps) = x.dims3()?;
    let hidden = w_hh.dim(1)?;
    let rows = x.transpose(1, 2)?.contiguous()?.reshape((n * steps, channels))?;
    let projected = rows.matmul(&w_ih.t()?)?.broadcast_add(&(b_ih + b_hh)?)?;
    let projected = projected.reshape((n, steps, 4 * hidden))?;
    let recurrent = w_hh.t()?;
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
