//! The training of a config, down to the trained networks: choosing, attributes, protocols, scenes.
//!
//! The trainings themselves are tested in `taxel-learn`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold, Npz, Quantity, Task};
use taxel_learn::encoding::IMAGE;
use taxel_learn::{Encoder, FoldKey, FoldRecord, Model, ResultsTable, RunFolder, RunOptions, Silent};
use taxel_trainer::{Error, Experiment, Overrides, Runner};
use taxel_zoo::Registry;

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

fn parse(text: &str, sets: &[&str]) -> Result<Experiment, Error> {
    let set = sets.iter().map(ToString::to_string).collect();
    let overrides = Overrides { set, ..Overrides::default() };
    Experiment::parse(text, "tiny.toml", &overrides, &Registry::built_in())
}

fn experiment(text: &str, sets: &[&str]) -> Experiment {
    parse(text, sets).unwrap_or_else(|e| panic!("{e}"))
}

fn go(experiment: &Experiment, dataset: &Dataset, out: &Path) -> Result<RunFolder, Error> {
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    let runner = Runner { experiment, registry: &Registry::built_in(), dataset };
    runner.run(Some(out), &options, &Silent, &AtomicBool::new(false))
}

/// Runs TINY with `sets`: the folder lives as long as the first of the two.
fn run_tiny(sets: &[&str]) -> (tempfile::TempDir, RunFolder) {
    let dir = tempfile::tempdir().unwrap();
    let experiment = experiment(TINY, sets);
    let folder = go(&experiment, &experiment.dataset().unwrap(), &dir.path().join("run")).unwrap();
    (dir, folder)
}

/// Returns the error of TINY with `sets` once it has its samples.
fn refusal(sets: &[&str]) -> String {
    let dir = tempfile::tempdir().unwrap();
    let experiment = experiment(TINY, sets);
    let out = dir.path().join("run");
    let error = go(&experiment, &experiment.dataset().unwrap(), &out).unwrap_err().to_string();
    assert!(!out.exists(), "nothing was begun: {error}");
    error
}

fn key(network: &str, fold: usize) -> FoldKey {
    FoldKey { network: network.into(), repetition: 0, fold }
}

fn record(folder: &RunFolder, network: &str, fold: usize) -> FoldRecord {
    folder.record(&key(network, fold)).unwrap().unwrap()
}

fn model(folder: &RunFolder, fold: usize) -> Vec<u8> {
    std::fs::read(folder.model_path(&key("mlp", fold))).unwrap()
}

fn folds(experiment: &Experiment, dataset: &Dataset) -> Vec<Fold> {
    let config = experiment.config();
    config.protocol.folds(dataset, config.seed, 0).unwrap()
}

/// Settings that a network or the samples refuse are named with the line that holds them.
#[test]
fn what_only_the_samples_can_refuse_names_its_place() {
    let frozen = "train.frozen=[\"fc9\"]";
    let error = refusal(&[frozen]);
    let want = format!("--set {frozen}: networks.0.train.frozen = [\"fc9\"]: mlp: cannot freeze `fc9`");
    assert!(error.starts_with(&want) && error.contains("`taxel cost mlp`"), "{error}");
    let text = TINY.replace("set = { hidden = 8 }", "train.frozen = [\"fc9\"]");
    let frozen = experiment(&text, &[]);
    let error = go(&frozen, &frozen.dataset().unwrap(), Path::new("never")).unwrap_err().to_string();
    assert!(error.starts_with("tiny.toml:15: networks.0.train.frozen = [\"fc9\"]: "), "{error}");

    let error = refusal(&["protocol.split=group", "protocol.folds=200"]);
    assert!(error.contains("protocol.folds") || error.contains("200"), "{error}");
    let error = refusal(&["protocol={ kind = \"official\" }"]);
    let want = "--set protocol={ kind = \"official\" }: protocol.kind = \"official\": simulated: fingertip has no \
                split of its own";
    assert!(error.starts_with(want), "{error}");
    let text = TINY.replace("folds = 3", "kind = \"official\"");
    let official = experiment(&text, &[]);
    let error = go(&official, &official.dataset().unwrap(), Path::new("never")).unwrap_err().to_string();
    assert!(error.starts_with("tiny.toml:9: protocol.kind = \"official\": "), "{error}");
    assert!(!Path::new("never").exists());
}

