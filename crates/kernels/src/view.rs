//! Values as a consumer sees them: through a batch norm, a ReLU or ReLU6, both or neither.
//!
//! Normalised and rectified values are never stored. Whoever reads a convolution's output applies the
//! view on the way, and the gradient comes back the same way.

use crate::fold::Fold;
use crate::simd::{Simd, at_level};

/// Runs `$body` for the vectors of one row: `$c` is the first channel, `$n` the number of lanes. A macro,
/// because a closure would not carry the target features.
macro_rules! vectors {
    ($simd:ty, $channels:expr, $c:ident, $n:ident, $body:block) => {
        let channels: usize = $channels;
        let mut $c = 0;
        while $c + <$simd>::LANES <= channels {
            let $n = <$simd>::LANES;
            $body
            $c += <$simd>::LANES;
        }
        if $c < channels {
            let $n = channels - $c;
            $body
        }
    };
}
pub(crate) use vectors;

/// Values of rows that are gone through once per vector of channels. Coefficients are loaded once for all of
/// them; more than some cache lines of them, and large images no longer come from memory in order, which
/// costs more (a tenth of a training step of mobilenet-v2 at 2048).
const BLOCK: usize = 256;

/// Length of whole rows that is about [`BLOCK`].
pub(crate) fn block(channels: usize) -> usize {
    (BLOCK / channels).max(1) * channels
}

/// What cuts off values at their corners. NaN stays NaN and lets its gradient pass.
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
pub struct View<'a> {
    /// Scale and shift per channel.
    pub affine: Option<(&'a [f32], &'a [f32])>,
    /// What follows.
    pub rectifier: Rectifier,
}

