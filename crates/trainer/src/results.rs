//! What a run folder's files say: folds, scores, timings.
//!
//! Everything here except [`Timing`] is a function of config and data alone: equal runs write equal
//! bytes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use taxel_graph::Cost;

use crate::config::{BatchNorm, Protocol, Published};
use crate::error::Result;
use crate::labels::Attribute;
use crate::metrics::{Clusters, Confusion, LevelScores, Levels, LookAlikes, Scores, mean_sd};
use crate::train::{Epoch, Latency};

/// Resamples of a bootstrap interval.
const DRAWS: usize = 2000;

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

impl std::fmt::Display for FoldKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.r{}.f{}", self.network, self.repetition, self.fold)
    }
}

/// One combination of settings and how it did on the validation part; nothing where it diverged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Values by key below `[train]`.
    pub set: BTreeMap<String, toml::Value>,
    /// Mean loss over the validation part.
    pub loss: Option<f64>,
    /// Share of it that was right, in %.
    pub accuracy: Option<f64>,
}

/// What a fold has chosen, and from what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// Values by key below `[train]`.
    pub set: BTreeMap<String, toml::Value>,
    /// Everything that was tried.
    pub trials: Vec<Trial>,
}

/// How far training moved one convolution from the checkpoint that it started from (paper 001, Figs. 3 and 4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// The convolution.
    pub layer: String,
    /// Mean squared difference of the two kernels, each scaled to 0..1.
    pub change: f64,
}

/// How the same weights do with the other kind of batch-norm statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OtherStatistics {
    /// The kind that the experiment does not use.
    pub batch_norm: BatchNorm,
    /// Share of the test samples that is right in %, with several attributes of their levels.
    pub accuracy: f64,
    /// Mean loss over the test samples.
    pub test_loss: f64,
}

/// A finished fold: `folds/<network>.r<repetition>.f<fold>.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoldRecord {
    /// Which fold of which network.
    #[serde(flatten)]
    pub key: FoldKey,
    /// Number of training samples.
    pub train_samples: usize,
    /// Test samples by position in the data set, ascending.
    pub index: Vec<usize>,
    /// Their classes, or with several attributes their levels `[test samples, attributes]`.
    #[serde(rename = "true")]
    pub truth: Vec<u32>,
    /// The classes or levels predicted.
    pub predicted: Vec<u32>,
    /// Probabilities `[test samples, outputs]`, row-major.
    pub probabilities: Vec<f32>,
    /// Mean loss over the test samples.
    pub test_loss: f64,
    /// What the fold has chosen by its validation part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<Chosen>,
    /// The epoch whose weights were tested, with early stopping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best_epoch: Option<usize>,
    /// What it costs, where that depends on the training samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub costs: Option<Costs>,
    /// What training changed, where the network started from a checkpoint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// What the choice of batch-norm statistics does; none without batch norms, where the loss is not
    /// finite, and after early stopping with the population's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_statistics: Option<OtherStatistics>,
    /// What happened in training.
    pub epochs: Vec<Epoch>,
}

impl FoldRecord {
    /// Counts `[true][predicted]` of each attribute.
    ///
    /// # Errors
    /// A damaged record.
    pub fn confusions(&self, levels: &Levels) -> Result<Vec<Confusion>> {
        Ok(levels.scores(&self.truth, &self.predicted)?.into_iter().map(|own| own.confusion).collect())
    }

    /// Accuracy and macro means; with several attributes their means over them.
    ///
    /// # Errors
    /// A damaged record.
    pub fn scores(&self, levels: &Levels) -> Result<Scores> {
        let each: Vec<Scores> =
            levels.scores(&self.truth, &self.predicted)?.into_iter().map(|own| own.scores).collect();
        Ok(mean_scores(&each))
    }
}

