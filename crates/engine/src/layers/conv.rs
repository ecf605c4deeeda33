//! Convolution.

use taxel_graph::{Node, Op, Param};
use taxel_kernels::{conv, layout};

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct Conv {
    conv: conv::Conv,
    bias: bool,
}

impl Conv {
    pub fn new(conv: conv::Conv, bias: bool) -> Self {
        Conv { conv, bias }
    }
}

impl Layer for Conv {
    fn forward(&self, inputs: Inputs, params: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (weight, bias) = params.split_at(self.conv.weight_len());
        let (x, view) = inputs.get(0);
        let bias = self.bias.then_some(bias);
        for band in self.conv.bands() {
            let padded = self.conv.pad(x, &view, band, &mut scratch.x);
            self.conv.forward(padded, weight, inputs.packed, bias, y, &mut scratch.work);
        }
    }

    fn backward(
        &self,
        pass: Backward,
        dy: &[f32],
        partials: &mut [f32],
        mut outputs: Outputs,
        scratch: &mut Scratch,
    ) {
        if !partials.is_empty() {
            let (dweight, dbias) = partials.split_at_mut(self.conv.sums_len());
            let (x, view) = pass.inputs.get(0);
            for band in self.conv.bands() {
                let dbias = self.bias.then_some(&mut *dbias);
                let padded = self.conv.pad(x, &view, band, &mut scratch.x);
                self.conv.backward_weight(padded, dy, dweight, dbias, &mut scratch.work);
            }
        }
        if let Some((dx, add)) = outputs.get(0) {
            self.conv.backward_input(dy, pass.params, pass.prepared, &mut scratch.work, dx, add);
        }
    }

    fn scratch_len(&self) -> usize {
        self.conv.padded_len()
    }

    fn work_len(&self, trains: bool) -> usize {
        self.conv.work_len().max(if trains { self.conv.backward_len() } else { 0 })
    }

    fn pack(&self, params: &[f32], packed: &mut Vec<f32>) {
        self.conv.pack(params, packed);
    }

    fn prepare(&self, params: &[f32], prepared: &mut Vec<f32>) {
        self.conv.turn(params, prepared);
    }

    fn partials_len(&self, params: usize) -> usize {
        self.conv.sums_len() + params - self.conv.weight_len()
    }

    fn finish(&self, totals: &[f32], dparams: &mut [f32]) {
        let (weight, bias) = totals.split_at(self.conv.sums_len());
        let (dweight, dbias) = dparams.split_at_mut(self.conv.weight_len());
        dweight.fill(0.0);
        self.conv.finish(weight, dweight);
        dbias.copy_from_slice(bias);
    }
}

/// Brings a parameter from PyTorch's order into the engine's.
pub(crate) fn read_tensor(node: &Node, param: &Param, outer: &[f32], inner: &mut [f32]) {
    match conv_sizes(node, param) {
        Some((filters, channels, volume, groups)) => {
            layout::weights_in(filters, channels, volume, groups, outer, inner);
        }
        None => inner.copy_from_slice(outer),
    }
}

/// Brings a parameter from the engine's order into PyTorch's.
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
