//! The time steps that targets belong to.

use serde::{Deserialize, Serialize};

/// The time step of each target, where targets belong to time steps in place of whole recordings: the last one of a window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetSteps {
    /// The recording of each, by number.
    pub recordings: Vec<u32>,
    /// Its place in the recording, from 0.
    pub steps: Vec<u32>,
    /// Time steps from one target of a recording to the next.
    pub hop: u32,
    /// Time steps per second (Hz), where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
}

impl TargetSteps {
    /// Returns the time steps of the targets in `rows`, in that order.
    pub fn of(&self, rows: &[usize]) -> Self {
        let of = |all: &[u32]| rows.iter().map(|row| all[*row]).collect();
        Self { recordings: of(&self.recordings), steps: of(&self.steps), ..*self }
    }
}
