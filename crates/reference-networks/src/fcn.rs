//! FCN-1D: three convolutions over time and global average pooling, the field's usual baseline for time series.
//!
//! # Reference
//! Wang, Yan and Oates 2017, "Time Series Classification from Scratch with Deep Neural Networks: A Strong Baseline",
//! section II-B and Fig. 1 (b): kernels of 8, 5 and 3 with 128, 256 and 128 filters, each followed by batch norm and
//! ReLU.
//!
//! # Departures
//! The paper sizes each data set; the defaults are those of five fingertip sensors. Read into the text, after the
//! authors' Keras code: convolutions carry a bias and keep the length, where 3 of the 7 zeros beside a kernel of 8 come
//! first.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Conv, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least};

/// Filters and kernel of each convolution.
const LAYERS: [(usize, usize); 3] = [(128, 8), (256, 5), (128, 3)];

pub(crate) const FCN: Listing<FcnConfig> = Listing {
    name: "fcn-1d",
    family: crate::FAMILY,
    paper: "Wang et al. 2017",
    config: FcnConfig { classes: 3, in_channels: 5, length: 50 },
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 269_187, statistics: 1_024, macs: 13_363_584 },
    quick: &[],
};

/// `signal` `[in_channels, length]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FcnConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Sensors, rows of the recording, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 1.
    pub length: usize,
}

impl Default for FcnConfig {
    fn default() -> Self {
        FCN.config
    }
}

impl Architecture for FcnConfig {
    fn graph(&self) -> Result<Graph> {
        let FcnConfig { classes, in_channels, length } = *self;
        at_least(&[("classes", classes, 1), ("in_channels", in_channels, 1), ("length", length, 1)])?;
        let net = Network::new(FCN.name);
        let mut x = net.input("signal", &[in_channels, length]);
        for (i, (filters, kernel)) in LAYERS.into_iter().enumerate() {
            x = x.conv_bn_relu(&format!("convs.{i}"), Conv::new(filters, kernel).same());
        }
        net.finish(&[("logits", x.global_average_pool().linear("fc", classes))])
    }
}
