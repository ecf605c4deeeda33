//! Vgg6-Lite: five convolutions in the manner of VGG16.
//!
//! # Reference
//! Kaewrakmuk and Srinonchat 2026, section 3.1.1 and Fig. 1a.
//!
//! # Departures
//! None known. Read into the text: pools round up (50 → 25 → 13 → 7, MATLAB's `same`), which alone
//! gives the published 0.0392 GFLOPs; convolutions carry a bias.

use taxel_graph::{Conv, Flow, Pool};

/// Filters of each convolution, and whether a 2/2 max-pool follows.
const LAYERS: [(usize, bool); 5] = [(16, true), (32, true), (64, false), (64, false), (64, true)];

/// Applies everything up to global average pooling: channels × … → 64 × …; 1D or 2D by the input.
pub(crate) fn body(mut x: Flow) -> Flow {
    for (i, (filters, pooled)) in LAYERS.into_iter().enumerate() {
        x = x.conv_bn_relu(&format!("convs.{i}"), Conv::new(filters, 3).same());
        if pooled {
            x = x.max_pool(Pool::new(2).round_up());
        }
    }
    x
}
