#![doc = include_str!("../README.md")]

mod mobilenet_v2;
mod resnet;

pub use mobilenet_v2::MobileNetV2Config;
pub use resnet::{ResNet, ResNetDepth};

use serde::{Deserialize, Serialize};
use taxel_graph::{Error, Result};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageConfig {
    /// Output classes, at least 2.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1; networks say where more is needed.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl ImageConfig {
    /// A colour image of 224×224, the size all of these networks were published with.
    pub const fn colour(classes: usize) -> Self {
        ImageConfig { classes, in_channels: 3, height: 224, width: 224 }
    }

    fn check(&self) -> Result<()> {
        let &ImageConfig { classes, in_channels, height, width } = self;
        in_range(&[
            ("classes", classes, 2),
            ("in_channels", in_channels, 1),
            ("height", height, 1),
            ("width", width, 1),
        ])
    }

    fn shape(&self) -> [usize; 3] {
        [self.in_channels, self.height, self.width]
    }
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