#[test]
fn samples_without_a_full_scale_or_groups_name_the_line_that_asks_for_them() {
    let dir = tempfile::tempdir().unwrap();
    let mut npz = Npz::default();
    npz.add("x", &[12, 4, 6], &(0..288).map(|i| (i * i % 17) as f32).collect::<Vec<_>>()).unwrap();
    npz.add("y", &[12], &(0..12).map(|i| i % 2).collect::<Vec<u32>>()).unwrap();
    let path = dir.path().join("ladder.npz");
    std::fs::write(&path, npz.finish().unwrap()).unwrap();
    let text = TINY.replace("scene = \"fingertip\"\nsamples = 45", &format!("path = \"{}\"", path.display()));
    let grouped = experiment(&text.replace("folds = 3", "split = \"group\""), &[]);
    let dataset = grouped.dataset().unwrap();
    let error = go(&grouped, &dataset, Path::new("never")).unwrap_err().to_string();
    assert!(
        error.starts_with("tiny.toml:8: protocol.split = \"group\": real: ladder has no groups"),
        "{error}"
    );
    let raw = text
        .replace("[protocol]", "[encoding]\nimage = { kind = \"raw\" }\n[protocol]")
        .replace("name = \"mlp\"\nset = { hidden = 8 }", "name = \"resnet8-lite-2d\"");
    let images = experiment(&raw, &[]);
    let error = go(&images, &images.dataset().unwrap(), Path::new("never")).unwrap_err().to_string();
    assert!(error.starts_with("tiny.toml:5: data.full_scale = not set: the scale needs"), "{error}");
    assert!(!Path::new("never").exists());
    // The samples are images as soon as the encoding says so.
    let mut encoder = Encoder::new(&images.config().encoding, &dataset);
    assert!(encoder.prepare(&[IMAGE]).is_err());
    let of = |full_scale: u32| {
        experiment(&raw.replace("[encoding]", &format!("full_scale = {full_scale}\n[encoding]")), &[])
    };
    let error = of(2).dataset().unwrap_err().to_string();
    assert!(error.contains("data.full_scale = 2: values reach 16, "), "{error}");
    let scaled = of(16);
    let dataset = scaled.dataset().unwrap();
    let mut encoder = Encoder::new(&scaled.config().encoding, &dataset);
    encoder.prepare(&[IMAGE]).unwrap();
    assert_eq!(encoder.shape(IMAGE), Some(vec![1, 4, 6]));
}

const CHOOSE: &str =
    "choose={ validation = 0.3, grid = { \"optimizer.lr\" = [1e-6, 0.05], \"batch_size\" = [4, 8] } }";

