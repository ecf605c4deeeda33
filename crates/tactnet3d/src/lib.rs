#![doc = include_str!("../README.md")]

mod tactnet3d;

pub use tactnet3d::{TactNet3d, TactNet3dConfig};
