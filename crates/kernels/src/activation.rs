//! Functions of one value, with PyTorch's gradients at the corners. NaN stays NaN.
//!
//! `exp` is written out in plain arithmetic, so that the loops are vectorised; its relative error is below
//! 2e-7.

use crate::simd::{Simd, at_level};

/// Defines a function value by value: `name(x, y)`.
macro_rules! forward {
    ($(#[$meta:meta])* $name:ident($($arg:ident: $ty:ty)?) = $body:ident, |$x:ident| $value:expr) => {
        at_level! { $(#[$meta])* pub fn $name($($arg: $ty,)? x: &[f32], y: &mut [f32]) = $body }

        /// # Safety
        /// The CPU has the features of `S`.
        #[inline(always)]
        unsafe fn $body<S: Simd>($($arg: $ty,)? x: &[f32], y: &mut [f32]) {
            for (y, &$x) in y.iter_mut().zip(x) {
                *y = $value;
            }
        }
    };
}

/// Defines a gradient from a kept value and `dy`, written or added: `name(kept, dy, dx, accumulate)`.
macro_rules! backward {
    (
        $(#[$meta:meta])* $name:ident($($arg:ident: $ty:ty)?) = $body:ident,
        |$kept:ident, $dy:ident| $gradient:expr
    ) => {
        at_level! {
            $(#[$meta])*
            pub fn $name($($arg: $ty,)? kept: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) = $body
        }

        /// # Safety
        /// The CPU has the features of `S`.
        #[inline(always)]
        unsafe fn $body<S: Simd>(
            $($arg: $ty,)? kept: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool,
        ) {
            let rows = dx.iter_mut().zip(kept.iter().zip(dy));
            if accumulate {
                for (dx, (&$kept, &$dy)) in rows {
                    *dx += $gradient;
                }
            } else {
                for (dx, (&$kept, &$dy)) in rows {
                    *dx = $gradient;
                }
            }
        }
    };
}

forward! {
    /// `y = min(max(x, 0), 6)`.
    relu6() = relu6_at, |x| x.clamp(0.0, 6.0)
}

backward! {
    /// Gradient of [`relu6`] from its input: 0 at both corners.
    relu6_backward() = relu6_backward_at, |x, dy| if x <= 0.0 || x >= 6.0 { 0.0 } else { dy }
}

forward! {
    /// `y = x` above 0, else `slope · x`.
    leaky_relu(slope: f32) = leaky_relu_at, |x| if x > 0.0 { x } else { slope * x }
}

backward! {
    /// Gradient of [`leaky_relu`] from its input: `slope` at 0.
    leaky_relu_backward(slope: f32) = leaky_relu_backward_at,
    |x, dy| if x > 0.0 { dy } else { slope * dy }
}

forward! {
    /// `y = 1 / (1 + e⁻ˣ)`.
    sigmoid() = sigmoid_at, |x| sigmoid_of(x)
}

backward! {
    /// Gradient of [`sigmoid`] from its output.
    sigmoid_backward() = sigmoid_backward_at, |y, dy| dy * (y * (1.0 - y))
}

forward! {
    /// `y = tanh(x)`.
    tanh() = tanh_at, |x| tanh_of(x)
}

backward! {
    /// Gradient of [`tanh`] from its output.
    tanh_backward() = tanh_backward_at, |y, dy| dy * (1.0 - y * y)
}

forward! {
    /// `y = x · min(max(x + 3, 0), 6) / 6`.
    hard_swish() = hard_swish_at, |x| {
        let inner = x * (x + 3.0) / 6.0;
        let right = if x >= 3.0 { x } else { inner };
        if x <= -3.0 { 0.0 } else { right }
    }
}

backward! {
    /// Gradient of [`hard_swish`] from its input: 0 at −3, 1 at 3.
    hard_swish_backward() = hard_swish_backward_at, |x, dy| {
        let inner = dy * (x / 3.0 + 0.5);
        let right = if x >= 3.0 { dy } else { inner };
        if x <= -3.0 { 0.0 } else { right }
    }
}

#[inline(always)]
pub(crate) fn sigmoid_of(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// Below 0.625 a polynomial (Cephes' tanhf), since 1 − 2/(e²ˣ + 1) would cancel.
#[inline(always)]
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
#[inline(always)]
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
