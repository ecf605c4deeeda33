//! TactResNet: four residual blocks on pressure images.
//!
//! # Reference
//! Gandarias, García-Cerezo and Gómez-de-Gabriel 2019, "CNN-based methods for object recognition with high-resolution
//! tactile sensors", in the layer list the authors published; compared with in Kaewrakmuk and Srinonchat 2026, Table 5:
//! 2.9 MB, 0.2398 GFLOPs.
//!
//! # Departures
//! Input is the colour image of Kaewrakmuk and Srinonchat, 50×50, in place of the authors' 28×50 pressure image. No
//! counting convention tried gives the published GFLOPs; ours is 0.2186. Both pools are maxima: so says the authors'
//! published layer graph of the one before the classifier (`pool5`, kernel 5, stride 1), where ResNet averages. Read
//! into the list: the pool after the stem is not padded, and ReLU comes after the addition, as in ResNet.

use serde::{Deserialize, Serialize};
use taxel_graph::{
    Architecture, Conv, Flow, Graph, InputKeys, Listing, Network, NetworkCounts, Pool, Result, at_least,
};

/// Name and filters of each residual block; where the filters grow, the shortcut is a convolution.
const BLOCKS: [(&str, usize); 4] = [("res2", 64), ("res3", 64), ("res4", 128), ("res5", 128)];

pub(crate) const TACTRESNET: Listing<TactResNetConfig> = Listing {
    name: "tactresnet",
    family: crate::FAMILY,
    paper: "Gandarias et al. 2019a; Kaewrakmuk and Srinonchat 2026, Table 5",
    config: TactResNetConfig { classes: 3, in_channels: 3, height: 50, width: 50 },
    inputs: &[InputKeys::IMAGE],
    counts: NetworkCounts { parameters: 769_539, statistics: 1_920, macs: 109_192_896 },
    quick: &[("height", 50), ("width", 28)],
};

/// `image` `[in_channels, height, width]` → logits `[classes]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TactResNetConfig {
    /// Outputs: one of each class or value; at least 1.
    pub classes: usize,
    /// Colour planes, at least 1.
    pub in_channels: usize,
    /// Rows, at least 21: less is nothing to the last pool.
    pub height: usize,
    /// Columns, at least 21.
    pub width: usize,
}

impl Default for TactResNetConfig {
    fn default() -> Self {
        TACTRESNET.config
    }
}

impl Architecture for TactResNetConfig {
    fn graph(&self) -> Result<Graph> {
        let TactResNetConfig { classes, in_channels, height, width } = *self;
        at_least(&[
            ("classes", classes, 1),
            ("in_channels", in_channels, 1),
            ("height", height, 21),
            ("width", width, 21),
        ])?;
        let net = Network::new(TACTRESNET.name);
        let image = net.input("image", &[in_channels, height, width]);
        let mut x =
            image.conv_bn_relu("stem", Conv::new(64, 5).stride(2).pad(2)).max_pool(Pool::new(3).stride(2));
        for (name, filters) in BLOCKS {
            x = block(&x, name, filters);
        }
        let pooled = x.max_pool(Pool::new(5).stride(1));
        net.finish(&[("logits", pooled.flatten().linear("fc", classes))])
    }
}

fn block(x: &Flow, name: &str, filters: usize) -> Flow {
    let main = x
        .conv_bn_relu(&format!("{name}.conv1"), Conv::new(filters, 3).pad(1))
        .conv(&format!("{name}.conv2.conv"), Conv::new(filters, 3).pad(1))
        .batch_norm(&format!("{name}.conv2.bn"));
    let shortcut = match x.shape().first() {
        Some(&channels) if channels == filters => x.clone(),
        _ => x
            .conv(&format!("{name}.shortcut.conv"), Conv::new(filters, 3).pad(1))
            .batch_norm(&format!("{name}.shortcut.bn")),
    };
    main.add(&shortcut).relu()
}
