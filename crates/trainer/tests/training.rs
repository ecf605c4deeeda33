//! What a training does besides its steps: choosing, stopping, several attributes, baselines, protocols.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use taxel_data::Npz;
use taxel_trainer::{
    Error, Experiment, FoldKey, FoldRecord, Overrides, Results, RunFolder, RunOptions, Samples, Silent,
    Table, run_on,
};

const TINY: &str = r#"
name = "tiny"
seed = 3
baselines = []
[data]
scene = "fingertip"
samples = 45
[protocol]
folds = 3
[train]
epochs = 4
batch_size = 8
[[networks]]
name = "mlp"
set = { hidden = 8 }
"#;

fn experiment(text: &str, sets: &[&str]) -> Experiment {
    let set = sets.iter().map(ToString::to_string).collect();
    Experiment::parse(text, "tiny.toml", &Overrides { set, ..Overrides::default() }).unwrap()
}

fn go(experiment: &Experiment, samples: &Samples, out: &Path) -> Result<RunFolder, Error> {
    let options = RunOptions { out: Some(out.into()), threads: Some(1), ..RunOptions::default() };
    run_on(experiment, samples, &options, &Silent, &AtomicBool::new(false))
}

/// Runs TINY with `sets`: the folder lives as long as the first of the two.
fn run_tiny(sets: &[&str]) -> (tempfile::TempDir, RunFolder) {
    let dir = tempfile::tempdir().unwrap();
    let experiment = experiment(TINY, sets);
    let folder = go(&experiment, &Samples::load(&experiment).unwrap(), &dir.path().join("run")).unwrap();
    (dir, folder)
}

fn record(folder: &RunFolder, network: &str, repetition: usize, fold: usize) -> FoldRecord {
    folder.record(&FoldKey { network: network.into(), repetition, fold }).unwrap().unwrap()
}

fn model(folder: &RunFolder, fold: usize) -> Vec<u8> {
    let key = FoldKey { network: "mlp".into(), repetition: 0, fold };
    std::fs::read(folder.model_path(&key)).unwrap()
}

#[test]
fn every_option_changes_the_training_and_nothing_is_left_unread() {
    let (_keep, plain) = run_tiny(&[]);
    for set in [
        "train.optimizer={ name = \"adam\", lr = 1e-3 }",
        "train.optimizer={ name = \"adamw\", lr = 1e-3, weight_decay = 0.1 }",
        "train.schedule={ kind = \"cosine\" }",
        "train.schedule={ kind = \"steps\", at = [0.5] }",
        "train.clip=0.01",
        "train.label_smoothing=0.2",
        "train.early_stopping={ patience = 2 }",
        "train.loss=mean-squared-error",
        "train.frozen=[\"fc1\"]",
    ] {
        let (_keep, other) = run_tiny(&[set]);
        assert_ne!(model(&plain, 0), model(&other, 0), "{set}");
    }
    // Adam and AdamW part where there is a penalty.
    let adam = |name: &str| {
        format!("train.optimizer={{ name = \"{name}\", lr = 1e-3, weight_decay = 0.1, betas = [0.8, 0.9] }}")
    };
    let ((_a, coupled), (_b, decoupled)) = (run_tiny(&[&adam("adam")]), run_tiny(&[&adam("adamw")]));
    assert_ne!(model(&coupled, 0), model(&decoupled, 0));
}

#[test]
fn frozen_layers_stay_and_unknown_ones_are_named() {
    let weights = |folder: &RunFolder| {
        let key = FoldKey { network: "mlp".into(), repetition: 0, fold: 0 };
        taxel_trainer::read_checkpoint(&folder.model_path(&key)).unwrap().0
    };
    let (_a, short) = run_tiny(&["train.frozen=[\"fc1\"]", "train.epochs=1"]);
    let (_b, long) = run_tiny(&["train.frozen=[\"fc1\"]"]);
    let (short, long) = (weights(&short), weights(&long));
    assert_eq!(short.get("fc1.weight"), long.get("fc1.weight"));
    assert_ne!(short.get("fc2.weight"), long.get("fc2.weight"));
    let dir = tempfile::tempdir().unwrap();
    let experiment = experiment(TINY, &["train.frozen=[\"fc9\"]"]);
    let error = go(&experiment, &Samples::load(&experiment).unwrap(), &dir.path().join("run")).unwrap_err();
    assert!(error.to_string().contains("mlp: cannot freeze `fc9`"), "{error}");
    assert!(!dir.path().join("run").exists());
}

