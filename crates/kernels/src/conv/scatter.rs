//! The input gradient where windows do not move by single steps: a patch of gradients per block of positions,
//! added back to where the windows read.

use std::cell::RefCell;

use crate::half;
use crate::lengths::at_least;
use crate::matmul::{Matrix, matmul};
use crate::pointwise;

use super::sizes::ConvSizes;

thread_local! {
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

/// Adds the input gradient to `dx`, with products of bf16 where it is `paired`.
pub(crate) fn scatter(sizes: &ConvSizes, paired: bool, dy: &[f32], weight: &[f32], dx: &mut [f32]) {
    let product = if paired { half::multiply } else { matmul };
    at_least("dy of a convolution", dy.len(), sizes.y_len());
    at_least("weights of a convolution", weight.len(), sizes.weight_len());
    at_least("dx of a convolution", dx.len(), sizes.x_len());
    let (depth, filters, [_, out]) = (sizes.depth(), sizes.filters, sizes.of_group());
    let positions = sizes.window.output_len();
    let block = (64 * 1024 / depth).clamp(8, 1024);
    SCRATCH.with_borrow_mut(|patch| {
        for from in (0..positions).step_by(block) {
            let to = (from + block).min(positions);
            patch.resize((to - from) * depth, 0.0);
            for group in 0..sizes.groups {
                let dy = &dy[from * filters + group * out..to * filters];
                let dy = Matrix::strided(dy, to - from, out, filters);
                let weight = &weight[group * depth * out..(group + 1) * depth * out];
                product(patch, depth, dy, Matrix::new(weight, depth, out).t(), false);
                for (position, patch) in (from..to).zip(patch.chunks_exact(depth)) {
                    add_patch(sizes, group, position, patch, dx);
                }
            }
        }
    });
}

/// Adds the gradients under one window, kernel × channels of a group, to where they belong.
fn add_patch(sizes: &ConvSizes, group: usize, position: usize, patch: &[f32], dx: &mut [f32]) {
    let (window, dilation, [inner, _]) = (&sizes.window, sizes.dilation, sizes.of_group());
    let [d, r, c] = window.unravel(position);
    let (depths, first_d) = sizes.inside(0, d);
    let (rows, first_r) = sizes.inside(1, r);
    let (columns, first_c) = sizes.inside(2, c);
    for kd in depths.clone() {
        for kr in rows.clone() {
            let depth = first_d + (kd - depths.start) * dilation[0];
            let line = depth * window.input[1] + first_r + (kr - rows.start) * dilation[1];
            let tap = (kd * window.kernel[1] + kr) * window.kernel[2] + columns.start;
            let gradients = patch[tap * inner..].chunks_exact(inner);
            for (number, gradient) in (0..columns.len()).zip(gradients) {
                let column = first_c + number * dilation[2];
                let to = (line * window.input[2] + column) * sizes.channels + group * inner;
                pointwise::copy(gradient, &mut dx[to..to + inner], true);
            }
        }
    }
}
