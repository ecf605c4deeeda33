//! Rows of channels, gone through vector by vector.

use crate::simd::Simd;

/// Runs `$body` for the vectors of one row: `$c` is the first channel, `$n` the number of lanes, so that
/// `$c + $n` is at most `$channels`. A macro, because a closure would not carry the target features.
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

/// Values of the rows that are gone through together, once per vector of channels, so that the coefficients
/// of those channels are loaded once for all rows. With many more values, large images no longer come from
/// memory in order: at 2048 a training step of mobilenet-v2 took a tenth longer.
const BLOCK: usize = 256;

/// Returns a length of whole rows that is about [`BLOCK`].
pub(crate) fn block(channels: usize) -> usize {
    (BLOCK / channels).max(1) * channels
}

/// Loads lanes `at..at + n` of a slice, 1 ≤ `n` ≤ LANES; the other lanes are zero.
///
/// # Safety
/// The CPU has the features of `S` and `at + n <= from.len()`.
#[inline(always)]
pub(crate) unsafe fn load<S: Simd>(from: &[f32], at: usize, n: usize) -> S::V {
    debug_assert!(at + n <= from.len());
    // SAFETY: `at + n <= from.len()` by the caller's contract.
    unsafe {
        let p = from.as_ptr().add(at);
        if n == S::LANES { S::load(p) } else { S::load_first(p, n) }
    }
}

/// Stores the first `n` lanes of `v` in `at..at + n` of a slice, 1 ≤ `n` ≤ LANES.
///
/// # Safety
/// The CPU has the features of `S` and `at + n <= to.len()`.
#[inline(always)]
pub(crate) unsafe fn store<S: Simd>(to: &mut [f32], at: usize, n: usize, v: S::V) {
    debug_assert!(at + n <= to.len());
    // SAFETY: `at + n <= to.len()` by the caller's contract.
    unsafe {
        let p = to.as_mut_ptr().add(at);
        if n == S::LANES { S::store(p, v) } else { S::store_first(p, v, n) }
    }
}
