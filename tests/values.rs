//! Targets that are values from a file to a prediction, as a user goes: run, fit, inspect, predict.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use ndarray::ArrayD;
use serde_json::Value;
use taxel::data::{Quantity, Targets, Values};
use taxel::{Dataset, Layout};

/// Runs and expects this exit code; what was printed, on the stream of that code.
fn ends(code: i32, arguments: &[&str]) -> String {
    let output = Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    if code == 2 { error } else { String::from_utf8(output.stdout).unwrap() }
}

/// Presses from 0 to 10 N on two channels, whose readings are linear in the force, with a little noise.
fn presses(path: &Path, samples: usize, offset: usize) {
    let force = |i: usize| ((i * 37 + offset) % 101) as f32 / 10.1;
    let noise = |i: usize| ((i * 7919 % 997) as f32 / 997.0 - 0.5) * 0.02;
    let x = ArrayD::from_shape_fn(vec![samples, 2, 12], |at| {
        let rise = (at[2] + 1) as f32 / 12.0;
        force(at[0]) * rise * (1.0 + at[1] as f32) + noise(at[0] * 24 + at[1] * 12 + at[2])
    });
    let mut dataset = Dataset::new("skin", Layout::Series, x, &vec![0; samples]).unwrap();
    let quantity = Quantity { name: "force".into(), unit: Some("N".into()) };
    dataset.targets = Targets::Values(Values::new(vec![quantity], (0..samples).map(force).collect()));
    dataset.save(path).unwrap();
}

const CONFIG: &str = r#"
name = "skin"
networks = []
[data]
path = "skin.npz"
[encoding]
signal = { scale = "raw" }
"#;

#[test]
fn a_force_is_learned_and_predicted_with_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("skin.npz"), 80, 0);
    presses(&folder.path().join("new.npz"), 20, 5);
    fs::write(folder.path().join("skin.toml"), CONFIG).unwrap();
    let (config, run, model, new) = (at("skin.toml"), at("run"), at("m.safetensors"), at("new.npz"));

    let table = ends(0, &["run", &config, "--output", &run]);
    assert!(table.contains("MAE N") && table.contains("R²"), "{table}");
    assert!(table.contains("left out: svm-rbf: learns classes, and the targets are values"), "{table}");
    let results: Value = serde_json::from_str(&fs::read_to_string(at("run/results.json")).unwrap()).unwrap();
    assert_eq!(results["quantities"][0]["unit"], "N");
    let networks = results["networks"].as_array().unwrap();
    let row = |name: &str| networks.iter().find(|row| row["network"] == name).unwrap();
    for name in ["mean", "k-nn", "mini-rocket", "extra-trees"] {
        assert!(row(name)["mean"]["mae"].is_f64(), "{name}");
    }
    let ridge = row("ridge");
    let mae = ridge["mean"]["mae"].as_f64().unwrap();
    assert!(mae < 0.05 && ridge["mean"]["r2"].as_f64().unwrap() > 0.999, "{ridge}");
    let interval = &ridge["interval"];
    assert!(interval[0].as_f64().unwrap() <= mae && mae <= interval[1].as_f64().unwrap(), "{interval}");
    // Nothing is trained again, and the scores follow from the records.
    ends(0, &["run", &config, "--output", &run, "--resume"]);

    ends(0, &["fit", &run, "--network", "ridge", "--output", &model]);
    let card = ends(0, &["inspect", &model]);
    assert!(card.contains("force: a value, in N") && card.contains("MAE 0.0"), "{card}");
    // A run that names no baselines has that of values all the same.
    ends(0, &["shrink", &run, "--network", "ridge", "--axes", "sensors", "--output", &at("smaller")]);
    let said = ends(0, &["predict", &model, &new, "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    for (i, answer) in said["answers"].as_array().unwrap().iter().enumerate() {
        let force = f64::from(((i * 37 + 5) % 101) as u32) / 10.1;
        let predicted = answer["predicted"]["force"].as_f64().unwrap();
        assert!((predicted - force).abs() < 0.2, "sample {i}: {predicted} for {force}");
    }
    let table = ends(0, &["predict", &model, &new]);
    assert!(table.contains("force (N)"), "{table}");
}

#[test]
fn a_network_of_classes_refuses_values_by_name() {
    let folder = tempfile::tempdir().unwrap();
    presses(&folder.path().join("skin.npz"), 40, 0);
    let config = folder.path().join("skin.toml");
    fs::write(&config, CONFIG.replace("networks = []", "networks = [{ name = \"mlp\" }]")).unwrap();
    let out = folder.path().join("run");
    let error = ends(2, &["run", config.to_str().unwrap(), "--output", out.to_str().unwrap()]);
    assert!(error.contains("mlp") && error.contains("run a baseline of values, such as ridge"), "{error}");
    assert!(!out.exists());
}
