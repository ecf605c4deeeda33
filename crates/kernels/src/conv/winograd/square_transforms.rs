//! The transforms of F(2×2, 3×3), vector by vector along channels.

use crate::conv::begin::Begin;
use crate::lengths::{at_least, exactly};
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};

use super::grid::{TILE, TileGrid, TileRun};

/// Returns `Bᵀ d` of one column.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn spread<S: Simd>(d: [S::V; 4]) -> [S::V; 4] {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe { [S::sub(d[0], d[2]), S::add(d[1], d[2]), S::sub(d[2], d[1]), S::sub(d[1], d[3])] }
}

/// Returns `Aᵀ m` of one column.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn gather<S: Simd>(m: [S::V; 4]) -> [S::V; 2] {
    // SAFETY: the caller has the features; no memory is touched.
    unsafe { [S::add(S::add(m[0], m[1]), m[2]), S::sub(S::sub(m[1], m[2]), m[3])] }
}

at_level! {
    /// Computes `v = Bᵀ d B` of a block of tiles, from the padded input `x`.
    pub(crate) fn spread_input(
        grid: &TileGrid, width: usize, first: usize, count: usize, x: &[f32], v: &mut [f32],
    ) = spread_input_at
}

/// Computes [`spread_input`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn spread_input_at<S: Simd>(
    grid: &TileGrid,
    width: usize,
    first: usize,
    count: usize,
    x: &[f32],
    v: &mut [f32],
) {
    at_least("padded input of a convolution", x.len(), grid.halo_len() * width);
    at_least("a transformed block", v.len(), TILE * grid.plane(width));
    let (line, plane) = (grid.halo()[1] * width, grid.plane(width));
    for TileRun { row, column, count, number } in grid.runs(first, count) {
        let x = &x[2 * row * line + 2 * column * width..];
        let v = &mut v[number * width..];
        vectors!(S, width, c, n, {
            // SAFETY: `c + n <= width`. A run's tiles end inside the image's and inside a block's, as `runs`
            // asserts; every 4×4 values of theirs lie inside the padded image, whose length in `x` is asserted,
            // and their 16 elements inside the planes, whose length in `v` is.
            unsafe {
                macro_rules! position_column {
                    ($column:expr) => {{
                        let at = $column * width + c;
                        spread::<S>([
                            load::<S>(x, at, n),
                            load::<S>(x, at + line, n),
                            load::<S>(x, at + 2 * line, n),
                            load::<S>(x, at + 3 * line, n),
                        ])
                    }};
                }
                // Neighbouring tiles share two columns.
                let (mut a, mut b) = (position_column!(0), position_column!(1));
                for tile in 0..count {
                    let (d, e) = (position_column!(2 * tile + 2), position_column!(2 * tile + 3));
                    for i in 0..4 {
                        let spread = spread::<S>([a[i], b[i], d[i], e[i]]);
                        for (j, value) in spread.into_iter().enumerate() {
                            store::<S>(v, (4 * i + j) * plane + tile * width + c, n, value);
                        }
                    }
                    (a, b) = (d, e);
                }
            }
        });
    }
}

at_level! {
    /// Computes `w = A dy Aᵀ` of a block of tiles; outputs beyond the edge count as zero.
    pub(crate) fn spread_gradient(
        grid: &TileGrid, width: usize, first: usize, count: usize, dy: &[f32], to: &mut [f32],
    ) = spread_gradient_at
}