#[test]
fn settings_are_chosen_per_fold_and_never_by_test_data() {
    let experiment = experiment(TINY, &[CHOOSE]);
    let dataset = experiment.dataset().unwrap();
    let dir = tempfile::tempdir().unwrap();
    let folder = go(&experiment, &dataset, &dir.path().join("plain")).unwrap();
    for fold in 0..3 {
        let chosen = record(&folder, "mlp", fold).chosen.unwrap();
        assert_eq!(chosen.trials.len(), 4);
        let least = chosen.trials.iter().map(|t| t.loss.unwrap()).fold(f64::INFINITY, f64::min);
        let best = chosen.trials.iter().find(|t| t.loss == Some(least)).unwrap();
        assert_eq!(best.set, chosen.set);
    }
    // Spoil the test samples of fold 0: what fold 0 has chosen and trained stays the same.
    let test = folds(&experiment, &dataset)[0].test.clone();
    let mut spoilt = dataset.clone();
    for &row in &test {
        spoilt.x.index_axis_mut(ndarray::Axis(0), row).mapv_inplace(|v| 1023.0 - v);
    }
    let other = go(&experiment, &spoilt, &dir.path().join("spoilt")).unwrap();
    assert!(model(&folder, 0) == model(&other, 0));
    assert_eq!(record(&folder, "mlp", 0).chosen, record(&other, "mlp", 0).chosen);
    assert_ne!(record(&folder, "mlp", 0).outcome.outputs(), record(&other, "mlp", 0).outcome.outputs());
    // The chosen training is the one with its values written down, on the whole training part.
    let chosen = record(&folder, "mlp", 0).chosen.unwrap().set;
    let sets: Vec<String> = chosen.iter().map(|(key, value)| format!("train.{key}={value}")).collect();
    let (_keep, fixed) = run_tiny(&sets.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(model(&folder, 0) == model(&fixed, 0));
}

#[test]
fn a_rate_that_diverges_is_not_chosen_and_all_of_them_are_an_error() {
    let grid = |rates: &str| format!("choose={{ grid = {{ \"optimizer.lr\" = {rates} }} }}");
    let (_keep, folder) = run_tiny(&[&grid("[1e30, 0.01]"), "train.epochs=2"]);
    let chosen = record(&folder, "mlp", 0).chosen.unwrap();
    assert_eq!(chosen.trials[0].loss, None);
    assert_eq!(chosen.set["optimizer.lr"].as_f64(), Some(0.01));
    let dir = tempfile::tempdir().unwrap();
    let experiment = experiment(TINY, &[&grid("[1e30, 1e31]")]);
    let error = go(&experiment, &experiment.dataset().unwrap(), &dir.path().join("run")).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("\nmlp, repetition 0, fold 0: training diverged with all 2"), "{error}");
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
    let dataset = experiment.dataset().unwrap();
    assert_eq!((dataset.output_names().len(), dataset.output_names()[4].as_str()), (7, "hardness:1"));
    let folder = go(&experiment, &dataset, &dir.path().join("run")).unwrap();
    let results = folder.results().unwrap();
    assert_eq!(results.task.attributes()[1].name, "hardness");
    let mlp = &results.networks[0];
    assert!(mlp.score("accuracy").unwrap() > 90.0, "{:?}", mlp.mean);
    assert_eq!((mlp.attributes.len(), mlp.attributes[1].per_level.len()), (2, 4));
    assert!(mlp.attributes[0].mean_absolute_error < 0.2 && mlp.confusion.is_none());
    let majority = &results.networks[1];
    assert!(majority.score("accuracy").unwrap() < 50.0 && majority.attributes[0].mean_absolute_error > 0.5);
    assert!(results.networks[2].score("accuracy").unwrap() > 90.0);
    let record = record(&folder, "mlp", 0);
    assert_eq!(
        (record.outcome.labels().0.len(), record.outcome.outputs().len()),
        (2 * record.index.len(), 7 * record.index.len())
    );
    let text = ResultsTable::of(&folder).unwrap().to_string();
    assert!(text.contains("hardness off by"), "{text}");
    // Splits are even over the combinations of levels.
    for fold in folds(&experiment, &dataset) {
        let mut seen: Vec<u32> = fold.test.iter().map(|&row| dataset.strata().to_vec()[row]).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 12);
    }
    let text = TINY.replace("scene = \"fingertip\"\nsamples = 45", "path = \"levels.npz\"");
    let wrong = [sets[0], "train.loss=\"softmax-cross-entropy\""];
    let error = parse(&text, &wrong).unwrap_err().to_string();
    assert!(error.contains("train.loss") && error.contains("multi-label-soft-margin"), "{error}");
    let attributes = "data.attributes=[\"a\", \"b\", \"c\"]";
    let three = two_level_experiment(&dir.path().join("levels.npz"), &[attributes, sets[1]]);
    let error = three.dataset().unwrap_err().to_string();
    assert!(error.starts_with(&format!("--set {attributes}: data.attributes = ")), "{error}");
    assert!(error.contains("has 2 columns of labels"), "{error}");
}

