//! AlexNet: five convolutions and three fully connected layers.
//!
//! # Reference
//! Krizhevsky 2014, "One weird trick for parallelizing convolutional neural networks", as torchvision's `alexnet`.
//! Compared with in paper 001 (transfer of learning from vision to touch), Tables 1–5.
//!
//! # Departures
//! Paper 001's MATLAB network is that of 2012, with two channel groups and response normalisation; torchvision's
//! has neither, and its checkpoints are what users have. Images that leave another size than 6×6 are pooled to
//! that, as torchvision does; there is nothing to pool at 224×224.

use taxel_graph::{Architecture, Conv, Graph, Network, Pool, Result};

use crate::HiddenConfig;

/// Number in torchvision's `features`, filters, kernel, stride, padding, whether a 3/2 max-pool follows.
const LAYERS: [(usize, usize, usize, usize, usize, bool); 5] = [
    (0, 64, 11, 4, 2, true),
    (3, 192, 5, 1, 2, true),
    (6, 384, 3, 1, 1, false),
    (8, 256, 3, 1, 1, false),
    (10, 256, 3, 1, 1, true),
];

/// Rows and columns; the pools leave nothing of less.
const LEAST_SIDE: usize = 63;

/// AlexNet with its configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct AlexNet(
    /// Sizes.
    pub HiddenConfig,
);

impl Architecture for AlexNet {
    fn graph(&self) -> Result<Graph> {
        let HiddenConfig { classes, hidden, dropout, .. } = self.0;
        self.0.check(LEAST_SIDE)?;
        let net = Network::new("alexnet");
        let mut x = net.input("image", &self.0.shape());
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
