//! The smallest network that suffices, with the evidence.

use serde::{Deserialize, Serialize};
use taxel_learn::require;

use crate::error::Result;

/// What is to be small.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CostKind {
    /// Time from raw reading to answer of one sample on one thread.
    #[default]
    Latency,
    /// Bytes of parameters and statistics.
    Size,
    /// Multiply-accumulates per sample.
    Macs,
}

/// What a choice has to respect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Criteria {
    /// What is to be small.
    pub cost: CostKind,
    /// Level of significance over the whole table, (0, 1). Default 0.05.
    pub alpha: f64,
    /// The most accuracy that faults may cost on average, in percentage points; none: not asked for.
    pub max_loss: Option<f64>,
    /// An accuracy loss that would matter, in percentage points: a table that could not have seen a loss
    /// this large has too few data, and what seems to lose more is not chosen. Default 5.
    pub margin: f64,
}

/// One network beside the most accurate one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Name in the experiment.
    pub network: String,
    /// Mean accuracy in %.
    pub accuracy: f64,
    /// Its accuracy less that of the best, in percentage points; 0 for the best itself.
    pub difference: f64,
    /// 95 % interval of the difference, where the test gives one.
    pub interval: Option<[f64; 2]>,
    /// Two-sided p of the test against the best; none for the best itself.
    pub p: Option<f64>,
    /// The same, Holm-corrected over the table.
    pub p_holm: Option<f64>,
    /// Whether it is worse than the best beyond doubt (`p_holm < alpha` and less accurate).
    pub worse: bool,
    /// What is to be small: ms, bytes or multiply-accumulates; none where it was not measured.
    pub cost: Option<f64>,
    /// Mean accuracy that faults cost, in percentage points; none without a stress test.
    pub mean_loss: Option<f64>,
    /// Why it cannot be chosen; none for candidates.
    pub refused: Option<String>,
}

/// How two networks were compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Corrected resampled t-test over folds and repetitions (Nadeau & Bengio 2003).
    NadeauBengio,
    /// Exact test on the samples of one shared test part (McNemar 1947).
    McNemar,
}

/// The recommendation and all that speaks for and against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// What was asked for.
    pub criteria: Criteria,
    /// How networks were compared.
    pub test: Test,
    /// The most accurate one.
    pub best: String,
    /// The smallest one that suffices; none where none does.
    pub chosen: Option<String>,
    /// Whether the data can tell: no candidate may be worse than the best by [`Criteria::margin`] unseen.
    pub enough_data: bool,
    /// In the order of the run.
    pub evidence: Vec<Evidence>,
    /// The recommendation in sentences: what is chosen, what it gives up, what it saves, what is not known.
    pub words: Vec<String>,
}

impl Default for Criteria {
    fn default() -> Self {
        Criteria { cost: CostKind::Latency, alpha: 0.05, max_loss: None, margin: 5.0 }
    }
}

impl Criteria {
    /// Refuses what cannot be asked for, before anything is measured.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn check(&self) -> Result<()> {
        let Criteria { alpha, margin, max_loss, .. } = *self;
        require(alpha > 0.0 && alpha < 1.0, "alpha", alpha, "must be in (0, 1); 0.05 is usual")?;
        let reason = "must be in (0, 100] percentage points";
        require(margin > 0.0 && margin <= 100.0, "margin", margin, reason)?;
        if let Some(loss) = max_loss {
            let reason = "must be in 0..=100 percentage points";
            require((0.0..=100.0).contains(&loss), "max_loss", loss, reason)?;
        }
        Ok(())
    }
}
