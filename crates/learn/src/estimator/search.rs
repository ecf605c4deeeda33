//! Settings that each fold chooses by a validation part, never by its test part.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::metrics::Metric;
use crate::problem::{Check, require, share};
use crate::training::recipe::{Criterion, Recipe};

/// Every recipe of `grid` is trained on what is left of the training part and scored on what is held back (or
/// on the protocol's validation part); the best one is trained on the whole training part and tested.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Search {
    /// The recipes to try.
    pub grid: Vec<Combination>,
    /// Share of the training part that is held back where the protocol has no validation part, (0, 1).
    pub validation: f64,
    /// The criterion on the validation part.
    pub by: Criterion,
}

/// One recipe of a grid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Combination {
    /// The values that it sets, by dotted key of the recipe.
    pub set: BTreeMap<String, Value>,
    /// The recipe with these values.
    pub recipe: Recipe,
}

/// One combination and how it did on the validation part; nothing where it diverged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Values by dotted key of the recipe.
    pub set: BTreeMap<String, Value>,
    /// Mean loss over the validation part.
    pub loss: Option<f64>,
    /// The metric of the search's criterion on it, in its unit; by loss the primary one.
    #[serde(alias = "accuracy")]
    pub score: Option<f64>,
}

/// The choice of a fold, with all that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// Values by dotted key of the recipe.
    pub set: BTreeMap<String, Value>,
    /// Everything that was tried.
    pub trials: Vec<Trial>,
}

impl Search {
    /// Checks the recipes to try, the validation share and the criterion.
    ///
    /// # Errors
    /// Nothing to choose from, a share that is none, a recipe out of range.
    pub(crate) fn check(&self) -> Check {
        let reason = "needs recipes to choose from";
        require(!self.grid.is_empty(), "grid", "[]", reason)?;
        share("validation", self.validation)?;
        self.by.check("by")?;
        self.grid.iter().enumerate().try_for_each(|(i, tried)| {
            tried.recipe.check().map_err(|problem| problem.below(&format!("grid.{i}")))
        })
    }

    /// Returns the position of the best trial; of equals the first. None if all diverged.
    pub(crate) fn best(&self, metric: &Metric, trials: &[Trial]) -> Option<usize> {
        let mut best: Option<(usize, (f64, f64))> = None;
        for (i, trial) in trials.iter().enumerate() {
            let (Some(loss), Some(score)) = (trial.loss, trial.score) else { continue };
            if best.is_none_or(|(_, other)| self.by.prefers(metric, (loss, score), other)) {
                best = Some((i, (loss, score)));
            }
        }
        best.map(|(i, _)| i)
    }
}
