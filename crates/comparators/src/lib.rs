#![doc = include_str!("../README.md")]

mod mlp;

pub use mlp::MlpConfig;
