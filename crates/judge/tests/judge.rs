//! A small run judged: models answer as they did, faults break what they must, speed is measured.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use taxel_judge::{
    By, Case, Judgement, Kind, Options, Outcome, StressOptions, Test, Wish, across, choose, claims, judge,
    stress,
};
use taxel_scenes::faults::Fault;
use taxel_trainer::{Experiment, Overrides, RunOptions, Silent, run};

const CONFIG: &str = r#"
name = "judged"
seed = 3
baselines = ["majority", "k-nn", "mini-rocket", "svm-linear", "svm-rbf"]
[data]
scene = "fingertip"
samples = 60
[encoding]
signal = { scale = "z-score" }
image = { kind = "gadf", size = 12, range = "per-sample" }
[protocol]
folds = 2
[train]
epochs = 6
batch_size = 8
optimizer = { name = "adam", lr = 3e-3 }
[[networks]]
name = "resnet8-lite-1d"
[[networks]]
name = "vgg6-lite-2d"
"#;

const GRIPPER: &str = r#"
name = "gripped"
seed = 1
baselines = ["k-nn"]
[data]
scene = "gripper"
samples = 60
attributes = ["elasticity", "hardness"]
[encoding]
image = { kind = "numatac" }
[protocol]
kind = "random-splits"
test = 0.5
[train]
epochs = 1
batch_size = 8
loss = "multi-label-soft-margin"
optimizer = { name = "adam", lr = 1e-3 }
[[networks]]
name = "multiscale-cnn"
"#;

fn case(config: &str, folder: &Path) -> Case {
    let experiment = Experiment::parse(config, "test.toml", &Overrides::default()).unwrap();
    let options = RunOptions { out: Some(folder.into()), ..RunOptions::default() };
    run(&experiment, &options, &Silent, &AtomicBool::new(false)).unwrap();
    Case::open(folder).unwrap()
}

#[test]
fn saved_models_answer_as_in_their_own_test() {
    for config in [CONFIG, GRIPPER] {
        let folder = tempfile::tempdir().unwrap();
        let case = case(config, folder.path());
        for network in case.contestants() {
            for record in case.records(network).unwrap() {
                let mut model = case.predictor(&record.key, 7, 1).unwrap();
                let x = case.samples.x.select(ndarray::Axis(0), &record.index);
                let got = model.predict(&x, "test").unwrap();
                assert_eq!(got.len(), record.probabilities.len(), "{}", record.key);
                for (got, want) in got.iter().zip(&record.probabilities) {
                    assert!((got - want).abs() <= 1e-5, "{}: {got} and {want}", record.key);
                }
                assert_eq!(model.predicted(&got), record.predicted, "{}", record.key);
            }
        }
    }
}

#[test]
fn faults_are_scored_on_every_network() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(CONFIG, folder.path());
    let quiet = |options: &StressOptions| stress(&case, options, &|_| {}, &|| {}).unwrap();
    let options = StressOptions {
        faults: vec![Fault::Noise, Fault::Saturation],
        threads: 2,
        ..StressOptions::default()
    };
    let outcome = quiet(&options);
    assert_eq!((outcome.samples, outcome.of), (60, 60));
    assert_eq!(outcome, quiet(&StressOptions { threads: 1, ..options.clone() }), "threads do not matter");
    assert_eq!(outcome.reference.as_deref(), Some("k-nn"));
    for (network, own) in outcome.networks.iter().zip(&case.results.networks) {
        // The clean accuracy is the run's own.
        let accuracy = own.mean.unwrap().accuracy;
        assert!((network.clean.accuracy - accuracy).abs() < 1e-9, "{}: {accuracy}", network.network);
        assert_eq!(network.curves.len(), 2);
        let error: f64 = network.corruption_error.unwrap();
        if network.network == "k-nn" {
            assert!((error - 100.0).abs() < 1e-9);
            assert!((network.relative_corruption_error.unwrap() - 100.0).abs() < 1e-9);
        }
        if network.network == "majority" {
            assert_eq!(network.mean_loss, 0.0, "it reads nothing");
            assert!(network.verdict.contains("nothing to break"), "{}", network.verdict);
        }
    }
    // Readings cut at 30 % of full scale hold little of a grasp.
    let rocket = outcome.networks.iter().find(|n| n.network == "mini-rocket").unwrap();
    assert!(rocket.curves[1].points[4].1.accuracy < rocket.clean.accuracy, "{rocket:?}");
    // One severity alone gives the same number.
    let one = StressOptions { faults: vec![Fault::Saturation], severity: Some(5), ..options };
    assert_eq!(quiet(&one).networks[4].curves[0].points[0], outcome.networks[4].curves[1].points[4]);
    let shift = StressOptions { faults: vec![Fault::Shift], ..StressOptions::default() };
    let error = stress(&case, &shift, &|_| {}, &|| {}).unwrap_err().to_string();
    assert!(error.contains("shift") && error.contains("channels have no place"), "{error}");
}

