//! F(4, 3) along one axis: half the products of a kernel that is 3 long there, whatever it is elsewhere.
//!
//! For every tile of 4 outputs along the axis, the input becomes 6 images over the two other axes, each of
//! which is convolved by the definition's own products.

use crate::conv::begin::Begin;
use crate::conv::direct::Direct;
use crate::conv::sizes::ConvSizes;
use crate::lengths::{at_least, exactly};
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::window::Window3;

/// Outputs and elements of a tile.
const OUTPUTS: usize = 4;
const ELEMENTS: usize = 6;

type Matrix = [[f32; ELEMENTS]; ELEMENTS];

const fn transposed(m: &Matrix) -> Matrix {
    let mut t = [[0.0; ELEMENTS]; ELEMENTS];
    let mut i = 0;
    while i < ELEMENTS * ELEMENTS {
        t[i / ELEMENTS][i % ELEMENTS] = m[i % ELEMENTS][i / ELEMENTS];
        i += 1;
    }
    t
}

/// `Bᵀ`, for the points 0, ±1, ±2, ∞.
const INPUT: Matrix = [
    [4.0, 0.0, -5.0, 0.0, 1.0, 0.0],
    [0.0, -4.0, -4.0, 1.0, 1.0, 0.0],
    [0.0, 4.0, -4.0, -1.0, 1.0, 0.0],
    [0.0, -2.0, -1.0, 2.0, 1.0, 0.0],
    [0.0, 2.0, -1.0, -2.0, 1.0, 0.0],
    [0.0, 4.0, 0.0, -5.0, 0.0, 1.0],
];
/// `G`, three columns.
const WEIGHT: Matrix = [
    [1.0 / 4.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-1.0 / 6.0, -1.0 / 6.0, -1.0 / 6.0, 0.0, 0.0, 0.0],
    [-1.0 / 6.0, 1.0 / 6.0, -1.0 / 6.0, 0.0, 0.0, 0.0],
    [1.0 / 24.0, 1.0 / 12.0, 1.0 / 6.0, 0.0, 0.0, 0.0],
    [1.0 / 24.0, -1.0 / 12.0, 1.0 / 6.0, 0.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
];
/// `Aᵀ`, four rows.
const OUTPUT: Matrix = [
    [1.0, 1.0, 1.0, 1.0, 1.0, 0.0],
    [0.0, 1.0, -1.0, 2.0, -2.0, 0.0],
    [0.0, 1.0, 1.0, 4.0, 4.0, 0.0],
    [0.0, 1.0, -1.0, 8.0, -8.0, 1.0],
    [0.0; 6],
    [0.0; 6],
];
const WEIGHT_GRADIENT: Matrix = transposed(&WEIGHT);
const OUTPUT_GRADIENT: Matrix = transposed(&OUTPUT);

/// A convolution with stride 1 whose kernel is 3 long along `axis`, 0 or 1.
#[derive(Debug, Clone)]
pub(crate) struct WinogradLine {
    axis: usize,
    /// Outputs along the axis.
    output: usize,
    filters: usize,
    /// Convolution over the other axes.
    inner: Direct,
    /// Where values along the axis lie, in the padded input, the output and the weights.
    input_runs: Runs,
    output_runs: Runs,
    weight_runs: Runs,
}

/// An array whose axis is taken apart: `count` times `axis` stretches of `len` values.
#[derive(Debug, Clone, Copy)]
struct Runs {
    count: usize,
    axis: usize,
    len: usize,
}

impl Runs {
    fn new(size: [usize; 3], axis: usize, width: usize) -> Self {
        let count = size[..axis].iter().product();
        Runs { count, axis: size[axis], len: size[axis + 1..].iter().product::<usize>() * width }
    }

    /// Returns the number of all values at one position of the axis.
    fn slice(&self) -> usize {
        self.count * self.len
    }
}

impl WinogradLine {
    pub fn new(window: &Window3, axis: usize, channels: usize, filters: usize) -> Self {
        let flat = |size: [usize; 3], one: usize| {
            let mut size = size;
            size[axis] = one;
            size
        };
        let Window3 { input, output, kernel, stride, before } = *window;
        let inner = Window3 {
            input: flat(input, 1),
            output: flat(output, 1),
            kernel: flat(kernel, 1),
            stride,
            before: flat(before, 0),
        };
        let mut padded: [usize; 3] = std::array::from_fn(|a| output[a] + kernel[a] - 1);
        padded[axis] = output[axis].div_ceil(OUTPUTS) * OUTPUTS + 2;
        WinogradLine {
            axis,
            output: output[axis],
            filters,
            inner: Direct::new(ConvSizes::new(inner, [1; 3], channels, filters, 1)),
            input_runs: Runs::new(padded, axis, channels),
            output_runs: Runs::new(output, axis, filters),
            weight_runs: Runs::new(kernel, axis, channels * filters),
        }
    }

    pub fn padded(&self, mut padded: [usize; 3]) -> [usize; 3] {
        padded[self.axis] = self.input_runs.axis;
        padded
    }

    pub fn weight_len(&self) -> usize {
        ELEMENTS * self.inner.weight_len()
    }

    pub fn work_len(&self) -> usize {
        ELEMENTS * (self.input_runs.slice() + self.inner.y_len())
    }

    pub fn pack(&self, weight: &[f32], u: &mut [f32]) {
        let runs = self.weight_runs;
        at_least("weights of a convolution", weight.len(), runs.slice() * runs.axis);
        at_least("packed weights", u.len(), self.weight_len());
        for run in 0..runs.count {
            let from = &weight[run * runs.axis * runs.len..];
            let to = &mut u[run * runs.len..];
            combine(&WEIGHT, [ELEMENTS, 3], from, runs.len, to, runs.slice(), runs.len, false);
        }
    }

    pub fn unpack(&self, du: &[f32], dweight: &mut [f32]) {
        let runs = self.weight_runs;
        at_least("gradient of the packed weights", du.len(), self.weight_len());
        at_least("weight gradient of a convolution", dweight.len(), runs.slice() * runs.axis);
        for run in 0..runs.count {
            let from = &du[run * runs.len..];
            let to = &mut dweight[run * runs.axis * runs.len..];
            combine(&WEIGHT_GRADIENT, [3, ELEMENTS], from, runs.slice(), to, runs.len, runs.len, true);
        }
    }

    fn check(&self, padded: &[f32], y: &[f32], work: &[f32]) {
        at_least(
            "padded input of a convolution",
            padded.len(),
            self.input_runs.slice() * self.input_runs.axis,
        );
        at_least("outputs of a convolution", y.len(), self.output_runs.slice() * self.output_runs.axis);
        at_least("scratch of a convolution", work.len(), self.work_len());
    }

    /// Computes `Bᵀ d` of one tile's input: six images over the other axes.
    fn spread(&self, tile: usize, padded: &[f32], v: &mut [f32]) {
        let runs = self.input_runs;
        for run in 0..runs.count {
            let from = &padded[(run * runs.axis + tile * OUTPUTS) * runs.len..];
            let to = &mut v[run * runs.len..];
            combine(&INPUT, [ELEMENTS; 2], from, runs.len, to, runs.slice(), runs.len, false);
        }
    }

    pub fn forward(&self, padded: &[f32], u: &[f32], begin: Begin, y: &mut [f32], work: &mut [f32]) {
        let (image, weights) = (self.inner.y_len(), self.inner.weight_len());
        at_least("packed weights", u.len(), self.weight_len());
        self.check(padded, y, work);
        let (v, m) = work.split_at_mut(ELEMENTS * self.input_runs.slice());
        let m = &mut m[..ELEMENTS * image];
        let runs = self.output_runs;
        if let Begin::Bias(bias) = begin {
            exactly("bias of a convolution", bias.len(), self.filters);
            y[..runs.slice() * runs.axis]
                .chunks_exact_mut(self.filters)
                .for_each(|y| y.copy_from_slice(bias));
        }
        let add = !matches!(begin, Begin::Zero);
        for tile in 0..self.output.div_ceil(OUTPUTS) {
            self.spread(tile, padded, v);
            let elements = v.chunks_exact(self.input_runs.slice()).zip(m.chunks_exact_mut(image));
            for ((v, m), u) in elements.zip(u.chunks_exact(weights)) {
                self.inner.forward(v, u, Begin::Zero, m);
            }
            let outputs = OUTPUTS.min(self.output - tile * OUTPUTS);
            for run in 0..runs.count {
                let from = &m[run * runs.len..];
                let to = &mut y[(run * runs.axis + tile * OUTPUTS) * runs.len..];
                combine(&OUTPUT, [outputs, ELEMENTS], from, image, to, runs.len, runs.len, add);
            }
        }
    }

    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], du: &mut [f32], work: &mut [f32]) {
        let (image, weights) = (self.inner.y_len(), self.inner.weight_len());
        at_least("gradient of the packed weights", du.len(), self.weight_len());
        self.check(padded, dy, work);
        let (v, w) = work.split_at_mut(ELEMENTS * self.input_runs.slice());
        let w = &mut w[..ELEMENTS * image];
        let runs = self.output_runs;
        for tile in 0..self.output.div_ceil(OUTPUTS) {
            self.spread(tile, padded, v);
            let outputs = OUTPUTS.min(self.output - tile * OUTPUTS);
            for run in 0..runs.count {
                let from = &dy[(run * runs.axis + tile * OUTPUTS) * runs.len..];
                let to = &mut w[run * runs.len..];
                combine(&OUTPUT_GRADIENT, [ELEMENTS, outputs], from, runs.len, to, image, runs.len, false);
            }
            let elements = v.chunks_exact(self.input_runs.slice()).zip(w.chunks_exact(image));
            for ((v, w), du) in elements.zip(du.chunks_exact_mut(weights)) {
                self.inner.backward_weight(v, w, du);
            }
        }
    }
}

