//! The smallest network that suffices, with the evidence.

use serde::{Deserialize, Serialize};
use taxel_faults::Fault;
use taxel_learn::require;

use super::primary::Primary;
use super::room::Room;
use crate::error::Result;

/// A loss that would matter, in percentage points or in % of what knowing nothing scores.
const MARGIN: f64 = 5.0;

/// The cost that is to be small.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CostKind {
    /// Time from raw sample to prediction of one sample on one thread.
    #[default]
    Latency,
    /// Bytes of parameters and statistics.
    Size,
    /// Multiply-accumulates per sample.
    Macs,
}

/// Criteria of a choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Criteria {
    /// The cost that is to be small.
    pub cost: CostKind,
    /// Level of significance over the whole table, (0, 1). Default 0.05.
    pub alpha: f64,
    /// The most that faults may cost on average, in percentage points of accuracy or in the unit of the metric; none:
    /// no limit.
    pub max_loss: Option<f64>,
    /// A loss that would matter, in percentage points of accuracy or in the unit of the metric: a table that could not
    /// have seen a loss this large has too few data, and what seems to lose more is not chosen. None is 5 percentage
    /// points, and for a metric in the unit of a quantity 5 % of what always giving the mean scores.
    pub margin: Option<f64>,
    /// Whether scores on clean samples alone decide. Else what loses half of its margin above chance at severity 1 of a
    /// common fault ([`COMMON_FAULTS`]) is chosen only where nothing steadier suffices. Default false.
    #[serde(default)]
    pub clean_only: bool,
    /// The microcontroller that it has to fit; none: any will do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub room: Option<Room>,
}

/// The faults that any sensor meets: noise, drift of the offset, another gain after re-mounting, dead taxels or channels,
/// dropped frames.
pub const COMMON_FAULTS: [Fault; 5] = [Fault::Noise, Fault::Drift, Fault::Gain, Fault::Dead, Fault::Jitter];

/// One network beside the best one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Name in the experiment.
    pub network: String,
    /// Mean of the primary metric, in its unit.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// Its score less that of the best, in percentage points or in the metric's unit; 0 for the best itself.
    pub difference: f64,
    /// 95 % interval of the difference, where the test gives one.
    pub interval: Option<[f64; 2]>,
    /// Two-sided p of the test against the best; none for the best itself.
    pub p: Option<f64>,
    /// The test that gave it: over two folds, and over folds that all differ alike, that of all samples together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<Test>,
    /// The same, Holm-corrected over the table.
    pub p_holm: Option<f64>,
    /// Whether it is worse than the best beyond doubt (`p_holm < alpha` and a worse score).
    pub worse: bool,
    /// The cost that is to be small: ms, bytes or multiply-accumulates; none where it was not measured.
    pub cost: Option<f64>,
    /// Mean loss under faults, above 0 where they make the score worse; none without a stress test.
    pub mean_loss: Option<f64>,
    /// The common faults that take half of its margin above chance at severity 1 already; empty without a stress test.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub breaks_at_1: Vec<Fault>,
    /// Why it cannot be chosen; none for candidates.
    pub refused: Option<String>,
}

/// How two networks were compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Corrected resampled t-test over folds and repetitions (Nadeau & Bengio 2003).
    NadeauBengio,
    /// Paired t-test over simulated worlds that share nothing.
    FreshWorlds,
    /// Exact test on all test samples, each counted once (McNemar 1947).
    McNemar,
    /// The same question of grouped samples: t-test on the variance of the groups (Durkalski et al. 2003).
    GroupedPairs,
    /// Exact signed-rank test on all test samples, or on their groups, by how far values are off (Wilcoxon 1945).
    Wilcoxon,
}

/// The recommendation and all that speaks for and against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The criteria, with the margin filled in.
    pub criteria: Criteria,
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// How networks were compared.
    pub test: Test,
    /// The most accurate one, by the primary metric.
    pub best: String,
    /// The smallest one that suffices, on clean samples and under faults; none where none does.
    pub chosen: Option<String>,
    /// A cheaper one that suffices on clean samples and was not chosen, because a common fault breaks it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passed_over: Option<String>,
    /// Where a common fault breaks the chosen one too: the one that suffices and loses least to faults.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steadier: Option<String>,
    /// Whether the data can tell: no candidate may be worse than the best by [`Criteria::margin`] unseen.
    pub enough_data: bool,
    /// In the order of the run.
    pub evidence: Vec<Evidence>,
    /// The recommendation in sentences: what is chosen, what it gives up, what it saves, what is not known.
    pub words: Vec<String>,
}

impl Default for Criteria {
    fn default() -> Self {
        Criteria {
            cost: CostKind::Latency,
            alpha: 0.05,
            max_loss: None,
            margin: None,
            clean_only: false,
            room: None,
        }
    }
}

impl Criteria {
    /// Checks the values for that metric, before anything is measured.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn check(&self, primary: &Primary) -> Result<()> {
        let Criteria { alpha, margin, max_loss, .. } = *self;
        require(alpha > 0.0 && alpha < 1.0, "alpha", alpha, "must be in (0, 1); 0.05 is usual")?;
        let most = if primary.is_percent() { 100.0 } else { f64::MAX };
        let reason = |percent, other| if primary.is_percent() { percent } else { other };
        if let Some(margin) = margin {
            let reason = reason("must be in (0, 100] percentage points", "must be above 0");
            require(margin > 0.0 && margin <= most, "margin", margin, reason)?;
        }
        if let Some(loss) = max_loss {
            let reason = reason("must be in 0..=100 percentage points", "must be 0 or more");
            require((0.0..=most).contains(&loss), "max_loss", loss, reason)?;
        }
        self.room.as_ref().map_or(Ok(()), Room::check)
    }

    /// Returns the given margin, or the default for that metric where knowing nothing scores `chance`.
    pub fn margin_of(&self, primary: &Primary, chance: f64) -> f64 {
        self.margin.unwrap_or_else(|| primary.share(MARGIN, chance))
    }
}

impl Choice {
    /// Returns the loss that would matter, in the unit of the metric.
    pub fn margin(&self) -> f64 {
        self.criteria.margin.unwrap_or(MARGIN)
    }
}
