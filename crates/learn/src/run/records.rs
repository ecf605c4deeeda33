//! Records of every fold: predictions, epochs, times.
//!
//! Everything here except [`Timing`] is a function of settings and data alone: equal runs write equal bytes.

use serde::{Deserialize, Serialize};
use taxel_data::{Dataset, Fold, Task};
use taxel_graph::{Cost, Graph, Weights};

use crate::error::Result;
use crate::estimator::search::Chosen;
use crate::latency::Latency;
use crate::metrics::{self, Confusion, Levels, Outcome, Scores};
use crate::training::epoch::Epoch;
use crate::training::recipe::BatchNorm;

/// Which fold of which network.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct FoldKey {
    /// Name of the network in the experiment.
    pub network: String,
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold, from 0.
    pub fold: usize,
}

impl FoldKey {
    /// Returns every fold of every network, in the order in which they are run.
    pub(crate) fn all<'a>(
        networks: impl Iterator<Item = &'a str>,
        repetitions: usize,
        folds: usize,
    ) -> Vec<FoldKey> {
        let mut keys = vec![];
        for network in networks {
            for repetition in 0..repetitions {
                keys.extend((0..folds).map(|fold| FoldKey { network: network.into(), repetition, fold }));
            }
        }
        keys
    }

    /// Checks whether `part` is one or several whole parts of its name `mlp.r0.f1`: the row `mlp`, the repetition
    /// `r0`, or `mlp.r0`.
    pub fn is_within(&self, part: &str) -> bool {
        format!(".{self}.").contains(&format!(".{part}."))
    }
}

impl std::fmt::Display for FoldKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.r{}.f{}", self.network, self.repetition, self.fold)
    }
}

/// How far training moved one convolution from the checkpoint that it started from (Rouhafzay et al. 2021, Figs. 3 and
/// 4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// The convolution.
    pub layer: String,
    /// Mean squared difference of the two kernels, each scaled to 0..1.
    pub change: f64,
}

impl Change {
    /// Computes how far training moved each convolution of `graph`.
    pub(crate) fn all(graph: &Graph, start: &Weights, trained: &Weights) -> Result<Vec<Self>> {
        let mut before = trained.clone();
        before.start_from(graph, start, false)?;
        let changes = before.changes(trained, graph)?;
        Ok(changes.into_iter().map(|(layer, change)| Change { layer, change }).collect())
    }
}

/// How the same weights do with the other kind of batch-norm statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OtherStatistics {
    /// The kind that the experiment does not use.
    pub batch_norm: BatchNorm,
    /// The primary metric on the test samples, in its unit.
    #[serde(alias = "accuracy")]
    pub score: f64,
    /// Mean loss over the test samples.
    pub test_loss: f64,
}

/// A finished fold: `folds/<network>.r<repetition>.f<fold>.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoldRecord {
    /// Which fold of which network.
    #[serde(flatten)]
    pub key: FoldKey,
    /// BLAKE3 of the samples; none in folders of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<String>,
    /// Digest of the [facts](taxel_data::Facts) about the samples; none in folders of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<String>,
    /// Digest of the network and the weights that it started from; none of a baseline.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub network_digest: Option<String>,
    /// Digest of the model that the fold wrote, which stands last in the card of its file; none in memory and in
    /// folders of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Number of training samples.
    pub train_samples: usize,
    /// Test samples by position in the data set, ascending.
    pub index: Vec<usize>,
    /// Their true targets beside what was predicted.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// Mean loss over the test samples.
    pub test_loss: f64,
    /// Whether the training diverged: the weights that were tested had a training loss above ten times that of
    /// outputs that are all 0 (ln(classes) for the cross-entropy).
    #[serde(default, skip_serializing_if = "crate::json_file::is_default")]
    pub diverged: bool,
    /// The choice of the fold by its validation part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<Chosen>,
    /// The epoch whose weights were tested, with early stopping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best_epoch: Option<usize>,
    /// Its costs, where they depend on the training samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub costs: Option<Costs>,
    /// Changes of the convolutions, where the network started from a checkpoint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Scores with the other kind of batch-norm statistics; none without batch norms, where the loss is not finite, and
    /// after early stopping with recomputed statistics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_statistics: Option<OtherStatistics>,
    /// The epochs of the training.
    pub epochs: Vec<Epoch>,
}