#[test]
fn early_stopping_keeps_the_best_epoch_and_ends() {
    let stop = "train.early_stopping={ patience = 3, validation = 0.2 }";
    let (_keep, folder) = run_tiny(&[stop, "train.epochs=60", "train.optimizer.lr=0.2"]);
    for fold in 0..3 {
        let record = record(&folder, "mlp", 0, fold);
        let best = record.best_epoch.unwrap();
        let losses: Vec<f64> = record.epochs.iter().map(|e| e.validation_loss.unwrap()).collect();
        assert!(losses.iter().all(|loss| losses[best] <= *loss), "{losses:?}");
        assert!(record.epochs.len() == 60 || record.epochs.len() == best + 1 + 3, "{} {best}", losses.len());
        assert_eq!(record.train_samples, 30);
    }
    let stopped = (0..3).filter(|&fold| record(&folder, "mlp", 0, fold).epochs.len() < 60).count();
    assert!(stopped > 0);
    // The weights are the best epoch's: a run that ends there has the same ones.
    let best = record(&folder, "mlp", 0, 0).best_epoch.unwrap();
    let (_keep, short) = run_tiny(&[stop, &format!("train.epochs={}", best + 1), "train.optimizer.lr=0.2"]);
    assert!(model(&folder, 0) == model(&short, 0));
}

const CHOOSE: &str =
    "choose={ validation = 0.3, grid = { \"optimizer.lr\" = [1e-6, 0.05], \"batch_size\" = [4, 8] } }";

