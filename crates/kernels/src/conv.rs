//! Convolution over up to three spatial axes, one image at a time.
//!
//! Channels lie innermost, so the input under one row of the kernel is one stretch of memory. A block of
//! neighbouring outputs × filters is held in registers (`tile.rs`) and reads the halo-padded input where
//! it lies. With a stride of 1 the input gradient is the same convolution with the kernel turned round;
//! the weight gradient is the same loop over positions. Kernels that are 3 long and see many channels need
//! fewer products (`winograd`).
//!
//! Weights lie as group × kernel × channels in × channels out. Where every channel is a group of its own
//! (`depthwise.rs`), they lie as kernel × channels.

use std::cell::RefCell;
use std::ops::Range;

use crate::Window3;
use crate::depthwise;
use crate::matmul::{Matrix, matmul};
use crate::tile::{Start, Tile, columns, even};
use crate::view::View;
use crate::winograd::{Begin, Winograd};

/// A convolution with its plan.
#[derive(Debug, Clone)]
pub struct Conv {
    window: Window3,
    channels: usize,
    filters: usize,
    groups: usize,
    /// Size of the input with its halo, as far as windows reach.
    padded: [usize; 3],
    /// Offsets (input, weights) of the stretches under one window; first the whole window, then what is
    /// left of it over an edge.
    taps: Vec<Vec<(usize, usize)>>,
    /// Length of such a stretch.
    run: usize,
    /// Every row of outputs.
    lines: Vec<Line>,
    /// Where they start, in input and output.
    starts: Vec<(usize, usize)>,
    /// The input gradient as a convolution, where it is one.
    turned: Option<Box<Conv>>,
    /// The plan with fewer products, where it pays.
    winograd: Option<Winograd>,
}

/// Some rows of outputs, or all of them.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    from: usize,
    rows: usize,
    /// Rows of the padded input under it, over all depths.
    under: (usize, usize),
}

/// The input under a band, as the kernel reads it; made by [`Conv::pad`].
#[derive(Debug, Clone, Copy)]
pub struct Padded<'a> {
    values: &'a [f32],
    band: Band,
}

/// Values of padded input that stay in a core's own cache, beside the outputs.
const BAND: usize = 1 << 17;

/// A row of outputs.
#[derive(Debug, Clone)]
struct Line {
    /// Where its input starts.
    from: usize,
    /// Where it starts itself.
    to: usize,
    /// Number of its list of taps.
    taps: usize,
}

