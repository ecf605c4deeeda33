//! ShuffleNetV2 at width 1: half of the channels pass a block untouched, then all are shuffled.
//!
//! # Reference
//! Ma et al. 2018, "ShuffleNet V2: Practical Guidelines for Efficient CNN Architecture Design", Table 5 and Fig. 3;
//! torchvision's `shufflenet_v2_x1_0` for names. Compared with in Zhang et al. 2022, Table 2, on 2×23×300.
//!
//! # Departures
//! None known.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result,
};

use crate::check_image;

/// Table 5: channels and blocks of stages 2 to 4; each starts with a stride of 2.
const STAGES: [(usize, usize); 3] = [(116, 4), (232, 8), (464, 4)];

pub(crate) const SHUFFLENET_V2: Listing<ShuffleNetV2Config> = Listing {
    name: "shufflenet-v2",
    family: crate::FAMILY,
    paper: "Ma et al. 2018; Zhang et al. 2022, Table 2",
    config: ShuffleNetV2Config { classes: 20, in_channels: 2, height: 23, width: 300 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 1_273_888, statistics: 16_180, macs: 25_809_568 },
    quick: &[("width", 90)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShuffleNetV2Config {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl Default for ShuffleNetV2Config {
    fn default() -> Self {
        SHUFFLENET_V2.config
    }
}

impl Architecture for ShuffleNetV2Config {
    fn graph(&self) -> Result<Graph> {
        let ShuffleNetV2Config { classes, in_channels, height, width } = *self;
        let shape = [in_channels, height, width];
        check_image(classes, shape, 1)?;
        let net = Network::new(SHUFFLENET_V2.name);
        let image = net.input("image", &shape);
        let stem = image.conv("conv1.0", Conv::new(24, 3).stride(2).pad(1).no_bias()).bn_relu("conv1.1");
        let mut x = stem.max_pool(Pool::new(3).stride(2).pad(1));
        for (stage, (channels, blocks)) in (2..).zip(STAGES) {
            for i in 0..blocks {
                let name = format!("stage{stage}.{i}");
                let joined = if i == 0 { downsample(&x, &name, channels / 2) } else { basic(&x, &name) };
                x = joined.channel_shuffle(2);
            }
        }
        let last = x.conv("conv5.0", Conv::new(1024, 1).no_bias()).bn_relu("conv5.1");
        net.finish(&[("logits", last.global_average_pool().linear("fc", classes))])
    }
}

/// Applies Fig. 3 (c): the second half of the channels is convolved.
fn basic(x: &Flow, name: &str) -> Flow {
    let half = x.shape().first().copied().unwrap_or_default() / 2;
    x.slice(0, half).concat(&branch2(&x.slice(half, half), name, half, 1))
}

/// Applies Fig. 3 (d): all channels go both ways.
fn downsample(x: &Flow, name: &str, half: usize) -> Flow {
    let channels = x.shape().first().copied().unwrap_or_default();
    let part = |i: usize| format!("{name}.branch1.{i}");
    let left = depthwise(x, &part(0), &part(1), channels, 2)
        .conv(&part(2), Conv::new(half, 1).no_bias())
        .bn_relu(&part(3));
    left.concat(&branch2(x, name, half, 2))
}

fn branch2(x: &Flow, name: &str, half: usize, stride: usize) -> Flow {
    let part = |i: usize| format!("{name}.branch2.{i}");
    let narrow = x.conv(&part(0), Conv::new(half, 1).no_bias()).bn_relu(&part(1));
    depthwise(&narrow, &part(3), &part(4), half, stride)
        .conv(&part(5), Conv::new(half, 1).no_bias())
        .bn_relu(&part(6))
}

fn depthwise(x: &Flow, conv: &str, norm: &str, channels: usize, stride: usize) -> Flow {
    x.conv(conv, Conv::new(channels, 3).stride(stride).pad(1).groups(channels).no_bias()).batch_norm(norm)
}
