#![doc = include_str!("../README.md")]

mod densenet6_lite;
mod hybrid;
mod resnet8_lite;
mod vgg6_lite;

pub use hybrid::{Fusion, Hybrid, HybridConfig};

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Error, Flow, Graph, Network, Result};

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

/// A light 1D network: `signal` [in_channels, length] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light1dConfig {
    /// Output classes, at least 2.
    pub classes: usize,
    /// Sensors, rows of the recording, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 1.
    pub length: usize,
}

impl Default for Light1dConfig {
    fn default() -> Self {
        Light1dConfig { classes: 3, in_channels: 5, length: 50 }
    }
}

/// A light 2D network: `image` [in_channels, height, width] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light2dConfig {
    /// Output classes, at least 2.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl Default for Light2dConfig {
    fn default() -> Self {
        Light2dConfig { classes: 3, in_channels: 3, height: 50, width: 50 }
    }
}

/// One of the six light networks: a body with its configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Light<C> {
    /// Which body.
    pub body: Body,
    /// Sizes.
    pub config: C,
}

impl Architecture for Light<Light1dConfig> {
    fn graph(&self) -> Result<Graph> {
        let Light1dConfig { classes, in_channels, length } = self.config;
        positive(&[("classes", classes), ("in_channels", in_channels), ("length", length)])?;
        light(&format!("{}-1d", self.body.name()), "signal", &[in_channels, length], self.body, classes)
    }
}

impl Architecture for Light<Light2dConfig> {
    fn graph(&self) -> Result<Graph> {
        let Light2dConfig { classes, in_channels, height, width } = self.config;
        positive(&[
            ("classes", classes),
            ("in_channels", in_channels),
            ("height", height),
            ("width", width),
        ])?;
        light(&format!("{}-2d", self.body.name()), "image", &[in_channels, height, width], self.body, classes)
    }
}

fn light(name: &str, input: &str, shape: &[usize], body: Body, classes: usize) -> Result<Graph> {
    let net = Network::new(name);
    let logits = body.features(net.input(input, shape)).linear("fc", classes);
    net.finish(&[("logits", logits)])
}

/// Refuses sizes of 0 and absurd ones (which would only fail later, when memory runs out), and fewer
/// than two classes.
fn positive(values: &[(&str, usize)]) -> Result<()> {
    for &(key, value) in values {
        let least = if key == "classes" { 2 } else { 1 };
        if !(least..=65_536).contains(&value) {
            return Err(Error::config(key, value, &format!("must be in {least}..=65536")));
        }
    }
    Ok(())
}
