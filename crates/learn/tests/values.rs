//! Baselines that learned values answer from their files as in their folds.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use allocation_counter::measure;
use ndarray::Axis;
use support::{bits, presses, record, run_at};
use taxel_baselines::Method;
use taxel_data::{Dataset, Quantity, Targets, Values};
use taxel_learn::{Candidate, CrossValidation, Encoding, Model, Protocol, fit};

/// Presses with the height of each channel's last reading.
fn measured() -> Dataset {
    let mut dataset = presses(30, 12);
    let last = dataset.x.index_axis(Axis(2), 11);
    let heights: Vec<f32> = last.iter().copied().collect();
    let names = ["height", "offset"].map(|name| Quantity { name: name.into(), unit: Some("N".into()) });
    dataset.targets = Targets::Values(Values::new(names.to_vec(), heights));
    dataset
}

#[test]
fn values_come_from_the_file_as_in_the_fold_and_allocate_nothing() {
    let dataset = measured();
    let mut validation = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).seed(5);
    validation.candidates = Method::of_values().map(Candidate::baseline).to_vec();
    let dir = tempfile::tempdir().unwrap();
    let folder = run_at(validation, &dir.path().join("run")).unwrap();
    for key in folder.keys().unwrap() {
        let (record, model) = (record(&folder, &key), Model::open(&folder.model_path(&key)).unwrap());
        let test = dataset.x.select(Axis(0), &record.index);
        assert_eq!(bits(&model.predict(&test).unwrap().outputs), bits(record.outcome.outputs()), "{key}");
        let predictor = model.predictor(8, 1).unwrap();
        let mut workspace = predictor.workspace().unwrap();
        let reading: Vec<f32> = test.index_axis(Axis(0), 0).iter().copied().collect();
        let one = predictor.predict_one(&mut workspace, &reading).unwrap().to_vec();
        assert_eq!(bits(&one), bits(&record.outcome.outputs()[..2]), "{key}");
        let allocated = measure(|| {
            predictor.predict_one(&mut workspace, &reading).unwrap();
        });
        assert_eq!(allocated.count_total, 0, "{key}");
    }
}

#[test]
fn a_method_of_the_other_targets_says_so() {
    let (values, classes) = (measured(), presses(30, 12));
    for method in Method::all().into_iter().chain(Method::of_values()) {
        let candidate = Candidate::baseline(method);
        for (dataset, learns, reason) in [
            (&values, method.learns_values(), "learns classes, and the targets are values"),
            (&classes, method.learns_classes(), "learns values, and the targets are classes"),
        ] {
            match fit(&candidate, dataset, &Encoding::default()) {
                Ok(_) => assert!(learns, "{method:?}"),
                Err(error) => assert!(!learns && error.to_string().contains(reason), "{method:?}: {error}"),
            }
        }
    }
}
