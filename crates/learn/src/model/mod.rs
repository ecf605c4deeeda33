//! A model in one file: what was trained, what it reads, what it predicts, and how well.

mod calibrate;
mod card;
mod digest;
mod familiar;
mod file;
mod halve;
mod hub_page;
mod kind;
pub(crate) mod marks;
mod mask;
pub(crate) mod members;
mod multiplied;
mod open;
mod predictions;
mod predictor;
mod quantize;
mod ranges;
pub(crate) mod ready;
pub(crate) mod responder;
mod workspace;

pub use card::{Card, FORMAT, ModelInput, Quantized, Score, TrainedOn, TrainingPart};
pub(crate) use digest::digest;
pub use file::Model;
pub use hub_page::HUB_LIBRARY;
pub use kind::{AverageMember, ModelKind};
pub use mask::{MaskGrid, Masked, at_rest};
pub use predictions::Predictions;
pub use predictor::Predictor;
pub use ranges::{OutsideRange, Ranges};
pub use workspace::Workspace;
