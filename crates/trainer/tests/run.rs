//! Whole runs on tiny data: the folder, equal bytes, resuming, refusals.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../../tests/support/run_folder.rs"]
mod run_folder;

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use run_folder::contents;
use taxel_trainer::{
    Error, Experiment, FoldKey, Overrides, Progress, RunFolder, RunOptions, Samples, Silent, Table,
    read_checkpoint, run,
};

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
published = { table = "paper 000, Table 5", accuracy = [83.13, 2.39] }

[[networks]]
name = "resnet8-lite-1d"
"#;

fn experiment(sets: &[&str]) -> Experiment {
    let set = sets.iter().map(ToString::to_string).collect();
    Experiment::parse(TINY, "tiny.toml", &Overrides { set, ..Overrides::default() }).unwrap()
}

fn options(out: &Path, resume: bool, threads: usize) -> RunOptions {
    RunOptions { out: Some(out.into()), resume, threads: Some(threads), save_every: Some(0.0) }
}

fn run_tiny(out: &Path, sets: &[&str]) -> Result<RunFolder, Error> {
    run(&experiment(sets), &options(out, false, 1), &Silent, &AtomicBool::new(false))
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
    assert_eq!((results.source.as_str(), results.samples), ("simulated: fingertip", 30));
    assert_eq!(results.networks[0].costs.parameters, 32_515);
    for network in &results.networks {
        assert_eq!(network.folds.len(), 2);
        let tested: u64 = network.confusion.as_ref().unwrap().counts().iter().flatten().sum();
        assert_eq!(tested, 30);
        let accuracies: Vec<f64> = network.folds.iter().map(|f| f.scores.accuracy).collect();
        let mean = network.mean.unwrap().accuracy;
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
    let table = Table::of(&folder).unwrap();
    let text = table.to_string();
    assert!(text.contains("measured on: simulated: fingertip"), "{text}");
    assert!(text.contains("published (paper 000, own data)"), "{text}");
    assert!(text.lines().any(|l| l.starts_with("mlp") && l.ends_with("83.13 ± 2.39")), "{text}");
    assert!(text.lines().any(|l| l.starts_with("resnet8-lite-1d") && l.ends_with("-")), "{text}");
    assert!(table.markdown().contains("| mlp | 32,515 | 32,384 |"), "{}", table.markdown());
    assert_eq!(
        table.json()["networks"][0]["measured"]["mean"]["accuracy"],
        results.networks[0].mean.unwrap().accuracy
    );
    // The resolved config runs again, to the same bytes.
    let again = dir.path().join("again");
    run(&folder.experiment().unwrap(), &options(&again, false, 1), &Silent, &AtomicBool::new(false)).unwrap();
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
    assert_eq!(100.0 * right as f64 / 30.0, results.networks[0].mean.unwrap().accuracy);
    index.sort_unstable();
    assert_eq!(index, (0..30).collect::<Vec<u32>>());
    let probabilities = npz.by_name("mlp.probabilities").unwrap().unwrap();
    assert_eq!(probabilities.shape(), [30, 3]);
    for row in probabilities.into_vec::<f32>().unwrap().chunks(3) {
        assert!((row.iter().sum::<f32>() - 1.0).abs() <= 1e-5, "{row:?}");
    }
}

#[test]
fn checkpoints_rebuild_the_network_that_was_tested() {
    let dir = tempfile::tempdir().unwrap();
    let folder = run_tiny(&dir.path().join("run"), &[]).unwrap();
    let key = FoldKey { network: "resnet8-lite-1d".into(), repetition: 0, fold: 1 };
    let (weights, metadata) = read_checkpoint(&folder.model_path(&key)).unwrap();
    assert_eq!(metadata.classes, ["shore-00", "shore-10", "shore-20"]);
    let samples = Samples::load(&folder.experiment().unwrap()).unwrap();
    let (name, transform) = &metadata.inputs[0];
    assert_eq!(name, "signal");
    let encoded = transform.apply(&samples.x, &samples.source).unwrap();
    let record = folder.record(&key).unwrap().unwrap();
    let options = taxel_engine::Options { batch: 1, threads: 1, ..taxel_engine::Options::default() };
    let mut engine = taxel_engine::Engine::new(&metadata.graph().unwrap(), &weights, options).unwrap();
    for (i, &row) in record.index.iter().enumerate() {
        let x: Vec<f32> = encoded.index_axis(ndarray::Axis(0), row).iter().copied().collect();
        let mut logits = engine.forward(&[&x], 1, taxel_engine::Mode::Eval).unwrap().to_vec();
        taxel_trainer::metrics::softmax(&mut logits, 3);
        for (got, want) in logits.iter().zip(&record.probabilities[3 * i..]) {
            assert!((got - want).abs() <= 1e-5, "sample {row}: {logits:?}");
        }
    }
}

/// Largest gap between the logits of the training set in training and in evaluation.
fn train_eval_gap(folder: &RunFolder) -> f32 {
    let key = FoldKey { network: "resnet8-lite-1d".into(), repetition: 0, fold: 0 };
    let (weights, metadata) = read_checkpoint(&folder.model_path(&key)).unwrap();
    let experiment = folder.experiment().unwrap();
    let samples = Samples::load(&experiment).unwrap();
    let train = &samples.folds(&experiment, 0).unwrap()[0].train;
    let encoded = metadata.inputs[0].1.apply(&samples.x, &samples.source).unwrap();
    let x: Vec<f32> = encoded.select(ndarray::Axis(0), train).iter().copied().collect();
    let options =
        taxel_engine::Options { batch: train.len(), threads: 1, ..taxel_engine::Options::default() };
    let mut engine = taxel_engine::Engine::new(&metadata.graph().unwrap(), &weights, options).unwrap();
    let mut logits = |mode| engine.forward(&[&x], train.len(), mode).unwrap().to_vec();
    let (eval, train) = (logits(taxel_engine::Mode::Eval), logits(taxel_engine::Mode::Train));
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
        let words = Table::of(&folder).unwrap().to_string();
        (folder.results().unwrap().networks, words)
    };
    let ((population, words), (moving, _)) = (of("population"), of("moving"));
    assert!(population[0].other_statistics.is_none(), "an MLP has no batch norm");
    for (own, other, name) in
        [(&population[1], &moving[1], "moving"), (&moving[1], &population[1], "population")]
    {
        let seen = own.other_statistics.unwrap();
        assert_eq!(seen.batch_norm.name(), name);
        assert!((seen.accuracy - other.mean.unwrap().accuracy).abs() < 1e-9);
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
    let options = options(&dir.path().join("run"), false, 1);
    run(&experiment(&[]), &options, &count, &AtomicBool::new(false)).unwrap();
    assert!(count.0.load(Ordering::Relaxed) > 0);
    assert_eq!(count.0.into_inner(), count.1.into_inner());
}

#[test]
fn equal_runs_write_equal_bytes_whatever_the_threads() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b, c) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("c"));
    run_tiny(&a, &[]).unwrap();
    run(&experiment(&[]), &options(&b, false, 2), &Silent, &AtomicBool::new(false)).unwrap();
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
        let error = run(&experiment(&[]), &options(&parts, folds > 1, 1), &stop, &cancel).unwrap_err();
        assert!(matches!(error, Error::Cancelled { done, total: 4, .. } if done == folds), "{error}");
        assert!(error.to_string().contains("--resume"), "{error}");
        let results = RunFolder::open(&parts).unwrap().results().unwrap();
        assert!(!results.complete);
        assert_eq!(results.missing.len(), 4 - folds);
        let text = Table::of(&RunFolder::open(&parts).unwrap()).unwrap().to_string();
        assert!(text.contains("INCOMPLETE"), "{text}");
    }
    // What a kill in the middle of a write leaves behind.
    std::fs::write(parts.join("results.json.part"), "{").unwrap();
    std::fs::write(parts.join(".lock"), "4294967295").unwrap();
    run(&experiment(&[]), &options(&parts, true, 1), &Silent, &AtomicBool::new(false)).unwrap();
    assert_same(&whole, &parts);
}

