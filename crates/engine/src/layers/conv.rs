//! Convolution: images in parallel, weight gradients as a fixed number of partial sums.

use taxel_graph::{Node, Op, Param};
use taxel_kernels::{Window3, conv, layout};

use super::{Layer, Pass};
use crate::threads::{Parts, add_parts};

/// The most values that partial weight gradients may take together.
const PARTIALS: usize = 1 << 24;

pub(super) struct Conv {
    conv: conv::Conv,
    bias: bool,
    /// Partial gradients of weights and bias, one after the other.
    partials: Vec<f32>,
}

impl Conv {
    pub fn new(window: Window3, input: &Node, node: &Node, groups: usize, bias: bool, batch: usize) -> Self {
        let conv = conv::Conv { window, channels: input.shape[0], filters: node.shape[0], groups };
        let mut layer = Conv { conv, bias, partials: vec![] };
        layer.partials = vec![0.0; layer.params_len() * layer.parts(batch).count];
        layer
    }

    fn params_len(&self) -> usize {
        self.conv.weight_len() + if self.bias { self.conv.filters } else { 0 }
    }

    fn parts(&self, n: usize) -> Parts {
        Parts::of(n, PARTIALS / self.params_len())
    }

    fn x_len(&self) -> usize {
        self.conv.window.input_len() * self.conv.channels
    }

    fn y_len(&self) -> usize {
        self.conv.window.output_len() * self.conv.filters
    }
}

impl Layer for Conv {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], params: &[f32], _: &mut [f32], y: &mut [f32]) {
        let (weight, bias) = params.split_at(self.conv.weight_len());
        let bias = self.bias.then_some(bias);
        pass.threads.each(y, self.y_len(), |i, y| {
            self.conv.forward(&xs[0][i * self.x_len()..][..self.x_len()], weight, bias, y);
        });
    }

    fn backward_params(&mut self, pass: &Pass, xs: &[&[f32]], dy: &[f32], _: &[f32], dparams: &mut [f32]) {
        let parts = self.parts(pass.n);
        let len = self.params_len();
        let mut partials = std::mem::take(&mut self.partials);
        pass.threads.each(&mut partials[..parts.count * len], len, |part, partial| {
            partial.fill(0.0);
            let (dweight, dbias) = partial.split_at_mut(self.conv.weight_len());
            for i in parts.range(part, pass.n) {
                let (x, dy) =
                    (&xs[0][i * self.x_len()..][..self.x_len()], &dy[i * self.y_len()..][..self.y_len()]);
                self.conv.backward_weight(x, dy, dweight, if self.bias { Some(&mut *dbias) } else { None });
            }
        });
        add_parts(&partials[..parts.count * len], dparams);
        self.partials = partials;
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        _: &[&[f32]],
        _: &[f32],
        dy: &[f32],
        params: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let weight = &params[..self.conv.weight_len()];
        pass.threads.each(dx, self.x_len(), |i, dx| {
            self.conv.backward_input(&dy[i * self.y_len()..][..self.y_len()], weight, dx, accumulate);
        });
    }
}

/// A parameter from PyTorch's order into the engine's.
pub(crate) fn read_tensor(node: &Node, param: &Param, outer: &[f32], inner: &mut [f32]) {
    match conv_sizes(node, param) {
        Some((filters, channels, volume, groups)) => {
            layout::weights_in(filters, channels, volume, groups, outer, inner);
        }
        None => inner.copy_from_slice(outer),
    }
}

/// A parameter from the engine's order into PyTorch's.
pub(crate) fn write_tensor(node: &Node, param: &Param, inner: &[f32]) -> Vec<f32> {
    let mut outer = inner.to_vec();
    if let Some((filters, channels, volume, groups)) = conv_sizes(node, param) {
        layout::weights_out(filters, channels, volume, groups, inner, &mut outer);
    }
    outer
}

fn conv_sizes(node: &Node, param: &Param) -> Option<(usize, usize, usize, usize)> {
    match &node.op {
        Op::Conv { groups, .. } if param.shape.len() > 1 => {
            let volume = param.shape[2..].iter().product();
            Some((param.shape[0], param.shape[1], volume, *groups))
        }
        _ => None,
    }
}
