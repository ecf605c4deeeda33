//! MLP: the flattened recording through one hidden layer.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, Tables 1 and 5: input 1×250, 0.12 MB, 0.00006 GFLOPs.
//!
//! # Departures
//! The paper gives no widths: 250–128–classes with ReLU is what its size and GFLOPs leave.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, InputKeys, Listing, Network, NetworkCounts, Result, within};

pub(crate) const MLP: Listing<MlpConfig> = Listing {
    name: "mlp",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, Table 5",
    config: MlpConfig { classes: 3, in_features: 250, hidden: 128 },
    inputs: &[InputKeys::FLAT],
    counts: NetworkCounts { parameters: 32_515, statistics: 0, macs: 32_384 },
    quick: &[],
};

/// `signal` `[1, in_features]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MlpConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Readings of a recording: sensors × samples in time, at least 1.
    pub in_features: usize,
    /// Hidden units, at least 1.
    pub hidden: usize,
}

impl Default for MlpConfig {
    fn default() -> Self {
        MLP.config
    }
}

impl Architecture for MlpConfig {
    fn graph(&self) -> Result<Graph> {
        let MlpConfig { classes, in_features, hidden } = *self;
        for (key, value, least) in
            [("classes", classes, 1), ("in_features", in_features, 1), ("hidden", hidden, 1)]
        {
            within(key, value, least..=16_777_216)?;
        }
        let net = Network::new(MLP.name);
        let x = net.input("signal", &[1, in_features]).flatten();
        let logits = x.linear("fc1", hidden).relu().linear("fc2", classes);
        net.finish(&[("logits", logits)])
    }
}