#[test]
fn a_folder_is_not_overwritten_and_not_mixed() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    run_tiny(&out, &[]).unwrap();
    let before = contents(&out);
    let error = run_tiny(&out, &[]).unwrap_err().to_string();
    assert!(error.contains("--resume") && error.contains("--out"), "{error}");
    let resume = |sets: &[&str]| {
        let cancel = AtomicBool::new(false);
        run(&experiment(sets), &options(&out, true, 1), &Silent, &cancel).unwrap_err().to_string()
    };
    let error = resume(&["train.epochs=4"]);
    assert!(error.contains("train.epochs was 3, is now 4"), "{error}");
    let error = resume(&["networks.1.train={ epochs = 9 }"]);
    assert!(error.contains("networks.1.train was not set, is now { epochs = 9 }"), "{error}");
    let held = std::fs::File::options().write(true).open(out.join(".lock")).unwrap();
    held.lock().unwrap();
    let error = resume(&[]);
    assert!(error.contains(&format!("process {}", std::process::id())), "{error}");
    drop(held);
    assert_eq!(contents(&out), before);
    let empty = dir.path().join("notes");
    std::fs::create_dir(&empty).unwrap();
    std::fs::write(empty.join("notes.txt"), "mine").unwrap();
    let error = run(&experiment(&[]), &options(&empty, true, 1), &Silent, &AtomicBool::new(false));
    assert!(error.unwrap_err().to_string().contains("no config.toml"));
    assert_eq!(std::fs::read_dir(&empty).unwrap().count(), 1);
}

/// What a kill before the first file leaves behind.
#[test]
fn a_bare_folder_counts_as_empty() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    std::fs::create_dir_all(out.join("folds")).unwrap();
    std::fs::create_dir_all(out.join("models")).unwrap();
    std::fs::write(out.join("config.toml.part"), "name").unwrap();
    run(&experiment(&[]), &options(&out, true, 1), &Silent, &AtomicBool::new(false)).unwrap();
    assert!(!out.join("config.toml.part").exists());
}

