//! Every public function that takes slices, with each of them one value too short: a panic whose message says
//! what is needed, in place of a read or write beyond the end.

mod common;

use common::{most, needs, panics, says_what_is_needed};
use taxel_kernels::adaptive_pool::AdaptivePool;
use taxel_kernels::batch_norm::InputGradient;
use taxel_kernels::conv::Conv;
use taxel_kernels::gru::{self, Gru};
use taxel_kernels::lstm::{Lstm, Trace, Weights};
use taxel_kernels::matmul::{Matrix, few_rows, matmul};
use taxel_kernels::optim::Adam;
use taxel_kernels::pool::MaxPool;
use taxel_kernels::{
    AffineView, Rectifier, Window3, activation, batch_norm, dropout, layout, loss, optim, pointwise, pool,
    reduce,
};
use taxel_kernels::{deviation, layer_norm};

#[test]
fn activations() {
    type Forward = fn(&[f32], &mut [f32]);
    let forward: [(&str, Forward); 6] = [
        ("relu", activation::relu),
        ("relu6", activation::relu6),
        ("leaky_relu", |x, y| activation::leaky_relu(0.1, x, y)),
        ("sigmoid", activation::sigmoid),
        ("tanh", activation::tanh),
        ("hard_swish", activation::hard_swish),
    ];
    type Backward = fn(&[f32], &[f32], &mut [f32], bool);
    let backward: [(&str, Backward); 6] = [
        ("relu_backward", activation::relu_backward),
        ("relu6_backward", activation::relu6_backward),
        ("leaky_relu_backward", |x, dy, dx, add| activation::leaky_relu_backward(0.1, x, dy, dx, add)),
        ("sigmoid_backward", activation::sigmoid_backward),
        ("tanh_backward", activation::tanh_backward),
        ("hard_swish_backward", activation::hard_swish_backward),
    ];
    for len in [1, 16, 37] {
        for (name, function) in forward {
            needs(name, [len; 2], |[x, y]| function(x, y));
        }
        for (name, function) in backward {
            for add in [false, true] {
                needs(name, [len; 3], |[x, dy, dx]| function(x, dy, dx, add));
            }
        }
    }
}

#[test]
fn values_that_are_moved() {
    let (rows, width, wide) = (5, 3, 7);
    for add in [false, true] {
        needs("copy", [37; 2], |[x, y]| pointwise::copy(x, y, add));
        needs("scale", [37; 2], |[x, y]| pointwise::scale(2.0, x, y, add));
        needs("take_columns", [rows * wide, rows * width], |[y, x]| {
            pointwise::take_columns(y, wide, 2, x, width, add);
        });
        needs("shuffle_columns", [rows * 6; 2], |[x, y]| pointwise::shuffle_columns(x, 6, 2, y, add));
        needs("mean_positions_backward", [width, rows * width], |[dy, dx]| {
            pointwise::mean_positions_backward(width, dy, dx, add);
        });
        let (image, each) = (rows * width, width);
        needs("deviation::backward", [image, each, each, each, image], |[x, mean, y, dy, dx]| {
            deviation::backward(width, x, mean, y, dy, dx, add);
        });
        needs("transpose", [rows * width; 2], |[x, y]| layout::transpose(rows, width, x, y, add));
        needs("dropout", [37; 2], |[x, y]| dropout::apply(x, y, 2.0, |i| i % 2 == 0, add));
    }
    needs("layer_norm::forward", [37; 4], |[x, weight, bias, y]| {
        layer_norm::forward(1e-5, x, weight, bias, y);
    });
    for add in [false, true] {
        needs("layer_norm::backward", [37; 4], |[x, weight, dy, dx]| {
            layer_norm::backward([0.1, 2.0], x, weight, dy, dx, add);
        });
    }
    needs("layer_norm::add_gradients", [37; 4], |[x, dy, dweight, dbias]| {
        layer_norm::add_gradients([0.1, 2.0], x, dy, dweight, dbias);
    });
    needs("deviation::forward", [rows * width, width, width], |[x, mean, y]| {
        deviation::forward(width, 1e-5, x, mean, y);
    });
    needs("put_columns", [rows * width, rows * wide], |[x, y]| pointwise::put_columns(x, width, y, wide, 2));
    needs("add_to_columns", [rows * width, rows * wide], |[x, y]| {
        pointwise::add_to_columns(x, width, y, wide, 4);
    });
    says_what_is_needed("columns beyond the row", || {
        pointwise::put_columns(&[0.0; 3], 3, &mut [0.0; 7], 7, 5);
    });
    says_what_is_needed("groups that do not divide", || {
        pointwise::shuffle_columns(&[0.0; 5], 5, 2, &mut [0.0; 5], false);
    });
    for (filters, channels, groups) in [(6, 2, 3), (6, 1, 6)] {
        let len = filters * channels * 4;
        needs("weights_in", [len; 2], |[w, inner]| {
            layout::weights_in(filters, channels, 4, groups, w, inner)
        });
        needs("weights_out", [len; 2], |[inner, w]| {
            layout::weights_out(filters, channels, 4, groups, inner, w);
        });
    }
}

