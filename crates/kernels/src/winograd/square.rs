//! F(2×2, 3×3): 16 products in place of 36 for every 2×2 outputs, on overlapping 4×4 tiles of the input.
//!
//! All factors of the transforms are 0, ±1 and ½, so that little accuracy is lost.

use super::Begin;
use crate::simd::{Simd, at_level};
use crate::tile::{Start, Tile, columns, even, wide_rows};
use crate::view::{load, store, vectors};

/// Elements of a tile.
const TILE: usize = 16;
/// Floats between the planes of a block, so that they do not all fall into the same cache sets.
const GAP: usize = 16;
/// Floats of a block that stay in cache between transform and product.
const BLOCK: usize = 96 * 1024;

/// Sizes of a 3×3 convolution with stride 1 whose input lies in a halo that its tiles fill.
#[derive(Debug, Clone)]
pub(crate) struct Square {
    /// Rows and columns of the output.
    output: [usize; 2],
    channels: usize,
    filters: usize,
    /// Tiles from top to bottom and from left to right.
    tiles: [usize; 2],
    /// Tiles of a block.
    block: usize,
}

impl Square {
    pub fn new(output: [usize; 2], channels: usize, filters: usize) -> Self {
        let tiles = output.map(|size| size.div_ceil(2));
        // A multiple of the rows that a product holds in registers.
        let rows = wide_rows();
        let most = (BLOCK / (TILE * (channels + filters)) / rows).max(1) * rows;
        let block = even(tiles[0] * tiles[1], most);
        Square { output, channels, filters, tiles, block }
    }

    /// Rows and columns of the input with the halo that the tiles cover.
    fn halo(&self) -> [usize; 2] {
        self.tiles.map(|tiles| 2 * tiles + 2)
    }

    pub fn padded(&self, padded: [usize; 3]) -> [usize; 3] {
        let [rows, columns] = self.halo();
        [padded[0], rows, columns]
    }

    pub fn weight_len(&self) -> usize {
        TILE * self.channels * self.filters
    }

    pub fn work_len(&self) -> usize {
        TILE * (self.plane(self.channels) + self.plane(self.filters))
    }

    /// Floats from one plane of a block to the next.
    fn plane(&self, width: usize) -> usize {
        self.block * width + GAP
    }

    /// `u = G g Gᵀ` of weights (3 × 3 × channels × filters): element × channels × filters.
    pub fn pack(&self, weight: &[f32], u: &mut [f32]) {
        let block = self.channels * self.filters;
        pack(block, &weight[..9 * block], &mut u[..TILE * block]);
    }

    /// Adds `Gᵀ du G` to the weights' gradient.
    pub fn unpack(&self, du: &[f32], dweight: &mut [f32]) {
        let block = self.channels * self.filters;
        unpack(block, &du[..TILE * block], &mut dweight[..9 * block]);
    }

    pub fn forward(&self, padded: &[f32], u: &[f32], begin: Begin, y: &mut [f32], work: &mut [f32]) {
        let (channels, filters) = (self.channels, self.filters);
        assert!(u.len() >= self.weight_len() && work.len() >= self.work_len(), "packed weights and scratch");
        assert!(padded.len() >= self.halo().iter().product::<usize>() * channels, "a padded image");
        assert!(y.len() >= self.output.iter().product::<usize>() * filters, "an output image");
        let (from_plane, to_plane) = (self.plane(channels), self.plane(filters));
        let (v, m) = work.split_at_mut(TILE * from_plane);
        let m = &mut m[..TILE * to_plane];
        let all = self.tiles[0] * self.tiles[1];
        for first in (0..all).step_by(self.block) {
            let count = self.block.min(all - first);
            spread_input(self, first, count, padded, v);
            for element in 0..TILE {
                for columns in columns(filters) {
                    let most = even(count, columns.rows());
                    for from in (0..count).step_by(most) {
                        let rows = most.min(count - from);
                        let tile = Tile {
                            a: v[element * from_plane + from * channels..].as_ptr(),
                            a_row: channels,
                            a_step: 1,
                            b: u[element * channels * filters + columns.from..].as_ptr(),
                            b_row: filters,
                            c: m[element * to_plane + from * filters + columns.from..].as_mut_ptr(),
                            c_row: filters,
                            segments: &[(0, 0)],
                            run: channels,
                            start: Start::Zero,
                            last: columns.last,
                        };
                        // SAFETY: `a` walks `rows` of the `count` tiles of one plane, `b` one element's
                        // weights, `c` the same tiles of the other plane; lengths are asserted.
                        unsafe { columns.kernel(rows)(&tile) };
                    }
                }
            }
            gather_output(self, first, count, m, begin, y);
        }
    }

    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], du: &mut [f32], work: &mut [f32]) {
        let (channels, filters) = (self.channels, self.filters);
        assert!(du.len() >= self.weight_len() && work.len() >= self.work_len(), "gradient and scratch");
        assert!(padded.len() >= self.halo().iter().product::<usize>() * channels, "a padded image");
        assert!(dy.len() >= self.output.iter().product::<usize>() * filters, "a gradient image");
        let (from_plane, to_plane) = (self.plane(channels), self.plane(filters));
        let (v, w) = work.split_at_mut(TILE * from_plane);
        let w = &mut w[..TILE * to_plane];
        let all = self.tiles[0] * self.tiles[1];
        for first in (0..all).step_by(self.block) {
            let count = self.block.min(all - first);
            spread_input(self, first, count, padded, v);
            spread_gradient(self, first, count, dy, w);
            for element in 0..TILE {
                for columns in columns(filters) {
                    let most = even(channels, columns.rows());
                    for from in (0..channels).step_by(most) {
                        let rows = most.min(channels - from);
                        let tile = Tile {
                            a: v[element * from_plane + from..].as_ptr(),
                            a_row: 1,
                            a_step: channels,
                            b: w[element * to_plane + columns.from..].as_ptr(),
                            b_row: filters,
                            c: du[(element * channels + from) * filters + columns.from..].as_mut_ptr(),
                            c_row: filters,
                            segments: &[(0, 0)],
                            run: count,
                            start: Start::Add,
                            last: columns.last,
                        };
                        // SAFETY: `a` and `b` walk the `count` tiles of one plane each, `c` covers `rows`
                        // channels of one element; lengths are asserted.
                        unsafe { columns.kernel(rows)(&tile) };
                    }
                }
            }
        }
    }

    /// The tiles `first..first + count`, row by row: (row, column, number of tiles, number in the block).
    fn rows(&self, first: usize, count: usize) -> impl Iterator<Item = (usize, usize, usize, usize)> {
        let across = self.tiles[1];
        let mut tile = first;
        std::iter::from_fn(move || {
            let (row, column) = (tile / across, tile % across);
            let run = (across - column).min(first + count - tile);
            let number = tile - first;
            tile += run;
            (run > 0).then_some((row, column, run, number))
        })
    }
}

