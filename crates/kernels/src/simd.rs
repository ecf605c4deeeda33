//! One set of vector operations, three widths: AVX-512, AVX2 with FMA, and whatever the compiler makes
//! of four floats. Chosen once, at run time.
//!
//! Kernels are written once over the trait `Simd` and instantiated per width inside a function that carries the
//! target features; everything between is inlined.

use std::sync::OnceLock;

/// The widths that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Four floats, any CPU.
    Portable,
    /// Eight floats with fused multiply–add.
    Avx2,
    /// Sixteen floats with masks; eight where more would stay empty.
    Avx512,
}

/// The widest level of this CPU. `TAXEL_SIMD=portable` or `avx2` asks for a narrower one.
pub fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let asked = std::env::var("TAXEL_SIMD").unwrap_or_default();
        if asked == "portable" {
            return Level::Portable;
        }
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if avx2 && is_x86_feature_detected!("avx512f") && asked != "avx2" {
                return Level::Avx512;
            }
            if avx2 {
                return Level::Avx2;
            }
        }
        Level::Portable
    })
}

/// Vector operations of one width.
///
/// # Safety
/// Every function may only be called where the CPU has the features of its implementation; pointers
/// must be valid for the lanes that a function names.
pub(crate) trait Simd: Copy {
    type V: Copy;
    const LANES: usize;
    /// Accumulator rows of a tile that is one and two vectors wide, so that all fit in registers.
    const ROWS: [usize; 2];