/// Computes [`spread_gradient`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn spread_gradient_at<S: Simd>(
    grid: &TileGrid,
    width: usize,
    first: usize,
    count: usize,
    dy: &[f32],
    to: &mut [f32],
) {
    at_least("dy of a convolution", dy.len(), grid.output_len() * width);
    at_least("a transformed block", to.len(), TILE * grid.plane(width));
    let ([rows, columns], plane) = (grid.output, grid.plane(width));
    for TileRun { row, column, count, number } in grid.runs(first, count) {
        let dy = &dy[(2 * row * columns + 2 * column) * width..];
        let to = &mut to[number * width..];
        let below = 2 * row + 1 < rows;
        vectors!(S, width, c, n, {
            // SAFETY: `c + n <= width`. A run's tiles end inside the image's and inside a block's, as `runs`
            // asserts. Their outputs lie inside `dy`, whose length is asserted: those beyond the edge are not
            // read. Their elements lie inside the planes, whose length in `to` is asserted.
            unsafe {
                let zero = S::splat(0.0);
                for tile in 0..count {
                    let at = 2 * tile * width + c;
                    let right = 2 * (column + tile) + 1 < columns;
                    let p = load::<S>(dy, at, n);
                    let q = if right { load::<S>(dy, at + width, n) } else { zero };
                    let r = if below { load::<S>(dy, at + columns * width, n) } else { zero };
                    let s = if right && below { load::<S>(dy, at + (columns + 1) * width, n) } else { zero };
                    let left = [p, S::add(p, r), S::sub(p, r), S::sub(zero, r)];
                    let right = [q, S::add(q, s), S::sub(q, s), S::sub(zero, s)];
                    for i in 0..4 {
                        let (p, q) = (left[i], right[i]);
                        let spread = [p, S::add(p, q), S::sub(p, q), S::sub(zero, q)];
                        for (j, value) in spread.into_iter().enumerate() {
                            store::<S>(to, (4 * i + j) * plane + tile * width + c, n, value);
                        }
                    }
                }
            }
        });
    }
}

at_level! {
    /// Computes `y = Aᵀ m A` of a block of tiles.
    pub(crate) fn gather_output(
        grid: &TileGrid, width: usize, first: usize, count: usize, m: &[f32], begin: Begin, y: &mut [f32],
    ) = gather_output_at
}

/// Computes [`gather_output`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
unsafe fn gather_output_at<S: Simd>(
    grid: &TileGrid,
    width: usize,
    first: usize,
    count: usize,
    m: &[f32],
    begin: Begin,
    y: &mut [f32],
) {
    at_least("a transformed block", m.len(), TILE * grid.plane(width));
    at_least("output of a convolution", y.len(), grid.output_len() * width);
    if let Begin::Bias(bias) = begin {
        exactly("bias of a convolution", bias.len(), width);
    }
    let ([rows, columns], plane) = (grid.output, grid.plane(width));
    for TileRun { row, column, count, number } in grid.runs(first, count) {
        let y = &mut y[(2 * row * columns + 2 * column) * width..];
        let m = &m[number * width..];
        let below = 2 * row + 1 < rows;
        vectors!(S, width, c, n, {
            // SAFETY: `c + n <= width`, the asserted length of a bias. A run's tiles end inside the image's and
            // inside a block's, as `runs` asserts. Their elements lie inside the planes, whose length in `m` is
            // asserted, their outputs inside `y`, whose length is: those beyond the edge are neither read nor
            // written.
            unsafe {
                let bias = if let Begin::Bias(bias) = begin { load::<S>(bias, c, n) } else { S::splat(0.0) };
                for tile in 0..count {
                    let right = 2 * (column + tile) + 1 < columns;
                    let mut halves = [[S::splat(0.0); 4]; 2];
                    for j in 0..4 {
                        let at = j * plane + tile * width + c;
                        let [upper, lower] = gather::<S>([
                            load::<S>(m, at, n),
                            load::<S>(m, at + 4 * plane, n),
                            load::<S>(m, at + 8 * plane, n),
                            load::<S>(m, at + 12 * plane, n),
                        ]);
                        halves[0][j] = upper;
                        halves[1][j] = lower;
                    }
                    for (i, half) in halves.into_iter().enumerate() {
                        let [p, q] = gather::<S>(half);
                        let at = i * columns * width + 2 * tile * width + c;
                        macro_rules! put {
                            ($at:expr, $value:expr) => {
                                let value = match begin {
                                    Begin::Add => S::add($value, load::<S>(y, $at, n)),
                                    _ => S::add($value, bias),
                                };
                                store::<S>(y, $at, n, value);
                            };
                        }
                        if i == 0 || below {
                            put!(at, p);
                            if right {
                                put!(at + width, q);
                            }
                        }
                    }
                }
            }
        });
    }
}

