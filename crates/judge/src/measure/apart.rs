//! Temperature and gate of each fold, fitted to the other folds.

use std::collections::BTreeMap;

use taxel_learn::certainty::Seen;

/// Temperature and gate by row and fold.
pub(super) type Apart = BTreeMap<(String, u32), (f64, Option<Seen>)>;
