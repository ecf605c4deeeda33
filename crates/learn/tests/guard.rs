//! The guard before a network: part of an experiment, of its model and of its predictions.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::sync::Arc;

use ndarray::{ArrayD, Axis};
use serde_json::json;
use support::{bits, imprints, key, mlp, model, presses, recipe, record, run, three_folds};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_learn::{Candidate, Encoding, Model, fit, fitted_guard};

fn guarded() -> Encoding {
    serde_json::from_value(json!({ "guard": true })).unwrap()
}

/// The samples with channel 0 of those in `rows` stuck.
fn stuck(dataset: &Dataset, rows: &[usize]) -> ArrayD<f32> {
    let mut x = dataset.x.clone();
    rows.iter().for_each(|&row| x.index_axis_mut(Axis(0), row).index_axis_mut(Axis(0), 0).fill(400.0));
    x
}

#[test]
fn a_model_answers_broken_samples_as_its_guard_mends_them() {
    let dataset = presses(30, 16);
    let candidate = mlp(&dataset, recipe(json!({})));
    let [plain, model] =
        [Encoding::default(), guarded()].map(|encoding| fit(&candidate, &dataset, &encoding).unwrap());
    assert_eq!(
        (plain.card().guard.as_ref(), plain.weights()),
        (None, model.weights()),
        "nothing is trained otherwise"
    );
    let guard = model.card().guard.clone().unwrap();
    assert_eq!(guard, fitted_guard(&dataset, &(0..30).collect::<Vec<_>>()).unwrap());
    let text = model.card().to_string();
    assert!(text.contains("guard        on: 2 channels; readings "), "{text}");

    let x = stuck(&dataset, &[4, 7]);
    let [with, without] = [&model, &plain].map(|model| model.predictor(8, 1).unwrap());
    let found = with.found(&x).unwrap();
    let broken: Vec<usize> = (0..30).filter(|row| !found[*row].is_empty()).collect();
    assert_eq!((broken, found[4][0].element), (vec![4, 7], 0));
    assert!(without.found(&x).unwrap().iter().all(Vec::is_empty));
    let [a, b] = [&with, &without].map(|predictor| predictor.predict(&x).unwrap().outputs);
    let differ: Vec<usize> = (0..30).filter(|row| a[row * 3..][..3] != b[row * 3..][..3]).collect();
    assert_eq!(differ, [4, 7]);
    // Switched off it is the plain model, switched on the guarded one; reading by reading the same.
    let off = model.predictor(8, 1).unwrap().guarded(None).unwrap();
    assert_eq!(bits(&off.predict(&x).unwrap().outputs), bits(&b));
    let on = plain.predictor(8, 1).unwrap().guarded(Some(Arc::new(guard.clone()))).unwrap();
    assert_eq!(bits(&on.predict(&x).unwrap().outputs), bits(&a));
    let mut workspace = with.workspace().unwrap();
    for (row, sample) in x.outer_iter().enumerate() {
        let sample: Vec<f32> = sample.iter().copied().collect();
        let prediction = bits(with.predict_one(&mut workspace, &sample).unwrap());
        assert_eq!(prediction, bits(&a[row * 3..][..3]));
        assert_eq!(workspace.found(), found[row]);
    }
    let other = fitted_guard(&imprints(9, 14), &[0, 1, 2]).unwrap();
    let error = off.guarded(Some(Arc::new(other))).err().unwrap().to_string();
    assert!(error.contains("the guard is of image samples of shape [14, 14]"), "{error}");
}

#[test]
fn a_guard_comes_back_with_its_file_and_a_damaged_one_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    let dataset = presses(30, 16);
    let nearest = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    let model = fit(&nearest, &dataset, &guarded()).unwrap();
    model.save(&path).unwrap();
    assert_eq!(Model::open(&path).unwrap(), model);
    let plain = fit(&nearest, &dataset, &Encoding::default()).unwrap();
    plain.save(&path).unwrap();
    let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
    assert!(!text.contains("guard"), "a model without one is written as before");
    assert_eq!(Model::open(&path).unwrap().card().guard, None);
    let mut card = model.card().clone();
    card.spec.shape = vec![2, 17];
    assert!(card.guard.unwrap().check(card.spec.layout, &card.spec.shape).is_err());
}

#[test]
fn a_run_fits_a_guard_to_each_training_part_and_tests_behind_it() {
    let clean = presses(45, 16);
    // Among the test samples of every fold.
    let rows = [0, 1, 2, 20, 21, 22, 40, 41, 42];
    let dataset = Dataset { x: stuck(&clean, &rows), ..clean.clone() };
    let candidates =
        || vec![mlp(&dataset, recipe(json!({}))), Candidate::baseline(Method::NearestNeighbours { k: 1 })];
    let (_dir, folder) = run(three_folds(&dataset, candidates()).encoding(guarded()));
    let (_other, plain) = run(three_folds(&dataset, candidates()));
    for name in ["mlp", "k-nn"] {
        for fold in 0..3 {
            let key = key(name, 0, fold);
            let (record, model) = (record(&folder, &key), model(&folder, &key));
            let train: Vec<usize> = (0..45).filter(|row| !record.index.contains(row)).collect();
            assert_eq!(model.card().guard, Some(fitted_guard(&dataset, &train).unwrap()));
            let tested = dataset.x.select(Axis(0), &record.index);
            assert_eq!(bits(&model.predict(&tested).unwrap().outputs), bits(record.outcome.outputs()));
            let before = self::record(&plain, &key);
            assert_eq!(before.index, record.index);
            let unguarded = self::model(&plain, &key);
            assert_eq!(unguarded.weights(), model.weights(), "training sees the samples as they are");
        }
    }
}
