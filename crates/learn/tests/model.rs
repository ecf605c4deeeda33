//! Models predict from their files alone, bit for bit as in their folds.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::collections::BTreeSet;

use ndarray::Axis;
use serde_json::{Value, json};
use support::{bits, imprints, mlp, network, presses, recipe, record, run_at, squeezes, three_folds};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_learn::{Candidate, CrossValidation, Encoding, FoldKey, Model, Protocol, RunFolder, fit};

/// It sees through six planes, which no encoding makes, and has two outputs: `taxel stitch` makes it.
const APART: &str = "mobilenet-v2-split";

/// Their 4096 hidden units are 32 here.
const WIDE: [&str; 2] = ["alexnet", "vgg16"];

/// They take long in batches of one, and have the layers of others.
const SLOW: [&str; 3] = ["mnasnet1-0", "shufflenet-v2", "hybrid-densenet"];

/// Parameters above which a network takes too long in batches of one.
const MOST: u64 = 3_200_000;

fn encoding(value: Value) -> Encoding {
    serde_json::from_value(value).unwrap()
}

/// Samples that some networks read, and how.
fn worlds() -> Vec<(Dataset, Encoding, &'static [&'static str])> {
    let field = json!({ "image": { "kind": "gadf", "size": 24 }, "rocket": { "features": 168 } });
    let frames = json!({ "tensor": { "frames": 8 } });
    let red = json!({ "image": { "kind": "raw", "red": true } });
    vec![
        (presses(15, 32), encoding(field), &["signal", "image", "rocket"]),
        (squeezes(15, [8, 28, 28]), encoding(frames), &["tensor"]),
        (squeezes(15, [24, 14, 14]), encoding(json!({ "tensor": {} })), &["tensor"]),
        (imprints(15, 33), encoding(red.clone()), &["image"]),
        // What alexnet leaves something of.
        (imprints(15, 64), encoding(red), &["image"]),
    ]
}

/// The networks of the registry that read `inputs`, have at most so many parameters and were not seen yet, with
/// one epoch each.
fn networks(
    validation: &mut CrossValidation,
    inputs: &[&str],
    most: u64,
    seen: &mut BTreeSet<String>,
) -> Vec<Candidate> {
    let mut found = vec![];
    for entry in taxel_zoo::built_in().entries() {
        if !entry.inputs.iter().all(|input| inputs.contains(&input.name.as_str())) {
            continue;
        }
        let recipe =
            recipe(json!({ "epochs": 1, "batch_size": 4, "optimizer": { "name": "sgdm", "lr": 1e-5 } }));
        let names: Vec<&str> = entry.inputs.iter().map(|input| input.name.as_str()).collect();
        let encoder = validation.encoder();
        encoder.prepare(&names).unwrap();
        let narrow = if WIDE.contains(&entry.name.as_str()) { json!({ "hidden": 32 }) } else { json!({}) };
        let mut sized = entry.fit(3, |input| encoder.shape(input)).unwrap();
        sized.extend(narrow.as_object().unwrap().clone());
        let Ok(graph) = entry.graph(&sized) else { continue };
        if graph.cost().parameters <= most && seen.insert(entry.name.clone()) {
            found.push(network(&entry.name, narrow, recipe, encoder));
        }
    }
    found
}

/// Copies a model to a folder without anything else and opens it there.
fn opened_elsewhere(folder: &RunFolder, key: &FoldKey) -> Model {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    std::fs::copy(folder.model_path(key), &path).unwrap();
    Model::open(&path).unwrap()
}

#[test]
fn every_network_and_baseline_answers_from_its_file_as_in_its_fold() {
    let baselines = Method::all().map(Candidate::baseline);
    let mut seen = BTreeSet::new();
    for (dataset, encoding, inputs) in worlds() {
        let mut validation =
            CrossValidation::new(&dataset).encoding(encoding).protocol(Protocol::k_fold(2)).seed(5);
        let networks = networks(&mut validation, inputs, u64::MAX, &mut seen);
        validation.candidates = networks.into_iter().chain(baselines.clone()).collect();
        let dir = tempfile::tempdir().unwrap();
        let folder = run_at(validation, &dir.path().join("run")).unwrap();
        for key in folder.keys().unwrap() {
            let record = record(&folder, &key);
            let model = opened_elsewhere(&folder, &key);
            let test = dataset.x.select(Axis(0), &record.index);
            for threads in [1, 2] {
                let predictor = model.predictor(model.card().batch(), threads).unwrap();
                let predictions = predictor.predict(&test).unwrap();
                assert_eq!(bits(&predictions.outputs), bits(record.outcome.outputs()), "{key}");
                assert_eq!(predictions.labels, record.outcome.labels().1, "{key}");
            }
            let predictions = model.predict(&test).unwrap();
            assert_eq!(bits(&predictions.outputs), bits(record.outcome.outputs()), "{key}");
            for (i, &label) in record.outcome.labels().1.iter().enumerate() {
                assert_eq!(predictions.class(i), dataset.output_names()[label as usize]);
            }
        }
    }
    let left: Vec<&str> = taxel_zoo::built_in().entries().map(|entry| entry.name.as_str()).collect();
    let left: Vec<&str> = left.into_iter().filter(|name| !seen.contains(*name)).collect();
    assert_eq!(left, [APART]);
}

