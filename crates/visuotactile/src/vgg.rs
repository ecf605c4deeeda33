//! VGG16: thirteen convolutions of 3 and three fully connected layers.
//!
//! # Reference
//! Simonyan and Zisserman 2015, "Very Deep Convolutional Networks for Large-Scale Image Recognition", Table 1,
//! column D; torchvision's `vgg16` for names and initial weights. Compared with in paper 000 (Hybrid-CNN
//! hardness recognition), Table 5: 512.2 MB, 30.9459 GFLOPs, and in paper 001, Tables 1–5.
//!
//! # Departures
//! Images that leave another size than 7×7 are pooled to that, as torchvision does; there is nothing to pool
//! at 224×224.

use taxel_graph::{Architecture, Conv, Fill, Graph, Network, Pool, Result};

use crate::HiddenConfig;

/// Table 1, column D: filters and number of convolutions before each max-pool.
const GROUPS: [(usize, usize); 5] = [(64, 2), (128, 2), (256, 3), (512, 3), (512, 3)];

/// Rows and columns; the pools leave nothing of less.
const LEAST_SIDE: usize = 32;

/// VGG16 with its configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Vgg16(
    /// Sizes.
    pub HiddenConfig,
);

impl Architecture for Vgg16 {
    fn graph(&self) -> Result<Graph> {
        let HiddenConfig { classes, hidden, dropout, .. } = self.0;
        self.0.check(LEAST_SIDE)?;
        let net = Network::new("vgg16");
        net.conv_init(Fill::KaimingNormalFanOut, Fill::Constant(0.0));
        net.linear_init(Fill::Normal { sd: 0.01 }, Fill::Constant(0.0));
        let mut x = net.input("image", &self.0.shape());
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
