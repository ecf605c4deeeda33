//! Values rounded to bf16 by the processor's own instruction.

use crate::lengths::{at_least, exactly, reach};

use super::support::assert_supported;

/// Makes pairs of neighbours in `count` stretches of `len` values that start `pitch` apart: `len / 2` pairs each, rounded
/// up, the last with 0 where `len` is odd. Subnormal numbers become 0, as which products count them. Panics where
/// [`supported`](super::supported) is an error.
pub(crate) fn halve(count: usize, pitch: usize, len: usize, x: &[f32], pairs: &mut [f32]) {
    assert_supported();
    at_least("values to be rounded", x.len(), reach(count, pitch, len));
    exactly("pairs of rounded values", pairs.len(), count * len.div_ceil(2));
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: the features are there and the slices hold all stretches, as just asserted.
        unsafe { halve_at(count, pitch, len, x.as_ptr(), pairs.as_mut_ptr()) };
    }
}

/// Computes [`halve`].
///
/// # Safety
/// The CPU has AVX512-BF16. From `x` on lie `count` stretches of `len` values, `pitch` apart; from `pairs` on there is room
/// for as many pairs, which overlap no value.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bf16")]
unsafe fn halve_at(count: usize, pitch: usize, len: usize, x: *const f32, pairs: *mut f32) {
    use crate::simd::{Avx512, Simd};
    const LANES: usize = Avx512::LANES;
    // SAFETY: a stretch ends `len` values behind its start and its pairs half as many behind theirs; the last loads and stores
    // are cut off there.
    unsafe {
        for stretch in 0..count {
            let (x, pairs) = (x.add(stretch * pitch), pairs.add(stretch * len.div_ceil(2)));
            let mut at = 0;
            while at + 2 * LANES <= len {
                let both = [Avx512::load(x.add(at)), Avx512::load(x.add(at + LANES))];
                Avx512::store(pairs.add(at / 2), paired(both));
                at += 2 * LANES;
            }
            let left = len - at;
            if left > 0 {
                let first = Avx512::load_first(x.add(at), left.min(LANES));
                let second = match left.checked_sub(LANES) {
                    None | Some(0) => Avx512::splat(0.0),
                    Some(n) => Avx512::load_first(x.add(at + LANES), n),
                };
                Avx512::store_first(pairs.add(at / 2), paired([first, second]), left.div_ceil(2));
            }
        }
    }
}

/// Returns neighbours of 32 values as pairs, the first of each in the upper half.
///
/// # Safety
/// The CPU has AVX512-BF16.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
unsafe fn paired([first, second]: [std::arch::x86_64::__m512; 2]) -> std::arch::x86_64::__m512 {
    use std::arch::x86_64::{__m512bh, __m512i, _mm512_castsi512_ps, _mm512_cvtne2ps_pbh, _mm512_rol_epi32};
    // SAFETY: the caller has checked the features; the types differ in name alone.
    unsafe {
        let halves = std::mem::transmute::<__m512bh, __m512i>(_mm512_cvtne2ps_pbh(second, first));
        // The instruction leaves the first of two neighbours in the lower half.
        _mm512_castsi512_ps(_mm512_rol_epi32::<16>(halves))
    }
}
