//! A network frozen against the engine's prediction.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use taxel_engine::{EngineOptions, Evaluator};
use taxel_graph::{Graph, Init, Scheme, Tensor, TensorKind, Weights};
use taxel_runtime::Frozen;

/// Fresh weights with running statistics that are not those of a fresh network.
pub fn weights(graph: &Graph) -> Weights {
    let mut weights = Weights::init(graph, Scheme::Pytorch, 1, "agrees");
    for param in graph.params() {
        let is_statistic = param.kind == TensorKind::Buffer;
        if !is_statistic && !matches!(param.init, Init::Constant(_)) {
            continue;
        }
        let value = |i: usize| {
            let wave = ((i * 37 + param.name.len()) % 19) as f32 / 19.0;
            if is_statistic && !param.name.ends_with("mean") {
                0.5 + wave
            } else if matches!(param.init, Init::Constant(one) if one == 1.0) {
                0.75 + 0.5 * wave
            } else {
                0.2 * (wave - 0.5)
            }
        };
        let data = (0..param.len()).map(value).collect();
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

/// How far each output is off, as a share of its largest value; infinite where its length is another.
pub fn off(graph: &Graph) -> Vec<(String, f32)> {
    let weights = weights(graph);
    let value = |i: usize| ((i * 37 % 101) as f32 - 50.0) / 50.0;
    let inputs: Vec<Vec<f32>> =
        graph.inputs().map(|node| (0..node.shape.iter().product()).map(value).collect()).collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let evaluator =
        Evaluator::new(graph, &weights, EngineOptions { batch: 1, ..EngineOptions::default() }).unwrap();
    let mut memory = evaluator.workspace();
    evaluator.predict(&mut memory, &inputs, 1).unwrap();
    let frozen = Frozen::new(graph, &weights).unwrap();
    let mut workspace = frozen.workspace();
    // Twice: nothing of a prediction may be left for the next.
    for _ in 0..2 {
        frozen.predict(&mut workspace, &inputs).unwrap();
    }
    let mut offs = vec![];
    for ((name, expected), (_, got)) in memory.outputs().zip(workspace.outputs()) {
        let largest = expected.iter().fold(1e-3f32, |most, v| most.max(v.abs()));
        let differences = expected.iter().zip(got).map(|(a, b)| (a - b).abs() / largest);
        // NaN counts as far off.
        let most = differences.map(|d| if d.is_nan() { f32::INFINITY } else { d }).fold(0.0, f32::max);
        let off = if expected.len() == got.len() { most } else { f32::INFINITY };
        offs.push((name.to_string(), off));
    }
    offs
}
