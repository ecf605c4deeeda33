//! Functions of one value, with PyTorch's gradients at the corners.

use candle_core::{Result, Tensor};
use taxel_graph::Activation;

/// Applies an activation. Comparisons with NaN are false, so each chain of choices ends in the branch that
/// hands NaN on.
pub(crate) fn apply(function: Activation, x: &Tensor) -> Result<Tensor> {
    match function {
        Activation::Relu6 => {
            let capped = x.ge(6f32)?.where_cond(&constant(x, 6.0)?, x)?;
            x.le(0f32)?.where_cond(&constant(x, 0.0)?, &capped)
        }
        Activation::LeakyRelu { slope } => x.gt(0f32)?.where_cond(x, &(x * f64::from(slope))?),
        Activation::Sigmoid => candle_nn::ops::sigmoid(x),
        Activation::Tanh => x.tanh(),
        Activation::HardSwish => {
            let middle = ((x * (x + 3.0)?)? / 6.0)?;
            let right = x.ge(3f32)?.where_cond(x, &middle)?;
            x.le(-3f32)?.where_cond(&constant(x, 0.0)?, &right)
        }
    }
}

fn constant(x: &Tensor, value: f32) -> Result<Tensor> {
    Tensor::full(value, x.shape(), x.device())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use candle_core::{Device, Var};

    /// Compares values and gradients at the corners with PyTorch's:
    ///
    /// ```python
    /// x = torch.tensor([-4, -3, -1, 0, 3, 4, 6, 7, torch.nan], requires_grad=True)
    /// torch.nn.functional.relu6(x).sum().backward()  # and leaky_relu, hardswish
    /// ```
    #[test]
    fn corners_are_those_of_pytorch_and_nan_comes_through() {
        let x = [-4.0, -3.0, -1.0, 0.0, 3.0, 4.0, 6.0, 7.0, f32::NAN];
        let (third, sixth) = (-1.0 / 3.0, 1.0 / 6.0);
        let cases = [
            (
                Activation::Relu6,
                [0.0, 0.0, 0.0, 0.0, 3.0, 4.0, 6.0, 6.0],
                [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0],
            ),
            (
                Activation::LeakyRelu { slope: 0.5 },
                [-2.0, -1.5, -0.5, 0.0, 3.0, 4.0, 6.0, 7.0],
                [0.5, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0, 1.0],
            ),
            (
                Activation::HardSwish,
                [0.0, 0.0, third, 0.0, 3.0, 4.0, 6.0, 7.0],
                [0.0, 0.0, sixth, 0.5, 1.0, 1.0, 1.0, 1.0],
            ),
        ];
        for (function, values, gradients) in cases {
            let x = Var::new(&x, &Device::Cpu).unwrap();
            let y = apply(function, &x).unwrap();
            let store = y.narrow(0, 0, 8).unwrap().sum_all().unwrap().backward().unwrap();
            let y = y.to_vec1::<f32>().unwrap();
            let dx = store.get(&x).unwrap().to_vec1::<f32>().unwrap();
            for i in 0..8 {
                assert!((y[i] - values[i]).abs() < 1e-6, "{function:?}: value {i} is {}", y[i]);
                assert!((dx[i] - gradients[i]).abs() < 1e-6, "{function:?}: gradient {i} is {}", dx[i]);
            }
            assert!(y[8].is_nan(), "{function:?}");
        }
        for function in [Activation::Sigmoid, Activation::Tanh] {
            let y = apply(function, &Tensor::new(&x, &Device::Cpu).unwrap()).unwrap();
            assert!(y.to_vec1::<f32>().unwrap()[8].is_nan(), "{function:?}");
        }
    }
}
