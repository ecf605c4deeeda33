//! DeepMLP: the flattened recording through several hidden layers, each with a batch norm.
//!
//! # Reference
//! taxel's own, for values such as force and position. The parts are known: rectified layers with batch norms before the
//! rectifier (Ioffe and Szegedy, ICML 2015).
//!
//! # Departures
//! None: nothing is published.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, InputKeys, Listing, Network, NetworkCounts, Result, within};

pub(crate) const DEEP_MLP: Listing<DeepMlpConfig> = Listing {
    name: "deep-mlp",
    family: crate::FAMILY,
    paper: "taxel's own",
    config: DeepMlpConfig { classes: 3, in_features: 250, hidden: 128, layers: 3, batch_norm: true },
    inputs: &[InputKeys::FLAT],
    counts: NetworkCounts { parameters: 66_307, statistics: 768, macs: 65_152 },
    quick: &[],
};

/// `signal` `[1, in_features]` → outputs `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DeepMlpConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Readings of a recording: sensors × samples in time, at least 1.
    pub in_features: usize,
    /// Units of each hidden layer, at least 1.
    pub hidden: usize,
    /// Hidden layers, 1 to 16.
    pub layers: usize,
    /// Whether a batch norm follows each of them. Without, training may vary the gain of its readings more.
    pub batch_norm: bool,
}

impl Default for DeepMlpConfig {
    fn default() -> Self {
        DEEP_MLP.config
    }
}

impl Architecture for DeepMlpConfig {
    fn graph(&self) -> Result<Graph> {
        let DeepMlpConfig { classes, in_features, hidden, layers, batch_norm } = *self;
        for (key, value) in [("classes", classes), ("in_features", in_features), ("hidden", hidden)] {
            within(key, value, 1..=16_777_216)?;
        }
        within("layers", layers, 1..=16)?;
        let net = Network::new(DEEP_MLP.name);
        let mut x = net.input("signal", &[1, in_features]).flatten();
        for layer in 1..=layers {
            x = x.linear(&format!("fc{layer}"), hidden);
            x = if batch_norm { x.batch_norm(&format!("bn{layer}")) } else { x }.relu();
        }
        net.finish(&[("logits", x.linear("head", classes))])
    }
}
