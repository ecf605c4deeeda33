//! Optimiser steps over flat parameters.

/// Stochastic gradient descent with momentum as PyTorch defines it:
/// `v ← momentum · v + (g + weight_decay · w)`, `w ← w − lr · v`.
pub fn sgdm(
    weights: &mut [f32],
    gradients: &[f32],
    velocity: &mut [f32],
    lr: f32,
    momentum: f32,
    weight_decay: f32,
) {
    for ((w, &g), v) in weights.iter_mut().zip(gradients).zip(velocity) {
        *v = momentum * *v + (g + weight_decay * *w);
        *w -= lr * *v;
    }
}
