//! Runs without a config: in memory and in a folder, resumed, and one training on everything.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};
use support::{change, key, mlp, model, network, presses, recipe, record, run_at, three_folds, trainable};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_learn::{
    Candidate, Combination, Criterion, CrossValidation, Encoder, Encoding, Error, Fit, FoldKey, Model,
    Progress, Protocol, RunOptions, Search, Silent, TrainingPart, fit,
};

/// An MLP that stops early, a network with batch norms, a baseline.
fn candidates(dataset: &Dataset) -> Vec<Candidate> {
    let mut encoder = Encoder::new(&Encoding::default(), dataset);
    let stopping = json!({ "early_stopping": { "patience": 2 }, "epochs": 6 });
    vec![
        mlp(dataset, recipe(stopping)),
        network("resnet8-lite-1d", json!({}), recipe(json!({ "epochs": 5 })), &mut encoder),
        Candidate::baseline(Method::MiniRocket { features: 84 }),
    ]
}

/// Keeps what it is told.
#[derive(Default)]
struct Lines(RefCell<Vec<String>>);

impl Progress for Lines {
    fn start(&self, _work: u64) {}
    fn fold(&self, _key: &FoldKey, _number: usize, _total: usize) {}
    fn step(&self, _work: u64) {}
    fn finish(&self) {}
    fn say(&self, line: &str) {
        self.0.borrow_mut().push(line.into());
    }
}

#[test]
fn a_run_in_memory_gives_the_results_of_a_run_in_a_folder() {
    let dataset = presses(45, 24);
    let dir = tempfile::tempdir().unwrap();
    let folder = run_at(three_folds(&dataset, candidates(&dataset)), &dir.path().join("run")).unwrap();
    let on_disk: Value =
        serde_json::from_slice(&std::fs::read(folder.file("results.json")).unwrap()).unwrap();
    let in_memory = three_folds(&dataset, candidates(&dataset)).run().unwrap();
    assert!(in_memory.complete && in_memory.networks.len() == 3);
    // By way of text, as the file: it may round the last digit.
    let text = serde_json::to_string(&in_memory).unwrap();
    let in_memory: Value = serde_json::from_str(&text).unwrap();
    assert_same("results", &in_memory, &on_disk);
}

/// Equal but for the last digit of numbers: records on disk are read back before they are summed.
fn assert_same(at: &str, a: &Value, b: &Value) {
    match (a, b) {
        (Value::Object(one), Value::Object(other)) => {
            assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>(), "{at}");
            one.iter().for_each(|(key, value)| assert_same(&format!("{at}.{key}"), value, &other[key]));
        }
        (Value::Array(one), Value::Array(other)) => {
            assert_eq!(one.len(), other.len(), "{at}");
            one.iter().zip(other).enumerate().for_each(|(i, (a, b))| assert_same(&format!("{at}.{i}"), a, b));
        }
        (Value::Number(one), Value::Number(other)) if one.is_f64() && other.is_f64() => {
            let (one, other) = (one.as_f64().unwrap(), other.as_f64().unwrap());
            assert!((one - other).abs() <= 1e-14 * one.abs(), "{at}: {one} and {other}");
        }
        _ => assert_eq!(a, b, "{at}"),
    }
}

fn resume(validation: CrossValidation, out: &Path) -> Result<(), Error> {
    let options = RunOptions { resume: true, threads: Some(1), ..RunOptions::default() };
    validation.run_in(out, &options, &Silent, &AtomicBool::new(false)).map(|_| ())
}

