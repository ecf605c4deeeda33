//! Convolution against plain loops over its definition.

mod common;

use common::{Case, cases, most, values};
use proptest::prelude::*;
use taxel_kernels::conv::{Conv, ConvKind};
use taxel_kernels::simd::{Level, level};
use taxel_kernels::{AffineView, Rectifier, Window3};

impl Case {
    /// Calls `body(input value, weight, output value)` for every product of the definition.
    fn products(&self, mut body: impl FnMut(usize, usize, usize)) {
        let Window3 { input, output, kernel, stride, before } = self.window;
        let (inner, out) = (self.channels / self.groups, self.filters / self.groups);
        let at = |size: [usize; 3], p: [usize; 3]| (p[0] * size[1] + p[1]) * size[2] + p[2];
        let all = |size: [usize; 3]| {
            (0..size[0])
                .flat_map(move |d| (0..size[1]).flat_map(move |r| (0..size[2]).map(move |c| [d, r, c])))
        };
        for o in all(output) {
            for k in all(kernel) {
                let position: Vec<Option<usize>> = (0..3)
                    .map(|a| {
                        (o[a] * stride[a] + k[a] * self.dilation[a])
                            .checked_sub(before[a])
                            .filter(|&i| i < input[a])
                    })
                    .collect();
                let [Some(d), Some(r), Some(c)] = position[..] else { continue };
                for group in 0..self.groups {
                    for i in 0..inner {
                        for f in 0..out {
                            let x = at(input, [d, r, c]) * self.channels + group * inner + i;
                            let kernels = kernel.iter().product::<usize>();
                            let w = if self.groups > 1 && inner == 1 && out == 1 {
                                at(kernel, k) * self.filters + group
                            } else {
                                ((group * kernels + at(kernel, k)) * inner + i) * out + f
                            };
                            body(x, w, at(output, o) * self.filters + group * out + f);
                        }
                    }
                }
            }
        }
    }
}

/// Sums of `terms` products are equal within a share of the largest, or of what such sums are like where
/// all cancel.
fn close(got: &[f32], want: &[f64], terms: usize, share: f64, what: &str) {
    assert_eq!(got.len(), want.len());
    let scale = want.iter().fold(0.1 * (terms as f64).sqrt(), |a, v| a.max(v.abs()));
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        assert!((f64::from(*got) - want).abs() <= share * scale, "{what}[{i}]: {got} and {want}");
    }
}

/// Shares by which outputs and gradients may differ.
struct Shares {
    forward: f64,
    gradients: f64,
    /// Parts of 1 that values are rounded to, so that a bf16 holds them and products are exact; 0 leaves them as they are.
    parts: f32,
}

const DIRECT: Shares = Shares { forward: 1e-5, gradients: 1e-5, parts: 0.0 };
/// Transforms add and subtract values several times as large as what is left in the end: of thousands of
/// outputs' cases one was above 1e-5.
const FEWER: Shares = Shares { forward: 2e-5, gradients: 5e-5, parts: 0.0 };

/// Portable code rounds each product before it is added, where the others round the sum alone: cases of many
/// products came out a little above their share.
fn fewer() -> Shares {
    let factor = if level() == Level::Portable { 2.0 } else { 1.0 };
    Shares { forward: factor * FEWER.forward, gradients: factor * FEWER.gradients, ..FEWER }
}

/// Shares for products of bf16. Of transformed values, sums of up to nine, a bf16 holds fewer.
fn half(conv: &Conv) -> Shares {
    match conv.kind() {
        ConvKind::Winograd => Shares { parts: 8.0, ..fewer() },
        _ => Shares { parts: 64.0, ..DIRECT },
    }
}

