//! Whole runs on tiny data: the folder, equal bytes, resuming, refusals.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../../tests/support/run_folder.rs"]
mod run_folder;

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use run_folder::contents;
use taxel_data::Dataset;
use taxel_engine::{Engine, EngineOptions, Mode};
use taxel_graph::Weights;
use taxel_learn::{FoldKey, Model, Progress, ResultsTable, RunFolder, RunOptions, Silent};
use taxel_trainer::{Error, Experiment, Overrides, Runner, open, run};
use taxel_zoo::Registry;

const TINY: &str = r#"
name = "tiny"
seed = 3
baselines = []

[data]
scene = "fingertip"
samples = 30

[protocol]
folds = 2

[train]
epochs = 3
batch_size = 8

[[networks]]
name = "mlp"
published = { table = "Kaewrakmuk and Srinonchat 2026, Table 5", accuracy = [83.13, 2.39] }

[[networks]]
name = "resnet8-lite-1d"
"#;

fn experiment(sets: &[&str]) -> Experiment {
    let set = sets.iter().map(ToString::to_string).collect();
    let overrides = Overrides { set, ..Overrides::default() };
    Experiment::parse(TINY, "tiny.toml", &overrides, &Registry::built_in()).unwrap()
}

fn options(resume: bool, threads: usize) -> RunOptions {
    RunOptions { resume, threads: Some(threads), save_every: Some(0.0), ..RunOptions::default() }
}

/// Runs to the end, unless something is wrong.
fn go(experiment: &Experiment, out: &Path, options: &RunOptions) -> Result<RunFolder, Error> {
    let cancel = AtomicBool::new(false);
    run(experiment, &Registry::built_in(), Some(out), options, &Silent, &cancel)
}

fn run_tiny(out: &Path, sets: &[&str]) -> Result<RunFolder, Error> {
    go(&experiment(sets), out, &options(false, 1))
}

/// 30 recordings of one channel that are longer than light networks take.
fn long_recordings(dir: &Path) -> std::path::PathBuf {
    let (n, length) = (12usize, 70_000usize);
    let x: Vec<f32> = (0..n * length).map(|i| ((i / length % 3) * 100 + i % 89) as f32).collect();
    let mut npz = taxel_data::Npz::default();
    npz.add("x", &[n, 1, length], &x).unwrap();
    npz.add("y", &[n], &(0..n as u32).map(|i| i % 3).collect::<Vec<_>>()).unwrap();
    let path = dir.join("long.npz");
    std::fs::write(&path, npz.finish().unwrap()).unwrap();
    path
}

#[test]
fn fresh_worlds_share_no_sample() {
    let text = TINY
        .replace("samples = 30", "")
        .replace("folds = 2", "kind = \"fresh\"\ntrain = 12\ntest = 6\nrepetitions = 3");
    let experiment = |set: &[&str]| {
        let set = set.iter().map(ToString::to_string).collect();
        let overrides = Overrides { set, ..Overrides::default() };
        Experiment::parse(&text, "fresh.toml", &overrides, &Registry::built_in()).unwrap()
    };
    let fresh = experiment(&[]);
    let dataset = fresh.dataset().unwrap();
    assert_eq!(dataset.x.shape(), [54, 5, 50]);
    assert_eq!(dataset.group_name.as_deref(), Some("world"));
    let protocol = &fresh.config().protocol;
    for repetition in 0..3 {
        let folds = protocol.folds(&dataset, 3, repetition).unwrap();
        let first = 18 * repetition;
        assert_eq!((folds.len(), &folds[0].train), (1, &(first..first + 12).collect()));
        assert_eq!(folds[0].test, (first + 12..first + 18).collect::<Vec<_>>());
    }
    // Another world is no continuation of the first, and the same command makes the same ones.
    let world =
        |number: usize| dataset.x.slice_axis(ndarray::Axis(0), (18 * number..18 * number + 18).into());
    assert!(world(0) != world(1) && world(1) != world(2));
    assert_eq!(fresh.dataset().unwrap().digest, dataset.digest);
    let dir = tempfile::tempdir().unwrap();
    let folder = go(&fresh, &dir.path().join("run"), &options(false, 1)).unwrap();
    assert_eq!(folder.results().unwrap().networks[0].folds.len(), 3);
    // A learning curve: the smaller training sets lie inside the larger ones, and all are tested alike.
    let curve = experiment(&["protocol.per_class=[1, 3]"]);
    for repetition in 0..3 {
        let folds = curve.config().protocol.folds(&dataset, 3, repetition).unwrap();
        assert_eq!(folds.iter().map(|fold| fold.train.len()).collect::<Vec<_>>(), [3, 9]);
        assert!(folds[0].train.iter().all(|row| folds[1].train.contains(row)));
        let world = 18 * repetition..18 * repetition + 12;
        assert!(folds[1].train.iter().all(|row| world.contains(row)));
        assert!(folds.iter().all(|fold| fold.test == (world.end..world.end + 6).collect::<Vec<_>>()));
    }
    let folder = go(&curve, &dir.path().join("curve"), &options(false, 1)).unwrap();
    let rows: Vec<(Option<usize>, usize)> =
        folder.results().unwrap().networks.iter().map(|row| (row.per_class, row.folds.len())).collect();
    assert_eq!(rows[..2], [(Some(1), 3), (Some(3), 3)]);
    let error =
        experiment(&["protocol.per_class=[1, 30]"]).config().protocol.folds(&dataset, 3, 0).unwrap_err();
    assert!(error.to_string().contains("30"), "{error}");
    let path = long_recordings(dir.path());
    let of_path = text.replace("scene = \"fingertip\"", &format!("path = {path:?}"));
    let of_path =
        Experiment::parse(&of_path, "t.toml", &Overrides::default(), &Registry::built_in()).unwrap();
    let error = of_path.dataset().unwrap_err().to_string();
    assert!(error.contains("simulates a new world for each repetition"), "{error}");
}

