//! Convolution by every product of its definition, in blocks of neighbouring outputs × filters that are held
//! in registers (`tile.rs`).
//!
//! Channels lie innermost, so the input under one row of the kernel is one stretch of memory (under one value
//! of the row where it is dilated), read where it lies in the padded image. The weights' gradient is the same loop over positions.

use std::ops::Range;

use crate::lengths::{at_least, exactly, image};
use crate::tile::{ColumnBlock, Start, Tile, columns, columns_of, even};
use crate::view::Rectifier;
use crate::window::Window3;

use super::begin::Begin;
use super::sizes::ConvSizes;

/// The plan: which stretches of the padded input meet which weights.
#[derive(Debug, Clone)]
pub(crate) struct Direct {
    sizes: ConvSizes,
    /// Values of the padded input.
    padded_len: usize,
    /// Offsets (input, weights) of the stretches under one window; first the whole window, then what is
    /// left of it over an edge.
    taps: Vec<Vec<(usize, usize)>>,
    /// Products of such a stretch, and values of the input from one to the next.
    run: usize,
    step: usize,
    weight_len: usize,
    /// Every row of outputs.
    lines: Vec<ConvRow>,
    /// Where they start, in input and output.
    starts: Vec<(usize, usize)>,
    /// Whether values of the input, and weights, are pairs of bf16.
    paired: bool,
}

/// A row of outputs.
#[derive(Debug, Clone)]
struct ConvRow {
    /// Where its input starts.
    from: usize,
    /// Where it starts itself.
    to: usize,
    /// Number of its list of taps.
    taps: usize,
}

impl Direct {
    pub fn new(sizes: ConvSizes) -> Self {
        let ConvSizes { window, dilation, channels, filters, groups } = sizes;
        let Window3 { output, kernel, stride, .. } = window;
        let padded = sizes.reach();
        let [inner, out] = sizes.of_group();
        let joined = groups == 1 && dilation[2] == 1;
        let (run, steps) = if joined { (kernel[2] * channels, 1) } else { (inner, kernel[2]) };
        let offset = sizes.offsets(padded);
        let under = |rows: &Range<usize>, depths: &Range<usize>| {
            let mut taps = vec![];
            for kd in depths.clone() {
                for kr in rows.clone() {
                    for kc in 0..steps {
                        let number = (kd * kernel[1] + kr) * steps + kc;
                        taps.push((offset([kd, kr, kc]) * channels, number * run * out));
                    }
                }
            }
            taps
        };
        // Rows of the kernel that lie in the halo for a whole line are left out.
        let mut cuts = vec![[0..kernel[1], 0..kernel[0]]];
        let lines: Vec<ConvRow> = (0..output[0] * output[1])
            .map(|line| {
                let (d, r) = (line / output[1], line % output[1]);
                let position = (d * stride[0] * padded[1] + r * stride[1]) * padded[2];
                let cut = [sizes.inside(1, r).0, sizes.inside(0, d).0];
                let taps = cuts.iter().position(|c| *c == cut).unwrap_or_else(|| {
                    cuts.push(cut);
                    cuts.len() - 1
                });
                ConvRow { from: position * channels, to: line * output[2] * filters, taps }
            })
            .collect();
        let taps = cuts.iter().map(|[rows, depths]| under(rows, depths)).collect();
        let starts = lines.iter().map(|line| (line.from, line.to)).collect();
        let (padded_len, weight_len) = (image(padded, channels), sizes.weight_len());
        Direct { sizes, padded_len, taps, run, step: 1, weight_len, lines, starts, paired: false }
    }

    /// Makes the plan for outputs of pairs of bf16, of which `sizes` counts the channels; its
    /// [`Direct::backward_weight`] has no meaning.
    pub fn paired(sizes: ConvSizes) -> Self {
        Direct { paired: true, ..Direct::new(sizes) }
    }

    /// Makes the plan for outputs of pairs of bf16 across channels: of every value with the next one. None where the values under a row
    /// of the kernel are no single stretch. Its [`Direct::backward_weight`] has no meaning.
    pub fn paired_along(sizes: ConvSizes) -> Option<Self> {
        if sizes.groups > 1 || sizes.dilation[2] > 1 {
            return None;
        }
        let mut plan = Direct::new(sizes);
        let half = plan.run.div_ceil(2);
        plan.taps.iter_mut().flatten().for_each(|(_, weights)| *weights = *weights / plan.run * half);
        let weight_len = plan.weight_len / plan.run * half;
        Some(Direct { run: half, step: 2, weight_len, paired: true, ..plan })
    }

    /// Checks whether pairs are of neighbouring values of a row, in place of channels.
    pub fn is_along(&self) -> bool {
        self.step == 2
    }

    /// Returns where the rows of outputs start, in the padded input and the output.
    pub fn starts(&self) -> &[(usize, usize)] {
        &self.starts
    }

    /// Returns the stretches under a whole window, and their length.
    pub fn taps(&self) -> (&[(usize, usize)], usize) {
        (&self.taps[0], self.run)
    }

