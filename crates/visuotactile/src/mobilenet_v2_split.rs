//! MobileNetV2 with two streams, vision and touch, that share their middle.
//!
//! # Reference
//! Rouhafzay et al. 2021, section 7, Fig. 5: MATLAB's layers 2–17 per stream,
//! 18–139 shared, 140–154 per stream; 11,652 KB in place of 16,644 KB.
//!
//! # Departures
//! Without dropout. The paper stitches it from two trained networks and only predicts with it (`Weights::stitched`);
//! trained directly, the losses of both outputs add up. The switch looks at the standardised channels, which are
//! constant where the raw ones are; "zero variance" is taken exactly, largest value = smallest, and per sample.
//! Where both streams are lit their features add up, which the paper leaves open.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Error, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least,
};

use crate::mobilenet_v2::{blocks, conv_bn, initial_weights, last, stem};

/// MATLAB's layer 17 ends block 2 of torchvision's `features`, layer 139 ends block 16.
const SHARED: std::ops::RangeInclusive<usize> = 3..=16;

pub(crate) const MOBILENET_V2_SPLIT: Listing<MobileNetV2SplitConfig> = Listing {
    name: "mobilenet-v2-split",
    family: crate::FAMILY,
    paper: "Rouhafzay et al. 2021, section 7",
    config: MobileNetV2SplitConfig { classes: 6, in_channels: 6, height: 224, width: 224 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 3_132_284, statistics: 41_756, macs: 392_658_240 },
    quick: &[("height", 40), ("width", 36)],
};

/// `image` `[in_channels, height, width]`, vision before touch → `visual` `[classes]`, `tactile` `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MobileNetV2SplitConfig {
    /// Outputs of each stream: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes of both streams together, an even number of at least 2.
    pub in_channels: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns, at least 1.
    pub width: usize,
}

impl Default for MobileNetV2SplitConfig {
    fn default() -> Self {
        MOBILENET_V2_SPLIT.config
    }
}

impl Architecture for MobileNetV2SplitConfig {
    fn graph(&self) -> Result<Graph> {
        let MobileNetV2SplitConfig { classes, in_channels, height, width } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 2),
            ("height", height, 1),
            ("width", width, 1),
        ])?;
        if in_channels % 2 != 0 {
            return Err(Error::config("in_channels", in_channels, "must be even: vision, then touch"));
        }
        let net = Network::new(MOBILENET_V2_SPLIT.name);
        initial_weights(&net);
        let image = net.input("image", &[in_channels, height, width]).standardize("mean", "std");
        let half = in_channels / 2;
        let entered = |scope: &str, from: usize| {
            let stream = image.slice(from, half);
            let mut x = conv_bn(&stream.clone().within(scope), "features.0.0", "features.0.1", stem(1.0));
            for block in blocks(1.0).iter().filter(|block| block.number < *SHARED.start()) {
                x = block.apply(&x);
            }
            x.switch_scale(&stream).outside()
        };
        let mut x = entered("visual", 0).add(&entered("tactile", half)).within("shared");
        for block in blocks(1.0).iter().filter(|block| SHARED.contains(&block.number)) {
            x = block.apply(&x);
        }
        let left = |scope: &str| {
            let mut x: Flow = x.clone().outside().within(scope);
            for block in blocks(1.0).iter().filter(|block| block.number > *SHARED.end()) {
                x = block.apply(&x);
            }
            let features = conv_bn(&x, "features.18.0", "features.18.1", last(1.0)).global_average_pool();
            features.linear("classifier.1", classes)
        };
        net.finish(&[("visual", left("visual")), ("tactile", left("tactile"))])
    }
}