/// All passes of `conv` against the definition.
fn agrees(case: &Case, conv: &Conv, accumulate: bool, relu: bool, shares: Shares) {
    let Shares { forward, gradients, parts } = shares;
    let values = |count: usize, salt: usize| -> Vec<f32> {
        let values = values(count, salt).into_iter();
        values.map(|v| if parts > 0.0 { (parts * v).round() / parts } else { v }).collect()
    };
    let filters = case.filters;
    let (depth, positions) = (conv.weight_len() / filters, conv.y_len() / filters);
    let (x, dy) = (values(conv.x_len(), 1), values(conv.y_len(), 2));
    let (weight, bias) = (values(conv.weight_len(), 3), values(filters, 4));
    let rectifier = if relu { Rectifier::Relu } else { Rectifier::None };
    let view = AffineView { affine: None, rectifier };
    let seen: Vec<f64> = x.iter().map(|&v| f64::from(if relu { v.max(0.0) } else { v })).collect();

    let mut y: Vec<f64> = bias.iter().cycle().take(conv.y_len()).map(|&b| f64::from(b)).collect();
    let mut dx = vec![if accumulate { 0.5 } else { 0.0 }; conv.x_len()];
    let mut dweight = vec![0.25; conv.weight_len()];
    case.products(|i, w, o| {
        y[o] += seen[i] * f64::from(weight[w]);
        dx[i] += f64::from(weight[w]) * f64::from(dy[o]);
        dweight[w] += seen[i] * f64::from(dy[o]);
    });
    let mut dbias = vec![0.25; filters];
    dy.iter().enumerate().for_each(|(o, v)| dbias[o % filters] += f64::from(*v));

    let mut scratch = vec![f32::NAN; conv.padded_len()];
    let mut work = vec![f32::NAN; conv.work_len()];
    let (mut packed, mut turned) = (vec![], vec![]);
    conv.pack(&weight, &mut packed);
    let mut got = vec![f32::NAN; conv.y_len()];
    for band in conv.bands() {
        let padded = conv.pad(&x, &view, band, &mut scratch);
        conv.forward(padded, &weight, &packed, Some(&bias), &mut got, &mut work);
    }
    close(&got, &y, depth, forward, "y");
    let (mut sums, mut got_bias) = (vec![0.0; conv.sums_len()], vec![0.25; filters]);
    work.fill(f32::NAN);
    for band in conv.bands() {
        let padded = conv.pad(&x, &view, band, &mut scratch);
        conv.backward_weight(padded, &dy, &mut sums, Some(&mut got_bias), &mut work);
    }
    let mut got_weight = vec![0.25; conv.weight_len()];
    conv.finish(&sums, &mut got_weight);
    close(&got_weight, &dweight, positions, gradients, "dweight");
    close(&got_bias, &dbias, positions, gradients, "dbias");
    conv.turn(&weight, &mut turned);
    let mut got = vec![if accumulate { 0.5 } else { f32::NAN }; conv.x_len()];
    let mut scratch = vec![f32::NAN; conv.backward_len()];
    conv.backward_input(&dy, &weight, &turned, &mut scratch, &mut got, accumulate);
    close(&got, &dx, depth, gradients, "dx");
}

/// 3×3 windows with stride 1, from one position to several blocks of tiles.
fn squares() -> impl Strategy<Value = Case> {
    let axis = || (1..most(30, 9), 0usize..3, 0usize..3);
    ([axis(), axis()], 1..most(40, 5), 1..most(40, 20)).prop_map(|(axes, channels, filters)| {
        let mut window =
            Window3 { input: [1; 3], output: [1; 3], kernel: [1, 3, 3], stride: [1; 3], before: [0; 3] };
        for (a, (input, before, after)) in axes.into_iter().enumerate() {
            let padding = 3usize.saturating_sub(input).max(before + after);
            window.input[a + 1] = input;
            window.before[a + 1] = before;
            window.output[a + 1] = input + padding - 2;
        }
        Case { window, dilation: [1; 3], channels, filters, groups: 1 }
    })
}

