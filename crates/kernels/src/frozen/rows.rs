//! Values that go from place to place, seen through a batch norm or a rectifier, or added.

use crate::lengths::at_least;
use crate::pointwise;
use crate::view::View;

use super::place::Place;

/// Runs `each` over stretches of values that lie together at both places; of each the start there and the length.
pub(super) fn stretches(from: &Place, to: &Place, mut each: impl FnMut(usize, usize, usize)) {
    assert!(from.size == to.size && from.channels == to.channels, "{from:?} and {to:?} are of two shapes");
    let channels = from.channels;
    if from.is_dense() && to.is_dense() {
        return each(0, 0, from.len());
    }
    let rows = from.pitch[2] == channels && to.pitch[2] == channels;
    for (x, y) in from.rows().zip(to.rows()) {
        if rows {
            each(x, y, from.size[2] * channels);
            continue;
        }
        for column in 0..from.size[2] {
            each(x + column * from.pitch[2], y + column * to.pitch[2], channels);
        }
    }
}

/// `y = view(x)`.
pub fn map(view: &View, from: &Place, x: &[f32], to: &Place, y: &mut [f32]) {
    at_least("values to be moved", x.len(), from.end());
    at_least("room for values", y.len(), to.end());
    stretches(from, to, |a, b, len| view.apply(from.channels, &x[a..a + len], &mut y[b..b + len]));
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
