//! Vectors of AVX2 with fused multiply–add.

use std::arch::x86_64::*;

use super::vector::Simd;

/// Eight floats.
#[derive(Clone, Copy)]
pub(crate) struct Avx2;

/// Lane numbers, to make a mask of the first `n`.
const LANE: [i32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

// SAFETY of all blocks below: the trait's contract. Each function is some instructions of AVX2 and FMA,
// which the caller has checked; loads and stores need no alignment.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Avx2 {
    /// Returns the mask of the first `n` lanes.
    #[inline(always)]
    unsafe fn first(n: usize) -> __m256i {
        unsafe {
            let lanes = _mm256_loadu_si256(LANE.as_ptr().cast());
            _mm256_cmpgt_epi32(_mm256_set1_epi32(n as i32), lanes)
        }
    }
}

#[allow(clippy::undocumented_unsafe_blocks)]
impl Simd for Avx2 {
    type V = __m256;
    const LANES: usize = 8;
    const ROWS: [usize; 2] = [12, 6];

    #[inline(always)]
    unsafe fn splat(value: f32) -> __m256 {
        unsafe { _mm256_set1_ps(value) }
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> __m256 {
        unsafe { _mm256_loadu_ps(from) }
    }
    #[inline(always)]
    unsafe fn load_first(from: *const f32, n: usize) -> __m256 {
        unsafe { _mm256_maskload_ps(from, Self::first(n)) }
    }
    #[inline(always)]
    unsafe fn store(to: *mut f32, v: __m256) {
        unsafe { _mm256_storeu_ps(to, v) }
    }
    #[inline(always)]
    unsafe fn store_first(to: *mut f32, v: __m256, n: usize) {
        // A masked store takes tens of cycles on AMD's cores before AVX-512.
        unsafe {
            if n >= 8 {
                return _mm256_storeu_ps(to, v);
            }
            let (mut to, mut left) = (to, _mm256_castps256_ps128(v));
            if n & 4 != 0 {
                _mm_storeu_ps(to, left);
                (to, left) = (to.add(4), _mm256_extractf128_ps::<1>(v));
            }
            if n & 2 != 0 {
                _mm_storel_pd(to.cast(), _mm_castps_pd(left));
                (to, left) = (to.add(2), _mm_movehl_ps(left, left));
            }
            if n & 1 != 0 {
                _mm_store_ss(to, left);
            }
        }
    }
    #[inline(always)]
    unsafe fn fma(a: __m256, b: __m256, c: __m256) -> __m256 {
        unsafe { _mm256_fmadd_ps(a, b, c) }
    }
    #[inline(always)]
    unsafe fn add(a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_add_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn sub(a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_sub_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn mul(a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_mul_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn div(a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_div_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn power_of_two(x: __m256) -> __m256 {
        unsafe {
            let exponent = _mm256_slli_epi32::<23>(_mm256_castps_si256(x));
            let one = _mm256_castps_si256(_mm256_set1_ps(1.0));
            _mm256_castsi256_ps(_mm256_add_epi32(exponent, one))
        }
    }
    #[inline(always)]
    unsafe fn zero_unless_positive(x: __m256, value: __m256) -> __m256 {
        // "Not less or equal" is true for NaN.
        unsafe { _mm256_and_ps(value, _mm256_cmp_ps::<_CMP_NLE_UQ>(x, _mm256_setzero_ps())) }
    }
    #[inline(always)]
    unsafe fn zero_from(x: __m256, limit: __m256, value: __m256) -> __m256 {
        // "Not greater or equal" is true for NaN.
        unsafe { _mm256_and_ps(value, _mm256_cmp_ps::<_CMP_NGE_UQ>(x, limit)) }
    }
    #[inline(always)]
    unsafe fn at_most(x: __m256, limit: __m256) -> __m256 {
        // The second operand comes out where one is NaN.
        unsafe { _mm256_min_ps(limit, x) }
    }
    #[inline(always)]
    unsafe fn where_beats(x: __m256, best: __m256, yes: __m256, no: __m256) -> __m256 {
        unsafe {
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(x, best);
            let nan = _mm256_cmp_ps::<_CMP_UNORD_Q>(x, x);
            _mm256_blendv_ps(no, yes, _mm256_or_ps(above, nan))
        }
    }
    #[inline(always)]
    unsafe fn count_above(count: __m256, x: __m256, limit: __m256) -> __m256 {
        unsafe {
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(x, limit);
            _mm256_add_ps(count, _mm256_and_ps(above, _mm256_set1_ps(1.0)))
        }
    }
    #[inline(always)]
    unsafe fn where_equal(a: __m256, b: __m256, yes: __m256) -> __m256 {
        unsafe { _mm256_and_ps(yes, _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b)) }
    }
    #[inline(always)]
    unsafe fn clamp(x: __m256, low: __m256, high: __m256) -> __m256 {
        // The second operand comes out where one is NaN.
        unsafe { _mm256_min_ps(_mm256_max_ps(x, low), high) }
    }
    #[inline(always)]
    unsafe fn load_bytes(from: *const u8, n: usize) -> __m256 {
        unsafe {
            let bytes = if n == 8 {
                _mm_loadl_epi64(from.cast())
            } else {
                let mut few = [0u8; 8];
                from.copy_to_nonoverlapping(few.as_mut_ptr(), n);
                _mm_loadl_epi64(few.as_ptr().cast())
            };
            _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes))
        }
    }
    #[inline(always)]
    unsafe fn store_bytes(to: *mut u8, v: __m256, n: usize) {
        unsafe {
            let words = _mm256_cvtps_epi32(v);
            let words = _mm_packus_epi32(_mm256_castsi256_si128(words), _mm256_extracti128_si256::<1>(words));
            let bytes = _mm_packus_epi16(words, words);
            if n == 8 {
                return _mm_storel_epi64(to.cast(), bytes);
            }
            let mut few = [0u8; 8];
            _mm_storel_epi64(few.as_mut_ptr().cast(), bytes);
            few.as_ptr().copy_to_nonoverlapping(to, n);
        }
    }
}
