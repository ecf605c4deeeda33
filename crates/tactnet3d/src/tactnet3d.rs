//! TactNet3D: a squeeze as one tensor of rows, columns and frames, read by 3D convolutions.
//!
//! # Reference
//! Paper 002 (active tactile recognition of deformable objects), section on TactNet3D and Table I: four
//! widths on 28×50×10. Paper 003 (robotic palpation), section 3 and Fig. 4: one network on 28×50×51.
//!
//! # Departures
//! None known. Read into the text: "max-pooling with filters and stride = 1" pools nothing (`pool` offers
//! more); convolutions are unpadded, as in both toolboxes by default; the order is convolution, batch norm,
//! ReLU; a ReLU follows fc3, and dropout follows that, once. Paper 002's dropout of 0.8 is mdCNN's, the share
//! *kept*; paper 003's 0.7 is MATLAB's, the share *dropped*. Paper 003 prints its kernel as 5×3×8 in the
//! figure and 3×5×8 in the text; the figure is followed. The third convolution of `tactnet3d-8-16-32` has the
//! kernel of the second. Softmax belongs to the loss.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Conv, Error, Graph, Network, Pool, Result};

/// Rows, columns, frames.
type Kernel = [usize; 3];

/// Paper 002: the kernel of the first convolution, then of all others.
const ACTIVE_KERNELS: [Kernel; 2] = [[5, 5, 3], [5, 3, 3]];
/// Paper 003, Fig. 4.
const PALPATION_KERNELS: [Kernel; 2] = [[5, 3, 8], [5, 3, 8]];

/// `tensor` `[in_channels, height, width, frames]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TactNet3dConfig {
    /// Output classes, at least 2.
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

/// One of the papers' networks: widths and kernels with the sizes.
#[derive(Debug, Clone, PartialEq)]
pub struct TactNet3d {
    /// Registry name.
    pub name: &'static str,
    /// Filters of each convolution.
    filters: &'static [usize],
    kernels: [Kernel; 2],
    /// Sizes.
    pub config: TactNet3dConfig,
}

const ACTIVE_CONFIG: TactNet3dConfig = TactNet3dConfig {
    classes: 9,
    in_channels: 1,
    height: 28,
    width: 50,
    frames: 10,
    hidden: 64,
    pool: 1,
    dropout: 0.2,
};

impl TactNet3d {
    /// Paper 002, Table I, second row: what the paper calls TactNet3D.
    pub const ACTIVE: TactNet3d =
        TactNet3d { name: "tactnet3d", filters: &[8, 16], kernels: ACTIVE_KERNELS, config: ACTIVE_CONFIG };
    /// Paper 002, Table I, first row.
    pub const ACTIVE_4_8: TactNet3d =
        TactNet3d { name: "tactnet3d-4-8", filters: &[4, 8], ..TactNet3d::ACTIVE };
    /// Paper 002, Table I, third row.
    pub const ACTIVE_FC32: TactNet3d = TactNet3d {
        name: "tactnet3d-fc32",
        config: TactNet3dConfig { hidden: 32, ..ACTIVE_CONFIG },
        ..TactNet3d::ACTIVE
    };
    /// Paper 002, Table I, fourth row.
    pub const ACTIVE_8_16_32: TactNet3d =
        TactNet3d { name: "tactnet3d-8-16-32", filters: &[8, 16, 32], ..TactNet3d::ACTIVE };
    /// Paper 003, Fig. 4.
    pub const PALPATION: TactNet3d = TactNet3d {
        name: "tactnet3d-51",
        filters: &[16, 32],
        kernels: PALPATION_KERNELS,
        config: TactNet3dConfig { classes: 24, frames: 51, dropout: 0.7, ..ACTIVE_CONFIG },
    };
}

impl Architecture for TactNet3d {
    fn graph(&self) -> Result<Graph> {
        let TactNet3dConfig { classes, in_channels, height, width, frames, hidden, pool, dropout } =
            self.config;
        for (key, value, least, most) in [
            ("classes", classes, 2, 65_536),
            ("in_channels", in_channels, 1, 65_536),
            ("height", height, 1, 4096),
            ("width", width, 1, 4096),
            ("frames", frames, 1, 4096),
            ("hidden", hidden, 1, 65_536),
            ("pool", pool, 1, 4096),
        ] {
            if !(least..=most).contains(&value) {
                return Err(Error::config(key, value, &format!("must be in {least}..={most}")));
            }
        }
        if !(0.0..1.0).contains(&dropout) {
            return Err(Error::config("dropout", dropout, "must be at least 0 and below 1"));
        }
        let net = Network::new(self.name);
        let mut x = net.input("tensor", &[in_channels, height, width, frames]);
        for (i, &filters) in self.filters.iter().enumerate() {
            let kernel = self.kernels[i.min(1)];
            x = x.conv(&format!("convs.{i}"), Conv::new(filters, kernel)).bn_relu(&format!("bns.{i}"));
            if pool > 1 {
                x = x.max_pool(Pool::new(pool));
            }
        }
        let hidden = x.flatten().linear("fc3", hidden).relu().dropout(dropout);
        net.finish(&[("logits", hidden.linear("fc4", classes))])
    }
}
