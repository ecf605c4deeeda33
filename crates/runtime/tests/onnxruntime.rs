//! A small network in eight bits against onnxruntime's, with the ranges that onnxruntime has found
//! (`scripts/fixtures/eight_bits.py`).
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use taxel_graph::{Activation, Conv, Graph, Network, Pool, Tensor, Weights};
use taxel_runtime::{Frozen, Ranges};

/// A step of onnxruntime's logits.
const STEP: f32 = 0.024_503_41;

fn values(count: usize, salt: usize) -> Vec<f32> {
    (0..count).map(|i| ((i * 7919 + salt * 104_729) % 2003) as f32 / 1000.0 - 1.001).collect()
}

fn network() -> Graph {
    let net = Network::new("small");
    let x = net.input("x", &[3, 12, 14]);
    let stem = x.conv("stem", Conv::new(20, 3).pad(1)).relu().max_pool(Pool::new(2));
    let depthwise = stem.conv("depthwise", Conv::new(20, 3).pad(1).groups(20)).activation(Activation::Relu6);
    let grouped = depthwise.conv("grouped", Conv::new(36, 3).stride(2).pad(1).groups(2)).relu();
    let sum = grouped.conv("one", Conv::new(36, 1)).relu().add(&grouped);
    net.finish(&[("logits", sum.flatten().linear("fc", 5))]).unwrap()
}

fn weights(graph: &Graph) -> Weights {
    let mut weights = Weights::new();
    for (salt, param) in graph.params().enumerate() {
        let fan_in: usize = param.shape[1..].iter().product();
        let scale = if param.shape.len() > 1 { (6.0 / fan_in as f32).sqrt() } else { 0.2 };
        let data = values(param.len(), salt).iter().map(|v| v * scale).collect();
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

fn rows(fixture: &Value, key: &str) -> Vec<Vec<f32>> {
    let row = |row: &Value| row.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect();
    fixture[key].as_array().unwrap().iter().map(row).collect()
}

#[test]
fn answers_are_those_of_onnxruntime_to_half_a_step_of_its_logits() {
    let fixture: Value = serde_json::from_str(include_str!("data/eight-bits.json")).unwrap();
    let graph = network();
    let weights = weights(&graph);
    // Onnxruntime names values as PyTorch's export does; here they go by the order of the nodes.
    let at = [
        (0, "x"),
        (2, "stem/relu"),
        (3, "pool"),
        (5, "depthwise/relu6"),
        (7, "grouped/relu"),
        (9, "one/relu"),
        (10, "sum"),
    ];
    let mut ranges = Ranges::new();
    for (node, name) in at {
        let ends = fixture["ranges"][name].as_array().unwrap();
        let [low, high] = [0, 1].map(|end| ends[end].as_f64().unwrap() as f32);
        ranges.insert(graph.nodes()[node].name.clone(), [low, high]);
    }
    let (floats, bytes) =
        (Frozen::new(&graph, &weights).unwrap(), Frozen::quantized(&graph, &weights, &ranges).unwrap());
    let len = 3 * 12 * 14;
    let inputs = values(8 * len, 50);
    let mut others = 0f32;
    for (i, (plain, quantized)) in
        rows(&fixture, "floats").iter().zip(rows(&fixture, "eight_bits")).enumerate()
    {
        let x = &inputs[i * len..(i + 1) * len];
        let (mut of_floats, mut of_bytes) = (floats.workspace(), bytes.workspace());
        let a = floats.predict(&mut of_floats, &[x]).unwrap();
        assert!(a.iter().zip(plain).all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} and {plain:?}");
        let b = bytes.predict(&mut of_bytes, &[x]).unwrap();
        for ((b, other), float) in b.iter().zip(&quantized).zip(plain) {
            // Its logits are bytes of a range of their own, too.
            let b = b.clamp(-159.0 * STEP, 96.0 * STEP);
            assert!((b - other).abs() <= 0.5001 * STEP, "sample {i}: {b} and {other}");
            others = others.max((float - other).abs());
        }
    }
    assert!(others > 2.0 * STEP, "floats would do as well: {others}");
}
