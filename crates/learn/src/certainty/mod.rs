//! How far the probabilities of a model can be believed.
//!
//! A network that is sure is not right as often as it says, and MiniRocket's ridge is right more often. A *temperature* T
//! divides the logits before the softmax (Guo et al., ICML 2017, section 4.2), so that answers of which the model is 90 %
//! sure are right in nine of ten cases. It is fitted on predictions for samples that no training saw: those of the test
//! parts of a run, or own recordings. The same predictions give [sets](AnswerSet) of classes that hold the true one as often as they
//! say, and a [gate](Seen) that tells samples unlike any that was learned.
//!
//! Values have [intervals](Intervals) instead, fitted to the errors of the same predictions.

mod answers;
mod apart;
mod early;
mod fitted;
mod gate;
mod held_out;
mod intervals;
mod place;
mod promise;
mod readings;
mod reliability;
mod seen;
mod sets;
mod summary;
mod temperature;
mod unknown;

pub use answers::answers;
pub use apart::fitted_apart;
pub use early::EarlyRecord;
pub use fitted::{CalibrationErrors, Certainty, FittedOn, HeldOutParts, SureAnswers};
pub use gate::Gates;
pub(crate) use gate::familiarity;
pub use held_out::HeldOut;
pub use intervals::{HeldOutValues, IntervalAt, Intervals};
pub use place::Place;
pub use promise::groups_needed;
pub use readings::Readings;
pub use reliability::{Reliability, ReliabilityBin};
pub use seen::{FALSE_ALARMS, Seen};
pub use sets::AnswerSet;
pub use summary::Axes;
pub(crate) use summary::Summary;
pub use temperature::{fitted_temperature, matched_temperature, tempered};
pub use unknown::{UnknownDraw, UnknownScores, UnknownTrial, WithoutClasses};