#[test]
fn protocols_cut_as_they_say() {
    let dir = tempfile::tempdir().unwrap();
    let path = two_attributes(dir.path());
    let folds = |protocol: &str| {
        let set = format!("protocol={protocol}");
        let experiment = two_level_experiment(&path, &[&set, "data.test=held", "data.attribute=0"]);
        let dataset = experiment.dataset().unwrap();
        (folds(&experiment, &dataset), dataset)
    };
    let (split, _) = folds("{ kind = \"random-splits\", test = 0.2, validation = 0.1, repetitions = 2 }");
    assert_eq!([split[0].train.len(), split[0].validation.len(), split[0].test.len()], [42, 6, 12]);
    let (left, dataset) = folds("{ kind = \"leave-group-out\" }");
    assert_eq!(left.len(), 5);
    for (group, fold) in left.iter().enumerate() {
        assert!(fold.test.iter().all(|&row| dataset.groups.as_ref().unwrap()[row] == group as u32));
    }
    let (official, _) = folds("{ kind = \"official\" }");
    assert!(official[0].test.iter().all(|row| row % 4 == 0) && official[0].test.len() == 15);
    let (grouped, dataset) = folds("{ kind = \"random-splits\", split = \"group\", test = 0.4 }");
    let groups = dataset.groups.unwrap();
    assert!(grouped[0].test.iter().all(|&a| grouped[0].train.iter().all(|&b| groups[a] != groups[b])));
}

/// Of a learning curve every row has its own samples, and every network its own recipe, whatever it is called.
#[test]
fn a_learning_curve_has_a_row_per_number_of_samples() {
    let protocol = "protocol={ kind = \"few-samples\", per_class = [1, 3], test = 0.4, repetitions = 2 }";
    let networks = "networks=[{ name = \"mlp\" }, { name = \"mlp\", label = \"mlp.nobn\", train = { epochs = 2, \
                    loss = \"mean-squared-error\" } }]";
    let (_keep, folder) = run_tiny(&[protocol, networks, "baselines=[\"k-nn\"]"]);
    let results = folder.results().unwrap();
    let rows: Vec<(&str, Option<usize>)> =
        results.networks.iter().map(|n| (n.network.as_str(), n.per_class)).collect();
    assert_eq!(
        rows,
        [
            ("mlp.n1", Some(1)),
            ("mlp.n3", Some(3)),
            ("mlp.nobn.n1", Some(1)),
            ("mlp.nobn.n3", Some(3)),
            ("k-nn.n1", Some(1)),
            ("k-nn.n3", Some(3))
        ]
    );
    assert!(results.complete && results.networks.iter().all(|n| n.folds.len() == 2));
    for (row, epochs, loss, samples) in [
        ("mlp.n1", 4, "softmax-cross-entropy", 3),
        ("mlp.n3", 4, "softmax-cross-entropy", 9),
        ("mlp.nobn.n1", 2, "mean-squared-error", 3),
        ("mlp.nobn.n3", 2, "mean-squared-error", 9),
    ] {
        let key = FoldKey { network: row.into(), repetition: 1, fold: 0 };
        let record = folder.record(&key).unwrap().unwrap();
        assert_eq!((record.epochs.len(), record.train_samples), (epochs, samples), "{row}");
        let card = Model::open(&folder.model_path(&key)).unwrap().card().clone();
        let anatomy = serde_json::to_value(&card.kind).unwrap();
        assert_eq!(anatomy["loss"], loss, "{row}");
        assert_eq!(
            (anatomy["recipe"]["epochs"].as_u64(), card.trained_on.samples),
            (Some(epochs as u64), samples)
        );
    }
    let (one, three) = (record(&folder, "mlp.n1", 0), record(&folder, "mlp.n3", 0));
    assert_eq!(one.index, three.index);
    assert!(ResultsTable::of(&folder).unwrap().to_string().contains("few samples per class"));
}

