//! Losses, which training minimises.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// A loss between outputs [n, outputs] and targets; always a mean, so that it does not grow with the batch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// `torch.nn.CrossEntropyLoss`: −log softmax of the labelled class, or with values as targets −Σ t·log
    /// softmax (PyTorch's class probabilities; weighted ones need not add up to 1), mean over samples.
    #[default]
    SoftmaxCrossEntropy,
    /// `torch.nn.MultiLabelSoftMarginLoss`: −(t·log σ(x) + (1−t)·log σ(−x)), mean over samples and outputs.
    MultiLabelSoftMargin,
    /// max(0, 1 − s·x) with s = 2t − 1, mean over samples and outputs: `sklearn.metrics.hinge_loss` of each class
    /// against the rest. With an L2 penalty the last linear layer is a linear support vector machine.
    Hinge,
    /// `torch.nn.MSELoss`: (x − t)², mean over samples and outputs.
    MeanSquaredError,
}

/// The wanted outputs of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Targets<'a> {
    /// One class number per sample, for [`Loss::SoftmaxCrossEntropy`] alone.
    Labels(&'a [u32]),
    /// One value per sample and output, [n, outputs] row-major, for every loss.
    Values(&'a [f32]),
}

impl Targets<'_> {
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
                if values.len() != n * outputs {
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
