//! Prediction in bf16 against plain loops over rounded factors: the same bits. What needs the processor's products is ignored
//! where `scripts/check` finds none.

mod common;

use common::placed::{Placed, gathered, placed, spread};
use common::{needs, panics, values};
use proptest::prelude::*;
use taxel_kernels::conv::ConvKind;
use taxel_kernels::frozen::{ImagePlace, Route, half};
use taxel_kernels::{Rectifier, Window3};

/// Returns the nearest bf16 (even among equals), by comparing both neighbours.
fn nearest(value: f32) -> f32 {
    let below = f32::from_bits(value.to_bits() & 0xffff_0000);
    let above = f32::from_bits(below.to_bits().wrapping_add(0x1_0000));
    let (down, up) = (f64::from(value) - f64::from(below), f64::from(above) - f64::from(value));
    match down.abs().total_cmp(&up.abs()) {
        std::cmp::Ordering::Less => below,
        std::cmp::Ordering::Greater => above,
        std::cmp::Ordering::Equal if (below.to_bits() >> 16).is_multiple_of(2) => below,
        std::cmp::Ordering::Equal => above,
    }
}

/// Values with all bits of a mantissa in use.
fn fine(count: usize, salt: usize) -> Vec<f32> {
    values(count, salt).into_iter().map(|value| value * 0.987_654_3).collect()
}

fn rectified(rectifier: Rectifier, value: f32) -> f32 {
    match rectifier {
        Rectifier::None => value,
        Rectifier::Relu => value.max(0.0),
        Rectifier::Relu6 => value.clamp(0.0, 6.0),
    }
}

/// Every output of a convolution: the bias, then one product of rounded factors after the other, each fused with the sum.
fn model(placed: &Placed, x: &[f32], weight: &[f32], bias: &[f32], addend: Option<&[f32]>) -> Vec<f32> {
    let (case, window) = (&placed.case, &placed.case.window);
    let Window3 { input, output, kernel, stride, before } = *window;
    let (inner, out) = (case.channels / case.groups, case.filters / case.groups);
    let mut y = vec![];
    for at in 0..output.iter().product() {
        let o = [at / (output[1] * output[2]), at / output[2] % output[1], at % output[2]];
        for filter in 0..case.filters {
            let (group, f) = (filter / out, filter % out);
            let mut sum = bias[filter];
            for tap in 0..kernel.iter().product() {
                let k = [tap / (kernel[1] * kernel[2]), tap / kernel[2] % kernel[1], tap % kernel[2]];
                let position = [0, 1, 2].map(|a| {
                    let position = (o[a] * stride[a] + k[a] * case.dilation[a]).checked_sub(before[a]);
                    position.filter(|&position| position < input[a])
                });
                let [Some(d), Some(r), Some(c)] = position else { continue };
                let x = &x[((d * input[1] + r) * input[2] + c) * case.channels + group * inner..];
                for i in 0..inner {
                    let weight =
                        weight[((group * kernel.iter().product::<usize>() + tap) * inner + i) * out + f];
                    sum = nearest(x[i]).mul_add(nearest(weight), sum);
                }
            }
            sum += addend.map_or(0.0, |addend| addend[at * case.filters + filter]);
            y.push(rectified(placed.rectifier, sum));
        }
    }
    y
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    #[ignore = "needs avx512_bf16"]
    fn convolutions_have_the_bits_of_their_definition_needs_bf16(placed in placed()) {
        let case = &placed.case;
        prop_assume!(half::Conv::takes(case.channels, case.groups));
        let (from, to) = (placed.from(), placed.to());
        let len = case.window.volume() * case.channels / case.groups * case.filters;
        let (x, weight, bias) = (fine(from.len(), 1), fine(len, 2), fine(case.filters, 3));
        let addend = fine(to.len(), 4);
        let input = spread(&from, &x);
        let mut y = vec![7.0; to.buffer_len()];
        let plain = Route { rectifier: placed.rectifier, ..Route::new(from, to) };
        for (route, given) in [(plain, None), (Route { addend: Some(to), ..plain }, Some(&addend[..]))] {
            let conv = half::Conv::new(&case.window, case.dilation, case.groups, &weight, &bias, route);
            let mut work = vec![f32::NAN; conv.work_len()];
            conv.run(&input, given.map(|addend| spread(&to, addend)).as_deref(), &mut work, &mut y);
            prop_assert_eq!(gathered(&to, &y), model(&placed, &x, &weight, &bias, given));
            let untouched = y.iter().filter(|v| **v == 7.0).count();
            prop_assert!(untouched >= y.len() - to.len(), "nothing is written outside the place");
        }
    }
}

