//! What networks learn: one class per sample, or a level of each of several attributes.

use serde::{Deserialize, Serialize};
use taxel_graph::{Loss, Targets};

use crate::config::{ClassWeights, Train};
use crate::metrics::Levels;

/// One attribute of the samples and the names of its levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attribute {
    /// `elasticity`; `class` where samples have one class each.
    pub name: String,
    /// Names by label.
    pub classes: Vec<String>,
}

/// Labels `[N, attributes]` and what they mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    attributes: Vec<Attribute>,
    values: Vec<u32>,
}

impl Labels {
    /// Labels `[N, attributes]`, row-major.
    pub fn new(attributes: Vec<Attribute>, values: Vec<u32>) -> Self {
        Labels { attributes, values }
    }

    /// The attributes; one of the name `class` where samples have one class each.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }

    /// Sizes of the attributes: their outputs lie one after the other.
    pub fn levels(&self) -> Levels {
        Levels::new(&self.attributes.iter().map(|a| a.classes.len()).collect::<Vec<_>>())
    }

    /// Labels of `rows`, `[rows, attributes]`.
    pub fn of(&self, rows: &[usize]) -> Vec<u32> {
        let width = self.attributes.len();
        rows.iter().flat_map(|&row| &self.values[row * width..(row + 1) * width]).copied().collect()
    }
}

/// A loss with its targets, and how outputs are read.
pub(crate) struct Objective {
    loss: Loss,
    levels: Levels,
    smoothing: f64,
    /// Per class, their mean over the training samples is 1.
    weights: Option<Vec<f64>>,
}

impl Objective {
    /// The objective of `train` on the training samples with labels `seen`.
    pub fn new(train: &Train, levels: Levels, seen: &[u32]) -> Self {
        let outputs = levels.outputs();
        let balanced = || {
            let mut counts = vec![0.0f64; outputs];
            seen.iter().for_each(|&label| counts[label as usize] += 1.0);
            let present = counts.iter().filter(|n| **n > 0.0).count() as f64;
            let weight = |n: &f64| if *n > 0.0 { seen.len() as f64 / (present * n) } else { 0.0 };
            counts.iter().map(weight).collect()
        };
        Objective {
            loss: train.loss,
            smoothing: train.label_smoothing,
            weights: (train.class_weights == ClassWeights::Balanced).then(balanced),
            levels,
        }
    }

    /// Loss of a batch's labels, and the gradients, by `backward`.
    pub fn backward<T>(&self, labels: &[u32], backward: impl FnOnce(Loss, Targets) -> T) -> T {
        let soft = self.smoothing > 0.0 || self.weights.is_some();
        if self.loss == Loss::SoftmaxCrossEntropy && !soft {
            return backward(self.loss, Targets::Labels(labels));
        }
        let mut targets = self.levels.targets(labels);
        if soft {
            self.soften(labels, &mut targets);
        }
        backward(self.loss, Targets::Values(&targets))
    }

    /// `torch.nn.CrossEntropyLoss(weight=.., label_smoothing=..)` as target values: PyTorch divides by the
    /// weights of the batch's labels, the engine by the number of samples.
    fn soften(&self, labels: &[u32], targets: &mut [f32]) {
        let classes = self.levels.outputs();
        let weight = |class: usize| self.weights.as_ref().map_or(1.0, |weights| weights[class]);
        let whole: f64 = labels.iter().map(|&label| weight(label as usize)).sum();
        let share = labels.len() as f64 / whole.max(f64::MIN_POSITIVE);
        for row in targets.chunks_exact_mut(classes) {
            for (class, target) in row.iter_mut().enumerate() {
                let smooth = (1.0 - self.smoothing) * f64::from(*target) + self.smoothing / classes as f64;
                *target = (smooth * weight(class) * share) as f32;
            }
        }
    }

    /// Mean loss of logits `[n, outputs]` in evaluation: without smoothing and weights, so that different
    /// trainings compare.
    pub fn value(&self, logits: &[f32], labels: &[u32]) -> f64 {
        let outputs = self.levels.outputs();
        let targets = self.levels.targets(labels);
        let softplus = |v: f64| v.max(0.0) + (-v.abs()).exp().ln_1p();
        let term = |(row, targets): (&[f32], &[f32])| -> f64 {
            let pairs = || row.iter().zip(targets).map(|(x, t)| (f64::from(*x), f64::from(*t)));
            match self.loss {
                Loss::SoftmaxCrossEntropy => {
                    let most = pairs().map(|(x, _)| x).fold(f64::NEG_INFINITY, f64::max);
                    let sum: f64 = pairs().map(|(x, _)| (x - most).exp()).sum();
                    pairs().map(|(x, t)| t * (sum.ln() + most - x)).sum()
                }
                Loss::MultiLabelSoftMargin => {
                    pairs().map(|(x, t)| softplus(x) - x * t).sum::<f64>() / outputs as f64
                }
                Loss::MeanSquaredError => {
                    pairs().map(|(x, t)| (x - t).powi(2)).sum::<f64>() / outputs as f64
                }
            }
        };
        let rows = logits.chunks_exact(outputs).zip(targets.chunks_exact(outputs));
        rows.map(term).sum::<f64>() / (logits.len() / outputs).max(1) as f64
    }

    /// Number of labels that `outputs` (logits or probabilities) get right.
    pub fn correct(&self, outputs: &[f32], labels: &[u32]) -> usize {
        self.levels.predicted(outputs).iter().zip(labels).filter(|(a, b)| a == b).count()
    }

    /// Logits to probabilities, in place: softmax of one class, a sigmoid per output for several
    /// attributes, and for the squared error the outputs themselves, cut at 0 and 1.
    pub fn probabilities(&self, logits: &mut [f32]) {
        match self.loss {
            Loss::SoftmaxCrossEntropy => crate::metrics::softmax(logits, self.levels.outputs()),
            Loss::MultiLabelSoftMargin => logits.iter_mut().for_each(|v| *v = 1.0 / (1.0 + (-*v).exp())),
            // Not `clamp`, which would hide NaN.
            Loss::MeanSquaredError => logits.iter_mut().for_each(|v| {
                *v = if *v < 0.0 {
                    0.0
                } else if *v > 1.0 {
                    1.0
                } else {
                    *v
                }
            }),
        }
    }
}
