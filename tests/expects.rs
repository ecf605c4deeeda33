//! Compares recordings with what a model expects of them: unit, rate, full scale, layout and the range of each channel.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;

use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with recordings in millivolts at 100 Hz, and a model of them.
static TRAINED: LazyLock<(TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    run(&["simulate", "fingertip", "--samples", "60", "--output", text(&at("mv.npz"))]);
    say(
        &at("mv.classes.json"),
        &[("unit", json!("mV")), ("rate", json!(100.0)), ("full_scale", json!(1023.0))],
    );
    let config =
        "name = \"c\"\nbaselines = [\"k-nn\"]\n[data]\npath = \"mv.npz\"\n[[networks]]\nname = \"mlp\"\n";
    fs::write(at("c.toml"), config).unwrap();
    let model = at("m.safetensors");
    run(&["fit", text(&at("c.toml")), "--network", "k-nn", "--output", text(&model)]);
    (folder, model)
});

fn taxel(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).env_remove("RUST_BACKTRACE").stdin(Stdio::null()).output().unwrap()
}

fn run(arguments: &[&str]) -> (String, String) {
    let output = taxel(arguments);
    let [out, error] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert!(output.status.success(), "{arguments:?}: {error}");
    (out, error)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Writes facts into the file of names beside an array.
fn say(names: &Path, facts: &[(&str, Value)]) {
    let mut all: Value = serde_json::from_slice(&fs::read(names).unwrap()).unwrap();
    for (key, value) in facts {
        all[*key] = value.clone();
    }
    fs::write(names, all.to_string()).unwrap();
}

/// Writes the recordings of the training, each value times `factor`, with other facts.
fn recordings(folder: &Path, factor: f32, facts: &[(&str, Value)]) -> PathBuf {
    let (trained, path) = (TRAINED.0.path(), folder.join("here.npz"));
    let dataset = taxel::load(&trained.join("mv.npz"), &taxel::ReadOptions::default()).unwrap();
    let x = dataset.x.mapv(|value| value * factor);
    let rows: Vec<usize> = (0..dataset.len()).collect();
    let labels: Vec<i64> = dataset.targets.labels().unwrap().of(&rows).into_iter().map(i64::from).collect();
    let mut npz = taxel::data::Npz::default();
    npz.add("x", x.shape(), x.as_slice().unwrap()).unwrap();
    npz.add("y", &[labels.len()], &labels).unwrap();
    fs::write(&path, npz.finish().unwrap()).unwrap();
    fs::copy(trained.join("mv.classes.json"), folder.join("here.classes.json")).unwrap();
    say(&folder.join("here.classes.json"), facts);
    path
}

fn predictions(path: &Path, more: &[&str]) -> Vec<Value> {
    let arguments = [&["predict", text(&TRAINED.1), text(path), "--format", "json"][..], more].concat();
    serde_json::from_str::<Value>(&run(&arguments).0).unwrap()["answers"].as_array().unwrap().clone()
}

#[test]
fn a_unit_with_another_prefix_is_converted() {
    let folder = tempfile::tempdir().unwrap();
    let volts = recordings(folder.path(), 1e-3, &[("unit", json!("V")), ("full_scale", json!(1.023))]);
    let class = |rows: &[Value]| rows.iter().map(|row| row["predicted"]["class"].clone()).collect::<Vec<_>>();
    let trained = predictions(&TRAINED.0.path().join("mv.npz"), &[]);
    assert_eq!(class(&predictions(&volts, &[])), class(&trained));
    let (_, said) = run(&["predict", text(&TRAINED.1), text(&volts)]);
    assert!(said.contains("here.npz: values are converted from V to mV"), "{said}");
    assert!(!said.contains("far outside"), "{said}");
}

#[test]
fn facts_that_differ_are_refused_together_and_as_is_overrides() {
    let folder = tempfile::tempdir().unwrap();
    let facts = [("unit", json!("N")), ("rate", json!(1000.0)), ("full_scale", json!(1.0))];
    let other = recordings(folder.path(), 1.0, &facts);
    for command in [&["predict"][..], &["stream", "--input"]] {
        let (name, before) = command.split_first().unwrap();
        let arguments = [&[*name, text(&TRAINED.1)], before, &[text(&other)]].concat();
        let output = taxel(&arguments);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        for fact in ["here.npz: ", "unit N", "rate 1000 Hz", "full scale 1,", "trained on mV", "--as-is"] {
            assert!(error.contains(fact), "{arguments:?}: {fact}: {error}");
        }
        run(&[&arguments[..], &["--as-is"]].concat());
    }
}

#[test]
fn values_far_outside_the_training_are_said() {
    let folder = tempfile::tempdir().unwrap();
    // No facts: nothing to compare but the values.
    let larger = recordings(folder.path(), 1000.0, &[]);
    fs::remove_file(folder.path().join("here.classes.json")).unwrap();
    for command in [&["predict"][..], &["stream", "--input"]] {
        let (name, before) = command.split_first().unwrap();
        let (_, said) = run(&[&[*name, text(&TRAINED.1)], before, &[text(&larger)]].concat());
        assert!(said.contains("far outside those of the training"), "{said}");
        assert!(said.contains("channel 0 ") && said.contains("in training"), "{said}");
    }
    let (_, said) = run(&["predict", text(&TRAINED.1), text(&TRAINED.0.path().join("mv.npz"))]);
    assert!(!said.contains("far outside"), "{said}");
}
