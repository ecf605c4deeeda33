//! Laws of every network, which need no twin: finite differences, refusals, NaN.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../../tests/support/twin.rs"]
mod twin;

use taxel_engine::{Engine, EngineOptions, Mode, Sgdm};
use taxel_graph::{Graph, Weights};
use twin::Twin;

fn graph(twin: &Twin) -> Graph {
    taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap()
}

/// Along a random direction within each tensor, the slope of the loss is the gradient's projection.
#[test]
fn gradients_are_slopes() {
    for twin in
        Twin::all().iter().filter(|t| ["mlp", "resnet8-lite-1d", "densenet6-lite-1d"].contains(&&*t.name))
    {
        let graph = graph(twin);
        let weights = twin.weights();
        let options = EngineOptions { batch: twin.batch, threads: 1, ..EngineOptions::default() };
        let mut engine = Engine::new(&graph, &weights, options).unwrap();
        let inputs = twin.inputs(&graph, 500);
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let mut loss = |weights: &Weights| {
            engine.set_weights(weights).unwrap();
            engine.forward(&xs, twin.batch, Mode::Train).unwrap();
            let loss = engine.backward(&twin.labels()).unwrap();
            (f64::from(loss), engine.gradients())
        };
        let (_, gradients) = loss(&weights);
        let largest = gradients.iter().map(|(_, t)| norm(&t.data)).fold(0.0, f64::max);
        for (salt, (name, gradient)) in gradients.iter().enumerate() {
            let direction = twin::hashed(gradient.data.len(), 3000 + salt as u64);
            let length = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
            let mut shifted = |step: f64| {
                let mut tensor = weights.get(name).unwrap().clone();
                for (value, along) in tensor.data.iter_mut().zip(&direction) {
                    *value += (step * along / length) as f32;
                }
                let mut moved = weights.clone();
                moved.insert(name, tensor);
                loss(&moved).0
            };
            let step = 2e-3;
            let slope = (shifted(step) - shifted(-step)) / (2.0 * step);
            let projected: f64 =
                gradient.data.iter().zip(&direction).map(|(&g, v)| f64::from(g) * v / length).sum();
            let gap = (slope - projected).abs();
            assert!(
                gap <= 0.02 * projected.abs() + 2e-3 * largest,
                "{}: {name}: {slope} and {projected}",
                twin.name
            );
        }
    }
}

fn norm(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt()
}

/// Sixty-four start on any machine; of 99999 the first thousands would stop it.
#[test]
fn more_threads_than_a_machine_is_asked_for_are_refused() {
    let twin = Twin::all().into_iter().find(|t| t.name == "mlp").unwrap();
    let (graph, weights) = (graph(&twin), twin.weights());
    let options = |threads| EngineOptions { threads, ..EngineOptions::default() };
    let refusal = Engine::new(&graph, &weights, options(99_999)).err().unwrap().to_string();
    assert!(refusal.starts_with("cannot start 99999 threads: this machine has "), "{refusal}");
    assert!(refusal.ends_with(" threads are the most; try fewer threads"), "{refusal}");
    assert!(Engine::new(&graph, &weights, options(64)).is_ok());
}

