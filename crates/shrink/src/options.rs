//! How a run is shrunk.

use crate::axis::Axis;

/// How a run is shrunk.
#[derive(Debug, Clone)]
pub struct ShrinkOptions {
    /// Quantities to reduce. Default all.
    pub axes: Vec<Axis>,
    /// A loss that would matter, in percentage points of accuracy, (0, 100], or in the unit of the metric, above 0. None
    /// is 2 percentage points, and for a metric in the unit of a quantity 2 % of what always giving the mean scores.
    pub margin: Option<f64>,
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

impl Default for ShrinkOptions {
    fn default() -> Self {
        ShrinkOptions {
            axes: Axis::ALL.to_vec(),
            margin: None,
            alpha: 0.05,
            inner: 2,
            quick: false,
            epochs: None,
            resume: false,
            threads: 1,
        }
    }
}
