//! Losses of samples with weights, against PyTorch.

#![allow(clippy::unwrap_used)]

use serde_json::Value;
use taxel_engine::{Engine, EngineOptions, Mode};
use taxel_graph::{Graph, Loss, Network, Scheme, Targets, Tensor, Weights};

fn singles(value: &Value) -> Vec<f32> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect()
}

/// A linear layer that is the identity: the gradient of its bias is the sum of the outputs' gradients.
fn identity(outputs: usize) -> (Graph, Weights) {
    let net = Network::new("identity");
    let flow = net.input("signal", &[1, outputs]).flatten().linear("fc", outputs);
    let graph = net.finish(&[("outputs", flow)]).unwrap();
    let mut weights = Weights::init(&graph, Scheme::Pytorch, 0, "identity");
    let eye = (0..outputs * outputs).map(|i| f32::from(u8::from(i % (outputs + 1) == 0))).collect();
    weights.insert("fc.weight", Tensor { shape: vec![outputs, outputs], data: eye });
    weights.insert("fc.bias", Tensor { shape: vec![outputs], data: vec![0.0; outputs] });
    (graph, weights)
}

#[test]
fn losses_of_weighted_samples_agree_with_pytorch() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("data/weights.json")).unwrap();
    for case in cases {
        let loss: Loss = serde_json::from_value(case["loss"].clone()).unwrap();
        let (values, weights) = (singles(&case["outputs"]), singles(&case["weights"]));
        let (targets, n) = (singles(&case["targets"]), weights.len());
        let labels: Vec<u32> = targets.iter().map(|target| *target as u32).collect();
        let targets = match loss {
            Loss::SoftmaxCrossEntropy => Targets::Labels(&labels),
            _ => Targets::Values(&targets),
        };
        let (graph, identity) = identity(values.len() / n);
        let options = EngineOptions { batch: n, ..EngineOptions::default() };
        let mut engine = Engine::new(&graph, &identity, options).unwrap();
        engine.forward(&[&values], n, Mode::Train).unwrap();
        let value = engine.backward_weighted(loss, targets, &weights).unwrap();
        let want = case["value"].as_f64().unwrap();
        assert!(
            (f64::from(value) - want).abs() <= 2e-6 * want.abs().max(1.0),
            "{loss:?}: {value} and {want}"
        );
        let gradient = engine.gradients().get("fc.bias").unwrap().data.clone();
        for (got, want) in gradient.iter().zip(singles(&case["gradient"])) {
            assert!((got - want).abs() <= 2e-6, "{loss:?}: {got} and {want}");
        }

        engine.forward(&[&values], n, Mode::Train).unwrap();
        let error = engine.backward_weighted(loss, targets, &weights[1..]).unwrap_err().to_string();
        assert!(error.contains("6 weights for 7 samples"), "{error}");
        // Weights of 1 are no weights.
        let plain = engine.backward_with(loss, targets).unwrap();
        engine.forward(&[&values], n, Mode::Train).unwrap();
        let ones = engine.backward_weighted(loss, targets, &vec![1.0; n]).unwrap();
        assert!((plain - ones).abs() <= 1e-6 * plain.abs().max(1.0), "{loss:?}: {plain} and {ones}");
    }
}
