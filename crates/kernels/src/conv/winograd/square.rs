//! F(2×2, 3×3): 16 products in place of 36 for every 2×2 outputs, on overlapping 4×4 tiles of the input.
//!
//! All factors of the transforms are 0, ±1 and ½, so that little accuracy is lost, also where the transformed values are rounded
//! to bf16: pairs of neighbouring channels for outputs, of neighbouring tiles for the weights' gradient.

use crate::conv::begin::Begin;
use crate::half::{pair_columns_of_rows, pair_rows};
use crate::lengths::{at_least, exactly};
use crate::tile::{Start, Tile, columns_of, even};
use crate::view::Rectifier;

use super::grid::{TILE, TileGrid};
use super::square_transforms::{gather_output, pack, spread_gradient, spread_input, unpack};

/// Sizes of a 3×3 convolution with stride 1 whose input lies in a halo that its tiles fill.
#[derive(Debug, Clone)]
pub(crate) struct Square {
    grid: TileGrid,
    channels: usize,
    filters: usize,
    /// Whether products are of bf16.
    paired: bool,
}

/// Scratch of a block of tiles.
struct Work<'a> {
    /// Transformed input, and transformed output or its gradient: elements × tiles × channels.
    v: &'a mut [f32],
    m: &'a mut [f32],
    /// Pairs of one element of each.
    v_pairs: &'a mut [f32],
    w_pairs: &'a mut [f32],
}

impl Square {
    pub fn new(output: [usize; 2], channels: usize, filters: usize, paired: bool) -> Self {
        Square { grid: TileGrid::new(output, channels, filters), channels, filters, paired }
    }

    pub fn padded(&self, padded: [usize; 3]) -> [usize; 3] {
        let [rows, columns] = self.grid.halo();
        [padded[0], rows, columns]
    }

    pub fn weight_len(&self) -> usize {
        TILE * self.channels * self.filters
    }

    /// Returns the number of packed weights; behind pairs of bf16 lie the floats that they are made of.
    pub fn packed_len(&self) -> usize {
        self.weight_len() + if self.paired { TILE * self.depth() * self.filters } else { 0 }
    }

    /// Returns the rows of the packed weights of an element: channels, or pairs of them.
    fn depth(&self) -> usize {
        if self.paired { self.channels.div_ceil(2) } else { self.channels }
    }

    pub fn work_len(&self) -> usize {
        let planes = TILE + usize::from(self.paired);
        planes * (self.grid.plane(self.channels) + self.grid.plane(self.filters))
    }

    /// Computes `u = G g Gᵀ` of weights (3 × 3 × channels × filters): element × channels × filters.
    pub fn pack(&self, weight: &[f32], u: &mut [f32]) {
        let (channels, filters) = (self.channels, self.filters);
        let (pairs, floats) = u.split_at_mut(self.packed_len() - self.weight_len());
        pack(channels * filters, weight, floats);
        if self.paired {
            let elements = pairs.chunks_exact_mut(self.depth() * filters);
            for (pairs, floats) in elements.zip(floats.chunks_exact(channels * filters)) {
                pair_rows(channels, filters, filters, floats, pairs);
            }
        }
    }

    /// Adds `Gᵀ du G` to the weights' gradient.
    pub fn unpack(&self, du: &[f32], dweight: &mut [f32]) {
        unpack(self.channels * self.filters, du, dweight);
    }

