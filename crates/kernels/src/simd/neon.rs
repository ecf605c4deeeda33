//! Vectors of NEON, which every 64-bit Arm processor has, with fused multiply–add.

use std::arch::aarch64::*;

use super::vector::Simd;

/// Four floats.
#[derive(Clone, Copy)]
pub(crate) struct Neon;

// SAFETY of all blocks below: the trait's contract. Each function is some instructions of NEON, which belongs to the
// architecture; loads and stores need no alignment.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Simd for Neon {
    type V = float32x4_t;
    const LANES: usize = 4;
    // Of 32 registers, one per row holds four inputs.
    const ROWS: [usize; 2] = [12, 8];
    const BY_LANE: bool = true;

    #[inline(always)]
    unsafe fn splat(value: f32) -> float32x4_t {
        unsafe { vdupq_n_f32(value) }
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> float32x4_t {
        unsafe { vld1q_f32(from) }
    }
    #[inline(always)]
    unsafe fn load_first(from: *const f32, n: usize) -> float32x4_t {
        unsafe {
            let none = vdupq_n_f32(0.0);
            match n {
                1 => vld1q_lane_f32::<0>(from, none),
                2 => vcombine_f32(vld1_f32(from), vget_low_f32(none)),
                3 => vld1q_lane_f32::<2>(from.add(2), vcombine_f32(vld1_f32(from), vget_low_f32(none))),
                _ => vld1q_f32(from),
            }
        }
    }
    #[inline(always)]
    unsafe fn store(to: *mut f32, v: float32x4_t) {
        unsafe { vst1q_f32(to, v) }
    }
    #[inline(always)]
    unsafe fn store_first(to: *mut f32, v: float32x4_t, n: usize) {
        unsafe {
            match n {
                1 => vst1q_lane_f32::<0>(to, v),
                2 => vst1_f32(to, vget_low_f32(v)),
                3 => {
                    vst1_f32(to, vget_low_f32(v));
                    vst1q_lane_f32::<2>(to.add(2), v);
                }
                _ => vst1q_f32(to, v),
            }
        }
    }
    #[inline(always)]
    unsafe fn fma(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
        unsafe { vfmaq_f32(c, a, b) }
    }
    #[inline(always)]
    unsafe fn fma_lane<const LANE: i32>(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
        unsafe { vfmaq_laneq_f32::<LANE>(c, b, a) }
    }
    #[inline(always)]
    unsafe fn add(a: float32x4_t, b: float32x4_t) -> float32x4_t {
        unsafe { vaddq_f32(a, b) }
    }
    #[inline(always)]
    unsafe fn sub(a: float32x4_t, b: float32x4_t) -> float32x4_t {
        unsafe { vsubq_f32(a, b) }
    }
    #[inline(always)]
    unsafe fn mul(a: float32x4_t, b: float32x4_t) -> float32x4_t {
        unsafe { vmulq_f32(a, b) }
    }
    #[inline(always)]
    unsafe fn div(a: float32x4_t, b: float32x4_t) -> float32x4_t {
        unsafe { vdivq_f32(a, b) }
    }
    #[inline(always)]
    unsafe fn power_of_two(x: float32x4_t) -> float32x4_t {
        unsafe {
            let exponent = vshlq_n_s32::<23>(vreinterpretq_s32_f32(x));
            let one = vreinterpretq_s32_f32(vdupq_n_f32(1.0));
            vreinterpretq_f32_s32(vaddq_s32(exponent, one))
        }
    }
    #[inline(always)]
    unsafe fn zero_unless_positive(x: float32x4_t, value: float32x4_t) -> float32x4_t {
        // Comparisons with NaN are false.
        unsafe { cleared(value, vcleq_f32(x, vdupq_n_f32(0.0))) }
    }
    #[inline(always)]
    unsafe fn zero_from(x: float32x4_t, limit: float32x4_t, value: float32x4_t) -> float32x4_t {
        unsafe { cleared(value, vcgeq_f32(x, limit)) }
    }
    #[inline(always)]
    unsafe fn at_most(x: float32x4_t, limit: float32x4_t) -> float32x4_t {
        unsafe { vbslq_f32(vcgeq_f32(x, limit), limit, x) }
    }
    #[inline(always)]
    unsafe fn where_beats(
        x: float32x4_t,
        best: float32x4_t,
        yes: float32x4_t,
        no: float32x4_t,
    ) -> float32x4_t {
        unsafe {
            let nan = vmvnq_u32(vceqq_f32(x, x));
            vbslq_f32(vorrq_u32(vcgtq_f32(x, best), nan), yes, no)
        }
    }
    #[inline(always)]
    unsafe fn count_above(count: float32x4_t, x: float32x4_t, limit: float32x4_t) -> float32x4_t {
        unsafe { vaddq_f32(count, kept(vdupq_n_f32(1.0), vcgtq_f32(x, limit))) }
    }
    #[inline(always)]
    unsafe fn where_equal(a: float32x4_t, b: float32x4_t, yes: float32x4_t) -> float32x4_t {
        unsafe { kept(yes, vceqq_f32(a, b)) }
    }
    #[inline(always)]
    unsafe fn clamp(x: float32x4_t, low: float32x4_t, high: float32x4_t) -> float32x4_t {
        unsafe {
            let x = vbslq_f32(vcgtq_f32(x, low), x, low);
            vbslq_f32(vcltq_f32(x, high), x, high)
        }
    }
    #[inline(always)]
    unsafe fn load_bytes(from: *const u8, n: usize) -> float32x4_t {
        unsafe {
            let bytes = if n == 4 {
                from.cast::<u32>().read_unaligned()
            } else {
                let mut few = [0u8; 4];
                from.copy_to_nonoverlapping(few.as_mut_ptr(), n);
                u32::from_le_bytes(few)
            };
            let words = vmovl_u8(vreinterpret_u8_u32(vdup_n_u32(bytes)));
            vcvtq_f32_u32(vmovl_u16(vget_low_u16(words)))
        }
    }
    #[inline(always)]
    unsafe fn store_bytes(to: *mut u8, v: float32x4_t, n: usize) {
        unsafe {
            let words = vqmovn_u32(vcvtnq_u32_f32(v));
            let bytes = vqmovn_u16(vcombine_u16(words, words));
            let bytes = vget_lane_u32::<0>(vreinterpret_u32_u8(bytes));
            if n == 4 {
                return to.cast::<u32>().write_unaligned(bytes);
            }
            let few = bytes.to_le_bytes();
            few.as_ptr().copy_to_nonoverlapping(to, n);
        }
    }
}

/// Returns `value` where `mask` is set, 0 elsewhere.
#[inline(always)]
fn kept(value: float32x4_t, mask: uint32x4_t) -> float32x4_t {
    // SAFETY: NEON belongs to the architecture.
    unsafe { vreinterpretq_f32_u32(vandq_u32(vreinterpretq_u32_f32(value), mask)) }
}

/// Returns 0 where `mask` is set, `value` elsewhere.
#[inline(always)]
fn cleared(value: float32x4_t, mask: uint32x4_t) -> float32x4_t {
    // SAFETY: NEON belongs to the architecture.
    unsafe { vreinterpretq_f32_u32(vbicq_u32(vreinterpretq_u32_f32(value), mask)) }
}