#[test]
fn settings_are_chosen_per_fold_and_never_by_test_data() {
    let experiment = experiment(TINY, &[CHOOSE]);
    let samples = Samples::load(&experiment).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let folder = go(&experiment, &samples, &dir.path().join("plain")).unwrap();
    for fold in 0..3 {
        let chosen = record(&folder, "mlp", 0, fold).chosen.unwrap();
        assert_eq!(chosen.trials.len(), 4);
        let least = chosen.trials.iter().map(|t| t.loss.unwrap()).fold(f64::INFINITY, f64::min);
        let best = chosen.trials.iter().find(|t| t.loss == Some(least)).unwrap();
        assert_eq!(best.set, chosen.set);
    }
    // Spoil the test samples of fold 0: what fold 0 has chosen and trained stays the same.
    let test = samples.folds(&experiment, 0).unwrap()[0].test.clone();
    let mut spoilt = samples.clone();
    for &row in &test {
        spoilt.x.index_axis_mut(ndarray::Axis(0), row).mapv_inplace(|v| 1023.0 - v);
    }
    let other = go(&experiment, &spoilt, &dir.path().join("spoilt")).unwrap();
    assert!(model(&folder, 0) == model(&other, 0));
    assert_eq!(record(&folder, "mlp", 0, 0).chosen, record(&other, "mlp", 0, 0).chosen);
    assert_ne!(record(&folder, "mlp", 0, 0).probabilities, record(&other, "mlp", 0, 0).probabilities);
    // The chosen training is the one with its values written down, on the whole training part.
    let chosen = record(&folder, "mlp", 0, 0).chosen.unwrap().set;
    let sets: Vec<String> = chosen.iter().map(|(key, value)| format!("train.{key}={value}")).collect();
    let (_keep, fixed) = run_tiny(&sets.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(model(&folder, 0) == model(&fixed, 0));
}

#[test]
fn a_rate_that_diverges_is_not_chosen_and_all_of_them_are_an_error() {
    let grid = |rates: &str| format!("choose={{ grid = {{ \"optimizer.lr\" = {rates} }} }}");
    let (_keep, folder) = run_tiny(&[&grid("[1e30, 0.01]"), "train.epochs=2"]);
    let chosen = record(&folder, "mlp", 0, 0).chosen.unwrap();
    assert_eq!(chosen.trials[0].loss, None);
    assert_eq!(chosen.set["optimizer.lr"].as_float(), Some(0.01));
    let dir = tempfile::tempdir().unwrap();
    let experiment = experiment(TINY, &[&grid("[1e30, 1e31]")]);
    let error = go(&experiment, &Samples::load(&experiment).unwrap(), &dir.path().join("run")).unwrap_err();
    assert!(
        error.to_string().starts_with("mlp, repetition 0, fold 0: training diverged with all 2"),
        "{error}"
    );
}

/// Two attributes that channel 0 and channel 1 show: level = height.
fn two_attributes(dir: &Path) -> std::path::PathBuf {
    let (n, mut x, mut y) = (60usize, vec![], vec![]);
    for i in 0..n {
        let levels = [i % 3, (i / 3) % 4];
        for level in levels {
            x.extend((0..12).map(|t| level as f32 + 0.2 * ((i * 7 + t * 3) as f32).sin()));
        }
        y.extend(levels.map(|level| level as u32));
    }
    let mut npz = Npz::default();
    npz.add("x", &[n, 2, 12], &x).unwrap();
    npz.add("y", &[n, 2], &y).unwrap();
    npz.add("held", &[n], &(0..n).map(|i| u32::from(i % 4 == 0)).collect::<Vec<_>>()).unwrap();
    npz.add("group", &[n], &(0..n as u32).map(|i| i / 12).collect::<Vec<_>>()).unwrap();
    let path = dir.join("levels.npz");
    std::fs::write(&path, npz.finish().unwrap()).unwrap();
    path
}

fn two_level_experiment(path: &Path, sets: &[&str]) -> Experiment {
    let text = TINY.replace("scene = \"fingertip\"\nsamples = 45", &format!("path = \"{}\"", path.display()));
    experiment(&text, sets)
}

#[test]
fn several_attributes_are_learned_and_scored_level_by_level() {
    let dir = tempfile::tempdir().unwrap();
    let sets = [
        "data.attributes=[\"elasticity\", \"hardness\"]",
        "train.loss=multi-label-soft-margin",
        "train.epochs=60",
        "train.optimizer={ name = \"adam\", lr = 0.02 }",
        "baselines=[\"majority\", \"svm-linear\"]",
    ];
    let experiment = two_level_experiment(&two_attributes(dir.path()), &sets);
    let samples = Samples::load(&experiment).unwrap();
    assert_eq!((samples.classes.len(), samples.classes[4].as_str()), (7, "hardness:1"));
    let folder = go(&experiment, &samples, &dir.path().join("run")).unwrap();
    let results = folder.results().unwrap();
    assert_eq!(results.attributes[1].name, "hardness");
    let mlp = &results.networks[0];
    assert!(mlp.mean.unwrap().accuracy > 90.0, "{:?}", mlp.mean);
    assert_eq!((mlp.attributes.len(), mlp.attributes[1].per_level.len()), (2, 4));
    assert!(mlp.attributes[0].mean_absolute_error < 0.2 && mlp.confusion.is_none());
    let majority = &results.networks[1];
    assert!(majority.mean.unwrap().accuracy < 50.0 && majority.attributes[0].mean_absolute_error > 0.5);
    assert!(results.networks[2].mean.unwrap().accuracy > 90.0);
    let record = record(&folder, "mlp", 0, 0);
    assert_eq!(
        (record.truth.len(), record.probabilities.len()),
        (2 * record.index.len(), 7 * record.index.len())
    );
    let text = Table::of(&folder).unwrap().to_string();
    assert!(text.contains("hardness off by"), "{text}");
    // Splits are even over the combinations of levels.
    for fold in samples.folds(&experiment, 0).unwrap() {
        let mut seen: Vec<u32> = fold.test.iter().map(|&row| samples.y[row]).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 12);
    }
    let refused = |sets: &[&str]| {
        let parsed = sets.iter().map(ToString::to_string).collect();
        let text = TINY.replace("scene = \"fingertip\"\nsamples = 45", "path = \"levels.npz\"");
        Experiment::parse(&text, "tiny.toml", &Overrides { set: parsed, ..Overrides::default() })
            .unwrap_err()
            .to_string()
    };
    let error = refused(&sets[..1]);
    assert!(error.contains("train.loss") && error.contains("multi-label-soft-margin"), "{error}");
    let three = two_level_experiment(
        &dir.path().join("levels.npz"),
        &["data.attributes=[\"a\", \"b\", \"c\"]", sets[1]],
    );
    let error = Samples::load(&three).unwrap_err().to_string();
    assert!(error.contains("has 2 columns of labels"), "{error}");
}