impl FoldRecord {
    /// Takes the outputs of a model for the test part of a fold, and nothing else yet.
    pub(crate) fn of(
        key: &FoldKey,
        dataset: &Dataset,
        fold: &Fold,
        outputs: Vec<f32>,
        test_loss: f64,
    ) -> Self {
        let outcome =
            Outcome::new(&dataset.targets, &fold.test, outputs).with_training(&dataset.targets, &fold.train);
        FoldRecord {
            data: Some(dataset.digest.clone()),
            facts: Some(dataset.facts().digest()),
            test_loss,
            ..FoldRecord::of_predictions(key.clone(), fold.train.len(), fold.test.clone(), outcome)
        }
    }

    /// Takes the predictions `outcome` for the samples at `index`, by a model that was trained on `train_samples`; nothing else is
    /// known.
    pub fn of_predictions(key: FoldKey, train_samples: usize, index: Vec<usize>, outcome: Outcome) -> Self {
        FoldRecord {
            key,
            data: None,
            facts: None,
            network_digest: None,
            model: None,
            train_samples,
            index,
            outcome,
            test_loss: 0.0,
            diverged: false,
            chosen: None,
            best_epoch: None,
            costs: None,
            changes: vec![],
            other_statistics: None,
            epochs: vec![],
        }
    }

    /// Returns the counts `[true][predicted]` of each attribute; none of values.
    ///
    /// # Errors
    /// A damaged record.
    pub fn confusions(&self, task: &Task) -> Result<Vec<Confusion>> {
        let (truth, predicted) = self.outcome.labels();
        let each = Levels::of_task(task).scores(truth, predicted)?;
        Ok(each.into_iter().map(|scores| scores.confusion).collect())
    }

    /// Returns the metrics of the task, in their units.
    ///
    /// # Errors
    /// A damaged record.
    pub fn scores(&self, task: &Task) -> Result<Scores> {
        metrics::scores(task, &self.outcome)
    }
}

/// How long a fold took; `folds/<..>.timing.json` and a line of `timings.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Which fold of which network.
    #[serde(flatten)]
    pub key: FoldKey,
    /// Seconds of training, batch-norm statistics included.
    pub train_seconds: f64,
    /// Training samples times epochs.
    pub samples: u64,
    /// Seconds of testing.
    pub test_seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// Time to encode one sample for this network, in ms.
    pub encoding_ms_per_sample: f64,
    /// From the raw sample to the answer, batch 1, one thread; measured once per network, on its first fold.
    #[serde(rename = "whole_latency", skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
    /// The latency of older versions: networks without their encoding, baselines with it.
    #[serde(rename = "latency", skip_serializing)]
    pub latency_without_encoding: Option<Latency>,
}

/// Costs of one sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Costs {
    /// Trained values.
    pub parameters: u64,
    /// Bytes of parameters and batch-norm statistics in f32.
    pub bytes: u64,
    /// Multiply-accumulates.
    pub macs: u64,
    /// 2 per multiply-accumulate, 1 per bias addition.
    pub flops: u64,
}

impl From<Cost> for Costs {
    fn from(cost: Cost) -> Self {
        Costs { parameters: cost.parameters, bytes: cost.bytes(), macs: cost.macs, flops: cost.flops }
    }
}

impl Timing {
    /// Checks whether this is the fold of its network whose predictions are timed.
    pub fn is_timed(&self) -> bool {
        self.latency.is_some() || self.latency_without_encoding.is_some()
    }

    /// Computes training samples times epochs per second.
    pub fn samples_per_second(&self) -> f64 {
        self.samples as f64 / self.train_seconds.max(1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fold_is_within_whole_parts_of_its_name() {
        let key = FoldKey { network: "mlp.n10".into(), repetition: 1, fold: 12 };
        for part in ["mlp", "mlp.n10", "n10", "r1", "f12", "mlp.n10.r1", "mlp.n10.r1.f12"] {
            assert!(key.is_within(part), "{part}");
        }
        for part in ["", "m", "n1", "r", "f1", "mlp.r1", "r12", "mlp.n10.r1.f12.x"] {
            assert!(!key.is_within(part), "{part}");
        }
    }
}
