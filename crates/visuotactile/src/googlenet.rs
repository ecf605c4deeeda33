//! GoogLeNet: inception blocks, which convolve at three sizes and pool side by side.
//!
//! # Reference
//! Szegedy et al. 2015, "Going Deeper with Convolutions", Table 1; torchvision's `googlenet` for names, batch
//! norm and initial weights. Compared with in Rouhafzay et al. 2021, Tables 1–5.
//!
//! # Departures
//! torchvision's, whose checkpoints are what users have: batch norm (ε 0.001) in place of response
//! normalisation, and 3×3 where the paper has 5×5. The two auxiliary heads, which count 0.3 each in training, are
//! off by default: `aux` adds them as the outputs `aux1` and `aux2`. torchvision's own checkpoint holds them.
//! torchvision shifts the images of its pretrained network to mean and deviation 0.5; here, scaling images is the
//! encoding's business.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, BATCH_NORM_MOMENTUM, Conv, Fill, Flow, Graph, InputKeys, Listing, Network, NetworkCounts,
    Pool, Result, share,
};

use crate::check_image;

/// Table 1: name; filters of 1×1, before and of 3×3, before and of 5×5, after the pool; the kernel of the 3×3 or
/// 2×2 max-pool that follows, or 0.
type InceptionRow = (&'static str, usize, [usize; 2], [usize; 2], usize, usize);
const ROWS: [InceptionRow; 9] = [
    ("3a", 64, [96, 128], [16, 32], 32, 0),
    ("3b", 128, [128, 192], [32, 96], 64, 3),
    ("4a", 192, [96, 208], [16, 48], 64, 0),
    ("4b", 160, [112, 224], [24, 64], 64, 0),
    ("4c", 128, [128, 256], [24, 64], 64, 0),
    ("4d", 112, [144, 288], [32, 64], 64, 0),
    ("4e", 256, [160, 320], [32, 128], 128, 2),
    ("5a", 256, [160, 320], [32, 128], 128, 0),
    ("5b", 384, [192, 384], [48, 128], 128, 0),
];
/// Auxiliary heads and the blocks that they read.
const HEADS: [(&str, &str); 2] = [("aux1", "4a"), ("aux2", "4d")];
const AUXILIARY_DROPOUT: f32 = 0.7;
/// Section 5: what the loss of each counts beside that of the logits.
const AUXILIARY_WEIGHT: f32 = 0.3;

pub(crate) const GOOGLENET: Listing<GoogLeNetConfig> = Listing {
    name: "googlenet",
    family: crate::FAMILY,
    paper: "Szegedy et al. 2015; Rouhafzay et al. 2021, Tables 1-5",
    config: GoogLeNetConfig { classes: 6, in_channels: 3, height: 224, width: 224, dropout: 0.2, aux: false },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 5_606_054, statistics: 14_560, macs: 1_497_358_336 },
    quick: &[("height", 40), ("width", 36)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`; with `aux` also `aux1` and `aux2`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GoogLeNetConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 31: the pools leave nothing of less.
    pub height: usize,
    /// Columns, at least 31.
    pub width: usize,
    /// Share of the features dropped in training, in 0..1.
    pub dropout: f32,
    /// Whether the auxiliary heads are there; their loss counts 0.3 each.
    pub aux: bool,
}

impl Default for GoogLeNetConfig {
    fn default() -> Self {
        GOOGLENET.config
    }
}

impl Architecture for GoogLeNetConfig {
    fn graph(&self) -> Result<Graph> {
        let GoogLeNetConfig { classes, in_channels, height, width, dropout, aux } = *self;
        let shape = [in_channels, height, width];
        check_image(classes, shape, 31)?;
        share("dropout", dropout)?;
        let net = Network::new(GOOGLENET.name);
        // Cut off at 2, which is 200 standard deviations away.
        net.conv_init(Fill::Normal { sd: 0.01 }, Fill::Pytorch);
        net.linear_init(Fill::Normal { sd: 0.01 }, Fill::Pytorch);
        let pool = || Pool::new(3).stride(2).round_up();
        let image = net.input("image", &shape);
        let x = conv_bn(&image, "conv1", Conv::new(64, 7).stride(2).pad(3)).max_pool(pool());
        let x = conv_bn(&x, "conv2", Conv::new(64, 1));
        let mut x = conv_bn(&x, "conv3", Conv::new(192, 3).pad(1)).max_pool(pool());
        let mut heads = vec![];
        for row in ROWS {
            x = inception(&net, &x, row);
            if let Some((head, _)) = HEADS.iter().find(|(_, block)| aux && *block == row.0) {
                heads.push((*head, auxiliary(&x, head, classes)));
            }
            match row.5 {
                0 => {}
                2 => x = x.max_pool(Pool::new(2).round_up()),
                _ => x = x.max_pool(pool()),
            }
        }
        let features = x.global_average_pool().dropout(dropout);
        let mut outputs = vec![("logits", features.linear("fc", classes))];
        outputs.extend(heads);
        net.finish_weighted(&outputs, &[1.0, AUXILIARY_WEIGHT, AUXILIARY_WEIGHT][..outputs.len()])
    }
}

/// Applies a convolution without bias, batch norm and ReLU.
fn conv_bn(x: &Flow, name: &str, conv: Conv) -> Flow {
    x.conv(&format!("{name}.conv"), conv.no_bias())
        .batch_norm_with(&format!("{name}.bn"), 0.001, BATCH_NORM_MOMENTUM)
        .relu()
}

fn inception(net: &Network, x: &Flow, (block, one, three, five, pooled, _): InceptionRow) -> Flow {
    let name = |part: &str| format!("inception{block}.{part}");
    let pair = |branch: &str, [before, filters]: [usize; 2]| {
        let narrow = conv_bn(x, &name(&format!("{branch}.0")), Conv::new(before, 1));
        conv_bn(&narrow, &name(&format!("{branch}.1")), Conv::new(filters, 3).pad(1))
    };
    let branch1 = conv_bn(x, &name("branch1"), Conv::new(one, 1));
    let (branch2, branch3) = (pair("branch2", three), pair("branch3", five));
    let around = x.max_pool(Pool::new(3).stride(1).pad(1).round_up());
    let branch4 = conv_bn(&around, &name("branch4.1"), Conv::new(pooled, 1));
    net.concat(&format!("inception{block}"), &[&branch1, &branch2, &branch3, &branch4])
}

fn auxiliary(x: &Flow, name: &str, classes: usize) -> Flow {
    let pooled = x.adaptive_average_pool(4);
    conv_bn(&pooled, &format!("{name}.conv"), Conv::new(128, 1))
        .flatten()
        .linear(&format!("{name}.fc1"), 1024)
        .relu()
        .dropout(AUXILIARY_DROPOUT)
        .linear(&format!("{name}.fc2"), classes)
}