/// Kernels that are 3 long along an axis, with stride 1.
fn lines() -> impl Strategy<Value = Case> {
    let axis = || (1..most(14, 6), 1..most(6, 4), 0usize..4, 0usize..4);
    ([axis(), axis(), axis()], 0usize..2, 1..most(20, 5), 1..most(36, 20)).prop_map(
        |(axes, three, channels, filters)| {
            let mut window =
                Window3 { input: [1; 3], output: [1; 3], kernel: [1; 3], stride: [1; 3], before: [0; 3] };
            for (a, (input, kernel, before, after)) in axes.into_iter().enumerate() {
                let kernel = if a == three { 3 } else { kernel };
                let padding = kernel.saturating_sub(input).max(before + after);
                window.input[a] = input;
                window.kernel[a] = kernel;
                window.before[a] = before;
                window.output[a] = input + padding + 1 - kernel;
            }
            Case { window, dilation: [1; 3], channels, filters, groups: 1 }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 6 } else { 200 }))]

    #[test]
    fn agrees_with_its_definition(case in cases(1..36, 1), accumulate in any::<bool>(), relu in any::<bool>()) {
        let Case { window, channels, filters, groups, .. } = case;
        let conv = match case.dilation {
            [1, 1, 1] => Conv::direct(window, channels, filters, groups),
            dilation => Conv::dilated(window, dilation, channels, filters, groups),
        };
        agrees(&case, &conv, accumulate, relu, DIRECT);
    }

    #[test]
    #[ignore = "needs avx512_bf16"]
    fn halves_agree_with_the_definition_needs_bf16(case in cases(1..36, 1), accumulate in any::<bool>(), relu in any::<bool>()) {
        let Case { window, dilation, channels, filters, groups } = case;
        let conv = Conv::half(window, dilation, channels, filters, groups);
        agrees(&case, &conv, accumulate, relu, half(&conv));
    }

    #[test]
    #[ignore = "needs avx512_bf16"]
    fn fewer_products_of_halves_give_the_same_needs_bf16(case in squares(), accumulate in any::<bool>(), relu in any::<bool>()) {
        let Case { window, channels, filters, groups, .. } = case;
        let conv = Conv::half_winograd(window, channels, filters, groups);
        prop_assert_eq!(conv.kind(), ConvKind::Winograd);
        agrees(&case, &conv, accumulate, relu, half(&conv));
    }

    #[test]
    fn fewer_products_give_the_same(case in prop_oneof![squares(), lines()], accumulate in any::<bool>(), relu in any::<bool>()) {
        let Case { window, channels, filters, groups, .. } = case;
        agrees(&case, &Conv::winograd(window, channels, filters, groups), accumulate, relu, fewer());
    }
}

#[test]
#[cfg_attr(miri, ignore = "hundreds of millions of products")]
fn large_depthwise_images_go_band_by_band() {
    // The padded images do not fit into one band; odd strides, kernels and paddings, and a stride that
    // leaves out the last rows.
    for (kernel, stride, before, rows, step) in [
        (3, 1, 1, 40, 1),
        (3, 2, 1, 40, 1),
        (5, 3, 0, 41, 1),
        (2, 2, 0, 40, 1),
        (3, 1, 2, 40, 2),
        (2, 2, 0, 40, 3),
    ] {
        let (input, channels) = ([1, rows, 30], 150);
        let dilation = [1, step, step];
        let out = |size: usize| (size + 2 * before - (kernel - 1) * step - 1) / stride + 1;
        let window = Window3 {
            input,
            output: [1, out(rows), out(30)],
            kernel: [1, kernel, kernel],
            stride: [1, stride, stride],
            before: [0, before, before],
        };
        let case = Case { window, dilation, channels, filters: channels, groups: channels };
        let conv = Conv::dilated(window, dilation, channels, channels, channels);
        assert!(conv.bands().count() > 1);
        for accumulate in [false, true] {
            agrees(&case, &conv, accumulate, true, DIRECT);
        }
    }
}
