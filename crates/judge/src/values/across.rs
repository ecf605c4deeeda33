//! Networks ranked over several data sets.

use serde::{Deserialize, Serialize};

use super::primary::Primary;

/// One data set and how good each network is on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Contest {
    /// Name of the data set or of its run.
    pub name: String,
    /// The metric that networks are compared by.
    pub primary: Primary,
    /// Networks with that metric, in its unit.
    pub scores: Vec<(String, f64)>,
}

impl Contest {
    /// Returns the score of a network.
    pub fn of(&self, network: &str) -> Option<f64> {
        self.scores.iter().find(|(name, _)| name == network).map(|(_, score)| *score)
    }
}

/// Networks that several runs share, ranked over their data sets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Across {
    /// Names of the runs, one per data set.
    pub runs: Vec<String>,
    /// Names of the networks that all runs have, the best mean rank first.
    pub networks: Vec<String>,
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// That metric in its unit, `[run][network]`.
    #[serde(rename = "accuracy", alias = "score")]
    pub scores: Vec<Vec<f64>>,
    /// Friedman's test; ranks in the order of `networks`, 1 is the best.
    pub friedman: Friedman,
    /// Level of significance of [`Across::critical_difference`].
    pub alpha: f64,
    /// Nemenyi's: mean ranks that differ by at least as much differ beyond doubt.
    pub critical_difference: f64,
    /// Wilcoxon's signed-rank test of each network against the first, Holm-corrected; none for the first.
    pub p_holm: Vec<Option<f64>>,
    /// The result in sentences.
    pub words: Vec<String>,
}

/// Friedman's test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Friedman {
    /// Mean rank of each method over the data sets; 1 is the best, ties share their mean.
    pub ranks: Vec<f64>,
    /// Chi-squared with methods − 1 degrees of freedom, corrected for ties.
    pub statistic: f64,
    /// Of [`Friedman::statistic`].
    pub p: f64,
    /// Of the less conservative F statistic (Iman & Davenport 1980).
    pub p_iman_davenport: f64,
}
