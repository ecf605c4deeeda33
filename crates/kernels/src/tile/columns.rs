//! Blocks of the inner loop for every number of rows and vectors, and how columns are cut into them.

#[cfg(target_arch = "aarch64")]
use crate::simd::Neon;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512, Pairs};
use crate::simd::{Floats, Level, Portable, Simd, level};

use super::block::{Tile, tile};

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

/// Products of pairs of bf16.
#[cfg(target_arch = "x86_64")]
static PAIRS: Kernels = Kernels {
    lanes: Avx512::LANES,
    rows: Avx512::ROWS,
    table: [
        kernels!(Avx512, Pairs, 1, false, target_feature(enable = "avx512f,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28]),
        kernels!(Avx512, Pairs, 2, false, target_feature(enable = "avx512f,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14]),
    ],
    frozen: [
        kernels!(Avx512, Pairs, 1, true, target_feature(enable = "avx512f,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28]),
        kernels!(Avx512, Pairs, 2, true, target_feature(enable = "avx512f,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14]),
    ],
};

/// The same for what is left of a row that fills half a vector; such blocks have one vector.
#[cfg(target_arch = "x86_64")]
static NARROW_PAIRS: Kernels = Kernels {
    lanes: Avx2::LANES,
    rows: Avx2::ROWS,
    table: [
        kernels!(Avx2, Pairs, 1, false, target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12]),
        &[],
    ],
    frozen: [
        kernels!(Avx2, Pairs, 1, true, target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512bf16"), [1 2 3 4 5 6 7 8 9 10 11 12]),
        &[],
    ],
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
    columns_of(width, false)
}

/// Cuts `width` columns of products of pairs of bf16; panics where the CPU has no such products.
pub(crate) fn pair_columns(width: usize) -> impl Iterator<Item = ColumnBlock> {
    columns_of(width, true)
}

/// Cuts `width` columns as [`columns`] does, or as [`pair_columns`].
pub(crate) fn columns_of(width: usize, paired: bool) -> impl Iterator<Item = ColumnBlock> {
    let (wide, narrow) = if paired { pair_kernels() } else { (kernels(), narrow()) };
    cut(width, wide, narrow)
}

/// Returns the kernels of pairs of bf16, wide and narrow.
fn pair_kernels() -> (&'static Kernels, &'static Kernels) {
    crate::half::assert_supported();
    #[cfg(target_arch = "x86_64")]
    {
        (&PAIRS, &NARROW_PAIRS)
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        (kernels(), narrow())
    }
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
