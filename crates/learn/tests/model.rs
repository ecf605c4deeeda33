//! Model files: every network and baseline comes back from its file alone, and broken files are refused.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::{Path, PathBuf};

use ndarray::Axis;
use serde_json::{Value, json};
use support::{bits, imprints, key, mlp, network, presses, recipe, record, run_at, squeezes, three_folds};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_graph::{Tensor, Weights};
use taxel_learn::{
    Candidate, CrossValidation, Encoding, FoldKey, Model, Protocol, RunFolder, fit,
};

/// Parameters above which a network takes too long for a test.
const MOST: u64 = 3_200_000;

fn encoding(value: Value) -> Encoding {
    serde_json::from_value(value).unwrap()
}

/// Samples that some networks read, and how.
fn worlds() -> Vec<(Dataset, Encoding, &'static [&'static str])> {
    let field = json!({ "image": { "kind": "gadf", "size": 24 } });
    let frames = json!({ "tensor": { "frames": 8 } });
    vec![
        (presses(15, 32), encoding(field), &["signal", "image"]),
        (squeezes(15, [8, 28, 28]), encoding(frames), &["tensor"]),
        (imprints(15, 33), encoding(json!({ "image": { "kind": "raw", "red": true } })), &["image"]),
    ]
}

/// The networks of the registry that read what `world` offers and that are small, with one epoch each.
fn small_networks(validation: &mut CrossValidation, inputs: &[&str]) -> Vec<Candidate> {
    let mut found = vec![];
    for entry in taxel_zoo::built_in().entries() {
        if !entry.inputs.iter().all(|input| inputs.contains(&input.name.as_str())) {
            continue;
        }
        let own = recipe(json!({ "epochs": 1, "batch_size": 4, "optimizer": { "name": "sgdm", "lr": 1e-5 } }));
        let names: Vec<&str> = entry.inputs.iter().map(|input| input.name.as_str()).collect();
        let encoder = validation.encoder();
        encoder.prepare(&names).unwrap();
        let sized = entry.fit(3, |input| encoder.shape(input)).unwrap();
        let Ok(graph) = entry.graph(&sized) else { continue };
        if graph.cost().parameters <= MOST {
            found.push(network(&entry.name, json!({}), own, encoder));
        }
    }
    found
}

/// Copies a model to a folder without anything else and opens it there.
fn alone(folder: &RunFolder, key: &FoldKey) -> Model {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    std::fs::copy(folder.model_path(key), &path).unwrap();
    Model::open(&path).unwrap()
}

#[test]
fn every_small_network_and_baseline_answers_from_its_file_as_in_its_fold() {
    let baselines = Method::all().map(Candidate::baseline);
    let mut seen = std::collections::BTreeSet::new();
    for (dataset, encoding, inputs) in worlds() {
        let mut validation =
            CrossValidation::new(&dataset).encoding(encoding).protocol(Protocol::k_fold(2)).seed(5);
        let networks = small_networks(&mut validation, inputs);
        let fresh = networks.into_iter().filter(|own| seen.insert(own.name.clone()));
        validation.candidates = fresh.chain(baselines.clone()).collect();
        let dir = tempfile::tempdir().unwrap();
        let folder = run_at(validation, &dir.path().join("run")).unwrap();
        for key in folder.keys().unwrap() {
            let record = record(&folder, &key);
            let model = alone(&folder, &key);
            let test = dataset.x.select(Axis(0), &record.index);
            for threads in [1, 2] {
                let mut predictor = model.predictor(model.card().batch(), threads).unwrap();
                let answers = predictor.predict(&test).unwrap();
                assert_eq!(bits(&answers.probabilities), bits(&record.probabilities), "{key}");
                assert_eq!(answers.labels, record.predicted, "{key}");
            }
            let answers = model.predict(&test).unwrap();
            assert_eq!(bits(&answers.probabilities), bits(&record.probabilities), "{key}");
            for (i, &label) in record.predicted.iter().enumerate() {
                assert_eq!(answers.class(i), dataset.classes[label as usize]);
            }
        }
    }
    let names: Vec<&str> = seen.iter().map(String::as_str).collect();
    println!("{} networks: {}", names.len(), names.join(", "));
    for name in ["mlp", "lstm", "hybrid-resvgg", "tactnet3d", "multiscale-cnn", "mobilenet-v2", "shufflenet-v2"] {
        assert!(names.iter().any(|own| own.starts_with(name)), "no {name} among {names:?}");
    }
    assert!(names.len() >= 25, "{names:?}");
}

/// REPORT
#[test]
fn batches() {
    for (dataset, encoding, inputs) in worlds() {
        let mut validation =
            CrossValidation::new(&dataset).encoding(encoding).protocol(Protocol::k_fold(2)).seed(5);
        let networks = small_networks(&mut validation, inputs);
        let baselines = Method::all().map(Candidate::baseline);
        validation.candidates = networks.into_iter().chain(baselines).collect();
        let dir = tempfile::tempdir().unwrap();
        let folder = run_at(validation, &dir.path().join("run")).unwrap();
        for key in folder.keys().unwrap().into_iter().filter(|key| key.fold == 0) {
            let model = alone(&folder, &key);
            let want = model.predict(&dataset.x).unwrap();
            let classes = want.outputs();
            let differ = |batch: usize| {
                let mut predictor = model.predictor(batch, 1).unwrap();
                let got = predictor.predict(&dataset.x).unwrap();
                let rows = got.probabilities.chunks(classes).zip(want.probabilities.chunks(classes));
                let rows = rows.filter(|(a, b)| bits(a) != bits(b)).count();
                let gap = got.probabilities.iter().zip(&want.probabilities).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                format!("{batch}: {rows} rows {gap:e}")
            };
            println!("REPORT {} {key}: {}", dataset.name, [1, 2, 3, 5, 7, 15, 64].map(differ).join("; "));
        }
    }
}