at_level! {
    /// Computes `to[i] = Σ m[i][j] · from[j]`, written or added: stretches of `len` values, `size` = (i, j) of them,
    /// that lie `from_step` and `to_step` apart.
    fn combine(
        m: &Matrix, size: [usize; 2], from: &[f32], from_step: usize, to: &mut [f32], to_step: usize,
        len: usize, add: bool,
    ) = combine_at
}

/// Computes [`combine`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::too_many_arguments, clippy::needless_range_loop)]
#[inline(always)]
unsafe fn combine_at<S: Simd>(
    m: &Matrix,
    [rows, columns]: [usize; 2],
    from: &[f32],
    from_step: usize,
    to: &mut [f32],
    to_step: usize,
    len: usize,
    add: bool,
) {
    assert!(
        (1..=ELEMENTS).contains(&rows) && (1..=ELEMENTS).contains(&columns),
        "1 to 6 stretches are needed"
    );
    at_least("stretches to combine", from.len(), (columns - 1) * from_step + len);
    at_least("combined stretches", to.len(), (rows - 1) * to_step + len);
    vectors!(S, len, c, n, {
        // SAFETY: `c + n <= len`, and `len` values from the last of `columns` stretches of `from` and `rows`
        // of `to` on are asserted to be there.
        unsafe {
            let mut x = [S::splat(0.0); ELEMENTS];
            for j in 0..ELEMENTS {
                if j < columns {
                    x[j] = load::<S>(from, j * from_step + c, n);
                }
            }
            for i in 0..ELEMENTS {
                if i < rows {
                    let at = i * to_step + c;
                    let mut sum = if add { load::<S>(to, at, n) } else { S::splat(0.0) };
                    for j in 0..ELEMENTS {
                        sum = S::fma(S::splat(m[i][j]), x[j], sum);
                    }
                    store::<S>(to, at, n, sum);
                }
            }
        }
    });
}
