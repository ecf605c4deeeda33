//! Run folders judged: the task's primary metric against measured speed, breaking points under faults, statistics, and
//! the smallest network that suffices. Nothing is trained here.
//!
//! [`Case`] is an opened run folder with its data. [`judge()`] measures it once: the [`Judgement`] is plain
//! values. [`choose`] and [`across`] decide by them, [`report()`] and [`overview`] show them.
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use taxel_baselines::Method;
//! use taxel_data::{Dataset, Layout};
//! use taxel_judge::{Case, Criteria, JudgeOptions, choose, judge};
//! use taxel_learn::{Candidate, CrossValidation, Protocol, RunFolder, RunOptions, Silent};
//!
//! // Forty presses: soft ones rise slowly, hard ones at once.
//! let reading = |press: usize, time: usize| (press % 2 + 1) as f32 * time as f32 + (7 * press % 5) as f32;
//! let x = ndarray::ArrayD::from_shape_fn(vec![40, 1, 12], |at| reading(at[0], at[2]));
//! let labels: Vec<&str> = (0..40).map(|press| ["soft", "hard"][press % 2]).collect();
//! let presses = Dataset::new("presses", Layout::Series, x, &labels)?;
//!
//! let folder = tempfile::tempdir()?;
//! let out = folder.path().join("presses");
//! CrossValidation::new(&presses)
//!     .protocol(Protocol::k_fold(2))
//!     .candidate(Candidate::baseline(Method::Majority))
//!     .candidate(Candidate::baseline(Method::NearestNeighbours { k: 1 }))
//!     .run_in(&out, &RunOptions::default(), &Silent, &AtomicBool::new(false))?;
//!
//! let case = Case::new(RunFolder::open(&out)?, presses)?;
//! let judgement = judge(&case, &JudgeOptions { budget: 0.01, ..JudgeOptions::default() })?;
//! let choice = choose(&case, &judgement, &Criteria::default())?;
//! assert_eq!(choice.chosen.as_deref(), Some("k-nn"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod case;
mod decide;
mod error;
mod measure;
mod pareto;
mod report;
#[cfg(any(test, feature = "synthetic"))]
#[doc(hidden)]
#[allow(clippy::unwrap_used)]
pub mod synthetic;
mod values;

pub use case::Case;
pub use decide::{
    Comparison, Effect, Predicted, Side, Statistic, across, choose, contrasts, hardening, knee, mean_score,
    rank, rounded, side_by_side, statistics,
};
pub use error::{Error, Result};
pub use measure::{
    EarlyOptions, HeldOutRow, JudgeOptions, StressOptions, held_out, judge, speed, stress, survey,
};
pub use report::{NetworkSummary, OverviewRun, Ranked, Report, curve_words, overview, report, survey_page};
pub use taxel_report::pictures::{ArrayPicture, PictureKind};
pub use values::{
    Across, Alarms, COMMON_FAULTS, Change, Choice, ClassImportance, ClassPictures, Contest, Contrast,
    CostKind, Criteria, CurveGain, CurveLaw, CurvePoint, Early, EarlyDecisions, EarlyNetwork, EarlyPoint,
    EpochPoint, Evidence, Example, FaultCurve, FaultInfo, FoldLoss, Hardened, Importance, Judged, Judgement,
    LearningCurve, MAJORITY, Need, NetworkStress, OtherWay, Place, Primary, Right, Room, Score, SensorRange,
    SideBySide, SideCosts, Speed, Stress, Survey, Test, UnseenFault, Verdict, named_scores,
};
