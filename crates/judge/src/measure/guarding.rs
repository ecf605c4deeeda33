//! Guards of a stress test: of the models, or fitted on what a fold was trained on.

use std::sync::Arc;

use taxel_learn::guard::{Guard, ReplacedElement};
use taxel_learn::{FoldKey, Model, fitted_guard};

use crate::case::Case;
use crate::error::{Error, Result};
use crate::values::Alarms;

/// Returns the guard of the models of one fold: their own, or, where it is `wanted` and none has one, a new one of the
/// fold's training samples alone.
pub(super) fn guard(
    case: &Case,
    keys: &[FoldKey],
    models: &[Model],
    wanted: bool,
) -> Result<Option<Arc<Guard>>> {
    let guard = models.iter().find_map(|model| model.card().guard.clone());
    match (guard, keys.first()) {
        (Some(guard), _) => Ok(Some(Arc::new(guard))),
        (None, Some(key)) if wanted => {
            Ok(Some(Arc::new(fitted_guard(&case.dataset, &trained_on(case, key)?)?)))
        }
        _ => Ok(None),
    }
}

/// Returns the rows that a fold was trained on, as its protocol divides them.
pub(super) fn trained_on(case: &Case, key: &FoldKey) -> Result<Vec<usize>> {
    let folds = case.results.protocol.folds(&case.dataset, case.results.seed, key.repetition)?;
    let record = case.records(&key.network).find(|record| record.key == *key);
    let mut tested = record.map_or(vec![], |record| record.index.clone());
    tested.sort_unstable();
    match folds.into_iter().nth(key.fold) {
        Some(fold) if fold.test == tested => Ok(fold.train),
        _ => {
            let reason = format!(
                "{key} is not the fold that its protocol makes, so no guard can be fitted; leave --compare-guard out"
            );
            Err(Error::run(case.folder.path(), reason))
        }
    }
}

impl Alarms {
    /// Counts the replacements in some samples.
    pub(super) fn of(guard: &Guard, found: &[Vec<ReplacedElement>]) -> Self {
        Alarms {
            samples: found.len(),
            alarmed: found.iter().filter(|places| !places.is_empty()).count(),
            replaced: found.iter().map(Vec::len).sum(),
            elements: guard.elements(),
        }
    }

    /// Returns both together.
    pub(super) fn and(self, other: Self) -> Self {
        Alarms {
            samples: self.samples + other.samples,
            alarmed: self.alarmed + other.alarmed,
            replaced: self.replaced + other.replaced,
            elements: self.elements.max(other.elements),
        }
    }
}
