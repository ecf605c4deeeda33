//! The objective of a training on values, which a network learns scaled.

use taxel_data::{Dataset, Targets as DatasetTargets, Values};
use taxel_graph::{Graph, Loss, Targets, Weights};

use crate::error::Result;
use crate::metrics::{Outcome, spread};
use crate::training::objective::{Backward, Objective, Taught};

/// A loss with values as its targets.
///
/// A network learns each quantity less its mean over the training samples, in its standard deviations: losses of quantities in
/// different units then count alike. The weights of the model have this taken back.
pub(crate) struct ValueObjective<'d> {
    loss: Loss,
    targets: &'d DatasetTargets,
    values: &'d Values,
    /// Mean and standard deviation of each quantity; 1 where all values are equal.
    scale: Vec<(f64, f64)>,
    /// The share of the network's first output that answers.
    share: f64,
}

impl<'d> ValueObjective<'d> {
    /// Makes the objective on the training samples `rows`.
    pub fn new(loss: Loss, graph: &Graph, dataset: &'d Dataset, values: &'d Values, rows: &[usize]) -> Self {
        let (seen, width) = (values.of(rows), values.quantities().len());
        let weights = dataset.weights_over(rows);
        let weight = |row: usize| weights.as_ref().map_or(1.0, |weights| f64::from(weights[rows[row]]));
        let of_quantity = |at: usize| {
            let column: Vec<f64> = seen.iter().skip(at).step_by(width).map(|v| f64::from(*v)).collect();
            let (mean, sd) = weighted_mean_sd(&column, weight);
            (mean, sd.filter(|sd| *sd > 0.0).unwrap_or(1.0))
        };
        let scale = (0..width).map(of_quantity).collect();
        ValueObjective { loss, targets: &dataset.targets, values, scale, share: graph.answering_share() }
    }

    /// Returns what each output of a network is multiplied by and moved by to be in its unit.
    fn unit(&self) -> (Vec<f64>, Vec<f64>) {
        let quantities = self.scale.len();
        let of_output = |at: usize| {
            let (mean, sd) = self.scale[at % quantities];
            if self.loss == Loss::GaussianLikelihood && at >= quantities {
                return (self.share, 2.0 * sd.ln());
            }
            (sd * self.share, mean)
        };
        (0..quantities * self.loss.outputs_per_target()).map(of_output).unzip()
    }

    /// Returns the targets `[rows, quantities]` as the network learns them.
    fn scaled(&self, mut values: Vec<f32>) -> Vec<f32> {
        for row in values.chunks_exact_mut(self.scale.len()) {
            for (value, (mean, sd)) in row.iter_mut().zip(&self.scale) {
                *value = ((f64::from(*value) - mean) / sd) as f32;
            }
        }
        values
    }

    /// Computes the loss of one sample: the scaled outputs of its quantities, and their scaled targets.
    fn term(&self, outputs: &[f64], targets: &[f32]) -> f64 {
        let width = targets.len();
        let each = targets.iter().enumerate().map(|(at, target)| {
            let error = outputs[at] - f64::from(*target);
            match self.loss {
                Loss::Huber if error.abs() > 1.0 => error.abs() - 0.5,
                Loss::Huber => 0.5 * error * error,
                Loss::GaussianLikelihood => {
                    let log = outputs[width + at].max(Loss::LEAST_VARIANCE.ln());
                    0.5 * (log + error * error * (-log).exp())
                }
                Loss::Quantiles => {
                    let quantiles = Loss::QUANTILES.iter().enumerate();
                    let missing = quantiles.map(|(place, quantile)| {
                        let missing = f64::from(*target) - outputs[place * width + at];
                        if missing < 0.0 { (quantile - 1.0) * missing } else { quantile * missing }
                    });
                    missing.sum::<f64>() / Loss::QUANTILES.len() as f64
                }
                _ => error * error,
            }
        });
        each.sum::<f64>() / width as f64
    }

