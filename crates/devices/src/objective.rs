//! Losses of a batch.

use candle_core::{D, Result, Tensor};
use candle_nn::ops::log_softmax;
use taxel_graph::{Loss, Targets};

/// Computes `loss` between `outputs` [n, outputs] and targets that [`Targets::check`] let pass.
pub(crate) fn mean_loss(outputs: &Tensor, loss: Loss, targets: Targets) -> Result<Tensor> {
    let device = outputs.device();
    match targets {
        Targets::Labels(labels) => {
            let labels = Tensor::from_slice(labels, labels.len(), device)?;
            candle_nn::loss::cross_entropy(outputs, &labels)
        }
        Targets::Values(values) => {
            let (samples, width) = outputs.dims2()?;
            let width = width / loss.outputs_per_target();
            let targets = Tensor::from_slice(values, (samples, width), device)?;
            match loss {
                Loss::SoftmaxCrossEntropy => {
                    (targets * log_softmax(outputs, D::Minus1)?)?.sum(D::Minus1)?.mean_all()?.neg()
                }
                Loss::MultiLabelSoftMargin | Loss::CumulativeLogits => {
                    multi_label_soft_margin(outputs, &targets)
                }
                Loss::Hinge => {
                    let sides = targets.affine(2.0, -1.0)?;
                    (outputs * sides)?.affine(-1.0, 1.0)?.relu()?.mean_all()
                }
                Loss::MeanSquaredError => (outputs - targets)?.sqr()?.mean_all(),
                Loss::Huber => huber(&(outputs - targets)?),
                Loss::GaussianLikelihood => {
                    let mean = outputs.narrow(1, 0, width)?;
                    let log = outputs.narrow(1, width, width)?.maximum(Loss::LEAST_VARIANCE.ln())?;
                    let scaled = ((mean - targets)?.sqr()? * log.neg()?.exp()?)?;
                    (log + scaled)?.mean_all()? * 0.5
                }
                Loss::Quantiles => {
                    let of_one = |(at, quantile): (usize, &f64)| {
                        let missing = (&targets - outputs.narrow(1, at * width, width)?)?;
                        (&missing * *quantile)? + missing.neg()?.relu()?
                    };
                    let each = Loss::QUANTILES.iter().enumerate().map(of_one).collect::<Result<Vec<_>>>()?;
                    Tensor::cat(&each, 1)?.mean_all()
                }
            }
        }
    }
}

/// Takes the error within ±1 and what is beyond apart: e²/2 of the one, the amount of the other.
fn huber(error: &Tensor) -> Result<Tensor> {
    let (above, below) = ((error - 1.0)?.relu()?, (error.neg()? - 1.0)?.relu()?);
    let within = ((error - &above)? + &below)?;
    (((within.sqr()? * 0.5)? + above)? + below)?.mean_all()
}

/// Takes log σ(x) and log σ(−x) as one log softmax over (x, 0): no overflow, and a gradient that candle gets right,
/// which those of |x| and max(x, 0) at 0 are not.
fn multi_label_soft_margin(outputs: &Tensor, targets: &Tensor) -> Result<Tensor> {
    let pair = Tensor::stack(&[outputs, &outputs.zeros_like()?], D::Minus1)?;
    let pair = log_softmax(&pair, D::Minus1)?;
    let likelihood = (pair * Tensor::stack(&[targets, &(1.0 - targets)?], D::Minus1)?)?;
    likelihood.sum(D::Minus1)?.mean_all()?.neg()
}
