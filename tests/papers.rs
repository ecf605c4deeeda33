//! One small, seeded experiment per paper on its simulated scene (`papers/*.toml`), through encoding, network,
//! protocol and metrics, held to `papers/pins.json`, which `scripts/pin_papers.py` writes. Networks left as they were drawn
//! are pinned to their last digits: they move when scene, encoding, network, costs, initialisation, splits or loss
//! change. Trained ones are pinned to the spread of ten seeds. These are values of this repository on simulated
//! data: no paper's numbers.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use taxel::experiment::run;
use taxel::learn::{FoldKey, FoldRecord, NetworkResults, Silent};
use taxel::{Experiment, Overrides, Registry, RunOptions};

/// A rate that changes no weight, as in `scripts/pin_papers.py`.
const FIXED: [&str; 2] = ["train.optimizer.lr=1e-30", "train.epochs=1"];
const CHOICE: &str = r#"choose.grid={"optimizer.lr"=[1e-30]}"#;

/// Of losses, relative: vectors of another width add in another order.
const DIGITS: f64 = 1e-5;

/// Runs the config of `paper`; of each network its results and the record of its first fold.
fn results(paper: &str, set: &[&str]) -> Vec<(NetworkResults, FoldRecord)> {
    let dir = tempfile::tempdir().unwrap();
    let registry = Registry::built_in();
    let set = set.iter().map(ToString::to_string).collect();
    let overrides = Overrides { set, ..Overrides::default() };
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../tests/papers/{paper}.toml"));
    let experiment = Experiment::load(&config, &overrides, &registry).unwrap();
    let (out, options) = (dir.path().join("run"), RunOptions::default());
    let folder = run(&experiment, &registry, Some(&out), &options, &Silent, &AtomicBool::new(false)).unwrap();
    let first = |network: &NetworkResults| {
        let key = FoldKey { network: network.network.clone(), repetition: 0, fold: 0 };
        folder.record(&key).unwrap().unwrap()
    };
    folder.results().unwrap().networks.into_iter().map(|network| (network.clone(), first(&network))).collect()
}

/// Equal, numbers within [`DIGITS`].
fn same(what: &str, found: impl Into<Value>, want: &Value) {
    let found = found.into();
    match (found.as_f64(), want.as_f64()) {
        (Some(now), Some(before)) => {
            assert!((now - before).abs() <= DIGITS * before.abs(), "{what} is {now}, was {before}");
        }
        _ => assert_eq!(found, *want, "{what}"),
    }
}

/// Holds `paper` to its pins; its trained networks and baselines.
fn pinned(paper: &str, more: &[&str]) -> Vec<(NetworkResults, FoldRecord)> {
    let pins: Value = serde_json::from_str(include_str!("papers/pins.json")).unwrap();
    let (fixed, trained) = (&pins[paper]["fixed"], &pins[paper]["trained"]);

    let drawn = results(paper, &[&FIXED, more].concat());
    assert_eq!(drawn.len(), fixed.as_array().unwrap().len());
    for ((network, fold), want) in drawn.iter().zip(fixed.as_array().unwrap()) {
        let name = |what: &str| format!("{paper}: {what} of {} as it was drawn", network.network);
        same("name", network.network.as_str(), &want["network"]);
        same(&name("parameters"), network.costs.parameters, &want["parameters"]);
        same(&name("MACs"), network.costs.macs, &want["macs"]);
        same(&name("training loss"), fold.epochs.first().map(|epoch| epoch.train_loss), &want["train_loss"]);
        same(&name("test loss"), fold.test_loss, &want["test_loss"]);
        same(&name("accuracy"), network.score("accuracy").unwrap(), &want["accuracy"]);
        same(&name("confusion"), serde_json::to_value(&network.confusion).unwrap(), &want["confusion"]);
    }

    let found = results(paper, &[]);
    assert_eq!(found.len(), trained.as_array().unwrap().len());
    for ((network, _), want) in found.iter().zip(trained.as_array().unwrap()) {
        same("name", network.network.as_str(), &want["network"]);
        let seeds: Vec<f64> =
            want["accuracy"].as_array().unwrap().iter().map(|a| a.as_f64().unwrap()).collect();
        let n = seeds.len() as f64;
        let mean = seeds.iter().sum::<f64>() / n;
        let sd = (seeds.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let accuracy = network.score("accuracy").unwrap();
        println!("{paper}: {} {accuracy:.2} %, {n} seeds {mean:.2} ± {sd:.2}", network.network);
        assert!(
            (accuracy - mean).abs() <= 3.0 * sd + 1e-9,
            "{}: {accuracy} %, was {mean} ± {sd}",
            network.network
        );
    }
    found
}

#[test]
fn paper_000_hardness_from_fingertips() {
    let found = pinned("paper-000", &[]);
    // Kaewrakmuk and Srinonchat 2026, Fig. 6: hardness 20 is taken for 10 more often than for 00.
    let confusion = found[0].0.confusion.as_ref().unwrap().counts().to_vec();
    assert!(confusion[2][1] >= confusion[2][0], "{confusion:?}");
    assert_eq!(confusion.iter().flatten().sum::<u64>(), 150);
}

#[test]
fn paper_001_touch_on_virtual_arrays() {
    let found = pinned("paper-001", &[CHOICE]);
    assert_eq!(found[0].0.folds[0].test_samples, 60);
}

#[test]
fn paper_002_squeezes() {
    let found = pinned("paper-002", &[]);
    assert_eq!(found[1].0.network, "tactnet3d-4-8.n6");
    assert_eq!(found[1].0.folds[0].train_samples, 54);
}

#[test]
fn paper_003_bags() {
    let found = pinned("paper-003", &[]);
    assert_eq!((found[0].1.train_samples, found[0].1.index.len()), (32, 40));
}

#[test]
fn paper_004_levels_of_elasticity_and_hardness() {
    let found = pinned("paper-004", &[]);
    let [elasticity, hardness] = found[0].0.attributes.as_slice() else { panic!("two attributes") };
    assert_eq!((elasticity.per_level.len(), hardness.per_level.len()), (10, 10));
    let mean = (elasticity.scores.accuracy + hardness.scores.accuracy) / 2.0;
    assert!((100.0 * mean - found[0].0.score("accuracy").unwrap()).abs() <= 1e-9);
}
