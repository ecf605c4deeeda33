//! The vector operations that kernels are written over.

/// Lanes of the widest vector.
pub(crate) const WIDEST: usize = 16;

/// Vector operations of one width.
///
/// # Safety
/// Every function may only be called where the CPU has the features of its implementation; pointers
/// must be valid for all lanes, or for the first `n` where a function takes `n`. No alignment is needed.
pub(crate) trait Simd: Copy {
    type V: Copy;
    const LANES: usize;
    /// Accumulator rows of a tile that is one and two vectors wide, so that all fit in registers.
    const ROWS: [usize; 2];
    /// Whether `fma_lane` costs no more than `fma`, so that neighbouring factors are best loaded together.
    const BY_LANE: bool = false;

    unsafe fn splat(value: f32) -> Self::V;
    unsafe fn load(from: *const f32) -> Self::V;
    /// Loads the first `n` lanes, 1..=LANES; the others are zero.
    unsafe fn load_first(from: *const f32, n: usize) -> Self::V;
    unsafe fn store(to: *mut f32, v: Self::V);
    unsafe fn store_first(to: *mut f32, v: Self::V, n: usize);
    /// Returns `a · b + c`.
    unsafe fn fma(a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// Returns `a[LANE] · b + c`; `LANE` is 0 to 3.
    #[inline(always)]
    unsafe fn fma_lane<const LANE: i32>(a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        // SAFETY: the caller's contract.
        unsafe {
            let mut lanes = [0.0; WIDEST];
            Self::store(lanes.as_mut_ptr(), a);
            Self::fma(Self::splat(lanes[LANE as usize]), b, c)
        }
    }
    unsafe fn add(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn sub(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn mul(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn div(a: Self::V, b: Self::V) -> Self::V;
    /// Returns 2 to the power of the integer in the low bits of `x`, which must give a normal number.
    unsafe fn power_of_two(x: Self::V) -> Self::V;
    /// Returns `if x <= 0 { 0 } else { value }` per lane: NaN in `x` lets `value` pass.
    unsafe fn zero_unless_positive(x: Self::V, value: Self::V) -> Self::V;
    /// Returns `if x >= limit { 0 } else { value }` per lane: NaN in `x` lets `value` pass.
    unsafe fn zero_from(x: Self::V, limit: Self::V, value: Self::V) -> Self::V;
    /// Returns `if x >= limit { limit } else { x }` per lane: NaN in `x` stays.
    unsafe fn at_most(x: Self::V, limit: Self::V) -> Self::V;
    /// Returns `if x > best or x is NaN { yes } else { no }` per lane.
    unsafe fn where_beats(x: Self::V, best: Self::V, yes: Self::V, no: Self::V) -> Self::V;
    /// Returns `if x > limit { count + 1 } else { count }` per lane.
    unsafe fn count_above(count: Self::V, x: Self::V, limit: Self::V) -> Self::V;
    /// Returns `if a == b { yes } else { 0 }` per lane.
    unsafe fn where_equal(a: Self::V, b: Self::V, yes: Self::V) -> Self::V;
    /// Returns `if x > low { min(x, high) } else { low }` per lane: NaN becomes `low`.
    unsafe fn clamp(x: Self::V, low: Self::V, high: Self::V) -> Self::V;
    /// Loads the first `n` bytes, 1..=LANES, as numbers; the other lanes are zero.
    unsafe fn load_bytes(from: *const u8, n: usize) -> Self::V;
    /// Stores the first `n` lanes, 1..=LANES, which lie between 0 and 255, rounded to the nearest (even) number.
    unsafe fn store_bytes(to: *mut u8, v: Self::V, n: usize);
}
