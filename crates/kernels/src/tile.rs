//! The one inner loop of convolution: a block of outputs held in registers.
//!
//! `c[m][n] (+)= Σ over segments s, Σ over k: a[s + m · a_row + k · a_step] · b[s' + k · b_row + n]`.
//! Forward, input gradient and weight gradient are this loop with other strides, on channels-last data
//! as they lie: nothing is copied into panels.

#[cfg(target_arch = "aarch64")]
use crate::simd::Neon;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512, Pairs};
use crate::simd::{Floats, Level, Portable, Product, Simd, level};
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
unsafe fn tile<S: Simd, P: Product<S>, const M: usize, const N: usize, const FROZEN: bool>(t: &Tile) {
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

/// A compiled block of `rows` × `vectors`.
pub(crate) type BlockKernel = unsafe fn(&Tile);

/// Kernels of one level: `[vectors - 1][rows - 1]`.
struct Kernels {
    lanes: usize,
    rows: [usize; 2],
    table: [&'static [BlockKernel]; 2],
    /// The same with an addend and a rectifier.
    frozen: [&'static [BlockKernel]; 2],
}

macro_rules! kernels {
    ($simd:ty, $vectors:literal, $frozen:literal, $attribute:meta, [$($rows:literal)*]) => {
        kernels!($simd, Floats, $vectors, $frozen, $attribute, [$($rows)*])
    };
    ($simd:ty, $product:ty, $vectors:literal, $frozen:literal, $attribute:meta, [$($rows:literal)*]) => {
        &[$({
            #[$attribute]
            unsafe fn kernel(t: &Tile) {
                // SAFETY: the caller of the kernel keeps the contract of `tile`.
                unsafe { tile::<$simd, $product, $rows, $vectors, $frozen>(t) }
            }
            kernel as BlockKernel
        }),*]
    };
}

static PORTABLE: Kernels = Kernels {
    lanes: Portable::LANES,
    rows: Portable::ROWS,
    table: [
        kernels!(Portable, 1, false, inline(never), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Portable, 2, false, inline(never), [1 2 3 4 5 6]),
    ],
    frozen: [
        kernels!(Portable, 1, true, inline(never), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Portable, 2, true, inline(never), [1 2 3 4 5 6]),
    ],
};

#[cfg(target_arch = "x86_64")]
static AVX2: Kernels = Kernels {
    lanes: Avx2::LANES,
    rows: Avx2::ROWS,
    table: [
        kernels!(Avx2, 1, false, target_feature(enable = "avx2,fma"), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Avx2, 2, false, target_feature(enable = "avx2,fma"), [1 2 3 4 5 6]),
    ],
    frozen: [
        kernels!(Avx2, 1, true, target_feature(enable = "avx2,fma"), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Avx2, 2, true, target_feature(enable = "avx2,fma"), [1 2 3 4 5 6]),
    ],
};

#[cfg(target_arch = "x86_64")]
static AVX512: Kernels = Kernels {
    lanes: Avx512::LANES,
    rows: Avx512::ROWS,
    table: [
        kernels!(Avx512, 1, false, target_feature(enable = "avx512f"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28]),
        kernels!(Avx512, 2, false, target_feature(enable = "avx512f"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14]),
    ],
    frozen: [
        kernels!(Avx512, 1, true, target_feature(enable = "avx512f"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28]),
        kernels!(Avx512, 2, true, target_feature(enable = "avx512f"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14]),
    ],
};

/// Products of pairs of bf16; networks for prediction have none.
#[cfg(target_arch = "x86_64")]
static PAIRS: Kernels = Kernels {
    lanes: Avx512::LANES,
    rows: Avx512::ROWS,
    table: [
        kernels!(Avx512, Pairs, 1, false, target_feature(enable = "avx512f,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28]),
        kernels!(Avx512, Pairs, 2, false, target_feature(enable = "avx512f,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14]),
    ],
    frozen: [&[], &[]],
};

#[cfg(target_arch = "aarch64")]
static NEON: Kernels = Kernels {
    lanes: Neon::LANES,
    rows: Neon::ROWS,
    table: [
        kernels!(Neon, 1, false, inline(never), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Neon, 2, false, inline(never), [1 2 3 4 5 6 7 8]),
    ],
    frozen: [
        kernels!(Neon, 1, true, inline(never), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Neon, 2, true, inline(never), [1 2 3 4 5 6 7 8]),
    ],
};

/// Returns the kernels of this CPU.
fn kernels() -> &'static Kernels {
    match level() {
        #[cfg(target_arch = "aarch64")]
        Level::Neon => &NEON,
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => &AVX2,
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => &AVX512,
        _ => &PORTABLE,
    }
}

/// Returns the kernels for what is left of a row that fills half a vector: as many products, twice as fast where a
/// wide vector counts as two narrow ones.
fn narrow() -> &'static Kernels {
    match level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => &AVX2,
        _ => kernels(),
    }
}

/// Neighbouring columns that one kernel computes.
#[derive(Clone, Copy)]
pub(crate) struct ColumnBlock {
    kernels: &'static Kernels,
    /// The first one.
    pub from: usize,
    vectors: usize,
    /// Columns in the last vector.
    pub last: usize,
}

impl ColumnBlock {
    /// Returns the number of columns.
    pub fn width(&self) -> usize {
        (self.vectors - 1) * self.kernels.lanes + self.last
    }

    /// Returns the most rows of a block.
    pub fn rows(&self) -> usize {
        self.kernels.rows[self.vectors - 1]
    }

    /// Returns the kernel for `rows` rows.
    pub fn kernel(&self, rows: usize) -> BlockKernel {
        self.kernels.table[self.vectors - 1][rows - 1]
    }

    /// Returns the same kernel with what frozen networks do to the outputs before they store them.
    pub fn frozen(&self, rows: usize) -> BlockKernel {
        self.kernels.frozen[self.vectors - 1][rows - 1]
    }
}

/// Cuts `width` columns into those of single kernels.
pub(crate) fn columns(width: usize) -> impl Iterator<Item = ColumnBlock> {
    cut(width, kernels(), narrow())
}

/// Cuts `width` columns as [`columns`] does, or as [`pair_columns`].
pub(crate) fn columns_of(width: usize, paired: bool) -> impl Iterator<Item = ColumnBlock> {
    let (floats, pairs) = if paired { (0, width) } else { (width, 0) };
    columns(floats).chain((pairs > 0).then(|| pair_columns(pairs)).into_iter().flatten())
}

/// Cuts `width` columns of products of pairs of bf16; panics where the CPU has no such products.
pub(crate) fn pair_columns(width: usize) -> impl Iterator<Item = ColumnBlock> {
    crate::half::assert_supported();
    #[cfg(target_arch = "x86_64")]
    let kernels = &PAIRS;
    #[cfg(not(target_arch = "x86_64"))]
    let kernels = kernels();
    cut(width, kernels, kernels)
}

fn cut(width: usize, wide: &'static Kernels, narrow: &'static Kernels) -> impl Iterator<Item = ColumnBlock> {
    let mut from = 0;
    std::iter::from_fn(move || {
        let left = width - from;
        let (kernels, vectors) = if left <= narrow.lanes {
            (narrow, 1)
        } else if left <= wide.lanes + narrow.lanes && narrow.lanes < wide.lanes || left <= wide.lanes {
            (wide, 1)
        } else {
            (wide, 2)
        };
        let taken = left.min(vectors * kernels.lanes);
        let last = taken - (vectors - 1) * kernels.lanes.min(taken);
        let columns = ColumnBlock { kernels, from, vectors, last };
        from += taken;
        (taken > 0).then_some(columns)
    })
}

/// Returns the most rows that a block of two vectors holds.
pub(crate) fn wide_rows() -> usize {
    kernels().rows[1]
}

/// Returns the rows of the largest block, at most `most`, that cuts `rows` into equal pieces (give or take one).
pub(crate) fn even(rows: usize, most: usize) -> usize {
    rows.div_ceil(rows.div_ceil(most).max(1)).max(1)
}