#[test]
fn protocols_cut_as_they_say() {
    let dir = tempfile::tempdir().unwrap();
    let path = two_attributes(dir.path());
    let folds = |protocol: &str| {
        let set = format!("protocol={protocol}");
        let experiment = two_level_experiment(&path, &[&set, "data.test=held"]);
        let samples = Samples::load(&experiment).unwrap();
        (samples.folds(&experiment, 0).unwrap(), samples)
    };
    let (split, _) = folds("{ kind = \"random-splits\", test = 0.2, validation = 0.1, repetitions = 2 }");
    assert_eq!([split[0].train.len(), split[0].validation.len(), split[0].test.len()], [42, 6, 12]);
    let (left, samples) = folds("{ kind = \"leave-group-out\" }");
    assert_eq!(left.len(), 5);
    for (group, fold) in left.iter().enumerate() {
        assert!(fold.test.iter().all(|&row| samples.groups.as_ref().unwrap()[row] == group as u32));
    }
    let (official, _) = folds("{ kind = \"official\" }");
    assert!(official[0].test.iter().all(|row| row % 4 == 0) && official[0].test.len() == 15);
    let (grouped, samples) = folds("{ kind = \"random-splits\", split = \"group\", test = 0.4 }");
    let groups = samples.groups.unwrap();
    assert!(grouped[0].test.iter().all(|&a| grouped[0].train.iter().all(|&b| groups[a] != groups[b])));
}

#[test]
fn a_learning_curve_has_a_row_per_number_of_samples() {
    let protocol = "protocol={ kind = \"few-samples\", per_class = [1, 3], test = 0.4, repetitions = 2 }";
    let (_keep, folder) = run_tiny(&[protocol, "baselines=[\"k-nn\"]"]);
    let results = folder.results().unwrap();
    let rows: Vec<(&str, Option<usize>)> =
        results.networks.iter().map(|n| (n.network.as_str(), n.per_class)).collect();
    assert_eq!(rows, [("mlp.n1", Some(1)), ("mlp.n3", Some(3)), ("k-nn.n1", Some(1)), ("k-nn.n3", Some(3))]);
    assert!(results.complete && results.networks.iter().all(|n| n.folds.len() == 2));
    let (one, three) = (record(&folder, "mlp.n1", 1, 0), record(&folder, "mlp.n3", 1, 0));
    assert_eq!((one.train_samples, three.train_samples), (3, 9));
    assert_eq!(one.index, three.index);
    assert!(Table::of(&folder).unwrap().to_string().contains("few samples per class"));
}

