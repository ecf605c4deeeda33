//! The bits of what networks of the zoo predict, for weights and samples that are made by exact arithmetic.

use std::collections::BTreeMap;

use taxel_graph::{Graph, Init, Tensor, TensorKind, Weights};
use taxel_runtime::{Frozen, Observer};

/// Digests of the outputs in floats and in eight bits, by network.
pub type Bits = BTreeMap<String, [String; 2]>;

/// Returns weights that need no function whose last bit differs between systems.
fn weights(graph: &Graph) -> Weights {
    let mut weights = Weights::default();
    for param in graph.params() {
        let fan: usize = param.shape.iter().skip(1).product();
        let bound = 1.0 / (fan.max(1) as f32).sqrt();
        let wave = |i: usize| ((i * 7919 + param.name.len()) % 2003) as f32 / 2003.0;
        let value = |i: usize| match (param.kind == TensorKind::Buffer, param.init) {
            (true, _) if param.name.ends_with("mean") => 0.2 * (wave(i) - 0.5),
            (true, _) | (_, Init::Constant(1.0)) => 0.75 + 0.5 * wave(i),
            _ => bound * (2.0 * wave(i) - 1.0),
        };
        let data = (0..param.len()).map(value).collect();
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

/// Returns a digest (FNV-1a) of the bits of all outputs.
fn digest(frozen: &Frozen, inputs: &[&[f32]]) -> Result<String, taxel_runtime::Error> {
    let mut workspace = frozen.workspace();
    frozen.predict(&mut workspace, inputs)?;
    let bits = workspace.outputs().flat_map(|(_, values)| values).map(|v| v.to_bits());
    let mix = |digest: u64, bits: u32| (digest ^ u64::from(bits)).wrapping_mul(0x0000_0100_0000_01b3);
    Ok(format!("{:016x}", bits.fold(0xcbf2_9ce4_8422_2325, mix)))
}

/// Predicts one sample with every network of the zoo of at most so many multiply–adds, in floats and in eight bits.
pub fn of_zoo(most: u64) -> Result<Bits, Box<dyn std::error::Error>> {
    let mut all = Bits::new();
    for entry in taxel_zoo::Registry::built_in().entries() {
        let graph = entry.graph(&taxel_zoo::Settings::new())?;
        if graph.cost().macs > most {
            continue;
        }
        let weights = weights(&graph);
        let value = |i: usize| ((i * 37 % 101) as f32 - 50.0) / 50.0;
        let inputs: Vec<Vec<f32>> =
            graph.inputs().map(|node| (0..node.shape.iter().product()).map(value).collect()).collect();
        let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let mut observer = Observer::new(&graph, &weights)?;
        observer.see(&inputs)?;
        let floats = digest(&Frozen::new(&graph, &weights)?, &inputs)?;
        let bytes = digest(&Frozen::quantized(&graph, &weights, &observer.ranges())?, &inputs)?;
        all.insert(entry.name.clone(), [floats, bytes]);
    }
    Ok(all)
}