#[test]
fn a_resumed_run_must_be_the_same_one() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let validation = |changes: Value| three_folds(&dataset, vec![mlp(&dataset, recipe(changes))]);
    let folder = run_at(validation(json!({})), &out).unwrap();
    let before = std::fs::read(folder.file("results.json")).unwrap();
    let error = run_at(validation(json!({})), &out).unwrap_err().to_string();
    assert!(error.ends_with("exists and is not empty; resume its run or give another folder"), "{error}");
    resume(validation(json!({})), &out).unwrap();

    let choosing = |validation: f64, by| {
        let mut candidate = mlp(&dataset, recipe(json!({})));
        let set = BTreeMap::from([("epochs".to_string(), json!(2))]);
        let grid = vec![Combination { set, recipe: recipe(json!({ "epochs": 2 })) }];
        change(&mut candidate, |network| network.search = Some(Search { grid, validation, by }));
        three_folds(&dataset, vec![candidate])
    };
    let starting = |fold: usize| {
        let mut candidate = mlp(&dataset, recipe(json!({})));
        let weights = model(&folder, &key("mlp", 0, fold)).weights().clone();
        change(&mut candidate, |network| network.start = Some(Arc::new(weights)));
        three_folds(&dataset, vec![candidate])
    };
    let renamed = Candidate { name: "other".into(), ..mlp(&dataset, recipe(json!({}))) };
    let raw: Encoding = serde_json::from_value(json!({ "signal": { "scale": "raw" } })).unwrap();
    for (other, difference) in [
        (validation(json!({ "epochs": 5 })), "candidates.0.recipe.epochs was 4, is now 5"),
        (validation(json!({})).seed(4), "seed was 3, is now 4"),
        (validation(json!({})).protocol(Protocol::k_fold(2)), "protocol.folds was 3, is now 2"),
        (validation(json!({})).encoding(raw), "encoding.signal.scale was \"z-score\", is now \"raw\""),
        (three_folds(&dataset, vec![renamed]), "candidates.0.name was \"mlp\", is now \"other\""),
        (three_folds(&dataset, vec![]), "candidates is another"),
        (choosing(0.2, Criterion::Loss), "candidates.0.search is another"),
        (starting(0), "candidates.0.start was null, is now \""),
    ] {
        let error = resume(other, &out).unwrap_err().to_string();
        let want = format!("{}: was run with other settings: {difference}", out.display());
        assert!(error.starts_with(&want), "{error}");
        assert!(error.ends_with("; resume with the same ones or give another folder"), "{error}");
    }
    // On other data, though the settings agree.
    let mut other = dataset.clone();
    other.digest = "0".repeat(64);
    let error = resume(three_folds(&other, vec![mlp(&dataset, recipe(json!({})))]), &out).unwrap_err();
    assert!(error.to_string().contains("was run on other data"), "{error}");
    assert_eq!(std::fs::read(folder.file("results.json")).unwrap(), before);

    // What a search is judged by and what a training starts from are settings too.
    let chosen = dir.path().join("chosen");
    run_at(choosing(0.2, Criterion::Loss), &chosen).unwrap();
    resume(choosing(0.2, Criterion::Loss), &chosen).unwrap();
    for other in [choosing(0.3, Criterion::Loss), choosing(0.2, Criterion::Metric("accuracy".into()))] {
        assert!(resume(other, &chosen).is_err());
    }
    let started = dir.path().join("started");
    run_at(starting(0), &started).unwrap();
    resume(starting(0), &started).unwrap();
    assert!(resume(starting(1), &started).is_err(), "other weights to start from");
}

/// Ends a training after `samples` of it.
fn stopped_after(fit: &Fit, dataset: &Dataset, samples: usize) -> Option<Model> {
    let (cancel, mut seen) = (AtomicBool::new(false), 0);
    let mut tick = |count: usize| {
        seen += count;
        cancel.store(seen >= samples, Ordering::Relaxed);
    };
    fit.run(&mut Encoder::new(&Encoding::default(), dataset), &mut tick, &cancel).unwrap()
}

/// A training on everything goes on where it was saved, also in the middle of a search, to the same bytes.
#[test]
fn a_stopped_fit_goes_on_to_the_same_bytes() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let bytes = |model: Model| {
        let path = dir.path().join("model.safetensors");
        model.save(&path).unwrap();
        std::fs::read(&path).unwrap()
    };
    let adam = json!({
        "epochs": 8, "optimizer": { "name": "adam", "lr": 1e-2 }, "early_stopping": { "patience": 5 },
    });
    let mut choosing = mlp(&dataset, recipe(adam));
    let combination = |lr: f64| {
        let set = BTreeMap::from([("optimizer.lr".to_string(), json!(lr))]);
        let changes = json!({ "epochs": 3, "optimizer": { "name": "adam", "lr": lr } });
        Combination { set, recipe: recipe(changes) }
    };
    let grid = vec![combination(1e-3), combination(1e-2)];
    change(&mut choosing, |network| {
        network.search = Some(Search { grid, validation: 0.2, by: Criterion::Loss })
    });
    for candidate in candidates(&dataset).into_iter().take(2).chain([choosing]) {
        let protocol = Protocol::k_fold(3);
        let options = RunOptions { threads: Some(1), save_every: Some(0.0), ..RunOptions::default() };
        let session = |name: &str| Some(dir.path().join(name).with_extension("session.safetensors"));
        let fit = |name: &str| Fit {
            candidate: &candidate,
            protocol: &protocol,
            seed: 7,
            options: options.clone(),
            session: session(name),
        };
        let whole = stopped_after(&Fit { session: None, ..fit("whole") }, &dataset, usize::MAX).unwrap();
        let parts = fit(&format!("{}-{}", candidate.name, trainable(&candidate).search.is_some()));
        // In the middle of an epoch, each time a little further.
        let (mut stops, mut model) = (0, None);
        while model.is_none() {
            // What was done before is heard of at once, so the first stops would come at the same place.
            model = stopped_after(&parts, &dataset, 60 + 50 * stops);
            stops += 1;
            assert!(stops < 50);
        }
        assert!(stops > 2, "{}: {stops}", candidate.name);
        assert_eq!(whole.card().trained_on.part, TrainingPart::Everything);
        assert_eq!(whole.card().trained_on.samples, 45);
        assert!(bytes(whole) == bytes(model.unwrap()), "{}", candidate.name);
    }
}

