//! Scores under graded faults on raw readings.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use taxel_faults::Fault;
use taxel_learn::certainty::SureAnswers;

use super::primary::Primary;

/// Description of a fault for readers of a report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultInfo {
    /// Name in settings and in reports.
    pub fault: Fault,
    /// Its effect in a few words.
    pub what: String,
    /// Severities 1 to 5.
    pub levels: [f32; 5],
    /// Unit of the levels.
    pub unit: String,
}

/// The range of readings that levels in % of full scale refer to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SensorRange {
    /// The smallest possible reading.
    pub low: f32,
    /// The largest possible reading.
    pub high: f32,
    /// Whether it was taken from the samples, since nobody says what the sensor's is.
    pub from_samples: bool,
}

/// Scores on the same test samples, clean or broken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The primary metric, in its unit.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// Expected calibration error, 0 to 1; none of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_error: Option<f64>,
    /// Samples that an encoding refused; they count as wrong, of values as the mean.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub refused: usize,
    /// Share of the samples that gates of the other folds find unknown, 0 to 1; none without gates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unknown: Option<f64>,
}

/// One network under one fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultCurve {
    /// The fault.
    pub fault: Fault,
    /// Severity (1 to 5) and scores; all five unless one was chosen.
    pub points: Vec<(u8, Score)>,
    /// The first severity at which half of the margin above chance is lost: its breaking point.
    pub breaks_at: Option<u8>,
}

/// One network under all faults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NetworkStress {
    /// Name in the experiment.
    pub network: String,
    /// On the same samples, unbroken.
    pub clean: Score,
    /// In the order of [`Stress::faults`].
    pub curves: Vec<FaultCurve>,
    /// Mean loss under faults, over faults and severities; above 0 where they make the score worse.
    pub mean_loss: f64,
    /// The largest loss of a fault, mean over its severities.
    pub worst_loss: f64,
    /// Errors relative to the reference's, mean over faults, in % (Hendrycks & Dietterich 2019, mCE).
    pub corruption_error: Option<f64>,
    /// Errors beyond the clean ones relative to the reference's (relative mCE), in %; none where the
    /// reference loses nothing.
    pub relative_corruption_error: Option<f64>,
    /// Mean over faults and severities; none of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_error: Option<f64>,
    /// Answers that are 90 % sure, of clean samples; none of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sure: Option<SureAnswers>,
    /// The same of broken samples, all faults and severities together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sure_when_broken: Option<SureAnswers>,
    /// The result in words.
    pub verdict: String,
    /// The same with the guard switched the other way, where that was tried.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<OtherWay>,
    /// Fold by fold, for differences between two networks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub folds: Vec<FoldLoss>,
}

/// A network behind a guard whose models have none, or without the guard that its models have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OtherWay {
    /// Whether this is with a guard.
    pub is_guarded: bool,
    /// On unbroken samples.
    pub clean: Score,
    /// In the order of [`Stress::faults`].
    pub curves: Vec<FaultCurve>,
    /// Lost of what the models as they are have on unbroken samples
    /// ([`NetworkStress::clean`]); mean over faults and severities.
    pub mean_loss: f64,
}

/// Replacements by guards in unbroken test samples. They are false alarms, unless a recording was faulty already.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alarms {
    /// Test samples that they looked at, over all folds.
    pub samples: usize,
    /// Those in which they replaced anything.
    pub alarmed: usize,
    /// Channels or taxels that they replaced.
    pub replaced: usize,
    /// Channels or taxels of a sample.
    pub elements: usize,
}

/// One network on one fold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FoldLoss {
    /// From 0.
    pub fold: usize,
    /// The primary metric on unbroken samples.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// Loss under faults, mean over faults and severities.
    pub loss: f64,
}

/// Every network under every fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stress {
    /// Seed of the faults.
    pub seed: u64,
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// Test samples behind every score, over all folds of the first repetition.
    pub samples: usize,
    /// Test samples that there are; more than `samples` where some were left out for time.
    pub of: usize,
    /// The sensor's range.
    pub range: SensorRange,
    /// Score of always naming the commonest class, or of always giving the mean.
    pub chance: f64,
    /// The network that corruption errors are relative to.
    pub reference: Option<String>,
    /// In the order of the table.
    pub faults: Vec<FaultInfo>,
    /// Faults without a meaning for these readings, and why.
    pub left_out: BTreeMap<String, String>,
    /// In the order of the run.
    pub networks: Vec<NetworkStress>,
    /// Replacements by guards in unbroken test samples; none where there are no guards.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alarms: Option<Alarms>,
    /// Rows that were trained without one fault, under that fault alone.
    #[serde(rename = "unmet", default, skip_serializing_if = "Vec::is_empty")]
    pub unseen: Vec<NetworkStress>,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl FaultInfo {
    /// Describes `fault`.
    pub(crate) fn of(fault: Fault) -> Self {
        let (what, unit) = (fault.describe().into(), fault.unit().into());
        FaultInfo { fault, what, levels: fault.severities(), unit }
    }

    /// Returns the level of a severity from 1 to 5, in [`FaultInfo::unit`].
    pub fn level(&self, severity: u8) -> f32 {
        self.levels[usize::from(severity.clamp(1, 5)) - 1]
    }
}

impl NetworkStress {
    /// Returns the score on unbroken samples and curves, without a guard and with one; none where only one way was tried.
    pub fn sides(&self) -> Option<[(Score, &[FaultCurve], f64); 2]> {
        let other = self.other.as_ref()?;
        let saved = (self.clean, self.curves.as_slice(), self.mean_loss);
        let switched = (other.clean, other.curves.as_slice(), other.mean_loss);
        Some(if other.is_guarded { [saved, switched] } else { [switched, saved] })
    }
}

impl FaultCurve {
    /// Returns what is lost of `clean`, above 0 where the score gets worse; mean over the severities.
    pub fn loss(&self, clean: Score, primary: &Primary) -> f64 {
        self.mean(|score| primary.worsening(score.score, clean.score))
    }

    /// Returns the mean of a score over the severities.
    pub(crate) fn mean(&self, value: impl Fn(&Score) -> f64) -> f64 {
        self.points.iter().map(|(_, score)| value(score)).sum::<f64>() / self.points.len().max(1) as f64
    }
}

impl Stress {
    /// Returns what the faults cost the network of that name on average.
    pub fn mean_loss(&self, network: &str) -> Option<f64> {
        self.networks.iter().find(|tested| tested.network == network).map(|tested| tested.mean_loss)
    }
}
