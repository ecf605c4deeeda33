//! Vectors of AVX-512.

use std::arch::x86_64::*;

use super::vector::Simd;

/// Sixteen floats.
#[derive(Clone, Copy)]
pub(crate) struct Avx512;

impl Avx512 {
    /// Returns the mask of the first `n` lanes.
    #[inline(always)]
    fn first(n: usize) -> __mmask16 {
        ((1u32 << n) - 1) as __mmask16
    }
}

// SAFETY of all blocks below: the trait's contract. Each function is some instructions of AVX-512F, which
// the caller has checked; loads and stores need no alignment.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Simd for Avx512 {
    type V = __m512;
    const LANES: usize = 16;
    const ROWS: [usize; 2] = [28, 14];

    #[inline(always)]
    unsafe fn splat(value: f32) -> __m512 {
        unsafe { _mm512_set1_ps(value) }
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> __m512 {
        unsafe { _mm512_loadu_ps(from) }
    }
    #[inline(always)]
    unsafe fn load_first(from: *const f32, n: usize) -> __m512 {
        unsafe { _mm512_maskz_loadu_ps(Self::first(n), from) }
    }
    #[inline(always)]
    unsafe fn store(to: *mut f32, v: __m512) {
        unsafe { _mm512_storeu_ps(to, v) }
    }
    #[inline(always)]
    unsafe fn store_first(to: *mut f32, v: __m512, n: usize) {
        unsafe { _mm512_mask_storeu_ps(to, Self::first(n), v) }
    }
    #[inline(always)]
    unsafe fn fma(a: __m512, b: __m512, c: __m512) -> __m512 {
        unsafe { _mm512_fmadd_ps(a, b, c) }
    }
    #[inline(always)]
    unsafe fn add(a: __m512, b: __m512) -> __m512 {
        unsafe { _mm512_add_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn sub(a: __m512, b: __m512) -> __m512 {
        unsafe { _mm512_sub_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn mul(a: __m512, b: __m512) -> __m512 {
        unsafe { _mm512_mul_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn div(a: __m512, b: __m512) -> __m512 {
        unsafe { _mm512_div_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn power_of_two(x: __m512) -> __m512 {
        unsafe {
            let exponent = _mm512_slli_epi32::<23>(_mm512_castps_si512(x));
            let one = _mm512_castps_si512(_mm512_set1_ps(1.0));
            _mm512_castsi512_ps(_mm512_add_epi32(exponent, one))
        }
    }
    #[inline(always)]
    unsafe fn zero_unless_positive(x: __m512, value: __m512) -> __m512 {
        unsafe {
            let keep = _mm512_cmp_ps_mask::<_CMP_NLE_UQ>(x, _mm512_setzero_ps());
            _mm512_maskz_mov_ps(keep, value)
        }
    }
    #[inline(always)]
    unsafe fn zero_from(x: __m512, limit: __m512, value: __m512) -> __m512 {
        unsafe { _mm512_maskz_mov_ps(_mm512_cmp_ps_mask::<_CMP_NGE_UQ>(x, limit), value) }
    }
    #[inline(always)]
    unsafe fn at_most(x: __m512, limit: __m512) -> __m512 {
        // The second operand comes out where one is NaN.
        unsafe { _mm512_min_ps(limit, x) }
    }
    #[inline(always)]
    unsafe fn where_beats(x: __m512, best: __m512, yes: __m512, no: __m512) -> __m512 {
        unsafe {
            let above = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(x, best);
            let nan = _mm512_cmp_ps_mask::<_CMP_UNORD_Q>(x, x);
            _mm512_mask_blend_ps(above | nan, no, yes)
        }
    }
    #[inline(always)]
    unsafe fn count_above(count: __m512, x: __m512, limit: __m512) -> __m512 {
        unsafe {
            let above = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(x, limit);
            _mm512_mask_add_ps(count, above, count, _mm512_set1_ps(1.0))
        }
    }
    #[inline(always)]
    unsafe fn where_equal(a: __m512, b: __m512, yes: __m512) -> __m512 {
        unsafe { _mm512_maskz_mov_ps(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b), yes) }
    }
    #[inline(always)]
    unsafe fn clamp(x: __m512, low: __m512, high: __m512) -> __m512 {
        // The second operand comes out where one is NaN.
        unsafe { _mm512_min_ps(_mm512_max_ps(x, low), high) }
    }
    #[inline(always)]
    unsafe fn load_bytes(from: *const u8, n: usize) -> __m512 {
        unsafe {
            let bytes = if n == 16 {
                _mm_loadu_si128(from.cast())
            } else {
                let mut few = [0u8; 16];
                from.copy_to_nonoverlapping(few.as_mut_ptr(), n);
                _mm_loadu_si128(few.as_ptr().cast())
            };
            _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(bytes))
        }
    }
    #[inline(always)]
    unsafe fn store_bytes(to: *mut u8, v: __m512, n: usize) {
        unsafe {
            let bytes = _mm512_cvtepi32_epi8(_mm512_cvtps_epi32(v));
            if n == 16 {
                return _mm_storeu_si128(to.cast(), bytes);
            }
            let mut few = [0u8; 16];
            _mm_storeu_si128(few.as_mut_ptr().cast(), bytes);
            few.as_ptr().copy_to_nonoverlapping(to, n);
        }
    }
}
