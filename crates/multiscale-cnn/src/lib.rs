#![doc = include_str!("../README.md")]

mod multiscale;

pub use multiscale::{BlockActivation, MultiscaleConfig};
