//! Plain values: what is measured about a run, and what is decided by it. They serialise, and know neither
//! how they came about nor how they are shown.

mod across;
mod certainty;
mod choice;
mod contrast;
mod early;
mod eight_bits;
mod errors;
mod example;
mod hardening;
mod importance;
mod judgement;
mod learning_curve;
mod primary;
mod room;
mod side_by_side;
mod speed;
mod stress;
mod survey;

pub use across::{Across, Contest, Friedman};
pub use certainty::{RowCertainty, UnknownMeans};
pub use choice::{COMMON_FAULTS, Choice, CostKind, Criteria, Evidence, Test};
pub use contrast::Contrast;
pub use early::{Early, EarlyDecisions, EarlyNetwork, EarlyPoint};
pub use eight_bits::{Changed, EightBits};
pub use errors::{CoveredShare, QuantityErrors, RowErrors};
pub use example::{Example, Verdict};
pub use hardening::{Change, Hardened, UnseenFault};
pub use importance::{ClassImportance, Importance};
pub use judgement::{EpochPoint, Judged, Judgement};
pub use learning_curve::{CurveGain, CurveLaw, CurvePoint, LearningCurve};
pub use primary::{Primary, named_scores};
pub use room::{Need, Room};
pub use side_by_side::{Place, Right, SideBySide, SideCosts};
pub use speed::Speed;
pub use stress::{
    Alarms, FaultCurve, FaultInfo, FoldLoss, NetworkStress, OtherWay, Score, SensorRange, Stress,
};
pub use survey::{ClassPictures, Survey};

/// The baseline that reads nothing.
pub const MAJORITY: &str = "majority";
