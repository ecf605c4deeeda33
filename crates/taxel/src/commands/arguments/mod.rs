//! Arguments that several commands share, each with one meaning.

#[cfg(feature = "lab")]
pub mod budget;
#[cfg(feature = "lab")]
pub mod bytes;
pub mod certainty;
pub mod lines;
pub mod model_recordings;
#[cfg(feature = "lab")]
pub mod network;
pub mod option_hints;
pub mod output_format;
pub mod paths;
#[cfg(feature = "lab")]
pub mod settings;
pub mod threads;