    pub fn forward(&self, padded: &[f32], u: &[f32], begin: Begin, y: &mut [f32], work: &mut [f32]) {
        at_least("packed weights", u.len(), self.packed_len());
        let (channels, filters, depth) = (self.channels, self.filters, self.depth());
        let Work { v, m, v_pairs, .. } = self.split(work);
        for (first, count) in self.grid.blocks() {
            spread_input(&self.grid, channels, first, count, padded, v);
            for element in 0..TILE {
                let mut v = self.plane(element, count, channels, v);
                if self.paired {
                    pair_columns_of_rows(channels, channels, v, &mut v_pairs[..count * depth]);
                    v = &v_pairs[..count * depth];
                }
                let u = &u[element * depth * filters..][..depth * filters];
                self.products(count, v, u, self.plane_mut(element, count, filters, m));
            }
            gather_output(&self.grid, filters, first, count, m, begin, y);
        }
    }

    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], du: &mut [f32], work: &mut [f32]) {
        at_least("gradient of the packed weights", du.len(), self.weight_len());
        let (channels, filters) = (self.channels, self.filters);
        let Work { v, m: w, v_pairs, w_pairs } = self.split(work);
        for (first, count) in self.grid.blocks() {
            spread_input(&self.grid, channels, first, count, padded, v);
            spread_gradient(&self.grid, filters, first, count, dy, w);
            for (element, du) in du.chunks_exact_mut(channels * filters).take(TILE).enumerate() {
                let v = self.plane(element, count, channels, v);
                let w = self.plane(element, count, filters, w);
                if self.paired {
                    let half = count.div_ceil(2);
                    pair_rows(count, channels, channels, v, v_pairs);
                    pair_rows(count, filters, filters, w, w_pairs);
                    self.weight_products(half, &v_pairs[..half * channels], &w_pairs[..half * filters], du);
                } else {
                    self.weight_products(count, v, w, du);
                }
            }
        }
    }

    /// Splits `work` into scratch for the transformed input and for the transformed output of a block, and for the pairs of one
    /// element of each.
    fn split<'a>(&self, work: &'a mut [f32]) -> Work<'a> {
        at_least("scratch of a convolution", work.len(), self.work_len());
        let (input, output) = (self.grid.plane(self.channels), self.grid.plane(self.filters));
        let (v, work) = work.split_at_mut(TILE * input);
        let (m, work) = work.split_at_mut(TILE * output);
        let (v_pairs, w_pairs) = work.split_at_mut(if self.paired { input } else { 0 });
        Work { v, m, v_pairs, w_pairs }
    }

    /// Computes `m = v · u` of one element of a block's tiles: tiles × channels by channels × filters, or pairs of channels.
    fn products(&self, count: usize, v: &[f32], u: &[f32], m: &mut [f32]) {
        let (channels, filters) = (self.depth(), self.filters);
        exactly("tiles of a block", v.len(), count * channels);
        exactly("packed weights of an element", u.len(), channels * filters);
        exactly("outputs of a block", m.len(), count * filters);
        for columns in columns_of(filters, self.paired) {
            let most = even(count, columns.rows());
            for from in (0..count).step_by(most) {
                let rows = most.min(count - from);
                let tile = Tile {
                    a: v[from * channels..].as_ptr(),
                    a_row: channels,
                    a_step: 1,
                    b: u[columns.from..].as_ptr(),
                    b_row: filters,
                    c: m[from * filters + columns.from..].as_mut_ptr(),
                    c_row: filters,
                    segments: &[(0, 0)],
                    run: channels,
                    start: Start::Zero,
                    last: columns.last,
                    addend: None,
                    rectifier: Rectifier::None,
                };
                // SAFETY: `a` walks `rows` of the `count` tiles of `v`, `b` the weights `u`, `c` the same tiles
                // of `m`; the lengths of the three are asserted above. `m` is borrowed exclusively.
                unsafe { columns.kernel(rows)(&tile) };
            }
        }
    }

    /// Computes `du += vᵀ · w` of one element: channels × tiles by tiles × filters, or pairs of tiles.
    fn weight_products(&self, count: usize, v: &[f32], w: &[f32], du: &mut [f32]) {
        let (channels, filters) = (self.channels, self.filters);
        exactly("tiles of a block", v.len(), count * channels);
        exactly("gradients of a block", w.len(), count * filters);
        exactly("gradient of the packed weights of an element", du.len(), channels * filters);
        for columns in columns_of(filters, self.paired) {
            let most = even(channels, columns.rows());
            for from in (0..channels).step_by(most) {
                let rows = most.min(channels - from);
                let tile = Tile {
                    a: v[from..].as_ptr(),
                    a_row: 1,
                    a_step: channels,
                    b: w[columns.from..].as_ptr(),
                    b_row: filters,
                    c: du[from * filters + columns.from..].as_mut_ptr(),
                    c_row: filters,
                    segments: &[(0, 0)],
                    run: count,
                    start: Start::Add,
                    last: columns.last,
                    addend: None,
                    rectifier: Rectifier::None,
                };
                // SAFETY: `a` and `b` walk the `count` tiles of `v` and `w`, `c` covers `rows` channels of `du`;
                // the lengths of the three are asserted above. `du` is borrowed exclusively.
                unsafe { columns.kernel(rows)(&tile) };
            }
        }
    }

    /// Returns one plane of a block: `count` tiles × `width`.
    fn plane<'a>(&self, element: usize, count: usize, width: usize, block: &'a [f32]) -> &'a [f32] {
        &block[element * self.grid.plane(width)..][..count * width]
    }

    fn plane_mut<'a>(
        &self,
        element: usize,
        count: usize,
        width: usize,
        block: &'a mut [f32],
    ) -> &'a mut [f32] {
        &mut block[element * self.grid.plane(width)..][..count * width]
    }
}
