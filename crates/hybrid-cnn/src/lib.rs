#![doc = include_str!("../README.md")]

mod densenet6_lite;
mod hybrid;
mod light;
mod resnet8_lite;
mod vgg6_lite;

pub use hybrid::{Branches, Fusion, HybridConfig};
pub use light::{Light1dConfig, Light2dConfig};

use taxel_graph::Flow;

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

    fn name(self) -> &'static str {
        match self {
            Body::Vgg6 => "vgg6-lite",
            Body::ResNet8 => "resnet8-lite",
            Body::DenseNet6 => "densenet6-lite",
        }
    }
}
