//! Values as a consumer sees them: through a batch norm, a ReLU, both or neither.
//!
//! Normalised and rectified values are never stored. Whoever reads a convolution's output applies the
//! view on the way, and the gradient comes back the same way.

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

/// How a reader sees stored values (rows × channels).
#[derive(Debug, Clone, Copy, Default)]
pub struct View<'a> {
    /// Scale and shift per channel.
    pub affine: Option<(&'a [f32], &'a [f32])>,
    /// `max(·, 0)` after that.
    pub relu: bool,
}

impl View<'_> {
    /// Whether values are seen as they are stored.
    pub fn is_plain(&self) -> bool {
        self.affine.is_none() && !self.relu
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
        match (self.affine, self.relu) {
            (None, false) => y.copy_from_slice(x),
            (None, true) => crate::pointwise::relu(x, y),
            (Some((scale, shift)), relu) => affine(channels, x, scale, shift, relu, y),
        }
    }
}

at_level! {
    fn affine(channels: usize, x: &[f32], scale: &[f32], shift: &[f32], relu: bool, y: &mut [f32]) = affine_at
}

/// # Safety
/// The CPU has the features of `S`; lengths as checked by [`View::apply`].
#[inline(always)]
unsafe fn affine_at<S: Simd>(
    channels: usize,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    relu: bool,
    y: &mut [f32],
) {
    // Channel by channel block, so that the coefficients stay in registers.
    vectors!(S, channels, c, n, {
        // SAFETY: `c + n <= channels`, the length of every row and of the coefficients.
        unsafe {
            let (scale, shift) = (load::<S>(scale, c, n), load::<S>(shift, c, n));
            for (x, y) in x.chunks_exact(channels).zip(y.chunks_exact_mut(channels)) {
                let v = S::fma(load::<S>(x, c, n), scale, shift);
                store::<S>(y, c, n, if relu { S::zero_unless_positive(v, v) } else { v });
            }
        }
    });
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
