//! AlexNet: five convolutions and three fully connected layers.
//!
//! # Reference
//! Krizhevsky 2014, "One weird trick for parallelizing convolutional neural networks", as torchvision's `alexnet`.
//! Compared with in Rouhafzay et al. 2021, Tables 1–5.
//!
//! # Departures
//! The MATLAB network of Rouhafzay et al. is that of 2012, with two channel groups and response normalisation;
//! torchvision's has neither, and its checkpoints are what users have. Images that leave another size than 6×6 are
//! pooled to that, as torchvision does; there is nothing to pool at 224×224.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result, at_least, share,
};

use crate::check_image;

/// Number in torchvision's `features`, filters, kernel, stride, padding, whether a 3/2 max-pool follows.
const LAYERS: [(usize, usize, usize, usize, usize, bool); 5] = [
    (0, 64, 11, 4, 2, true),
    (3, 192, 5, 1, 2, true),
    (6, 384, 3, 1, 1, false),
    (8, 256, 3, 1, 1, false),
    (10, 256, 3, 1, 1, true),
];

pub(crate) const ALEXNET: Listing<AlexNetConfig> = Listing {
    name: "alexnet",
    family: crate::FAMILY,
    paper: "Krizhevsky 2014; Rouhafzay et al. 2021, Tables 1-5",
    config: AlexNetConfig { classes: 6, in_channels: 3, height: 224, width: 224, hidden: 4096, dropout: 0.5 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 57_028_422, statistics: 0, macs: 710_117_056 },
    quick: &[("hidden", 64), ("height", 95), ("width", 79)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AlexNetConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 63: the pools leave nothing of less.
    pub height: usize,
    /// Columns, at least 63.
    pub width: usize,
    /// Units of each of the two fully connected layers before the last, at least 1.
    pub hidden: usize,
    /// Share of their values dropped in training, in 0..1.
    pub dropout: f32,
}

impl Default for AlexNetConfig {
    fn default() -> Self {
        ALEXNET.config
    }
}

impl Architecture for AlexNetConfig {
    fn graph(&self) -> Result<Graph> {
        let AlexNetConfig { classes, in_channels, height, width, hidden, dropout } = *self;
        let image = [in_channels, height, width];
        check_image(classes, image, 63)?;
        at_least(&[("hidden", hidden, 1)])?;
        share("dropout", dropout)?;
        let net = Network::new(ALEXNET.name);
        let mut x = net.input("image", &image);
        for (number, filters, kernel, stride, padding, pool) in LAYERS {
            let conv = Conv::new(filters, kernel).stride(stride).pad(padding);
            x = x.conv(&format!("features.{number}"), conv).relu();
            if pool {
                x = x.max_pool(Pool::new(3).stride(2));
            }
        }
        let x = crate::pooled_to(&x, 6).flatten().dropout(dropout).linear("classifier.1", hidden).relu();
        let x = x.dropout(dropout).linear("classifier.4", hidden).relu();
        net.finish(&[("logits", x.linear("classifier.6", classes))])
    }
}
