//! ResNet8-Lite: identity block, convolutional block, identity block.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, section 3.1.2 and Fig. 1b.
//!
//! # Departures
//! None known. Read into the text, after ResNet18: the stem pool is padded by 1 (50 → 25), the
//! shortcut of the convolutional block is a 1×1 convolution of stride 2 with its own batch norm, and
//! the ReLU comes after the addition.

use taxel_graph::{Conv, Flow, Pool};

/// Applies everything up to global average pooling: channels × … → 32 × …; 1D or 2D by the input.
pub(crate) fn body(x: Flow) -> Flow {
    let x = x.conv_bn_relu("stem", Conv::new(16, 5).same()).max_pool(Pool::new(3).stride(2).pad(1));
    let x = block(&x, "identity1", 16, 1);
    let x = block(&x, "downsample", 32, 2);
    block(&x, "identity2", 32, 1)
}

/// Applies two convolutions of 3 and a shortcut; a stride above 1 makes the shortcut a convolution.
fn block(x: &Flow, name: &str, filters: usize, stride: usize) -> Flow {
    let main = x
        .conv_bn_relu(&format!("{name}.conv1"), Conv::new(filters, 3).stride(stride).pad(1))
        .conv(&format!("{name}.conv2.conv"), Conv::new(filters, 3).pad(1))
        .batch_norm(&format!("{name}.conv2.bn"));
    let shortcut = match stride {
        1 => x.clone(),
        _ => x
            .conv(&format!("{name}.shortcut.conv"), Conv::new(filters, 1).stride(stride))
            .batch_norm(&format!("{name}.shortcut.bn")),
    };
    main.add(&shortcut).relu()
}
