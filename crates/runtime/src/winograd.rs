//! Convolutions with fewer products, by the convolution that training uses.

use taxel_kernels::frozen::{self, ImagePlace};
use taxel_kernels::{AffineView, Rectifier, conv};

use crate::step::Conv;

/// The convolution of training with what was folded into it.
pub(crate) struct Winograd {
    conv: Box<conv::Conv>,
    packed: Vec<f32>,
    bias: Vec<f32>,
    rectifier: Rectifier,
}

impl Winograd {
    /// Packs the weights of a step for `plan`.
    pub fn new(step: Conv, plan: Box<conv::Conv>) -> Self {
        let Conv { weight, bias, rectifier, .. } = step;
        let mut packed = vec![];
        plan.pack(&weight, &mut packed);
        Winograd { conv: plan, packed, bias, rectifier }
    }

    /// Computes what lies at `to` from a dense input; `padded`, `output` and `work` are scratch.
    pub fn run(&self, x: &[f32], [padded, output, work]: [&mut [f32]; 3], to: &ImagePlace, y: &mut [f32]) {
        let output = &mut output[..to.len()];
        for band in self.conv.bands() {
            let padded = self.conv.pad(x, &AffineView::default(), band, padded);
            // What is packed takes the place of the weights.
            self.conv.forward(padded, &[], &self.packed, Some(&self.bias), output, work);
        }
        let view = AffineView { affine: None, rectifier: self.rectifier };
        frozen::map(&view, &ImagePlace::dense(to.size, to.channels), output, to, y);
    }
}