#[test]
fn a_session_of_another_training_is_refused_by_name() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let session = dir.path().join("mlp.session.safetensors");
    let options = RunOptions { threads: Some(1), save_every: Some(0.0), ..RunOptions::default() };
    let go = |candidate: &Candidate, dataset: &Dataset, seed: u64, samples: usize| {
        let (cancel, mut seen) = (AtomicBool::new(false), 0);
        let mut tick = |count: usize| {
            seen += count;
            cancel.store(seen >= samples, Ordering::Relaxed);
        };
        let (protocol, options, session) = (Protocol::default(), options.clone(), Some(session.clone()));
        let fit = Fit { candidate, protocol: &protocol, seed, options, session };
        fit.run(&mut Encoder::new(&Encoding::default(), dataset), &mut tick, &cancel)
    };
    let candidate = mlp(&dataset, recipe(json!({})));
    assert!(go(&candidate, &dataset, 0, 100).unwrap().is_none() && session.is_file());
    let slow = mlp(&dataset, recipe(json!({ "optimizer": { "name": "sgdm", "lr": 1e-3 } })));
    let others = candidates(&dataset);
    let more = presses(48, 20);
    for (candidate, dataset, seed) in
        [(&slow, &dataset, 0), (&others[1], &dataset, 0), (&candidate, &dataset, 1), (&candidate, &more, 0)]
    {
        let error = go(candidate, dataset, seed, usize::MAX).unwrap_err().to_string();
        let want = format!("{}: was saved by another training: ", session.display());
        assert!(error.starts_with(&want) && error.contains("delete it and go on"), "{error}");
    }
    assert!(go(&candidate, &dataset, 0, usize::MAX).unwrap().is_some());
    // A file that is broken is named too.
    std::fs::write(&session, b"{").unwrap();
    let error = go(&candidate, &dataset, 0, usize::MAX).unwrap_err().to_string();
    assert!(error.starts_with(&session.display().to_string()) && error.contains("delete it"), "{error}");
}

#[test]
fn a_fit_without_a_session_is_the_same_for_any_threads() {
    let dataset = presses(45, 24);
    for candidate in candidates(&dataset) {
        let one = fit(&candidate, &dataset, &Encoding::default()).unwrap();
        let protocol = Protocol::default();
        let options = RunOptions { threads: Some(3), ..RunOptions::default() };
        let three = Fit { candidate: &candidate, protocol: &protocol, seed: 0, options, session: None };
        let three = stopped_after(&three, &dataset, usize::MAX).unwrap();
        assert!(one == three, "{}", candidate.name);
    }
}

#[test]
fn a_fold_in_training_goes_on_where_it_was_saved() {
    struct Stop<'a>(&'a AtomicBool, std::sync::atomic::AtomicUsize);
    impl Progress for Stop<'_> {
        fn start(&self, _work: u64) {}
        fn fold(&self, _key: &FoldKey, _number: usize, _total: usize) {}
        fn step(&self, _work: u64) {
            self.0.store(self.1.fetch_add(1, Ordering::Relaxed) >= 15, Ordering::Relaxed);
        }
        fn finish(&self) {}
    }
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let whole = run_at(three_folds(&dataset, candidates(&dataset)), &dir.path().join("whole")).unwrap();
    let out = dir.path().join("parts");
    let mut sessions = 0;
    for stops in 0.. {
        let cancel = AtomicBool::new(false);
        let options = RunOptions {
            resume: stops > 0,
            threads: Some(1),
            save_every: Some(0.0),
            ..RunOptions::default()
        };
        let validation = three_folds(&dataset, candidates(&dataset));
        match validation.run_in(&out, &options, &Stop(&cancel, 0.into()), &cancel) {
            Ok(_) => break,
            Err(Error::Cancelled { total: 9, .. }) => {}
            Err(other) => panic!("{other}"),
        }
        let saved = std::fs::read_dir(out.join("folds")).unwrap().map(|e| e.unwrap().file_name());
        sessions += saved.filter(|name| name.to_string_lossy().contains(".session.")).count();
        assert!(stops < 50);
    }
    assert!(sessions > 2, "{sessions} stops in the middle of a fold");
    let parts = taxel_learn::RunFolder::open(&out).unwrap();
    for key in parts.keys().unwrap() {
        assert_eq!(record(&parts, &key), record(&whole, &key));
        let bytes = |folder: &taxel_learn::RunFolder| std::fs::read(folder.model_path(&key)).unwrap();
        assert!(bytes(&parts) == bytes(&whole), "{key}");
    }
}