#[test]
fn batches_that_do_not_fit_are_refused_and_change_nothing() {
    let twin = Twin::all().into_iter().find(|t| t.name == "hybrid-resvgg").unwrap();
    let graph = graph(&twin);
    let mut engine = Engine::new(
        &graph,
        &twin.weights(),
        EngineOptions { batch: twin.batch, threads: 1, ..EngineOptions::default() },
    )
    .unwrap();
    let inputs = twin.inputs(&graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let before = engine.weights();
    let refusal = |r: Result<&[f32], taxel_engine::Error>| r.unwrap_err().to_string();
    assert_eq!(
        refusal(engine.forward(&xs, 0, Mode::Train)),
        "hybrid-resvgg: a batch of 0 samples; compiled for 1 to 3"
    );
    assert_eq!(
        refusal(engine.forward(&xs, 4, Mode::Train)),
        "hybrid-resvgg: a batch of 4 samples; compiled for 1 to 3"
    );
    assert_eq!(
        refusal(engine.forward(&xs[..1], 3, Mode::Train)),
        "hybrid-resvgg: 1 inputs given, 2 expected"
    );
    assert_eq!(
        refusal(engine.forward(&[xs[0], &xs[1][1..]], 3, Mode::Train)),
        "hybrid-resvgg: input `image` holds 22499 values; 3 samples of channels 3 × rows 50 × columns 50 have 22500"
    );
    assert_eq!(
        engine.backward(&[0, 1, 2]).unwrap_err().to_string(),
        "hybrid-resvgg: backward needs a forward pass in training"
    );
    assert_eq!(engine.weights(), before);
    engine.forward(&xs, twin.batch, Mode::Train).unwrap();
    assert_eq!(
        engine.backward(&[0, 3, 2]).unwrap_err().to_string(),
        "hybrid-resvgg: label 3 of sample 1 is not one of 3 classes"
    );
}

#[test]
fn weights_that_do_not_fit_are_refused_by_name() {
    let twin = Twin::all().into_iter().find(|t| t.name == "mlp").unwrap();
    let graph = graph(&twin);
    let build = |weights: &Weights| {
        Engine::new(&graph, weights, EngineOptions { batch: 1, threads: 1, ..EngineOptions::default() })
            .err()
            .unwrap()
    };
    let mut extra = twin.weights();
    extra.insert("fc3.bias", twin.weights().get("fc2.bias").unwrap().clone());
    assert_eq!(build(&extra).to_string(), "mlp: tensor `fc3.bias` is not part of this network");
    let mut misshaped = twin.weights();
    misshaped.insert("fc1.bias", twin.weights().get("fc2.bias").unwrap().clone());
    assert_eq!(build(&misshaped).to_string(), "mlp: tensor `fc1.bias` has shape [3], expected [128]");
    assert_eq!(
        build(&Weights::new()).to_string(),
        "mlp: tensor `fc1.weight` is missing; expected shape [128, 250]"
    );
}

#[test]
fn nan_comes_out_as_nan() {
    for twin in Twin::all() {
        let graph = graph(&twin);
        let mut engine = Engine::new(
            &graph,
            &twin.weights(),
            EngineOptions { batch: twin.batch, threads: 1, ..EngineOptions::default() },
        )
        .unwrap();
        let mut inputs = twin.inputs(&graph, 500);
        inputs[0][7] = f32::NAN;
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let logits = engine.forward(&xs, twin.batch, Mode::Eval).unwrap();
        let classes = logits.len() / twin.batch;
        assert!(logits[..classes].iter().all(|v| v.is_nan()), "{}: the sample with NaN", twin.name);
        assert!(logits[classes..].iter().all(|v| v.is_finite()), "{}: the samples without", twin.name);
    }
}

#[test]
fn what_is_taken_out_goes_back_in() {
    for twin in Twin::all() {
        let graph = graph(&twin);
        let mut engine = Engine::new(
            &graph,
            &twin.weights(),
            EngineOptions { batch: twin.batch, threads: 1, ..EngineOptions::default() },
        )
        .unwrap();
        let (given, taken) = (twin.weights(), engine.weights());
        assert_eq!(given.len(), taken.len(), "{}", twin.name);
        for (name, tensor) in given.iter() {
            assert!(taken.get(name) == Some(tensor), "{}: {name}", twin.name);
        }
        let inputs = twin.inputs(&graph, 500);
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        engine.forward(&xs, twin.batch, Mode::Train).unwrap();
        engine.backward(&twin.labels()).unwrap();
        engine.sgdm(&Sgdm { lr: 0.1, momentum: 0.9, weight_decay: 0.0 });
        for (name, tensor) in engine.weights().iter() {
            // A bias before a batch norm has no effect, so no gradient.
            assert!(
                twin.is_idle(name) || Some(tensor) != given.get(name),
                "{}: {name} does not move",
                twin.name
            );
        }
    }
}