fn mean_scores(each: &[Scores]) -> Scores {
    let mean = |i: usize| each.iter().map(|s| s.values()[i]).sum::<f64>() / each.len().max(1) as f64;
    Scores::from_values([0, 1, 2, 3].map(mean))
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
    /// Of these per second.
    pub samples_per_second: f64,
    /// Seconds of testing.
    pub test_seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// Time to encode one sample for this network, in ms.
    pub encoding_ms_per_sample: f64,
    /// Batch 1, one thread; measured once per network, on its first fold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
}

/// Scores of one fold, in %.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoldScores {
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold, from 0.
    pub fold: usize,
    /// Number of training samples.
    pub train_samples: usize,
    /// Number of test samples.
    pub test_samples: usize,
    /// In %.
    #[serde(flatten)]
    pub scores: Scores,
    /// Mean loss over the test samples.
    pub test_loss: f64,
    /// Expected calibration error in 15 bins, 0 to 1; with several attributes the mean over them.
    pub calibration_error: f64,
    /// Brier score, 0 to 2; with several attributes the mean over them.
    pub brier: f64,
}

/// What a network costs for one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

/// One network of `results.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NetworkResults {
    /// Name of the network in the experiment.
    pub network: String,
    /// Name in the zoo, or of the baseline.
    pub zoo: String,
    /// Training samples per class, in a learning curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per_class: Option<usize>,
    /// Where it is published.
    pub paper: String,
    /// Its sizes and settings; what is left out has the default of the zoo.
    pub settings: taxel_zoo::Settings,
    /// Tensors that did not come from the checkpoint that it started from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub made_anew: Vec<String>,
    /// Mean over finished folds of what training changed, where the network started from a checkpoint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Mean over finished folds of what the other kind of batch-norm statistics does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_statistics: Option<OtherStatistics>,
    /// What it costs.
    pub costs: Costs,
    /// Finished folds, in %.
    pub folds: Vec<FoldScores>,
    /// Mean over finished folds, in %.
    pub mean: Option<Scores>,
    /// Sample standard deviation (n - 1) over finished folds, in percentage points.
    pub sd: Option<Scores>,
    /// 95 % bootstrap interval of the accuracy in %: groups are drawn where there are some, samples
    /// elsewhere. None for a single group.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Counts `[true][predicted]` summed over finished folds; none with several attributes.
    pub confusion: Option<Confusion>,
    /// Where mistakes go between the groups of look-alikes that the config names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_alikes: Option<LookAlikes>,
    /// Scores of each of several attributes over all finished folds together, shares in `[0, 1]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<LevelScores>,
    /// What its authors report on their own data, in %.
    pub published: Option<Published>,
}

/// `results.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Name of the experiment.
    pub name: String,
    /// One line for tables and reports.
    pub title: Option<String>,
    /// Whether every fold is in it.
    pub complete: bool,
    /// The folds that are not.
    pub missing: Vec<FoldKey>,
    /// What the scores were measured on: `simulated: ..` or `real: ..`.
    pub source: String,
    /// BLAKE3 of the samples.
    pub data_digest: String,
    /// Number of samples.
    pub samples: usize,
    /// Shape of one sample.
    pub sample_shape: Vec<usize>,
    /// Class names by label.
    pub classes: Vec<String>,
    /// The attributes and their levels, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<Attribute>,
    /// How samples were divided.
    pub protocol: Protocol,
    /// Folds of one repetition.
    pub folds: usize,
    /// Baselines that were left out, and why.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<String, String>,
    /// Real recordings that a few global statistics tell apart: part of every score may not be touch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortcut: Option<taxel_data::Shortcut>,
    /// Seed of the experiment.
    pub seed: u64,
    /// Always `percent`: of `folds`, `mean`, `sd` and `published`.
    pub unit: String,
    /// In the order of the config.
    pub networks: Vec<NetworkResults>,
}

/// What scores need to know about the data besides the predictions.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// Outputs of each attribute.
    pub levels: Levels,
    /// What is drawn as one by the bootstrap, per sample of the data set.
    pub clusters: Vec<u32>,
    /// Groups of look-alikes with their classes.
    pub look_alikes: Vec<(String, Vec<usize>)>,
    /// Seed of the bootstrap.
    pub seed: u64,
}

