//! Functions of one value, with PyTorch's gradients at the corners. NaN stays NaN.
//!
//! `exp` is written out in vectors; its relative error is below 2e-7.

use crate::lengths::exactly;
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};

/// Defines a function value by value: `name(x, y)`.
macro_rules! forward {
    ($(#[$meta:meta])* $name:ident($($arg:ident: $ty:ty)?) = $body:ident, |$x:ident| $value:expr) => {
        at_level! { $(#[$meta])* pub fn $name($($arg: $ty,)? x: &[f32], y: &mut [f32]) = $body }

        /// Computes the function value by value, compiled for the vectors of `S`.
        ///
        /// # Safety
        /// The CPU has the features of `S`.
        #[inline(always)]
        unsafe fn $body<S: Simd>($($arg: $ty,)? x: &[f32], y: &mut [f32]) {
            exactly(concat!("output of ", stringify!($name)), y.len(), x.len());
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

        /// Writes the gradient to `dx` value by value or adds it, compiled for the vectors of `S`.
        ///
        /// # Safety
        /// The CPU has the features of `S`.
        #[inline(always)]
        unsafe fn $body<S: Simd>(
            $($arg: $ty,)? kept: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool,
        ) {
            exactly(concat!("kept values of ", stringify!($name)), kept.len(), dx.len());
            exactly(concat!("dy of ", stringify!($name)), dy.len(), dx.len());
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

// The functions that `forward` and `backward` define are plain loops: compiled per level, they become
// vectors of that level's width.

forward! {
    /// Computes `y = max(x, 0)`.
    relu() = relu_at, |x| if x <= 0.0 { 0.0 } else { x }
}

backward! {
    /// Computes the gradient of [`relu`] from its input or its output: 0 at 0.
    relu_backward() = relu_backward_at, |x, dy| if x <= 0.0 { 0.0 } else { dy }
}

forward! {
    /// Computes `y = min(max(x, 0), 6)`.
    relu6() = relu6_at, |x| x.clamp(0.0, 6.0)
}

backward! {
    /// Computes the gradient of [`relu6`] from its input: 0 at both corners.
    relu6_backward() = relu6_backward_at, |x, dy| if x <= 0.0 || x >= 6.0 { 0.0 } else { dy }
}

forward! {
    /// Computes `y = x` above 0, else `y = slope · x`.
    leaky_relu(slope: f32) = leaky_relu_at, |x| if x > 0.0 { x } else { slope * x }
}

backward! {
    /// Computes the gradient of [`leaky_relu`] from its input: `slope` at 0.
    leaky_relu_backward(slope: f32) = leaky_relu_backward_at,
    |x, dy| if x > 0.0 { dy } else { slope * dy }
}

at_level! {
    /// Computes `y = 1 / (1 + e⁻ˣ)`.
    pub fn sigmoid(x: &[f32], y: &mut [f32]) = sigmoid_at
}

/// Computes [`sigmoid`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn sigmoid_at<S: Simd>(x: &[f32], y: &mut [f32]) {
    exactly("output of sigmoid", y.len(), x.len());
    vectors!(S, x.len(), at, n, {
        // SAFETY: `at + n <= x.len()`, which is asserted to be `y.len()` too.
        unsafe { store::<S>(y, at, n, sigmoid_of::<S>(load::<S>(x, at, n))) }
    });
}

backward! {
    /// Computes the gradient of [`sigmoid`] from its output.
    sigmoid_backward() = sigmoid_backward_at, |y, dy| dy * (y * (1.0 - y))
}

at_level! {
    /// Computes `y = tanh(x)`.
    pub fn tanh(x: &[f32], y: &mut [f32]) = tanh_at
}

/// Computes [`tanh`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn tanh_at<S: Simd>(x: &[f32], y: &mut [f32]) {
    exactly("output of tanh", y.len(), x.len());
    vectors!(S, x.len(), at, n, {
        // SAFETY: `at + n <= x.len()`, which is asserted to be `y.len()` too.
        unsafe { store::<S>(y, at, n, tanh_of::<S>(load::<S>(x, at, n))) }
    });
}

backward! {
    /// Computes the gradient of [`tanh`] from its output.
    tanh_backward() = tanh_backward_at, |y, dy| dy * (1.0 - y * y)
}

forward! {
    /// Computes `y = x · min(max(x + 3, 0), 6) / 6`.
    hard_swish() = hard_swish_at, |x| {
        let inner = x * (x + 3.0) / 6.0;
        let right = if x >= 3.0 { x } else { inner };
        if x <= -3.0 { 0.0 } else { right }
    }
}

backward! {
    /// Computes the gradient of [`hard_swish`] from its input: 0 at −3, 1 at 3.
    hard_swish_backward() = hard_swish_backward_at, |x, dy| {
        let inner = dy * (x / 3.0 + 0.5);
        let right = if x >= 3.0 { dy } else { inner };
        if x <= -3.0 { 0.0 } else { right }
    }
}

/// Returns the sigmoid of every lane.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
pub(crate) unsafe fn sigmoid_of<S: Simd>(x: S::V) -> S::V {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe {
        let one = S::splat(1.0);
        S::div(one, S::add(one, exp::<S>(S::sub(S::splat(0.0), x))))
    }
}

/// Returns the tanh of every lane. Up to ±0.625 it is a polynomial (Cephes' tanhf), since 1 − 2/(e²ˣ + 1) would
/// cancel.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
pub(crate) unsafe fn tanh_of<S: Simd>(x: S::V) -> S::V {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        let z = S::mul(x, x);
        let mut near = S::splat(-5.704_988_7e-3);
        for coefficient in [2.063_909e-2, -5.373_971_6e-2, 1.333_144_2e-1, -3.333_328e-1] {
            near = S::fma(near, z, S::splat(coefficient));
        }
        let near = S::fma(S::mul(near, z), x, x);
        let magnitude = S::where_beats(x, zero, x, S::sub(zero, x));
        let far = S::div(S::splat(2.0), S::add(exp::<S>(S::add(magnitude, magnitude)), one));
        let far = S::sub(one, far);
        let far = S::where_beats(x, zero, far, S::sub(zero, far));
        S::where_beats(magnitude, S::splat(0.625), far, near)
    }
}

/// Returns eˣ of every lane, held at the ends of the range of normal numbers; NaN stays NaN.
///
/// Cody and Waite's reduction to ±ln 2 / 2 and Cephes' polynomial. Adding 1.5·2²³ rounds to an integer and
/// leaves it in the low bits, from where it becomes the exponent.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn exp<S: Simd>(x: S::V) -> S::V {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe {
        let (zero, one, round) = (S::splat(0.0), S::splat(1.0), S::splat(12_582_912.0));
        let x = S::at_most(x, S::splat(88.0));
        let x = S::sub(zero, S::at_most(S::sub(zero, x), S::splat(87.0)));
        let shifted = S::fma(x, S::splat(std::f32::consts::LOG2_E), round);
        let power = S::sub(shifted, round);
        let r = S::fma(power, S::splat(-0.693_359_4), x);
        let r = S::fma(power, S::splat(2.121_944_4e-4), r);
        let mut polynomial = S::splat(1.987_569_1e-4);
        for coefficient in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 0.5] {
            polynomial = S::fma(polynomial, r, S::splat(coefficient));
        }
        let fraction = S::fma(S::mul(polynomial, r), r, S::add(r, one));
        S::mul(fraction, S::power_of_two(shifted))
    }
}

#[cfg(test)]
mod tests {
    use crate::simd::Portable;

    fn exp(x: f32) -> f32 {
        // SAFETY: the portable level needs no feature.
        unsafe { super::exp::<Portable>([x; 4])[0] }
    }

    #[test]
    fn exp_is_close_everywhere_and_hides_no_nan() {
        for i in (-87_000..=88_000).step_by(if cfg!(miri) { 1000 } else { 1 }) {
            let x = i as f32 / 1000.0;
            let want = f64::from(x).exp();
            assert!((f64::from(exp(x)) / want - 1.0).abs() < 2e-7, "e^{x} is {}, want {want}", exp(x));
        }
        assert!(exp(f32::NAN).is_nan());
        assert_eq!(exp(f32::NEG_INFINITY), exp(-87.0));
        assert!(exp(f32::INFINITY).is_finite());
    }
}
