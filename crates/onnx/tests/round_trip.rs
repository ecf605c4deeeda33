//! A written network is read back as the same network.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{SAMPLES, inputs, off, outputs, weights};
use taxel_onnx::{Export, from_bytes, to_bytes};
use taxel_zoo::{Registry, Settings};

/// Networks with an operation that ONNX says in many nodes which are not read as one.
const ONE_WAY: [&str; 1] = ["mobilenet-v2-split"];
/// Larger ones take the memory of a test several times over.
const MOST_PARAMETERS: usize = 30_000_000;

#[test]
fn every_network_of_the_zoo_comes_back() {
    let (mut equal, mut other, mut wrong) = (0, vec![], vec![]);
    for entry in Registry::built_in().entries() {
        let graph = entry.graph(&Settings::new()).unwrap();
        let name = entry.name.as_str();
        if graph.parameter_count() > MOST_PARAMETERS {
            continue;
        }
        let weights = weights(&graph);
        let bytes = to_bytes(&Export::new(&graph, &weights)).unwrap();
        let read = match from_bytes(bytes, name, None) {
            Ok(read) => read,
            Err(error) => {
                let text = error.to_string();
                assert!(ONE_WAY.contains(&name), "{name}: {text}");
                assert!(text.contains("ReduceMax") || text.contains("(Equal)"), "{name}: {text}");
                continue;
            }
        };
        if (&read.graph, &read.weights) == (&graph, &weights) {
            equal += 1;
            continue;
        }
        let x = inputs(&graph);
        let (before, after) =
            (outputs(&graph, &weights, &x, SAMPLES), outputs(&read.graph, &read.weights, &x, SAMPLES));
        let off = before.iter().zip(&after).map(|((_, a), (_, b))| off(a, b)).fold(0.0, f32::max);
        other.push(format!("{name} {off:e}"));
        if off > 1e-5 || before.len() != after.len() {
            wrong.push(format!("{name}: {off:e}"));
        }
    }
    println!("{equal} networks are equal, the others' outputs differ by {other:?}");
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(equal + other.len() >= 25, "{equal} and {}", other.len());
}
