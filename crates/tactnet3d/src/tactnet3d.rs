//! TactNet3D: a squeeze as one tensor of rows, columns and frames, read by 3D convolutions.
//!
//! # Reference
//! Gandarias et al. 2019b, section on TactNet3D and Table I: four
//! widths on 28×50×10. Pastor et al. 2019, section 3 and Fig. 4: one network on 28×50×51.
//!
//! # Departures
//! None known. Read into the text: "max-pooling with filters and stride = 1" pools nothing (`pool` offers more);
//! convolutions are unpadded, as in both toolboxes by default; the order is convolution, batch norm, ReLU; a ReLU
//! follows fc3, and dropout follows that, once. The dropout of 0.8 in Gandarias et al. is mdCNN's, the share
//! *kept*; the 0.7 in Pastor et al. is MATLAB's, the share *dropped*. Pastor et al. print its kernel as 5×3×8 in the
//! figure and 3×5×8 in the text; the figure is followed. The third convolution of `tactnet3d-8-16-32` has the
//! kernel of the second. Softmax belongs to the loss.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result, share, within,
};

/// Rows, columns, frames.
type KernelSize = [usize; 3];

/// Gandarias et al. 2019b: the kernel of the first convolution, then of all others.
const ACTIVE_KERNELS: [KernelSize; 2] = [[5, 5, 3], [5, 3, 3]];
/// Pastor et al. 2019, Fig. 4.
const PALPATION_KERNELS: [KernelSize; 2] = [[5, 3, 8], [5, 3, 8]];

pub(crate) const TACTNET3D: Listing<TactNet3dConfig> = Listing {
    name: TactNet3dConfig::ACTIVE.layers.name,
    family: crate::FAMILY,
    paper: "Gandarias et al. 2019b, Table I",
    config: TactNet3dConfig::ACTIVE,
    inputs: &[InputKeys::TENSOR],
    counts: NetworkCounts { parameters: 5_413_801, statistics: 48, macs: 41_119_296 },
    quick: &[("height", 15), ("width", 13), ("frames", 8)],
};

pub(crate) const TACTNET3D_4_8: Listing<TactNet3dConfig> = Listing {
    name: TactNet3dConfig::ACTIVE_4_8.layers.name,
    family: crate::FAMILY,
    paper: "Gandarias et al. 2019b, Table I",
    config: TactNet3dConfig::ACTIVE_4_8,
    inputs: &[InputKeys::TENSOR],
    counts: NetworkCounts { parameters: 2_705_785, statistics: 24, macs: 12_956_736 },
    quick: &[("height", 15), ("width", 13), ("frames", 8)],
};

pub(crate) const TACTNET3D_FC32: Listing<TactNet3dConfig> = Listing {
    name: TactNet3dConfig::ACTIVE_FC32.layers.name,
    family: crate::FAMILY,
    paper: "Gandarias et al. 2019b, Table I",
    config: TactNet3dConfig::ACTIVE_FC32,
    inputs: &[InputKeys::TENSOR],
    counts: NetworkCounts { parameters: 2_710_121, statistics: 48, macs: 38_415_648 },
    quick: &[("height", 15), ("width", 13), ("frames", 8)],
};

pub(crate) const TACTNET3D_8_16_32: Listing<TactNet3dConfig> = Listing {
    name: TactNet3dConfig::ACTIVE_8_16_32.layers.name,
    family: crate::FAMILY,
    paper: "Gandarias et al. 2019b, Table I",
    config: TactNet3dConfig::ACTIVE_8_16_32,
    inputs: &[InputKeys::TENSOR],
    counts: NetworkCounts { parameters: 5_535_241, statistics: 112, macs: 103_149_120 },
    quick: &[("height", 15), ("width", 13), ("frames", 8)],
};

pub(crate) const TACTNET3D_51: Listing<TactNet3dConfig> = Listing {
    name: TactNet3dConfig::PALPATION.layers.name,
    family: crate::FAMILY,
    paper: "Pastor et al. 2019, Fig. 4",
    config: TactNet3dConfig::PALPATION,
    inputs: &[InputKeys::TENSOR],
    counts: NetworkCounts { parameters: 69_779_048, statistics: 96, macs: 2_258_454_016 },
    quick: &[("height", 12), ("width", 9), ("frames", 19)],
};

