//! How a run is shrunk.

use crate::axis::Axis;

/// How a run is shrunk.
#[derive(Debug, Clone)]
pub struct Options {
    /// What may become less. Default everything.
    pub axes: Vec<Axis>,
    /// A loss of accuracy that would matter, in percentage points, (0, 100]. Default 2.
    pub margin: f64,
    /// Level of significance over a curve, (0, 1). Default 0.05.
    pub alpha: f64,
    /// Inner folds of each training part, 2 to 100. Default 2.
    pub inner: usize,
    /// Whether to look at two test parts and a quarter of the epochs only, with few settings. Default false.
    pub quick: bool,
    /// Epochs in place of the run's. Default those of the run.
    pub epochs: Option<usize>,
    /// Whether the folder may hold finished trainings already, which are not made again. Default false.
    pub resume: bool,
    /// Worker threads; results do not depend on them. Default 1.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            axes: Axis::ALL.to_vec(),
            margin: 2.0,
            alpha: 0.05,
            inner: 2,
            quick: false,
            epochs: None,
            resume: false,
            threads: 1,
        }
    }
}