at_level! {
    /// Computes `u = G g Gᵀ`: 3×3 blocks of `len` weights become 4×4.
    pub(crate) fn pack(len: usize, weight: &[f32], u: &mut [f32]) = pack_at
}

/// Computes [`pack`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
unsafe fn pack_at<S: Simd>(len: usize, weight: &[f32], u: &mut [f32]) {
    at_least("weights of a convolution", weight.len(), 9 * len);
    at_least("packed weights", u.len(), TILE * len);
    vectors!(S, len, c, n, {
        // SAFETY: `c + n <= len`, and `weight` is asserted to hold 9 blocks of `len`, `u` 16.
        unsafe {
            let half = S::splat(0.5);
            let mut columns = [[S::splat(0.0); 3]; 4];
            for j in 0..3 {
                let [a, b, d] = [
                    load::<S>(weight, j * len + c, n),
                    load::<S>(weight, (3 + j) * len + c, n),
                    load::<S>(weight, (6 + j) * len + c, n),
                ];
                let sum = S::add(a, d);
                columns[0][j] = a;
                columns[1][j] = S::mul(half, S::add(sum, b));
                columns[2][j] = S::mul(half, S::sub(sum, b));
                columns[3][j] = d;
            }
            for (i, [a, b, d]) in columns.into_iter().enumerate() {
                let sum = S::add(a, d);
                store::<S>(u, 4 * i * len + c, n, a);
                store::<S>(u, (4 * i + 1) * len + c, n, S::mul(half, S::add(sum, b)));
                store::<S>(u, (4 * i + 2) * len + c, n, S::mul(half, S::sub(sum, b)));
                store::<S>(u, (4 * i + 3) * len + c, n, d);
            }
        }
    });
}

at_level! {
    /// Computes `dweight += Gᵀ du G`: the way back of [`pack`] for gradients.
    pub(crate) fn unpack(len: usize, du: &[f32], dweight: &mut [f32]) = unpack_at
}

/// Computes [`unpack`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
unsafe fn unpack_at<S: Simd>(len: usize, du: &[f32], dweight: &mut [f32]) {
    at_least("gradient of the packed weights", du.len(), TILE * len);
    at_least("weight gradient of a convolution", dweight.len(), 9 * len);
    vectors!(S, len, c, n, {
        // SAFETY: `c + n <= len`, and `du` is asserted to hold 16 blocks of `len`, `dweight` 9.
        unsafe {
            let half = S::splat(0.5);
            macro_rules! thirds {
                ($m:expr) => {{
                    let [a, b, d, e] = $m;
                    let (sum, gap) = (S::mul(half, S::add(b, d)), S::mul(half, S::sub(b, d)));
                    [S::add(a, sum), gap, S::add(sum, e)]
                }};
            }
            let mut rows = [[S::splat(0.0); 4]; 3];
            for j in 0..4 {
                let column = [
                    load::<S>(du, j * len + c, n),
                    load::<S>(du, (4 + j) * len + c, n),
                    load::<S>(du, (8 + j) * len + c, n),
                    load::<S>(du, (12 + j) * len + c, n),
                ];
                let [a, b, d] = thirds!(column);
                (rows[0][j], rows[1][j], rows[2][j]) = (a, b, d);
            }
            for (i, row) in rows.into_iter().enumerate() {
                let [a, b, d] = thirds!(row);
                for (j, value) in [a, b, d].into_iter().enumerate() {
                    let at = (3 * i + j) * len + c;
                    store::<S>(dweight, at, n, S::add(load::<S>(dweight, at, n), value));
                }
            }
        }
    });
}
