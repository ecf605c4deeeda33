//! Products of four bytes with four weights, added to 32-bit sums, in several widths.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

#[cfg(target_arch = "aarch64")]
use crate::simd::is_wanted;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use crate::simd::{Level, level};
use crate::simd::{Portable, Simd};

/// How wide sums of products are computed; all give the same sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// Four sums, any CPU.
    Portable,
    /// Four sums, by products of 16-bit numbers, on 64-bit Arm.
    Neon,
    /// Four sums by `sdot`.
    DotProduct,
    /// Eight sums, by products of 16-bit pairs: those of bytes would have to be cut off.
    Avx2,
    /// Sixteen sums by `vpdpbusd`.
    Vnni,
}

impl Width {
    /// Returns all widths that this CPU has, the widest last; `TAXEL_SIMD` may ask for narrower ones.
    pub fn all() -> Vec<Width> {
        let mut all = vec![Width::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if level() != Level::Portable {
                all.push(Width::Avx2);
            }
            let has_vnni = is_x86_feature_detected!("avx512bw") && is_x86_feature_detected!("avx512vnni");
            if level() == Level::Avx512 && has_vnni {
                all.push(Width::Vnni);
            }
        }
        #[cfg(target_arch = "aarch64")]
        if level() == Level::Neon {
            all.push(Width::Neon);
            if std::arch::is_aarch64_feature_detected!("dotprod") && !is_wanted("neon") {
                all.push(Width::DotProduct);
            }
        }
        all
    }

    /// Returns the widest width of this CPU.
    pub fn widest() -> Width {
        Width::all().pop().unwrap_or(Width::Portable)
    }
}

/// Sums of one width, which become floats of `S`.
///
/// # Safety
/// As [`Simd`]; of AVX-512 the CPU has BW and VNNI too, of `sdot` dotprod.
pub(super) trait Dot<S: Simd> {
    /// Fours of bytes that are loaded at once.
    const FOURS: usize = 1;
    /// A number that is taken from bytes before they are multiplied; the starts of sums make good for it.
    const TAKEN: u8 = 0;

    /// LANES sums.
    type Sums: Copy;
    /// Four weights of each lane.
    type Weights: Copy;
    /// `FOURS` times four bytes, the same for all lanes.
    type Bytes: Copy;

    /// Returns where weight `k` of `lane` lies among the 4 · LANES of all.
    fn place(lane: usize, k: usize) -> usize;
    unsafe fn sums(from: *const i32) -> Self::Sums;
    unsafe fn weights(from: *const i8) -> Self::Weights;
    /// Loads four bytes, as the first ones.
    unsafe fn four(from: *const u8) -> Self::Bytes;
    /// Loads `FOURS` times four bytes.
    #[inline(always)]
    unsafe fn fours(from: *const u8) -> Self::Bytes {
        // SAFETY: the caller's contract.
        unsafe { Self::four(from) }
    }
    /// Returns `sums + bytes · weights` per lane, of the four bytes with number `F`.
    unsafe fn dot<const F: u8>(sums: Self::Sums, bytes: Self::Bytes, weights: Self::Weights) -> Self::Sums;
    /// Returns the nearest floats.
    unsafe fn floats(sums: Self::Sums) -> S::V;
}

#[allow(clippy::needless_range_loop)]
impl Dot<Portable> for Portable {
    type Sums = [i32; 4];
    type Weights = [i8; 16];
    type Bytes = [u8; 4];

