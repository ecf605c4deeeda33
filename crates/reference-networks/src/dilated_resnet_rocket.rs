//! DilatedResNet-Rocket-1D: DilatedResNet-1D and a small perceptron on MiniRocket's features; their logits are added.
//!
//! # Reference
//! taxel's own. The series goes through DilatedResNet-1D (`dilated_resnet.rs`); the features are MiniRocket's (Dempster,
//! Schmidt & Webb, KDD 2021), fixed before training. The two err on different recordings, so together they err on fewer.
//!
//! # Departures
//! None: nothing is published. Each member has a loss of its own and the sum of their logits has none: on the sum alone
//! the member that learns faster leaves the other little to learn.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least};

use crate::dilated_resnet::{check, logits};

/// Share of the features, and of the perceptron's hidden units, that training drops.
const DROPPED: [f32; 2] = [0.3, 0.2];
/// Weights of the sum, the network and the perceptron in training.
const WEIGHTS: [f32; 3] = [0.0, 1.0, 1.0];

pub(crate) const DILATED_RESNET_ROCKET: Listing<DilatedResNetRocketConfig> = Listing {
    name: "dilated-resnet-rocket-1d",
    family: crate::FAMILY,
    paper: "taxel's own",
    config: DilatedResNetRocketConfig {
        classes: 3,
        in_channels: 500,
        length: 25,
        width: 64,
        blocks: 2,
        features: 1932,
        hidden: 32,
    },
    inputs: &[InputKeys::SIGNAL, InputKeys::ROCKET],
    counts: NetworkCounts { parameters: 144_774, statistics: 1_088, macs: 2_091_296 },
    quick: &[],
};

/// `signal` `[in_channels, length]` and `rocket` `[features]` → logits `[classes]`, and those of each member.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DilatedResNetRocketConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Rows of the code, or sensors, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 1.
    pub length: usize,
    /// Channels of all convolutions, at least 1.
    pub width: usize,
    /// Residual blocks, 1 or 2: the first has dilation 1, the second 2.
    pub blocks: usize,
    /// MiniRocket's features, at least 1.
    pub features: usize,
    /// Hidden units of the perceptron, at least 1.
    pub hidden: usize,
}

impl Default for DilatedResNetRocketConfig {
    /// Returns the configuration for the quantile code of five sensors with 50 samples in time, and the features that
    /// `encoding.rocket` makes.
    fn default() -> Self {
        DILATED_RESNET_ROCKET.config
    }
}

impl Architecture for DilatedResNetRocketConfig {
    fn graph(&self) -> Result<Graph> {
        let DilatedResNetRocketConfig { classes, in_channels, length, width, blocks, features, hidden } =
            *self;
        check([classes, in_channels, length, width], blocks)?;
        at_least(&[("features", features, 1), ("hidden", hidden, 1)])?;
        let net = Network::new(DILATED_RESNET_ROCKET.name);
        let signal = net.input("signal", &[in_channels, length]);
        let series = logits(&net, &signal, [length, width, blocks], classes);
        let x = net.input("rocket", &[features]).dropout(DROPPED[0]).linear("rocket.fc1", hidden);
        let x = x.batch_norm("rocket.bn").relu().dropout(DROPPED[1]);
        let features = x.linear("rocket.fc2", classes);
        let outputs =
            [("logits", series.add(&features)), ("series_logits", series), ("rocket_logits", features)];
        net.finish_weighted(&outputs, &WEIGHTS)
    }
}
