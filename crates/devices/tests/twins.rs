//! Every network against its PyTorch twin on candle, and against the engine.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../../tests/support/twin.rs"]
mod twin;

use taxel_devices::{Device, Model};
use taxel_engine::{Engine, Mode, Options};
use taxel_graph::Graph;
use twin::Twin;

#[test]
fn networks_logits_loss_and_every_gradient() {
    for twin in Twin::all() {
        compare(&twin, &taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap());
    }
}

#[test]
fn operations_on_awkward_shapes() {
    for (twin, graph) in Twin::operations() {
        compare(&twin, &graph);
    }
}

fn compare(twin: &Twin, graph: &Graph) {
    let model = Model::new(graph, &twin.weights(), &Device::Cpu).unwrap();
    let inputs = twin.inputs(graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let outputs = model.forward(&xs, twin.batch, false).unwrap();
    assert_eq!(outputs[0].0, "logits");
    twin.assert_values("eval_logits", &outputs[0].1, 1e-5);
    let (loss, gradients) = model.loss_and_gradients(&xs, &twin.labels()).unwrap();
    twin.assert_loss(loss, 1e-5);
    assert_eq!(gradients.len(), twin.count("gradients"), "{}", twin.name);
    twin.assert_digests("gradients", |name| gradients.get(name).map(|t| t.data.clone()), 1e-4);
    let weights = model.weights().unwrap();
    twin.assert_digests("running", |name| weights.get(name).map(|t| t.data.clone()), 1e-5);

    let mut engine = Engine::new(graph, &twin.weights(), Options { batch: twin.batch, threads: 1 }).unwrap();
    let logits = engine.forward(&xs, twin.batch, Mode::Eval).unwrap();
    let scale = logits.iter().fold(0.0f32, |a, v| a.max(v.abs()));
    for (engine, candle) in logits.iter().zip(&outputs[0].1) {
        assert!((engine - candle).abs() <= 1e-5 * scale, "{}: {engine} and {candle}", twin.name);
    }
}
