//! TactNet4 and TactNet6: plain convolutions on pressure images.
//!
//! # Reference
//! Gandarias, García-Cerezo and Gómez-de-Gabriel 2019, "CNN-based methods for object recognition with high-resolution
//! tactile sensors", in the layer lists the authors published; compared with in Kaewrakmuk and Srinonchat 2026, Table
//! 5: 0.04 MB and 0.0060 GFLOPs, 0.40 MB and 0.0102 GFLOPs.
//!
//! # Departures
//! Input is the colour image of Kaewrakmuk and Srinonchat, 50×50, in place of the authors' 28×50 pressure image. Read
//! into the text: pools round up (MATLAB's `same`), which alone gives the published GFLOPs.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result, at_least,
};

/// Filters of TactNet6's convolutions, each followed by batch norm, ReLU and a 2/2 max-pool; the first has
/// a kernel of 5, the others of 3. TactNet4 has the first three.
pub(crate) const FILTERS: [usize; 5] = [8, 16, 32, 64, 128];

pub(crate) const TACTNET4: Listing<TactNetConfig> = Listing {
    name: "tactnet4",
    family: crate::FAMILY,
    paper: "Gandarias et al. 2019a; Kaewrakmuk and Srinonchat 2026, Table 5",
    config: TactNetConfig::FOUR,
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 11_235, statistics: 112, macs: 3_003_456 },
    quick: &[],
};

pub(crate) const TACTNET6: Listing<TactNetConfig> = Listing {
    name: "tactnet6",
    family: crate::FAMILY,
    paper: TACTNET4.paper,
    config: TactNetConfig::SIX,
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 100_803, statistics: 496, macs: 5_083_104 },
    quick: &[],
};

/// Which of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TactNetDepth {
    /// Three convolutions and the classifier.
    Four,
    /// Five convolutions and the classifier.
    Six,
}

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TactNetConfig {
    /// Which of the two; no setting.
    #[serde(skip)]
    pub depth: TactNetDepth,
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl TactNetConfig {
    /// `tactnet4` with the image and classes of Kaewrakmuk and Srinonchat 2026.
    pub const FOUR: TactNetConfig =
        TactNetConfig { depth: TactNetDepth::Four, classes: 3, in_channels: 3, height: 50, width: 50 };
    /// `tactnet6`, likewise.
    pub const SIX: TactNetConfig = TactNetConfig { depth: TactNetDepth::Six, ..TactNetConfig::FOUR };
}

impl Default for TactNetConfig {
    fn default() -> Self {
        TactNetConfig::FOUR
    }
}

impl Architecture for TactNetConfig {
    fn with(&self, settings: Self) -> Self {
        TactNetConfig { depth: self.depth, ..settings }
    }

    fn graph(&self) -> Result<Graph> {
        let TactNetConfig { depth, classes, in_channels, height, width } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 1),
            ("height", height, 1),
            ("width", width, 1),
        ])?;
        let (name, filters) = match depth {
            TactNetDepth::Four => (TACTNET4.name, &FILTERS[..3]),
            TactNetDepth::Six => (TACTNET6.name, &FILTERS[..]),
        };
        let net = Network::new(name);
        let mut x = net.input("image", &[in_channels, height, width]);
        for (i, &filters) in filters.iter().enumerate() {
            let kernel = if i == 0 { 5 } else { 3 };
            x = x
                .conv_bn_relu(&format!("convs.{i}"), Conv::new(filters, kernel).same())
                .max_pool(Pool::new(2).round_up());
        }
        net.finish(&[("logits", x.flatten().linear("fc", classes))])
    }
}
