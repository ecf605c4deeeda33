//! Run folders judged: accuracy against measured speed, breaking points under faults, statistics, and
//! the smallest network that suffices. Nothing is trained here.
//!
//! [`Case`] is an opened run folder, [`Judgement`] everything that is measured about it; tables, charts and
//! words are made of a judgement alone.

mod case;
mod choice;
mod claims;
mod error;
mod examples;
mod judgement;
mod measure;
mod speed;
pub mod statistics;
mod stress;

pub use case::Case;
pub use choice::{By, Choice, Evidence, Test, Wish};
pub use claims::{Claim, Outcome};
pub use error::{Error, Result};
pub use judgement::{
    EpochPoint, Example, Judged, Judgement, Kind, Picture, PictureKind, Verdict, WeightChange,
};
pub use measure::{Options, judge, judged_before_or_now};
pub use speed::Speed;
pub use stress::{FaultCurve, FaultInfo, NetworkStress, Range, Score, Stress, StressOptions, stress};
