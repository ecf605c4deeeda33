//! How a kernel adds products to its sums: of floats, or of pairs of bf16.

use super::vector::Simd;

/// The step of a matrix product.
///
/// # Safety
/// `add` may only be called where the CPU has the features of `S` and of the product.
pub(crate) trait Product<S: Simd> {
    /// Whether one lane of a vector serves as a factor, as [`Simd::BY_LANE`] says.
    const BY_LANE: bool;

    /// Returns `c` plus the products of `a` and `b`, lane by lane.
    unsafe fn add(a: S::V, b: S::V, c: S::V) -> S::V;
}

/// Products of floats, fused with the sum.
pub(crate) struct Floats;

impl<S: Simd> Product<S> for Floats {
    const BY_LANE: bool = S::BY_LANE;

    #[inline(always)]
    unsafe fn add(a: S::V, b: S::V, c: S::V) -> S::V {
        // SAFETY: the caller's contract.
        unsafe { S::fma(a, b, c) }
    }
}

/// Products of two bf16 each, which lie in the bits of a float: that of the upper halves is added first, then that of
/// the lower ones, each fused with the sum. Subnormal numbers count as zero.
#[cfg(target_arch = "x86_64")]
pub(crate) struct Pairs;

#[cfg(target_arch = "x86_64")]
impl Product<super::Avx512> for Pairs {
    const BY_LANE: bool = false;

    #[inline(always)]
    unsafe fn add(
        a: std::arch::x86_64::__m512,
        b: std::arch::x86_64::__m512,
        c: std::arch::x86_64::__m512,
    ) -> std::arch::x86_64::__m512 {
        use std::arch::x86_64::{__m512bh, _mm512_dpbf16_ps};
        // SAFETY: the caller has checked AVX512-BF16; the types differ in name alone.
        unsafe {
            let halves = |v| std::mem::transmute::<std::arch::x86_64::__m512, __m512bh>(v);
            // The compiler reads a value that is the same in all lanes from memory only in the last place; kernels have it in `a`.
            _mm512_dpbf16_ps(c, halves(b), halves(a))
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Product<super::Avx2> for Pairs {
    const BY_LANE: bool = false;

    #[inline(always)]
    unsafe fn add(
        a: std::arch::x86_64::__m256,
        b: std::arch::x86_64::__m256,
        c: std::arch::x86_64::__m256,
    ) -> std::arch::x86_64::__m256 {
        use std::arch::x86_64::{__m256bh, _mm256_dpbf16_ps};
        // SAFETY: the caller has checked AVX512-BF16 and AVX512-VL; the types differ in name alone.
        unsafe {
            let halves = |v| std::mem::transmute::<std::arch::x86_64::__m256, __m256bh>(v);
            _mm256_dpbf16_ps(c, halves(b), halves(a))
        }
    }
}
