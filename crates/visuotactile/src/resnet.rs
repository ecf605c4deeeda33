//! ResNet18 and ResNet50: residual blocks of two convolutions, or of three with a narrow one between.
//!
//! # Reference
//! He et al. 2016, "Deep Residual Learning for Image Recognition", Table 1; torchvision's `resnet18` and
//! `resnet50` for names, padding and initial weights. ResNet18 is compared with in Kaewrakmuk and Srinonchat 2026,
//! Table 5, and in Zhang et al. 2022, Table 2; ResNet50 in Rouhafzay et al. 2021, Tables 1–5, and in Pastor et al. 2019.
//!
//! # Departures
//! ResNet50 has its strides in the convolutions of 3, as torchvision; He et al. have them in the 1×1 before. Kaewrakmuk
//! and Srinonchat count 1.7965 GFLOPs for ResNet18; no counting convention tried gives that (1·MAC is 0.9 % above).

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Fill, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result,
};

use crate::check_image;

/// Table 1: widths of the four groups of blocks; each but the first starts with a stride of 2.
const WIDTHS: [usize; 4] = [64, 128, 256, 512];

pub(crate) const RESNET18: Listing<ResNetConfig> = Listing {
    name: "resnet18",
    family: crate::FAMILY,
    paper: "He et al. 2016; Kaewrakmuk and Srinonchat 2026, Table 5",
    config: ResNetConfig::EIGHTEEN,
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 11_178_051, statistics: 9_600, macs: 1_813_562_880 },
    quick: &[("height", 40), ("width", 36)],
};

pub(crate) const RESNET50: Listing<ResNetConfig> = Listing {
    name: "resnet50",
    family: crate::FAMILY,
    paper: "He et al. 2016; Rouhafzay et al. 2021, Tables 1-5",
    config: ResNetConfig::FIFTY,
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 23_520_326, statistics: 53_120, macs: 4_087_148_544 },
    quick: &[("height", 40), ("width", 36)],
};

/// Which of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResNetDepth {
    /// Two blocks of two convolutions per group.
    Eighteen,
    /// 3, 4, 6 and 3 blocks of three convolutions.
    Fifty,
}

impl ResNetDepth {
    /// Returns the registry name, the blocks per group and the block.
    fn table(self) -> (&'static str, [usize; 4], ResidualBlock) {
        match self {
            ResNetDepth::Eighteen => (RESNET18.name, [2, 2, 2, 2], basic),
            ResNetDepth::Fifty => (RESNET50.name, [3, 4, 6, 3], bottleneck),
        }
    }
}

/// Input, name, width, stride.
type ResidualBlock = fn(&Flow, &str, usize, usize) -> Flow;

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ResNetConfig {
    /// Which of them; no setting.
    #[serde(skip)]
    pub depth: ResNetDepth,
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl ResNetConfig {
    /// `resnet18` with the classes of Kaewrakmuk and Srinonchat 2026.
    pub const EIGHTEEN: ResNetConfig =
        ResNetConfig { depth: ResNetDepth::Eighteen, classes: 3, in_channels: 3, height: 224, width: 224 };
    /// `resnet50` with the classes of Rouhafzay et al. 2021.
    pub const FIFTY: ResNetConfig =
        ResNetConfig { depth: ResNetDepth::Fifty, classes: 6, ..ResNetConfig::EIGHTEEN };
}

impl Default for ResNetConfig {
    fn default() -> Self {
        ResNetConfig::EIGHTEEN
    }
}

impl Architecture for ResNetConfig {
    fn with(&self, settings: Self) -> Self {
        ResNetConfig { depth: self.depth, ..settings }
    }

    fn graph(&self) -> Result<Graph> {
        let ResNetConfig { depth, classes, in_channels, height, width } = *self;
        let shape = [in_channels, height, width];
        check_image(classes, shape, 1)?;
        let (name, groups, block) = depth.table();
        let net = Network::new(name);
        net.conv_init(Fill::KaimingNormalFanOut, Fill::Pytorch);
        let image = net.input("image", &shape);
        let stem = image.conv("conv1", Conv::new(64, 7).stride(2).pad(3).no_bias()).bn_relu("bn1");
        let mut x = stem.max_pool(Pool::new(3).stride(2).pad(1));
        for (g, (width, blocks)) in WIDTHS.into_iter().zip(groups).enumerate() {
            for b in 0..blocks {
                let stride = if g > 0 && b == 0 { 2 } else { 1 };
                x = block(&x, &format!("layer{}.{b}", g + 1), width, stride);
            }
        }
        net.finish(&[("logits", x.global_average_pool().linear("fc", classes))])
    }
}

fn basic(x: &Flow, name: &str, width: usize, stride: usize) -> Flow {
    let part = |suffix: &str| format!("{name}.{suffix}");
    let main = x
        .conv(&part("conv1"), Conv::new(width, 3).stride(stride).pad(1).no_bias())
        .bn_relu(&part("bn1"))
        .conv(&part("conv2"), Conv::new(width, 3).pad(1).no_bias())
        .batch_norm(&part("bn2"));
    main.add(&shortcut(x, name, width, stride)).relu()
}

/// Applies a narrow 1×1, a 3×3, then a 1×1 four times as wide.
fn bottleneck(x: &Flow, name: &str, width: usize, stride: usize) -> Flow {
    let part = |suffix: &str| format!("{name}.{suffix}");
    let main = x
        .conv(&part("conv1"), Conv::new(width, 1).no_bias())
        .bn_relu(&part("bn1"))
        .conv(&part("conv2"), Conv::new(width, 3).stride(stride).pad(1).no_bias())
        .bn_relu(&part("bn2"))
        .conv(&part("conv3"), Conv::new(4 * width, 1).no_bias())
        .batch_norm(&part("bn3"));
    main.add(&shortcut(x, name, 4 * width, stride)).relu()
}

/// Returns the input itself, or a 1×1 convolution of it where shape or width changes.
fn shortcut(x: &Flow, name: &str, filters: usize, stride: usize) -> Flow {
    if stride == 1 && x.shape().first() == Some(&filters) {
        return x.clone();
    }
    x.conv(&format!("{name}.downsample.0"), Conv::new(filters, 1).stride(stride).no_bias())
        .batch_norm(&format!("{name}.downsample.1"))
}
