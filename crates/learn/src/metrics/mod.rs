//! Scores of predictions, with scikit-learn's meaning.
//!
//! [`metrics`] is the table of each task, the primary metric first; an [`Outcome`] is what they judge, and [`Scores`]
//! hold their values by name. [`Confusion`] counts; [`brier`], [`calibration_error`] and [`log_loss`] judge
//! probabilities; [`Levels`] scores ordered attributes; [`MeanEstimate`] gives intervals of means. Precision, recall and
//! F1 are macro means over the classes that occur among the true or the predicted labels, as `average="macro",
//! zero_division=0` computes them: a class that is never predicted has precision 0, one that never occurs has recall 0.
//! A class that a training part does not have is left out of the means of its fold.
//!
//! ```
//! use taxel_learn::metrics::{Confusion, mean_sd};
//!
//! let confusion = Confusion::new(&[0, 0, 1, 2], &[0, 1, 1, 2], 3)?;
//! assert_eq!(confusion.scores().accuracy, 0.75);
//! assert_eq!(mean_sd(&[1.0, 2.0, 3.0]), (2.0, Some(1.0)));
//! # Ok::<(), taxel_learn::Error>(())
//! ```

mod bootstrap;
mod detections;
mod interval;
mod levels;
mod outcome;
mod probabilities;
mod ranking;
mod scores;
mod spread;
mod table;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

pub use bootstrap::{Clusters, bootstrap, central, quantile};
pub use detections::Detections;
pub(crate) use interval::wilson;
pub use interval::{FEW_GROUPS, MeanEstimate, Terms, t_quantile};
pub(crate) use levels::each_attribute;
pub use levels::{LevelScores, Levels};
pub use outcome::Outcome;
pub use ranking::{average_precision, roc_area};
pub use scores::Scores;
pub use spread::{around, spread};
pub(crate) use table::metric_names;
pub use table::{Direction, Metric, MetricUnit, metrics, scores, shown};
pub use taxel_baselines::softmax;

pub use probabilities::{BINS, brier, calibration_error, log_loss};

/// Precision, recall and F1 of one class, each in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ClassScores {
    /// Of the samples predicted as the class, the share that belong to it; 0 without any.
    pub precision: f64,
    /// Of the samples of the class, the share predicted as it; 0 without any.
    pub recall: f64,
    /// Harmonic mean of the two; 0 where neither exists.
    pub f1: f64,
    /// Samples of the class.
    pub support: u64,
}

/// Where mistakes go when classes come in groups of look-alikes (Pastor et al. 2019, section 5: the errors of
/// TactNet3D stay inside a subset).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LookAlikes {
    /// Names of the groups.
    pub groups: Vec<String>,
    /// Counts `[true group][predicted group]`.
    pub confusion: Confusion,
    /// Wrong predictions.
    pub errors: u64,
    /// Of these, the share whose prediction is of the true class's group; none without errors.
    pub within_group: Option<f64>,
}

/// Counts `[true][predicted]`: as many columns as rows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Vec<u64>>", into = "Vec<Vec<u64>>")]
pub struct Confusion {
    counts: Vec<Vec<u64>>,
}

impl TryFrom<Vec<Vec<u64>>> for Confusion {
    type Error = String;

    fn try_from(counts: Vec<Vec<u64>>) -> std::result::Result<Self, String> {
        let classes = counts.len();
        if let Some(row) = counts.iter().find(|row| row.len() != classes) {
            return Err(format!("a confusion of {classes} true classes has a row of {}", row.len()));
        }
        let total = counts.iter().flatten().try_fold(0u64, |sum, count| sum.checked_add(*count));
        if total.is_some_and(|total| total <= u64::from(u32::MAX)) {
            Ok(Confusion { counts })
        } else {
            Err("a confusion counts more samples than there can be".into())
        }
    }
}

impl From<Confusion> for Vec<Vec<u64>> {
    fn from(confusion: Confusion) -> Self {
        confusion.counts
    }
}

/// Accuracy and macro means of one attribute, each in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MacroScores {
    /// Share of correct predictions.
    pub accuracy: f64,
    /// Of the samples predicted as a class, the share that belong to it.
    pub precision: f64,
    /// Of the samples of a class, the share predicted as it.
    pub recall: f64,
    /// Harmonic mean of the two, per class.
    pub f1: f64,
}

impl Confusion {
    /// Counts `predicted` against `truth`, labels `0..classes`.
    ///
    /// # Errors
    /// No or unequally many labels, or a label of `classes` and above.
    pub fn new(truth: &[u32], predicted: &[u32], classes: usize) -> Result<Self> {
        let refuse = |what, reason| Err(Error::Metrics { what, reason });
        if truth.is_empty() || truth.len() != predicted.len() {
            let reason = format!("{} for {} true ones; one each is needed", predicted.len(), truth.len());
            return refuse("predicted labels", reason);
        }
        let mut counts = vec![vec![0; classes]; classes];
        for (&t, &p) in truth.iter().zip(predicted) {
            match counts.get_mut(t as usize).and_then(|row| row.get_mut(p as usize)) {
                Some(count) => *count += 1,
                None => return refuse("labels", format!("true {t}, predicted {p} of {classes} classes")),
            }
        }
        Ok(Confusion { counts })
    }

