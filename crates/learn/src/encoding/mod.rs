//! The inputs of networks and baselines, made of raw samples fold by fold.
//!
//! An [`Encoding`] says what is wanted, an [`Encoder`] makes it of a data set. What needs no fitting is
//! computed once; what does (z-scores, quantiles) is fitted on the training part of each fold. What was fitted is a
//! [`Transform`], saved with the model and enough to encode new recordings.

mod axes;
mod compiled;
mod copies;
mod encoder;
mod guarding;
mod names;
mod range;
mod rocket;
mod scale;
mod settings;
mod signal;
mod transform;

pub use compiled::Compiled;
pub use encoder::{Encoded, Encoder, Input};
pub use guarding::{fitted_guard, mended};
pub use names::{IMAGE, ROCKET, SERIES, SIGNAL, TENSOR};
pub use range::Range;
pub use rocket::{Rocket, RocketSettings};
pub use scale::{Scale, Scaled};
pub use settings::{Bits, Encoding, GramianSettings, Image, PictureSettings, SqueezeFrame, TensorSettings};
pub use signal::{Code, Signal};
pub use taxel_encodings::{Converter, Reduction};
pub use transform::Transform;
