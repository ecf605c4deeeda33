//! Hybrid-CNN: a 1D branch on the signal and a 2D branch on its image, fused before the classifier.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, section 3.2, Eqs. 1–3, Fig. 2; ablation of the FC
//! head in Table 4.
//!
//! # Departures
//! None known.

use serde::{Deserialize, Serialize};
use taxel_graph::{Architecture, Graph, InputKeys, Listing, Network, NetworkCounts, Result, at_least};

use crate::Body;

/// Inputs of both branches.
const INPUTS: [InputKeys; 2] =
    [InputKeys::SIGNAL, InputKeys { name: "image", keys: &["image_channels", "height", "width"] }];

pub(crate) const HYBRID_VGG: Listing<HybridConfig> = Listing {
    name: HybridConfig::VGG.branches.name,
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.2",
    config: HybridConfig::VGG,
    inputs: &INPUTS,
    counts: NetworkCounts { parameters: 139_587, statistics: 960, macs: 19_993_184 },
    quick: &[],
};

pub(crate) const HYBRID_RESNET: Listing<HybridConfig> = Listing {
    name: HybridConfig::RESNET.branches.name,
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.2",
    config: HybridConfig::RESNET,
    inputs: &INPUTS,
    counts: NetworkCounts { parameters: 55_203, statistics: 832, macs: 11_624_768 },
    quick: &[],
};

pub(crate) const HYBRID_DENSENET: Listing<HybridConfig> = Listing {
    name: HybridConfig::DENSENET.branches.name,
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.2",
    config: HybridConfig::DENSENET,
    inputs: &INPUTS,
    counts: NetworkCounts { parameters: 38_435, statistics: 960, macs: 11_210_608 },
    quick: &[],
};

pub(crate) const HYBRID_RESVGG: Listing<HybridConfig> = Listing {
    name: HybridConfig::RESVGG.branches.name,
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, section 3.2",
    config: HybridConfig::RESVGG,
    inputs: &INPUTS,
    counts: NetworkCounts { parameters: 116_547, statistics: 896, macs: 19_744_624 },
    quick: &[],
};

pub(crate) const HYBRID_RESVGG_NOFC: Listing<HybridConfig> = Listing {
    name: HybridConfig::RESVGG_NOFC.branches.name,
    family: crate::FAMILY,
    paper: "Kaewrakmuk and Srinonchat 2026, Table 4",
    config: HybridConfig::RESVGG_NOFC,
    inputs: &INPUTS,
    counts: NetworkCounts { parameters: 112_035, statistics: 896, macs: 19_740_160 },
    quick: &[],
};

/// A hybrid: `signal` [in_channels, length] + `image` [image_channels, height, width] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HybridConfig {
    /// Which of the five; no setting.
    #[serde(skip)]
    pub branches: Branches,
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Sensors of the signal, at least 1.
    pub in_channels: usize,
    /// Samples of the signal in time, at least 1.
    pub length: usize,
    /// Colour planes of the image, at least 1.
    pub image_channels: usize,
    /// Rows of the image, at least 1.
    pub height: usize,
    /// Columns of the image, at least 1.
    pub width: usize,
}

/// The two branches of a hybrid and how they are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Branches {
    /// Registry name.
    pub name: &'static str,
    /// 1D body of the signal.
    pub temporal: Body,
    /// 2D body of the image.
    pub spatial: Body,
    /// Fusion head.
    pub fusion: Fusion,
}

/// The layers between the joined features and the classifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fusion {
    /// A fully connected layer of half the width and ReLU (Eqs. 2–3).
    FullyConnected,
    /// Nothing: the ablation of Table 4.
    None,
}

impl HybridConfig {
    /// `hybrid-vgg`, section 3.2.
    pub const VGG: HybridConfig = HybridConfig::of("hybrid-vgg", Body::Vgg6, Body::Vgg6);
    /// `hybrid-resnet`, section 3.2.
    pub const RESNET: HybridConfig = HybridConfig::of("hybrid-resnet", Body::ResNet8, Body::ResNet8);
    /// `hybrid-densenet`, section 3.2.
    pub const DENSENET: HybridConfig = HybridConfig::of("hybrid-densenet", Body::DenseNet6, Body::DenseNet6);
    /// `hybrid-resvgg`, section 3.2: what the paper proposes.
    pub const RESVGG: HybridConfig = HybridConfig::of("hybrid-resvgg", Body::ResNet8, Body::Vgg6);
    /// `hybrid-resvgg-nofc`, Table 4.
    pub const RESVGG_NOFC: HybridConfig = HybridConfig {
        branches: Branches {
            name: "hybrid-resvgg-nofc",
            fusion: Fusion::None,
            ..HybridConfig::RESVGG.branches
        },
        ..HybridConfig::RESVGG
    };

    /// Returns the configuration of two bodies with the paper's fusion and sizes.
    const fn of(name: &'static str, temporal: Body, spatial: Body) -> Self {
        HybridConfig {
            branches: Branches { name, temporal, spatial, fusion: Fusion::FullyConnected },
            classes: 3,
            in_channels: 5,
            length: 50,
            image_channels: 3,
            height: 50,
            width: 50,
        }
    }
}

impl Default for HybridConfig {
    fn default() -> Self {
        HybridConfig::RESVGG
    }
}

impl Architecture for HybridConfig {
    fn with(&self, settings: Self) -> Self {
        HybridConfig { branches: self.branches, ..settings }
    }

    fn graph(&self) -> Result<Graph> {
        let HybridConfig { branches, classes, in_channels, length, image_channels, height, width } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 1),
            ("length", length, 1),
            ("image_channels", image_channels, 1),
            ("height", height, 1),
            ("width", width, 1),
        ])?;
        let net = Network::new(branches.name);
        let signal = net.input("signal", &[in_channels, length]).within("temporal");
        let image = net.input("image", &[image_channels, height, width]).within("spatial");
        let joined =
            net.concat("fusion", &[&branches.temporal.features(signal), &branches.spatial.features(image)]);
        let fused = match branches.fusion {
            Fusion::FullyConnected => {
                let half = joined.shape().iter().sum::<usize>() / 2;
                joined.linear("fuse", half).relu()
            }
            Fusion::None => joined,
        };
        net.finish(&[("logits", fused.linear("fc", classes))])
    }
}