/// Channels that are folded, and that are not; rows enough for several vectors.
const ROWS: [(usize, usize); 3] = [(3, 13), (20, 9), (2, 40)];

#[test]
fn views() {
    for (channels, rows) in ROWS {
        let len = channels * rows;
        for rectifier in [Rectifier::None, Rectifier::Relu, Rectifier::Relu6] {
            let plain = AffineView { affine: None, rectifier };
            needs("apply", [len; 2], |[x, y]| plain.apply(channels, x, y));
            needs("affine apply", [channels, channels, len, len], |[scale, shift, x, y]| {
                AffineView { affine: Some((scale, shift)), rectifier }.apply(channels, x, y);
            });
            needs("seen", [channels, channels, len, len], |[scale, shift, x, scratch]| {
                AffineView { affine: Some((scale, shift)), rectifier }.seen(channels, x, scratch);
            });
            needs(
                "mean_positions",
                [channels, channels, len, len, channels],
                |[scale, shift, x, scratch, y]| {
                    let view = AffineView { affine: Some((scale, shift)), rectifier };
                    pointwise::mean_positions(channels, &view, x, scratch, y);
                },
            );
        }
        needs("mean_positions as they are", [len, channels], |[x, y]| {
            pointwise::mean_positions(channels, &AffineView::default(), x, &mut [], y);
        });
    }
}

#[test]
fn sums_and_batch_norms() {
    for (channels, rows) in ROWS {
        let len = channels * rows;
        needs("add_columns", [len, channels], |[x, sums]| reduce::add_columns(channels, x, sums));
        needs("add_squared_deviations", [len, channels, channels], |[x, mean, sums]| {
            reduce::add_squared_deviations(channels, x, mean, sums);
        });
        needs("dot", [len; 2], |[x, y]| {
            reduce::dot(x, y);
        });
        needs(
            "add_gradient_sums",
            [len, len, channels, channels, channels, channels, channels],
            |[x, dy, scale, shift, mean, sums, deviations]| {
                let view = AffineView { affine: Some((scale, shift)), rectifier: Rectifier::Relu };
                reduce::add_gradient_sums(channels, x, &view, dy, mean, sums, deviations);
            },
        );
        for rectifier in [Rectifier::None, Rectifier::Relu, Rectifier::Relu6] {
            needs("batch_norm without a norm", [len; 3], |[x, dy, dx]| {
                let view = AffineView { affine: None, rectifier };
                batch_norm::backward(channels, x, &view, None, dy, dx, true);
            });
            needs(
                "batch_norm",
                [len, len, len, channels, channels, channels, channels, channels, channels],
                |[x, dy, dx, scale, shift, of_dy, of_x, mean, constant]| {
                    let norm = InputGradient {
                        dy: of_dy.to_vec(),
                        x: of_x.to_vec(),
                        mean: mean.to_vec(),
                        constant: constant.to_vec(),
                    };
                    let view = AffineView { affine: Some((scale, shift)), rectifier };
                    batch_norm::backward(channels, x, &view, Some(&norm), dy, dx, false);
                },
            );
        }
    }
    says_what_is_needed("scale and shift without their norm", || {
        let view = AffineView { affine: Some((&[1.0], &[0.0])), rectifier: Rectifier::None };
        batch_norm::backward(1, &[0.0], &view, None, &[0.0], &mut [0.0], false);
    });
}

const fn flat(input: usize, output: usize, kernel: usize, stride: usize, before: usize) -> Window3 {
    Window3 {
        input: [1, input, input],
        output: [1, output, output],
        kernel: [1, kernel, kernel],
        stride: [1, stride, stride],
        before: [0, before, before],
    }
}

