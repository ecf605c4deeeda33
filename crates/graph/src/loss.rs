//! Losses, which training minimises.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// A loss between outputs [n, outputs] and targets; always a mean, so that it does not grow with the batch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// `torch.nn.CrossEntropyLoss`: −log softmax of the labelled class, or with values as targets −Σ t·log
    /// softmax (PyTorch's class probabilities; weighted ones need not add up to 1), mean over samples.
    #[default]
    SoftmaxCrossEntropy,
    /// `torch.nn.MultiLabelSoftMarginLoss`: −(t·log σ(x) + (1−t)·log σ(−x)), mean over samples and outputs.
    MultiLabelSoftMargin,
    /// Of ordered classes: output k is the logit of "at least level k", and t is 1 for every level up to the labelled one. The loss
    /// is that of [`Loss::MultiLabelSoftMargin`]; output 0 of an attribute says nothing. The probability of level k is
    /// softmax(x₁ + … + xₖ), the likelihood of its code word (Cheng, Wang and Pollastri, IJCNN 2008).
    CumulativeLogits,
    /// max(0, 1 − s·x) with s = 2t − 1, mean over samples and outputs: `sklearn.metrics.hinge_loss` of each class
    /// against the rest. With an L2 penalty the last linear layer is a linear support vector machine.
    Hinge,
    /// `torch.nn.MSELoss`: (x − t)², mean over samples and outputs.
    MeanSquaredError,
    /// `torch.nn.HuberLoss` with delta 1: (x − t)² / 2 within 1, |x − t| − 1/2 beyond, mean over samples and outputs.
    Huber,
    /// `torch.nn.GaussianNLLLoss` of a mean m and a log variance s for each target: (s + (m − t)² · e^−s) / 2, mean over
    /// samples and targets. A row of outputs is all means, then all log variances, which count as at least ln 1e-4.
    GaussianLikelihood,
    /// Pinball loss (`sklearn.metrics.mean_pinball_loss`) of the [`Loss::QUANTILES`] of each target, mean over samples,
    /// targets and quantiles. A row of outputs is all medians, then all lower, then all upper quantiles.
    Quantiles,
}

impl Loss {
    /// Quantiles that [`Loss::Quantiles`] learns, in the order of the outputs.
    pub const QUANTILES: [f64; 3] = [0.5, 0.05, 0.95];
    /// Least variance that [`Loss::GaussianLikelihood`] counts with.
    pub const LEAST_VARIANCE: f64 = 1e-4;

    /// Returns the number of outputs that learn one target.
    pub fn outputs_per_target(self) -> usize {
        match self {
            Loss::GaussianLikelihood => 2,
            Loss::Quantiles => Self::QUANTILES.len(),
            _ => 1,
        }
    }

    /// Checks whether it compares values, which need not lie between 0 and 1.
    pub fn learns_values(self) -> bool {
        matches!(self, Loss::MeanSquaredError | Loss::Huber | Loss::GaussianLikelihood | Loss::Quantiles)
    }
}

/// The wanted outputs of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Targets<'a> {
    /// One class number per sample, for [`Loss::SoftmaxCrossEntropy`] alone.
    Labels(&'a [u32]),
    /// One value per sample and target, [n, targets] row-major, for every loss; each target has
    /// [`Loss::outputs_per_target`] outputs.
    Values(&'a [f32]),
}

impl<'a> Targets<'a> {
    /// Returns the targets of one of `n` samples.
    pub fn row(&self, row: usize, n: usize) -> Targets<'a> {
        match self {
            Targets::Labels(labels) => Targets::Labels(&labels[row..row + 1]),
            Targets::Values(values) => {
                let each = values.len() / n.max(1);
                Targets::Values(&values[row * each..(row + 1) * each])
            }
        }
    }

    /// Refuses targets that do not suit `loss`, `n` samples and `outputs`; `model` names the network.
    ///
    /// # Errors
    /// Targets of the wrong kind or number, or a label that is no output.
    pub fn check(&self, model: &str, loss: Loss, n: usize, outputs: usize) -> Result<()> {
        let refuse = |reason: String| Err(Error::node(model, reason));
        match (loss, self) {
            (Loss::SoftmaxCrossEntropy, Targets::Labels(labels)) => {
                if labels.len() != n {
                    return refuse(format!("{} labels for a batch of {n} samples", labels.len()));
                }
                match labels.iter().position(|&label| label as usize >= outputs) {
                    Some(i) => {
                        refuse(format!("label {} of sample {i} is not one of {outputs} classes", labels[i]))
                    }
                    None => Ok(()),
                }
            }
            (_, Targets::Values(values)) => {
                let each = loss.outputs_per_target();
                if !outputs.is_multiple_of(each) {
                    return refuse(format!("{outputs} outputs; this loss takes {each} for each target"));
                }
                if values.len() * each != n * outputs {
                    return refuse(format!(
                        "{} target values for {n} samples of {outputs} outputs",
                        values.len()
                    ));
                }
                Ok(())
            }
            (_, Targets::Labels(_)) => refuse("this loss needs target values, not labels".into()),
        }
    }
}
