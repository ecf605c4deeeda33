//! Convolution of 3×3 windows with fewer products, of bf16.
//!
//! As [`crate::conv`] in floats: tiles of the input and weights are transformed, multiplied and transformed back
//! (F(2×2, 3×3)). The transformed factors are rounded to bf16; transforms and sums are floats.

use crate::buffer::Buffer;
use crate::conv::winograd::WIDE_PAIRED;
use crate::conv::winograd::grid::{TILE, TileGrid};
use crate::conv::winograd::square_transforms::{gather_output, pack, spread_input};
use crate::conv::{Begin, ConvKind};
use crate::frozen::place::{ImagePlace, Route};
use crate::frozen::rows;
use crate::half::{assert_supported, pair_columns_of_rows, pair_rows};
use crate::lengths::{at_least, exactly};
use crate::tile::{ColumnBlock, Start, Tile, even, pair_columns};
use crate::view::{AffineView, Rectifier};
use crate::window::Window3;

/// A convolution with its transformed weights in bf16.
pub struct Winograd {
    grid: TileGrid,
    from: ImagePlace,
    to: ImagePlace,
    addend: Option<ImagePlace>,
    /// The input in the halo of zeros that its tiles cover.
    padded: ImagePlace,
    blocks: Vec<ColumnBlock>,
    /// Element × block of filters × pairs of channels × filters.
    weights: Buffer,
    bias: Vec<f32>,
    rectifier: Rectifier,
}

impl Winograd {
    /// Checks whether a convolution with fewer products in floats has fewer in bf16, too.
    pub fn pays(window: &Window3, kind: ConvKind, channels: usize, filters: usize) -> bool {
        let is_square = window.kernel == [1, 3, 3] && window.output[0] == 1 && window.input[0] == 1;
        let wide = channels.min(filters) >= WIDE_PAIRED && channels.is_multiple_of(2);
        kind == ConvKind::Winograd && is_square && wide
    }

    /// Makes a convolution along `route` of a window whose steps and dilation are 1; `weight` lies as kernel × channels in ×
    /// channels out.
    pub fn new(window: &Window3, weight: &[f32], bias: &[f32], route: Route) -> Self {
        assert_supported();
        let Route { from, to, addend, rectifier } = route;
        let Window3 { input, output, kernel, stride, before } = *window;
        let fits = input == from.size && output == to.size && kernel == [1, 3, 3] && stride == [1; 3];
        assert!(fits && input[0] == 1 && output[0] == 1, "{window:?}: {from:?} to {to:?}");
        let (channels, filters) = (from.channels, to.channels);
        assert!(channels.is_multiple_of(2), "pairs of channels are needed: {from:?}");
        exactly("weights of a convolution", weight.len(), 9 * channels * filters);
        exactly("bias of a convolution", bias.len(), filters);
        let grid = TileGrid::new([output[1], output[2]], channels, filters);
        let [rows, columns] = grid.halo();
        let fits = before[1] + input[1] <= rows && before[2] + input[2] <= columns;
        assert!(fits, "windows over all inputs are needed: {window:?}");
        let pitch = [rows * columns * channels, columns * channels, channels];
        let start = before[1] * pitch[1] + before[2] * pitch[2];
        let margin = [before[2], columns - before[2] - input[2]];
        let padded = ImagePlace { size: input, channels, start, pitch, margin };
        let blocks: Vec<ColumnBlock> = pair_columns(filters).collect();
        let weights = transformed(&blocks, channels, filters, weight);
        Winograd { grid, from, to, addend, padded, blocks, weights, bias: bias.to_vec(), rectifier }
    }

    /// Returns the number of values of scratch that [`Winograd::run`] needs.
    pub fn work_len(&self) -> usize {
        self.parts().iter().sum()
    }

    /// Returns the lengths of the parts of scratch: padded input, transformed input and its pairs, products, outputs.
    fn parts(&self) -> [usize; 5] {
        let (channels, filters) = (self.from.channels, self.to.channels);
        let planes = |width| TILE * self.grid.plane(width);
        [
            self.grid.halo_len() * channels,
            planes(channels),
            self.grid.plane(channels / 2),
            planes(filters),
            self.grid.output_len() * filters,
        ]
    }

