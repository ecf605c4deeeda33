//! Models in eight bits: made, saved, opened, predicting; and the rows of a run.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use ndarray::Axis;
use serde_json::json;
use support::{bits, imprints, key, mlp, network, presses, recipe, run, three_folds};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_learn::{
    Candidate, CrossValidation, Encoding, Model, RunFolder, RunOptions, Silent, fit, quantize_run,
};

fn images() -> (Dataset, Model) {
    let images = imprints(30, 14);
    let encoding: Encoding =
        serde_json::from_value(json!({ "image": { "kind": "raw", "resize": [12, 12] } })).unwrap();
    let mut validation = CrossValidation::new(&images).encoding(encoding.clone());
    let candidate = network("vgg6-lite-2d", json!({}), recipe(json!({ "epochs": 6 })), validation.encoder());
    let model = fit(&candidate, &images, &encoding).unwrap();
    (images, model)
}

#[test]
fn a_model_in_eight_bits_is_a_quarter_of_the_file_and_predictions_alike() {
    let (images, floats) = images();
    let bytes = floats.quantized(&images.x, &images.digest).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let [large, small] = ["floats", "bits"].map(|name| dir.path().join(name).with_extension("safetensors"));
    floats.save(&large).unwrap();
    bytes.save(&small).unwrap();
    let opened = Model::open(&small).unwrap();
    assert!(opened.card() == bytes.card(), "it comes back as itself");
    assert!(bytes.weights().iter().all(|(name, tensor)| opened.weights().get(name) == Some(tensor)));
    let len = |path| std::fs::metadata(path).unwrap().len();
    assert!(3 * len(&small) < len(&large), "{} and {} bytes", len(&small), len(&large));
    let quantized = opened.card().quantized.as_ref().unwrap();
    assert_eq!((quantized.bits, quantized.samples, &quantized.digest), (8, 30, &images.digest));
    assert_eq!(opened.card().format, 4);
    assert!(opened.card().to_string().contains("8 per weight and value, ranges seen on 30 samples"));
    let (before, after) = (floats.predict(&images.x).unwrap(), opened.predict(&images.x).unwrap());
    let differ = before.labels.iter().zip(&after.labels).filter(|(a, b)| a != b).count();
    assert!(differ <= 1, "{differ} of 30 predictions differ");
    assert_ne!(bits(&before.outputs), bits(&after.outputs), "it does predict in eight bits");
    let most = before.outputs.iter().zip(&after.outputs).map(|(a, b)| (a - b).abs());
    assert!(most.fold(0.0, f32::max) < 0.1);
    // One by one, and in batches of any size on any threads.
    for (batch, threads) in [(1, 1), (7, 2)] {
        let predictor = opened.predictor(batch, threads).unwrap();
        assert_eq!(bits(&predictor.predict(&images.x).unwrap().outputs), bits(&after.outputs));
        let mut workspace = predictor.workspace().unwrap();
        let each = after.width();
        for (i, want) in after.outputs.chunks(each).enumerate() {
            let reading: Vec<f32> = images.x.index_axis(Axis(0), i).iter().copied().collect();
            assert_eq!(
                bits(predictor.predict_one(&mut workspace, &reading).unwrap()),
                bits(want),
                "sample {i}"
            );
        }
    }
}

#[test]
fn what_has_no_eight_bits_is_refused() {
    let (images, floats) = images();
    let bytes = floats.quantized(&images.x, "some").unwrap();
    let error = bytes.quantized(&images.x, "some").unwrap_err().to_string();
    assert!(error.contains(": is in eight bits already"), "{error}");
    let presses = presses(15, 12);
    let nearest = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    let baseline = fit(&nearest, &presses, &Encoding::default()).unwrap();
    let error = baseline.quantized(&presses.x, "some").unwrap_err().to_string();
    assert!(error.contains("only networks have eight bits"), "{error}");
    let error = floats.quantized(&presses.x, "some").unwrap_err().to_string();
    assert!(error.contains("samples of shape"), "{error}");
    // A card whose ranges are none.
    let path = tempfile::tempdir().unwrap().keep().join("model.safetensors");
    bytes.save(&path).unwrap();
    let (weights, text) = taxel_checkpoint::read(&path).unwrap();
    let card: serde_json::Value = serde_json::from_str(&text.unwrap()).unwrap();
    let mut card = card.as_object().unwrap().clone();
    card.remove("digest").unwrap();
    let range = card["quantized"]["ranges"].as_object_mut().unwrap().values_mut().next().unwrap();
    *range = json!([2.0, 1.0]);
    let card = serde_json::to_string(&card).unwrap();
    let digest = blake3::hash(card.as_bytes()).to_hex();
    let text = format!("{},\"digest\":\"{digest}\"}}", card.strip_suffix('}').unwrap());
    taxel_checkpoint::write(&path, &weights, &text).unwrap();
    let error = Model::open(&path).unwrap_err().to_string();
    assert!(error.contains("reach over [2.0, 1.0]"), "{error}");
    std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
}