#[test]
fn pools() {
    for (window, channels) in [(flat(7, 3, 3, 2, 0), 5), (flat(6, 6, 3, 1, 1), 19)] {
        let (inputs, outputs) = (window.input_len() * channels, window.output_len() * channels);
        let max = MaxPool::new(&window, channels);
        needs("max forward", [inputs, outputs, outputs], |[x, y, taken]| {
            max.forward(&AffineView::default(), x, y, taken);
        });
        needs("max forward through a view", [inputs, outputs, outputs, channels, channels], |slices| {
            let [x, y, taken, scale, shift] = slices;
            let view = AffineView { affine: Some((scale, shift)), rectifier: Rectifier::Relu };
            max.forward(&view, x, y, taken);
        });
        let counted = [(0, 0); 3];
        for add in [false, true] {
            needs("max backward", [outputs, outputs, inputs], |[taken, dy, dx]| {
                max.backward(taken, dy, dx, add);
            });
        }
        needs("average forward", [inputs, outputs], |[x, y]| {
            pool::average_forward(&window, &counted, channels, x, y);
        });
        needs("average backward", [outputs, inputs], |[dy, dx]| {
            pool::average_backward(&window, &counted, channels, dy, dx);
        });
        let adaptive = AdaptivePool { input: window.input, output: [1, 2, 3], channels };
        needs("adaptive forward", [inputs, 6 * channels], |[x, y]| adaptive.forward(x, y));
        needs("adaptive backward", [6 * channels, inputs], |[dy, dx]| adaptive.backward(dy, dx));
    }
}

type New = fn(Window3, usize, usize, usize) -> Conv;

/// Name, constructor, window, channels, filters, groups: every algorithm, and every way to an input gradient.
const CONVOLUTIONS: [(&str, New, Window3, [usize; 3]); 11] = [
    ("direct", Conv::direct, flat(7, 7, 3, 1, 1), [5, 19, 1]),
    ("direct without a halo", Conv::direct, flat(7, 7, 1, 1, 0), [5, 19, 1]),
    ("direct in groups", Conv::direct, flat(7, 5, 3, 1, 0), [6, 9, 3]),
    ("direct with strides", Conv::direct, flat(7, 3, 3, 2, 0), [5, 19, 1]),
    ("dilated", twice_as_wide, flat(7, 7, 3, 1, 2), [5, 19, 1]),
    ("dilated with strides", twice_as_wide, flat(7, 2, 3, 2, 0), [5, 19, 1]),
    ("depthwise", Conv::new, flat(7, 7, 3, 1, 1), [19, 19, 19]),
    ("depthwise with strides", Conv::new, flat(7, 3, 3, 2, 0), [19, 19, 19]),
    ("squares", Conv::winograd, flat(7, 7, 3, 1, 1), [5, 19, 1]),
    ("lines", Conv::winograd, LINES, [5, 19, 1]),
    ("depthwise in bands", Conv::new, flat(60, 60, 5, 1, 2), [40, 40, 40]),
];

/// Under Miri without the millions of products of the last one, and the dense ones with few channels.
fn convolutions() -> impl Iterator<Item = (&'static str, New, Window3, [usize; 3])> {
    CONVOLUTIONS.into_iter().take(most(11, 10)).map(|(name, new, window, sizes)| {
        let few = cfg!(miri) && sizes == [5, 19, 1];
        (name, new, window, if few { [2, 17, 1] } else { sizes })
    })
}

const LINES: Window3 =
    Window3 { input: [6, 5, 5], output: [6, 5, 5], kernel: [3, 1, 5], stride: [1; 3], before: [1, 0, 2] };

fn twice_as_wide(window: Window3, channels: usize, filters: usize, groups: usize) -> Conv {
    Conv::dilated(window, [1, 2, 2], channels, filters, groups)
}