#[test]
fn baselines_stand_in_the_table_and_follow_the_seed() {
    let dir = tempfile::tempdir().unwrap();
    let text = TINY.replace("baselines = []\n", "");
    let plain = experiment(
        &text,
        &[
            "baselines=[\"majority\", { name = \"k-nn\", k = 3 }, { name = \"mini-rocket\", features = 168 }, \"svm-linear\", \"svm-rbf\"]",
        ],
    );
    let samples = Samples::load(&plain).unwrap();
    let folder = go(&plain, &samples, &dir.path().join("a")).unwrap();
    let results = folder.results().unwrap();
    let score =
        |name: &str| results.networks.iter().find(|n| n.network == name).unwrap().mean.unwrap().accuracy;
    assert!((score("majority") - 100.0 / 3.0).abs() <= 1e-9);
    for name in ["k-nn", "mini-rocket", "svm-linear", "svm-rbf"] {
        assert!(score(name) > 50.0, "{name}: {}", score(name));
    }
    let rocket = results.networks.iter().find(|n| n.network == "mini-rocket").unwrap();
    assert!(rocket.costs.parameters > 168 && rocket.costs.macs > 0 && rocket.interval.is_some());
    let key = FoldKey { network: "k-nn".into(), repetition: 0, fold: 0 };
    assert!(folder.model_path(&key).is_file() && folder.timing(&key).unwrap().unwrap().latency.is_some());
    let again = go(&plain, &samples, &dir.path().join("b")).unwrap();
    let bytes = |folder: &RunFolder| std::fs::read(folder.file("results.json")).unwrap();
    assert!(bytes(&folder) == bytes(&again));
    // By default all of them are there; an unknown one is named with its line.
    let config = experiment(&text, &[]).config().clone();
    assert_eq!(config.baselines.unwrap().len(), 5);
    let error = Experiment::parse(&TINY.replace("[]", "[\"knn\"]"), "tiny.toml", &Overrides::default());
    let error = error.unwrap_err().to_string();
    assert!(error.starts_with("tiny.toml:4:") && error.contains("no baseline is called `knn`"), "{error}");
}

#[test]
fn classes_can_be_kept_and_look_alikes_are_told_apart() {
    let keep = ["data.classes=[\"shore-20\", \"shore-00\"]", "baselines=[\"k-nn\"]"];
    let (_keep, folder) = run_tiny(&keep);
    let results: Results = folder.results().unwrap();
    assert_eq!(results.classes, ["shore-20", "shore-00"]);
    assert_eq!(results.samples, 30);
    let alike = "data.look_alikes={ hard = [\"shore-10\", \"shore-20\"], soft = [\"shore-00\"] }";
    let (_keep, folder) = run_tiny(&[alike]);
    let alikes = folder.results().unwrap().networks[0].look_alikes.clone().unwrap();
    assert_eq!(alikes.groups, ["hard", "soft"]);
    let counted: u64 = alikes.confusion.counts().iter().flatten().sum();
    assert_eq!(counted, 45);
    let experiment = experiment(TINY, &["data.look_alikes={ hard = [\"shore-10\"] }"]);
    let dir = tempfile::tempdir().unwrap();
    let error = go(&experiment, &Samples::load(&experiment).unwrap(), &dir.path().join("run")).unwrap_err();
    assert!(error.to_string().contains("must be in exactly one group"), "{error}");
}

/// The order of samples is a pure function: what other epochs or folds did does not matter.
#[test]
fn batches_follow_seed_repetition_fold_and_epoch_alone() {
    let rows: Vec<usize> = (0..50).collect();
    let order = |seed, repetition, fold, epoch| taxel_trainer::shuffled(&rows, seed, repetition, fold, epoch);
    assert_eq!(order(1, 2, 3, 4), order(1, 2, 3, 4));
    for other in [order(2, 2, 3, 4), order(1, 1, 3, 4), order(1, 2, 2, 4), order(1, 2, 3, 5)] {
        assert_ne!(order(1, 2, 3, 4), other);
    }
}

const IMAGES: &str = r#"
name = "squeezes"
baselines = []
[data]
scene = "palpation"
samples = 60
[encoding]
image = { kind = "frame", frame = "peak", scale = "full-scale" }
tensor = { frames = 10, scale = "full-scale" }
[protocol]
folds = 2
[train]
epochs = 2
batch_size = 8
optimizer = { lr = 1e-3 }
[[networks]]
name = "vgg6-lite-2d"
"#;

