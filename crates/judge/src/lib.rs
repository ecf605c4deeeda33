//! Run folders judged: accuracy against measured speed, breaking points under faults, statistics, and
//! the smallest network that suffices. Nothing is trained here.
//!
//! [`Case`] is an opened run folder, [`Judgement`] everything that is measured about it; tables, charts and
//! words are made of a judgement alone.

mod across;
mod case;
mod choice;
mod claims;
mod contest;
mod error;
mod examples;
mod judgement;
mod measure;
mod report;
mod speed;
pub mod statistics;
mod stress;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod synthetic;

pub use across::{Across, across};
pub use case::Case;
pub use choice::{By, Choice, Evidence, Test, Wish, choose};
pub use claims::{Claim, Outcome, claims};
pub use error::{Error, Result};
pub use judgement::{EpochPoint, Example, Judged, Judgement, Kind, Picture, PictureKind, Verdict};
pub use measure::{Options, judge};
pub use report::{Entry, Report, Summary, overview, report};
pub use speed::Speed;
pub use stress::{FaultCurve, FaultInfo, NetworkStress, Range, Score, Stress, StressOptions, stress};