    /// Returns the first value of each quantity of rows of outputs.
    fn first(&self, outputs: Vec<f32>) -> Vec<f32> {
        let (quantities, each) = (self.scale.len(), self.scale.len() * self.loss.outputs_per_target());
        if each == quantities {
            return outputs;
        }
        outputs.chunks_exact(each).flat_map(|row| &row[..quantities]).copied().collect()
    }
}

/// Computes mean and standard deviation of values whose weights are 1 on average; no deviation of a single value.
fn weighted_mean_sd(values: &[f64], weight: impl Fn(usize) -> f64) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().enumerate().map(|(row, value)| weight(row) * value).sum::<f64>() / n;
    let squares = values.iter().enumerate().map(|(row, value)| weight(row) * (value - mean).powi(2));
    (mean, (values.len() > 1).then(|| (squares.sum::<f64>() / (n - 1.0)).sqrt()))
}

impl Objective for ValueObjective<'_> {
    fn backward(&self, rows: &[usize], taught: Taught, backward: Backward) -> taxel_engine::Result<f32> {
        let mut targets = self.values.of(rows);
        if let Some(teacher) = taught {
            teacher.teach(rows, &mut targets);
        }
        backward(self.loss, Targets::Values(&self.scaled(targets)))
    }

    fn loss(&self, outputs: &[f32], rows: &[usize]) -> f64 {
        let targets = self.scaled(self.values.of(rows));
        let each = self.scale.len() * self.loss.outputs_per_target();
        let pairs = outputs.chunks_exact(each).zip(targets.chunks_exact(self.scale.len()));
        let of_row = |(outputs, targets): (&[f32], &[f32])| {
            let outputs: Vec<f64> = outputs.iter().map(|v| f64::from(*v) * self.share).collect();
            self.term(&outputs, targets)
        };
        pairs.map(of_row).sum::<f64>() / rows.len().max(1) as f64
    }

    /// Computes the loss of predicting the mean: that of a target that lies one standard deviation away.
    fn idle(&self) -> f64 {
        let width = self.scale.len();
        self.term(&vec![0.0; width * self.loss.outputs_per_target()], &vec![1.0; width])
    }

    fn score(&self, outputs: &[f32], rows: &[usize]) -> (f64, usize) {
        let answers = self.answers(outputs.to_vec());
        let errors = answers.iter().zip(self.values.of(rows)).map(|(a, b)| f64::from((a - b).abs()));
        (errors.sum::<f64>() / self.scale.len() as f64, rows.len())
    }

    fn answers(&self, outputs: Vec<f32>) -> Vec<f32> {
        let (scale, shift) = self.unit();
        let mut answers = self.first(outputs);
        for row in answers.chunks_exact_mut(self.scale.len()) {
            for (at, value) in row.iter_mut().enumerate() {
                *value = (f64::from(*value) * scale[at] + shift[at]) as f32;
            }
        }
        answers
    }

    fn finished(&self, graph: &Graph, weights: Weights) -> Result<Weights> {
        let (scale, shift) = self.unit();
        Ok(graph.rescaled(&weights, &scale, &shift).map_err(taxel_engine::Error::from)?)
    }

    fn begun(&self, graph: &Graph, weights: Weights) -> Result<Weights> {
        let (scale, shift) = self.unit();
        let back: Vec<f64> = scale.iter().map(|scale| 1.0 / scale).collect();
        let moved: Vec<f64> = shift.iter().zip(&back).map(|(shift, back)| -shift * back).collect();
        Ok(graph.rescaled(&weights, &back, &moved).map_err(taxel_engine::Error::from)?)
    }

    fn answers_of_model(&self, outputs: Vec<f32>) -> Vec<f32> {
        self.first(outputs)
    }

    fn spread_of_model(&self, outputs: &[f32]) -> Vec<f32> {
        spread(self.loss, outputs, self.scale.len())
    }

    fn test_loss(&self, outputs: &[f32], rows: &[usize]) -> Result<f64> {
        let answers = self.first(outputs.to_vec());
        Outcome::new(self.targets, rows, answers).loss(&self.targets.task())
    }
}