#[test]
fn augmentation_moves_training_images_alone() {
    let dir = tempfile::tempdir().unwrap();
    let go_with = |name: &str, sets: &[&str]| {
        let experiment = experiment(IMAGES, sets);
        let folder = go(&experiment, &Samples::load(&experiment).unwrap(), &dir.path().join(name)).unwrap();
        record(&folder, "vgg6-lite-2d", 0, 0)
    };
    let augment = "train.augment={ flip_rows = true, flip_columns = true, shift = 3.0, rotate = 10.0 }";
    let (plain, moved, again) =
        (go_with("plain", &[]), go_with("moved", &[augment]), go_with("again", &[augment]));
    assert_ne!(plain.epochs[0].train_loss, moved.epochs[0].train_loss);
    assert_eq!(moved.epochs, again.epochs);
    // Without training the test images are the same ones: a rate of almost 0 leaves the same answers.
    let rate = "train.optimizer.lr=1e-30";
    let (still, turned) = (go_with("still", &[rate]), go_with("turned", &[rate, augment]));
    assert_ne!(still.epochs[1].train_loss, turned.epochs[1].train_loss);
    assert_eq!(still.probabilities, turned.probabilities);
    let set = "encoding={ image = { kind = \"gadf\" } }";
    let overrides = Overrides { set: vec![set.into(), augment.into()], ..Overrides::default() };
    let error = Experiment::parse(IMAGES, "tiny.toml", &overrides).unwrap_err().to_string();
    assert!(error.contains("train.augment") && error.contains("moves pixels"), "{error}");
}

#[test]
fn every_scene_feeds_its_papers_networks() {
    let run = |text: &str, sets: &[&str]| {
        let dir = tempfile::tempdir().unwrap();
        let experiment = experiment(text, sets);
        let samples = Samples::load(&experiment).unwrap();
        let folder = go(&experiment, &samples, &dir.path().join("run")).unwrap();
        let results = folder.results().unwrap();
        let key = FoldKey { network: results.networks[0].network.clone(), repetition: 0, fold: 0 };
        let metadata = taxel_trainer::read_checkpoint(&folder.model_path(&key)).unwrap().1;
        // What was fitted is enough to encode new recordings.
        let (_, transform) = &metadata.inputs[0];
        let x = transform.apply(&samples.x, "new").unwrap();
        assert_eq!(x.shape()[0], samples.len());
        (results, x.shape().to_vec())
    };
    let tensor = "networks=[{ name = \"tactnet3d-4-8\", set = { pool = 2 } }]";
    let (results, shape) = run(IMAGES, &[tensor]);
    assert_eq!(shape, [60, 1, 28, 50, 10]);
    assert!(results.complete);
    let sets = [
        "data={ scene = \"gripper\", samples = 40, attributes = [\"elasticity\", \"hardness\"] }",
        "encoding={ image = { kind = \"numatac\" } }",
        "train={ epochs = 1, batch_size = 8, loss = \"multi-label-soft-margin\", batch_norm = \"moving\", optimizer = { name = \"adam\", lr = 1e-3 } }",
        "networks=[{ name = \"multiscale-cnn\" }]",
    ];
    let (results, shape) = run(IMAGES, &sets);
    assert_eq!(shape, [40, 2, 23, 300]);
    assert_eq!((results.attributes.len(), results.networks[0].attributes.len()), (2, 2));
    let sets = [
        "data={ scene = \"imprint\", samples = 24, set = { elements = 16 } }",
        "encoding={ image = { kind = \"raw\", red = true, resize = [32, 32] } }",
        "networks=[{ name = \"resnet8-lite-2d\" }]",
    ];
    let (results, shape) = run(IMAGES, &sets);
    assert_eq!(shape, [24, 3, 32, 32]);
    assert_eq!(results.classes.len(), 6);
}
