//! The six light networks: a body in 1D or 2D and a classifier.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, section 3.1.
//!
//! # Departures
//! Those of the bodies.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least};

use crate::{Body, densenet6_lite, resnet8_lite, vgg6_lite};

pub(crate) const VGG6_1D: Listing<Light1dConfig> = Listing {
    name: "vgg6-lite-1d",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.1.1",
    config: Light1dConfig::of(Body::Vgg6),
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 33_411, statistics: 480, macs: 449_952 },
    quick: &[],
};

pub(crate) const VGG6_2D: Listing<Light2dConfig> = Listing {
    name: "vgg6-lite-2d",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.1.1",
    config: Light2dConfig::of(Body::Vgg6),
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 98_115, statistics: 480, macs: 19_535_232 },
    quick: &[],
};

pub(crate) const RESNET8_1D: Listing<Light1dConfig> = Listing {
    name: "resnet8-lite-1d",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.1.2",
    config: Light1dConfig::of(Body::ResNet8),
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 13_923, statistics: 416, macs: 204_928 },
    quick: &[],
};

pub(crate) const RESNET8_2D: Listing<Light2dConfig> = Listing {
    name: "resnet8-lite-2d",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.1.2",
    config: Light2dConfig::of(Body::ResNet8),
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 39_299, statistics: 416, macs: 11_417_888 },
    quick: &[],
};

pub(crate) const DENSENET6_1D: Listing<Light1dConfig> = Listing {
    name: "densenet6-lite-1d",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.1.3",
    config: Light1dConfig::of(Body::DenseNet6),
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 10_419, statistics: 480, macs: 183_984 },
    quick: &[],
};

pub(crate) const DENSENET6_2D: Listing<Light2dConfig> = Listing {
    name: "densenet6-lite-2d",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.1.3",
    config: Light2dConfig::of(Body::DenseNet6),
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 23_507, statistics: 480, macs: 11_022_160 },
    quick: &[],
};

/// A light 1D network: `signal` [in_channels, length] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light1dConfig {
    /// Which of the three; no setting.
    #[serde(skip)]
    pub body: Body,
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Sensors, rows of the recording, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 1.
    pub length: usize,
}

/// A light 2D network: `image` [in_channels, height, width] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light2dConfig {
    /// Which of the three; no setting.
    #[serde(skip)]
    pub body: Body,
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl Body {
    /// Computes the features before the classifier: channels after global average pooling.
    pub(crate) fn features(self, x: Flow) -> Flow {
        match self {
            Body::Vgg6 => vgg6_lite::body(x),
            Body::ResNet8 => resnet8_lite::body(x),
            Body::DenseNet6 => densenet6_lite::body(x),
        }
        .global_average_pool()
    }

    /// Returns the names of the networks with this body, in 1D and in 2D.
    fn names(self) -> [&'static str; 2] {
        match self {
            Body::Vgg6 => [VGG6_1D.name, VGG6_2D.name],
            Body::ResNet8 => [RESNET8_1D.name, RESNET8_2D.name],
            Body::DenseNet6 => [DENSENET6_1D.name, DENSENET6_2D.name],
        }
    }
}

impl Light1dConfig {
    /// Returns the configuration of a body with the paper's sizes.
    pub const fn of(body: Body) -> Self {
        Light1dConfig { body, classes: 3, in_channels: 5, length: 50 }
    }
}

impl Light2dConfig {
    /// Returns the configuration of a body with the paper's sizes.
    pub const fn of(body: Body) -> Self {
        Light2dConfig { body, classes: 3, in_channels: 3, height: 50, width: 50 }
    }
}

impl Default for Light1dConfig {
    fn default() -> Self {
        Light1dConfig::of(Body::Vgg6)
    }
}

impl Default for Light2dConfig {
    fn default() -> Self {
        Light2dConfig::of(Body::Vgg6)
    }
}

impl Architecture for Light1dConfig {
    fn with(&self, settings: Self) -> Self {
        Light1dConfig { body: self.body, ..settings }
    }

    fn graph(&self) -> Result<Graph> {
        let Light1dConfig { body, classes, in_channels, length } = *self;
        at_least(&[("classes", classes, 1), ("in_channels", in_channels, 1), ("length", length, 1)])?;
        light(body.names()[0], "signal", &[in_channels, length], body, classes)
    }
}

impl Architecture for Light2dConfig {
    fn with(&self, settings: Self) -> Self {
        Light2dConfig { body: self.body, ..settings }
    }

    fn graph(&self) -> Result<Graph> {
        let Light2dConfig { body, classes, in_channels, height, width } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 1),
            ("height", height, 1),
            ("width", width, 1),
        ])?;
        light(body.names()[1], "image", &[in_channels, height, width], body, classes)
    }
}

fn light(name: &str, input: &str, shape: &[usize], body: Body, classes: usize) -> Result<Graph> {
    let net = Network::new(name);
    let logits = body.features(net.input(input, shape)).linear("fc", classes);
    net.finish(&[("logits", logits)])
}
