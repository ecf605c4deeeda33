//! Run folders judged: accuracy against measured speed, breaking points under faults, statistics, and
//! the smallest network that suffices. Nothing is trained here.
//!
//! [`Case`] is an opened run folder with its data. [`judge()`] measures it once: the [`Judgement`] is plain
//! values. [`choose`], [`claims`] and [`across`] decide by them, [`report()`] and [`overview`] show them.

mod case;
mod decide;
mod error;
mod measure;
mod pareto;
mod report;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod synthetic;
mod values;

pub use case::Case;
pub use decide::{across, choose, claims, hardening, rank, statistics};
pub use error::{Error, Result};
pub use measure::{EarlyOptions, Options, StressOptions, judge, speed, stress, survey};
pub use report::{Entry, Report, Summary, overview, report, survey_page, sweep_page};
pub use values::{
    Across, Alarms, Axis, Change, Choice, Claim, ClassPictures, Contest, CostKind, Criteria, Early,
    EarlyDecisions, EarlyNetwork, EarlyPoint, EpochPoint, Evidence, Example, FaultCurve, FaultInfo, FoldLoss,
    Hardened, Judged, Judgement, MAJORITY, NetworkStress, OpenTrial, OtherWay, Outcome, Picture, PictureKind,
    Score, SensorRange, Setting, Speed, Spread, Stress, Survey, Sweep, SweepProgress, Test, Unmet, Verdict,
};
