//! DenseNet201: every layer reads all layers before it in its block.
//!
//! # Reference
//! Huang et al. 2017, "Densely Connected Convolutional Networks", Table 1; torchvision's `densenet201` for names
//! and initial weights. Compared with in Kaewrakmuk and Srinonchat 2026, Table 5: 70 MB,
//! 3.5720 GFLOPs.
//!
//! # Departures
//! No counting convention tried gives the GFLOPs of Kaewrakmuk and Srinonchat 2026; 1·MAC is 4.2895.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Fill, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result,
};

use crate::check_image;

/// Table 1: layers of the four dense blocks.
const LAYERS: [usize; 4] = [6, 12, 48, 32];
/// Filters that each layer adds; its 1×1 convolution has four times as many.
const GROWTH: usize = 32;

pub(crate) const DENSENET201: Listing<DenseNet201Config> = Listing {
    name: "densenet201",
    family: crate::FAMILY,
    paper: "Huang et al. 2017; Kaewrakmuk and Srinonchat 2026, Table 5",
    config: DenseNet201Config { classes: 3, in_channels: 3, height: 224, width: 224 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 18_098_691, statistics: 229_056, macs: 4_289_451_648 },
    quick: &[("height", 40), ("width", 36)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DenseNet201Config {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 29: the pools leave nothing of less.
    pub height: usize,
    /// Columns, at least 29.
    pub width: usize,
}

impl Default for DenseNet201Config {
    fn default() -> Self {
        DENSENET201.config
    }
}

impl Architecture for DenseNet201Config {
    fn graph(&self) -> Result<Graph> {
        let DenseNet201Config { classes, in_channels, height, width } = *self;
        let shape = [in_channels, height, width];
        check_image(classes, shape, 29)?;
        let net = Network::new(DENSENET201.name);
        net.conv_init(Fill::KaimingNormalFanIn, Fill::Pytorch);
        net.linear_init(Fill::Pytorch, Fill::Constant(0.0));
        let image = net.input("image", &shape);
        let stem = image
            .conv("features.conv0", Conv::new(64, 7).stride(2).pad(3).no_bias())
            .bn_relu("features.norm0");
        let mut x = stem.max_pool(Pool::new(3).stride(2).pad(1));
        for (block, layers) in (1..).zip(LAYERS) {
            for layer in 1..=layers {
                x = dense(&x, &format!("features.denseblock{block}.denselayer{layer}"));
            }
            if block < LAYERS.len() {
                x = transition(&x, &format!("features.transition{block}"));
            }
        }
        let features = x.bn_relu("features.norm5").global_average_pool();
        net.finish(&[("logits", features.linear("classifier", classes))])
    }
}

fn dense(x: &Flow, name: &str) -> Flow {
    let grown = x
        .bn_relu(&format!("{name}.norm1"))
        .conv(&format!("{name}.conv1"), Conv::new(4 * GROWTH, 1).no_bias())
        .bn_relu(&format!("{name}.norm2"))
        .conv(&format!("{name}.conv2"), Conv::new(GROWTH, 3).pad(1).no_bias());
    x.concat(&grown)
}

/// Halves the channels, the rows and the columns.
fn transition(x: &Flow, name: &str) -> Flow {
    let channels = x.shape().first().copied().unwrap_or_default();
    x.bn_relu(&format!("{name}.norm"))
        .conv(&format!("{name}.conv"), Conv::new(channels / 2, 1).no_bias())
        .average_pool(Pool::new(2))
}