#[test]
fn a_network_that_takes_no_such_samples_is_left_out_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = long_recordings(dir.path());
    let text = TINY.replace("scene = \"fingertip\"\nsamples = 30", &format!("path = {path:?}"));
    let load = |text: &str, set: &[&str]| {
        let overrides =
            Overrides { set: set.iter().map(ToString::to_string).collect(), ..Overrides::default() };
        Experiment::parse(text, "tiny.toml", &overrides, &Registry::built_in()).unwrap()
    };
    let wanted = "length = 70000: must be in 1..=65536; shorten the recordings: data.length = \
                  { kind = \"resample\", to = 1000 }";
    let sets = ["networks.0.set={ hidden = 2 }", "train.epochs=1"];
    let folder = go(&load(&text, &sets), &dir.path().join("run"), &options(false, 1)).unwrap();
    let results = folder.results().unwrap();
    assert_eq!((results.networks.len(), results.complete), (1, true));
    assert_eq!(results.left_out.get("resnet8-lite-1d").map(String::as_str), Some(wanted));
    let table = ResultsTable::of(&folder).unwrap().to_string();
    assert!(table.contains(&format!("left out: resnet8-lite-1d: {wanted}")), "{table}");
    // Where none is left there is nothing to run.
    let one = text.replace("name = \"mlp\"", "name = \"resnet8-lite-1d\"\nlabel = \"one\"");
    let error = go(&load(&one, &[]), &dir.path().join("none"), &options(false, 1)).unwrap_err().to_string();
    assert_eq!(error, format!("one: {wanted}"));
    assert!(!dir.path().join("none").exists());
}

fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (contents(a), contents(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(b[name] == *bytes, "{} differs", name.display());
    }
}

/// Sets `cancel` in the middle of the fold after `folds` whole ones.
struct StopAfter<'a> {
    folds: usize,
    begun: AtomicUsize,
    cancel: &'a AtomicBool,
}

impl Progress for StopAfter<'_> {
    fn start(&self, _work: u64) {}
    fn fold(&self, _key: &FoldKey, _number: usize, _total: usize) {
        self.begun.fetch_add(1, Ordering::Relaxed);
    }
    fn step(&self, _work: u64) {
        self.cancel.store(self.begun.load(Ordering::Relaxed) > self.folds, Ordering::Relaxed);
    }
    fn finish(&self) {}
}

