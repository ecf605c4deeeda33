//! Recordings of unequal length from `data check` to `predict`, as a user goes.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/quickstart.toml");

fn taxel(arguments: &[&str]) -> Output {
    Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap()
}

/// Runs and expects this exit code; what was printed, on the stream of that code.
fn ends(code: i32, arguments: &[&str]) -> String {
    let output = taxel(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    if code == 2 { error } else { String::from_utf8(output.stdout).unwrap() }
}

/// One recording of three channels.
fn csv(path: &Path, length: usize, hard: bool) {
    let pace = if hard { 0.9 } else { 0.3 };
    let row = |t: usize| {
        let t = t as f64;
        format!("{:.4},{:.4},{:.4}\n", (pace * t).sin(), (pace * t).cos() * 2.0, pace * t)
    };
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, (0..length).map(row).collect::<String>()).unwrap();
}

/// Eight recordings of each of two classes, of 20 to 35 readings.
fn presses(folder: &Path) {
    for i in 0..16 {
        let class = ["soft", "hard"][i % 2];
        csv(&folder.join(class).join(format!("{i}.csv")), 20 + (i * 7) % 16, i % 2 == 1);
    }
}

#[test]
fn unequal_recordings_are_checked_run_fitted_and_answered() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("presses"));
    csv(&folder.path().join("new.csv"), 41, true);
    let (data, run, model, new) = (at("presses"), at("run"), at("m.safetensors"), at("new.csv"));

    // Sixteen lengths from 20 to 35; the median, the lower of two, is 27.
    let card = ends(1, &["data", "check", &data]);
    assert!(card.contains("proposed    length = { kind = \"resample\", to = 27 }"), "{card}");
    let quick = ["run", QUICKSTART, "--quick", "--set", "train.epochs=2", "--data", &data, "--output", &run];
    let error = ends(2, &quick);
    let way_out =
        "data.length = { kind = \"resample\", to = 27 }, or on the command line --length resample:27";
    assert!(error.contains("recordings have 20 to 35 readings") && error.contains(way_out), "{error}");
    assert!(!Path::new(&run).join("results.json").exists());

    let checked: Value = serde_json::from_str(&ends(
        0,
        &["data", "check", &data, "--length", "resample:27", "--format", "json"],
    ))
    .unwrap();
    ends(0, &[&quick[..], &["--length", "resample:27"]].concat());
    let results: Value =
        serde_json::from_str(&fs::read_to_string(Path::new(&run).join("results.json")).unwrap()).unwrap();
    assert_eq!(results["data_digest"], checked["digest"], "the digest of the data as used is recorded");
    assert!(fs::read_to_string(Path::new(&run).join("config.toml")).unwrap().contains("[data.length]"));

    let card = ends(0, &["fit", &run, "--network", "mlp", "--output", &model]);
    assert!(card.contains("length = { kind = \"resample\", to = 27 }"), "{card}");
    let answers = ends(0, &["predict", &model, &new, "--format", "csv"]);
    assert_eq!(answers.lines().count(), 2, "one answer per recording: {answers}");
    assert_eq!(ends(0, &["predict", &model, &data, "--format", "csv"]).lines().count(), 17);
    let error = ends(2, &["predict", &model, &new, "--length", "crop:27"]);
    assert!(error.contains("the model has its own rule, resample:27"), "{error}");
    let error = ends(2, &["run", QUICKSTART, "--length", "half:3"]);
    assert!(error.contains("is no length rule; write resample:300"), "{error}");
}

#[test]
fn windows_are_answered_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("presses"));
    csv(&folder.path().join("new.csv"), 41, true);
    let (data, model, new) = (at("presses"), at("m.safetensors"), at("new.csv"));
    let fit = ["fit", QUICKSTART, "--quick", "--network", "mlp", "--output", &model, "--data", &data];
    ends(0, &[&fit[..], &["--length", "window:10,8", "--set", "train.epochs=2"]].concat());
    let answers = ends(0, &["predict", &model, &new, "--format", "csv"]);
    let starts: Vec<&str> = answers.lines().map(|line| line.split(',').nth(1).unwrap()).collect();
    assert_eq!(starts, ["start", "0", "8", "16", "24"]);
    assert!(answers.lines().skip(1).all(|line| line.starts_with("new.csv,")), "{answers}");
    let answers: Value =
        serde_json::from_str(&ends(0, &["predict", &model, &new, "--format", "json"])).unwrap();
    assert_eq!(
        (&answers["answers"][3]["start"], &answers["answers"][3]["sample"]),
        (&24.into(), &"new.csv".into())
    );
    let out = at("answers.npz");
    ends(0, &["predict", &model, &data, "--format", "npz", "--output", &out]);
    csv(&folder.path().join("short.csv"), 9, true);
    let error = ends(2, &["predict", &model, &at("short.csv")]);
    assert!(error.contains("short.csv: has 9 readings, length.to is 10; it holds no window"), "{error}");
}

#[test]
fn recordings_with_time_stamps_are_answered_at_the_rate_of_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let table = |name: &str, recordings: usize, stamps: &[f64]| {
        let mut rows = "recording,time,a,b,label\n".to_string();
        for i in 0..recordings {
            for time in stamps {
                let value = (time * [30.0, 90.0][i % 2]).sin();
                rows +=
                    &format!("r{i},{time:.4},{value:.4},{:.4},{}\n", value * value, ["soft", "hard"][i % 2]);
            }
        }
        fs::write(folder.path().join(name), rows).unwrap();
    };
    let regular: Vec<f64> = (0..41).map(|i| f64::from(i) * 0.01).collect();
    // 81 readings of the same 0.4 s, of which the median step is 5 ms.
    let irregular: Vec<f64> =
        (0..81).map(|i| f64::from(i) * 0.005 + [0.0, 0.0, 0.002][i as usize % 3]).collect();
    table("presses.csv", 12, &regular);
    table("new.csv", 1, &irregular);
    let (data, model, new) = (at("presses.csv"), at("m.safetensors"), at("new.csv"));
    let fit = ["fit", QUICKSTART, "--quick", "--network", "mlp", "--output", &model, "--data", &data];
    ends(0, &[&fit[..], &["--length", "window:10,8", "--set", "train.epochs=1"]].concat());
    let answers = ends(0, &["predict", &model, &new, "--format", "csv"]);
    let starts: Vec<&str> = answers.lines().map(|line| line.split(',').nth(1).unwrap()).collect();
    assert_eq!(starts, ["start", "0", "8", "16", "24"], "41 readings at 100 Hz");
}

#[test]
fn a_model_without_a_rule_takes_one_for_the_moment() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    (0..8).for_each(|i| {
        csv(&folder.path().join("even").join(["a", "b"][i % 2]).join(format!("{i}.csv")), 24, i % 2 == 1);
    });
    presses(&folder.path().join("presses"));
    let (even, model, data) = (at("even"), at("m.safetensors"), at("presses"));
    let set = ["--set", "train.epochs=1"];
    let fit = ["fit", QUICKSTART, "--quick", "--network", "mlp", "--output", &model, "--data", &even];
    ends(0, &[&fit[..], &set].concat());
    let error = ends(2, &["predict", &model, &data]);
    assert!(error.trim_end().ends_with("or on the command line --length resample:24"), "{error}");
    let answers = ends(0, &["predict", &model, &data, "--length", "pad:24,edge,crop", "--format", "csv"]);
    assert_eq!(answers.lines().count(), 17);
}
