//! Baselines that learned values answer from their files as in their folds.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use allocation_counter::measure;
use ndarray::Axis;
use support::{bits, presses, record, run_at};
use taxel_baselines::Method;
use taxel_data::{Dataset, Quantity, Targets, Values};
use taxel_graph::Loss;
use taxel_learn::metrics::Outcome;
use taxel_learn::{Candidate, CrossValidation, Encoding, Model, Protocol, Recipe, Split, fit};

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

/// Every network answers from its file in the unit of the targets, as in its fold.
#[test]
fn networks_answer_in_the_unit_of_their_targets() {
    let dataset = measured();
    let graph = |outputs: usize| {
        let net = taxel_graph::Network::new("line");
        let flow = net.input("signal", &dataset.spec.shape.clone()).flatten();
        net.finish(&[("values", flow.linear("fc1", 16).relu().linear("fc2", outputs))]).unwrap()
    };
    let recipe = |loss: Loss| Recipe {
        epochs: 40,
        batch_size: 8,
        loss: Some(loss),
        optimizer: serde_json::from_str(r#"{ "name": "adam", "lr": 0.01 }"#).unwrap(),
        ..Recipe::default()
    };
    for loss in [Loss::Huber, Loss::GaussianLikelihood, Loss::Quantiles] {
        let candidate = Candidate::network(graph(2 * loss.outputs_per_target()), recipe(loss));
        let validation = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).candidate(candidate);
        let dir = tempfile::tempdir().unwrap();
        let folder = run_at(validation, &dir.path().join("run")).unwrap();
        let chance = {
            let validation = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2));
            let mean = validation.candidate(Candidate::baseline(Method::Mean));
            let folder = run_at(mean, &dir.path().join("mean")).unwrap();
            error(&folder)
        };
        assert!(error(&folder) < 0.7 * chance, "{loss:?}: {} of {chance}", error(&folder));
        for key in folder.keys().unwrap() {
            let (record, model) = (record(&folder, &key), Model::open(&folder.model_path(&key)).unwrap());
            let said = model.predict(&dataset.x.select(Axis(0), &record.index)).unwrap();
            assert_eq!(bits(&said.outputs), bits(record.outcome.outputs()), "{loss:?} {key}");
            let Outcome::Values { spread, .. } = &record.outcome else { panic!("labels") };
            assert_eq!(bits(&said.spread), bits(spread), "{loss:?} {key}");
            assert_eq!(spread.len(), if loss == Loss::Huber { 0 } else { 4 * record.index.len() });
        }
    }
    let rectified = {
        let net = taxel_graph::Network::new("rectified");
        let flow = net.input("signal", &dataset.spec.shape.clone()).flatten();
        net.finish(&[("values", flow.linear("fc", 2).relu())]).unwrap()
    };
    let candidate = Candidate::network(rectified, recipe(Loss::Huber));
    let refused = fit(&candidate, &dataset, &Encoding::default()).unwrap_err().to_string();
    assert!(refused.contains("values need a linear layer, a convolution or a batch norm there"), "{refused}");
}

/// Mean absolute error over all folds.
fn error(folder: &taxel_learn::RunFolder) -> f64 {
    let results = folder.results().unwrap();
    results.networks[0].mean.as_ref().unwrap().get("mae").unwrap()
}

#[test]
fn rare_values_need_not_be_in_every_part() {
    let mut dataset = presses(30, 12);
    let force = Quantity { name: "force".into(), unit: Some("N".into()) };
    // Mostly at rest, as a skin is; ten parts of the range, of which the last ones hold one to three samples.
    let values = (0..30).map(|row| if row < 26 { 0.0 } else { row as f32 }).collect();
    dataset.targets = Targets::Values(Values::new(vec![force], values));
    for folds in [2, 5] {
        let folds = Protocol::k_fold(folds).folds(&dataset, 1, 0).unwrap();
        let mut tested: Vec<usize> = folds.iter().flat_map(|fold| fold.test.clone()).collect();
        tested.sort_unstable();
        assert_eq!(tested, (0..30).collect::<Vec<_>>());
    }
    let few =
        Protocol::FewSamples { split: Split::Stratified, test: 0.4, per_class: vec![9], repetitions: 1 };
    assert!(few.words(&dataset.task()).starts_with("few samples per part of the range"));
    let error = few.folds(&dataset, 1, 0).unwrap_err().to_string();
    assert!(error.starts_with("protocol.per_class = 9: a part of the range of the values has "), "{error}");
}
