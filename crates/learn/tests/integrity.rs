//! A run folder whose files do not belong together is refused; a training that diverges is marked.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use support::{key, mlp, presses, recipe, run, run_at, three_folds};
use taxel_baselines::Method;
use taxel_data::{Dataset, Targets};
use taxel_learn::{Candidate, CrossValidation, Error, Model, ResultsTable, RunFolder, RunOptions, Silent};

fn resume(validation: CrossValidation, out: &Path) -> Result<RunFolder, Error> {
    let options = RunOptions { resume: true, threads: Some(1), ..RunOptions::default() };
    validation.run_in(out, &options, &Silent, &AtomicBool::new(false))
}

fn small(dataset: &Dataset) -> CrossValidation<'_> {
    let baseline = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    three_folds(dataset, vec![mlp(dataset, recipe(json!({}))), baseline])
}

fn json_of(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// The same data with other readings.
fn changed(dataset: &Dataset) -> Dataset {
    Dataset { digest: "0".repeat(64), x: dataset.x.mapv(|v| 1.5 * v), ..dataset.clone() }
}

#[test]
fn a_run_goes_on_with_its_own_data_only() {
    let dataset = presses(45, 20);
    let (_keep, folder) = run(small(&dataset));
    let record = folder.file("folds/mlp.r0.f0.json");
    let kept = fs::read(&record).unwrap();
    let others = changed(&dataset);
    // However few files are left that know the data.
    for missing in [&["results.json"][..], &["environment.json"], &[]] {
        missing.iter().for_each(|name| fs::remove_file(folder.file(name)).unwrap());
        let _ = fs::remove_file(&record);
        let error = resume(small(&others), folder.path()).unwrap_err().to_string();
        assert!(error.starts_with(&folder.path().display().to_string()), "{error}");
        assert!(error.contains(&dataset.digest) && error.contains(&others.digest), "{error}");
        assert!(error.ends_with("bring the data back, or run it again in another folder"), "{error}");
        assert!(!record.exists(), "no fold was trained on other data");
    }
    resume(small(&dataset), folder.path()).unwrap();
    assert_eq!(fs::read(&record).unwrap(), kept);
}

#[test]
fn a_run_goes_on_with_its_own_facts_only() {
    let dataset = presses(45, 20);
    let (_keep, folder) = run(small(&dataset));
    type Change<'c> = (&'c str, &'c dyn Fn(&mut Dataset));
    let changes: [Change; 7] = [
        ("full_scale was ", &|data| data.spec.full_scale = Some(4096.0)),
        ("unit was not known, is now \"V\"", &|data| data.spec.unit = Some("V".into())),
        ("rate was ", &|data| data.spec.rate = Some(17.0)),
        ("rest was ", &|data| data.spec.rest = Some(vec![3.0])),
        ("depth was not known, is now 16", &|data| data.spec.depth = Some(16)),
        ("channel_names was ", &|data| data.spec.channel_names = vec!["thumb".into(), "index".into()]),
        ("task was ", &|data| {
            let names = ["hard", "soft", "harder"].map(String::from);
            data.targets = Targets::classes(&names, &data.strata());
        }),
    ];
    for (says, change) in changes {
        let mut other = dataset.clone();
        change(&mut other);
        assert_eq!(other.digest, dataset.digest, "else the readings tell");
        for missing in ["environment.json", "results.json"] {
            let kept = fs::read(folder.file(missing)).unwrap();
            let refused =
                [resume(small(&other), folder.path()).map(|_| ()), folder.finished(&other).map(|_| ())];
            for error in refused {
                let error = error.unwrap_err().to_string();
                let named = missing == "results.json" || error.contains(says);
                assert!(error.contains("same readings with other facts") && named, "{error}");
            }
            fs::remove_file(folder.file(missing)).unwrap();
            let error = resume(small(&other), folder.path()).unwrap_err().to_string();
            assert!(error.contains("same readings with other facts"), "{error}");
            fs::write(folder.file(missing), kept).unwrap();
        }
    }
    resume(small(&dataset), folder.path()).unwrap();
}

#[test]
fn a_model_file_that_is_not_its_folds_own_is_refused_by_name() {
    let dataset = presses(45, 20);
    let (_keep, folder) = run(small(&dataset));
    let (_other, other) = run(three_folds(&dataset, vec![mlp(&dataset, recipe(json!({ "epochs": 9 })))]));
    let path = folder.model_path(&key("mlp", 0, 0));
    let whole = fs::read(&path).unwrap();
    for (foreign, says) in [
        (folder.model_path(&key("mlp", 0, 1)), "is mlp of repetition 0, fold 1"),
        (folder.model_path(&key("k-nn", 0, 0)), "is k-nn of repetition 0, fold 0"),
        (other.model_path(&key("mlp", 0, 0)), "and not the model that its fold wrote"),
    ] {
        fs::copy(&foreign, &path).unwrap();
        let error = Model::open(&path).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: ", path.display())) && error.contains(says), "{error}");
        assert!(error.contains("mlp.r0.f0.json") && error.contains("resume the run"), "{error}");
    }
    fs::write(&path, whole).unwrap();
    Model::open(&path).unwrap();
    // Somewhere else it is a model like any other.
    let away = folder.path().parent().unwrap().join("mlp.safetensors");
    fs::copy(folder.model_path(&key("mlp", 0, 1)), &away).unwrap();
    Model::open(&away).unwrap();
}

/// Folders of older versions hold no digests: resuming takes them from model files whose cards fit.
#[test]
fn resuming_an_older_run_takes_the_digests_of_its_models() {
    let dataset = presses(45, 20);
    let (_keep, folder) = run(small(&dataset));
    let records = ["mlp.r0.f0", "mlp.r0.f1", "mlp.r0.f2", "k-nn.r0.f0", "k-nn.r0.f1", "k-nn.r0.f2"];
    let path = |name: &str| folder.file(&format!("folds/{name}.json"));
    let before: Vec<Vec<u8>> = records.iter().map(|name| fs::read(path(name)).unwrap()).collect();
    let age = || {
        for name in records {
            let mut record = json_of(&path(name));
            for newer in ["model", "data"] {
                assert!(record.as_object_mut().unwrap().shift_remove(newer).is_some(), "{newer}");
            }
            fs::write(path(name), record.to_string()).unwrap();
        }
    };
    age();
    resume(small(&dataset), folder.path()).unwrap();
    let after: Vec<Vec<u8>> = records.iter().map(|name| fs::read(path(name)).unwrap()).collect();
    assert!(before == after, "as if they had been there from the beginning");
    age();
    fs::copy(folder.model_path(&key("mlp", 0, 1)), folder.model_path(&key("mlp", 0, 0))).unwrap();
    let error = resume(small(&dataset), folder.path()).unwrap_err().to_string();
    assert!(error.contains("models/mlp.r0.f0.safetensors: is mlp of repetition 0, fold 1"), "{error}");
}

#[test]
fn the_scores_of_an_older_run_are_read_as_they_were_written() {
    let dataset = presses(45, 20);
    let (_keep, folder) = run(small(&dataset));
    let path = folder.file("results.json");
    let written = json_of(&path);
    let with = |change: &dyn Fn(&mut Value)| {
        let mut results = written.clone();
        for row in results["networks"].as_array_mut().unwrap() {
            change(&mut row["mean"]);
            change(&mut row["sd"]);
            row["folds"].as_array_mut().unwrap().iter_mut().for_each(change);
        }
        fs::write(&path, results.to_string()).unwrap();
        folder.finished(&dataset).map(|(results, _)| results.networks[0].score("accuracy"))
    };
    // A metric that the older version did not know.
    let older = with(&|scores| {
        assert!(scores.as_object_mut().unwrap().shift_remove("balanced_accuracy").is_some());
    });
    assert_eq!(older.unwrap(), written["networks"][0]["mean"]["accuracy"].as_f64());
    let wrong = with(&|scores| scores["accuracy"] = json!(99.0));
    assert!(wrong.unwrap_err().to_string().contains("are not those of the records"));
}

/// An MLP whose steps are far too large.
fn wild(dataset: &Dataset, lr: f64) -> Candidate {
    let changes = json!({ "epochs": 3, "optimizer": { "name": "sgdm", "lr": lr } });
    Candidate { name: "wild".into(), ..mlp(dataset, recipe(changes)) }
}

#[test]
fn a_training_that_ends_far_above_guessing_is_marked() {
    let dataset = presses(45, 20);
    let slow = json!({ "epochs": 1, "optimizer": { "name": "sgdm", "lr": 1e-9 } });
    let idle = Candidate { name: "idle".into(), ..mlp(&dataset, recipe(slow)) };
    let candidates = vec![mlp(&dataset, recipe(json!({}))), idle, wild(&dataset, 1e4)];
    let (_keep, folder) = run(three_folds(&dataset, candidates));
    let last = &folder.record(&key("wild", 0, 0)).unwrap().unwrap().epochs[2];
    assert!(last.train_loss > 100.0, "{last:?}");
    let results = json_of(&folder.file("results.json"));
    for (at, folds) in [(0, Value::Null), (1, Value::Null), (2, json!(3))] {
        assert_eq!(results["networks"][at]["diverged"], folds, "{}", results["networks"][at]["network"]);
    }
    assert_eq!(results["networks"][2]["folds"][1]["diverged"], json!(true));
    let table = ResultsTable::of(&folder).unwrap();
    assert_eq!(table.json()["networks"][2]["diverged"], json!(3));
    let text = table.to_string();
    assert!(text.contains("wild (diverged)") && !text.contains("mlp (diverged)"), "{text}");
    assert!(text.contains("diverged: wild in 3 folds"), "{text}");
}

/// Not finite any more: that fold stops, all others go on, and the run says at its end which did not finish.
#[test]
fn one_training_that_leaves_the_finite_numbers_does_not_take_the_others_with_it() {
    let dataset = presses(45, 20);
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let validation = || three_folds(&dataset, vec![wild(&dataset, 1e30), mlp(&dataset, recipe(json!({})))]);
    let mut said = run_at(validation(), &out).unwrap_err().to_string();
    for _ in 0..2 {
        assert!(said.starts_with("3 of 6 folds did not finish: their training diverged"), "{said}");
        for fold in 0..3 {
            let line = format!("\nwild, repetition 0, fold {fold}: the loss is NaN in epoch 0, batch 1");
            let infinite = line.replace("NaN", "inf");
            assert!(said.contains(&line) || said.contains(&infinite), "{said}");
        }
        let folder = RunFolder::open(&out).unwrap();
        let results = folder.results().unwrap();
        assert_eq!((results.missing.len(), results.networks[1].folds.len()), (3, 3));
        assert_eq!(json_of(&folder.file("results.json"))["networks"][0]["diverged"], json!(3));
        let text = ResultsTable::of(&folder).unwrap().to_string();
        assert!(text.contains("wild (diverged)") && text.contains("diverged: wild in 3 folds"), "{text}");
        // Not an invitation to try the same again.
        assert!(!text.contains("resume the run"), "{text}");
        said = resume(validation(), &out).unwrap_err().to_string();
    }
}