#[test]
fn a_run_folder_holds_what_it_promises() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("a/run");
    let folder = run_tiny(&out, &[]).unwrap();
    let results = folder.results().unwrap();
    assert!(results.complete && results.missing.is_empty());
    assert_eq!((results.source.to_string().as_str(), results.samples), ("simulated: fingertip", 30));
    assert_eq!(results.networks[0].costs.parameters, 32_515);
    for network in &results.networks {
        assert_eq!(network.folds.len(), 2);
        let tested: u64 = network.confusion.as_ref().unwrap().counts().iter().flatten().sum();
        assert_eq!(tested, 30);
        let accuracies: Vec<f64> = network.folds.iter().map(|f| f.scores.get("accuracy").unwrap()).collect();
        let mean = network.score("accuracy").unwrap();
        assert!((mean - (accuracies[0] + accuracies[1]) / 2.0).abs() <= 1e-9);
    }
    let lines = |name: &str| -> Vec<serde_json::Value> {
        let text = std::fs::read_to_string(folder.file(name)).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let metrics = lines("metrics.jsonl");
    assert_eq!(metrics.len(), 2 * 2 * 3);
    assert!(metrics[2]["test_f1"].is_f64() && metrics[1].get("test_f1").is_none());
    let timings = lines("timings.jsonl");
    assert_eq!(timings.iter().filter(|t| t.get("train_seconds").is_some()).count(), 4);
    assert_eq!(timings.iter().filter(|t| t.get("latency_p50_ms").is_some()).count(), 2);
    let environment = std::fs::read_to_string(folder.file("environment.json")).unwrap();
    assert!(environment.contains(&results.data_digest), "{environment}");
    // What two equal runs share says nothing about this machine.
    for (name, bytes) in contents(&out) {
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains(dir.path().to_str().unwrap()), "{}", name.display());
    }
    let table = ResultsTable::of(&folder).unwrap();
    let text = table.to_string();
    assert!(text.contains("measured on: simulated: fingertip"), "{text}");
    assert!(text.contains("published (Kaewrakmuk and Srinonchat 2026, own data)"), "{text}");
    assert!(text.lines().any(|l| l.starts_with("mlp") && l.ends_with("83.13 ± 2.39")), "{text}");
    assert!(text.lines().any(|l| l.starts_with("resnet8-lite-1d") && l.ends_with("-")), "{text}");
    assert!(table.markdown().contains("| mlp | 32,515 | 32,384 |"), "{}", table.markdown());
    assert_eq!(
        table.json()["networks"][0]["measured"]["mean"]["accuracy"],
        results.networks[0].score("accuracy").unwrap()
    );
    // The resolved config runs again, to the same bytes.
    let again = dir.path().join("again");
    let (experiment, dataset) = open(&folder, &Registry::built_in()).unwrap();
    assert_eq!(dataset.digest, results.data_digest);
    go(&experiment, &again, &options(false, 1)).unwrap();
    assert_same(&out, &again);
}

#[test]
fn predictions_are_readable_arrays() {
    let dir = tempfile::tempdir().unwrap();
    let folder = run_tiny(&dir.path().join("run"), &[]).unwrap();
    let mut npz = npyz::npz::NpzArchive::open(folder.file("predictions.npz")).unwrap();
    // Bytes must not depend on the clock.
    let stamp = npz.zip_archive().by_index(0).unwrap().last_modified();
    assert_eq!((stamp.year(), stamp.second()), (1980, 0));
    let mut ints = |name: &str| -> Vec<u32> { npz.by_name(name).unwrap().unwrap().into_vec().unwrap() };
    let mut index = ints("mlp.index");
    let (truth, predicted) = (ints("mlp.true"), ints("mlp.predicted"));
    assert_eq!(ints("mlp.fold").iter().filter(|f| **f == 1).count(), 15);
    assert!(ints("mlp.repetition").iter().all(|r| *r == 0));
    let right = truth.iter().zip(&predicted).filter(|(a, b)| a == b).count();
    let results = folder.results().unwrap();
    assert_eq!(100.0 * right as f64 / 30.0, results.networks[0].score("accuracy").unwrap());
    index.sort_unstable();
    assert_eq!(index, (0..30).collect::<Vec<u32>>());
    let probabilities = npz.by_name("mlp.probabilities").unwrap().unwrap();
    assert_eq!(probabilities.shape(), [30, 3]);
    for row in probabilities.into_vec::<f32>().unwrap().chunks(3) {
        assert!((row.iter().sum::<f32>() - 1.0).abs() <= 1e-5, "{row:?}");
    }
}

