//! Dropout: values kept and scaled, or multiplied by zero.

use crate::lengths::exactly;

/// Writes `y = x · scale` where `keeps(index)`, else `x · 0`, or adds it to `y`. The product lets NaN through.
///
/// Forward with values, backward with gradients and the same `keeps`. Indices count from the start of
/// `x`; `scale` is 1 / (1 − the drop probability).
pub fn apply(x: &[f32], y: &mut [f32], scale: f32, keeps: impl Fn(usize) -> bool, accumulate: bool) {
    exactly("output of a dropout", y.len(), x.len());
    let rows = y.iter_mut().zip(x).enumerate();
    let factor = |index| if keeps(index) { scale } else { 0.0 };
    if accumulate {
        for (index, (y, x)) in rows {
            *y += x * factor(index);
        }
    } else {
        for (index, (y, x)) in rows {
            *y = x * factor(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_values_are_scaled_and_nan_comes_through() {
        let x = [1.0, 2.0, f32::NAN, f32::NAN, 5.0];
        let mut y = [10.0; 5];
        apply(&x, &mut y, 2.0, |i| i % 2 == 0, false);
        assert_eq!((y[0], y[1], y[4]), (2.0, 0.0, 10.0));
        assert!(y[2].is_nan() && y[3].is_nan(), "kept or dropped");
        apply(&x[..2], &mut y[..2], 2.0, |i| i % 2 == 0, true);
        assert_eq!(y[..2], [4.0, 0.0]);
    }
}
