//! Training under faults: what it draws, what it is a function of, what it helps against.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::sync::atomic::AtomicBool;

use ndarray::{ArrayD, Axis};
use serde_json::json;
use support::{imprints, key, mlp, model, network, presses, recipe, record, run, squeezes, three_folds};
use taxel_baselines::Method;
use taxel_data::{Augment, Dataset};
use taxel_faults::{Fault, TrainingFaults};
use taxel_graph::Weights;
use taxel_learn::{Candidate, CrossValidation, Encoder, Encoding, Fit, Protocol, RunOptions, fit};

fn weights(dataset: &Dataset, candidate: Candidate) -> Weights {
    let name = candidate.name.clone();
    let (_keep, folder) = run(three_folds(dataset, vec![candidate]));
    model(&folder, &key(&name, 0, 0)).weights().clone()
}

#[test]
fn faults_change_a_training_and_none_leave_it_as_it_was() {
    let dataset = presses(45, 20);
    let trained = |changes| weights(&dataset, mlp(&dataset, recipe(changes)));
    let clean = trained(json!({}));
    assert_eq!(clean, trained(json!({ "faults": { "probability": 0.0, "second": 0.0 } })));
    let all = trained(json!({ "faults": {} }));
    assert_ne!(clean, all);
    for changes in [
        json!({ "faults": { "probability": 0.2 } }),
        json!({ "faults": { "second": 0.9 } }),
        json!({ "faults": { "kinds": ["noise", "dead"] } }),
        json!({ "faults": { "without": ["drift"] } }),
        json!({ "faults": { "levels": { "noise": [30.0, 40.0], "gain": [70.0, 80.0] } } }),
    ] {
        assert_ne!(all, trained(changes.clone()), "{changes}");
    }
}

#[test]
fn a_training_under_faults_is_the_same_for_any_threads() {
    let dataset = presses(45, 20);
    let candidate = mlp(&dataset, recipe(json!({ "faults": { "probability": 1.0 } })));
    let trained = |threads| {
        let options = RunOptions { threads: Some(threads), ..RunOptions::default() };
        let protocol = Protocol::default();
        let fit = Fit { candidate: &candidate, protocol: &protocol, seed: 5, options, session: None };
        let mut encoder = Encoder::new(&Encoding::default(), &dataset);
        fit.run(&mut encoder, &mut |_| {}, &AtomicBool::new(false)).unwrap().unwrap()
    };
    assert_eq!(trained(1).weights(), trained(2).weights());
}

#[test]
fn images_and_sequences_are_broken_too() {
    let images = imprints(30, 12);
    let mut encoder = Encoder::new(
        &serde_json::from_value(json!({ "image": { "kind": "raw", "scale": "z-score" } })).unwrap(),
        &images,
    );
    let small = json!({ "faults": { "kinds": ["shift", "rotation", "stuck"] }, "epochs": 1 });
    let net = network("vgg6-lite-2d", json!({}), recipe(small), &mut encoder);
    let encoding: Encoding =
        serde_json::from_value(json!({ "image": { "kind": "raw", "scale": "z-score" } })).unwrap();
    fit(&net, &images, &encoding).unwrap();
    // Both act on one image: the fault on readings, the augmentation on what they become.
    let mut both = net.clone();
    support::change(&mut both, |network| {
        network.recipe.augment = Some(Augment { shift: 2.0, ..Augment::default() })
    });
    assert_ne!(
        fit(&net, &images, &encoding).unwrap().weights(),
        fit(&both, &images, &encoding).unwrap().weights()
    );
    let sequences = squeezes(12, [4, 8, 8]);
    let method = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    let hardened = method.hardened(&TrainingFaults::default(), None);
    fit(&hardened, &sequences, &Encoding::default()).unwrap();
}

