//! Layer normalisation of the features of one sample.

use taxel_kernels::layer_norm;

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct LayerNorm {
    pub features: usize,
    pub eps: f32,
}

impl Layer for LayerNorm {
    fn forward(
        &self,
        inputs: Inputs,
        params: &[f32],
        y: &mut [f32],
        saved: &mut [f32],
        scratch: &mut Scratch,
    ) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.features, x, &mut scratch.x);
        let (weight, bias) = params.split_at(self.features);
        saved.copy_from_slice(&layer_norm::forward(self.eps, x, weight, bias, y));
    }

    fn backward(
        &self,
        pass: Backward,
        dy: &[f32],
        partials: &mut [f32],
        mut outputs: Outputs,
        scratch: &mut Scratch,
    ) {
        let (x, view) = pass.inputs.get(0);
        let x = view.seen(self.features, x, &mut scratch.x);
        let moments = [pass.saved[0], pass.saved[1]];
        if !partials.is_empty() {
            let (weight, bias) = partials.split_at_mut(self.features);
            layer_norm::add_gradients(moments, x, dy, weight, bias);
        }
        if let Some((dx, add)) = outputs.get(0) {
            layer_norm::backward(moments, x, &pass.params[..self.features], dy, dx, add);
        }
    }

    fn saved_len(&self) -> usize {
        2
    }

    fn scratch_len(&self) -> usize {
        self.features
    }
}