#[test]
fn single_frames_are_counted_and_kept_by_their_squeezes() {
    let squeezes =
        "[data]\nscene = \"palpation\"\nsamples = 27\neach_frame = true\nset = { paper = \"002\" }\n";
    let text = TINY.replace("[data]\nscene = \"fingertip\"\nsamples = 45\n", squeezes);
    let sets = [
        "protocol={ kind = \"few-samples\", per_class = [1, 2], test = 0.3 }",
        "encoding={ image = { kind = \"raw\", scale = \"full-scale\" } }",
        "networks=[{ name = \"tactnet4\" }]",
    ];
    let quick = experiment(&text, &sets);
    let dataset = quick.dataset().unwrap();
    assert_eq!(dataset.x.shape(), [270, 28, 50]);
    let folds = quick.config().protocol.folds(&dataset, 3, 0).unwrap();
    for (fold, squeezes) in folds.iter().zip([1, 2]) {
        assert_eq!(fold.train.len(), 9 * squeezes * 10);
        assert!(fold.train.iter().all(|a| fold.test.iter().all(|b| a / 10 != b / 10)));
    }
    let refused = experiment(TINY, &["data.each_frame=true"]).dataset().unwrap_err().to_string();
    assert!(refused.contains("data.each_frame") && refused.contains("no frames to take apart"), "{refused}");
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
    let dataset = plain.dataset().unwrap();
    let folder = go(&plain, &dataset, &dir.path().join("a")).unwrap();
    let results = folder.results().unwrap();
    let score =
        |name: &str| results.networks.iter().find(|n| n.network == name).unwrap().score("accuracy").unwrap();
    assert!((score("majority") - 100.0 / 3.0).abs() <= 1e-9);
    for name in ["k-nn", "mini-rocket", "svm-linear", "svm-rbf"] {
        assert!(score(name) > 50.0, "{name}: {}", score(name));
    }
    let rocket = results.networks.iter().find(|n| n.network == "mini-rocket").unwrap();
    assert!(rocket.costs.parameters > 168 && rocket.costs.macs > 0 && rocket.interval.is_some());
    let nearest = key("k-nn", 0);
    assert!(folder.model_path(&nearest).is_file());
    assert!(folder.timing(&nearest).unwrap().unwrap().latency.is_some());
    let again = go(&plain, &dataset, &dir.path().join("b")).unwrap();
    let bytes = |folder: &RunFolder| std::fs::read(folder.file("results.json")).unwrap();
    assert!(bytes(&folder) == bytes(&again));
    // By default all of them are there; an unknown one is named with its line.
    assert_eq!(experiment(&text, &[]).config().baselines.len(), 5);
    let error = parse(&TINY.replace("[]", "[\"knn\"]"), &[]).unwrap_err().to_string();
    assert!(
        error.starts_with(
            "tiny.toml:4:14: no baseline is called `knn`; did you mean `k-nn`? known: majority, "
        ),
        "{error}"
    );
    let error = parse(&TINY.replace("[]", "[\"k-nn\", { name = \"k-nn\", k = 3 }]"), &[]).unwrap_err();
    assert!(error.to_string().starts_with("tiny.toml:4: baselines.1 = \"k-nn\": two rows"), "{error}");
}

#[test]
fn baselines_alone_are_compared_where_no_network_is_named() {
    let sets = ["networks=[]", "baselines=[\"majority\", \"k-nn\"]"];
    let (_keep, folder) = run_tiny(&sets);
    let rows: Vec<String> = folder.results().unwrap().networks.into_iter().map(|row| row.network).collect();
    assert_eq!(rows, ["majority", "k-nn"]);
    let (again, samples) = taxel_trainer::open(&folder, &Registry::built_in()).unwrap();
    assert_eq!(again.config(), experiment(TINY, &sets).config());
    assert_eq!(samples.digest, folder.results().unwrap().data_digest);
}

