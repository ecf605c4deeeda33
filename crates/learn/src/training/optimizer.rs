//! Optimisers with their settings.

use serde::{Deserialize, Serialize};
pub use taxel_engine::Decay;
use taxel_engine::{Adam, Engine, Sgdm};

use crate::problem::{Check, require};

/// An optimiser with its settings, named and counted as in `torch.optim`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "name", deny_unknown_fields)]
pub enum Optimizer {
    /// Stochastic gradient descent with momentum (`torch.optim.SGD`).
    Sgdm {
        /// Learning rate, above 0. Default 0.01.
        #[serde(default = "lr")]
        lr: f64,
        /// Share of the last step that is kept, `[0, 1)`. Default 0.9.
        #[serde(default = "momentum")]
        momentum: f64,
        /// L2 penalty, `[0, 1]`. Default 0.
        #[serde(default)]
        weight_decay: f64,
        /// The parameters that the penalty touches. Default `all`.
        #[serde(default, skip_serializing_if = "crate::json_file::is_default")]
        decay: Decay,
    },
    /// `torch.optim.Adam`: the penalty is part of the gradient.
    Adam(Moments),
    /// `torch.optim.AdamW`: the penalty shrinks the weights.
    Adamw(Moments),
}

/// Settings of the optimisers that remember two moments of the gradient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Moments {
    /// Learning rate, above 0. Default 0.01.
    pub lr: f64,
    /// L2 penalty, `[0, 1]`. Default 0.
    pub weight_decay: f64,
    /// The parameters that the penalty touches. Default `all`.
    #[serde(skip_serializing_if = "crate::json_file::is_default")]
    pub decay: Decay,
    /// Decay of the first and second moment, each in `[0, 1)`. Default `[0.9, 0.999]`.
    pub betas: [f64; 2],
    /// Added to the root of the second moment, in (0, 1). Default 1e-8.
    pub eps: f64,
}

impl Default for Moments {
    fn default() -> Self {
        Moments { lr: lr(), weight_decay: 0.0, decay: Decay::All, betas: [0.9, 0.999], eps: 1e-8 }
    }
}

fn lr() -> f64 {
    0.01
}

fn momentum() -> f64 {
    0.9
}

impl Default for Optimizer {
    fn default() -> Self {
        Optimizer::Sgdm { lr: lr(), momentum: momentum(), weight_decay: 0.0, decay: Decay::All }
    }
}

impl Optimizer {
    /// Returns the first learning rate.
    pub fn lr(&self) -> f64 {
        match self {
            Optimizer::Sgdm { lr, .. } => *lr,
            Optimizer::Adam(moments) | Optimizer::Adamw(moments) => moments.lr,
        }
    }

    /// Returns the same optimiser with another first learning rate.
    pub(crate) fn with_lr(self, lr: f64) -> Self {
        match self {
            Optimizer::Sgdm { momentum, weight_decay, decay, .. } => {
                Optimizer::Sgdm { lr, momentum, weight_decay, decay }
            }
            Optimizer::Adam(moments) => Optimizer::Adam(Moments { lr, ..moments }),
            Optimizer::Adamw(moments) => Optimizer::Adamw(Moments { lr, ..moments }),
        }
    }

    /// Returns which parameters its penalty touches.
    pub(crate) fn decay(&self) -> Decay {
        match *self {
            Optimizer::Sgdm { decay, .. } => decay,
            Optimizer::Adam(moments) | Optimizer::Adamw(moments) => moments.decay,
        }
    }

    /// Makes one step with the gradients of the last backward pass, at learning rate `lr`.
    pub(crate) fn step(&self, engine: &mut Engine, lr: f64) {
        let adam = |moments: &Moments| {
            let [first, second] = moments.betas;
            Adam { lr, betas: (first, second), eps: moments.eps, weight_decay: moments.weight_decay }
        };
        match self {
            Optimizer::Sgdm { momentum, weight_decay, .. } => engine.sgdm(&Sgdm {
                lr: lr as f32,
                momentum: *momentum as f32,
                weight_decay: *weight_decay as f32,
            }),
            Optimizer::Adam(moments) => engine.adam(&adam(moments)),
            Optimizer::Adamw(moments) => engine.adamw(&adam(moments)),
        }
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn check(&self) -> Check {
        let decay = match self {
            Optimizer::Sgdm { momentum, weight_decay, .. } => {
                require((0.0..1.0).contains(momentum), "momentum", momentum, "must be in [0, 1)")?;
                weight_decay
            }
            Optimizer::Adam(moments) | Optimizer::Adamw(moments) => {
                let betas = moments.betas.iter().all(|beta| (0.0..1.0).contains(beta));
                require(betas, "betas", format!("{:?}", moments.betas), "must be two numbers in [0, 1)")?;
                let eps = moments.eps > 0.0 && moments.eps < 1.0;
                require(eps, "eps", moments.eps, "must be in (0, 1), usually 1e-8")?;
                &moments.weight_decay
            }
        };
        require((0.0..=1.0).contains(decay), "weight_decay", decay, "must be in [0, 1]")?;
        // Rates are applied in f32: one that rounds to 0 would never learn.
        let rate = self.lr() as f32;
        let reason = "must be positive and finite, usually 1e-4 to 0.1";
        require(rate > 0.0 && rate.is_finite(), "lr", self.lr(), reason)
    }
}
