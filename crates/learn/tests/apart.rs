//! Folds of one run trained apart, and a run that is stopped by a flag: the same bytes as one run.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../../tests/support/run_folder.rs"]
mod run_folder;
mod support;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use run_folder::contents;
use serde_json::json;
use support::{key, mlp, presses, recipe, run_at, three_folds};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_learn::{
    Candidate, CrossValidation, Error, FoldKey, Progress, RunFolder, RunOptions, Silent, gather,
};

fn validation(dataset: &Dataset) -> CrossValidation<'_> {
    let stopping = json!({ "early_stopping": { "patience": 2 }, "epochs": 6 });
    let baseline = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    three_folds(dataset, vec![mlp(dataset, recipe(stopping)), baseline])
}

fn only(dataset: &Dataset, out: &Path, only: &[FoldKey]) -> Result<RunFolder, Error> {
    let options =
        RunOptions { resume: true, threads: Some(1), only: Some(only.to_vec()), ..RunOptions::default() };
    validation(dataset).run_in(out, &options, &Silent, &AtomicBool::new(false))
}

fn assert_equal(a: &Path, b: &Path) {
    let (a, b) = (contents(a), contents(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    a.iter().for_each(|(name, bytes)| assert!(*bytes == b[name], "{} differs", name.display()));
}

#[test]
fn folds_that_were_trained_apart_are_one_run() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let whole = run_at(validation(&dataset), &at("whole")).unwrap();
    let keys = validation(&dataset).keys().unwrap();
    assert_eq!(keys, whole.keys().unwrap());
    let mut pieces = vec![];
    for key in &keys {
        let piece = only(&dataset, &at(&key.to_string()), std::slice::from_ref(key)).unwrap();
        let results = piece.results().unwrap();
        assert!(!results.complete && results.missing.len() == keys.len() - 1, "{key}");
        // Answers are timed where they are in an undivided run.
        assert_eq!(piece.timing(key).unwrap().unwrap().latency.is_some(), key.fold == 0, "{key}");
        pieces.push((piece, key.clone()));
    }
    let part = gather(&at("part"), &pieces[1..]).unwrap();
    only(&dataset, part.path(), &[]).unwrap();
    assert_eq!(part.results().unwrap().missing, keys[..1]);
    let together = gather(&at("together"), &pieces).unwrap();
    only(&dataset, together.path(), &[]).unwrap();
    assert_equal(whole.path(), together.path());
    let error = only(&dataset, &at("none"), &[key("mlp", 0, 7)]).unwrap_err().to_string();
    assert_eq!(error, "only = mlp.r0.f7: is no fold of this run");
}

/// Sets a flag at its third step.
struct Stop(Arc<AtomicBool>, std::sync::atomic::AtomicUsize);

impl Progress for Stop {
    fn start(&self, _work: u64) {}
    fn fold(&self, _key: &FoldKey, _number: usize, _total: usize) {}
    fn step(&self, _work: u64) {
        if self.1.fetch_add(1, Ordering::Relaxed) == 2 {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    fn finish(&self) {}
}

#[test]
fn a_stopped_run_is_saved_first_and_goes_on() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let (whole, parts) = (dir.path().join("whole"), dir.path().join("parts"));
    run_at(validation(&dataset), &whole).unwrap();
    let mut saved = 0;
    for stops in 0.. {
        assert!(stops < 40, "no stop came further than the one before");
        let stop = Arc::new(AtomicBool::new(false));
        // It would never be saved by itself.
        let options = RunOptions {
            resume: true,
            threads: Some(1),
            save_every: Some(1e6),
            stop: Some(Arc::clone(&stop)),
            ..RunOptions::default()
        };
        let progress = Stop(stop, 0.into());
        match validation(&dataset).run_in(&parts, &options, &progress, &AtomicBool::new(false)) {
            Ok(_) => break,
            Err(Error::Cancelled { total: 6, .. }) => {}
            Err(other) => panic!("{other}"),
        }
        let names = std::fs::read_dir(parts.join("folds")).unwrap().map(|e| e.unwrap().file_name());
        saved += names.filter(|name| name.to_string_lossy().contains(".session.")).count();
    }
    assert!(saved > 1, "{saved} stops within a fold");
    assert_equal(&whole, &parts);
}