/// A model file is enough to build the network by hand.
#[test]
fn models_rebuild_the_network_that_was_tested() {
    let dir = tempfile::tempdir().unwrap();
    let folder = run_tiny(&dir.path().join("run"), &[]).unwrap();
    let key = FoldKey { network: "resnet8-lite-1d".into(), repetition: 0, fold: 1 };
    let model = Model::open(&folder.model_path(&key)).unwrap();
    let card = model.card();
    assert_eq!(card.task.attributes()[0].classes, ["shore-00", "shore-10", "shore-20"]);
    let (_, dataset) = open(&folder, &Registry::built_in()).unwrap();
    let input = &card.inputs[0];
    assert_eq!(input.name, "signal");
    let encoded = input.transform.apply(&dataset.x, "tiny").unwrap();
    let record = folder.record(&key).unwrap().unwrap();
    let mut engine = engine(&model, 1);
    for (i, &row) in record.index.iter().enumerate() {
        let x: Vec<f32> = encoded.index_axis(ndarray::Axis(0), row).iter().copied().collect();
        let mut logits = engine.forward(&[&x], 1, Mode::Eval).unwrap().to_vec();
        taxel_learn::metrics::softmax(&mut logits, 3);
        for (got, want) in logits.iter().zip(&record.outcome.outputs()[3 * i..]) {
            assert!((got - want).abs() <= 1e-5, "sample {row}: {logits:?}");
        }
    }
}

fn engine(model: &Model, batch: usize) -> Engine {
    let options = EngineOptions { batch, threads: 1, ..EngineOptions::default() };
    Engine::new(model.card().graph().unwrap(), model.weights(), options).unwrap()
}

/// Largest gap between the logits of the training set in training and in evaluation.
fn train_eval_gap(folder: &RunFolder) -> f32 {
    let key = FoldKey { network: "resnet8-lite-1d".into(), repetition: 0, fold: 0 };
    let model = Model::open(&folder.model_path(&key)).unwrap();
    let (experiment, dataset) = open(folder, &Registry::built_in()).unwrap();
    let config = experiment.config();
    let train = &config.protocol.folds(&dataset, config.seed, 0).unwrap()[0].train;
    let encoded = model.card().inputs[0].transform.apply(&dataset.x, "tiny").unwrap();
    let x: Vec<f32> = encoded.select(ndarray::Axis(0), train).iter().copied().collect();
    let mut engine = engine(&model, train.len());
    let mut logits = |mode| engine.forward(&[&x], train.len(), mode).unwrap().to_vec();
    let (eval, train) = (logits(Mode::Eval), logits(Mode::Train));
    eval.iter().zip(&train).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn population_statistics_are_those_of_the_training_set() {
    let dir = tempfile::tempdir().unwrap();
    // With the training set in one batch, its statistics are the batch's.
    let whole = "train.batch_size=64";
    let population = run_tiny(&dir.path().join("population"), &[whole]).unwrap();
    let moving = run_tiny(&dir.path().join("moving"), &[whole, "train.batch_norm=moving"]).unwrap();
    let gap = train_eval_gap(&population);
    // Not exact: which of the two variances (n, n - 1) is stored.
    assert!(gap <= 0.02, "{gap}");
    let gap = train_eval_gap(&moving);
    assert!(gap > 0.1, "{gap}");
}

#[test]
fn the_other_statistics_are_those_that_the_other_setting_tests_with() {
    let dir = tempfile::tempdir().unwrap();
    let of = |kind: &str| {
        let set = format!("train.batch_norm={kind}");
        let folder = run_tiny(&dir.path().join(kind), &[&set, "train.epochs=1"]).unwrap();
        let words = ResultsTable::of(&folder).unwrap().to_string();
        (folder.results().unwrap().networks, words)
    };
    let ((population, words), (moving, _)) = (of("population"), of("moving"));
    assert!(population[0].other_statistics.is_none(), "an MLP has no batch norm");
    for (result, other, name) in
        [(&population[1], &moving[1], "moving"), (&moving[1], &population[1], "population")]
    {
        let seen = result.other_statistics.unwrap();
        assert_eq!(seen.batch_norm.name(), name);
        assert!((seen.score - other.score("accuracy").unwrap()).abs() < 1e-9);
        let losses: Vec<f64> = other.folds.iter().map(|fold| fold.test_loss).collect();
        assert_eq!(seen.test_loss, losses.iter().sum::<f64>() / losses.len() as f64);
    }
    let losses = [&population[1], &moving[1]].map(|n| n.other_statistics.unwrap().test_loss);
    assert_ne!(losses[0], losses[1], "else nothing was compared");
    assert!(words.contains("accuracy with moving batch-norm statistics: resnet8-lite-1d "), "{words}");

    let stopped = ["train.early_stopping.patience=2"];
    let folder = run_tiny(&dir.path().join("stopped"), &stopped).unwrap();
    assert!(folder.results().unwrap().networks[1].other_statistics.is_none());
}

#[test]
fn every_sample_of_every_epoch_is_a_piece_of_the_work_announced() {
    #[derive(Default)]
    struct Count(AtomicU64, AtomicU64);
    impl Progress for Count {
        fn start(&self, work: u64) {
            self.0.store(work, Ordering::Relaxed);
        }
        fn fold(&self, _key: &FoldKey, _number: usize, _total: usize) {}
        fn step(&self, work: u64) {
            self.1.fetch_add(work, Ordering::Relaxed);
        }
        fn finish(&self) {}
    }
    let dir = tempfile::tempdir().unwrap();
    let count = Count::default();
    // 15 training samples in batches of 8: the rest of 7 is a step too.
    let (registry, out) = (Registry::built_in(), dir.path().join("run"));
    let cancel = AtomicBool::new(false);
    run(&experiment(&[]), &registry, Some(&out), &options(false, 1), &count, &cancel).unwrap();
    assert!(count.0.load(Ordering::Relaxed) > 0);
    assert_eq!(count.0.into_inner(), count.1.into_inner());
}

#[test]
fn equal_runs_write_equal_bytes_whatever_the_threads() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b, c) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("c"));
    run_tiny(&a, &[]).unwrap();
    go(&experiment(&[]), &b, &options(false, 2)).unwrap();
    assert_same(&a, &b);
    run_tiny(&c, &["seed=4"]).unwrap();
    assert_ne!(contents(&a)[Path::new("results.json")], contents(&c)[Path::new("results.json")]);
}

