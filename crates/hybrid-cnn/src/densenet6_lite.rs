//! DenseNet6-Lite: two dense blocks of one bottleneck each.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, section 3.1.3 and Fig. 1c.
//!
//! # Departures
//! None known. Read into the text: one bottleneck per dense block ("6" counts stem, 2 × 2 and FC);
//! the transition is the average pool alone; pre-activation and a final batch norm with ReLU, after
//! DenseNet201; the stem pool is padded by 1 (50 → 25).

use taxel_graph::{Conv, Flow, Pool};

/// Filters of the 1×1 bottleneck and of the 3×3 convolution that grows the block.
const BOTTLENECK: usize = 64;
const GROWTH: usize = 16;

/// Applies everything up to global average pooling: channels × … → 48 × …; 1D or 2D by the input.
pub(crate) fn body(x: Flow) -> Flow {
    let x = x.conv_bn_relu("stem", Conv::new(16, 5).same()).max_pool(Pool::new(3).stride(2).pad(1));
    let x = dense(&x, "block1").average_pool(Pool::new(2));
    dense(&x, "block2").bn_relu("norm")
}

/// Joins the input with what BN–ReLU–1×1–BN–ReLU–3×3 makes of it.
fn dense(x: &Flow, name: &str) -> Flow {
    let grown = x
        .bn_relu(&format!("{name}.bn1"))
        .conv(&format!("{name}.conv1"), Conv::new(BOTTLENECK, 1))
        .bn_relu(&format!("{name}.bn2"))
        .conv(&format!("{name}.conv2"), Conv::new(GROWTH, 3).same());
    x.concat(&grown)
}
