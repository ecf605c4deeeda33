//! VGG16: thirteen convolutions of 3 and three fully connected layers.
//!
//! # Reference
//! Simonyan and Zisserman 2015, "Very Deep Convolutional Networks for Large-Scale Image Recognition", Table 1,
//! column D; torchvision's `vgg16` for names and initial weights. Compared with in Kaewrakmuk and Srinonchat 2026,
//! Table 5: 512.2 MB, 30.9459 GFLOPs, and in Rouhafzay et al. 2021, Tables 1–5.
//!
//! # Departures
//! Images that leave another size than 7×7 are pooled to that, as torchvision does; there is nothing to pool
//! at 224×224.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Fill, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result, at_least,
    share,
};

use crate::check_image;

/// Table 1, column D: filters and number of convolutions before each max-pool.
const GROUPS: [(usize, usize); 5] = [(64, 2), (128, 2), (256, 3), (512, 3), (512, 3)];

pub(crate) const VGG16: Listing<Vgg16Config> = Listing {
    name: "vgg16",
    family: crate::FAMILY,
    paper: "Simonyan and Zisserman 2015; Kaewrakmuk and Srinonchat 2026, Table 5",
    config: Vgg16Config { classes: 3, in_channels: 3, height: 224, width: 224, hidden: 4096, dropout: 0.5 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 134_272_835, statistics: 0, macs: 15_466_180_608 },
    quick: &[("hidden", 64), ("height", 40), ("width", 48)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vgg16Config {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 32: the pools leave nothing of less.
    pub height: usize,
    /// Columns, at least 32.
    pub width: usize,
    /// Units of each of the two fully connected layers before the last, at least 1.
    pub hidden: usize,
    /// Share of their values dropped in training, in 0..1.
    pub dropout: f32,
}

impl Default for Vgg16Config {
    fn default() -> Self {
        VGG16.config
    }
}

impl Architecture for Vgg16Config {
    fn graph(&self) -> Result<Graph> {
        let Vgg16Config { classes, in_channels, height, width, hidden, dropout } = *self;
        let image = [in_channels, height, width];
        check_image(classes, image, 32)?;
        at_least(&[("hidden", hidden, 1)])?;
        share("dropout", dropout)?;
        let net = Network::new(VGG16.name);
        net.conv_init(Fill::KaimingNormalFanOut, Fill::Constant(0.0));
        net.linear_init(Fill::Normal { sd: 0.01 }, Fill::Constant(0.0));
        let mut x = net.input("image", &image);
        // torchvision numbers ReLUs and pools as well.
        let mut number = 0;
        for (filters, convolutions) in GROUPS {
            for _ in 0..convolutions {
                x = x.conv(&format!("features.{number}"), Conv::new(filters, 3).pad(1)).relu();
                number += 2;
            }
            x = x.max_pool(Pool::new(2));
            number += 1;
        }
        let x = crate::pooled_to(&x, 7).flatten().linear("classifier.0", hidden).relu().dropout(dropout);
        let x = x.linear("classifier.3", hidden).relu().dropout(dropout);
        net.finish(&[("logits", x.linear("classifier.6", classes))])
    }
}