#[test]
fn a_network_scores_the_same_in_other_company() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b) = (dir.path().join("a"), dir.path().join("b"));
    run_tiny(&a, &[]).unwrap();
    run_tiny(&b, &["networks=[{ name = \"resnet8-lite-1d\" }]"]).unwrap();
    let file = Path::new("models/resnet8-lite-1d.r0.f1.safetensors");
    assert!(contents(&a)[file] == contents(&b)[file]);
}

#[test]
fn a_stopped_run_is_readable_and_resumes_to_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let (whole, parts) = (dir.path().join("whole"), dir.path().join("parts"));
    run_tiny(&whole, &[]).unwrap();
    for folds in [1, 2] {
        let cancel = AtomicBool::new(false);
        // One more fold each time.
        let stop = StopAfter { folds: 1, begun: AtomicUsize::new(0), cancel: &cancel };
        let registry = Registry::built_in();
        let error = run(&experiment(&[]), &registry, Some(&parts), &options(folds > 1, 1), &stop, &cancel)
            .unwrap_err();
        let Error::Learn(taxel_learn::Error::Cancelled { done, total: 4, ref folder }) = error else {
            panic!("{error}");
        };
        assert_eq!((done, folder.as_str()), (folds, parts.to_str().unwrap()));
        let results = RunFolder::open(&parts).unwrap().results().unwrap();
        assert!(!results.complete);
        assert_eq!(results.missing.len(), 4 - folds);
        let text = ResultsTable::of(&RunFolder::open(&parts).unwrap()).unwrap().to_string();
        assert!(text.contains("INCOMPLETE"), "{text}");
    }
    // What a kill in the middle of a write leaves behind.
    std::fs::write(parts.join("results.json.part"), "{").unwrap();
    std::fs::write(parts.join(".lock"), "4294967295").unwrap();
    go(&experiment(&[]), &parts, &options(true, 1)).unwrap();
    assert_same(&whole, &parts);
}

