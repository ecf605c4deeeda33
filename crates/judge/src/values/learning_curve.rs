//! The gain of more training recordings.

use serde::{Deserialize, Serialize};

/// The scores of one row with fewer training recordings, and what follows for more of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearningCurve {
    /// The row.
    pub network: String,
    /// The thing that a count is of: `class`, `part of the range`, or nothing where recordings are counted altogether.
    pub per: String,
    /// Scores on inner folds, from few recordings to all of an inner training part.
    pub points: Vec<CurvePoint>,
    /// The training parts of the run, with the scores of its test parts; none in a file of an earlier version.
    #[serde(default)]
    pub whole: Option<CurvePoint>,
    /// The fitted law; none where the scores follow none.
    pub law: Option<CurveLaw>,
}

/// The score with so many training recordings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Training recordings, mean over folds; of each class where the curve says so.
    pub count: f64,
    /// The primary metric of each fold.
    pub scores: Vec<f64>,
    /// Their mean.
    pub score: f64,
}

/// A power law of the error: `floor + scale · count^-rate`, in the unit of the primary metric.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveLaw {
    /// The error that remains with any number of recordings.
    pub floor: f64,
    /// Size of what falls.
    pub scale: f64,
    /// How fast it falls, above 0.
    pub rate: f64,
    /// Error with as many recordings as a training part of the run has, with its 95 % interval; none in a file of an earlier version.
    #[serde(default)]
    pub forecast: Option<(f64, [f64; 2])>,
    /// Error that it levels off at, with its 95 % interval; none where four sizes do not tell it.
    pub level: Option<(f64, [f64; 2])>,
    /// Gains of more recordings than a training part of the run has.
    pub gains: Vec<CurveGain>,
}

/// The gain of so many more recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurveGain {
    /// More recordings.
    pub more: f64,
    /// Points of the primary metric that are won, at least 0.
    pub gain: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}
