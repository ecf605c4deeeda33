//! Engine and candle on graphs that no fixture holds: one operation beside another reader of its input,
//! ReLU6 behind a batch norm, dropout masks of later steps.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_devices::{Device, Model};
use taxel_engine::{Engine, EngineOptions, Mode};
use taxel_graph::{Activation, Conv, Flow, Graph, Loss, Network, Pool, Scheme, Targets, Weights};

/// More than there are parts, so that some parts hold several samples.
const BATCH: usize = 19;
const SEED: u64 = 9;

/// Largest gap between both, relative to the largest value.
fn gap(ours: &[f32], theirs: &[f32]) -> f32 {
    assert_eq!(ours.len(), theirs.len());
    let scale = theirs.iter().fold(0.0f32, |a, v| a.max(v.abs()));
    ours.iter().zip(theirs).fold(0.0f32, |gap, (a, b)| gap.max((a - b).abs())) / scale.max(1e-3)
}

/// Holds logits, loss, gradients and running statistics of three training passes against each other.
fn compare(what: &str, graph: &Graph, weights: &Weights) {
    let node = graph.inputs().next().unwrap();
    let x: Vec<f32> = (0..BATCH * node.shape.iter().product::<usize>())
        .map(|i| ((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1 << 23) as f32 - 1.0)
        .collect();
    let labels: Vec<u32> = (0..BATCH as u32).map(|i| i % 3).collect();
    let options = EngineOptions { batch: BATCH, ..EngineOptions::default() };
    let mut engine = Engine::new(graph, weights, options).unwrap();
    let mut model = Model::new(graph, weights, &Device::Cpu).unwrap();
    engine.set_dropout(SEED, 4);
    for step in 4..7 {
        model.set_dropout(SEED, step);
        engine.forward(&[&x], BATCH, Mode::Train).unwrap();
        let ours = engine.backward(&labels).unwrap();
        let (theirs, gradients) = model.loss_and_gradients(&[&x], &labels).unwrap();
        assert!((ours - theirs).abs() <= 1e-5 * theirs, "{what}, step {step}: {ours} and {theirs}");
        let largest = gradients.iter().flat_map(|(_, t)| &t.data).fold(0.0f32, |a, v| a.max(v.abs()));
        for (name, ours) in engine.gradients().iter() {
            let theirs = gradients.get(name).unwrap();
            let gap = ours.data.iter().zip(&theirs.data).fold(0.0f32, |gap, (a, b)| gap.max((a - b).abs()));
            assert!(gap <= 2e-5 * largest, "{what}, step {step}: {name}: {gap}");
        }
    }
    let (ours, theirs) = (engine.weights(), model.weights().unwrap());
    for (name, tensor) in ours.iter() {
        let gap = gap(&tensor.data, &theirs.get(name).unwrap().data);
        assert!(gap <= 1e-5, "{what}: {name}: {gap}");
    }
    let theirs = model.forward(&[&x], BATCH, false).unwrap().remove(0).1;
    let gap = gap(engine.forward(&[&x], BATCH, Mode::Eval).unwrap(), &theirs);
    assert!(gap <= 1e-5, "{what}: evaluation: {gap}");
}

fn fresh(graph: &Graph) -> Weights {
    Weights::init(graph, Scheme::Pytorch, 1, "engine")
}

/// Labels smoothed and weighted: rows that do not add up to 1.
#[test]
fn soft_targets() {
    for loss in [Loss::SoftmaxCrossEntropy, Loss::MultiLabelSoftMargin, Loss::CumulativeLogits, Loss::Hinge] {
        compare_soft_targets(loss, 1.0);
    }
}

#[test]
fn values() {
    for loss in [Loss::MeanSquaredError, Loss::Huber, Loss::GaussianLikelihood, Loss::Quantiles] {
        // Errors within 1 and far beyond.
        for scale in [1.0, 9.0] {
            compare_soft_targets(loss, scale);
        }
    }
}

fn compare_soft_targets(loss: Loss, scale: f32) {
    let net = Network::new("soft");
    let logits = net.input("signal", &[3, 6]).flatten().linear("fc", 3 * loss.outputs_per_target());
    let graph = net.finish(&[("logits", logits)]).unwrap();
    let weights = fresh(&graph);
    let x: Vec<f32> = (0..4 * 18).map(|i| (i as f32 * 0.7).sin()).collect();
    let targets = [0.9, 0.05, 0.05, 0.1, 1.8, 0.1, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0];
    let targets = targets.map(|value: f32| scale * value);
    let targets = Targets::Values(&targets);
    let options = EngineOptions { batch: 4, ..EngineOptions::default() };
    let mut engine = Engine::new(&graph, &weights, options).unwrap();
    engine.forward(&[&x], 4, Mode::Train).unwrap();
    let ours = engine.backward_with(loss, targets).unwrap();
    let model = Model::new(&graph, &weights, &Device::Cpu).unwrap();
    let (theirs, gradients) = model.loss_and_gradients_with(&[&x], 4, loss, targets).unwrap();
    assert!((ours - theirs).abs() <= 2e-6 * ours && ours > 0.1, "{loss:?}: {ours} and {theirs}");
    for (name, ours) in engine.gradients().iter() {
        let gap = gap(&ours.data, &gradients.get(name).unwrap().data);
        assert!(gap <= 1e-5, "{loss:?}: {name}: {gap}");
    }
}

/// Gradients meet in the input of the operation: one reader writes, the other adds.
#[test]
fn operations_beside_another_reader() {
    type Case = (&'static str, &'static [usize], fn(&Flow) -> Flow);
    let cases: [Case; 20] = [
        ("leaky_relu", &[3, 4, 5], |x| x.activation(Activation::LeakyRelu { slope: 0.1 })),
        ("sigmoid", &[3, 4, 5], |x| x.activation(Activation::Sigmoid)),
        ("tanh", &[3, 7], |x| x.activation(Activation::Tanh)),
        ("hard_swish", &[3, 4, 5], |x| x.activation(Activation::HardSwish)),
        ("relu6", &[3, 4, 5], |x| x.activation(Activation::Relu6)),
        ("relu6 twice", &[3, 4, 5], |x| x.activation(Activation::Relu6).activation(Activation::Relu6)),
        ("dropout", &[3, 4, 5], |x| x.dropout(0.4)),
        ("two dropouts", &[3, 4, 5], |x| x.dropout(0.2).dropout(0.3)),
        ("scale", &[3, 4, 5], |x| x.scale("op", 0.7)),
        ("shuffle", &[6, 4, 5], |x| x.channel_shuffle(3)),
        ("slice", &[5, 4, 5], |x| x.slice(1, 3)),
        ("adaptive", &[3, 5, 7], |x| x.adaptive_average_pool([2, 3])),
        ("deviation", &[3, 5, 7], |x| x.global_standard_deviation(1e-3)),
        ("layer norm", &[3, 5, 7], |x| x.flatten().layer_norm_with("op", 1e-3)),
        ("layer norm of few", &[3, 4, 2], |x| x.global_average_pool().layer_norm("op")),
        ("dilated", &[3, 9], |x| x.conv("op", Conv::new(4, 3).dilation(2).same())),
        ("lstm", &[3, 6], |x| x.lstm("op", 4)),
        ("gru", &[3, 6], |x| x.gru("op", 4)),
        ("gru of frames", &[3, 1, 1, 5], |x| x.gru("op", 9)),
        ("max", &[3, 5, 6], |x| x.max_pool(Pool::new(2).stride(1))),
    ];
    for (what, shape, operation) in cases {
        for norm in [false, true] {
            let net = Network::new(what);
            let x = net.input("x", shape).conv("pre", Conv::new(shape[0], 1));
            // A batch norm and a rectifier that readers apply themselves.
            let x = if norm { x.batch_norm("norm").relu() } else { x };
            let first = operation(&x).flatten().concat(&x.flatten());
            let graph = net.finish(&[("logits", first.linear("head", 3))]).unwrap();
            compare(what, &graph, &fresh(&graph));
            // The operation as the later reader of two.
            let net = Network::new(what);
            let x = net.input("x", shape).conv("pre", Conv::new(shape[0], 1));
            let x = if norm { x.batch_norm("norm").relu() } else { x };
            let other = x.flatten();
            let second = other.concat(&operation(&x).flatten());
            let graph = net.finish(&[("logits", second.linear("head", 3))]).unwrap();
            compare(what, &graph, &fresh(&graph));
        }
    }
}

/// A wide scale drives values beyond both corners of ReLU6.
#[test]
fn relu6_seen_through_a_batch_norm() {
    let net = Network::new("rectified");
    let x = net.input("x", &[3, 6, 7]).conv("pre", Conv::new(5, 3).same()).batch_norm("norm");
    let x = x.activation(Activation::Relu6);
    let pooled = x.max_pool(Pool::new(2)).flatten();
    let mean = x.global_average_pool();
    let conv = x.conv("conv", Conv::new(4, 3).stride(2)).flatten();
    let all = net.concat("all", &[&pooled, &mean, &conv, &x.flatten()]);
    let graph = net.finish(&[("logits", all.linear("head", 3))]).unwrap();
    let mut weights = fresh(&graph);
    let mut wide = weights.get("norm.weight").unwrap().clone();
    wide.data.fill(8.0);
    weights.insert("norm.weight", wide);
    compare("rectified", &graph, &weights);
}

/// An output that others read too, seen through a batch norm, and given out twice.
#[test]
fn outputs_in_the_middle_of_a_network() {
    let net = Network::new("middle");
    let x = net.input("x", &[3, 6, 7]).conv("pre", Conv::new(5, 3).same()).batch_norm("norm").relu();
    let early = x.global_average_pool().linear("early", 3).batch_norm("early_norm");
    let late = early.relu().concat(&early).linear("late", 3);
    let outputs = [("late", late), ("early", early.clone()), ("again", early)];
    let graph = net.finish_weighted(&outputs, &[1.0, 0.3, 0.5]).unwrap();
    compare("middle", &graph, &fresh(&graph));
}

/// Gradients through both fixed operations, and none into the stream that is looked at.
#[test]
fn streams_behind_layers_that_learn() {
    for swapped in [false, true] {
        let net = Network::new("streams");
        let x = net.input("x", &[3, 6, 7]).conv("pre", Conv::new(4, 3).same()).batch_norm("norm").relu();
        // Later readers come first in the backward pass, earlier ones add to what they left.
        let before = swapped.then(|| x.flatten());
        let stream = x.standardize("mean", "std");
        let (first, second) = (stream.conv("first", Conv::new(2, 1)), stream.conv("second", Conv::new(2, 1)));
        let before = before.map(|x| x.concat(&second.flatten()));
        let lit = first.switch_scale(&second).flatten();
        let other = before.unwrap_or_else(|| x.flatten().concat(&second.flatten()));
        let all = lit.concat(&other);
        let graph = net.finish(&[("logits", all.linear("head", 3))]).unwrap();
        let mut weights = fresh(&graph);
        for (name, values) in [("mean", vec![0.1, -0.2, 0.3, 0.0]), ("std", vec![0.5, 2.0, 1.0, 3.0])] {
            weights.insert(name, taxel_graph::Tensor { shape: vec![4], data: values });
        }
        compare("streams", &graph, &weights);
    }
}