impl View<'_> {
    /// Whether values are seen as they are stored.
    pub fn is_plain(&self) -> bool {
        self.affine.is_none() && self.rectifier == Rectifier::None
    }

    fn check(&self, channels: usize, x: &[f32], y: &[f32]) {
        assert!(channels > 0 && x.len() == y.len() && x.len().is_multiple_of(channels), "rows of {channels}");
        if let Some((scale, shift)) = self.affine {
            assert!(
                scale.len() == channels && shift.len() == channels,
                "coefficients of {channels} channels"
            );
        }
    }

    /// `x` as it is seen: itself where the view is plain, else in `scratch`.
    pub fn seen<'b>(&self, channels: usize, x: &'b [f32], scratch: &'b mut [f32]) -> &'b [f32] {
        if self.is_plain() {
            return x;
        }
        let scratch = &mut scratch[..x.len()];
        self.apply(channels, x, scratch);
        scratch
    }

    /// `y = view(x)`.
    pub fn apply(&self, channels: usize, x: &[f32], y: &mut [f32]) {
        self.check(channels, x, y);
        match (self.affine, self.rectifier) {
            (None, Rectifier::None) => y.copy_from_slice(x),
            (None, Rectifier::Relu) => crate::pointwise::relu(x, y),
            (None, Rectifier::Relu6) => crate::activation::relu6(x, y),
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

/// # Safety
/// The CPU has the features of `S`; lengths as checked by [`View::apply`].
#[inline(always)]
unsafe fn affine_at<S: Simd>(
    channels: usize,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
) {
    let block = block(channels);
    for (x, y) in x.chunks(block).zip(y.chunks_mut(block)) {
        // Channel by channel, so that the coefficients stay in registers.
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`, the length of every row and of the coefficients.
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

/// `v` as a rectifier leaves it.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
pub(crate) unsafe fn rectify<S: Simd>(rectifier: Rectifier, v: S::V) -> S::V {
    // SAFETY: the caller's contract.
    unsafe {
        match rectifier {
            Rectifier::None => v,
            Rectifier::Relu => S::zero_unless_positive(v, v),
            Rectifier::Relu6 => S::at_most(S::zero_unless_positive(v, v), S::splat(6.0)),
        }
    }
}

/// The gradient `dy` of rectified values where the value before, `v`, lets it pass, else 0.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
pub(crate) unsafe fn rectified_gradient<S: Simd>(rectifier: Rectifier, v: S::V, dy: S::V) -> S::V {
    // SAFETY: the caller's contract.
    unsafe {
        match rectifier {
            Rectifier::None => dy,
            Rectifier::Relu => S::zero_unless_positive(v, dy),
            Rectifier::Relu6 => S::zero_from(v, S::splat(6.0), S::zero_unless_positive(v, dy)),
        }
    }
}

/// # Safety
/// The CPU has the features of `S` and `at + n <= from.len()`.
#[inline(always)]
pub(crate) unsafe fn load<S: Simd>(from: &[f32], at: usize, n: usize) -> S::V {
    debug_assert!(at + n <= from.len());
    // SAFETY: the caller's contract.
    unsafe {
        let p = from.as_ptr().add(at);
        if n == S::LANES { S::load(p) } else { S::load_first(p, n) }
    }
}

/// # Safety
/// The CPU has the features of `S` and `at + n <= to.len()`.
#[inline(always)]
pub(crate) unsafe fn store<S: Simd>(to: &mut [f32], at: usize, n: usize, v: S::V) {
    debug_assert!(at + n <= to.len());
    // SAFETY: the caller's contract.
    unsafe {
        let p = to.as_mut_ptr().add(at);
        if n == S::LANES { S::store(p, v) } else { S::store_first(p, v, n) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch_norm::{self, InputGradient};
    use crate::reduce::add_gradient_sums;

    /// ```python
    /// x = torch.tensor([-1, 0, 2, 6, 7, torch.nan], requires_grad=True)
    /// torch.nn.functional.relu6(x).sum().backward()  # 0 0 1 0 0 1; and relu: 0 0 1 1 1 1
    /// ```
    #[test]
    fn corners_are_those_of_pytorch_with_and_without_a_norm() {
        let x = [-1.0, 0.0, 2.0, 6.0, 7.0, f32::NAN];
        for (rectifier, seen, passes) in [
            (Rectifier::None, [-1.0, 0.0, 2.0, 6.0, 7.0], [1.0; 6]),
            (Rectifier::Relu, [0.0, 0.0, 2.0, 6.0, 7.0], [0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
            (Rectifier::Relu6, [0.0, 0.0, 2.0, 6.0, 6.0], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]),
        ] {
            // One channel, and rows of 35 that fill vectors and leave a rest.
            for channels in [1, 35] {
                let wide =
                    |values: &[f32]| -> Vec<f32> { values.iter().flat_map(|v| vec![*v; channels]).collect() };
                let (ones, zeros) = (vec![1.0; channels], vec![0.0; channels]);
                let norm = InputGradient {
                    dy: ones.clone(),
                    x: zeros.clone(),
                    mean: zeros.clone(),
                    constant: zeros.clone(),
                };
                // Without the NaN, since 0 · NaN is NaN in the norm's gradient.
                let finite = wide(&x[..5]);
                for affine in [None, Some((&ones[..], &zeros[..]))] {
                    let view = View { affine, rectifier };
                    let (x, mut y) = (wide(&x), vec![1.0; 6 * channels]);
                    view.apply(channels, &x, &mut y);
                    assert_eq!(y[..5 * channels], wide(&seen), "{view:?}");
                    assert!(y[5 * channels..].iter().all(|v| v.is_nan()), "{view:?}");
                    let (dy, mut dx) = (vec![1.0; 6 * channels], vec![2.0; 6 * channels]);
                    if affine.is_some() {
                        let (dy, dx) = (&dy[..finite.len()], &mut dx[..finite.len()]);
                        batch_norm::backward(channels, &finite, &view, Some(&norm), dy, dx, false);
                        assert_eq!(*dx, wide(&passes[..5]), "{view:?}");
                        let (mut sums, mut deviations) = (zeros.clone(), zeros.clone());
                        add_gradient_sums(channels, &finite, &view, dy, &zeros, &mut sums, &mut deviations);
                        assert_eq!(sums, vec![passes[..5].iter().sum::<f32>(); channels], "{view:?}");
                    } else {
                        batch_norm::backward(channels, &x, &view, None, &dy, &mut dx, false);
                        assert_eq!(dx, wide(&passes), "{view:?}");
                    }
                }
            }
        }
    }
}