#[test]
fn a_run_shows_its_networks_in_eight_bits_beside_those_in_floats() {
    let dataset = presses(45, 24);
    let mut validation = CrossValidation::new(&dataset);
    let candidate = network("resnet8-lite-1d", json!({}), recipe(json!({})), validation.encoder());
    let candidates = vec![mlp(&dataset, recipe(json!({}))), candidate, Candidate::baseline(Method::Majority)];
    let (_dir, folder) = run(three_folds(&dataset, candidates));
    let before = folder.results().unwrap();
    let made = quantize_run(&folder, &dataset, &|_| {}).unwrap();
    assert_eq!(made, ["mlp.int8", "resnet8-lite-1d.int8"]);
    let (results, records) = folder.finished(&dataset).unwrap();
    let names: Vec<&str> = results.networks.iter().map(|row| row.network.as_str()).collect();
    assert_eq!(names, ["mlp", "mlp.int8", "resnet8-lite-1d", "resnet8-lite-1d.int8", "majority"]);
    assert!(results.complete && records.len() == 15);
    for before in &before.networks {
        assert_eq!(results.networks.iter().find(|row| row.network == before.network), Some(before));
    }
    let row = &results.networks[3];
    assert_eq!(row.quantized.as_deref(), Some("resnet8-lite-1d"));
    let floats = ["resnet8-lite-1d.int8", "resnet8-lite-1d", "unknown"].map(|name| results.in_floats(name));
    assert_eq!(floats, ["resnet8-lite-1d", "resnet8-lite-1d", "unknown"]);
    assert!(3 * row.costs.bytes < 2 * results.networks[2].costs.bytes && row.mean.is_some());
    // What a fold says is what its model says, and it saw nothing but the fold's training samples.
    let key = key("resnet8-lite-1d.int8", 0, 1);
    let record = folder.record(&key).unwrap().unwrap();
    let model = folder.model(&record).unwrap();
    let quantized = model.card().quantized.as_ref().unwrap();
    assert_eq!((quantized.samples, record.train_samples), (30, 30));
    let predictions = model.predict(&dataset.x.select(Axis(0), &record.index)).unwrap();
    assert_eq!(bits(&predictions.outputs), bits(record.outcome.outputs()));
    // Once more: the same bytes.
    let text = std::fs::read(folder.file("results.json")).unwrap();
    assert_eq!(quantize_run(&folder, &dataset, &|_| {}).unwrap(), made);
    assert_eq!(std::fs::read(folder.file("results.json")).unwrap(), text);
}

#[test]
fn resuming_keeps_the_rows_in_eight_bits_of_networks_that_are_as_they_were() {
    let dataset = presses(45, 24);
    let start = |options: RunOptions, out: &Path| {
        let mut validation = CrossValidation::new(&dataset);
        let candidate = network("resnet8-lite-1d", json!({}), recipe(json!({})), validation.encoder());
        let candidates =
            vec![mlp(&dataset, recipe(json!({}))), candidate, Candidate::baseline(Method::Majority)];
        three_folds(&dataset, candidates).run_in(out, &options, &Silent, &AtomicBool::new(false)).unwrap()
    };
    let names = |folder: &RunFolder| -> Vec<String> {
        folder.results().unwrap().networks.into_iter().map(|row| row.network).collect()
    };
    let dir = tempfile::tempdir().unwrap();
    let folder = start(RunOptions::default(), dir.path());
    quantize_run(&folder, &dataset, &|_| {}).unwrap();
    let files = ["results.json", "metrics.jsonl", "timings.jsonl", "predictions.npz"];
    let read = || files.map(|name| std::fs::read(folder.file(name)).unwrap());
    let before = read();
    let resume = RunOptions { resume: true, ..RunOptions::default() };
    start(resume.clone(), dir.path());
    assert!(read() == before, "nothing is trained, nothing is lost");
    // Trained again, a network may be another one.
    std::fs::remove_file(dir.path().join("folds/mlp.r0.f1.json")).unwrap();
    start(resume, dir.path());
    assert_eq!(names(&folder), ["mlp", "resnet8-lite-1d", "resnet8-lite-1d.int8", "majority"]);
    assert_eq!(folder.finished(&dataset).unwrap().1.len(), 12);
}
