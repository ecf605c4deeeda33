//! ResNet18: residual blocks of two convolutions.
//!
//! # Reference
//! He et al. 2016, "Deep Residual Learning for Image Recognition", Table 1; torchvision's `resnet18` for names,
//! padding and initial weights. Compared with in paper 000 (Hybrid-CNN hardness recognition), Table 5, and in
//! paper 004, Table 2.
//!
//! # Departures
//! Paper 000 counts 1.7965 GFLOPs; no counting convention tried gives that (1·MAC is 0.9 % above).

use taxel_graph::{Architecture, Conv, Fill, Flow, Graph, Network, Pool, Result};

use crate::ImageConfig;

/// Table 1: filters of the four groups of blocks; each but the first starts with a stride of 2.
const FILTERS: [usize; 4] = [64, 128, 256, 512];

/// Which of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResNetDepth {
    /// Two blocks of two convolutions per group.
    Eighteen,
}

impl ResNetDepth {
    /// Registry name and blocks per group.
    fn table(self) -> (&'static str, [usize; 4]) {
        match self {
            ResNetDepth::Eighteen => ("resnet18", [2, 2, 2, 2]),
        }
    }
}

/// A ResNet with its configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResNet {
    /// Number of layers with weights.
    pub depth: ResNetDepth,
    /// Sizes.
    pub config: ImageConfig,
}

impl Architecture for ResNet {
    fn graph(&self) -> Result<Graph> {
        self.config.check()?;
        let (name, groups) = self.depth.table();
        let net = Network::new(name);
        net.conv_init(Fill::KaimingNormalFanOut, Fill::Pytorch);
        let image = net.input("image", &self.config.shape());
        let stem = image.conv("conv1", Conv::new(64, 7).stride(2).pad(3).no_bias()).bn_relu("bn1");
        let mut x = stem.max_pool(Pool::new(3).stride(2).pad(1));
        for (g, (filters, blocks)) in FILTERS.into_iter().zip(groups).enumerate() {
            for b in 0..blocks {
                let stride = if g > 0 && b == 0 { 2 } else { 1 };
                x = basic(&x, &format!("layer{}.{b}", g + 1), filters, stride);
            }
        }
        net.finish(&[("logits", x.global_average_pool().linear("fc", self.config.classes))])
    }
}

fn basic(x: &Flow, name: &str, filters: usize, stride: usize) -> Flow {
    let part = |suffix: &str| format!("{name}.{suffix}");
    let main = x
        .conv(&part("conv1"), Conv::new(filters, 3).stride(stride).pad(1).no_bias())
        .bn_relu(&part("bn1"))
        .conv(&part("conv2"), Conv::new(filters, 3).pad(1).no_bias())
        .batch_norm(&part("bn2"));
    main.add(&shortcut(x, name, filters, stride)).relu()
}

/// The input itself, or a 1×1 convolution of it where shape or width changes.
fn shortcut(x: &Flow, name: &str, filters: usize, stride: usize) -> Flow {
    if stride == 1 && x.shape().first() == Some(&filters) {
        return x.clone();
    }
    x.conv(&format!("{name}.downsample.0"), Conv::new(filters, 1).stride(stride).no_bias())
        .batch_norm(&format!("{name}.downsample.1"))
}
