#![doc = include_str!("../README.md")]

mod alexnet;
mod densenet;
mod googlenet;
mod mnasnet;
mod mobilenet_v2;
mod mobilenet_v2_split;
mod resnet;
mod shufflenet_v2;
mod vgg;

pub use alexnet::AlexNet;
pub use densenet::DenseNet201;
pub use googlenet::GoogLeNetConfig;
pub use mnasnet::MnasNetConfig;
pub use mobilenet_v2::MobileNetV2Config;
pub use mobilenet_v2_split::MobileNetV2SplitConfig;
pub use resnet::{ResNet, ResNetDepth};
pub use shufflenet_v2::ShuffleNetV2;
pub use vgg::Vgg16;

use serde::{Deserialize, Serialize};
use taxel_graph::{Error, Flow, Result};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageConfig {
    /// Output classes, at least 2.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows; the network says how many it needs.
    pub height: usize,
    /// Columns, likewise.
    pub width: usize,
}

impl ImageConfig {
    /// A colour image of 224×224, the size all of these networks were published with.
    pub const fn colour(classes: usize) -> Self {
        ImageConfig { classes, in_channels: 3, height: 224, width: 224 }
    }

    /// Paper 004: two fingers of 23 readings, 300 ticks, twenty outputs.
    pub const fn fingers() -> Self {
        ImageConfig { classes: 20, in_channels: 2, height: 23, width: 300 }
    }

    /// `side` is the least number of rows and of columns.
    fn check(&self, side: usize) -> Result<()> {
        let &ImageConfig { classes, in_channels, height, width } = self;
        in_range(&[
            ("classes", classes, 2),
            ("in_channels", in_channels, 1),
            ("height", height, side),
            ("width", width, side),
        ])
    }

    fn shape(&self) -> [usize; 3] {
        [self.in_channels, self.height, self.width]
    }
}

/// The same with two wide fully connected layers: `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HiddenConfig {
    /// Output classes, at least 2.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows; the network says how many it needs.
    pub height: usize,
    /// Columns, likewise.
    pub width: usize,
    /// Units of each of the two fully connected layers before the last, at least 1.
    pub hidden: usize,
    /// Share of their values dropped in training, in 0..1.
    pub dropout: f32,
}

impl HiddenConfig {
    /// A colour image of 224×224 and the published width of 4096.
    pub const fn colour(classes: usize) -> Self {
        HiddenConfig { classes, in_channels: 3, height: 224, width: 224, hidden: 4096, dropout: 0.5 }
    }

    /// `side` is the least number of rows and of columns.
    fn check(&self, side: usize) -> Result<()> {
        let &HiddenConfig { classes, in_channels, height, width, hidden, dropout } = self;
        ImageConfig { classes, in_channels, height, width }.check(side)?;
        in_range(&[("hidden", hidden, 1)])?;
        check_dropout(dropout)
    }

    fn shape(&self) -> [usize; 3] {
        [self.in_channels, self.height, self.width]
    }
}

/// Averaged to `size` rows and columns, where it has others.
fn pooled_to(x: &Flow, size: usize) -> Flow {
    if x.shape().get(1..) == Some(&[size, size]) { x.clone() } else { x.adaptive_average_pool(size) }
}

/// Refuses values below their least, and absurd ones (which would only fail later, when memory runs out).
fn in_range(values: &[(&str, usize, usize)]) -> Result<()> {
    for &(key, value, least) in values {
        if !(least..=65_536).contains(&value) {
            return Err(Error::config(key, value, &format!("must be in {least}..=65536")));
        }
    }
    Ok(())
}

fn check_dropout(dropout: f32) -> Result<()> {
    if (0.0..1.0).contains(&dropout) {
        return Ok(());
    }
    Err(Error::config("dropout", dropout, "must be at least 0 and below 1"))
}
