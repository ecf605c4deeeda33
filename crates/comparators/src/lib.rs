#![doc = include_str!("../README.md")]

mod lstm;
mod mlp;
mod tactnet;
mod tactresnet;

pub use lstm::LstmConfig;
pub use mlp::MlpConfig;
pub use tactnet::{TactNetConfig, TactNetDepth};
pub use tactresnet::TactResNetConfig;
