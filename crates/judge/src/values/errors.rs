//! How far the values of a row lie from the true ones.

use serde::{Deserialize, Serialize};

/// The errors of one row, quantity by quantity, over all test parts together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RowErrors {
    /// Name in the experiment.
    pub network: String,
    /// One of each quantity.
    pub quantities: Vec<QuantityErrors>,
}

/// The errors of one row in one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantityErrors {
    /// Name of the quantity.
    pub name: String,
    /// Its unit, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Mean absolute error, in the unit.
    pub mae: f64,
    /// Root of the mean squared error, in the unit.
    pub rmse: f64,
    /// 1 less the share of the variance that is left.
    pub r2: f64,
    /// Median of the absolute errors, in the unit.
    pub median: f64,
    /// The size that 95 % of the absolute errors do not pass, in the unit.
    pub p95: f64,
    /// Mean absolute error in % of the range of the true values.
    pub relative_mae: f64,
    /// Mean absolute error of always giving the mean, in the unit.
    pub of_mean: f64,
    /// The intervals of 90 %; none of fewer than 30 predictions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<CoveredShare>,
    /// True and predicted values of at most 400 samples.
    pub points: Vec<[f32; 2]>,
}

/// How well intervals of 90 % hold the true values, each part with those of the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CoveredShare {
    /// Share that they hold, 0..1; mean over the quantities.
    pub covered: f64,
    /// The same in the worst group; none without groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_group: Option<f64>,
    /// Mean width, in the unit.
    pub width: f64,
}
