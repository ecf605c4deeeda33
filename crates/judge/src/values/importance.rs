//! The parts that decisions rest on: sensors and parts of the window.

use serde::{Deserialize, Serialize};

/// The parts that the decisions of one row rest on, by masking its test samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Importance {
    /// The row.
    pub network: String,
    /// Test samples that were masked.
    pub samples: usize,
    /// Names of the sensors, or blocks of rows of an image.
    pub rows: Vec<String>,
    /// Names of the parts of the window, or blocks of columns.
    pub columns: Vec<String>,
    /// Mean loss with each sensor masked alone: of classes the fall of the true class's probability in percentage points, of values
    /// the rise of the absolute error in the unit of the metric.
    pub by_row: Vec<f64>,
    /// The same with each part of the window masked alone; empty where there is one.
    pub by_column: Vec<f64>,
    /// Class by class; of values one for all samples.
    pub classes: Vec<ClassImportance>,
}

/// The parts that the decisions on one class rest on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClassImportance {
    /// The true class; empty of values.
    pub class: String,
    /// Its samples.
    pub samples: usize,
    /// Mean loss with each pair of a sensor and a part of the window masked, row by row.
    pub cells: Vec<Vec<f64>>,
}
