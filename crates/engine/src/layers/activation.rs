//! Functions of one value, but those that readers apply themselves (ReLU and ReLU6).

use taxel_graph::Activation as Function;
use taxel_kernels::activation;

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct Activation {
    pub function: Function,
    pub channels: usize,
    /// Values of one sample.
    pub len: usize,
}

impl Layer for Activation {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.channels, x, &mut scratch.x);
        match self.function {
            Function::Relu6 => activation::relu6(x, y),
            Function::LeakyRelu { slope } => activation::leaky_relu(slope, x, y),
            Function::Sigmoid => activation::sigmoid(x, y),
            Function::Tanh => activation::tanh(x, y),
            Function::HardSwish => activation::hard_swish(x, y),
        }
    }

    fn backward(
        &self,
        pass: Backward,
        dy: &[f32],
        _: &mut [f32],
        mut outputs: Outputs,
        scratch: &mut Scratch,
    ) {
        let Some((dx, add)) = outputs.get(0) else { return };
        let (x, view) = pass.inputs.get(0);
        let kept = match self.function {
            Function::Sigmoid | Function::Tanh => pass.y,
            _ => view.seen(self.channels, x, &mut scratch.x),
        };
        match self.function {
            Function::Relu6 => activation::relu6_backward(kept, dy, dx, add),
            Function::LeakyRelu { slope } => activation::leaky_relu_backward(slope, kept, dy, dx, add),
            Function::Sigmoid => activation::sigmoid_backward(kept, dy, dx, add),
            Function::Tanh => activation::tanh_backward(kept, dy, dx, add),
            Function::HardSwish => activation::hard_swish_backward(kept, dy, dx, add),
        }
    }

    fn scratch_len(&self) -> usize {
        self.len
    }
}
