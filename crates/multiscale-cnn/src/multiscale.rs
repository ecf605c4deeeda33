//! Multi-scale CNN: a recording at three scales per block, which label elasticity and hardness at once.
//!
//! # Reference
//! Zhang et al. 2022, section 4, Fig. 5, Table 1,
//! Eqs. 4–7.
//!
//! # Departures
//! Eq. 5 puts a sigmoid after each block, Table 1 a leaky ReLU: the table is followed, `activation` offers
//! the other. Read into the text: each convolution is normalised before its pool (Table 1) and scaled after
//! it; a block joins its scales in Eq. 5's order: single, multi, original; the slope of the leaky ReLU is
//! PyTorch's 0.01; the scalars k¹ and k² start at 1; sigmoid follows the first fully connected layer's
//! batch norm (Eq. 6), and the last sigmoid belongs to the loss (Eq. 7). "Normal with mean 0 and standard
//! deviation 1" is taken for weights and biases alike.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Activation, Architecture, Conv, Fill, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool,
    Result, at_least,
};

/// Table 1: filters of the multi-channel convolution of each block (`Conv1_2`, `Conv2_2`, `Conv3_2`). The
/// single-channel one beside it has 1; both have a kernel of 3 and padding 1, every max-pool 2/2.
const MULTI: [usize; 3] = [5, 15, 32];
/// Table 1, Fc1.
const HIDDEN: usize = 512;

/// The activation after the three joined scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BlockActivation {
    /// Table 1.
    LeakyRelu,
    /// Eq. 5.
    Sigmoid,
}

pub(crate) const MULTISCALE_CNN: Listing<MultiscaleConfig> = Listing {
    name: "multiscale-cnn",
    family: crate::FAMILY,
    paper: "Zhang et al. 2022, Table 1",
    config: MultiscaleConfig {
        classes: 20,
        in_channels: 2,
        height: 23,
        width: 300,
        activation: BlockActivation::LeakyRelu,
    },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 2_180_011, statistics: 1_174, macs: 7_488_856 },
    quick: &[],
};

/// `image` `[in_channels, height, width]`, fingers × readings per tick × ticks → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MultiscaleConfig {
    /// Outputs, at least 1: ten levels of elasticity, then ten of hardness.
    pub classes: usize,
    /// Fingers, at least 1.
    pub in_channels: usize,
    /// Readings of one finger per tick, at least 8: three pools halve them.
    pub height: usize,
    /// Ticks, at least 8.
    pub width: usize,
    /// The activation after the joined scales of a block.
    pub activation: BlockActivation,
}

impl Default for MultiscaleConfig {
    fn default() -> Self {
        MULTISCALE_CNN.config
    }
}

impl Architecture for MultiscaleConfig {
    fn graph(&self) -> Result<Graph> {
        let MultiscaleConfig { classes, in_channels, height, width, activation } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 1),
            ("height", height, 8),
            ("width", width, 8),
        ])?;
        let activation = match activation {
            BlockActivation::LeakyRelu => Activation::LeakyRelu { slope: 0.01 },
            BlockActivation::Sigmoid => Activation::Sigmoid,
        };
        let net = Network::new(MULTISCALE_CNN.name);
        let normal = Fill::Normal { sd: 1.0 };
        net.conv_init(normal, normal);
        net.linear_init(normal, normal);
        let mut x = net.input("image", &[in_channels, height, width]);
        for (i, multi) in MULTI.into_iter().enumerate() {
            x = block(&net, &x, &format!("block{}", i + 1), multi).activation(activation);
        }
        let hidden = x.flatten().linear("fc1", HIDDEN).batch_norm("bn1").activation(Activation::Sigmoid);
        net.finish(&[("logits", hidden.linear("fc2", classes).batch_norm("bn2"))])
    }
}

/// Applies eq. 5 up to the activation: the pooled input beside two convolutions of it.
fn block(net: &Network, x: &Flow, name: &str, multi: usize) -> Flow {
    let scale = |part: &str, k: &str, filters: usize| {
        x.conv(&format!("{name}.{part}.conv"), Conv::new(filters, 3).pad(1))
            .batch_norm(&format!("{name}.{part}.bn"))
            .max_pool(Pool::new(2))
            .scale(&format!("{name}.{k}"), 1.0)
    };
    let (single, multi) = (scale("single", "k1", 1), scale("multi", "k2", multi));
    net.concat(&format!("{name}.cat"), &[&single, &multi, &x.max_pool(Pool::new(2))])
}