#[test]
fn convolutions_pad_and_go_forward() {
    for (name, new, window, [channels, filters, groups]) in convolutions() {
        let conv = new(window, channels, filters, groups);
        let (x, weight) = (vec![0.5; conv.x_len()], vec![0.5; conv.weight_len()]);
        // Scratch is filled where there is a halo, and as a whole where there is one band.
        let fills =
            if conv.padded_len() > conv.x_len() && conv.bands().count() == 1 { conv.padded_len() } else { 0 };
        needs(name, [conv.x_len(), fills], |[x, scratch]| {
            let mut whole = vec![0.0; if fills == 0 { conv.padded_len() } else { 0 }];
            let scratch = if fills == 0 { &mut whole } else { scratch };
            for band in conv.bands() {
                let _ = conv.pad(x, &AffineView::default(), band, scratch);
            }
        });
        needs(name, [weight.len()], |[weight]| conv.pack(weight, &mut vec![]));
        let mut packed = vec![];
        conv.pack(&weight, &mut packed);
        // One of the two is read.
        let reads = if packed.is_empty() { weight.len() } else { 0 };
        let lens = [reads, packed.len(), filters, conv.y_len(), conv.work_len()];
        needs(name, lens, |[weight, packed, bias, y, work]| {
            let mut scratch = vec![0.0; conv.padded_len()];
            for band in conv.bands() {
                let padded = conv.pad(&x, &AffineView::default(), band, &mut scratch);
                conv.forward(padded, weight, packed, Some(bias), y, work);
            }
        });
    }
}

#[test]
fn convolutions_and_their_gradients() {
    for (name, new, window, [channels, filters, groups]) in convolutions() {
        let conv = new(window, channels, filters, groups);
        let (x, weight) = (vec![0.5; conv.x_len()], vec![0.5; conv.weight_len()]);
        let lens = [conv.y_len(), conv.sums_len(), filters, conv.work_len()];
        needs(name, lens, |[dy, sums, dbias, work]| {
            let mut scratch = vec![0.0; conv.padded_len()];
            for band in conv.bands() {
                let padded = conv.pad(&x, &AffineView::default(), band, &mut scratch);
                conv.backward_weight(padded, dy, sums, Some(dbias), work);
            }
        });
        needs(name, [conv.y_len(), conv.sums_len(), conv.work_len()], |[dy, sums, work]| {
            let mut scratch = vec![0.0; conv.padded_len()];
            for band in conv.bands() {
                let padded = conv.pad(&x, &AffineView::default(), band, &mut scratch);
                conv.backward_weight(padded, dy, sums, None, work);
            }
        });
        needs(name, [conv.sums_len(), weight.len()], |[sums, dweight]| conv.finish(sums, dweight));
        needs(name, [weight.len()], |[weight]| conv.turn(weight, &mut vec![]));
        let mut turned = vec![];
        conv.turn(&weight, &mut turned);
        let reads = if turned.is_empty() { weight.len() } else { 0 };
        // Behind packed weights lies room that only `turn` uses.
        let packed = if conv.work_len() > 0 { turned.len() - weight.len() } else { turned.len() };
        for add in [false, true] {
            let lens = [conv.y_len(), reads, packed, conv.backward_len(), conv.x_len()];
            needs(name, lens, |[dy, weight, turned, scratch, dx]| {
                conv.backward_input(dy, weight, turned, scratch, dx, add);
            });
        }
    }
}

/// A padded image of another convolution, with fewer channels.
#[test]
fn padded_images_of_other_convolutions() {
    for (name, new, window, [channels, filters, groups]) in convolutions() {
        let (conv, other) = (new(window, channels, filters, groups), Conv::direct(window, 1, 1, 1));
        let (x, weight) = (vec![0.5; other.x_len()], vec![0.5; conv.weight_len()]);
        let (mut scratch, mut work) = (vec![0.0; other.padded_len()], vec![0.0; conv.work_len()]);
        let (mut y, mut sums) = (vec![0.0; conv.y_len()], vec![0.0; conv.sums_len()]);
        let mut packed = vec![];
        conv.pack(&weight, &mut packed);
        for band in other.bands() {
            let padded = other.pad(&x, &AffineView::default(), band, &mut scratch);
            says_what_is_needed(name, || conv.forward(padded, &weight, &packed, None, &mut y, &mut work));
            says_what_is_needed(name, || conv.backward_weight(padded, &y, &mut sums, None, &mut work));
        }
    }
}

#[test]
fn convolutions_of_impossible_sizes() {
    let huge = Window3 { input: [1, usize::MAX, 3], ..flat(3, 3, 1, 1, 0) };
    let message = panics(|| drop(Conv::direct(huge, 2, 2, 1))).unwrap_or_default();
    assert!(message.contains("no memory holds"), "{message}");
    says_what_is_needed("no output", || drop(Conv::direct(flat(3, 0, 3, 1, 0), 2, 2, 1)));
    says_what_is_needed("groups that do not divide", || drop(Conv::direct(flat(3, 3, 3, 1, 1), 3, 2, 2)));
}