/// `Bᵀ d` of four values, as the kernel has it.
fn spread_line([a, b, c, d]: [f32; 4]) -> [f32; 4] {
    [a - c, b + c, c - b, b - d]
}

/// `G g` of three values.
fn spread_weights([a, b, c]: [f32; 3]) -> [f32; 4] {
    [a, 0.5 * (a + c + b), 0.5 * (a + c - b), c]
}

/// `Aᵀ m` of four values.
fn gather_line([a, b, c, d]: [f32; 4]) -> [f32; 2] {
    [a + b + c, b - c - d]
}

/// Applies a line's transform to the columns of a square, then to its rows.
fn both<const N: usize, const M: usize>(
    line: fn([f32; N]) -> [f32; M],
    square: [[f32; N]; N],
) -> [[f32; M]; M] {
    let columns: [[f32; M]; N] = std::array::from_fn(|j| line(std::array::from_fn(|i| square[i][j])));
    std::array::from_fn(|i| line(std::array::from_fn(|j| columns[j][i])))
}

/// Every output of a 3×3 convolution with padding `before`, by tiles whose transformed factors are rounded.
fn model_of_tiles(
    window: &Window3,
    [channels, filters]: [usize; 2],
    x: &[f32],
    weight: &[f32],
    bias: &[f32],
) -> Vec<f32> {
    let Window3 { input, output, before, .. } = *window;
    let at = |row: usize, column: usize, channel: usize| {
        let (row, column) = (row.wrapping_sub(before[1]), column.wrapping_sub(before[2]));
        let inside = row < input[1] && column < input[2];
        if inside { x[(row * input[2] + column) * channels + channel] } else { 0.0 }
    };
    let mut y = vec![0.0; output[1] * output[2] * filters];
    for (row, column) in
        (0..output[1]).step_by(2).flat_map(|r| (0..output[2]).step_by(2).map(move |c| (r, c)))
    {
        for f in 0..filters {
            let mut products = [[0.0f32; 4]; 4];
            for channel in 0..channels {
                let d: [[f32; 4]; 4] =
                    std::array::from_fn(|i| std::array::from_fn(|j| at(row + i, column + j, channel)));
                let g: [[f32; 3]; 3] = std::array::from_fn(|i| {
                    std::array::from_fn(|j| weight[((3 * i + j) * channels + channel) * filters + f])
                });
                let (v, u) = (both(spread_line, d), both(spread_weights, g));
                for (i, sums) in products.iter_mut().enumerate() {
                    for (j, sum) in sums.iter_mut().enumerate() {
                        *sum = nearest(v[i][j]).mul_add(nearest(u[i][j]), *sum);
                    }
                }
            }
            for (i, values) in both(gather_line, products).into_iter().enumerate() {
                for (j, value) in values.into_iter().enumerate() {
                    if row + i < output[1] && column + j < output[2] {
                        y[((row + i) * output[2] + column + j) * filters + f] = value + bias[f];
                    }
                }
            }
        }
    }
    y
}

#[test]
#[ignore = "needs avx512_bf16"]
fn fewer_products_have_the_bits_of_their_tiles_needs_bf16() {
    for (size, before, [channels, filters]) in [
        ([6, 6], 1, [32, 32]),
        ([7, 9], 1, [34, 41]),
        ([5, 8], 0, [2, 3]),
        ([9, 6], 2, [70, 24]),
        ([31, 30], 1, [40, 64]),
    ] {
        let window = Window3 {
            input: [1, size[0], size[1]],
            output: [1, size[0] + 2 * before - 2, size[1] + 2 * before - 2],
            kernel: [1, 3, 3],
            stride: [1; 3],
            before: [0, before, before],
        };
        let wide = channels.min(filters) >= 32;
        assert_eq!(half::Winograd::pays(&window, ConvKind::Winograd, channels, filters), wide);
        assert!(!half::Winograd::pays(&window, ConvKind::Direct, channels, filters));
        let from = ImagePlace::new(window.input, channels, [2, 1], channels + 3, 1);
        let to = ImagePlace::new(window.output, filters, [1, 3], filters + 2, 2);
        let (x, bias) = (fine(from.len(), 1), fine(filters, 3));
        let weight = fine(9 * channels * filters, 2);
        let plain = Route { rectifier: Rectifier::Relu, ..Route::new(from, to) };
        let addend = fine(to.len(), 4);
        for (route, given) in
            [(plain, None), (Route { addend: Some(to), ..plain }, Some(spread(&to, &addend)))]
        {
            let conv = half::Winograd::new(&window, &weight, &bias, route);
            let (mut work, mut y) = (vec![f32::NAN; conv.work_len()], vec![7.0; to.buffer_len()]);
            let sums = model_of_tiles(&window, [channels, filters], &x, &weight, &bias);
            let added = |(at, sum): (usize, f32)| (sum + given.as_ref().map_or(0.0, |_| addend[at])).max(0.0);
            let want: Vec<f32> = sums.into_iter().enumerate().map(added).collect();
            // Twice: nothing of a run may be left for the next.
            for _ in 0..2 {
                conv.run(&spread(&from, &x), given.as_deref(), &mut work, &mut y);
                assert_eq!(gathered(&to, &y), want, "{size:?}, {channels} to {filters}");
            }
        }
    }
}

