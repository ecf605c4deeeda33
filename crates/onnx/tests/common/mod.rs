//! Answers of a network, for comparisons.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../../../tests/support/twin.rs"]
mod twin;

use taxel_engine::{EngineOptions, Evaluator};
use taxel_graph::{Graph, Init, Node, Scheme, Tensor, TensorKind, Weights};

/// Fresh weights with statistics and constants that are not those of a fresh network.
pub fn weights(graph: &Graph) -> Weights {
    let mut weights = Weights::init(graph, Scheme::Pytorch, 1, "onnx");
    for param in graph.params() {
        let statistic = param.kind == TensorKind::Buffer;
        if !statistic && !matches!(param.init, Init::Constant(_)) {
            continue;
        }
        let value = |i: usize| {
            let wave = ((i * 37 + param.name.len()) % 19) as f32 / 19.0;
            if statistic && param.name.ends_with("mean") { 0.2 * (wave - 0.5) } else { 0.75 + 0.5 * wave }
        };
        let data = (0..param.len()).map(value).collect();
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

/// Three samples of every input, from the formula of the fixtures.
pub fn inputs(graph: &Graph) -> Vec<Vec<f32>> {
    let values = |(i, node): (usize, &Node)| {
        let values = twin::hashed(SAMPLES * node.shape.iter().product::<usize>(), 500 + i as u64);
        values.into_iter().map(|v| v as f32).collect()
    };
    graph.inputs().enumerate().map(values).collect()
}

/// Samples of [`inputs`].
pub const SAMPLES: usize = 3;

/// Every output for `n` samples.
pub fn outputs(graph: &Graph, weights: &Weights, inputs: &[Vec<f32>], n: usize) -> Vec<(String, Vec<f32>)> {
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let evaluator =
        Evaluator::new(graph, weights, EngineOptions { batch: n, ..EngineOptions::default() }).unwrap();
    let mut memory = evaluator.workspace();
    evaluator.predict(&mut memory, &inputs, n).unwrap();
    memory.outputs().map(|(name, values)| (name.to_string(), values.to_vec())).collect()
}

/// The largest difference as a share of the largest value; infinite where lengths differ or a value is NaN.
pub fn off(expected: &[f32], got: &[f32]) -> f32 {
    let largest = expected.iter().fold(1e-3f32, |most, v| most.max(v.abs()));
    let differences = expected.iter().zip(got).map(|(a, b)| (a - b).abs() / largest);
    let most = differences.map(|d| if d.is_nan() { f32::INFINITY } else { d }).fold(0.0, f32::max);
    if expected.len() == got.len() { most } else { f32::INFINITY }
}