    unsafe fn splat(value: f32) -> Self::V;
    unsafe fn load(from: *const f32) -> Self::V;
    /// The first `n` lanes, 1..=LANES; the others are zero.
    unsafe fn load_first(from: *const f32, n: usize) -> Self::V;
    unsafe fn store(to: *mut f32, v: Self::V);
    unsafe fn store_first(to: *mut f32, v: Self::V, n: usize);
    /// `a · b + c`.
    unsafe fn fma(a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    unsafe fn add(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn sub(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn mul(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn div(a: Self::V, b: Self::V) -> Self::V;
    /// 2 to the power of the integer in the low bits of `x`, which must give a normal number.
    unsafe fn power_of_two(x: Self::V) -> Self::V;
    /// `if x <= 0 { 0 } else { value }` per lane: NaN in `x` lets `value` pass.
    unsafe fn zero_unless_positive(x: Self::V, value: Self::V) -> Self::V;
    /// `if x >= limit { 0 } else { value }` per lane: NaN in `x` lets `value` pass.
    unsafe fn zero_from(x: Self::V, limit: Self::V, value: Self::V) -> Self::V;
    /// `if x >= limit { limit } else { x }` per lane: NaN in `x` stays.
    unsafe fn at_most(x: Self::V, limit: Self::V) -> Self::V;
    /// `if x > best or x is NaN { yes } else { no }` per lane.
    unsafe fn where_beats(x: Self::V, best: Self::V, yes: Self::V, no: Self::V) -> Self::V;
    /// `if a == b { yes } else { 0 }` per lane.
    unsafe fn where_equal(a: Self::V, b: Self::V, yes: Self::V) -> Self::V;
}

/// Four lanes, each from its number.
macro_rules! lanes {
    ($i:ident => $value:expr) => {{
        let mut v = [0.0f32; 4];
        for $i in 0..4 {
            v[$i] = $value;
        }
        v
    }};
}

/// Four floats in an array; the compiler maps it to SSE, NEON or scalars.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

#[allow(clippy::needless_range_loop)]
impl Simd for Portable {
    type V = [f32; 4];
    const LANES: usize = 4;
    const ROWS: [usize; 2] = [12, 6];

    #[inline(always)]
    unsafe fn splat(value: f32) -> [f32; 4] {
        [value; 4]
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> [f32; 4] {
        // SAFETY: the caller guarantees four readable floats; arrays of f32 need no more alignment.
        unsafe { from.cast::<[f32; 4]>().read_unaligned() }
    }
    #[inline(always)]
    unsafe fn load_first(from: *const f32, n: usize) -> [f32; 4] {
        let mut v = [0.0; 4];
        for i in 0..n.min(4) {
            // SAFETY: the caller guarantees `n` readable floats.
            v[i] = unsafe { *from.add(i) };
        }
        v
    }
    #[inline(always)]
    unsafe fn store(to: *mut f32, v: [f32; 4]) {
        // SAFETY: the caller guarantees four writable floats.
        unsafe { to.cast::<[f32; 4]>().write_unaligned(v) }
    }
    #[inline(always)]
    unsafe fn store_first(to: *mut f32, v: [f32; 4], n: usize) {
        for i in 0..n.min(4) {
            // SAFETY: the caller guarantees `n` writable floats.
            unsafe { *to.add(i) = v[i] };
        }
    }
    #[inline(always)]
    unsafe fn fma(a: [f32; 4], b: [f32; 4], c: [f32; 4]) -> [f32; 4] {
        lanes!(i => a[i] * b[i] + c[i])
    }
    #[inline(always)]
    unsafe fn add(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        lanes!(i => a[i] + b[i])
    }
    #[inline(always)]
    unsafe fn sub(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        lanes!(i => a[i] - b[i])
    }
    #[inline(always)]
    unsafe fn mul(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        lanes!(i => a[i] * b[i])
    }
    #[inline(always)]
    unsafe fn div(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        lanes!(i => a[i] / b[i])
    }
    #[inline(always)]
    unsafe fn power_of_two(x: [f32; 4]) -> [f32; 4] {
        lanes!(i => f32::from_bits((x[i].to_bits() << 23).wrapping_add(1.0f32.to_bits())))
    }
    #[inline(always)]
    unsafe fn zero_unless_positive(x: [f32; 4], value: [f32; 4]) -> [f32; 4] {
        lanes!(i => if x[i] <= 0.0 { 0.0 } else { value[i] })
    }
    #[inline(always)]
    unsafe fn zero_from(x: [f32; 4], limit: [f32; 4], value: [f32; 4]) -> [f32; 4] {
        lanes!(i => if x[i] >= limit[i] { 0.0 } else { value[i] })
    }
    #[inline(always)]
    unsafe fn at_most(x: [f32; 4], limit: [f32; 4]) -> [f32; 4] {
        lanes!(i => if x[i] >= limit[i] { limit[i] } else { x[i] })
    }
    #[inline(always)]
    unsafe fn where_beats(x: [f32; 4], best: [f32; 4], yes: [f32; 4], no: [f32; 4]) -> [f32; 4] {
        lanes!(i => if x[i] > best[i] || x[i].is_nan() { yes[i] } else { no[i] })
    }
    #[inline(always)]
    unsafe fn where_equal(a: [f32; 4], b: [f32; 4], yes: [f32; 4]) -> [f32; 4] {
        lanes!(i => if a[i] == b[i] { yes[i] } else { 0.0 })
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Simd;
    use std::arch::x86_64::*;

    /// Eight floats.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2;

    /// Lane numbers, to make a mask of the first `n`.
    const LANE: [i32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

    // SAFETY of all blocks below: the trait's contract; each function is one or two instructions of
    // the feature set that the caller has checked.
    #[allow(clippy::undocumented_unsafe_blocks)]
    impl Avx2 {
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
        unsafe fn where_equal(a: __m256, b: __m256, yes: __m256) -> __m256 {
            unsafe { _mm256_and_ps(yes, _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b)) }
        }
    }

    /// Sixteen floats.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx512;

    impl Avx512 {
        #[inline(always)]
        fn first(n: usize) -> __mmask16 {
            ((1u32 << n) - 1) as __mmask16
        }
    }

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
        unsafe fn where_equal(a: __m512, b: __m512, yes: __m512) -> __m512 {
            unsafe { _mm512_maskz_mov_ps(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b), yes) }
        }
    }
}

/// Defines `fn name(..)` that runs `body::<S>(..)` at the CPU's level.
macro_rules! at_level {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),* $(,)?) = $body:ident) => {
        $(#[$meta])*
        #[allow(clippy::too_many_arguments)]
        $vis fn $name($($arg: $ty),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[allow(clippy::too_many_arguments)]
                #[target_feature(enable = "avx512f")]
                unsafe fn avx512($($arg: $ty),*) {
                    // SAFETY: the caller has checked the feature.
                    unsafe { $body::<$crate::simd::Avx512>($($arg),*) }
                }
                #[allow(clippy::too_many_arguments)]
                #[target_feature(enable = "avx2,fma")]
                unsafe fn avx2($($arg: $ty),*) {
                    // SAFETY: the caller has checked the features.
                    unsafe { $body::<$crate::simd::Avx2>($($arg),*) }
                }
                match $crate::simd::level() {
                    // SAFETY: `level` has found the features on this CPU.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Portable => {}
                }
            }
            // SAFETY: the portable level needs no feature.
            unsafe { $body::<$crate::simd::Portable>($($arg),*) }
        }
    };
}
pub(crate) use at_level;
