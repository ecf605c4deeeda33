//! One setting beside the whole.

use serde::{Deserialize, Serialize};

/// A setting beside the whole, on the same samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// Mean accuracy in %.
    pub accuracy: f64,
    /// 95 % interval of it, where the test parts give one.
    pub accuracy_interval: Option<[f64; 2]>,
    /// Its accuracy less that of the whole, in percentage points.
    pub difference: f64,
    /// 95 % interval of the difference, where the test gives one.
    pub interval: Option<[f64; 2]>,
    /// Two-sided p against the whole, Holm-corrected over its curve.
    pub p_holm: Option<f64>,
    /// Whether it is worse than the whole beyond doubt.
    pub worse: bool,
}

impl Contrast {
    /// Whether it does instead of the whole: not worse beyond doubt, and no loss above `margin` points to be seen.
    pub fn suffices(&self, margin: f64) -> bool {
        !self.worse && -self.difference <= margin + 1e-9
    }
}