    fn place(lane: usize, k: usize) -> usize {
        4 * lane + k
    }
    #[inline(always)]
    unsafe fn sums(from: *const i32) -> [i32; 4] {
        // SAFETY: the caller guarantees four readable sums.
        unsafe { from.cast::<[i32; 4]>().read_unaligned() }
    }
    #[inline(always)]
    unsafe fn weights(from: *const i8) -> [i8; 16] {
        // SAFETY: the caller guarantees sixteen readable weights.
        unsafe { from.cast::<[i8; 16]>().read_unaligned() }
    }
    #[inline(always)]
    unsafe fn four(from: *const u8) -> [u8; 4] {
        // SAFETY: the caller guarantees four readable bytes.
        unsafe { from.cast::<[u8; 4]>().read_unaligned() }
    }
    #[inline(always)]
    unsafe fn dot<const F: u8>(mut sums: [i32; 4], four: [u8; 4], weights: [i8; 16]) -> [i32; 4] {
        for lane in 0..4 {
            for k in 0..4 {
                sums[lane] += i32::from(four[k]) * i32::from(weights[4 * lane + k]);
            }
        }
        sums
    }
    #[inline(always)]
    unsafe fn floats(sums: [i32; 4]) -> [f32; 4] {
        sums.map(|sum| sum as f32)
    }
}

// SAFETY of all blocks below: the trait's contract. Each function is some instructions that the caller has checked;
// loads need no alignment.
#[cfg(target_arch = "x86_64")]
#[allow(clippy::undocumented_unsafe_blocks)]
impl Dot<Avx2> for Avx2 {
    type Sums = __m256i;
    /// The first and the last two of each lane.
    type Weights = [__m256i; 2];
    type Bytes = [__m256i; 2];

    fn place(lane: usize, k: usize) -> usize {
        k / 2 * 16 + 2 * lane + k % 2
    }
    #[inline(always)]
    unsafe fn sums(from: *const i32) -> __m256i {
        unsafe { _mm256_loadu_si256(from.cast()) }
    }
    #[inline(always)]
    unsafe fn weights(from: *const i8) -> [__m256i; 2] {
        unsafe {
            let wide = |at: usize| _mm256_cvtepi8_epi16(_mm_loadu_si128(from.add(at).cast()));
            [wide(0), wide(16)]
        }
    }
    #[inline(always)]
    unsafe fn four(from: *const u8) -> [__m256i; 2] {
        unsafe {
            // Each pair as two 16-bit numbers: -128 puts a zero.
            let four = _mm256_set1_epi32(from.cast::<i32>().read_unaligned());
            let first = _mm256_set1_epi32(0x8001_8000_u32 as i32);
            let last = _mm256_set1_epi32(0x8003_8002_u32 as i32);
            [_mm256_shuffle_epi8(four, first), _mm256_shuffle_epi8(four, last)]
        }
    }
    #[inline(always)]
    unsafe fn dot<const F: u8>(sums: __m256i, four: [__m256i; 2], weights: [__m256i; 2]) -> __m256i {
        unsafe {
            let first = _mm256_madd_epi16(four[0], weights[0]);
            let last = _mm256_madd_epi16(four[1], weights[1]);
            _mm256_add_epi32(_mm256_add_epi32(sums, first), last)
        }
    }
    #[inline(always)]
    unsafe fn floats(sums: __m256i) -> __m256 {
        unsafe { _mm256_cvtepi32_ps(sums) }
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(clippy::undocumented_unsafe_blocks)]
impl Dot<Avx512> for Avx512 {
    type Sums = __m512i;
    type Weights = __m512i;
    type Bytes = __m512i;

    fn place(lane: usize, k: usize) -> usize {
        4 * lane + k
    }
    #[inline(always)]
    unsafe fn sums(from: *const i32) -> __m512i {
        unsafe { _mm512_loadu_si512(from.cast()) }
    }
    #[inline(always)]
    unsafe fn weights(from: *const i8) -> __m512i {
        unsafe { _mm512_loadu_si512(from.cast()) }
    }
    #[inline(always)]
    unsafe fn four(from: *const u8) -> __m512i {
        unsafe { _mm512_set1_epi32(from.cast::<i32>().read_unaligned()) }
    }
    #[inline(always)]
    unsafe fn dot<const F: u8>(sums: __m512i, four: __m512i, weights: __m512i) -> __m512i {
        unsafe { _mm512_dpbusd_epi32(sums, four, weights) }
    }
    #[inline(always)]
    unsafe fn floats(sums: __m512i) -> __m512 {
        unsafe { _mm512_cvtepi32_ps(sums) }
    }
}