#[test]
fn classes_can_be_kept_and_look_alikes_are_told_apart() {
    let keep = ["data.classes=[\"shore-20\", \"shore-00\"]", "baselines=[\"k-nn\"]"];
    let (_keep, folder) = run_tiny(&keep);
    let results = folder.results().unwrap();
    assert_eq!(results.task.output_names(), ["shore-20", "shore-00"]);
    assert_eq!(results.samples, 30);
    let alike = "data.look_alikes={ hard = [\"shore-10\", \"shore-20\"], soft = [\"shore-00\"] }";
    let (_keep, folder) = run_tiny(&[alike]);
    let alikes = folder.results().unwrap().networks[0].look_alikes.clone().unwrap();
    assert_eq!(alikes.groups, ["hard", "soft"]);
    let counted: u64 = alikes.confusion.counts().iter().flatten().sum();
    assert_eq!(counted, 45);
    let torn = "data.look_alikes={ hard = [\"shore-10\"] }";
    let error = refusal(&[torn]);
    let want = format!("--set {torn}: data.look_alikes = \"shore-00\": must be in exactly one group");
    assert!(error.starts_with(&want), "{error}");
}

#[test]
fn true_values_of_a_scene_are_learned_and_unseen_ones_tested() {
    let sets = [
        "data.y=shore",
        "data.set={ shore = [0, 20, 40], between = [0, 40], unseen = 0.25 }",
        "protocol={ kind = \"official\" }",
        "baselines=[\"mean\", \"ridge\"]",
        "networks=[]",
    ];
    let (_keep, folder) = run_tiny(&sets);
    let results = folder.results().unwrap();
    let shore = Quantity { name: "shore".into(), unit: Some("Shore A".into()) };
    assert_eq!(results.task, Task::Values(vec![shore]));
    let mae = |row: usize| results.networks[row].mean.as_ref().unwrap().get("mae").unwrap();
    assert!(mae(1) < mae(0), "ridge {} mean {}", mae(1), mae(0));

    let samples = experiment(TINY, &sets).dataset().unwrap();
    let values = samples.targets.values().unwrap().values();
    let is_level = |value: &f32| [0.0, 20.0, 40.0].contains(value);
    let marks = samples.official.as_ref().unwrap();
    assert!(values.iter().zip(marks).all(|(value, is_tested)| is_level(value) != *is_tested), "{values:?}");

    // Levels without a unit, and the values of fresh worlds.
    let two = ["data.scene=gripper", "data.y=hardness_level,stiffness_n_per_mm"];
    let dataset = experiment(TINY, &two).dataset().unwrap();
    assert_eq!(dataset.task().quantities()[0].unit, None);
    assert_eq!(dataset.task().quantities()[1].unit.as_deref(), Some("N/mm"));
    let fresh =
        ["data.y=hold_force_n", "protocol={ kind = \"fresh\", train = 6, test = 3, repetitions = 2 }"];
    assert_eq!(experiment(TINY, &fresh).dataset().unwrap().targets.values().unwrap().values().len(), 18);

    let refused = |sets: &[&str]| experiment(TINY, sets).dataset().unwrap_err().to_string();
    let error = refused(&["data.y=shor"]);
    assert!(
        error.contains("data.y = \"shor\": is no true value of scene fingertip; did you mean `shore`?"),
        "{error}"
    );
    let marked = [fresh[1], "data.set={ between = [0, 40], unseen = 0.5 }"];
    assert!(refused(&marked).contains("say unseen = 0.3333"), "{}", refused(&marked));
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
        let folder = go(&experiment, &experiment.dataset().unwrap(), &dir.path().join(name)).unwrap();
        record(&folder, "vgg6-lite-2d", 0)
    };
    let augment = "train.augment={ flip_rows = true, flip_columns = true, shift = 3.0, rotate = 10.0 }";
    let (plain, moved, again) =
        (go_with("plain", &[]), go_with("moved", &[augment]), go_with("again", &[augment]));
    assert_ne!(plain.epochs[0].train_loss, moved.epochs[0].train_loss);
    assert_eq!(moved.epochs, again.epochs);
    // Without training the test images are the same ones: a rate of almost 0 leaves the same answers.
    let rate = "train.optimizer.lr=1e-30";
    let (unmoved, turned) = (go_with("still", &[rate]), go_with("turned", &[rate, augment]));
    assert_ne!(unmoved.epochs[1].train_loss, turned.epochs[1].train_loss);
    assert_eq!(unmoved.outcome.outputs(), turned.outcome.outputs());
    let set = "encoding={ image = { kind = \"gadf\" } }";
    let error = parse(IMAGES, &[set, augment]).unwrap_err().to_string();
    assert!(error.contains("train.augment") && error.contains("moves pixels"), "{error}");
}

