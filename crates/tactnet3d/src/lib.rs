#![doc = include_str!("../README.md")]

mod tactnet3d;

pub use tactnet3d::{Layers, TactNet3dConfig};