/// `tensor` `[in_channels, height, width, frames]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TactNet3dConfig {
    /// Which of the papers' networks; no setting.
    #[serde(skip)]
    pub layers: Layers,
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
    /// Units of fc3, at least 1.
    pub hidden: usize,
    /// Window and stride of the max-pool after each convolution; 1, the papers' value, pools nothing.
    pub pool: usize,
    /// Share of fc3's outputs dropped in training, in 0..1.
    pub dropout: f32,
}

/// The layers that differ between the papers' networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layers {
    /// Registry name.
    pub name: &'static str,
    /// Filters of each convolution.
    filters: &'static [usize],
    kernels: [KernelSize; 2],
}

impl TactNet3dConfig {
    /// `tactnet3d`: Gandarias et al. 2019b, Table I, second row, what the paper calls TactNet3D.
    pub const ACTIVE: TactNet3dConfig = TactNet3dConfig {
        layers: Layers { name: "tactnet3d", filters: &[8, 16], kernels: ACTIVE_KERNELS },
        classes: 9,
        in_channels: 1,
        height: 28,
        width: 50,
        frames: 10,
        hidden: 64,
        pool: 1,
        dropout: 0.2,
    };
    /// `tactnet3d-4-8`: Gandarias et al. 2019b, Table I, first row.
    pub const ACTIVE_4_8: TactNet3dConfig = TactNet3dConfig {
        layers: Layers { name: "tactnet3d-4-8", filters: &[4, 8], kernels: ACTIVE_KERNELS },
        ..TactNet3dConfig::ACTIVE
    };
    /// `tactnet3d-fc32`: Gandarias et al. 2019b, Table I, third row.
    pub const ACTIVE_FC32: TactNet3dConfig = TactNet3dConfig {
        layers: Layers { name: "tactnet3d-fc32", ..TactNet3dConfig::ACTIVE.layers },
        hidden: 32,
        ..TactNet3dConfig::ACTIVE
    };
    /// `tactnet3d-8-16-32`: Gandarias et al. 2019b, Table I, fourth row.
    pub const ACTIVE_8_16_32: TactNet3dConfig = TactNet3dConfig {
        layers: Layers { name: "tactnet3d-8-16-32", filters: &[8, 16, 32], kernels: ACTIVE_KERNELS },
        ..TactNet3dConfig::ACTIVE
    };
    /// `tactnet3d-51`: Pastor et al. 2019, Fig. 4.
    pub const PALPATION: TactNet3dConfig = TactNet3dConfig {
        layers: Layers { name: "tactnet3d-51", filters: &[16, 32], kernels: PALPATION_KERNELS },
        classes: 24,
        frames: 51,
        dropout: 0.7,
        ..TactNet3dConfig::ACTIVE
    };
}

impl Default for TactNet3dConfig {
    fn default() -> Self {
        TactNet3dConfig::ACTIVE
    }
}

impl Architecture for TactNet3dConfig {
    fn with(&self, settings: Self) -> Self {
        TactNet3dConfig { layers: self.layers, ..settings }
    }

    fn graph(&self) -> Result<Graph> {
        let &TactNet3dConfig { layers, classes, in_channels, height, width, frames, hidden, pool, dropout } =
            self;
        for (key, value, least, most) in [
            ("classes", classes, 1, 65_536),
            ("in_channels", in_channels, 1, 65_536),
            ("height", height, 1, 4096),
            ("width", width, 1, 4096),
            ("frames", frames, 1, 4096),
            ("hidden", hidden, 1, 65_536),
            ("pool", pool, 1, 4096),
        ] {
            within(key, value, least..=most)?;
        }
        share("dropout", dropout)?;
        let net = Network::new(layers.name);
        let mut x = net.input("tensor", &[in_channels, height, width, frames]);
        for (i, &filters) in layers.filters.iter().enumerate() {
            let kernel = layers.kernels[i.min(1)];
            x = x.conv(&format!("convs.{i}"), Conv::new(filters, kernel)).bn_relu(&format!("bns.{i}"));
            if pool > 1 {
                x = x.max_pool(Pool::new(pool));
            }
        }
        let hidden = x.flatten().linear("fc3", hidden).relu().dropout(dropout);
        net.finish(&[("logits", hidden.linear("fc4", classes))])
    }
}
