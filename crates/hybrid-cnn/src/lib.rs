#![doc = include_str!("../README.md")]

mod densenet6_lite;
mod hybrid;
mod light;
mod resnet8_lite;
mod vgg6_lite;

pub use hybrid::{Branches, Fusion, HybridConfig};
pub use light::{Light1dConfig, Light2dConfig};

use taxel_graph::{Flow, Register};

const FAMILY: &str = "hybrid-cnn";

/// Hands every network of this family to the zoo.
pub fn list(zoo: &mut impl Register) {
    zoo.add(vgg6_lite::IN_1D);
    zoo.add(resnet8_lite::IN_1D);
    zoo.add(densenet6_lite::IN_1D);
    zoo.add(vgg6_lite::IN_2D);
    zoo.add(resnet8_lite::IN_2D);
    zoo.add(densenet6_lite::IN_2D);
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

impl Body {
    /// The features before the classifier: channels after global average pooling.
    fn features(self, x: Flow) -> Flow {
        match self {
            Body::Vgg6 => vgg6_lite::body(x),
            Body::ResNet8 => resnet8_lite::body(x),
            Body::DenseNet6 => densenet6_lite::body(x),
        }
        .global_average_pool()
    }

    /// Names of the networks with this body, in 1D and in 2D.
    fn names(self) -> [&'static str; 2] {
        match self {
            Body::Vgg6 => [vgg6_lite::IN_1D.name, vgg6_lite::IN_2D.name],
            Body::ResNet8 => [resnet8_lite::IN_1D.name, resnet8_lite::IN_2D.name],
            Body::DenseNet6 => [densenet6_lite::IN_1D.name, densenet6_lite::IN_2D.name],
        }
    }
}
