//! Vectors for any CPU.

use super::vector::Simd;

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
    unsafe fn count_above(count: [f32; 4], x: [f32; 4], limit: [f32; 4]) -> [f32; 4] {
        lanes!(i => if x[i] > limit[i] { count[i] + 1.0 } else { count[i] })
    }
    #[inline(always)]
    unsafe fn where_equal(a: [f32; 4], b: [f32; 4], yes: [f32; 4]) -> [f32; 4] {
        lanes!(i => if a[i] == b[i] { yes[i] } else { 0.0 })
    }
    #[inline(always)]
    unsafe fn clamp(x: [f32; 4], low: [f32; 4], high: [f32; 4]) -> [f32; 4] {
        lanes!(i => {
            let x = if x[i] > low[i] { x[i] } else { low[i] };
            if x < high[i] { x } else { high[i] }
        })
    }
    #[inline(always)]
    unsafe fn load_bytes(from: *const u8, n: usize) -> [f32; 4] {
        let mut v = [0.0; 4];
        for i in 0..n.min(4) {
            // SAFETY: the caller guarantees `n` readable bytes.
            v[i] = f32::from(unsafe { *from.add(i) });
        }
        v
    }
    #[inline(always)]
    unsafe fn store_bytes(to: *mut u8, v: [f32; 4], n: usize) {
        for i in 0..n.min(4) {
            // SAFETY: the caller guarantees `n` writable bytes.
            unsafe { *to.add(i) = v[i].round_ties_even() as u8 };
        }
    }
}
