//! Temperature and gates of each fold, fitted to the other folds.

use std::collections::BTreeMap;

use taxel_learn::certainty::Gates;

/// Temperature and gates by row and fold.
pub(super) type Apart = BTreeMap<(String, u32), (f64, Gates)>;