    /// Counts `[true][predicted]`.
    pub fn counts(&self) -> &[Vec<u64>] {
        &self.counts
    }

    /// Adds the counts of another set of predictions over the same classes.
    pub fn add(&mut self, other: &Confusion) {
        for (row, others) in self.counts.iter_mut().zip(&other.counts) {
            row.iter_mut().zip(others).for_each(|(count, other)| *count += other);
        }
    }

    /// Computes precision, recall and F1 of every class (scikit-learn: `average=None, zero_division=0`).
    pub fn per_class(&self) -> Vec<ClassScores> {
        let of = |part: u64, whole: u64| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
        let class = |class: usize| {
            let hits = self.counts[class][class];
            let support: u64 = self.counts[class].iter().sum();
            let predicted: u64 = self.counts.iter().map(|row| row[class]).sum();
            ClassScores {
                precision: of(hits, predicted),
                recall: of(hits, support),
                f1: of(2 * hits, support + predicted),
                support,
            }
        };
        (0..self.counts.len()).map(class).collect()
    }

    /// Computes accuracy and macro precision, recall and F1; all 0 without predictions.
    pub fn scores(&self) -> MacroScores {
        self.scores_without(&[])
    }

    /// Computes what [`Confusion::scores`] does, with classes that were not trained left out of the macro means: a certain 0
    /// of theirs says nothing about the network. Accuracy counts their samples as wrong.
    pub fn scores_without(&self, untrained: &[u32]) -> MacroScores {
        let total: u64 = self.counts.iter().flatten().sum();
        let correct: u64 = self.counts.iter().enumerate().map(|(class, row)| row[class]).sum();
        let occurs = |class: usize| {
            self.counts[class].iter().any(|n| *n > 0) || self.counts.iter().any(|row| row[class] > 0)
        };
        let classes = self.per_class();
        let counts = |class: usize| occurs(class) && !untrained.iter().any(|other| *other as usize == class);
        let seen: Vec<ClassScores> =
            classes.iter().enumerate().filter(|(class, _)| counts(*class)).map(|(_, s)| *s).collect();
        let mean = |score: fn(&ClassScores) -> f64| match seen.len() {
            0 => 0.0,
            n => seen.iter().map(score).sum::<f64>() / n as f64,
        };
        MacroScores {
            accuracy: if total == 0 { 0.0 } else { correct as f64 / total as f64 },
            precision: mean(|s| s.precision),
            recall: mean(|s| s.recall),
            f1: mean(|s| s.f1),
        }
    }

    /// Counts where mistakes go between `groups`: names with the classes that are in them, each class in exactly one.
    ///
    /// # Errors
    /// A class in no or in two groups, or one that does not exist.
    pub fn look_alikes(&self, groups: &[(String, Vec<usize>)]) -> Result<LookAlikes> {
        let refuse = |class: usize, reason: &str| Error::Metrics {
            what: "groups of look-alikes",
            reason: format!("class {class} {reason}"),
        };
        let mut group_of: Vec<Option<usize>> = vec![None; self.counts.len()];
        for (group, (_, classes)) in groups.iter().enumerate() {
            for &class in classes {
                match group_of.get_mut(class) {
                    Some(slot @ None) => *slot = Some(group),
                    Some(_) => return Err(refuse(class, "is in two groups")),
                    None => return Err(refuse(class, "does not exist")),
                }
            }
        }
        let mut counts = vec![vec![0; groups.len()]; groups.len()];
        let (mut errors, mut within) = (0, 0);
        for (truth, row) in self.counts.iter().enumerate() {
            for (predicted, &count) in row.iter().enumerate() {
                let of = |class: usize| group_of[class].ok_or_else(|| refuse(class, "is in no group"));
                let (from, to) = (of(truth)?, of(predicted)?);
                counts[from][to] += count;
                if truth != predicted {
                    errors += count;
                    within += if from == to { count } else { 0 };
                }
            }
        }
        Ok(LookAlikes {
            groups: groups.iter().map(|(name, _)| name.clone()).collect(),
            confusion: Confusion { counts },
            errors,
            within_group: (errors > 0).then(|| within as f64 / errors as f64),
        })
    }
}

/// Computes mean and sample standard deviation (divided by n - 1); no deviation of fewer than two values, NaN for the
/// mean of none.
pub fn mean_sd(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (values.len() > 1).then(|| (squares / (n - 1.0)).sqrt()))
}

/// Returns the position of the largest value of each row; the first of equals.
pub fn argmax(rows: &[f32], classes: usize) -> Vec<u32> {
    let best = |row: &[f32]| {
        let mut best = 0;
        for (i, v) in row.iter().enumerate() {
            if *v > row[best] {
                best = i;
            }
        }
        best as u32
    };
    rows.chunks_exact(classes.max(1)).map(best).collect()
}