/// The message of a cancelled run says how to go on, in the library's words.
#[test]
fn a_stopped_run_says_where_it_stands() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let cancel = AtomicBool::new(true);
    let validation = three_folds(&dataset, candidates(&dataset));
    let error = validation.run_in(&out, &RunOptions::default(), &Silent, &cancel).unwrap_err().to_string();
    let want = format!("stopped after 0 of 9 folds; {} holds them", out.display());
    assert_eq!(error, want);
}

/// Of a machine that was busy: its latencies are taken again, and nothing else changes.
#[test]
fn latencies_are_timed_again_and_scores_stay() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let folder = run_at(three_folds(&dataset, candidates(&dataset)), &out).unwrap();
    let results = || std::fs::read(out.join("results.json")).unwrap();
    let (before, keys) = (results(), folder.keys().unwrap());
    let timing = |key: &FoldKey| out.join(format!("folds/{key}.timing.json"));
    let read = |path: &Path| -> Value { serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap() };
    let first: Vec<&FoldKey> =
        keys.iter().filter(|key| !read(&timing(key))["whole_latency"].is_null()).collect();
    assert_eq!(first.len(), 3, "one of each row");
    for key in &first {
        let mut busy = read(&timing(key));
        busy["whole_latency"]["p50_ms"] = 1e6.into();
        std::fs::write(timing(key), busy.to_string()).unwrap();
    }
    let again = |time_again| {
        let options = RunOptions { resume: true, threads: Some(1), time_again, ..RunOptions::default() };
        let validation = three_folds(&dataset, candidates(&dataset));
        validation.run_in(&out, &options, &Silent, &AtomicBool::new(false))
    };
    let p50 = || {
        first
            .iter()
            .map(|key| read(&timing(key))["whole_latency"]["p50_ms"].as_f64().unwrap())
            .fold(0.0, f64::max)
    };
    again(false).unwrap();
    assert_eq!(p50(), 1e6);
    again(true).unwrap();
    assert!(p50() < 1e6 && results() == before);
    // A run of an older version: its latency left the encoding of networks out, so none is shown until it is timed.
    for key in &first {
        let mut older = read(&timing(key));
        older["latency"] = older["whole_latency"].take();
        std::fs::write(timing(key), older.to_string()).unwrap();
    }
    assert!(folder.timings().unwrap().iter().all(|timing| timing.latency.is_none()));
    again(true).unwrap();
    let here = p50();
    let mut machine = read(&out.join("environment.json"));
    let cpu = std::mem::replace(&mut machine["cpu"], "abacus".into());
    std::fs::write(out.join("environment.json"), machine.to_string()).unwrap();
    let error = again(true).unwrap_err().to_string();
    assert!(error.contains("was run on abacus") && error.contains("another folder"), "{error}");
    assert_eq!(p50(), here, "what is refused is not timed either");
    // Vectors of another width are another machine too; a run of a version that did not write theirs is taken at its word.
    machine["cpu"] = cpu;
    for (vectors, same) in [("beads".into(), false), (Value::Null, true)] {
        machine["vectors"] = vectors;
        std::fs::write(out.join("environment.json"), machine.to_string()).unwrap();
        assert_eq!(again(true).is_ok(), same, "{machine}");
    }
}

/// Folds of two machines in one folder: it is said where some are still to be trained, and only there.
#[test]
fn a_run_that_goes_on_elsewhere_is_told_so() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let go_on = |only| {
        let lines = Lines::default();
        let options = RunOptions { resume: true, threads: Some(1), only, ..RunOptions::default() };
        let validation = three_folds(&dataset, candidates(&dataset));
        validation.run_in(&out, &options, &lines, &AtomicBool::new(false)).unwrap();
        lines.0.into_inner()
    };
    let first = key("mlp", 0, 0);
    assert_eq!(go_on(Some(vec![first.clone()])), [""; 0]);
    let mut machine: Value =
        serde_json::from_slice(&std::fs::read(out.join("environment.json")).unwrap()).unwrap();
    machine["vectors"] = "beads".into();
    std::fs::write(out.join("environment.json"), machine.to_string()).unwrap();
    assert_eq!(go_on(Some(vec![first])), [""; 0], "nothing is trained");
    let said = go_on(None);
    assert!(said.len() == 1 && said[0].contains("(beads), this is"), "{said:?}");
    assert!(said[0].ends_with("what is trained now may end a little elsewhere"), "{said:?}");
    assert_eq!(go_on(None), [""; 0], "nothing is left to train");
}