#[test]
fn matrix_products() {
    let (m, k, n) = (5, 7, 19);
    needs("matrix", [m * k], |[a]| {
        let _ = Matrix::new(a, m, k);
    });
    needs("strided matrix", [(m - 1) * 9 + k], |[a]| {
        let _ = Matrix::strided(a, m, k, 9);
    });
    for product in [matmul, few_rows] {
        needs("product", [m * k, k * n, (m - 1) * 23 + n], |[a, b, out]| {
            product(out, 23, Matrix::new(a, m, k), Matrix::new(b, k, n), true);
        });
        let (a, b) = (vec![0.5; m * k], vec![0.5; k * n]);
        says_what_is_needed("sizes that do not meet", || {
            product(&mut [0.0; 100], n, Matrix::new(&a, m, k), Matrix::new(&b, k - 1, n), false);
        });
        says_what_is_needed("rows over each other", || {
            product(&mut [0.0; 100], n - 1, Matrix::new(&a, m, k), Matrix::new(&b, k, n), false);
        });
    }
    let huge = || {
        let _ = Matrix::strided(&[0.0], 3, 1, usize::MAX);
    };
    let message = panics(huge).unwrap_or_default();
    assert!(message.contains("no memory holds"), "{message}");
}

#[test]
fn lstms() {
    let lstm = Lstm { channels: 3, steps: 4, hidden: 5 };
    let n = 2;
    let (inputs, states, weights) = (n * 12, n * 5, [60, 100, 20, 20]);
    let forward =
        |trace: &mut Trace, x: &[f32], [ih, hh, bias_ih, bias_hh]: [&mut [f32]; 4], y: &mut [f32]| {
            lstm.forward(x, &Weights { ih, hh, bias_ih, bias_hh }, trace, y);
        };
    let [ih, hh, bias_ih, bias_hh] = weights;
    needs("forward", [inputs, ih, hh, bias_ih, bias_hh, states], |[x, ih, hh, bias_ih, bias_hh, y]| {
        forward(&mut Trace::new(&lstm, n), x, [ih, hh, bias_ih, bias_hh], y);
    });
    needs("backward_gates", [states, ih, hh, bias_ih, bias_hh], |[dy, ih, hh, bias_ih, bias_hh]| {
        let weights = Weights { ih, hh, bias_ih, bias_hh };
        lstm.backward_gates(dy, &weights, &mut Trace::new(&lstm, n));
    });
    needs("backward_weights", [ih, hh, bias_ih], |[dih, dhh, dbias]| {
        lstm.backward_weights(n, &mut Trace::new(&lstm, n), dih, dhh, dbias);
    });
    needs("backward_input", [inputs, ih, hh, bias_ih, bias_hh], |[dx, ih, hh, bias_ih, bias_hh]| {
        let weights = Weights { ih, hh, bias_ih, bias_hh };
        lstm.backward_input(&Trace::new(&lstm, n), &weights, dx, false);
    });
    // A trace for one sequence fewer, and one of another layer.
    let values = vec![0.5; 200];
    let weights =
        Weights { ih: &values[..ih], hh: &values[..hh], bias_ih: &values[..20], bias_hh: &values[..20] };
    for mut trace in [Trace::new(&lstm, n - 1), Trace::new(&Lstm { hidden: 4, ..lstm }, n), Trace::default()]
    {
        let mut out = [0.0; 200];
        says_what_is_needed("forward", || {
            lstm.forward(&values[..inputs], &weights, &mut trace, &mut out[..states]);
        });
        says_what_is_needed("backward_gates", || {
            lstm.backward_gates(&values[..states], &weights, &mut trace)
        });
        says_what_is_needed("backward_weights", || {
            let (dih, rest) = out.split_at_mut(ih);
            let (dhh, dbias) = rest.split_at_mut(hh);
            lstm.backward_weights(n, &mut trace, dih, dhh, &mut dbias[..20]);
        });
        says_what_is_needed("backward_input", || {
            lstm.backward_input(&trace, &weights, &mut out[..inputs], true);
        });
    }
}

