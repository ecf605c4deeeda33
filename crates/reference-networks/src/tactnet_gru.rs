//! TactNet6-GRU: TactNet6's convolutions on every frame of a squeeze, a GRU over the frames.
//!
//! # Reference
//! taxel's own. Gandarias et al. 2019b name CNN-RNN models, Pastor et al. 2019 temporal methods, as what 3D networks have
//! to be compared with; neither builds one. The convolutions are those of Gandarias et al. 2019a, the GRU is that of Cho
//! et al. (arXiv 1406.1078) as PyTorch has it.
//!
//! # Departures
//! TactNet6 is followed up to its last pool. Its classifier reads every place of the last map; here each frame is
//! averaged over its places, so that the number of weights does not depend on the size of the sensor. An axis of one place
//! is not pooled, so that any sensor will do. All frames share weights and batch-norm statistics. The last
//! hidden state is classified.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result, within,
};

use crate::tactnet::FILTERS;

pub(crate) const TACTNET6_GRU: Listing<TactNetGruConfig> = Listing {
    name: "tactnet6-gru",
    family: crate::FAMILY,
    paper: "taxel's own, named by Gandarias et al. 2019b",
    config: TactNetGruConfig { classes: 9, in_channels: 1, height: 28, width: 50, frames: 10, hidden: 64 },
    inputs: &[InputKeys::TENSOR],
    counts: NetworkCounts { parameters: 136_697, statistics: 496, macs: 22_453_696 },
    quick: &[("height", 11), ("width", 9), ("frames", 6)],
};

/// `tensor` `[in_channels, height, width, frames]` → outputs `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TactNetGruConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Readings per taxel, at least 1.
    pub in_channels: usize,
    /// Rows of taxels, at most 4096.
    pub height: usize,
    /// Columns of taxels, at most 4096.
    pub width: usize,
    /// Pressure maps of one squeeze, at most 4096.
    pub frames: usize,
    /// Hidden units of the GRU, at least 1.
    pub hidden: usize,
}

impl Default for TactNetGruConfig {
    fn default() -> Self {
        TACTNET6_GRU.config
    }
}

/// Returns rows and columns of what every frame has become; 1 each where a refusal has left no such axes.
fn map_of(x: &Flow) -> [usize; 2] {
    [1, 2].map(|axis| x.shape().get(axis).copied().unwrap_or(1))
}

impl Architecture for TactNetGruConfig {
    fn graph(&self) -> Result<Graph> {
        let TactNetGruConfig { classes, in_channels, height, width, frames, hidden } = *self;
        for (key, value, most) in [
            ("classes", classes, 65_536),
            ("in_channels", in_channels, 65_536),
            ("height", height, 4096),
            ("width", width, 4096),
            ("frames", frames, 4096),
            ("hidden", hidden, 65_536),
        ] {
            within(key, value, 1..=most)?;
        }
        let net = Network::new(TACTNET6_GRU.name);
        let mut x = net.input("tensor", &[in_channels, height, width, frames]);
        for (i, &filters) in FILTERS.iter().enumerate() {
            let kernel = if i == 0 { 5 } else { 3 };
            let conv = Conv::new(filters, [kernel, kernel, 1]).same();
            x = x.conv_bn_relu(&format!("convs.{i}"), conv);
            let [rows, columns] = map_of(&x);
            x = x.max_pool(Pool::new([rows.min(2), columns.min(2), 1]).round_up());
        }
        let [rows, columns] = map_of(&x);
        let features = x.average_pool(Pool::new([rows, columns, 1]));
        net.finish(&[("logits", features.gru("gru", hidden).linear("fc", classes))])
    }
}