#[test]
fn a_folder_is_not_overwritten_and_not_mixed() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    run_tiny(&out, &[]).unwrap();
    let before = contents(&out);
    let error = run_tiny(&out, &[]).unwrap_err().to_string();
    let want = format!("{}: exists and is not empty; resume its run or give another folder", out.display());
    assert_eq!(error, want);
    let resume = |sets: &[&str]| go(&experiment(sets), &out, &options(true, 1)).unwrap_err().to_string();
    let error = resume(&["train.epochs=4"]);
    assert!(error.contains("train.epochs was 3, is now 4"), "{error}");
    let error = resume(&["networks.1.train={ epochs = 9 }"]);
    assert!(error.contains("networks.1.train.epochs was 3, is now 9"), "{error}");
    let error = resume(&["networks.1.label=other"]);
    assert!(error.contains("networks.1.label was \"resnet8-lite-1d\", is now \"other\""), "{error}");
    let error = resume(&["train.clip=1.0"]);
    assert!(error.contains("networks.0.train.clip was not set, is now 1.0"), "{error}");
    let held = std::fs::File::options().write(true).open(out.join(".lock")).unwrap();
    held.lock().unwrap();
    let error = resume(&[]);
    assert!(error.contains(&format!("process {}", std::process::id())), "{error}");
    drop(held);
    assert_eq!(contents(&out), before);
    let empty = dir.path().join("notes");
    std::fs::create_dir(&empty).unwrap();
    std::fs::write(empty.join("notes.txt"), "mine").unwrap();
    let error = go(&experiment(&[]), &empty, &options(true, 1));
    assert!(error.unwrap_err().to_string().contains("no config.toml"));
    assert_eq!(std::fs::read_dir(&empty).unwrap().count(), 1);
}

/// Files that a kill before the first file leaves behind.
#[test]
fn a_bare_folder_counts_as_empty() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    std::fs::create_dir_all(out.join("folds")).unwrap();
    std::fs::create_dir_all(out.join("models")).unwrap();
    std::fs::write(out.join("config.toml.part"), "name").unwrap();
    go(&experiment(&[]), &out, &options(true, 1)).unwrap();
    assert!(!out.join("config.toml.part").exists());
}

#[test]
fn resuming_on_other_data_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let (experiment, registry) = (experiment(&[]), Registry::built_in());
    let mut dataset = experiment.dataset().unwrap();
    let go = |dataset: &Dataset, resume| {
        let runner = Runner { experiment: &experiment, registry: &registry, dataset };
        runner.run(Some(&out), &options(resume, 1), &Silent, &AtomicBool::new(false))
    };
    go(&dataset, false).unwrap();
    go(&dataset, true).unwrap();
    dataset.digest = "0".repeat(64);
    let error = go(&dataset, true).unwrap_err().to_string();
    assert!(error.contains("was run on other data"), "{error}");
}

#[test]
fn a_loss_that_is_not_finite_says_where() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let error = run_tiny(&out, &["train.optimizer.lr=1e30"]).unwrap_err().to_string();
    assert!(error.contains("\nmlp, repetition 0, fold 0: the loss is "), "{error}");
    assert!(error.contains("in epoch 0, batch 1") && error.contains("train.optimizer.lr"), "{error}");
    assert_eq!(RunFolder::open(&out).unwrap().results().unwrap().missing.len(), 4);
}

#[test]
fn a_network_without_its_input_is_refused_before_a_folder_is_made() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let error = run_tiny(&out, &["networks=[{ name = \"vgg6-lite-2d\" }]"]).unwrap_err().to_string();
    assert!(error.contains("vgg6-lite-2d reads `image`"), "{error}");
    assert!(!out.exists());
}

