//! Every network against its PyTorch twin on candle, and against the engine.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../../tests/support/twin.rs"]
mod twin;

use taxel_devices::{Device, Model};
use taxel_engine::{Engine, EngineOptions, Mode};
use taxel_graph::{Graph, Loss, Targets, Weights};
use twin::Twin;

#[test]
fn networks_logits_loss_and_every_gradient() {
    for twin in Twin::all() {
        let graph = graph(&twin);
        let logits = compare(&twin, &graph);
        compare_with_engine(&twin, &graph, &logits);
    }
}

#[test]
fn operations_on_awkward_shapes_and_losses() {
    for (twin, graph) in Twin::operations() {
        let logits = compare(&twin, &graph);
        compare_with_engine(&twin, &graph, &logits);
    }
}

#[test]
fn several_outputs() {
    let twins = Twin::several_outputs();
    assert_eq!(twins.len(), 3, "run scripts/fixtures/outputs.py");
    for twin in twins {
        let graph = graph(&twin);
        let model = Model::new(&graph, &twin.weights(), &Device::Cpu).unwrap();
        let inputs = twin.inputs(&graph, 500);
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let outputs = model.forward(&xs, twin.batch, false).unwrap();
        let names: Vec<String> = outputs.iter().map(|(name, _)| name.clone()).collect();
        assert_eq!(names, twin.outputs(), "{}", twin.name);
        for (name, values) in outputs {
            twin.assert_values(&name, &values, 1e-4);
        }
        let (loss, gradients) = model.loss_and_gradients(&xs, &twin.labels()).unwrap();
        assert_several(&twin, loss, &gradients, &model.weights().unwrap());
    }
}

#[test]
fn several_outputs_on_the_engine() {
    for twin in Twin::several_outputs() {
        let graph = graph(&twin);
        let options = EngineOptions { batch: twin.batch, ..EngineOptions::default() };
        let mut engine = Engine::new(&graph, &twin.weights(), options).unwrap();
        let inputs = twin.inputs(&graph, 500);
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let first = engine.forward(&xs, twin.batch, Mode::Eval).unwrap().to_vec();
        let outputs: Vec<(&str, &[f32])> = engine.outputs().collect();
        assert_eq!(outputs[0].1, first);
        assert_eq!(outputs.iter().map(|o| o.0).collect::<Vec<_>>(), twin.outputs(), "{}", twin.name);
        for (name, values) in outputs {
            twin.assert_values(name, values, 1e-4);
        }
        engine.forward(&xs, twin.batch, Mode::Train).unwrap();
        let loss = engine.backward(&twin.labels()).unwrap();
        assert_several(&twin, loss, &engine.gradients(), &engine.weights());
    }
}

fn assert_several(twin: &Twin, loss: f32, gradients: &Weights, weights: &Weights) {
    let tolerance = twin.tolerance();
    twin.assert_loss(loss, tolerance.values);
    assert_eq!(gradients.len(), twin.count("gradients"), "{}", twin.name);
    twin.assert_digests("gradients", |name| gradients.get(name).map(|t| t.data.clone()), tolerance.gradients);
    twin.assert_digests("running", |name| weights.get(name).map(|t| t.data.clone()), tolerance.values);
}

#[test]
fn targets_that_do_not_fit_are_refused() {
    let (twin, graph) = Twin::operations().remove(0);
    let model = Model::new(&graph, &twin.weights(), &Device::Cpu).unwrap();
    let inputs = twin.inputs(&graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let refuse = |loss, targets| {
        let error = model.loss_and_gradients_with(&xs, twin.batch, loss, targets).unwrap_err().to_string();
        error.strip_prefix(graph.name()).unwrap().to_string()
    };
    let entropy = Loss::SoftmaxCrossEntropy;
    assert_eq!(refuse(entropy, Targets::Labels(&[0, 3, 1])), ": label 3 of sample 1 is not one of 3 classes");
    assert_eq!(refuse(entropy, Targets::Labels(&[0, 1])), ": 2 labels for a batch of 3 samples");
    assert_eq!(refuse(entropy, Targets::Values(&[0.0; 8])), ": 8 target values for 3 samples of 3 outputs");
    for loss in [Loss::MultiLabelSoftMargin, Loss::Hinge, Loss::MeanSquaredError] {
        assert_eq!(refuse(loss, Targets::Labels(&[0, 1, 2])), ": this loss needs target values, not labels");
        assert_eq!(refuse(loss, Targets::Values(&[0.0; 8])), ": 8 target values for 3 samples of 3 outputs");
    }
}

#[test]
fn dropout_masks_follow_seed_and_step_and_rest_in_evaluation() {
    let (twin, graph) =
        Twin::operations().into_iter().find(|(twin, _)| twin.name.starts_with("dropout")).unwrap();
    let mut model = Model::new(&graph, &twin.weights(), &Device::Cpu).unwrap();
    let inputs = twin.inputs(&graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut run = |seed, step, train| {
        model.set_dropout(seed, step);
        model.forward(&xs, twin.batch, train).unwrap().remove(0).1
    };
    let first = run(1, 0, true);
    assert_eq!(first, run(1, 0, true));
    assert_ne!(first, run(1, 1, true));
    assert_ne!(first, run(2, 0, true));
    assert_eq!(run(1, 0, false), run(2, 5, false));
}

fn graph(twin: &Twin) -> Graph {
    taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap()
}

/// Holds candle against the fixture; returns the logits in evaluation.
fn compare(twin: &Twin, graph: &Graph) -> Vec<f32> {
    let model = Model::new(graph, &twin.weights(), &Device::Cpu).unwrap();
    let inputs = twin.inputs(graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut outputs = model.forward(&xs, twin.batch, false).unwrap();
    assert_eq!(outputs[0].0, "logits");
    let tolerance = twin.tolerance();
    twin.assert_values("eval_logits", &outputs[0].1, tolerance.values);
    let (loss, gradients) = loss_and_gradients(&model, twin, &xs);
    twin.assert_loss(loss, tolerance.values);
    assert_eq!(gradients.len(), twin.count("gradients"), "{}", twin.name);
    twin.assert_digests("gradients", |name| gradients.get(name).map(|t| t.data.clone()), tolerance.gradients);
    let weights = model.weights().unwrap();
    twin.assert_digests("running", |name| weights.get(name).map(|t| t.data.clone()), tolerance.values);
    outputs.remove(0).1
}

fn loss_and_gradients(model: &Model, twin: &Twin, xs: &[&[f32]]) -> (f32, Weights) {
    let loss = twin.objective();
    if loss == Loss::SoftmaxCrossEntropy {
        return model.loss_and_gradients(xs, &twin.labels()).unwrap();
    }
    let targets = twin.target_values();
    model.loss_and_gradients_with(xs, twin.batch, loss, Targets::Values(&targets)).unwrap()
}

fn compare_with_engine(twin: &Twin, graph: &Graph, logits: &[f32]) {
    let inputs = twin.inputs(graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut engine = Engine::new(
        graph,
        &twin.weights(),
        EngineOptions { batch: twin.batch, threads: 1, ..EngineOptions::default() },
    )
    .unwrap();
    let ours = engine.forward(&xs, twin.batch, Mode::Eval).unwrap();
    let scale = ours.iter().fold(0.0f32, |a, v| a.max(v.abs()));
    for (engine, candle) in ours.iter().zip(logits) {
        let bound = twin.tolerance().values as f32 * scale;
        assert!((engine - candle).abs() <= bound, "{}: {engine} and {candle}", twin.name);
    }
}