thread_local! {
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

impl Conv {
    /// A convolution of `channels` into `filters`; `groups` divides both.
    pub fn new(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        let pays = Winograd::pays(&window, channels, filters);
        Self::with(window, channels, filters, groups, pays)
    }

    /// The same by the definition's own products, whatever the sizes.
    pub fn direct(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        Self::with(window, channels, filters, groups, false)
    }

    /// The same with fewer products wherever the window allows, even where that does not pay.
    pub fn winograd(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        Self::with(window, channels, filters, groups, true)
    }

    fn with(window: Window3, channels: usize, filters: usize, groups: usize, fewer: bool) -> Self {
        let mut conv = Self::forward_only(window, channels, filters, groups, fewer);
        let Window3 { kernel, before, stride, input, output } = conv.window;
        let turnable = stride == [1; 3] && (0..3).all(|a| before[a] < kernel[a]);
        if turnable {
            let before = std::array::from_fn(|a| kernel[a] - 1 - before[a]);
            let window = Window3 { input: output, output: input, kernel, stride, before };
            conv.turned = Some(Box::new(Self::forward_only(window, filters, channels, groups, fewer)));
        }
        conv
    }

    fn forward_only(
        mut window: Window3,
        channels: usize,
        filters: usize,
        groups: usize,
        fewer: bool,
    ) -> Self {
        assert!(groups > 0 && channels.is_multiple_of(groups) && filters.is_multiple_of(groups));
        if window.is_identity() {
            // One long row makes longer blocks than many short ones.
            let positions = window.input_len();
            window.input = [1, 1, positions];
            window.output = window.input;
        }
        let Window3 { output, kernel, stride, .. } = window;
        let mut padded: [usize; 3] = std::array::from_fn(|a| (output[a] - 1) * stride[a] + kernel[a]);
        let winograd = (fewer && groups == 1).then(|| Winograd::new(&window, channels, filters)).flatten();
        if let Some(winograd) = &winograd {
            padded = winograd.padded(padded);
        }
        let inner = channels / groups;
        let (run, steps) = if groups == 1 { (kernel[2] * channels, 1) } else { (inner, kernel[2]) };
        let under = |rows: &Range<usize>, depths: &Range<usize>| {
            let mut taps = vec![];
            for kd in depths.clone() {
                for kr in rows.clone() {
                    for kc in 0..steps {
                        let position = (kd * padded[1] + kr) * padded[2] + kc;
                        let number = (kd * kernel[1] + kr) * steps + kc;
                        taps.push((position * channels, number * run * (filters / groups)));
                    }
                }
            }
            taps
        };
        // Rows of the kernel that lie in the halo for a whole line are left out.
        let mut cuts = vec![[0..kernel[1], 0..kernel[0]]];
        let lines: Vec<Line> = (0..output[0] * output[1])
            .map(|line| {
                let (d, r) = (line / output[1], line % output[1]);
                let position = (d * stride[0] * padded[1] + r * stride[1]) * padded[2];
                let cut = [window.inside(1, r).0, window.inside(0, d).0];
                let taps = cuts.iter().position(|c| *c == cut).unwrap_or_else(|| {
                    cuts.push(cut);
                    cuts.len() - 1
                });
                Line { from: position * channels, to: line * output[2] * filters, taps }
            })
            .collect();
        let taps = cuts.iter().map(|[rows, depths]| under(rows, depths)).collect();
        let starts = lines.iter().map(|line| (line.from, line.to)).collect();
        Conv { window, channels, filters, groups, padded, taps, run, lines, starts, turned: None, winograd }
    }

    /// Whether every channel is a group of its own.
    fn is_depthwise(&self) -> bool {
        self.groups > 1 && self.groups == self.channels && self.groups == self.filters
    }

    /// Values of one input image.
    pub fn x_len(&self) -> usize {
        self.window.input_len() * self.channels
    }

    /// Values of one output image.
    pub fn y_len(&self) -> usize {
        self.window.output_len() * self.filters
    }

    /// Kernel values that meet in one output value.
    fn depth(&self) -> usize {
        self.window.volume() * self.channels / self.groups
    }

    /// Number of weights.
    pub fn weight_len(&self) -> usize {
        self.depth() * self.filters
    }

    /// Multiply–accumulates of one image.
    pub fn macs(&self) -> usize {
        self.window.output_len() * self.weight_len()
    }

    /// Values of one input image with its halo; what [`Conv::pad`] fills at most.
    pub fn padded_len(&self) -> usize {
        self.padded.iter().product::<usize>() * self.channels
    }

    /// The pieces in which passes over an image go best: kernels with few products per value wait for
    /// memory where the padded image does not stay in cache.
    pub fn bands(&self) -> impl Iterator<Item = Band> + use<> {
        let Window3 { output, kernel, stride, .. } = self.window;
        let row = self.padded[2] * self.channels;
        let lines = self.padded[0] * self.padded[1];
        let cut = self.is_depthwise() && output[0] == 1 && kernel[0] == 1 && lines * row > BAND;
        let most = match cut {
            true => ((BAND / row).saturating_sub(kernel[1]) / stride[1] + 1).min(output[1]),
            false => output[1],
        };
        (0..output[1]).step_by(most).map(move |from| {
            let rows = most.min(output[1] - from);
            let under = match cut {
                true => (from * stride[1], (rows - 1) * stride[1] + kernel[1]),
                false => (0, lines),
            };
            Band { from, rows, under }
        })
    }

    /// The input of a band as the kernel reads it: seen through `view`, with a halo of zeros. Borrows `x`
    /// itself where that is the same.
    pub fn pad<'a>(&self, x: &'a [f32], view: &View, band: Band, scratch: &'a mut [f32]) -> Padded<'a> {
        let x = &x[..self.x_len()];
        let Window3 { input, before, .. } = self.window;
        let c = self.channels;
        let row_len = self.padded[2] * c;
        let (first, count) = band.under;
        if view.is_plain() && self.padded == input && before == [0; 3] {
            return Padded { values: &x[first * row_len..(first + count) * row_len], band };
        }
        let scratch = &mut scratch[..count * row_len];
        // Columns of the input that windows reach; a stride may leave some out at the end.
        let left = before[2].min(self.padded[2]);
        let kept = input[2].min(self.padded[2] - left);
        let lines = scratch.chunks_exact_mut(row_len);
        for (line, to) in (first..).zip(lines) {
            let (d, r) = (line / self.padded[1], line % self.padded[1]);
            let from = d.checked_sub(before[0]).zip(r.checked_sub(before[1]));
            match from.filter(|&(d, r)| d < input[0] && r < input[1]) {
                Some((d, r)) => {
                    let from = (d * input[1] + r) * input[2] * c;
                    to[..left * c].fill(0.0);
                    view.apply(c, &x[from..from + kept * c], &mut to[left * c..(left + kept) * c]);
                    to[(left + kept) * c..].fill(0.0);
                }
                None => to.fill(0.0),
            }
        }
        Padded { values: scratch, band }
    }

    /// A band as a window of its own, the size of its padded input, and where its outputs lie.
    fn cut(&self, band: Band) -> (Window3, [usize; 3], Range<usize>) {
        let Window3 { output, .. } = self.window;
        let window = Window3 { output: [output[0], band.rows, output[2]], ..self.window };
        let is_whole = band.rows == output[1];
        let padded = if is_whole { self.padded } else { [1, band.under.1, self.padded[2]] };
        let row = output[2] * self.filters;
        let outputs = if is_whole { 0..self.y_len() } else { band.from * row..(band.from + band.rows) * row };
        (window, padded, outputs)
    }

    /// Weights as [`Conv::forward`] wants them; empty where it wants them as they are.
    pub fn pack(&self, weight: &[f32], packed: &mut Vec<f32>) {
        packed.clear();
        if let Some(winograd) = &self.winograd {
            packed.resize(winograd.weight_len(), 0.0);
            winograd.pack(weight, packed);
        }
    }

    /// Values of scratch that the passes need besides [`Conv::padded_len`].
    pub fn work_len(&self) -> usize {
        self.winograd.as_ref().map_or(0, Winograd::work_len)
    }

    /// `y = conv(x) + bias` of a band; `padded` comes from [`Conv::pad`], `packed` from [`Conv::pack`].
    pub fn forward(
        &self,
        padded: Padded,
        weight: &[f32],
        packed: &[f32],
        bias: Option<&[f32]>,
        y: &mut [f32],
        work: &mut [f32],
    ) {
        if let Some(bias) = bias {
            assert_eq!(bias.len(), self.filters, "one bias per filter");
        }
        let Padded { values: padded, band } = padded;
        if let Some(winograd) = &self.winograd {
            winograd.forward(padded, packed, bias.map_or(Begin::Zero, Begin::Bias), y, work);
            return;
        }
        if self.is_depthwise() {
            let (bias, (window, size, outputs)) = (bias.unwrap_or_default(), self.cut(band));
            let y = &mut y[outputs];
            depthwise::forward(&window, size, self.channels, padded, weight, bias, y, false);
            return;
        }
        self.blocks(padded, weight, y, |f| match bias {
            Some(bias) => Start::Bias(bias[f..].as_ptr()),
            None => Start::Zero,
        });
    }

    /// Every block of outputs: positions along a row × filters.
    pub(crate) fn blocks(
        &self,
        padded: &[f32],
        weight: &[f32],
        y: &mut [f32],
        start: impl Fn(usize) -> Start,
    ) {
        assert!(padded.len() >= self.padded_len() && weight.len() >= self.weight_len());
        assert!(y.len() >= self.y_len(), "an output image");
        let Window3 { output, stride, .. } = self.window;
        let (inner, out) = (self.channels / self.groups, self.filters / self.groups);
        for group in 0..self.groups {
            for columns in columns(out) {
                let f = columns.from;
                let most = even(output[2], columns.rows());
                for line in &self.lines {
                    for column in (0..output[2]).step_by(most) {
                        let rows = most.min(output[2] - column);
                        let a = line.from + column * stride[2] * self.channels + group * inner;
                        let b = group * self.depth() * out + f;
                        let c = line.to + column * self.filters + group * out + f;
                        let tile = Tile {
                            a: padded[a..].as_ptr(),
                            a_row: stride[2] * self.channels,
                            a_step: 1,
                            b: weight[b..].as_ptr(),
                            b_row: out,
                            c: y[c..].as_mut_ptr(),
                            c_row: self.filters,
                            segments: &self.taps[line.taps],
                            run: self.run,
                            start: start(group * out + f),
                            last: columns.last,
                        };
                        // SAFETY: `a` + a window's last tap + (rows - 1) strides ends inside the padded
                        // input, whose size was made from exactly these positions; `b` walks the weights
                        // of this group; `c` covers `rows` outputs of `width` filters; the three slices
                        // are as long as asserted, and `y` is borrowed exclusively.
                        unsafe { columns.kernel(rows)(&tile) };
                    }
                }
            }
        }
    }

    /// Weights as [`Conv::backward_input`] wants them: turned round, channels in and out exchanged.
    /// Empty where it wants them as they are.
    pub fn turn(&self, weight: &[f32], turned: &mut Vec<f32>) {
        turned.clear();
        let Some(conv) = &self.turned else { return };
        let packed = conv.winograd.as_ref().map_or(0, Winograd::weight_len);
        turned.resize(packed + self.weight_len(), 0.0);
        let (packed, turned) = turned.split_at_mut(packed);
        self.turn_round(weight, turned);
        if let Some(winograd) = &conv.winograd {
            winograd.pack(turned, packed);
        }
    }

    fn turn_round(&self, weight: &[f32], turned: &mut [f32]) {
        if self.is_depthwise() {
            let taps = weight[..self.weight_len()].chunks_exact(self.channels);
            for (to, from) in turned.chunks_exact_mut(self.channels).rev().zip(taps) {
                to.copy_from_slice(from);
            }
            return;
        }
        let (volume, inner, out) =
            (self.window.volume(), self.channels / self.groups, self.filters / self.groups);
        let block = inner * out;
        for (i, from) in weight[..self.weight_len()].chunks_exact(block).enumerate() {
            let (group, k) = (i / volume, i % volume);
            let to = (group * volume + volume - 1 - k) * block;
            crate::layout::transpose(inner, out, from, &mut turned[to..to + block], false);
        }
    }

    /// Values of scratch that [`Conv::backward_input`] needs.
    pub fn backward_len(&self) -> usize {
        self.turned.as_ref().map_or(0, |t| t.padded_len() + t.work_len())
    }

    /// Gradient of the input as it was seen, written to or added to `dx`.
    pub fn backward_input(
        &self,
        dy: &[f32],
        weight: &[f32],
        turned: &[f32],
        scratch: &mut [f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let dx = &mut dx[..self.x_len()];
        match &self.turned {
            Some(conv) => {
                let (scratch, work) = scratch.split_at_mut(conv.padded_len());
                for band in conv.bands() {
                    let padded = conv.pad(dy, &View::default(), band, scratch).values;
                    if let Some(winograd) = &conv.winograd {
                        let start = if accumulate { Begin::Add } else { Begin::Zero };
                        winograd.forward(padded, turned, start, dx, work);
                    } else if self.is_depthwise() {
                        let (window, size, outputs) = conv.cut(band);
                        let dx = &mut dx[outputs];
                        depthwise::forward(&window, size, self.channels, padded, turned, &[], dx, accumulate);
                    } else {
                        let start = |_| if accumulate { Start::Add } else { Start::Zero };
                        conv.blocks(padded, turned, dx, start);
                    }
                }
            }
            None => {
                if !accumulate {
                    dx.fill(0.0);
                }
                if self.is_depthwise() {
                    depthwise::scatter(&self.window, self.channels, &dy[..self.y_len()], weight, dx);
                } else {
                    self.scatter(dy, weight, dx);
                }
            }
        }
    }

    /// Values of the sums that [`Conv::backward_weight`] adds to, without the bias.
    pub fn sums_len(&self) -> usize {
        self.winograd.as_ref().map_or(self.weight_len(), Winograd::weight_len)
    }

    /// Adds the gradient of the weights, from the sums over all images.
    pub fn finish(&self, sums: &[f32], dweight: &mut [f32]) {
        match &self.winograd {
            Some(winograd) => winograd.unpack(sums, dweight),
            None => crate::pointwise::copy(&sums[..self.weight_len()], dweight, true),
        }
    }

    /// Adds the gradients of weights (to `sums`, see [`Conv::finish`]) and bias of a band; `padded` comes
    /// from [`Conv::pad`].
    pub fn backward_weight(
        &self,
        padded: Padded,
        dy: &[f32],
        sums: &mut [f32],
        dbias: Option<&mut [f32]>,
        work: &mut [f32],
    ) {
        let Padded { values: padded, band } = padded;
        let (window, size, outputs) = self.cut(band);
        if let Some(dbias) = dbias {
            crate::reduce::add_columns(self.filters, &dy[outputs.clone()], dbias);
        }
        if let Some(winograd) = &self.winograd {
            winograd.backward_weight(padded, dy, sums, work);
        } else if self.is_depthwise() {
            depthwise::backward_weight(&window, size, self.channels, padded, &dy[outputs], sums);
        } else {
            self.weight_blocks(padded, dy, sums);
        }
    }

    /// Adds the gradients of the weights to `dweight`, block by block of it.
    pub(crate) fn weight_blocks(&self, padded: &[f32], dy: &[f32], dweight: &mut [f32]) {
        assert!(padded.len() >= self.padded_len() && dweight.len() >= self.weight_len());
        assert!(dy.len() >= self.y_len(), "a gradient image");
        let Window3 { output, stride, .. } = self.window;
        let (inner, out) = (self.channels / self.groups, self.filters / self.groups);
        for group in 0..self.groups {
            for columns in columns(out) {
                let most = even(self.run, columns.rows());
                for &(tap, weights) in &self.taps[0] {
                    for m in (0..self.run).step_by(most) {
                        let rows = most.min(self.run - m);
                        let c = group * self.depth() * out + weights + m * out + columns.from;
                        let tile = Tile {
                            a: padded[tap + group * inner + m..].as_ptr(),
                            a_row: 1,
                            a_step: stride[2] * self.channels,
                            b: dy[group * out + columns.from..].as_ptr(),
                            b_row: self.filters,
                            c: dweight[c..].as_mut_ptr(),
                            c_row: out,
                            segments: &self.starts,
                            run: output[2],
                            start: Start::Add,
                            last: columns.last,
                        };
                        // SAFETY: for every output position, tap + m + rows lies under its window and so
                        // inside the padded input; `b` walks the rows of `dy`; `c` covers `rows` weights
                        // of `width` filters; lengths are asserted, `dweight` is borrowed exclusively.
                        unsafe { columns.kernel(rows)(&tile) };
                    }
                }
            }
        }
    }

    /// Input gradient where windows do not overlap regularly: a patch of gradients per block of
    /// positions, added back to where it was read.
    fn scatter(&self, dy: &[f32], weight: &[f32], dx: &mut [f32]) {
        let Window3 { input, kernel, .. } = self.window;
        let (depth, out, inner) = (self.depth(), self.filters / self.groups, self.channels / self.groups);
        let positions = self.window.output_len();
        let block = (64 * 1024 / depth).clamp(8, 1024);
        SCRATCH.with_borrow_mut(|patch| {
            for from in (0..positions).step_by(block) {
                let to = (from + block).min(positions);
                patch.resize((to - from) * depth, 0.0);
                for group in 0..self.groups {
                    let dy = &dy[from * self.filters + group * out..to * self.filters];
                    let dy = Matrix::strided(dy, to - from, out, self.filters);
                    let weight = &weight[group * depth * out..(group + 1) * depth * out];
                    matmul(patch, depth, dy, Matrix::new(weight, depth, out).t(), false);
                    for position in from..to {
                        let [d, r, c] = self.window.unravel(position);
                        let (depths, first_d) = self.window.inside(0, d);
                        let (rows, first_r) = self.window.inside(1, r);
                        let (columns, first_c) = self.window.inside(2, c);
                        for kd in depths.clone() {
                            for kr in rows.clone() {
                                let line =
                                    (first_d + kd - depths.start) * input[1] + first_r + kr - rows.start;
                                let tap = (kd * kernel[1] + kr) * kernel[2] + columns.start;
                                let mut from = (position - from) * depth + tap * inner;
                                for column in first_c..first_c + columns.len() {
                                    let to = (line * input[2] + column) * self.channels + group * inner;
                                    crate::pointwise::copy(
                                        &patch[from..from + inner],
                                        &mut dx[to..to + inner],
                                        true,
                                    );
                                    from += inner;
                                }
                            }
                        }
                    }
                }
            }
        });
    }
}
