#![doc = include_str!("../README.md")]

mod tactnet3d;

pub use tactnet3d::{Layers, TactNet3dConfig};

use taxel_graph::Register;

const FAMILY: &str = "tactnet3d";

/// Hands every network of this family to the zoo.
pub fn list(zoo: &mut impl Register) {
    zoo.add(tactnet3d::TACTNET3D);
    zoo.add(tactnet3d::TACTNET3D_4_8);
    zoo.add(tactnet3d::TACTNET3D_FC32);
    zoo.add(tactnet3d::TACTNET3D_8_16_32);
    zoo.add(tactnet3d::TACTNET3D_51);
}
