//! Products of bytes with weights on 64-bit Arm: by `sdot`, and by 16-bit numbers where the CPU lacks it.

use std::arch::aarch64::*;
use std::arch::asm;

use crate::simd::Neon;

use super::dot::Dot;

/// Makes bytes signed, which `sdot` multiplies.
const TAKEN: u8 = 128;

/// NEON with `sdot`.
pub(super) struct DotProduct;

// SAFETY of all blocks below: the trait's contract. Each function is some instructions that the caller has checked;
// loads need no alignment.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Dot<Neon> for Neon {
    const FOURS: usize = 2;
    type Sums = int32x4_t;
    /// The first and the last two of each lane.
    type Weights = [int16x8_t; 2];
    type Bytes = int16x8_t;

    fn place(lane: usize, k: usize) -> usize {
        4 * k + lane
    }
    #[inline(always)]
    unsafe fn sums(from: *const i32) -> int32x4_t {
        unsafe { vld1q_s32(from) }
    }
    #[inline(always)]
    unsafe fn weights(from: *const i8) -> [int16x8_t; 2] {
        unsafe {
            let bytes = vld1q_s8(from);
            [vmovl_s8(vget_low_s8(bytes)), vmovl_high_s8(bytes)]
        }
    }
    #[inline(always)]
    unsafe fn four(from: *const u8) -> int16x8_t {
        unsafe {
            let four = vdup_n_u32(from.cast::<u32>().read_unaligned());
            vreinterpretq_s16_u16(vmovl_u8(vreinterpret_u8_u32(four)))
        }
    }
    #[inline(always)]
    unsafe fn fours(from: *const u8) -> int16x8_t {
        unsafe { vreinterpretq_s16_u16(vmovl_u8(vld1_u8(from))) }
    }
    #[inline(always)]
    unsafe fn dot<const F: u8>(sums: int32x4_t, bytes: int16x8_t, weights: [int16x8_t; 2]) -> int32x4_t {
        unsafe {
            let [first, last] = [vget_low_s16(weights[0]), vget_low_s16(weights[1])];
            if F == 0 {
                let sums = vmlal_laneq_s16::<0>(sums, first, bytes);
                let sums = vmlal_high_laneq_s16::<1>(sums, weights[0], bytes);
                let sums = vmlal_laneq_s16::<2>(sums, last, bytes);
                vmlal_high_laneq_s16::<3>(sums, weights[1], bytes)
            } else {
                let sums = vmlal_laneq_s16::<4>(sums, first, bytes);
                let sums = vmlal_high_laneq_s16::<5>(sums, weights[0], bytes);
                let sums = vmlal_laneq_s16::<6>(sums, last, bytes);
                vmlal_high_laneq_s16::<7>(sums, weights[1], bytes)
            }
        }
    }
    #[inline(always)]
    unsafe fn floats(sums: int32x4_t) -> float32x4_t {
        unsafe { vcvtq_f32_s32(sums) }
    }
}

#[allow(clippy::undocumented_unsafe_blocks)]
impl Dot<Neon> for DotProduct {
    const FOURS: usize = 4;
    const TAKEN: u8 = TAKEN;
    type Sums = int32x4_t;
    type Weights = int8x16_t;
    type Bytes = uint8x16_t;

    fn place(lane: usize, k: usize) -> usize {
        4 * lane + k
    }
    #[inline(always)]
    unsafe fn sums(from: *const i32) -> int32x4_t {
        unsafe { vld1q_s32(from) }
    }
    #[inline(always)]
    unsafe fn weights(from: *const i8) -> int8x16_t {
        unsafe { vld1q_s8(from) }
    }
    #[inline(always)]
    unsafe fn four(from: *const u8) -> uint8x16_t {
        unsafe {
            let four = vdupq_n_u32(from.cast::<u32>().read_unaligned());
            veorq_u8(vreinterpretq_u8_u32(four), vdupq_n_u8(TAKEN))
        }
    }
    #[inline(always)]
    unsafe fn fours(from: *const u8) -> uint8x16_t {
        unsafe { veorq_u8(vld1q_u8(from), vdupq_n_u8(TAKEN)) }
    }
    #[inline(always)]
    unsafe fn dot<const F: u8>(mut sums: int32x4_t, bytes: uint8x16_t, weights: int8x16_t) -> int32x4_t {
        // The intrinsic is not stable yet.
        unsafe {
            asm!(
                "sdot {sums:v}.4s, {weights:v}.16b, {bytes:v}.4b[{f}]",
                sums = inout(vreg) sums,
                weights = in(vreg) weights,
                bytes = in(vreg) bytes,
                f = const F,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        sums
    }
    #[inline(always)]
    unsafe fn floats(sums: int32x4_t) -> float32x4_t {
        unsafe { vcvtq_f32_s32(sums) }
    }
}