    pub fn padded_len(&self) -> usize {
        self.padded_len
    }

    pub fn y_len(&self) -> usize {
        self.sizes.y_len()
    }

    pub fn weight_len(&self) -> usize {
        self.weight_len
    }

    /// Computes `y` from a padded image.
    pub fn forward(&self, padded: &[f32], weight: &[f32], begin: Begin, y: &mut [f32]) {
        at_least("padded input of a convolution", padded.len(), self.padded_len);
        at_least("weights of a convolution", weight.len(), self.weight_len());
        at_least("output of a convolution", y.len(), self.y_len());
        if let Begin::Bias(bias) = begin {
            exactly("bias of a convolution", bias.len(), self.sizes.filters);
        }
        let [_, out] = self.sizes.of_group();
        let block = |group: usize, columns: &ColumnBlock, y: &mut [f32]| {
            let filter = group * out + columns.from;
            let start = match begin {
                Begin::Zero => Start::Zero,
                Begin::Add => Start::Add,
                Begin::Bias(bias) => Start::Bias(bias[filter..].as_ptr()),
            };
            // SAFETY: `columns` are some of the group's filters; the lengths of `padded`, `weight` and
            // `y` are asserted above, and so is one bias per filter.
            unsafe { self.output_blocks(group, columns, start, padded, weight, y) };
        };
        for group in 0..self.sizes.groups {
            columns_of(out, self.paired).for_each(|columns| block(group, &columns, y));
        }
    }

    /// Computes some filters of one group, at all positions.
    ///
    /// # Safety
    /// `columns` lie inside a group's filters. `padded` holds `padded_len` values, `weight` `weight_len` ones and `y` those of
    /// `sizes`; a bias in `start` is valid for the columns.
    unsafe fn output_blocks(
        &self,
        group: usize,
        columns: &ColumnBlock,
        start: Start,
        padded: &[f32],
        weight: &[f32],
        y: &mut [f32],
    ) {
        let ConvSizes { window: Window3 { output, stride, .. }, channels, filters, .. } = self.sizes;
        let [inner, out] = self.sizes.of_group();
        let most = even(output[2], columns.rows());
        for line in &self.lines {
            for column in (0..output[2]).step_by(most) {
                let rows = most.min(output[2] - column);
                let a = line.from + column * stride[2] * channels + group * inner;
                let b = group * self.sizes.depth() * out + columns.from;
                let c = line.to + column * filters + group * out + columns.from;
                let tile = Tile {
                    a: padded[a..].as_ptr(),
                    a_row: stride[2] * channels,
                    a_step: self.step,
                    b: weight[b..].as_ptr(),
                    b_row: out,
                    c: y[c..].as_mut_ptr(),
                    c_row: filters,
                    segments: &self.taps[line.taps],
                    run: self.run,
                    start,
                    last: columns.last,
                    addend: None,
                    rectifier: Rectifier::None,
                };
                // SAFETY: the last value that `a` reaches, a window's last tap (rows - 1) strides further, is
                // at most the last of the padded input, whose size `ConvSizes::reach` gives by just these
                // positions; of pairs along the stretch the last begins at or before it. `b` walks the weights of this
                // group; `c` covers `rows` outputs of these filters. The caller guarantees the lengths and the bias;
                // `y` is borrowed exclusively.
                unsafe { columns.kernel(rows)(&tile) };
            }
        }
    }

    /// Adds the gradient of the weights to `dweight`, block by block of it.
    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], dweight: &mut [f32]) {
        at_least("padded input of a convolution", padded.len(), self.padded_len);
        at_least("dy of a convolution", dy.len(), self.y_len());
        at_least("weight gradient of a convolution", dweight.len(), self.weight_len());
        let ConvSizes { window: Window3 { output, stride, .. }, channels, filters, groups, .. } = self.sizes;
        let [inner, out] = self.sizes.of_group();
        for group in 0..groups {
            for columns in columns(out) {
                let most = even(self.run, columns.rows());
                for &(tap, weights) in &self.taps[0] {
                    for m in (0..self.run).step_by(most) {
                        let rows = most.min(self.run - m);
                        let c = group * self.sizes.depth() * out + weights + m * out + columns.from;
                        let tile = Tile {
                            a: padded[tap + group * inner + m..].as_ptr(),
                            a_row: 1,
                            a_step: stride[2] * channels,
                            b: dy[group * out + columns.from..].as_ptr(),
                            b_row: filters,
                            c: dweight[c..].as_mut_ptr(),
                            c_row: out,
                            segments: &self.starts,
                            run: output[2],
                            start: Start::Add,
                            last: columns.last,
                            addend: None,
                            rectifier: Rectifier::None,
                        };
                        // SAFETY: at every output position, `tap + m + rows` lies under its window and so
                        // inside the padded input; `b` walks the rows of `dy`; `c` covers `rows` weights of
                        // these filters. The three lengths are asserted above, `dweight` is borrowed
                        // exclusively.
                        unsafe { columns.kernel(rows)(&tile) };
                    }
                }
            }
        }
    }
}