#[test]
fn grus() {
    let gru = Gru { channels: 3, steps: 4, hidden: 5 };
    let n = 2;
    let (inputs, states, [ih, hh, bias]) = (n * 12, n * 5, [45, 75, 15]);
    let room = || gru::Trace::new(&gru, n);
    needs("forward", [inputs, ih, hh, bias, bias, states], |[x, ih, hh, bias_ih, bias_hh, y]| {
        gru.forward(x, &Weights { ih, hh, bias_ih, bias_hh }, &mut room(), y);
    });
    needs("backward_gates", [states, ih, hh, bias, bias], |[dy, ih, hh, bias_ih, bias_hh]| {
        gru.backward_gates(dy, &Weights { ih, hh, bias_ih, bias_hh }, &mut room());
    });
    needs("backward_weights", [inputs, ih, hh], |[x, dih, dhh]| {
        gru.backward_weights(x, &room(), dih, dhh);
    });
    needs("backward_biases", [bias, bias], |[dbias_ih, dbias_hh]| {
        gru.backward_biases(n, &room(), dbias_ih, dbias_hh);
    });
    needs("backward_input", [inputs, ih, hh, bias, bias], |[dx, ih, hh, bias_ih, bias_hh]| {
        gru.backward_input(&room(), &Weights { ih, hh, bias_ih, bias_hh }, dx, false);
    });
    // A trace for one sequence fewer, and one of another layer.
    let values = vec![0.5; 200];
    let [bias_ih, bias_hh] = [&values[..bias]; 2];
    let weights = Weights { ih: &values[..ih], hh: &values[..hh], bias_ih, bias_hh };
    let other = Gru { hidden: 4, ..gru };
    for mut trace in [gru::Trace::new(&gru, n - 1), gru::Trace::new(&other, n), gru::Trace::default()] {
        let mut out = [0.0; 200];
        says_what_is_needed("forward", || {
            gru.forward(&values[..inputs], &weights, &mut trace, &mut out[..states]);
        });
        says_what_is_needed("backward_gates", || {
            gru.backward_gates(&values[..states], &weights, &mut trace);
        });
        says_what_is_needed("backward_weights", || {
            let (dih, dhh) = out.split_at_mut(ih);
            gru.backward_weights(&values[..inputs], &trace, dih, &mut dhh[..hh]);
        });
        says_what_is_needed("backward_biases", || {
            let (dbias_ih, dbias_hh) = out.split_at_mut(bias);
            gru.backward_biases(n, &trace, dbias_ih, &mut dbias_hh[..bias]);
        });
        says_what_is_needed("backward_input", || {
            gru.backward_input(&trace, &weights, &mut out[..inputs], true);
        });
    }
}

#[test]
fn losses() {
    let (rows, classes) = (4, 5);
    let len = rows * classes;
    needs("softmax_cross_entropy", [len; 2], |[logits, gradient]| {
        loss::softmax_cross_entropy(logits, classes, &[0, 4, 1, 2], gradient);
    });
    says_what_is_needed("softmax_cross_entropy", || {
        loss::softmax_cross_entropy(&vec![0.0; len], classes, &[0, 4, 1], &mut vec![0.0; len]);
    });
    needs("softmax_cross_entropy_soft", [len; 3], |[logits, targets, gradient]| {
        loss::softmax_cross_entropy_soft(logits, classes, targets, gradient);
    });
    needs("softmax", [classes; 2], |[logits, probabilities]| loss::softmax(logits, probabilities));
    needs("gaussian_likelihood", [2 * len, len, 2 * len], |[outputs, targets, gradient]| {
        loss::gaussian_likelihood(outputs, targets, classes, 1e-4, gradient);
    });
    needs("pinball", [3 * len, len, 3 * len], |[outputs, targets, gradient]| {
        loss::pinball(outputs, targets, classes, &[0.5, 0.1, 0.9], gradient);
    });
    for function in [loss::multi_label_soft_margin, loss::mean_squared_error, loss::huber] {
        needs("loss", [len; 3], |[outputs, targets, gradient]| {
            function(outputs, targets, gradient);
        });
    }
}

#[test]
fn optimisers() {
    needs("sgdm", [37; 3], |[weights, gradients, velocity]| {
        optim::sgdm(weights, gradients, velocity, 0.1, 0.9, 1e-4);
    });
    for optimiser in [optim::adam, optim::adamw] {
        needs("adam", [37; 4], |[weights, gradients, first, second]| {
            optimiser(weights, gradients, first, second, &Adam::default(), 1);
        });
    }
}
