//! What a run folder's files say: folds, scores, timings.
//!
//! Everything here except [`Timing`] is a function of config and data alone: equal runs write equal
//! bytes.

use serde::{Deserialize, Serialize};
use taxel_graph::Cost;

use crate::config::{Protocol, Published};
use crate::error::Result;
use crate::metrics::{Confusion, Scores, mean_sd};
use crate::train::{Epoch, Latency};

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
    /// Their classes.
    #[serde(rename = "true")]
    pub truth: Vec<u32>,
    /// The classes predicted.
    pub predicted: Vec<u32>,
    /// Probabilities `[test samples, classes]`, row-major.
    pub probabilities: Vec<f32>,
    /// What happened in training.
    pub epochs: Vec<Epoch>,
}

impl FoldRecord {
    /// Counts `[true][predicted]`.
    ///
    /// # Errors
    /// A damaged record.
    pub fn confusion(&self, classes: usize) -> Result<Confusion> {
        Confusion::new(&self.truth, &self.predicted, classes)
    }

    /// Mean cross-entropy over the test samples.
    pub fn test_loss(&self) -> f64 {
        let classes = self.probabilities.len() / self.truth.len().max(1);
        let of = |(row, &label): (&[f32], &u32)| {
            // A probability that rounds to 0 would be an infinite loss, which JSON cannot hold.
            -row.get(label as usize).map_or(0.0, |p| f64::from(p.max(f32::MIN_POSITIVE)).ln())
        };
        let sum: f64 = self.probabilities.chunks(classes.max(1)).zip(&self.truth).map(of).sum();
        sum / self.truth.len().max(1) as f64
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
    /// Mean cross-entropy over the test samples.
    pub test_loss: f64,
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
    /// Name in the zoo.
    pub zoo: String,
    /// Where it is published.
    pub paper: String,
    /// Its sizes and settings; what is left out has the default of the zoo.
    pub settings: taxel_zoo::Settings,
    /// What it costs.
    pub costs: Costs,
    /// Finished folds, in %.
    pub folds: Vec<FoldScores>,
    /// Mean over finished folds, in %.
    pub mean: Option<Scores>,
    /// Sample standard deviation (n - 1) over finished folds, in percentage points.
    pub sd: Option<Scores>,
    /// Counts `[true][predicted]` summed over finished folds.
    pub confusion: Option<Confusion>,
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
    /// How samples were divided.
    pub protocol: Protocol,
    /// Seed of the experiment.
    pub seed: u64,
    /// Always `percent`: of `folds`, `mean`, `sd` and `published`.
    pub unit: String,
    /// In the order of the config.
    pub networks: Vec<NetworkResults>,
}

impl NetworkResults {
    /// Puts the finished folds and all that follows from them in.
    pub(crate) fn fill(&mut self, records: &[&FoldRecord], classes: usize) -> Result<()> {
        self.folds.clear();
        self.confusion = None;
        for record in records {
            let confusion = record.confusion(classes)?;
            self.folds.push(FoldScores {
                repetition: record.key.repetition,
                fold: record.key.fold,
                train_samples: record.train_samples,
                test_samples: record.index.len(),
                scores: confusion.scores().percent(),
                test_loss: record.test_loss(),
            });
            match &mut self.confusion {
                Some(sum) => sum.add(&confusion),
                none => *none = Some(confusion),
            }
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
