//! DilatedResNet-1D: channels mixed first, two residual blocks, mean, maximum and deviation over time.
//!
//! # Reference
//! taxel's own, for robustness against faults of a sensor: on the quantile code, where every input lies in 0..1 or
//! within ±8, no reading can be larger than those of training. The parts are known: dilation (Yu and Koltun, ICLR
//! 2016), residual blocks (He et al. 2016), mean and deviation over time (statistics pooling, Snyder et al., ICASSP
//! 2018).
//!
//! # Departures
//! None: nothing is published.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Error, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result,
    at_least,
};

/// Name and dilation of the residual blocks; both convolutions of a block have it.
const BLOCKS: [(&str, usize); 2] = [("block1", 1), ("block2", 2)];
/// Share of the mixed channels, and of the pooled features, that training drops.
const DROPPED: [f32; 2] = [0.1, 0.4];
/// Added to the variance over time.
const EPS: f32 = 1e-5;

pub(crate) const DILATED_RESNET: Listing<DilatedResNetConfig> = Listing {
    name: "dilated-resnet-1d",
    family: crate::FAMILY,
    paper: "taxel's own",
    config: DilatedResNetConfig { classes: 3, in_channels: 500, length: 25, width: 64, blocks: BLOCKS.len() },
    inputs: &[InputKeys::SIGNAL],
    counts: NetworkCounts { parameters: 82_755, statistics: 1_024, macs: 2_029_376 },
    quick: &[],
};

/// `signal` [in_channels, length] → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DilatedResNetConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Rows of the code, or sensors, at least 1.
    pub in_channels: usize,
    /// Samples in time, at least 1.
    pub length: usize,
    /// Channels of all convolutions, at least 1.
    pub width: usize,
    /// Residual blocks, 1 or 2: the first has dilation 1, the second 2.
    pub blocks: usize,
}

impl Default for DilatedResNetConfig {
    /// Returns the configuration for the quantile code of five sensors with 50 samples in time.
    fn default() -> Self {
        DILATED_RESNET.config
    }
}

impl Architecture for DilatedResNetConfig {
    fn graph(&self) -> Result<Graph> {
        let DilatedResNetConfig { classes, in_channels, length, width, blocks } = *self;
        check([classes, in_channels, length, width], blocks)?;
        let net = Network::new(DILATED_RESNET.name);
        let signal = net.input("signal", &[in_channels, length]);
        let logits = logits(&net, &signal, [length, width, blocks], classes);
        net.finish(&[("logits", logits)])
    }
}

/// Checks the sizes.
///
/// # Errors
/// The first of `classes`, `in_channels`, `length`, `width` and `blocks` outside its range.
pub(crate) fn check([classes, in_channels, length, width]: [usize; 4], blocks: usize) -> Result<()> {
    at_least(&[
        ("classes", classes, 1),
        ("in_channels", in_channels, 1),
        ("length", length, 1),
        ("width", width, 1),
        ("blocks", blocks, 1),
    ])?;
    if blocks > BLOCKS.len() {
        return Err(Error::config("blocks", blocks, "must be 1 or 2"));
    }
    Ok(())
}

/// Applies everything from `signal` [in_channels, length] to logits.
pub(crate) fn logits(
    net: &Network,
    signal: &Flow,
    [length, width, blocks]: [usize; 3],
    classes: usize,
) -> Flow {
    let mut x = signal.conv_bn_relu("stem", Conv::new(width, 1).no_bias()).dropout(DROPPED[0]);
    for (name, dilation) in BLOCKS.into_iter().take(blocks) {
        x = block(&x, name, width, dilation);
    }
    let largest = x.max_pool(Pool::new(length)).flatten();
    let statistics = [&x.global_average_pool(), &largest, &x.global_standard_deviation(EPS)];
    let pooled = net.concat("statistics", &statistics).batch_norm("norm").dropout(DROPPED[1]);
    pooled.linear("fc", classes)
}

fn block(x: &Flow, name: &str, width: usize, dilation: usize) -> Flow {
    let conv = || Conv::new(width, 3).dilation(dilation).same().no_bias();
    let main = x.conv_bn_relu(&format!("{name}.conv1"), conv());
    let main = main.conv(&format!("{name}.conv2.conv"), conv()).batch_norm(&format!("{name}.conv2.bn"));
    main.add(x).relu()
}
