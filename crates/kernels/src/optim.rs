//! Optimiser steps over flat parameters.

use crate::lengths::exactly;

/// Takes a step of stochastic gradient descent with momentum as PyTorch defines it:
/// `v ← momentum · v + (g + weight_decay · w)`, `w ← w − lr · v`.
pub fn sgdm(
    weights: &mut [f32],
    gradients: &[f32],
    velocity: &mut [f32],
    lr: f32,
    momentum: f32,
    weight_decay: f32,
) {
    exactly("gradients", gradients.len(), weights.len());
    exactly("velocity", velocity.len(), weights.len());
    for ((w, &g), v) in weights.iter_mut().zip(gradients).zip(velocity) {
        *v = momentum * *v + (g + weight_decay * *w);
        *w -= lr * *v;
    }
}

/// Settings of [`adam`] and [`adamw`], in `f64`: 1 − 0.999 is off by 5e-5 when 0.999 is an `f32`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adam {
    /// Learning rate.
    pub lr: f64,
    /// Decay of the first and the second moment.
    pub betas: (f64, f64),
    /// Added to the root of the second moment.
    pub eps: f64,
    /// L2 penalty, coupled in [`adam`], decoupled in [`adamw`].
    pub weight_decay: f64,
}

impl Default for Adam {
    /// Returns the defaults of `torch.optim.Adam`.
    fn default() -> Self {
        Adam { lr: 1e-3, betas: (0.9, 0.999), eps: 1e-8, weight_decay: 0.0 }
    }
}

/// Takes a step of `torch.optim.Adam`: the penalty is added to the gradient. `step` counts from 1; both moments start
/// at zero.
pub fn adam(
    weights: &mut [f32],
    gradients: &[f32],
    first: &mut [f32],
    second: &mut [f32],
    settings: &Adam,
    step: u64,
) {
    let decay = settings.weight_decay as f32;
    move_by_moments(weights, gradients, first, second, settings, step, |w, g| (w, g + decay * w));
}

/// Takes a step of `torch.optim.AdamW`: the penalty shrinks the weights and stays out of the moments.
pub fn adamw(
    weights: &mut [f32],
    gradients: &[f32],
    first: &mut [f32],
    second: &mut [f32],
    settings: &Adam,
    step: u64,
) {
    let kept = (1.0 - settings.lr * settings.weight_decay) as f32;
    move_by_moments(weights, gradients, first, second, settings, step, |w, g| (w * kept, g));
}

fn move_by_moments(
    weights: &mut [f32],
    gradients: &[f32],
    first: &mut [f32],
    second: &mut [f32],
    settings: &Adam,
    step: u64,
    decayed: impl Fn(f32, f32) -> (f32, f32),
) {
    let Adam { lr, betas: (beta1, beta2), eps, .. } = *settings;
    exactly("gradients", gradients.len(), weights.len());
    exactly("first moments", first.len(), weights.len());
    exactly("second moments", second.len(), weights.len());
    // After 2³¹ steps every power is 0 anyway.
    let exponent = step.min(i32::MAX as u64) as i32;
    let rate = (lr / (1.0 - beta1.powi(exponent))) as f32;
    let root = (1.0 - beta2.powi(exponent)).sqrt() as f32;
    let (share1, beta2, share2, eps) = ((1.0 - beta1) as f32, beta2 as f32, (1.0 - beta2) as f32, eps as f32);
    let moments = first.iter_mut().zip(second);
    for ((w, &g), (m, v)) in weights.iter_mut().zip(gradients).zip(moments) {
        let (weight, g) = decayed(*w, g);
        *m += share1 * (g - *m);
        *v = beta2 * *v + share2 * g * g;
        *w = weight - rate * *m / (v.sqrt() / root + eps);
    }
}

/// Scales gradients so that their norm is at most `largest`; returns the norm before
/// (`torch.nn.utils.clip_grad_norm_`, with its 1e-6 below the fraction). A NaN makes all of them NaN.
pub fn clip_by_global_norm(gradients: &mut [f32], largest: f32) -> f32 {
    let mut norm = 0.0f64;
    for stretch in gradients.chunks(64) {
        norm += stretch.iter().map(|&g| f64::from(g) * f64::from(g)).sum::<f64>();
    }
    let norm = norm.sqrt();
    let factor = f64::from(largest) / (norm + 1e-6);
    // Not `min`, which would hide NaN.
    let factor = if factor > 1.0 { 1.0 } else { factor as f32 };
    for gradient in gradients {
        *gradient *= factor;
    }
    norm as f32
}
