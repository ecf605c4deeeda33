//! LSTM: the recording read step by step, the last hidden state classified.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, Tables 1 and 5: input 5×50, 0.27 MB, 0.0068 GFLOPs.
//!
//! # Departures
//! The paper gives no widths: one layer of 128 units over 50 steps of 5 readings, whose last hidden state
//! goes to the classifier, is what its size and GFLOPs leave. Two bias vectors, as PyTorch has them.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least};

pub(crate) const LSTM: Listing<LstmConfig> = Listing {
    name: "lstm",
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, Table 5",
    config: LstmConfig { classes: 3, in_channels: 5, length: 50, hidden: 128 },
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 69_507, statistics: 0, macs: 3_405_184 },
    quick: &[],
};

/// `signal` `[in_channels, length]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LstmConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Sensors, rows of the recording, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 1.
    pub length: usize,
    /// Hidden units, at least 1.
    pub hidden: usize,
}

impl Default for LstmConfig {
    fn default() -> Self {
        LSTM.config
    }
}

impl Architecture for LstmConfig {
    fn graph(&self) -> Result<Graph> {
        let LstmConfig { classes, in_channels, length, hidden } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 1),
            ("length", length, 1),
            ("hidden", hidden, 1),
        ])?;
        let net = Network::new(LSTM.name);
        let logits = net.input("signal", &[in_channels, length]).lstm("lstm", hidden).linear("fc", classes);
        net.finish(&[("logits", logits)])
    }
}