/// Three readings per step in time, less what the sensor says at rest.
#[test]
fn the_quantile_code_comes_back_from_the_file() {
    let dataset = presses(18, 100);
    let code = encoding(json!({ "baseline": 4, "signal": { "kind": "quantile-code" } }));
    let mut validation = CrossValidation::new(&dataset).encoding(code).protocol(Protocol::k_fold(2)).seed(5);
    let short = recipe(json!({ "epochs": 2, "optimizer": { "name": "adamw", "lr": 1e-3 } }));
    let names = ["dilated-resnet-1d", "resnet8-lite-1d", "lstm"];
    let encoder = validation.encoder();
    let candidates = names.map(|name| network(name, json!({}), short.clone(), encoder)).to_vec();
    validation.candidates = candidates;
    let dir = tempfile::tempdir().unwrap();
    let folder = run_at(validation, &dir.path().join("run")).unwrap();
    for key in folder.keys().unwrap() {
        let (record, model) = (record(&folder, &key), opened_elsewhere(&folder, &key));
        let predictions = model.predict(&dataset.x.select(Axis(0), &record.index)).unwrap();
        assert_eq!(bits(&predictions.outputs), bits(record.outcome.outputs()), "{key}");
    }
}

/// One sample at a time gives the predictions of a batch, bit for bit.
#[test]
fn an_answer_does_not_depend_on_the_company() {
    let mut seen = BTreeSet::new();
    for (dataset, encoding, inputs) in worlds() {
        let mut validation =
            CrossValidation::new(&dataset).encoding(encoding).protocol(Protocol::k_fold(2)).seed(5);
        let networks = networks(&mut validation, inputs, MOST, &mut seen);
        let networks = networks.into_iter().filter(|network| !SLOW.contains(&network.name.as_str()));
        let baselines = Method::all().map(Candidate::baseline);
        validation.candidates = networks.chain(baselines).collect();
        let dir = tempfile::tempdir().unwrap();
        let folder = run_at(validation, &dir.path().join("run")).unwrap();
        for key in folder.keys().unwrap().into_iter().filter(|key| key.fold == 0) {
            let model = opened_elsewhere(&folder, &key);
            let all = model.predict(&dataset.x).unwrap();
            for batch in [1, 2, 15, 64] {
                let predictions = model.predictor(batch, 1).unwrap().predict(&dataset.x).unwrap();
                assert_eq!(bits(&predictions.outputs), bits(&all.outputs), "{key}, {batch}");
                assert_eq!(predictions.labels, all.labels, "{key} in batches of {batch}");
            }
            for row in [0, 7, 14] {
                let one = model.predict(&dataset.x.select(Axis(0), &[row])).unwrap();
                let outputs = one.width();
                let same = &all.outputs[row * outputs..(row + 1) * outputs];
                assert_eq!(bits(&one.outputs), bits(same), "{key}, sample {row}");
            }
        }
    }
}

/// A model predicts in batches of the fold's size, whatever comes at once.
#[test]
fn a_model_remembers_how_many_samples_its_fold_answered_at_a_time() {
    let dataset = presses(60, 32);
    let mut validation = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2));
    for (name, batch_size) in [("four", 4), ("many", 64)] {
        let changed = recipe(json!({ "epochs": 1, "batch_size": batch_size }));
        let wide = network("mlp", json!({ "hidden": 200 }), changed, validation.encoder());
        validation.candidates.push(Candidate { name: name.into(), ..wide });
    }
    let dir = tempfile::tempdir().unwrap();
    let folder = run_at(validation, &dir.path().join("run")).unwrap();
    for key in folder.keys().unwrap() {
        let record = record(&folder, &key);
        let model = opened_elsewhere(&folder, &key);
        assert_eq!(model.card().batch(), if key.network == "four" { 4 } else { 30 });
        let predictions = model.predict(&dataset.x.select(Axis(0), &record.index)).unwrap();
        assert_eq!(bits(&predictions.outputs), bits(record.outcome.outputs()), "{key}");
    }
}

/// The score of a run goes into the card of the model that is shipped.
#[test]
fn a_model_carries_the_score_of_its_run() {
    let dataset = presses(45, 20);
    let candidate = mlp(&dataset, recipe(json!({})));
    let results = three_folds(&dataset, vec![candidate.clone()]).run().unwrap();
    let score = results.score("mlp").unwrap();
    assert_eq!((score.folds, Some(&score.mean)), (3, results.networks[0].mean.as_ref()));
    assert!(results.score("none").is_none());
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    fit(&candidate, &dataset, &Encoding::default())
        .unwrap()
        .with_score(Some(score.clone()))
        .save(&path)
        .unwrap();
    let model = Model::open(&path).unwrap();
    assert_eq!(model.card().score, Some(score.clone()));
    assert!(model.card().to_string().contains(&score.words(&model.card().task)), "{}", model.card());
}
