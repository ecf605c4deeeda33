//! Products of four bytes with four weights, added to 32-bit sums, in three widths.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Level, Portable, Simd, level};

/// How wide sums of products are computed; all give the same sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// Four sums, any CPU.
    Portable,
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
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (level(), Level::Portable);
        all
    }

    /// Returns the widest width of this CPU.
    pub fn widest() -> Width {
        Width::all().pop().unwrap_or(Width::Portable)
    }
}

/// Sums of one width.
///
/// # Safety
/// As [`Simd`]; of AVX-512 the CPU has BW and VNNI too.
pub(super) trait Dot: Simd {
    /// LANES sums.
    type Sums: Copy;
    /// Four weights of each lane.
    type Weights: Copy;
    /// Four bytes, the same for all lanes.
    type Four: Copy;

    /// Returns where weight `k` of `lane` lies among the 4 · LANES of all.
    fn place(lane: usize, k: usize) -> usize;
    unsafe fn sums(from: *const i32) -> Self::Sums;
    unsafe fn weights(from: *const i8) -> Self::Weights;
    unsafe fn four(from: *const u8) -> Self::Four;
    /// Returns `sums + four · weights` per lane.
    unsafe fn dot(sums: Self::Sums, four: Self::Four, weights: Self::Weights) -> Self::Sums;
    /// Returns the nearest floats.
    unsafe fn floats(sums: Self::Sums) -> Self::V;
}

#[allow(clippy::needless_range_loop)]
impl Dot for Portable {
    type Sums = [i32; 4];
    type Weights = [i8; 16];
    type Four = [u8; 4];

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
    unsafe fn dot(mut sums: [i32; 4], four: [u8; 4], weights: [i8; 16]) -> [i32; 4] {
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
impl Dot for Avx2 {
    type Sums = __m256i;
    /// The first and the last two of each lane.
    type Weights = [__m256i; 2];
    type Four = [__m256i; 2];

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
    unsafe fn dot(sums: __m256i, four: [__m256i; 2], weights: [__m256i; 2]) -> __m256i {
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
impl Dot for Avx512 {
    type Sums = __m512i;
    type Weights = __m512i;
    type Four = __m512i;

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
    unsafe fn dot(sums: __m512i, four: __m512i, weights: __m512i) -> __m512i {
        unsafe { _mm512_dpbusd_epi32(sums, four, weights) }
    }
    #[inline(always)]
    unsafe fn floats(sums: __m512i) -> __m512 {
        unsafe { _mm512_cvtepi32_ps(sums) }
    }
}