#[test]
fn a_baseline_learns_from_its_clean_samples_and_their_copies() {
    let dataset = presses(30, 20);
    let faults =
        TrainingFaults { kinds: vec![Fault::Dead], probability: 1.0, copies: 3, ..Default::default() };
    let clean = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    let hardened = clean.hardened(&faults, None);
    let kept =
        |candidate: &Candidate| fit(candidate, &dataset, &Encoding::default()).unwrap().weights().clone();
    let (before, after) = (kept(&clean), kept(&hardened));
    let rows = |weights: &Weights| weights.iter().map(|(_, tensor)| tensor.data.len()).max().unwrap();
    assert_eq!(rows(&after), 4 * rows(&before));
    // What was learned from them helps: a dead first channel.
    let mut dead = dataset.x.clone();
    for mut sample in dead.axis_iter_mut(Axis(0)) {
        sample.index_axis_mut(Axis(0), 1).fill(0.0);
    }
    let right = |candidate: &Candidate, x: &ArrayD<f32>| {
        let predictions = fit(candidate, &dataset, &Encoding::default()).unwrap().predict(x).unwrap();
        (0..30)
            .filter(|&i| {
                predictions.class(i) == dataset.output_names()[dataset.strata().to_vec()[i] as usize]
            })
            .count()
    };
    assert!(right(&hardened, &dead) >= right(&clean, &dead));
    assert_eq!(right(&hardened, &dataset.x), 30);
}

#[test]
fn rows_say_how_they_were_hardened() {
    let dataset = presses(24, 20);
    let clean = mlp(&dataset, recipe(json!({})));
    let faults = TrainingFaults::default();
    let rows = vec![
        clean.clone(),
        clean.hardened(&faults, None),
        clean.hardened(&faults, Some(Fault::Drift)),
        Candidate::baseline(Method::NearestNeighbours { k: 1 }),
    ];
    let (_keep, folder) = run(three_folds(&dataset, rows));
    let results = folder.results().unwrap();
    let named: Vec<&str> = results.networks.iter().map(|row| row.network.as_str()).collect();
    assert_eq!(named, ["mlp", "mlp.hardened", "mlp.without-drift", "k-nn"]);
    let of = |row: usize| results.networks[row].hardening.clone();
    assert_eq!((of(0), of(3)), (None, None));
    let (hardened, spared) = (of(1).unwrap(), of(2).unwrap());
    assert_eq!((hardened.clean.as_deref(), hardened.unmet), (Some("mlp"), None));
    assert_eq!((spared.clean.as_deref(), spared.unmet), (Some("mlp"), Some(Fault::Drift)));
    assert_eq!(spared.faults.without, [Fault::Drift]);
    // Names tell the trainings apart, and the start is the same: only what is met differs.
    let loss = |name: &str| record(&folder, &key(name, 0, 0)).epochs[0].train_loss;
    assert_ne!(loss("mlp"), loss("mlp.hardened"));
    assert_ne!(loss("mlp.hardened"), loss("mlp.without-drift"));
}

#[test]
fn what_cannot_be_met_is_refused_before_anything_is_trained() {
    let dataset = presses(24, 20);
    let refused = |changes| {
        let candidate = mlp(&dataset, recipe(changes));
        CrossValidation::new(&dataset).candidate(candidate).run().unwrap_err().to_string()
    };
    let error = refused(json!({ "faults": { "kinds": ["rotation"] } }));
    assert!(
        error.starts_with("faults.kinds = rotation: fault rotation has no meaning for a series"),
        "{error}"
    );
    let error = refused(json!({ "faults": { "probability": 1.5 } }));
    assert_eq!(error, "faults.probability = 1.5: must be in 0..=1");
    let error = refused(json!({ "faults": { "levels": { "stuck": [0.0, 5.0] } } }));
    assert!(error.starts_with("faults.levels.stuck = [0, 5]: must be [smallest, largest] in "), "{error}");
    let baseline = Candidate::baseline(Method::all()[1]);
    let faults = TrainingFaults { copies: 1000, ..Default::default() };
    let error =
        fit(&baseline.hardened(&faults, None), &dataset, &Encoding::default()).unwrap_err().to_string();
    assert_eq!(error, "faults.copies = 1000: must be in 1..=100");
    assert!(baseline.estimator.as_network().is_none());
}

#[test]
fn a_guard_stands_before_the_training_as_before_the_answer() {
    let dataset = presses(30, 20);
    let faults = TrainingFaults { kinds: vec![Fault::Stuck], probability: 1.0, ..Default::default() };
    let nearest = Candidate::baseline(Method::NearestNeighbours { k: 1 }).hardened(&faults, None);
    let guarded: Encoding = serde_json::from_value(json!({ "guard": true })).unwrap();
    // What the baseline keeps: full scale where a channel was stuck, unless a guard has replaced it.
    let kept = |encoding: &Encoding| fit(&nearest, &dataset, encoding).unwrap().weights().clone();
    let (without, with) = (kept(&Encoding::default()), kept(&guarded));
    assert_ne!(without, with);
}
