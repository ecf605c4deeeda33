//! DS-CNN-1D: depthwise separable convolutions over time, for processors with little memory.
//!
//! # Reference
//! Zhang, Suda, Lai and Chandra 2017, "Hello Edge: Keyword Spotting on Microcontrollers" (arXiv:1711.07128), the small
//! DS-CNN: one convolution of 64 filters, 10 wide in time with stride 2; four times a depthwise convolution of 3 and
//! a pointwise one of 64 filters; average pooling. Batch norm and ReLU follow every convolution.
//!
//! # Departures
//! The paper convolves over time and frequency. Sensors are not in the order of a spectrum, so the kernels here span time
//! only, and the first convolution reads all sensors. The defaults are those of five fingertip sensors. Convolutions
//! have no bias, since batch norm follows; the first one has 4 zeros on both sides.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Conv, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least};

const FILTERS: usize = 64;
const BLOCKS: usize = 4;

pub(crate) const DS_CNN: Listing<DsCnnConfig> = Listing {
    name: "ds-cnn-1d",
    family: crate::FAMILY,
    paper: "Zhang et al. 2017",
    config: DsCnnConfig { classes: 3, in_channels: 5, length: 50 },
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 21_699, statistics: 1_152, macs: 508_992 },
    quick: &[],
};

/// `signal` `[in_channels, length]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DsCnnConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Sensors, rows of the recording, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 2.
    pub length: usize,
}

impl Default for DsCnnConfig {
    fn default() -> Self {
        DS_CNN.config
    }
}

impl Architecture for DsCnnConfig {
    fn graph(&self) -> Result<Graph> {
        let DsCnnConfig { classes, in_channels, length } = *self;
        at_least(&[("classes", classes, 1), ("in_channels", in_channels, 1), ("length", length, 2)])?;
        let net = Network::new(DS_CNN.name);
        let mut x = net
            .input("signal", &[in_channels, length])
            .conv_bn_relu("stem", Conv::new(FILTERS, 10).stride(2).pad(4).no_bias());
        for i in 0..BLOCKS {
            x = x
                .conv_bn_relu(
                    &format!("blocks.{i}.depthwise"),
                    Conv::new(FILTERS, 3).same().groups(FILTERS).no_bias(),
                )
                .conv_bn_relu(&format!("blocks.{i}.pointwise"), Conv::new(FILTERS, 1).no_bias());
        }
        net.finish(&[("logits", x.global_average_pool().linear("fc", classes))])
    }
}
