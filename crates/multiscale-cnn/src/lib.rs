#![doc = include_str!("../README.md")]

mod multiscale;

pub use multiscale::{BlockActivation, MultiscaleConfig};

use taxel_graph::Register;

const FAMILY: &str = "multiscale-cnn";

/// Hands every network of this family to the zoo.
pub fn list(zoo: &mut impl Register) {
    zoo.add(multiscale::MULTISCALE_CNN);
}
