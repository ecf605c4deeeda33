//! Hybrid-CNN: a 1D branch on the signal and a 2D branch on its image, fused before the classifier.
//!
//! # Reference
//! Paper 000 (Hybrid-CNN hardness recognition), section 3.2, Eqs. 1–3, Fig. 2; ablation of the FC
//! head in Table 4.
//!
//! # Departures
//! None known.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, Network, Result};

use crate::{Body, positive};

/// A hybrid: `signal` [in_channels, length] + `image` [image_channels, height, width] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HybridConfig {
    /// Output classes, at least 2.
    pub classes: usize,
    /// Sensors of the signal, at least 1.
    pub in_channels: usize,
    /// Samples of the signal in time, at least 1.
    pub length: usize,
    /// Colour planes of the image, at least 1.
    pub image_channels: usize,
    /// Rows of the image, at least 1.
    pub height: usize,
    /// Columns of the image, at least 1.
    pub width: usize,
}

impl Default for HybridConfig {
    fn default() -> Self {
        HybridConfig { classes: 3, in_channels: 5, length: 50, image_channels: 3, height: 50, width: 50 }
    }
}

/// What stands between the joined features and the classifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fusion {
    /// A fully connected layer of half the width and ReLU (Eqs. 2–3).
    FullyConnected,
    /// Nothing: the ablation of Table 4.
    None,
}

/// A hybrid network: two bodies, their fusion and the sizes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hybrid {
    /// Registry name.
    pub name: &'static str,
    /// 1D body of the signal.
    pub temporal: Body,
    /// 2D body of the image.
    pub spatial: Body,
    /// Fusion head.
    pub fusion: Fusion,
    /// Sizes.
    pub config: HybridConfig,
}

impl Architecture for Hybrid {
    fn graph(&self) -> Result<Graph> {
        let HybridConfig { classes, in_channels, length, image_channels, height, width } = self.config;
        positive(&[
            ("classes", classes),
            ("in_channels", in_channels),
            ("length", length),
            ("image_channels", image_channels),
            ("height", height),
            ("width", width),
        ])?;
        let net = Network::new(self.name);
        let signal = net.input("signal", &[in_channels, length]).within("temporal");
        let image = net.input("image", &[image_channels, height, width]).within("spatial");
        let joined = net.concat("fusion", &[&self.temporal.features(signal), &self.spatial.features(image)]);
        let fused = match self.fusion {
            Fusion::FullyConnected => {
                let half = joined.shape().iter().sum::<usize>() / 2;
                joined.linear("fuse", half).relu()
            }
            Fusion::None => joined,
        };
        net.finish(&[("logits", fused.linear("fc", classes))])
    }
}