/// A run that starts from another's model: frozen layers stay as they were, a head for other classes is made
/// anew and said so, and what does not fit is refused before anything is trained.
#[test]
fn starting_from_a_checkpoint() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    run_tiny(&at("first"), &[]).unwrap();
    let model = std::fs::read_dir(at("first/models")).unwrap().map(|e| e.unwrap().path());
    let model = model.filter(|p| p.to_str().unwrap().contains("resnet8")).min().unwrap();
    let read = |path: &Path| -> Weights { taxel_checkpoint::read(path).unwrap().0 };
    let before = read(&model);
    let parse = |text: &str, file: &str| {
        Experiment::parse(text, file, &Overrides::default(), &Registry::built_in()).unwrap()
    };
    let config = |path: &Path, more: &str| {
        let second = TINY.replace(
            "name = \"resnet8-lite-1d\"",
            &format!("name = \"resnet8-lite-1d\"\nweights = {:?}\n{more}", path.to_str().unwrap()),
        );
        let second = second.replace("[[networks]]\nname = \"mlp\"\npublished = { table = \"Kaewrakmuk and Srinonchat 2026, Table 5\", accuracy = [83.13, 2.39] }\n", "");
        parse(&second, "second.toml")
    };
    let go = |experiment: &Experiment, out: &str| go(experiment, &at(out), &options(false, 1));

    let names: Vec<String> = before.iter().map(|(name, _)| name.to_string()).collect();
    // A convolution.
    let frozen = names.iter().find(|name| before.get(name).unwrap().shape.len() == 3).unwrap().clone();
    let stem = frozen.rsplit_once('.').unwrap().0.to_string();
    let experiment = config(&model, &format!("train.frozen = [{stem:?}]"));
    go(&experiment, "second").unwrap();
    let tuned = std::fs::read_dir(at("second/models")).unwrap().next().unwrap().unwrap().path();
    let after = read(&tuned);
    assert_eq!(before.get(&frozen), after.get(&frozen), "{stem} is frozen");
    let moved = |name: &&String| before.get(name) != after.get(name);
    assert!(names.iter().filter(moved).count() > names.len() / 2, "the rest is tuned");
    let results: serde_json::Value =
        serde_json::from_slice(&std::fs::read(at("second/results.json")).unwrap()).unwrap();
    assert!(results["networks"][0].get("drawn").is_none());
    // What training changed: nothing in the frozen convolution, something in every other, averaged over folds.
    let changes = results["networks"][0]["changes"].as_array().unwrap();
    let unchanged = changes.iter().filter(|change| change["change"] == 0.0).count();
    assert!(changes.len() > 3 && unchanged == 1, "{changes:?}");
    for change in changes {
        let moved = change["change"].as_f64().unwrap();
        assert_eq!(moved == 0.0, change["layer"] == stem.as_str(), "{change}");
        let of_folds = [0, 1].map(|fold| {
            let record = at(&format!("second/folds/resnet8-lite-1d.r0.f{fold}.json"));
            let record: serde_json::Value = serde_json::from_slice(&std::fs::read(record).unwrap()).unwrap();
            let changes = record["changes"].as_array().unwrap();
            changes.iter().find(|c| c["layer"] == change["layer"]).unwrap()["change"].as_f64().unwrap()
        });
        assert!((of_folds[0] + of_folds[1] - 2.0 * moved).abs() < 1e-15, "{of_folds:?} {change}");
    }

    // Four classes instead of three.
    let four = "scene = \"fingertip\"\nset = { shore = [0, 10, 20, 30] }";
    let more = config(&model, "").to_toml().replace("scene = \"fingertip\"", four);
    let experiment = parse(&more, "four.toml");
    go(&experiment, "four").unwrap();
    let results: serde_json::Value =
        serde_json::from_slice(&std::fs::read(at("four/results.json")).unwrap()).unwrap();
    let anew = results["networks"][0]["drawn"].as_array().unwrap();
    assert_eq!(anew.len(), 2, "weight and bias of the head: {anew:?}");

    let message = |path: &Path| go(&config(path, ""), "never").unwrap_err().to_string();
    let text = message(&at("none.safetensors"));
    assert!(text.starts_with("second.toml:20: networks.0.weights = "), "{text}");
    let mlp = std::fs::read_dir(at("first/models")).unwrap().map(|e| e.unwrap().path());
    let mlp = mlp.filter(|p| p.to_str().unwrap().contains("mlp")).min().unwrap();
    assert!(message(&mlp).contains("networks.0.weights"), "{}", message(&mlp));
    assert!(!at("never").exists(), "nothing was begun");
}

#[test]
fn folds_that_began_with_other_weights_are_not_mixed() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    run_tiny(&at("first"), &[]).unwrap();
    let models = |fold: usize| at(&format!("first/models/resnet8-lite-1d.r0.f{fold}.safetensors"));
    let start = at("start.safetensors");
    std::fs::copy(models(0), &start).unwrap();
    let weights =
        format!("networks=[{{ name = \"resnet8-lite-1d\", weights = {:?} }}]", start.to_str().unwrap());
    let experiment = experiment(&[&weights]);
    go(&experiment, &at("second"), &options(false, 1)).unwrap();
    std::fs::remove_file(at("second/folds/resnet8-lite-1d.r0.f1.json")).unwrap();
    // The config still names this file.
    std::fs::copy(models(1), &start).unwrap();
    let error = go(&experiment, &at("second"), &options(true, 1)).unwrap_err().to_string();
    assert!(error.contains("resnet8-lite-1d.r0.f0.json") && error.contains("other weights"), "{error}");
    std::fs::copy(models(0), &start).unwrap();
    go(&experiment, &at("second"), &options(true, 1)).unwrap();
}