/// `Bᵀ d` of one column.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn spread<S: Simd>(d: [S::V; 4]) -> [S::V; 4] {
    // SAFETY: the caller's contract.
    unsafe { [S::sub(d[0], d[2]), S::add(d[1], d[2]), S::sub(d[2], d[1]), S::sub(d[1], d[3])] }
}

/// `Aᵀ m` of one column.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn gather<S: Simd>(m: [S::V; 4]) -> [S::V; 2] {
    // SAFETY: the caller's contract.
    unsafe { [S::add(S::add(m[0], m[1]), m[2]), S::sub(S::sub(m[1], m[2]), m[3])] }
}

at_level! {
    /// `v = Bᵀ d B` of a block of tiles.
    fn spread_input(w: &Square, first: usize, count: usize, x: &[f32], v: &mut [f32]) = spread_input_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn spread_input_at<S: Simd>(w: &Square, first: usize, count: usize, x: &[f32], v: &mut [f32]) {
    let (width, plane) = (w.channels, w.plane(w.channels));
    let line = w.halo()[1] * width;
    for (row, column, run, number) in w.rows(first, count) {
        let x = &x[2 * row * line + 2 * column * width..];
        let v = &mut v[number * width..];
        vectors!(S, width, c, n, {
            // SAFETY: `c + n <= width`; the tiles of a row lie inside the padded image, and inside the block.
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
                for tile in 0..run {
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
    /// `w = A dy Aᵀ` of a block of tiles; outputs beyond the edge count as zero.
    fn spread_gradient(w: &Square, first: usize, count: usize, dy: &[f32], to: &mut [f32]) = spread_gradient_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn spread_gradient_at<S: Simd>(w: &Square, first: usize, count: usize, dy: &[f32], to: &mut [f32]) {
    let (width, plane) = (w.filters, w.plane(w.filters));
    let [rows, columns] = w.output;
    for (row, column, run, number) in w.rows(first, count) {
        let dy = &dy[(2 * row * columns + 2 * column) * width..];
        let to = &mut to[number * width..];
        let below = 2 * row + 1 < rows;
        vectors!(S, width, c, n, {
            // SAFETY: `c + n <= width`; positions beyond the edge are not read.
            unsafe {
                let zero = S::splat(0.0);
                for tile in 0..run {
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
    /// `y = Aᵀ m A` of a block of tiles.
    fn gather_output(
        w: &Square, first: usize, count: usize, m: &[f32], begin: Begin, y: &mut [f32],
    ) = gather_output_at
}

/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
unsafe fn gather_output_at<S: Simd>(
    w: &Square,
    first: usize,
    count: usize,
    m: &[f32],
    begin: Begin,
    y: &mut [f32],
) {
    let (width, plane) = (w.filters, w.plane(w.filters));
    let [rows, columns] = w.output;
    for (row, column, run, number) in w.rows(first, count) {
        let y = &mut y[(2 * row * columns + 2 * column) * width..];
        let m = &m[number * width..];
        let below = 2 * row + 1 < rows;
        vectors!(S, width, c, n, {
            // SAFETY: `c + n <= width`; positions beyond the edge are neither read nor written.
            unsafe {
                let bias = if let Begin::Bias(bias) = begin { load::<S>(bias, c, n) } else { S::splat(0.0) };
                for tile in 0..run {
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
    fn pack(len: usize, weight: &[f32], u: &mut [f32]) = pack_at
}

/// # Safety
/// The CPU has the features of `S`; `weight` holds 9 and `u` 16 blocks of `len`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
unsafe fn pack_at<S: Simd>(len: usize, weight: &[f32], u: &mut [f32]) {
    vectors!(S, len, c, n, {
        // SAFETY: `c + n <= len`, the length of every block.
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
    fn unpack(len: usize, du: &[f32], dweight: &mut [f32]) = unpack_at
}

/// # Safety
/// The CPU has the features of `S`; `du` holds 16 and `dweight` 9 blocks of `len`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
unsafe fn unpack_at<S: Simd>(len: usize, du: &[f32], dweight: &mut [f32]) {
    vectors!(S, len, c, n, {
        // SAFETY: `c + n <= len`, the length of every block.
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