/// A sum of `n` fused products is off by at most `n` roundings of what its terms add up to.
#[test]
#[ignore = "needs avx512_bf16"]
fn linear_layers_are_off_by_the_rounding_of_sums_alone_needs_bf16() {
    for (inputs, outputs) in [(1, 1), (7, 3), (65, 16), (37, 148), (130, 129), (33, 400)] {
        let (x, weight, start) = (fine(inputs, 6), fine(inputs * outputs, 7), fine(outputs, 8));
        let linear = half::Linear::new(inputs, outputs, &weight);
        let (mut work, mut y) = (vec![f32::NAN; linear.work_len()], vec![7.0; outputs]);
        for panel in 0..linear.panels() {
            linear.run(panel..panel + 1, &x, &start, Rectifier::None, &mut work, &mut y);
        }
        let mut at_once = vec![7.0; outputs];
        linear.run(0..linear.panels(), &x, &start, Rectifier::None, &mut work, &mut at_once);
        assert_eq!(y, at_once);
        for output in 0..outputs {
            let (mut sum, mut most) = (f64::from(start[output]), f64::from(start[output].abs()));
            for input in 0..inputs {
                let product =
                    f64::from(nearest(x[input])) * f64::from(nearest(weight[input * outputs + output]));
                (sum, most) = (sum + product, most + product.abs());
            }
            // Up to eight sums side by side are added at last.
            let bound = (inputs + 10) as f64 * f64::from(f32::EPSILON / 2.0) * most;
            let off = (f64::from(y[output]) - sum).abs();
            assert!(off <= bound, "{inputs} to {outputs}: {off} at {output}, at most {bound}");
        }
    }
}

#[test]
#[ignore = "needs avx512_bf16"]
fn slices_that_are_too_short_are_refused_needs_bf16() {
    let size = [1, 5, 6];
    let window = Window3 { input: size, output: size, kernel: [1, 3, 3], stride: [1; 3], before: [0, 1, 1] };
    let (from, to) = (ImagePlace::new(size, 3, [1, 1], 3, 0), ImagePlace::dense(size, 4));
    let route = Route { addend: Some(to), ..Route::new(from, to) };
    let conv = half::Conv::new(&window, [1; 3], 1, &values(108, 1), &values(4, 2), route);
    let lens = [from.buffer_len(), to.end(), conv.work_len(), to.end()];
    needs("conv", lens, |[x, addend, work, y]| conv.run(x, Some(addend), work, y));
    let from = ImagePlace::new(size, 4, [1, 1], 6, 1);
    let route = Route { addend: Some(to), ..Route::new(from, to) };
    let conv = half::Winograd::new(&window, &values(9 * 16, 1), &values(4, 2), route);
    let lens = [from.end(), to.end(), conv.work_len(), to.end()];
    needs("winograd", lens, |[x, addend, work, y]| conv.run(x, Some(addend), work, y));
    let linear = half::Linear::new(7, 5, &values(35, 1));
    needs("linear", [7, 5, linear.work_len(), 5], |[x, start, work, y]| {
        linear.run(0..linear.panels(), x, start, Rectifier::None, work, y);
    });
    let narrow = ImagePlace::dense(size, 4);
    let refused = panics(|| {
        half::Conv::new(&window, [1; 3], 1, &values(144, 1), &values(4, 2), Route::new(narrow, to));
    });
    assert!(refused.unwrap_or_default().contains("margins of"));
}
