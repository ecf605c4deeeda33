//! MnasNet at width 1: inverted residual blocks found by search.
//!
//! # Reference
//! Tan et al. 2019, "MnasNet: Platform-Aware Neural Architecture Search for Mobile", Fig. 7 without squeeze and
//! excitation (MnasNet-B1); torchvision's `mnasnet1_0` for names, momentum and initial weights. Compared with in
//! Zhang et al. 2022, Table 2, on 2×23×300.
//!
//! # Departures
//! None known.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, BATCH_NORM_EPS, Conv, Fill, Flow, Graph, InputKeys, Listing, Network, NetworkCounts,
    Result, share,
};

use crate::check_image;

/// Filters, kernel, stride of the first block, expansion, blocks: torchvision's `layers.8` to `layers.13`.
const STACKS: [(usize, usize, usize, usize, usize); 6] = [
    (24, 3, 2, 3, 3),
    (40, 5, 2, 3, 3),
    (80, 5, 2, 6, 3),
    (96, 3, 1, 6, 2),
    (192, 5, 2, 6, 4),
    (320, 3, 1, 6, 1),
];
/// torchvision takes TensorFlow's 0.9997 for the share that stays.
const MOMENTUM: f32 = 1.0 - 0.9997;

pub(crate) const MNASNET: Listing<MnasNetConfig> = Listing {
    name: "mnasnet1-0",
    family: crate::FAMILY,
    paper: "Tan et al. 2019; Zhang et al. 2022, Table 2",
    config: MnasNetConfig { classes: 20, in_channels: 2, height: 23, width: 300, dropout: 0.2 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 3_127_644, statistics: 37_920, macs: 56_633_936 },
    quick: &[("width", 90)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MnasNetConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
    /// Share of the features dropped in training, in 0..1.
    pub dropout: f32,
}

impl Default for MnasNetConfig {
    fn default() -> Self {
        MNASNET.config
    }
}

impl Architecture for MnasNetConfig {
    fn graph(&self) -> Result<Graph> {
        let MnasNetConfig { classes, in_channels, height, width, dropout } = *self;
        let shape = [in_channels, height, width];
        check_image(classes, shape, 1)?;
        share("dropout", dropout)?;
        let net = Network::new(MNASNET.name);
        net.conv_init(Fill::KaimingNormalFanOut, Fill::Constant(0.0));
        net.linear_init(Fill::KaimingUniformFanOut, Fill::Constant(0.0));
        let image = net.input("image", &shape);
        let stem = conv_bn(&image, "layers", 0, Conv::new(32, 3).stride(2).pad(1)).relu();
        let depthwise = conv_bn(&stem, "layers", 3, Conv::new(32, 3).pad(1).groups(32)).relu();
        let mut x = conv_bn(&depthwise, "layers", 6, Conv::new(16, 1));
        for (number, (filters, kernel, stride, expansion, blocks)) in (8..).zip(STACKS) {
            for i in 0..blocks {
                let stride = if i == 0 { stride } else { 1 };
                x = block(&x, &format!("layers.{number}.{i}.layers"), filters, kernel, stride, expansion);
            }
        }
        let last = conv_bn(&x, "layers", 14, Conv::new(1280, 1)).relu();
        let features = last.global_average_pool().dropout(dropout);
        net.finish(&[("logits", features.linear("classifier.1", classes))])
    }
}

/// Applies convolution `number` without bias and the batch norm after it.
fn conv_bn(x: &Flow, name: &str, number: usize, conv: Conv) -> Flow {
    x.conv(&format!("{name}.{number}"), conv.no_bias()).batch_norm_with(
        &format!("{name}.{}", number + 1),
        BATCH_NORM_EPS,
        MOMENTUM,
    )
}

fn block(x: &Flow, name: &str, filters: usize, kernel: usize, stride: usize, expansion: usize) -> Flow {
    let channels = x.shape().first().copied().unwrap_or_default();
    let wide = channels * expansion;
    let depthwise = Conv::new(wide, kernel).stride(stride).pad(kernel / 2).groups(wide);
    let inner = conv_bn(x, name, 0, Conv::new(wide, 1)).relu();
    let inner = conv_bn(&inner, name, 3, depthwise).relu();
    let y = conv_bn(&inner, name, 6, Conv::new(filters, 1));
    if stride == 1 && channels == filters { y.add(x) } else { y }
}