fn mean_changes(records: &[&FoldRecord]) -> Vec<Change> {
    let Some(first) = records.first() else { return vec![] };
    let mean = |(i, change): (usize, &Change)| {
        let sum: f64 = records.iter().filter_map(|r| r.changes.get(i)).map(|own| own.change).sum();
        Change { layer: change.layer.clone(), change: sum / records.len() as f64 }
    };
    first.changes.iter().enumerate().map(mean).collect()
}

/// None unless every fold has it.
fn mean_other(records: &[&FoldRecord]) -> Option<OtherStatistics> {
    let own: Vec<OtherStatistics> = records.iter().map(|r| r.other_statistics).collect::<Option<_>>()?;
    let mean = |value: fn(&OtherStatistics) -> f64| own.iter().map(value).sum::<f64>() / own.len() as f64;
    let batch_norm = own.first()?.batch_norm;
    Some(OtherStatistics { batch_norm, accuracy: mean(|o| o.accuracy), test_loss: mean(|o| o.test_loss) })
}

impl NetworkResults {
    /// Puts the finished folds and all that follows from them in.
    pub(crate) fn fill(&mut self, records: &[&FoldRecord], frame: &Frame) -> Result<()> {
        let levels = &frame.levels;
        let width = levels.sizes().len().max(1);
        self.folds.clear();
        let mut sums: Vec<Confusion> = vec![];
        let (mut right, mut clusters) = (vec![], vec![]);
        for record in records {
            let confusions = record.confusions(levels)?;
            let (calibration_error, brier) = levels.calibration(&record.probabilities, &record.truth)?;
            self.folds.push(FoldScores {
                repetition: record.key.repetition,
                fold: record.key.fold,
                train_samples: record.train_samples,
                test_samples: record.index.len(),
                scores: record.scores(levels)?.percent(),
                test_loss: record.test_loss,
                calibration_error,
                brier,
            });
            match sums.is_empty() {
                true => sums = confusions,
                false => sums.iter_mut().zip(&confusions).for_each(|(sum, own)| sum.add(own)),
            }
            for (i, (truth, predicted)) in record.truth.iter().zip(&record.predicted).enumerate() {
                right.push(f64::from(u8::from(truth == predicted)));
                clusters.push(record.index.get(i / width).and_then(|&row| frame.clusters.get(row)).copied());
            }
        }
        // The most that any fold needs.
        let costs = records.iter().filter_map(|record| record.costs);
        if let Some(most) = costs.max_by_key(|costs| (costs.macs, costs.parameters)) {
            self.costs = most;
        }
        self.changes = mean_changes(records);
        self.other_statistics = mean_other(records);
        let clusters: Vec<u32> = clusters.into_iter().flatten().collect();
        let drawn = Clusters::new(&right, &clusters);
        self.interval = (drawn.len() > 1 && right.len() == clusters.len()).then(|| {
            let (low, high) = drawn.interval(0.95, DRAWS, frame.seed, &self.network);
            [100.0 * low, 100.0 * high]
        });
        (self.confusion, self.look_alikes, self.attributes) = (None, None, vec![]);
        match sums.as_slice() {
            [] => {}
            [one] => {
                if !frame.look_alikes.is_empty() {
                    self.look_alikes = Some(one.look_alikes(&frame.look_alikes)?);
                }
                self.confusion = Some(one.clone());
            }
            _ => self.attributes = sums.into_iter().map(LevelScores::of).collect(),
        }
        let column = |i: usize| self.folds.iter().map(|f| f.scores.values()[i]).collect::<Vec<_>>();
        let summary = [0, 1, 2, 3].map(|i| mean_sd(&column(i)));
        self.mean = (!self.folds.is_empty()).then(|| Scores::from_values(summary.map(|(mean, _)| mean)));
        self.sd = match summary {
            [(_, Some(a)), (_, Some(p)), (_, Some(r)), (_, Some(f))] => {
                Some(Scores::from_values([a, p, r, f]))
            }
            _ => None,
        };
        Ok(())
    }
}
