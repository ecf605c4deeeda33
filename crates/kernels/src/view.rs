//! Values as a consumer sees them: through a batch norm, a ReLU or ReLU6, both or neither.
//!
//! Normalised and rectified values are never stored. Whoever reads a convolution's output applies the
//! view on the way, and the gradient comes back the same way.

use crate::activation;
use crate::fold::Fold;
use crate::lengths::{at_least, exactly, whole_rows};
use crate::rows::{block, load, store, vectors};
use crate::simd::{Simd, at_level};

/// A rectifier, which cuts values off at its corners. NaN stays NaN and lets its gradient pass.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Rectifier {
    /// Values as they are.
    #[default]
    None,
    /// `max(·, 0)`; the gradient at 0 is 0.
    Relu,
    /// `min(max(·, 0), 6)`; the gradient at 0 and at 6 is 0.
    Relu6,
}

/// How a reader sees stored values (rows × channels).
#[derive(Debug, Clone, Copy, Default)]
pub struct AffineView<'a> {
    /// Scale and shift per channel.
    pub affine: Option<(&'a [f32], &'a [f32])>,
    /// The rectifier that follows.
    pub rectifier: Rectifier,
}

impl AffineView<'_> {
    /// Checks whether values are seen as they are stored.
    pub fn is_plain(&self) -> bool {
        self.affine.is_none() && self.rectifier == Rectifier::None
    }

    /// Returns `x` as it is seen: itself where the view is plain, else in `scratch`.
    pub fn seen<'b>(&self, channels: usize, x: &'b [f32], scratch: &'b mut [f32]) -> &'b [f32] {
        if self.is_plain() {
            return x;
        }
        at_least("scratch of a view", scratch.len(), x.len());
        let scratch = &mut scratch[..x.len()];
        self.apply(channels, x, scratch);
        scratch
    }

    /// Computes `y = view(x)`.
    pub fn apply(&self, channels: usize, x: &[f32], y: &mut [f32]) {
        whole_rows("a view's input", x.len(), channels);
        exactly("a view's output", y.len(), x.len());
        match (self.affine, self.rectifier) {
            (None, Rectifier::None) => y.copy_from_slice(x),
            (None, Rectifier::Relu) => activation::relu(x, y),
            (None, Rectifier::Relu6) => activation::relu6(x, y),
            (Some((scale, shift)), rectifier) => {
                let mut rest = 0;
                if let Some(fold) = Fold::new(channels) {
                    rest = fold.whole(x.len());
                    let (scale, shift) = (fold.repeat(scale), fold.repeat(shift));
                    affine(fold.channels(), &x[..rest], &scale, &shift, rectifier, &mut y[..rest]);
                }
                affine(channels, &x[rest..], scale, shift, rectifier, &mut y[rest..]);
            }
        }
    }
}

at_level! {
    fn affine(
        channels: usize, x: &[f32], scale: &[f32], shift: &[f32], rectifier: Rectifier, y: &mut [f32],
    ) = affine_at
}

/// Computes `y = rectifier(scale · x + shift)` with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn affine_at<S: Simd>(
    channels: usize,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
) {
    exactly("scale of a view", scale.len(), channels);
    exactly("shift of a view", shift.len(), channels);
    let block = block(channels);
    for (x, y) in x.chunks(block).zip(y.chunks_mut(block)) {
        // Channel by channel, so that the coefficients stay in registers.
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`: the asserted length of scale and shift, and that of every row
            // that `chunks_exact` gives.
            unsafe {
                let (scale, shift) = (load::<S>(scale, c, n), load::<S>(shift, c, n));
                for (x, y) in x.chunks_exact(channels).zip(y.chunks_exact_mut(channels)) {
                    let v = S::fma(load::<S>(x, c, n), scale, shift);
                    store::<S>(y, c, n, rectify::<S>(rectifier, v));
                }
            }
        });
    }
}

/// Returns `v` as a rectifier leaves it.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
pub(crate) unsafe fn rectify<S: Simd>(rectifier: Rectifier, v: S::V) -> S::V {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe {
        match rectifier {
            Rectifier::None => v,
            Rectifier::Relu => S::zero_unless_positive(v, v),
            Rectifier::Relu6 => S::at_most(S::zero_unless_positive(v, v), S::splat(6.0)),
        }
    }
}

/// Returns the gradient `dy` of rectified values where the value before, `v`, lets it pass, else 0.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
pub(crate) unsafe fn rectified_gradient<S: Simd>(rectifier: Rectifier, v: S::V, dy: S::V) -> S::V {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe {
        match rectifier {
            Rectifier::None => dy,
            Rectifier::Relu => S::zero_unless_positive(v, dy),
            Rectifier::Relu6 => S::zero_from(v, S::splat(6.0), S::zero_unless_positive(v, dy)),
        }
    }
}
