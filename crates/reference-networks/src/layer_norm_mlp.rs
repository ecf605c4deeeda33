//! LayerNormMLP: the flattened recording through several hidden layers, each with a layer norm.
//!
//! # Reference
//! taxel's own, for values such as force and position. The parts are known: layer norms before the rectifier (Ba, Kiros
//! and Hinton, arXiv 1607.06450). A layer norm treats each sample alone, so that the network predicts as it was
//! trained, also where later readings are larger than those of training.
//!
//! # Departures
//! None: nothing is published.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, InputKeys, Listing, Network, NetworkCounts, Result, within};

pub(crate) const LAYER_NORM_MLP: Listing<LayerNormMlpConfig> = Listing {
    name: "layer-norm-mlp",
    family: crate::FAMILY,
    paper: "taxel's own",
    config: LayerNormMlpConfig { classes: 3, in_features: 250, hidden: 128, layers: 3 },
    inputs: &[InputKeys::FLAT],
    counts: NetworkCounts { parameters: 66_307, statistics: 0, macs: 65_152 },
    quick: &[],
};

/// `signal` `[1, in_features]` → outputs `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LayerNormMlpConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Readings of a recording: sensors × samples in time, at least 1.
    pub in_features: usize,
    /// Units of each hidden layer, at least 1.
    pub hidden: usize,
    /// Hidden layers, 1 to 16.
    pub layers: usize,
}

impl Default for LayerNormMlpConfig {
    fn default() -> Self {
        LAYER_NORM_MLP.config
    }
}

impl Architecture for LayerNormMlpConfig {
    fn graph(&self) -> Result<Graph> {
        let LayerNormMlpConfig { classes, in_features, hidden, layers } = *self;
        for (key, value) in [("classes", classes), ("in_features", in_features), ("hidden", hidden)] {
            within(key, value, 1..=16_777_216)?;
        }
        within("layers", layers, 1..=16)?;
        let net = Network::new(LAYER_NORM_MLP.name);
        let mut x = net.input("signal", &[1, in_features]).flatten();
        for layer in 1..=layers {
            x = x.linear(&format!("fc{layer}"), hidden).layer_norm(&format!("ln{layer}")).relu();
        }
        net.finish(&[("logits", x.linear("head", classes))])
    }
}