#[test]
fn resuming_on_other_data_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let experiment = experiment(&[]);
    let mut samples = Samples::load(&experiment).unwrap();
    let go = |samples: &Samples, resume| {
        let options = options(&out, resume, 1);
        taxel_trainer::run_on(&experiment, samples, &options, &Silent, &AtomicBool::new(false))
    };
    go(&samples, false).unwrap();
    go(&samples, true).unwrap();
    samples.digest = "0".repeat(64);
    let error = go(&samples, true).unwrap_err().to_string();
    assert!(error.contains("was run on other data"), "{error}");
}

#[test]
fn a_loss_that_is_not_finite_says_where() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let error = run_tiny(&out, &["train.optimizer.lr=1e30"]).unwrap_err().to_string();
    assert!(error.starts_with("mlp, repetition 0, fold 0: the loss is "), "{error}");
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
    let (before, _) = taxel_checkpoint::read(&model).unwrap();
    let config = |path: &Path, more: &str| {
        let second = TINY.replace(
            "name = \"resnet8-lite-1d\"",
            &format!("name = \"resnet8-lite-1d\"\nweights = {:?}\n{more}", path.to_str().unwrap()),
        );
        let second = second.replace("[[networks]]\nname = \"mlp\"\npublished = { table = \"paper 000, Table 5\", accuracy = [83.13, 2.39] }\n", "");
        Experiment::parse(&second, "second.toml", &Overrides::default()).unwrap()
    };
    let go = |experiment: &Experiment, out: &str| {
        run(experiment, &options(&at(out), false, 1), &Silent, &AtomicBool::new(false))
    };

    let names: Vec<String> = before.iter().map(|(name, _)| name.to_string()).collect();
    // A convolution.
    let frozen = names.iter().find(|name| before.get(name).unwrap().shape.len() == 3).unwrap().clone();
    let stem = frozen.rsplit_once('.').unwrap().0.to_string();
    let experiment = config(&model, &format!("train.frozen = [{stem:?}]"));
    go(&experiment, "second").unwrap();
    let tuned = std::fs::read_dir(at("second/models")).unwrap().next().unwrap().unwrap().path();
    let (after, _) = taxel_checkpoint::read(&tuned).unwrap();
    assert_eq!(before.get(&frozen), after.get(&frozen), "{stem} is frozen");
    let moved = |name: &&String| before.get(name) != after.get(name);
    assert!(names.iter().filter(moved).count() > names.len() / 2, "the rest is tuned");
    let results: serde_json::Value =
        serde_json::from_slice(&std::fs::read(at("second/results.json")).unwrap()).unwrap();
    assert!(results["networks"][0].get("made_anew").is_none());
    // What training changed: nothing in the frozen convolution, something in every other, averaged over folds.
    let changes = results["networks"][0]["changes"].as_array().unwrap();
    let still = changes.iter().filter(|change| change["change"] == 0.0).count();
    assert!(changes.len() > 3 && still == 1, "{changes:?}");
    for change in changes {
        let moved = change["change"].as_f64().unwrap();
        assert_eq!(moved == 0.0, change["layer"] == stem.as_str(), "{change}");
        let of_folds = [0, 1].map(|fold| {
            let record = at(&format!("second/folds/resnet8-lite-1d.r0.f{fold}.json"));
            let record: serde_json::Value = serde_json::from_slice(&std::fs::read(record).unwrap()).unwrap();
            let own = record["changes"].as_array().unwrap();
            own.iter().find(|c| c["layer"] == change["layer"]).unwrap()["change"].as_f64().unwrap()
        });
        assert!((of_folds[0] + of_folds[1] - 2.0 * moved).abs() < 1e-15, "{of_folds:?} {change}");
    }

    // Four classes instead of three.
    let four = "scene = \"fingertip\"\nset = { shore = [0, 10, 20, 30] }";
    let more = config(&model, "").to_toml().unwrap().replace("scene = \"fingertip\"", four);
    let experiment = Experiment::parse(&more, "four.toml", &Overrides::default()).unwrap();
    go(&experiment, "four").unwrap();
    let results: serde_json::Value =
        serde_json::from_slice(&std::fs::read(at("four/results.json")).unwrap()).unwrap();
    let anew = results["networks"][0]["made_anew"].as_array().unwrap();
    assert_eq!(anew.len(), 2, "weight and bias of the head: {anew:?}");

    let message = |path: &Path| go(&config(path, ""), "never").unwrap_err().to_string();
    assert!(message(&at("none.safetensors")).contains("networks.0.weights"));
    let mlp = std::fs::read_dir(at("first/models")).unwrap().map(|e| e.unwrap().path());
    let mlp = mlp.filter(|p| p.to_str().unwrap().contains("mlp")).min().unwrap();
    assert!(message(&mlp).contains("networks.0.weights"), "{}", message(&mlp));
    assert!(!at("never").exists(), "nothing was begun");
}
