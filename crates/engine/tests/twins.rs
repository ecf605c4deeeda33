//! Every network against its PyTorch twin: logits, loss, every gradient, running statistics, five
//! SGDM steps, recomputed statistics. The reference is computed in float64.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../../tests/support/twin.rs"]
mod twin;

use taxel_engine::{Engine, EngineOptions, Mode, Sgdm};
use taxel_graph::{Graph, Loss, Targets, Weights};
use twin::Twin;

fn slices(inputs: &[Vec<f32>]) -> Vec<&[f32]> {
    inputs.iter().map(Vec::as_slice).collect()
}

fn compile(twin: &Twin, threads: usize) -> (Graph, Engine) {
    let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
    let engine = engine(twin, &graph, threads);
    (graph, engine)
}

fn engine(twin: &Twin, graph: &Graph, threads: usize) -> Engine {
    Engine::new(graph, &twin.weights(), EngineOptions { batch: 4, threads, ..EngineOptions::default() })
        .unwrap()
}

/// The loss of the last training pass, as the fixture measures it.
fn backward(twin: &Twin, engine: &mut Engine) -> f32 {
    match twin.objective() {
        Loss::SoftmaxCrossEntropy => engine.backward(&twin.labels()).unwrap(),
        loss => engine.backward_with(loss, Targets::Values(&twin.target_values())).unwrap(),
    }
}

fn compare(twin: &Twin, graph: &Graph) {
    let mut engine = engine(twin, graph, 1);
    let inputs = twin.inputs(graph, 500);
    let xs = slices(&inputs);
    let tolerance = twin.tolerance();
    let logits = engine.forward(&xs, twin.batch, Mode::Eval).unwrap();
    twin.assert_values("eval_logits", logits, tolerance.values);
    let logits = engine.forward(&xs, twin.batch, Mode::Train).unwrap();
    twin.assert_values("train_logits", logits, tolerance.values);
    twin.assert_loss(backward(twin, &mut engine), tolerance.values);
    let gradients = engine.gradients();
    assert_eq!(gradients.len(), twin.count("gradients"), "{}", twin.name);
    twin.assert_digests("gradients", |name| gradients.get(name).map(|t| t.data.clone()), tolerance.gradients);
    let weights = engine.weights();
    twin.assert_digests("running", |name| weights.get(name).map(|t| t.data.clone()), tolerance.values);
}

#[test]
fn networks_logits_loss_and_every_gradient() {
    for twin in Twin::all() {
        compare(&twin, &compile(&twin, 1).0);
    }
}

#[test]
fn operations_on_awkward_shapes_and_losses() {
    for (twin, graph) in Twin::operations() {
        compare(&twin, &graph);
    }
}

#[test]
fn five_steps_of_sgdm() {
    for twin in Twin::all() {
        let (graph, mut engine) = compile(&twin, 1);
        let inputs = twin.inputs(&graph, 500);
        let losses: Vec<f32> = (0..5)
            .map(|_| {
                engine.forward(&slices(&inputs), twin.batch, Mode::Train).unwrap();
                let loss = engine.backward(&twin.labels()).unwrap();
                engine.sgdm(&Sgdm { lr: twin.rate(), momentum: 0.9, weight_decay: 1e-3 });
                loss
            })
            .collect();
        twin.assert_steps(&losses);
    }
}

#[test]
fn recomputed_statistics() {
    for twin in Twin::all() {
        let (graph, mut engine) = compile(&twin, 2);
        let before = engine.weights();
        engine.begin_recomputing();
        for salt in [500, 600] {
            let inputs = twin.inputs(&graph, salt);
            engine.forward(&slices(&inputs), twin.batch, Mode::Train).unwrap();
        }
        let during = engine.weights();
        assert_eq!(during, before, "{}: gathering must not move anything", twin.name);
        engine.end_recomputing();
        let weights = engine.weights();
        let values = twin.tolerance().values;
        twin.assert_digests("population", |name| weights.get(name).map(|t| t.data.clone()), values);
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    for twin in Twin::all() {
        let run = |threads| -> (Vec<u32>, Weights) {
            let (graph, mut engine) = compile(&twin, threads);
            let inputs = twin.inputs(&graph, 500);
            let logits = engine.forward(&slices(&inputs), twin.batch, Mode::Train).unwrap();
            let bits = logits.iter().map(|v| v.to_bits()).collect();
            engine.backward(&twin.labels()).unwrap();
            engine.sgdm(&Sgdm { lr: 0.1, momentum: 0.9, weight_decay: 0.0 });
            (bits, engine.weights())
        };
        assert_eq!(run(1), run(2), "{}", twin.name);
        assert_eq!(run(1), run(3), "{}", twin.name);
    }
}

#[test]
fn a_smaller_batch_sees_only_itself() {
    for twin in Twin::all() {
        let (graph, mut engine) = compile(&twin, 1);
        let inputs = twin.inputs(&graph, 500);
        let all = engine.forward(&slices(&inputs), twin.batch, Mode::Eval).unwrap().to_vec();
        let classes = all.len() / twin.batch;
        let first: Vec<&[f32]> = inputs.iter().map(|x| &x[..x.len() / twin.batch]).collect();
        let one = engine.forward(&first, 1, Mode::Eval).unwrap();
        // Matrix products of one row and of several add in another order.
        let scale = all.iter().fold(0.0f32, |a, v| a.max(v.abs()));
        for (one, all) in one.iter().zip(&all[..classes]) {
            assert!((one - all).abs() <= 1e-6 * scale, "{}: {one} and {all}", twin.name);
        }
        assert_eq!(one.len(), classes);
    }
}
