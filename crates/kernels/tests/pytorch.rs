//! Kernels against numbers that PyTorch computed in float64 (`scripts/fixtures/kernels.py`), and NaN.

#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use taxel_kernels::adaptive_pool::AdaptivePool;
use taxel_kernels::gru::{self, Gru};
use taxel_kernels::lstm::{Lstm, Trace, Weights};
use taxel_kernels::optim::{Adam, adam, adamw, clip_by_global_norm};
use taxel_kernels::{activation, layer_norm, loss};

fn cases() -> Value {
    serde_json::from_str(include_str!("data/kernels.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f32> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect()
}

fn size(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

/// Gaps relative to the largest value of the tensor.
fn close(what: &str, got: &[f32], want: &Value, relative: f32) {
    let want = numbers(want);
    assert_eq!(got.len(), want.len(), "{what}");
    let scale = want.iter().fold(0.0f32, |a, v| a.max(v.abs()));
    for (i, (got, want)) in got.iter().zip(&want).enumerate() {
        assert!((got - want).abs() <= relative * scale, "{what}[{i}]: got {got}, want {want}");
    }
}

type Loss = fn(&[f32], &[f32], &mut [f32]) -> f32;
type Forward = fn(&[f32], &mut [f32]);
/// Whether the backward pass reads the output (true) or the input, and the pass.
type Backward = (bool, fn(&[f32], &[f32], &mut [f32], bool));

const ACTIVATIONS: [(&str, Forward, Backward); 5] = [
    ("relu6", activation::relu6, (false, activation::relu6_backward)),
    (
        "leaky_relu",
        |x, y| activation::leaky_relu(0.25, x, y),
        (false, |x, dy, dx, add| activation::leaky_relu_backward(0.25, x, dy, dx, add)),
    ),
    ("sigmoid", activation::sigmoid, (true, activation::sigmoid_backward)),
    ("tanh", activation::tanh, (true, activation::tanh_backward)),
    ("hard_swish", activation::hard_swish, (false, activation::hard_swish_backward)),
];

#[test]
fn activations_and_their_gradients() {
    let cases = cases();
    for (name, forward, (from_output, backward)) in ACTIVATIONS {
        let case = &cases[name];
        let (x, dy) = (numbers(&case["x"]), numbers(&case["dy"]));
        let mut y = vec![0.0; x.len()];
        forward(&x, &mut y);
        // Value by value: the largest input is 200, and small outputs count as much.
        for (i, (got, want)) in y.iter().zip(numbers(&case["y"])).enumerate() {
            assert!((got - want).abs() <= 1e-6 * want.abs().max(1e-3), "{name}[{i}]: got {got}, want {want}");
        }
        let kept = if from_output { &y } else { &x };
        let mut dx = vec![f32::NAN; x.len()];
        backward(kept, &dy, &mut dx, false);
        close(name, &dx, &case["dx"], 1e-5);
        let once = dx.clone();
        backward(kept, &dy, &mut dx, true);
        assert!(dx.iter().zip(&once).all(|(twice, once)| *twice == 2.0 * once), "{name}: added");
    }
}

#[test]
fn activations_let_nan_through() {
    for (name, forward, _) in ACTIVATIONS {
        let mut y = [0.0];
        forward(&[f32::NAN], &mut y);
        assert!(y[0].is_nan(), "{name}");
    }
}

#[test]
fn lstm_and_every_gradient() {
    for case in cases()["lstm"].as_array().unwrap() {
        let lstm = Lstm {
            channels: size(&case["channels"]),
            steps: size(&case["steps"]),
            hidden: size(&case["hidden"]),
        };
        let [x, ih, hh, bias_ih, bias_hh, dy] =
            ["x", "w_ih", "w_hh", "b_ih", "b_hh", "dy"].map(|key| numbers(&case[key]));
        let weights = Weights { ih: &ih, hh: &hh, bias_ih: &bias_ih, bias_hh: &bias_hh };
        let mut y = vec![f32::NAN; dy.len()];
        // Room for more samples than come, and the second run meets what the first left.
        let mut trace = Trace::new(&lstm, size(&case["batch"]) + 2);
        for _ in 0..2 {
            lstm.forward(&x, &weights, &mut trace, &mut y);
            close("y", &y, &case["y"], 1e-5);
            lstm.backward_gates(&dy, &weights, &mut trace);
            let (mut dih, mut dhh) = (vec![f32::NAN; ih.len()], vec![f32::NAN; hh.len()]);
            let mut dbias = vec![f32::NAN; bias_ih.len()];
            lstm.backward_weights(dy.len() / lstm.hidden, &mut trace, &mut dih, &mut dhh, &mut dbias);
            close("dw_ih", &dih, &case["dw_ih"], 1e-5);
            close("dw_hh", &dhh, &case["dw_hh"], 1e-5);
            close("db_ih", &dbias, &case["db_ih"], 1e-5);
            close("db_hh", &dbias, &case["db_hh"], 1e-5);
            let mut dx = vec![f32::NAN; x.len()];
            lstm.backward_input(&trace, &weights, &mut dx, false);
            close("dx", &dx, &case["dx"], 1e-5);
            let once = dx.clone();
            lstm.backward_input(&trace, &weights, &mut dx, true);
            assert!(dx.iter().zip(&once).all(|(twice, once)| (twice - 2.0 * once).abs() <= 1e-6), "added");
        }
    }
}

#[test]
fn gru_and_every_gradient() {
    for case in cases()["gru"].as_array().unwrap() {
        let [channels, steps, hidden, batch] =
            ["channels", "steps", "hidden", "batch"].map(|key| size(&case[key]));
        let gru = Gru { channels, steps, hidden };
        let [x, ih, hh, bias_ih, bias_hh, dy] =
            ["x", "w_ih", "w_hh", "b_ih", "b_hh", "dy"].map(|key| numbers(&case[key]));
        let weights = Weights { ih: &ih, hh: &hh, bias_ih: &bias_ih, bias_hh: &bias_hh };
        let mut y = vec![f32::NAN; dy.len()];
        // Room for more samples than come, and the second run meets what the first left.
        let mut trace = gru::Trace::new(&gru, batch + 2);
        for _ in 0..2 {
            gru.forward(&x, &weights, &mut trace, &mut y);
            close("y", &y, &case["y"], 1e-5);
            gru.backward_gates(&dy, &weights, &mut trace);
            let [mut dih, mut dhh, mut dbias_ih, mut dbias_hh] =
                [&ih, &hh, &bias_ih, &bias_hh].map(|tensor| vec![f32::NAN; tensor.len()]);
            gru.backward_weights(&x, &trace, &mut dih, &mut dhh);
            gru.backward_biases(batch, &trace, &mut dbias_ih, &mut dbias_hh);
            for (key, got) in [("dw_ih", &dih), ("dw_hh", &dhh), ("db_ih", &dbias_ih), ("db_hh", &dbias_hh)] {
                close(key, got, &case[key], 1e-5);
            }
            let mut dx = vec![f32::NAN; x.len()];
            gru.backward_input(&trace, &weights, &mut dx, false);
            close("dx", &dx, &case["dx"], 1e-5);
            let once = dx.clone();
            gru.backward_input(&trace, &weights, &mut dx, true);
            assert!(dx.iter().zip(&once).all(|(twice, once)| (twice - 2.0 * once).abs() <= 1e-6), "added");
        }
    }
}

#[test]
fn gru_forgets_a_batch_of_another_size() {
    let gru = Gru { channels: 2, steps: 3, hidden: 5 };
    let numbers =
        |count: usize| (0..count).map(|i| ((i * 29 + 3) % 17) as f32 / 17.0 - 0.5).collect::<Vec<f32>>();
    let (ih, hh, bias, x) = (numbers(30), numbers(75), numbers(15), numbers(4 * 6));
    let weights = Weights { ih: &ih, hh: &hh, bias_ih: &bias, bias_hh: &bias };
    let pass = |trace: &mut gru::Trace, n: usize| {
        let (mut y, mut dih, mut dhh) = (vec![0.0; n * 5], vec![0.0; 30], vec![0.0; 75]);
        let [mut dbias_ih, mut dbias_hh] = [(); 2].map(|()| vec![0.0; 15]);
        gru.forward(&x[..n * 6], &weights, trace, &mut y);
        gru.backward_gates(&vec![1.0; n * 5], &weights, trace);
        gru.backward_weights(&x[..n * 6], trace, &mut dih, &mut dhh);
        gru.backward_biases(n, trace, &mut dbias_ih, &mut dbias_hh);
        [y, dih, dhh, dbias_ih, dbias_hh]
    };
    let mut used = gru::Trace::new(&gru, 4);
    for n in [2, 4, 1, 3] {
        assert_eq!(pass(&mut used, n), pass(&mut gru::Trace::new(&gru, 4), n), "{n} after others");
    }
}

#[test]
fn gru_lets_nan_through() {
    let gru = Gru { channels: 1, steps: 3, hidden: 2 };
    let (ih, hh, bias) = ([0.5; 6], [0.5; 12], [0.1; 6]);
    let weights = Weights { ih: &ih, hh: &hh, bias_ih: &bias, bias_hh: &bias };
    let (mut trace, mut y) = (gru::Trace::new(&gru, 2), [0.0; 4]);
    gru.forward(&[1.0, f32::NAN, 1.0, 1.0, 1.0, 1.0], &weights, &mut trace, &mut y);
    assert!(y[0].is_nan() && y[1].is_nan() && y[2].is_finite() && y[3].is_finite());
}

#[test]
fn lstm_forgets_a_batch_of_another_size() {
    let lstm = Lstm { channels: 2, steps: 3, hidden: 5 };
    let value = |i: usize| ((i * 29 + 3) % 17) as f32 / 17.0 - 0.5;
    let numbers = |count: usize| (0..count).map(value).collect::<Vec<f32>>();
    let (ih, hh, bias, x) = (numbers(40), numbers(100), numbers(20), numbers(4 * 6));
    let weights = Weights { ih: &ih, hh: &hh, bias_ih: &bias, bias_hh: &bias };
    let pass = |trace: &mut Trace, n: usize| {
        let (mut y, mut dih, mut dhh, mut dbias) =
            (vec![0.0; n * 5], vec![0.0; 40], vec![0.0; 100], vec![0.0; 20]);
        lstm.forward(&x[..n * 6], &weights, trace, &mut y);
        lstm.backward_gates(&vec![1.0; n * 5], &weights, trace);
        lstm.backward_weights(n, trace, &mut dih, &mut dhh, &mut dbias);
        [y, dih, dhh, dbias]
    };
    let mut used = Trace::new(&lstm, 4);
    for n in [2, 4, 1, 3] {
        assert_eq!(pass(&mut used, n), pass(&mut Trace::new(&lstm, 4), n), "{n} after others");
    }
}

#[test]
fn lstm_lets_nan_through() {
    let lstm = Lstm { channels: 1, steps: 3, hidden: 2 };
    let (ih, hh, bias) = ([0.5; 8], [0.5; 16], [0.1; 8]);
    let weights = Weights { ih: &ih, hh: &hh, bias_ih: &bias, bias_hh: &bias };
    let (mut trace, mut y) = (Trace::new(&lstm, 2), [0.0; 4]);
    lstm.forward(&[1.0, f32::NAN, 1.0, 1.0, 1.0, 1.0], &weights, &mut trace, &mut y);
    assert!(y[0].is_nan() && y[1].is_nan() && y[2].is_finite() && y[3].is_finite());
}

#[test]
fn adaptive_pools() {
    for case in cases()["adaptive"].as_array().unwrap() {
        let axes = |key: &str| [0, 1, 2].map(|axis| size(&case[key][axis]));
        let pool =
            AdaptivePool { input: axes("size"), output: axes("output"), channels: size(&case["channels"]) };
        let (x, dy) = (numbers(&case["x"]), numbers(&case["dy"]));
        let mut y = vec![f32::NAN; dy.len()];
        pool.forward(&x, &mut y);
        close("y", &y, &case["y"], 1e-5);
        let mut dx = vec![0.0; x.len()];
        pool.backward(&dy, &mut dx);
        close("dx", &dx, &case["dx"], 1e-5);
        let mut spoiled = x;
        spoiled[0] = f32::NAN;
        pool.forward(&spoiled, &mut y);
        assert!(y[0].is_nan() && y[1].is_finite());
    }
}

#[test]
fn layer_norms() {
    for case in cases()["layer_norm"].as_array().unwrap() {
        let [weight, bias, x, dy] = ["weight", "bias", "x", "dy"].map(|key| numbers(&case[key]));
        let (mut y, eps) = (vec![f32::NAN; x.len()], case["eps"].as_f64().unwrap() as f32);
        let moments = layer_norm::forward(eps, &x, &weight, &bias, &mut y);
        close("y", &y, &case["y"], 1e-5);
        let mut dx = vec![f32::NAN; x.len()];
        layer_norm::backward(moments, &x, &weight, &dy, &mut dx, false);
        close("dx", &dx, &case["dx"], 1e-5);
        let once = dx.clone();
        layer_norm::backward(moments, &x, &weight, &dy, &mut dx, true);
        assert!(dx.iter().zip(&once).all(|(twice, once)| *twice == 2.0 * once), "added");
        let [mut dweight, mut dbias] = [(); 2].map(|()| vec![0.0; x.len()]);
        for _ in 0..2 {
            layer_norm::add_gradients(moments, &x, &dy, &mut dweight, &mut dbias);
        }
        for (what, twice) in [("dweight", dweight), ("dbias", dbias)] {
            close(what, &twice.iter().map(|v| v / 2.0).collect::<Vec<f32>>(), &case[what], 1e-5);
        }
        let mut spoiled = x;
        spoiled[1] = f32::NAN;
        layer_norm::forward(eps, &spoiled, &weight, &bias, &mut y);
        assert!(y.iter().all(|y| y.is_nan()));
    }
}

#[test]
fn losses_and_their_gradients() {
    let cases = cases();
    let functions: [(&str, Loss); 5] = [
        ("multi_label_soft_margin", loss::multi_label_soft_margin),
        ("mean_squared_error", loss::mean_squared_error),
        ("huber", loss::huber),
        ("gaussian_likelihood", |x, targets, gradient| {
            loss::gaussian_likelihood(x, targets, 2, 1e-4, gradient)
        }),
        ("pinball", |x, targets, gradient| loss::pinball(x, targets, 2, &[0.5, 0.05, 0.95], gradient)),
    ];
    for (name, function) in functions {
        let case = &cases[name];
        let (mut x, targets) = (numbers(&case["x"]), numbers(&case["targets"]));
        let mut gradient = vec![f32::NAN; x.len()];
        let got = function(&x, &targets, &mut gradient);
        let want = case["loss"].as_f64().unwrap() as f32;
        assert!((got - want).abs() <= 1e-6 * want.abs(), "{name}: got {got}, want {want}");
        close(name, &gradient, &case["gradient"], 1e-5);
        x[3] = f32::NAN;
        assert!(function(&x, &targets, &mut gradient).is_nan() && gradient[3].is_nan(), "{name}");
    }
}

#[test]
fn adam_and_adamw_step_by_step() {
    let cases = cases();
    let settings = Adam { lr: 0.01, weight_decay: 0.1, ..Adam::default() };
    for name in ["adam", "adamw"] {
        let case = &cases[name];
        let mut weights = numbers(&case["w"]);
        let (mut first, mut second) = (vec![0.0; weights.len()], vec![0.0; weights.len()]);
        for step in 0..5 {
            let gradients = numbers(&case["gradients"][step]);
            let optimiser = if name == "adam" { adam } else { adamw };
            optimiser(&mut weights, &gradients, &mut first, &mut second, &settings, step as u64 + 1);
            close(name, &weights, &case["weights"][step], 1e-6);
        }
    }
}

#[test]
fn gradients_are_clipped_by_their_norm() {
    let cases = cases();
    for name in ["clipped", "unclipped"] {
        let case = &cases[name];
        let mut gradients = numbers(&case["before"]);
        let norm = clip_by_global_norm(&mut gradients, case["largest"].as_f64().unwrap() as f32);
        close(name, &[norm], &serde_json::json!([case["norm"]]), 1e-6);
        close(name, &gradients, &case["after"], 1e-6);
    }
    let mut gradients = [1.0, f32::NAN];
    assert!(clip_by_global_norm(&mut gradients, 1.0).is_nan());
    assert!(gradients.iter().all(|g| g.is_nan()), "as in PyTorch");
}