#[test]
fn a_judgement_holds_what_a_report_needs() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(GRIPPER, folder.path());
    let faults = vec![Fault::Dead, Fault::Onset];
    let wanted = StressOptions { faults, samples: 10, ..StressOptions::default() };
    let options = Options { stress: Some(wanted), budget: 0.1, ..Options::default() };
    let judgement = judge(&case, &options).unwrap();
    assert_eq!(judgement.kind, Kind::Simulated);
    assert_eq!(judgement.networks.len(), 2);
    assert_eq!(judgement.networks[0].inputs, ["image"]);
    assert!(judgement.networks[1].baseline && judgement.networks[1].training.is_empty());
    assert_eq!(judgement.networks[0].training.len(), 1);
    for network in &judgement.networks {
        let speed = network.speed.unwrap();
        assert!(speed.runs >= 5 && speed.whole_p50_ms >= speed.p50_ms, "{speed:?}");
        assert!(speed.samples_per_second > 0.0);
    }
    assert!(judgement.networks.iter().any(|n| n.on_front));
    let stress = judgement.stress.as_ref().unwrap();
    assert!(stress.samples <= 10 && stress.of == 30, "{} of {}", stress.samples, stress.of);
    assert!(!judgement.examples.is_empty());
    let example = &judgement.examples[0];
    assert_eq!(example.pictures[0].name, "reading");
    assert!(example.truth.starts_with("elasticity:"), "{}", example.truth);
    assert_eq!(example.verdicts.len(), 2);
    judgement.write(&case.folder).unwrap();
    assert_eq!(Judgement::read(&case).unwrap().unwrap(), judgement);
}

#[test]
fn a_run_is_chosen_from_and_asked_about_claims() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(CONFIG, folder.path());
    let options = Options { stress: None, budget: 0.05, ..Options::default() };
    let judgement = judge(&case, &options).unwrap();
    let choice = choose(&case, &judgement, &Wish::default()).unwrap();
    assert_eq!((choice.test, choice.evidence.len()), (Test::NadeauBengio, 7));
    let best = choice.evidence.iter().map(|own| own.accuracy).fold(0.0, f64::max);
    for own in &choice.evidence {
        let mean = judgement.networks.iter().find(|n| n.results.network == own.network).unwrap();
        assert_eq!(own.accuracy, mean.results.mean.unwrap().accuracy);
        assert!((own.difference - (own.accuracy - best)).abs() < 1e-9, "{own:?}");
        assert_eq!(own.p.is_none(), own.network == choice.best);
    }
    // Two folds of thirty tell little, and the words say so.
    assert!(!choice.enough_data, "{choice:#?}");
    assert!(choice.words.iter().any(|words| words.starts_with("Too few data")), "{:#?}", choice.words);
    assert!(choice.chosen.as_deref().is_some_and(|name| name != "majority"));
    assert_eq!(choice, choose(&case, &judgement, &Wish::default()).unwrap());
    let text = serde_json::to_string(&choice).unwrap();
    assert_eq!(serde_json::from_str::<taxel_judge::Choice>(&text).unwrap(), choice);
    let limited = Wish { max_loss: Some(10.0), by: By::Size, ..Wish::default() };
    let error = choose(&case, &judgement, &limited).unwrap_err().to_string();
    assert!(error.contains("stress test"), "{error}");
    assert_eq!(across(&[&judgement; 5], 0.05).unwrap(), None, "one data set five times is one");
    let asked = claims(&[(&case, &judgement)]).unwrap();
    let says = |part: &str| asked.iter().find(|claim| claim.says.contains(part)).unwrap();
    assert_eq!(says("1D beats 2D: ResNet8").outcome, Outcome::CannotBeTested);
    assert!(says("1D beats 2D: ResNet8").effect.contains("lacks resnet8-lite-2d"));
    let shore = says("commonest error of 2D-Vgg6-Lite");
    assert!(shore.size.is_some_and(f64::is_finite), "{shore:?}");
    assert_eq!((shore.kind, shore.run.as_str()), (Kind::Simulated, "judged"));
}

#[test]
fn one_random_split_is_mcnemars() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(GRIPPER, folder.path());
    let judgement = judge(&case, &Options { stress: None, budget: 0.05, ..Options::default() }).unwrap();
    let choice = choose(&case, &judgement, &Wish { by: By::Macs, ..Wish::default() }).unwrap();
    assert_eq!(choice.test, Test::McNemar);
    // The gripper's groups are its objects: whole ones are drawn.
    let other = choice.evidence.iter().find(|own| own.network != choice.best).unwrap();
    let [low, high] = other.interval.unwrap();
    assert!(low <= other.difference && other.difference <= high && low < high, "{other:?}");
    assert!(choice.words.iter().any(|words| words.contains("elasticity and hardness")));
}
