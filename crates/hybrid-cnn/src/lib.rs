#![doc = include_str!("../README.md")]

mod densenet6_lite;
mod hybrid;
mod light;
mod resnet8_lite;
mod vgg6_lite;

pub use hybrid::{Branches, Fusion, HybridConfig};
pub use light::{Light1dConfig, Light2dConfig};

use taxel_graph::Register;

const FAMILY: &str = "hybrid-cnn";

/// Hands every network of this family to the zoo.
pub fn list(zoo: &mut impl Register) {
    zoo.add(light::VGG6_1D);
    zoo.add(light::RESNET8_1D);
    zoo.add(light::DENSENET6_1D);
    zoo.add(light::VGG6_2D);
    zoo.add(light::RESNET8_2D);
    zoo.add(light::DENSENET6_2D);
    zoo.add(hybrid::HYBRID_VGG);
    zoo.add(hybrid::HYBRID_RESNET);
    zoo.add(hybrid::HYBRID_DENSENET);
    zoo.add(hybrid::HYBRID_RESVGG);
    zoo.add(hybrid::HYBRID_RESVGG_NOFC);
}

/// The three light bodies of the paper (section 3.1), each in 1D and 2D.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    /// Five convolutions (section 3.1.1).
    Vgg6,
    /// Residual blocks (section 3.1.2).
    ResNet8,
    /// Dense blocks (section 3.1.3).
    DenseNet6,
}