    /// Computes `y = rectifier(conv(x) + bias + addend)`.
    pub fn run(&self, x: &[f32], addend: Option<&[f32]>, work: &mut [f32], y: &mut [f32]) {
        at_least("scratch of a frozen convolution", work.len(), self.work_len());
        let [first, second, third, fourth, fifth] = self.parts();
        let (padded, rest) = work.split_at_mut(first);
        let (spread, rest) = rest.split_at_mut(second);
        let (pairs, rest) = rest.split_at_mut(third);
        let (products, rest) = rest.split_at_mut(fourth);
        let outputs = &mut rest[..fifth];
        let (channels, filters) = (self.from.channels, self.to.channels);
        padded.fill(0.0);
        rows::copy(&self.from, x, &self.padded, padded);
        for (first, count) in self.grid.blocks() {
            spread_input(&self.grid, channels, first, count, padded, spread);
            for element in 0..TILE {
                let pairs = &mut pairs[..count * channels / 2];
                let plane = &spread[element * self.grid.plane(channels)..];
                pair_columns_of_rows(channels, channels, plane, pairs);
                self.multiply(element, count, pairs, &mut products[element * self.grid.plane(filters)..]);
            }
            let begin = Begin::Bias(&self.bias);
            gather_output(&self.grid, filters, first, count, products, begin, outputs);
        }
        let dense = ImagePlace::dense(self.to.size, filters);
        if let Some(place) = &self.addend {
            rows::add(place, addend.unwrap_or_default(), &dense, outputs);
        }
        let view = AffineView { affine: None, rectifier: self.rectifier };
        rows::map(&view, &dense, outputs, &self.to, y);
    }

    /// Computes the products of one element of a block's tiles: tiles × channels by channels × filters.
    fn multiply(&self, element: usize, count: usize, pairs: &[f32], products: &mut [f32]) {
        let (half, filters) = (self.from.channels / 2, self.to.channels);
        exactly("pairs of a block", pairs.len(), count * half);
        let products = &mut products[..count * filters];
        let weights = &self.weights[element * half * filters..][..half * filters];
        for columns in &self.blocks {
            let most = even(count, columns.rows());
            for from in (0..count).step_by(most) {
                let rows = most.min(count - from);
                let tile = Tile {
                    a: pairs[from * half..].as_ptr(),
                    a_row: half,
                    a_step: 1,
                    b: weights[columns.from * half..].as_ptr(),
                    b_row: columns.width(),
                    c: products[from * filters + columns.from..].as_mut_ptr(),
                    c_row: filters,
                    segments: &[(0, 0)],
                    run: half,
                    start: Start::Zero,
                    last: columns.last,
                    addend: None,
                    rectifier: Rectifier::None,
                };
                // SAFETY: `a` walks `rows` of the `count` tiles of `pairs`, whose length is asserted; `b` the `half` rows of this
                // block's weights, which lie behind those of the filters before it; `c` the same tiles of `products`, cut to just
                // that length. `products` is borrowed exclusively, and `pair_columns` has asserted the CPU's features.
                unsafe { columns.kernel(rows)(&tile) };
            }
        }
    }
}

/// Returns the transformed weights as pairs, in the order in which they are read.
fn transformed(blocks: &[ColumnBlock], channels: usize, filters: usize, weight: &[f32]) -> Buffer {
    let mut floats = vec![0.0; TILE * channels * filters];
    pack(channels * filters, weight, &mut floats);
    let half = channels / 2;
    let mut weights = Buffer::zeros(TILE * half * filters);
    let elements = weights.chunks_exact_mut(half * filters);
    for (from, to) in floats.chunks_exact(channels * filters).zip(elements) {
        for columns in blocks {
            let to = &mut to[columns.from * half..][..half * columns.width()];
            pair_rows(channels, columns.width(), filters, &from[columns.from..], to);
        }
    }
    weights
}
