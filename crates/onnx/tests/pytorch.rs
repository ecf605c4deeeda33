//! Networks that PyTorch exported predict as they did in PyTorch; `scripts/fixtures/onnx_networks.py` writes them.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::{Path, PathBuf};

use common::{SAMPLES, inputs, outputs};
use serde_json::Value;
use taxel_graph::Op;
use taxel_onnx::{Imported, read};

const NETWORKS: [&str; 10] = [
    "cnn1d",
    "resnet8",
    "mobilenet-v2",
    "lstm",
    "lstm-state",
    "gru",
    "frames-gru",
    "cnn3d",
    "mlp",
    "shuffle",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

fn imported(file: &str) -> Imported {
    read(&folder().join(format!("{file}.onnx"))).unwrap_or_else(|error| panic!("{error}"))
}

fn fixture() -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join("answers.json")).unwrap()).unwrap()
}

/// The largest difference from PyTorch's logits in float64.
fn off(file: &str) -> f64 {
    let read = imported(file);
    let fixture = &fixture()[file.split_once('.').unwrap().0];
    let want: Vec<f64> = fixture["logits"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let got = outputs(&read.graph, &read.weights, &inputs(&read.graph), SAMPLES);
    assert_eq!(got.len(), 1, "{file}");
    let (name, got) = &got[0];
    assert_eq!((name.as_str(), got.len()), ("logits", want.len()), "{file}");
    got.iter().zip(&want).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
}

#[test]
fn pytorchs_networks_answer_as_in_pytorch() {
    for name in NETWORKS {
        for exporter in ["script", "dynamo"] {
            let off = off(&format!("{name}.{exporter}"));
            println!("{name} {exporter}: {off:.1e}");
            assert!(off <= 1e-5, "{name} by {exporter}: {off:e}");
        }
    }
}

#[test]
fn other_precisions_are_widened_or_narrowed() {
    assert!(off("cnn1d.double") <= 1e-5);
    let half = off("cnn1d.half");
    assert!((1e-6..=5e-3).contains(&half), "halves are rounded, and no more: {half:e}");
}

#[test]
fn names_are_those_of_modules() {
    let names = |file: &str| {
        let graph = imported(file).graph;
        graph.params().map(|param| param.name.clone()).collect::<Vec<_>>()
    };
    // The newer exporter folds norms into nothing where a bias or an activation stands between.
    assert_eq!(names("mlp.dynamo"), ["first.weight", "first.bias", "last.weight", "last.bias"]);
    assert_eq!(names("mlp.script"), names("mlp.dynamo"));
    let script = names("cnn1d.script");
    assert_eq!(script[..4], ["features.0.weight", "features.0.bias", "features.4.weight", "features.4.bias"]);
    let lstm = names("lstm.script");
    assert_eq!(lstm[..2], ["lstm.weight_ih_l0", "lstm.weight_hh_l0"]);
    let gru = names("gru.script");
    assert_eq!(gru[..2], ["gru.weight_ih_l0", "gru.weight_hh_l0"]);
}

#[test]
fn nodes_that_are_one_operation_become_one() {
    let has = |file: &str, kind: &str| imported(file).graph.nodes().iter().any(|node| node.op.kind() == kind);
    for exporter in ["script", "dynamo"] {
        for kind in ["channel_shuffle", "global_standard_deviation", "hard_swish", "slice"] {
            assert!(has(&format!("shuffle.{exporter}"), kind), "{exporter}: {kind}");
        }
    }
    let read = imported("mobilenet-v2.script");
    assert!(read.notes.iter().any(|note| note.contains("softmax")), "{:?}", read.notes);
    assert!(read.graph.inputs().all(|node| node.name == "image" && node.op == Op::Input));
}
