//! Values that go from place to place, seen through a batch norm or a rectifier, or added.

use crate::lengths::{at_least, exactly, reach};
use crate::pointwise;
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::view::{AffineView, rectify};

use super::place::ImagePlace;

/// Runs `each` over columns that are equally far from each other at both places; of each the starts, the distances and
/// the number.
pub(super) fn columns(
    from: &ImagePlace,
    to: &ImagePlace,
    mut each: impl FnMut([usize; 2], [usize; 2], usize),
) {
    assert!(from.size == to.size && from.channels == to.channels, "{from:?} and {to:?} are of two shapes");
    if from.is_dense() && to.is_dense() {
        return each([0; 2], [from.channels; 2], from.positions());
    }
    for (x, y) in from.rows().zip(to.rows()) {
        each([x, y], [from.pitch[2], to.pitch[2]], from.size[2]);
    }
}

/// Computes `y = view(x)`.
pub fn map(view: &AffineView, from: &ImagePlace, x: &[f32], to: &ImagePlace, y: &mut [f32]) {
    at_least("values to be moved", x.len(), from.end());
    at_least("room for values", y.len(), to.end());
    let channels = from.channels;
    columns(from, to, |[a, b], pitches, count| {
        let len = count * channels;
        if pitches == [channels; 2] {
            view.apply(channels, &x[a..a + len], &mut y[b..b + len]);
        } else {
            apart(view, channels, count, &x[a..], pitches[0], &mut y[b..], pitches[1]);
        }
    });
}

at_level! {
    fn apart(
        view: &AffineView, channels: usize, columns: usize, x: &[f32], from: usize, y: &mut [f32], to: usize,
    ) = apart_at
}

/// Computes [`map`] of one row whose columns start `from` and `to` values apart.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn apart_at<S: Simd>(
    view: &AffineView,
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

/// Copies `x` to `y`.
pub fn copy(from: &ImagePlace, x: &[f32], to: &ImagePlace, y: &mut [f32]) {
    map(&AffineView::default(), from, x, to, y);
}

/// Adds `x` to `y`.
pub fn add(from: &ImagePlace, x: &[f32], to: &ImagePlace, y: &mut [f32]) {
    at_least("values to be added", x.len(), from.end());
    at_least("room for values", y.len(), to.end());
    let channels = from.channels;
    columns(from, to, |[a, b], pitches, count| {
        let (stretches, len) =
            if pitches == [channels; 2] { (1, count * channels) } else { (count, channels) };
        for stretch in 0..stretches {
            let (a, b) = (a + stretch * pitches[0], b + stretch * pitches[1]);
            pointwise::copy(&x[a..a + len], &mut y[b..b + len], true);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "no memory holds")]
    fn columns_that_lie_too_far_apart_are_refused() {
        apart(&AffineView::default(), 1, 3, &[1.0], usize::MAX / 2 + 1, &mut [0.0; 3], 1);
    }
}
