//! Models in bf16: made, saved, opened, predicting. What needs the processor's products is ignored where `scripts/check` finds
//! none.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use ndarray::Axis;
use serde_json::json;
use support::{bits, imprints, network, presses, recipe};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_learn::{Candidate, CrossValidation, Encoding, Model, Precision, fit};

/// Trains a network on the first `train` of the samples.
fn trained(name: &str, samples: &Dataset, encoding: &Encoding, epochs: usize) -> Model {
    let mut validation = CrossValidation::new(samples).encoding(encoding.clone());
    let candidate = network(name, json!({}), recipe(json!({ "epochs": epochs })), validation.encoder());
    fit(&candidate, samples, encoding).unwrap()
}

fn images(count: usize) -> (Dataset, Encoding) {
    let encoding = json!({ "image": { "kind": "raw", "resize": [12, 12] } });
    (imprints(count, 14), serde_json::from_value(encoding).unwrap())
}

#[test]
fn a_model_in_bf16_is_half_of_the_file_and_says_so() {
    let (images, encoding) = images(30);
    let floats = trained("vgg6-lite-2d", &images, &encoding, 1);
    let half = floats.halved().unwrap();
    let dir = tempfile::tempdir().unwrap();
    let [large, small] = ["floats", "half"].map(|name| dir.path().join(name).with_extension("safetensors"));
    floats.save(&large).unwrap();
    half.save(&small).unwrap();
    let opened = Model::open(&small).unwrap();
    assert!(opened.card() == half.card(), "it comes back as itself");
    assert!(half.weights().iter().all(|(name, tensor)| opened.weights().get(name) == Some(tensor)));
    let rounded = |name: &str| floats.weights().get(name) != half.weights().get(name);
    assert!(
        rounded("conv1.weight")
            || half.weights().iter().any(|(name, _)| name.ends_with(".weight") && rounded(name))
    );
    assert!(!half.weights().iter().any(|(name, _)| name.ends_with(".bias") && rounded(name)));
    let [large, small] = [&large, &small].map(|path| std::fs::metadata(path).unwrap().len());
    assert!(small < large * 6 / 10, "{small} and {large} bytes");
    assert_eq!(opened.card().precision, Precision::Bf16);
    assert!(opened.card().to_string().contains("in bits      16 per weight and factor (bf16)"));
    assert!(serde_json::to_string(opened.card()).unwrap().contains(r#""precision":"bf16""#));
    assert!(!serde_json::to_string(floats.card()).unwrap().contains(r#""precision":"bf16""#));
}

#[test]
fn what_has_no_bf16_is_refused() {
    let (images, encoding) = images(30);
    let floats = trained("vgg6-lite-2d", &images, &encoding, 1);
    let says = |model: &Model, text: &str| {
        let error = model.halved().unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    let half = floats.halved().unwrap();
    says(&half, "is in bf16 already");
    says(&floats.quantized(&images.x, "some").unwrap(), "is in eight bits");
    let nearest = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    says(
        &fit(&nearest, &presses(15, 12), &Encoding::default()).unwrap(),
        "only networks have weights in bf16",
    );
    let error = half.quantized(&images.x, "some").unwrap_err().to_string();
    assert!(error.contains("is in bf16; quantize the model in floats"), "{error}");
}

#[test]
#[ignore = "needs avx512_bf16"]
fn predictions_have_the_same_bits_on_any_number_of_threads_needs_bf16() {
    let (images, encoding) = images(40);
    let presses = presses(40, 24);
    for (name, dataset, encoding) in
        [("vgg6-lite-2d", &images, &encoding), ("lstm", &presses, &Encoding::default())]
    {
        let floats = trained(name, dataset, encoding, 2);
        let half = floats.halved().unwrap();
        let (before, after) = (floats.predict(&dataset.x).unwrap(), half.predict(&dataset.x).unwrap());
        assert_ne!(bits(&before.outputs), bits(&after.outputs), "{name} does predict in bf16");
        for (batch, threads) in [(1, 1), (40, 1), (7, 2), (16, 3)] {
            let predictor = half.predictor(batch, threads).unwrap();
            let again = predictor.predict(&dataset.x).unwrap();
            assert_eq!(
                bits(&again.outputs),
                bits(&after.outputs),
                "{name}, {batch} at a time on {threads} threads"
            );
            let mut workspace = predictor.workspace().unwrap();
            for (i, want) in after.outputs.chunks(after.width()).enumerate() {
                let sample: Vec<f32> = dataset.x.index_axis(Axis(0), i).iter().copied().collect();
                let one = predictor.predict_one(&mut workspace, &sample).unwrap();
                assert_eq!(bits(one), bits(want), "{name}, sample {i}");
            }
        }
    }
}

/// Share of the samples from number `first` on whose class is predicted.
fn accuracy(model: &Model, samples: &Dataset, first: usize) -> f64 {
    let (predicted, labels) =
        (model.predict(&samples.x).unwrap().labels, model.card().labels_of(samples).unwrap());
    let right = predicted.iter().zip(&labels).skip(first).filter(|(a, b)| a == b).count();
    right as f64 / (labels.len() - first) as f64
}

/// Trained on the first simulated samples, tested on as many others as tell differences of a tenth of a point.
#[test]
#[ignore = "needs avx512_bf16"]
fn accuracy_is_that_of_floats_within_three_tenths_of_a_point_needs_bf16() {
    const TRAIN: usize = 150;
    for (name, epochs) in [("resnet8-lite-1d", 8), ("mlp", 8)] {
        let floats = trained(name, &presses(TRAIN, 24), &Encoding::default(), epochs);
        let samples = presses(TRAIN + 3000, 24);
        let [before, after] =
            [&floats, &floats.halved().unwrap()].map(|model| accuracy(model, &samples, TRAIN));
        println!("{name}: {before} in floats, {after} in bf16");
        assert!(before > 0.7 && before < 1.0, "{name} learns, and has what to lose: {before}");
        assert!((before - after).abs() <= 0.003, "{name}: {before} and {after}");
    }
}
