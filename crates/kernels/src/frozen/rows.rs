//! Values that go from place to place, seen through a batch norm or a rectifier, or added.

use crate::lengths::{at_least, exactly, reach};
use crate::pointwise;
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::view::{View, rectify};

use super::place::Place;

/// Runs `each` over stretches of values that lie together at both places; of each the start there and the length.
pub(super) fn stretches(from: &Place, to: &Place, mut each: impl FnMut(usize, usize, usize)) {
    assert!(from.size == to.size && from.channels == to.channels, "{from:?} and {to:?} are of two shapes");
    let channels = from.channels;
    if from.is_dense() && to.is_dense() {
        return each(0, 0, from.len());
    }
    let together = rows_lie_together(from, to);
    for (x, y) in from.rows().zip(to.rows()) {
        if together {
            each(x, y, from.size[2] * channels);
            continue;
        }
        for column in 0..from.size[2] {
            each(x + column * from.pitch[2], y + column * to.pitch[2], channels);
        }
    }
}

/// Whether no other channels lie between the columns.
pub(super) fn rows_lie_together(from: &Place, to: &Place) -> bool {
    from.pitch[2] == from.channels && to.pitch[2] == to.channels
}

/// `y = view(x)`.
pub fn map(view: &View, from: &Place, x: &[f32], to: &Place, y: &mut [f32]) {
    at_least("values to be moved", x.len(), from.end());
    at_least("room for values", y.len(), to.end());
    let channels = from.channels;
    if rows_lie_together(from, to) {
        return stretches(from, to, |a, b, len| view.apply(channels, &x[a..a + len], &mut y[b..b + len]));
    }
    assert!(from.size == to.size && channels == to.channels, "{from:?} and {to:?} are of two shapes");
    for (a, b) in from.rows().zip(to.rows()) {
        apart(view, channels, from.size[2], &x[a..], from.pitch[2], &mut y[b..], to.pitch[2]);
    }
}

at_level! {
    fn apart(
        view: &View, channels: usize, columns: usize, x: &[f32], from: usize, y: &mut [f32], to: usize,
    ) = apart_at
}

/// [`map`] of one row whose columns start `from` and `to` values apart.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn apart_at<S: Simd>(
    view: &View,
    channels: usize,
    columns: usize,
    x: &[f32],
    from: usize,
    y: &mut [f32],
    to: usize,
) {
    at_least("columns to be moved", x.len(), reach(columns, from, channels));
    at_least("room for columns", y.len(), reach(columns, to, channels));
    if let Some((scale, shift)) = view.affine {
        exactly("scale of a view", scale.len(), channels);
        exactly("shift of a view", shift.len(), channels);
    }
    // Channel by channel, so that the coefficients stay in registers.
    vectors!(S, channels, c, n, {
        // SAFETY: `c + n <= channels`: the asserted length of scale and shift, and what the asserted lengths of `x` and `y`
        // hold from the start of each of the `columns`.
        unsafe {
            let affine = view.affine.map(|(scale, shift)| (load::<S>(scale, c, n), load::<S>(shift, c, n)));
            for column in 0..columns {
                let v = load::<S>(x, column * from + c, n);
                let v = affine.map_or(v, |(scale, shift)| S::fma(v, scale, shift));
                store::<S>(y, column * to + c, n, rectify::<S>(view.rectifier, v));
            }
        }
    });
}

/// `y = x`.
pub fn copy(from: &Place, x: &[f32], to: &Place, y: &mut [f32]) {
    map(&View::default(), from, x, to, y);
}

/// `y = y + x`.
pub fn add(from: &Place, x: &[f32], to: &Place, y: &mut [f32]) {
    at_least("values to be added", x.len(), from.end());
    at_least("room for values", y.len(), to.end());
    stretches(from, to, |a, b, len| pointwise::copy(&x[a..a + len], &mut y[b..b + len], true));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "no memory holds")]
    fn columns_that_lie_too_far_apart_are_refused() {
        apart(&View::default(), 1, 3, &[1.0], usize::MAX / 2 + 1, &mut [0.0; 3], 1);
    }
}
