//! How a network wants its fresh weights drawn.

use crate::error::Result;
use crate::graph::Init;

/// A rule for the tensors of a convolution or linear layer, by the shape of its weight.
///
/// "in" and "out" are counted as `torch.nn.init` counts them, which leaves groups out of sight: values of
/// one filter, and filters × kernel size.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Fill {
    /// PyTorch's default for weights and biases: uniform in ±1/√in.
    #[default]
    Pytorch,
    /// Every value the same.
    Constant(f32),
    /// `normal_(0, sd)`.
    Normal {
        /// Standard deviation, at least 0.
        sd: f32,
    },
    /// `kaiming_normal_(mode="fan_in")`: SD √(2/in).
    KaimingNormalFanIn,
    /// `kaiming_normal_(mode="fan_out", nonlinearity="relu")`: SD √(2/out).
    KaimingNormalFanOut,
    /// `kaiming_uniform_(mode="fan_out", nonlinearity="sigmoid")`: uniform in ±√(3/out).
    KaimingUniformFanOut,
}

impl Fill {
    /// Resolves the initial values of tensor `name` of a layer whose weight has shape `weight` (out × in × kernel).
    ///
    /// # Errors
    /// Numbers that nothing can be drawn from.
    pub(crate) fn resolve(self, name: &str, weight: &[usize]) -> Result<Init> {
        let fan_in = weight.iter().skip(1).product::<usize>() as f32;
        let fan_out = weight.iter().take(1).chain(weight.iter().skip(2)).product::<usize>() as f32;
        let init = match self {
            Fill::Pytorch => Init::Uniform { bound: 1.0 / fan_in.sqrt() },
            Fill::Constant(value) => Init::Constant(value),
            Fill::Normal { sd } => Init::Normal { sd },
            Fill::KaimingNormalFanIn => Init::Normal { sd: (2.0 / fan_in).sqrt() },
            Fill::KaimingNormalFanOut => Init::Normal { sd: (2.0 / fan_out).sqrt() },
            Fill::KaimingUniformFanOut => Init::Uniform { bound: (3.0 / fan_out).sqrt() },
        };
        init.check(name)?;
        Ok(init)
    }
}
