//! Functions of one value, with PyTorch's gradients at the corners. NaN stays NaN.
//!
//! `exp` is written out in plain arithmetic, so that the loops are vectorised; its relative error is below
//! 2e-7.

/// `y = min(max(x, 0), 6)`.
pub fn relu6(x: &[f32], y: &mut [f32]) {
    map(x, y, |x| x.clamp(0.0, 6.0));
}

/// Gradient of [`relu6`] from its input: 0 at both corners.
pub fn relu6_backward(x: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    pull(x, dy, dx, accumulate, |x, dy| if x <= 0.0 || x >= 6.0 { 0.0 } else { dy });
}

/// `y = x` above 0, else `slope · x`.
pub fn leaky_relu(slope: f32, x: &[f32], y: &mut [f32]) {
    map(x, y, |x| if x > 0.0 { x } else { slope * x });
}

/// Gradient of [`leaky_relu`] from its input: `slope` at 0.
pub fn leaky_relu_backward(slope: f32, x: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    pull(x, dy, dx, accumulate, |x, dy| if x > 0.0 { dy } else { slope * dy });
}

/// `y = 1 / (1 + e⁻ˣ)`.
pub fn sigmoid(x: &[f32], y: &mut [f32]) {
    map(x, y, sigmoid_of);
}

/// Gradient of [`sigmoid`] from its output.
pub fn sigmoid_backward(y: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    pull(y, dy, dx, accumulate, |y, dy| dy * (y * (1.0 - y)));
}

/// `y = tanh(x)`.
pub fn tanh(x: &[f32], y: &mut [f32]) {
    map(x, y, tanh_of);
}

/// Gradient of [`tanh`] from its output.
pub fn tanh_backward(y: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    pull(y, dy, dx, accumulate, |y, dy| dy * (1.0 - y * y));
}

/// `y = x · min(max(x + 3, 0), 6) / 6`.
pub fn hard_swish(x: &[f32], y: &mut [f32]) {
    map(x, y, |x| {
        if x <= -3.0 {
            0.0
        } else if x >= 3.0 {
            x
        } else {
            x * (x + 3.0) / 6.0
        }
    });
}

/// Gradient of [`hard_swish`] from its input: 0 at −3, 1 at 3.
pub fn hard_swish_backward(x: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    pull(x, dy, dx, accumulate, |x, dy| {
        if x <= -3.0 {
            0.0
        } else if x >= 3.0 {
            dy
        } else {
            dy * (x / 3.0 + 0.5)
        }
    });
}

fn map(x: &[f32], y: &mut [f32], function: impl Fn(f32) -> f32) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y = function(x);
    }
}

/// Gradients from a kept value and `dy`, written or added.
fn pull(kept: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool, gradient: impl Fn(f32, f32) -> f32) {
    let rows = dx.iter_mut().zip(kept.iter().zip(dy));
    if accumulate {
        for (dx, (&kept, &dy)) in rows {
            *dx += gradient(kept, dy);
        }
    } else {
        for (dx, (&kept, &dy)) in rows {
            *dx = gradient(kept, dy);
        }
    }
}

#[inline]
pub(crate) fn sigmoid_of(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// Below 0.625 a polynomial (Cephes' tanhf), since 1 − 2/(e²ˣ + 1) would cancel.
#[inline]
pub(crate) fn tanh_of(x: f32) -> f32 {
    let magnitude = x.abs();
    let z = x * x;
    let near = ((((-5.704_988_7e-3 * z + 2.063_909e-2) * z - 5.373_971_6e-2) * z + 1.333_144_2e-1) * z
        - 3.333_328e-1)
        * z
        * x
        + x;
    let far = (1.0 - 2.0 / (exp(2.0 * magnitude) + 1.0)).copysign(x);
    if magnitude < 0.625 { near } else { far }
}

/// eˣ, held at the ends of the range of normal numbers; NaN stays NaN.
///
/// Cody and Waite's reduction to ±ln 2 / 2 and Cephes' polynomial. Adding 1.5·2²³ rounds to an integer and
/// leaves it in the low bits, from where it is shifted into the exponent.
#[inline]
fn exp(x: f32) -> f32 {
    const ROUND: f32 = 12_582_912.0;
    let x = if x < -87.0 { -87.0 } else { x };
    let x = if x > 88.0 { 88.0 } else { x };
    let shifted = x * std::f32::consts::LOG2_E + ROUND;
    let power = shifted - ROUND;
    let r = x - power * 0.693_359_4 + power * 2.121_944_4e-4;
    let polynomial = ((((1.987_569_1e-4 * r + 1.398_199_9e-3) * r + 8.333_452e-3) * r + 4.166_579_6e-2) * r
        + 1.666_666_5e-1)
        * r
        + 0.5;
    let fraction = polynomial * r * r + r + 1.0;
    fraction * f32::from_bits((shifted.to_bits() << 23).wrapping_add(1.0f32.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_is_close_everywhere_and_hides_no_nan() {
        for i in -87_000..=88_000 {
            let x = i as f32 / 1000.0;
            let want = f64::from(x).exp();
            assert!((f64::from(exp(x)) / want - 1.0).abs() < 2e-7, "e^{x} is {}, want {want}", exp(x));
        }
        assert!(exp(f32::NAN).is_nan());
        assert_eq!(exp(f32::NEG_INFINITY), exp(-87.0));
        assert!(exp(f32::INFINITY).is_finite());
    }
}
