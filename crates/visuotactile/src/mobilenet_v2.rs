//! MobileNetV2: inverted residual blocks with linear bottlenecks.
//!
//! # Reference
//! Sandler et al. 2018, "MobileNetV2: Inverted Residuals and Linear Bottlenecks", Table 2; torchvision's `mobilenet_v2`
//! for names, padding, initial weights and the rounding of widths. Compared with in Rouhafzay et al. 2021, Tables 1–6,
//! and in Zhang et al. 2022, Table 2.
//!
//! # Departures
//! Dropout of 0.2 before the classifier is torchvision's; the MATLAB network of Rouhafzay et al. has none (`dropout =
//! 0`).

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Activation, Architecture, Conv, Fill, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Result,
    check_width_mult, share,
};

use crate::check_image;

/// Table 2: expansion, filters, blocks, stride of the first of them.
const ROWS: [(usize, usize, usize, usize); 7] = [
    (1, 16, 1, 1),
    (6, 24, 2, 2),
    (6, 32, 3, 2),
    (6, 64, 4, 2),
    (6, 96, 3, 1),
    (6, 160, 3, 2),
    (6, 320, 1, 1),
];
const STEM: usize = 32;
const LAST: usize = 1280;

pub(crate) const MOBILENET_V2: Listing<MobileNetV2Config> = Listing {
    name: "mobilenet-v2",
    family: crate::FAMILY,
    paper: "Sandler et al. 2018; Rouhafzay et al. 2021, Tables 1-6",
    config: MobileNetV2Config {
        classes: 6,
        in_channels: 3,
        height: 224,
        width: 224,
        width_mult: 1.0,
        dropout: 0.2,
    },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 2_231_558, statistics: 34_112, macs: 299_501_952 },
    quick: &[("height", 40), ("width", 36)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MobileNetV2Config {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1; 32 make one row of features.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
    /// Multiplies every width; the paper's α, above 0 and at most 4.
    pub width_mult: f64,
    /// Share of the features dropped in training, in 0..1.
    pub dropout: f32,
}

impl Default for MobileNetV2Config {
    fn default() -> Self {
        MOBILENET_V2.config
    }
}

impl Architecture for MobileNetV2Config {
    fn graph(&self) -> Result<Graph> {
        let MobileNetV2Config { classes, in_channels, height, width, width_mult, dropout } = *self;
        let shape = [in_channels, height, width];
        check_image(classes, shape, 1)?;
        share("dropout", dropout)?;
        check_width_mult(width_mult)?;
        let net = Network::new(MOBILENET_V2.name);
        initial_weights(&net);
        let image = net.input("image", &shape);
        let mut x = conv_bn(&image, "features.0.0", "features.0.1", stem(width_mult));
        for block in blocks(width_mult) {
            x = block.apply(&x);
        }
        let x = conv_bn(&x, "features.18.0", "features.18.1", last(width_mult));
        let features = x.global_average_pool().dropout(dropout);
        net.finish(&[("logits", features.linear("classifier.1", classes))])
    }
}

/// Sets torchvision's initial weights.
pub(crate) fn initial_weights(net: &Network) {
    net.conv_init(Fill::KaimingNormalFanOut, Fill::Constant(0.0));
    net.linear_init(Fill::Normal { sd: 0.01 }, Fill::Constant(0.0));
}

/// Returns the convolution `features.0`.
pub(crate) fn stem(width_mult: f64) -> Conv {
    Conv::new(rounded(STEM as f64 * width_mult), 3).stride(2).pad(1)
}

/// Returns the convolution `features.18`, which never gets narrower than the paper's.
pub(crate) fn last(width_mult: f64) -> Conv {
    Conv::new(rounded(LAST as f64 * width_mult.max(1.0)), 1)
}

/// Applies a convolution without bias, batch norm and ReLU6.
pub(crate) fn conv_bn(x: &Flow, conv: &str, norm: &str, by: Conv) -> Flow {
    x.conv(conv, by.no_bias()).batch_norm(norm).activation(Activation::Relu6)
}

/// One inverted residual block.
pub(crate) struct InvertedResidual {
    /// Its number in torchvision's `features`, 1 to 17.
    pub number: usize,
    expansion: usize,
    filters: usize,
    stride: usize,
}

/// Lists the blocks of Table 2, one by one.
pub(crate) fn blocks(width_mult: f64) -> Vec<InvertedResidual> {
    let row = |(expansion, filters, repeats, stride): (usize, usize, usize, usize)| {
        let filters = rounded(filters as f64 * width_mult);
        (0..repeats).map(move |i| (expansion, filters, if i == 0 { stride } else { 1 }))
    };
    let all = ROWS.into_iter().flat_map(row).zip(1..);
    all.map(|((expansion, filters, stride), number)| InvertedResidual { number, expansion, filters, stride })
        .collect()
}

impl InvertedResidual {
    pub fn apply(&self, x: &Flow) -> Flow {
        let &InvertedResidual { number, expansion, filters, stride } = self;
        let channels = x.shape().first().copied().unwrap_or_default();
        let wide = channels * expansion;
        let name = |part: &str| format!("features.{number}.conv.{part}");
        let depthwise = Conv::new(wide, 3).stride(stride).pad(1).groups(wide);
        let (inner, project, norm) = if expansion == 1 {
            (conv_bn(x, &name("0.0"), &name("0.1"), depthwise), name("1"), name("2"))
        } else {
            let inner = conv_bn(x, &name("0.0"), &name("0.1"), Conv::new(wide, 1));
            (conv_bn(&inner, &name("1.0"), &name("1.1"), depthwise), name("2"), name("3"))
        };
        let y = inner.conv(&project, Conv::new(filters, 1).no_bias()).batch_norm(&norm);
        if stride == 1 && channels == filters { y.add(x) } else { y }
    }
}

/// Rounds a width to a multiple of 8, at least 8, never more than a tenth below what was asked for.
fn rounded(width: f64) -> usize {
    let nearest = (((width + 4.0) / 8.0).floor() * 8.0).max(8.0);
    (if nearest < 0.9 * width { nearest + 8.0 } else { nearest }) as usize
}
