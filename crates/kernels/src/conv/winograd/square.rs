//! F(2×2, 3×3): 16 products in place of 36 for every 2×2 outputs, on overlapping 4×4 tiles of the input.
//!
//! All factors of the transforms are 0, ±1 and ½, so that little accuracy is lost.

use crate::conv::begin::Begin;
use crate::lengths::at_least;
use crate::tile::{Start, Tile, columns, even};
use crate::view::Rectifier;

use super::grid::{TILE, TileGrid};
use super::square_transforms::{gather_output, pack, spread_gradient, spread_input, unpack};

/// Sizes of a 3×3 convolution with stride 1 whose input lies in a halo that its tiles fill.
#[derive(Debug, Clone)]
pub(crate) struct Square {
    grid: TileGrid,
    channels: usize,
    filters: usize,
}

impl Square {
    pub fn new(output: [usize; 2], channels: usize, filters: usize) -> Self {
        Square { grid: TileGrid::new(output, channels, filters), channels, filters }
    }

    pub fn padded(&self, padded: [usize; 3]) -> [usize; 3] {
        let [rows, columns] = self.grid.halo();
        [padded[0], rows, columns]
    }

    pub fn weight_len(&self) -> usize {
        TILE * self.channels * self.filters
    }

    pub fn work_len(&self) -> usize {
        TILE * (self.grid.plane(self.channels) + self.grid.plane(self.filters))
    }

    /// Computes `u = G g Gᵀ` of weights (3 × 3 × channels × filters): element × channels × filters.
    pub fn pack(&self, weight: &[f32], u: &mut [f32]) {
        pack(self.channels * self.filters, weight, u);
    }

    /// Adds `Gᵀ du G` to the weights' gradient.
    pub fn unpack(&self, du: &[f32], dweight: &mut [f32]) {
        unpack(self.channels * self.filters, du, dweight);
    }

    pub fn forward(&self, padded: &[f32], u: &[f32], begin: Begin, y: &mut [f32], work: &mut [f32]) {
        at_least("packed weights", u.len(), self.weight_len());
        let (v, m) = self.split(work);
        for (first, count) in self.grid.blocks() {
            spread_input(&self.grid, self.channels, first, count, padded, v);
            for element in 0..TILE {
                self.products(element, count, v, u, m);
            }
            gather_output(&self.grid, self.filters, first, count, m, begin, y);
        }
    }

    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], du: &mut [f32], work: &mut [f32]) {
        at_least("gradient of the packed weights", du.len(), self.weight_len());
        let (v, w) = self.split(work);
        for (first, count) in self.grid.blocks() {
            spread_input(&self.grid, self.channels, first, count, padded, v);
            spread_gradient(&self.grid, self.filters, first, count, dy, w);
            for element in 0..TILE {
                self.weight_products(element, count, v, w, du);
            }
        }
    }

    /// Splits `work` into scratch for the transformed input and for the transformed output of a block.
    fn split<'a>(&self, work: &'a mut [f32]) -> (&'a mut [f32], &'a mut [f32]) {
        at_least("scratch of a convolution", work.len(), self.work_len());
        work[..self.work_len()].split_at_mut(TILE * self.grid.plane(self.channels))
    }

    /// Computes `m = v · u` of one element of a block's tiles: tiles × channels by channels × filters.
    fn products(&self, element: usize, count: usize, v: &[f32], u: &[f32], m: &mut [f32]) {
        let (channels, filters) = (self.channels, self.filters);
        let (v, m) = (self.plane(element, count, channels, v), self.plane_mut(element, count, filters, m));
        let u = &u[element * channels * filters..(element + 1) * channels * filters];
        for columns in columns(filters) {
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
                // of `m`; the three were cut to just that length above. `m` is borrowed exclusively.
                unsafe { columns.kernel(rows)(&tile) };
            }
        }
    }

    /// Computes `du += vᵀ · w` of one element: channels × tiles by tiles × filters.
    fn weight_products(&self, element: usize, count: usize, v: &[f32], w: &[f32], du: &mut [f32]) {
        let (channels, filters) = (self.channels, self.filters);
        let (v, w) = (self.plane(element, count, channels, v), self.plane(element, count, filters, w));
        let du = &mut du[element * channels * filters..(element + 1) * channels * filters];
        for columns in columns(filters) {
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
                // the three were cut to just that length above. `du` is borrowed exclusively.
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
