//! The channels of a source that nobody has described.

use std::sync::{Arc, OnceLock};

/// Names of the channels of a source, once its first time step has come. Clones see the same.
#[derive(Debug, Clone, Default)]
pub struct StreamChannels(Arc<OnceLock<Vec<String>>>);

impl StreamChannels {
    /// Returns the names in the order of the values of a time step, empty where the source names none; `None` before the first
    /// time step.
    pub fn names(&self) -> Option<&[String]> {
        self.0.get().map(Vec::as_slice)
    }

    /// Takes the names of the first time step; later ones change nothing.
    pub(crate) fn found(&self, names: Vec<String>) {
        let _ = self.0.set(names);
    }
}
