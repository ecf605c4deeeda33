//! The six light networks: a body in 1D or 2D and a classifier.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, section 3.1.
//!
//! # Departures
//! Those of the bodies.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, Network, Result, at_least};

use crate::Body;

/// A light 1D network: `signal` [in_channels, length] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light1dConfig {
    /// Which of the three; no setting.
    #[serde(skip)]
    pub body: Body,
    /// Output classes, at least 2.
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
    /// Output classes, at least 2.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl Light1dConfig {
    /// A body with the paper's sizes.
    pub const fn of(body: Body) -> Self {
        Light1dConfig { body, classes: 3, in_channels: 5, length: 50 }
    }
}

impl Light2dConfig {
    /// A body with the paper's sizes.
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
        at_least(&[("classes", classes, 2), ("in_channels", in_channels, 1), ("length", length, 1)])?;
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
            ("classes", classes, 2),
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
