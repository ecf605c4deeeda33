//! One block of outputs.

use crate::simd::{Product, Simd};
use crate::view::Rectifier;

/// The start of the accumulators.
#[derive(Clone, Copy)]
pub(crate) enum Start {
    Zero,
    /// The values already in `c`.
    Add,
    /// One value per column, from this address.
    Bias(*const f32),
}

/// One block of outputs: addresses and strides, in floats.
pub(crate) struct Tile<'a> {
    pub a: *const f32,
    pub a_row: usize,
    pub a_step: usize,
    pub b: *const f32,
    pub b_row: usize,
    pub c: *mut f32,
    pub c_row: usize,
    /// Offsets into `a` and `b` where a stretch of `run` products begins.
    pub segments: &'a [(usize, usize)],
    pub run: usize,
    pub start: Start,
    /// Columns in the last vector, 1..=LANES.
    pub last: usize,
    /// The addend of a frozen kernel's outputs: an address, and the distance of its rows.
    pub addend: Option<(*const f32, usize)>,
    /// The rectifier of a frozen kernel's outputs.
    pub rectifier: Rectifier,
}

/// Computes a block of outputs, `M` rows of `N` vectors. `FROZEN` ones get the addend and the rectifier of `t`, too.
///
/// # Safety
/// The CPU has the features of `S` and `P`; all addresses that the strides of `t` form for `M` rows and
/// `N` vectors (the last of `t.last` lanes) are valid, and `c` overlaps neither `a` nor `b`.
#[inline(always)]
pub(super) unsafe fn tile<S: Simd, P: Product<S>, const M: usize, const N: usize, const FROZEN: bool>(
    t: &Tile,
) {
    // SAFETY: the caller's contract; every access below is one of those addresses.
    unsafe {
        let full = t.last == S::LANES;
        macro_rules! load {
            ($at:expr, $n:expr) => {{
                let at = $at.add($n * S::LANES);
                if $n + 1 < N || full { S::load(at) } else { S::load_first(at, t.last) }
            }};
        }
        let mut acc = [[S::splat(0.0); N]; M];
        match t.start {
            Start::Zero => {}
            Start::Add => {
                for (m, row) in acc.iter_mut().enumerate() {
                    for (n, v) in row.iter_mut().enumerate() {
                        *v = load!(t.c.add(m * t.c_row).cast_const(), n);
                    }
                }
            }
            Start::Bias(bias) => {
                for row in &mut acc {
                    for (n, v) in row.iter_mut().enumerate() {
                        *v = load!(bias, n);
                    }
                }
            }
        }
        if full {
            products::<S, P, M, N, true>(t, &mut acc);
        } else {
            products::<S, P, M, N, false>(t, &mut acc);
        }
        // Short loops of their own: the accumulators stay in registers only where every loop over them unrolls.
        if FROZEN {
            if let Some((addend, distance)) = t.addend {
                for (m, row) in acc.iter_mut().enumerate() {
                    for (n, v) in row.iter_mut().enumerate() {
                        *v = S::add(*v, load!(addend.add(m * distance), n));
                    }
                }
            }
            if t.rectifier != Rectifier::None {
                for row in &mut acc {
                    for v in row {
                        *v = S::zero_unless_positive(*v, *v);
                    }
                }
            }
            if t.rectifier == Rectifier::Relu6 {
                for row in &mut acc {
                    for v in row {
                        *v = S::at_most(*v, S::splat(6.0));
                    }
                }
            }
        }
        for (m, row) in acc.iter().enumerate() {
            for (n, &v) in row.iter().enumerate() {
                let to = t.c.add(m * t.c_row + n * S::LANES);
                if n + 1 < N || full { S::store(to, v) } else { S::store_first(to, v, t.last) }
            }
        }
    }
}

/// Adds the products of all segments to `acc`; with `FULL` the last vector is whole.
///
/// # Safety
/// As [`tile`].
#[inline(always)]
unsafe fn products<S: Simd, P: Product<S>, const M: usize, const N: usize, const FULL: bool>(
    t: &Tile,
    acc: &mut [[S::V; N]; M],
) {
    // SAFETY: as in `tile`.
    unsafe {
        for &(from_a, from_b) in t.segments {
            let mut a = t.a.add(from_a);
            let mut b = t.b.add(from_b);
            let mut left = t.run;
            if P::BY_LANE && t.a_step == 1 {
                while left >= 4 {
                    let mut x = [S::splat(0.0); M];
                    for (m, x) in x.iter_mut().enumerate() {
                        *x = S::load(a.add(m * t.a_row));
                    }
                    product_of_lane::<S, M, N, FULL, 0>(t, &x, b, acc);
                    product_of_lane::<S, M, N, FULL, 1>(t, &x, b.wrapping_add(t.b_row), acc);
                    product_of_lane::<S, M, N, FULL, 2>(t, &x, b.wrapping_add(2 * t.b_row), acc);
                    product_of_lane::<S, M, N, FULL, 3>(t, &x, b.wrapping_add(3 * t.b_row), acc);
                    a = a.wrapping_add(4);
                    b = b.wrapping_add(4 * t.b_row);
                    left -= 4;
                }
            }
            for _ in 0..left {
                let bv = vectors::<S, N, FULL>(t, b);
                for (m, row) in acc.iter_mut().enumerate() {
                    let x = S::splat(*a.add(m * t.a_row));
                    for (v, &b) in row.iter_mut().zip(&bv) {
                        *v = P::add(x, b, *v);
                    }
                }
                a = a.wrapping_add(t.a_step);
                b = b.wrapping_add(t.b_row);
            }
        }
    }
}

/// Adds the products of one lane of each row's `x` to `acc`.
///
/// # Safety
/// As [`tile`]; `b` is one of its addresses.
#[inline(always)]
unsafe fn product_of_lane<S: Simd, const M: usize, const N: usize, const FULL: bool, const LANE: i32>(
    t: &Tile,
    x: &[S::V; M],
    b: *const f32,
    acc: &mut [[S::V; N]; M],
) {
    // SAFETY: as in `tile`.
    unsafe {
        let bv = vectors::<S, N, FULL>(t, b);
        for (row, &x) in acc.iter_mut().zip(x) {
            for (v, &b) in row.iter_mut().zip(&bv) {
                *v = S::fma_lane::<LANE>(x, b, *v);
            }
        }
    }
}

/// Loads a row of `b`; with `FULL` its last vector is whole.
///
/// # Safety
/// As [`tile`]; `b` is one of its addresses.
#[inline(always)]
unsafe fn vectors<S: Simd, const N: usize, const FULL: bool>(t: &Tile, b: *const f32) -> [S::V; N] {
    // SAFETY: as in `tile`.
    unsafe {
        let mut row = [S::splat(0.0); N];
        for (n, v) in row.iter_mut().enumerate() {
            let at = b.add(n * S::LANES);
            *v = if FULL || n + 1 < N { S::load(at) } else { S::load_first(at, t.last) };
        }
        row
    }
}
