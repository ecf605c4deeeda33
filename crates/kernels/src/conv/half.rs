//! Convolution with products of bf16: every product of the definition, two at a time.
//!
//! Outputs take pairs of neighbouring channels, so a padded image of pairs is one of half as many channels, and the
//! blocks are those of [`Direct`]. Where the number of channels is odd, they take pairs of neighbouring values of a row, so that
//! no half of a pair is empty but the last. The weights' gradient takes pairs of neighbouring outputs of a row.

use crate::half::{pair_columns_of_rows, pair_rows, pair_with_later};
use crate::lengths::at_least;
use crate::tile::{Start, Tile, even, pair_columns};
use crate::view::Rectifier;
use crate::window::Window3;

use super::begin::Begin;
use super::direct::Direct;
use super::sizes::ConvSizes;

/// The plan of a convolution of bf16.
#[derive(Debug, Clone)]
pub(crate) struct HalfDirect {
    sizes: ConvSizes,
    /// The convolution of floats, whose taps the weights' gradient follows.
    floats: Direct,
    /// That of pairs.
    pairs: Direct,
    /// Where the rows of outputs start, in the padded input and among the pairs of outputs.
    starts: Vec<(usize, usize)>,
}

impl HalfDirect {
    /// Makes the plan; none where pairs of channels would cross the edge of a group.
    pub fn new(sizes: ConvSizes) -> Option<Self> {
        let [inner, _] = sizes.of_group();
        if sizes.is_depthwise() || sizes.groups > 1 && !inner.is_multiple_of(2) {
            return None;
        }
        let ConvSizes { window, dilation, channels, filters, groups } = sizes;
        let along = (channels % 2 == 1).then(|| Direct::paired_along(sizes)).flatten();
        let across =
            || Direct::paired(ConvSizes::new(window, dilation, channels.div_ceil(2), filters, groups));
        let pairs = along.unwrap_or_else(across);
        let floats = Direct::new(sizes);
        let row = window.output[2].div_ceil(2) * filters;
        let starts =
            floats.starts().iter().enumerate().map(|(line, &(from, _))| (from, line * row)).collect();
        Some(HalfDirect { sizes, pairs, floats, starts })
    }

    pub fn packed_len(&self) -> usize {
        self.pairs.weight_len()
    }

    /// Returns the number of values of scratch for any pass.
    pub fn work_len(&self) -> usize {
        self.pairs.padded_len().max(self.floats.padded_len() + self.dy_len())
    }

    /// Returns the number of pairs of outputs.
    fn dy_len(&self) -> usize {
        let Window3 { output, .. } = self.sizes.window;
        output[0] * output[1] * output[2].div_ceil(2) * self.sizes.filters
    }

    /// Packs weights, for every group and kernel value: pairs of channels in × channels out; or for every row of the kernel: pairs of
    /// its values in × channels out.
    pub fn pack(&self, weight: &[f32], packed: &mut [f32]) {
        let [inner, out] = self.sizes.of_group();
        let rows = if self.pairs.is_along() { inner * self.sizes.window.kernel[2] } else { inner };
        at_least("weights of a convolution", weight.len(), self.sizes.weight_len());
        at_least("packed weights", packed.len(), self.packed_len());
        let packed = packed.chunks_exact_mut(rows.div_ceil(2) * out);
        for (from, to) in weight.chunks_exact(rows * out).zip(packed) {
            pair_rows(rows, out, out, from, to);
        }
    }

    /// Computes `y` from a padded image and packed weights.
    pub fn forward(&self, padded: &[f32], packed: &[f32], begin: Begin, y: &mut [f32], work: &mut [f32]) {
        let channels = self.sizes.channels;
        at_least("padded input of a convolution", padded.len(), self.floats.padded_len());
        at_least("scratch of a convolution", work.len(), self.work_len());
        let pairs = &mut work[..self.pairs.padded_len()];
        if self.pairs.is_along() {
            pair_with_later(1, &padded[..pairs.len()], pairs);
        } else {
            pair_columns_of_rows(channels, channels, padded, pairs);
        }
        self.pairs.forward(pairs, packed, begin, y);
    }

    /// Adds the gradient of the weights to `dweight`, block by block of it.
    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], dweight: &mut [f32], work: &mut [f32]) {
        at_least("padded input of a convolution", padded.len(), self.floats.padded_len());
        at_least("dy of a convolution", dy.len(), self.sizes.y_len());
        at_least("weight gradient of a convolution", dweight.len(), self.sizes.weight_len());
        at_least("scratch of a convolution", work.len(), self.work_len());
        let ConvSizes { window: Window3 { output, stride, .. }, channels, filters, groups, .. } = self.sizes;
        let (step, row) = (stride[2] * channels, output[2] * filters);
        let (pairs, rest) = work.split_at_mut(self.floats.padded_len());
        let pairs_of_dy = &mut rest[..self.dy_len()];
        pair_with_later(step, &padded[..pairs.len()], pairs);
        let lines = pairs_of_dy.chunks_exact_mut(output[2].div_ceil(2) * filters);
        for (dy, to) in dy[..self.sizes.y_len()].chunks_exact(row).zip(lines) {
            pair_rows(output[2], filters, filters, dy, to);
        }
        let [inner, out] = self.sizes.of_group();
        let (taps, run) = self.floats.taps();
        for group in 0..groups {
            for columns in pair_columns(out) {
                let most = even(run, columns.rows());
                for &(tap, weights) in taps {
                    for m in (0..run).step_by(most) {
                        let rows = most.min(run - m);
                        let c = group * self.sizes.depth() * out + weights + m * out + columns.from;
                        let tile = Tile {
                            a: pairs[tap + group * inner + m..].as_ptr(),
                            a_row: 1,
                            a_step: 2 * step,
                            b: pairs_of_dy[group * out + columns.from..].as_ptr(),
                            b_row: filters,
                            c: dweight[c..].as_mut_ptr(),
                            c_row: out,
                            segments: &self.starts,
                            run: output[2].div_ceil(2),
                            start: Start::Add,
                            last: columns.last,
                            addend: None,
                            rectifier: Rectifier::None,
                        };
                        // SAFETY: at every second output position of a row, `tap + m + rows` lies under its window
                        // and so inside the padded input, which has a pair for each of its values; `b` walks the
                        // rows of pairs of `dy`; `c` covers `rows` weights of these filters. The lengths are
                        // asserted above, `dweight` is borrowed exclusively. `pair_columns` asserts the features.
                        unsafe { columns.kernel(rows)(&tile) };
                    }
                }
            }
        }
    }
}