#[test]
fn every_scene_feeds_its_papers_networks() {
    let run = |text: &str, sets: &[&str]| {
        let dir = tempfile::tempdir().unwrap();
        let experiment = experiment(text, sets);
        let dataset = experiment.dataset().unwrap();
        let folder = go(&experiment, &dataset, &dir.path().join("run")).unwrap();
        let results = folder.results().unwrap();
        let key = key(&results.networks[0].network, 0);
        let model = Model::open(&folder.model_path(&key)).unwrap();
        // What was fitted is enough to encode new recordings.
        let predictor = model.predictor(model.card().batch(), 1).unwrap();
        let inputs = predictor.encode(&dataset.x).unwrap();
        assert_eq!(inputs[0].shape()[0], dataset.len());
        let tested = folder.record(&key).unwrap().unwrap();
        let answers = predictor.predict(&dataset.x.select(ndarray::Axis(0), &tested.index)).unwrap();
        assert_eq!(answers.outputs, tested.outcome.outputs());
        (results, inputs[0].shape().to_vec())
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
    assert_eq!((results.task.attributes().len(), results.networks[0].attributes.len()), (2, 2));
    let sets = [
        "data={ scene = \"imprint\", samples = 24, set = { elements = 16 } }",
        "encoding={ image = { kind = \"raw\", red = true, resize = [32, 32] } }",
        "networks=[{ name = \"resnet8-lite-2d\" }]",
    ];
    let (results, shape) = run(IMAGES, &sets);
    assert_eq!(shape, [24, 3, 32, 32]);
    assert_eq!(results.task.output_names().len(), 6);
}

#[test]
fn hardening_puts_every_network_beside_its_clean_twin() {
    let sets = [
        "harden={leave_out=[\"noise\"]}",
        "baselines=[\"majority\",\"mini-rocket\",\"svm-rbf\"]",
        "train.epochs=1",
    ];
    let (_keep, folder) = run_tiny(&sets);
    let rows: Vec<String> =
        folder.results().unwrap().networks.iter().map(|network| network.network.clone()).collect();
    let names = ["mlp", "majority", "mini-rocket", "svm-rbf", "mlp.hardened", "mlp.without-noise"];
    assert_eq!(rows[..6], names);
    let of_baselines =
        ["mini-rocket.hardened", "mini-rocket.without-noise", "svm-rbf.hardened", "svm-rbf.without-noise"];
    assert_eq!(rows[6..], of_baselines);
    // The clean rows are those of the run without the table, byte for byte.
    let (_keep, plain) = run_tiny(&["train.epochs=1"]);
    assert_eq!(model(&plain, 0), model(&folder, 0));
    // What was written is read back as the same experiment.
    let text = std::fs::read_to_string(folder.file("config.toml")).unwrap();
    let again = experiment(&text, &[]);
    assert_eq!(again.config().harden, experiment(TINY, &sets).config().harden);
    // Every kind that has a meaning for series is left out once.
    let each = experiment(TINY, &["harden={leave_each_out=true}"]);
    let dataset = each.dataset().unwrap();
    let registry = Registry::built_in();
    let keys = Runner { experiment: &each, registry: &registry, dataset: &dataset }.keys().unwrap();
    let spared = keys.iter().filter(|key| key.fold == 0 && key.network.contains(".without-")).count();
    assert_eq!(spared, 13);
}

#[test]
fn a_hardened_network_is_fitted_by_its_own_name() {
    let hardened = experiment(TINY, &["harden={}", "train.epochs=1", "networks.0.label=\"a.b\""]);
    let dataset = hardened.dataset().unwrap();
    let registry = Registry::built_in();
    let runner = Runner { experiment: &hardened, registry: &registry, dataset: &dataset };
    let dir = tempfile::tempdir().unwrap();
    let fit = |name: &str| {
        let options = RunOptions { threads: Some(1), ..RunOptions::default() };
        runner.fit(name, &options, Some(&dir.path().join("session")), &Silent, &AtomicBool::new(false))
    };
    let (clean, hardened) = (fit("a.b").unwrap().unwrap(), fit("a.b.hardened").unwrap().unwrap());
    assert_eq!(hardened.card().name, "a.b.hardened");
    assert_ne!(clean.weights(), hardened.weights());
    let error = fit("a.b.without-dead").unwrap_err().to_string();
    assert!(error.contains("is no network or baseline of this experiment"), "{error}");
}

#[test]
fn what_cannot_be_hardened_is_refused_by_its_key() {
    let refused = |set: &str| match parse(TINY, &[set]) {
        Err(error) => error.to_string(),
        Ok(experiment) => panic!("{:?}", experiment.config().harden),
    };
    let error = refused("harden={only=[\"mpl\"]}");
    assert!(error.contains("harden.only.0") && error.contains("mlp"), "{error}");
    let error = refused("harden={faults={probability=0.0,second=0.0}}");
    assert!(error.contains("harden.faults.probability"), "{error}");
    let error = refused("harden={leave_each_out=true,leave_out=[\"noise\"]}");
    assert!(error.contains("harden.leave_each_out"), "{error}");
    let error = refused("train.faults={kinds=[\"nose\"]}");
    assert!(error.contains("train.faults.kinds") && error.contains("noise"), "{error}");
    let error = refusal(&["harden={faults={kinds=[\"shift\"]}}"]);
    assert!(error.contains("faults.kinds = shift"), "{error}");
}

#[test]
fn gates_are_tried_on_every_row_of_a_learning_curve_and_on_repeated_cuts() {
    let tried = |protocol: &str| {
        let sets = [
            "data.samples=240",
            "networks=[]",
            "baselines=[{ name = \"mini-rocket\", features = 84 }]",
            "unknown={ draws = 2 }",
            protocol,
        ];
        let (dir, experiment) = (tempfile::tempdir().unwrap(), experiment(TINY, &sets));
        let (dataset, registry) = (experiment.dataset().unwrap(), Registry::built_in());
        let folder = go(&experiment, &dataset, &dir.path().join("run")).unwrap();
        let trial = experiment.config().unknown.unwrap();
        let runner = Runner { experiment: &experiment, registry: &registry, dataset: &dataset };
        let scores =
            runner.try_unknown(&folder, &trial, 1, &Silent, &AtomicBool::new(false)).unwrap().unwrap();
        scores.into_iter().map(|row| (row.network, row.draws)).collect::<Vec<_>>()
    };
    let curve =
        tried("protocol={ kind = \"few-samples\", per_class = [5, 20], test = 0.3, repetitions = 3 }");
    assert_eq!(
        curve.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["mini-rocket.n5", "mini-rocket.n20"]
    );
    let cuts = tried("protocol={ kind = \"random-splits\", test = 0.3, repetitions = 3 }");
    assert_eq!((cuts.len(), cuts[0].0.as_str()), (1, "mini-rocket"));
    for (name, draws) in curve.iter().chain(&cuts) {
        assert_eq!(draws.len(), 2, "{name}");
        // Three tests of 72 samples; one class of three is left out.
        assert!(draws.iter().all(|draw| (draw.known, draw.unknown) == (144, 72)), "{name}: {draws:?}");
    }
    assert_ne!(curve[0].1, curve[1].1);
    // One test part leaves nothing to fit a gate on.
    assert!(tried("protocol={ kind = \"random-splits\", test = 0.3, repetitions = 1 }").is_empty());
}
