//! The whole input times one learned scalar.

use taxel_kernels::{pointwise, reduce};

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct ScaleLayer {
    pub channels: usize,
    /// Values of one sample.
    pub len: usize,
}

impl Layer for ScaleLayer {
    fn forward(&self, inputs: Inputs, params: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        pointwise::scale(params[0], view.seen(self.channels, x, &mut scratch.x), y, false);
    }

    fn backward(
        &self,
        pass: Backward,
        dy: &[f32],
        partials: &mut [f32],
        mut outputs: Outputs,
        scratch: &mut Scratch,
    ) {
        if let [partial] = partials {
            let (x, view) = pass.inputs.get(0);
            *partial += reduce::dot(view.seen(self.channels, x, &mut scratch.x), dy);
        }
        if let Some((dx, add)) = outputs.get(0) {
            pointwise::scale(pass.params[0], dy, dx, add);
        }
    }

    fn scratch_len(&self) -> usize {
        self.len
    }
}
