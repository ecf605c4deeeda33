//! `taxel init` and `taxel run` of recordings: an experiment that nobody wrote.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use ndarray::ArrayD;
use serde_json::Value;
use taxel::data::{Quantity, Targets, Values};
use taxel::{Dataset, Layout};

#[path = "support/schema.rs"]
mod schema;

/// Runs a command in a folder and returns what it printed, with its notes.
fn says(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = Command::cargo_bin("taxel").unwrap().current_dir(folder).args(arguments).output().unwrap();
    let text = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    text
}

/// Recordings whose readings grow with their class, of three classes in four groups.
fn recordings(layout: Layout, shape: &[usize]) -> Dataset {
    let samples = 36;
    let x = ArrayD::from_shape_fn([&[samples], shape].concat(), |at| {
        let place: usize = (1..=shape.len()).map(|axis| at[axis] * (7 + axis)).sum();
        (1 + at[0] % 3) as f32 * 20.0 + ((at[0] * 31 + place * 17) % 23) as f32
    });
    let labels: Vec<usize> = (0..samples).map(|i| i % 3).collect();
    Dataset::new("skin", layout, x, &labels).unwrap()
}

/// Checks a config against the schema that its first line names, as an editor does, and that a wrong key is seen.
fn follows_its_schema(folder: &Path, text: &str) {
    let named = text.lines().next().unwrap().strip_prefix("#:schema ").unwrap();
    let schema: Value = serde_json::from_slice(&fs::read(folder.join(named)).unwrap()).unwrap();
    let of = |text: &str| serde_json::to_value(toml::from_str::<toml::Table>(text).unwrap()).unwrap();
    assert_eq!(schema::problems(&schema, &of(text)), [""; 0]);
    assert!(!schema::problems(&schema, &of(&text.replace("seed =", "sed ="))).is_empty());
}

#[test]
fn every_layout_gets_a_config_that_reads() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sets = [
        (Layout::Features, vec![6], "deep-mlp"),
        (Layout::Series, vec![3, 30], "dilated-resnet-rocket-1d"),
        (Layout::Series, vec![3, 5], "deep-mlp"),
        (Layout::Image, vec![12, 10], "resnet8-lite-2d"),
        (Layout::Image, vec![12, 10], "extra-trees"),
        (Layout::Colour, vec![3, 80, 70], "resize = [64, 56]"),
        (Layout::Sequence, vec![6, 9, 8], "tactnet3d-4-8"),
        (Layout::Fingers, vec![2, 3, 30], "resnet8-lite-1d"),
    ];
    for (layout, shape, wanted) in sets {
        recordings(layout, &shape).save(&at.join("skin.npz")).unwrap();
        fs::remove_file(at.join("skin.toml")).ok();
        let said = says(at, 0, &["init", "skin.npz"]);
        assert!(said.contains("config: skin.toml") && said.contains("min on this machine"), "{said}");
        let text = fs::read_to_string(at.join("skin.toml")).unwrap();
        assert!(text.contains(wanted) && text.contains("[harden]"), "{layout:?} {shape:?}: {text}");
        follows_its_schema(at, &text);
        let whole = says(at, 0, &["run", "skin.toml", "--print-config"]);
        assert!(whole.contains("[protocol]") && whole.contains("split = \"stratified\""), "{whole}");
    }
    let error = says(at, 2, &["init", "skin.npz"]);
    assert!(error.contains("skin.toml: is there already"), "{error}");
    fs::write(at.join("taxel.schema.json"), "{\"title\": \"mine\"}").unwrap();
    let error = says(at, 2, &["init", "skin.npz", "--output", "other.toml"]);
    assert!(error.contains("is no schema of taxel") && !at.join("other.toml").exists(), "{error}");
    assert_eq!(fs::read_to_string(at.join("taxel.schema.json")).unwrap(), "{\"title\": \"mine\"}");
    let error = says(at, 2, &["run", "skin.npz", "--budget", "soon"]);
    assert!(error.contains("--budget"), "{error}");
}

#[test]
fn recordings_run_without_a_config_within_their_budget() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let dataset = recordings(Layout::Series, &[2, 24]).with_groups(&[0, 1, 2, 3].repeat(9)).unwrap();
    dataset.save(&at.join("skin.npz")).unwrap();
    let table = says(at, 0, &["run", "skin.npz", "--budget", "2s", "--set", "train.least_steps=1"]);
    // Groups stay whole, and the networks that take the longest are left out.
    assert!(table.contains("grouped 4-fold") && table.contains("dilated-resnet-rocket-1d"), "{table}");
    assert!(!table.contains("resnet8-lite-1d"), "{table}");
    let results = fs::read(at.join("runs/skin/results.json")).unwrap();
    says(at, 0, &["run", "skin.npz", "--resume"]);
    assert_eq!(fs::read(at.join("runs/skin/results.json")).unwrap(), results, "the choice of the run folder");
    let resumed = says(at, 0, &["run", "skin.npz", "--resume", "--budget", "1h"]);
    assert!(resumed.contains("--budget: not used"), "{resumed}");
    assert_eq!(fs::read(at.join("runs/skin/results.json")).unwrap(), results);
    let error = says(at, 2, &["run", "runs/skin/config.toml", "--budget", "1h"]);
    assert!(error.contains("--budget") && error.contains("config.toml says itself what is run"), "{error}");
    let said = says(at, 0, &["run", "skin.npz", "--budget", "1ms", "--print-config"]);
    assert!(said.contains("no choice of methods fits it"), "{said}");
    let error = says(at, 2, &["run", "skin.npz", "--data", "skin.npz"]);
    assert!(error.contains("keep one of them"), "{error}");
}

#[test]
fn values_get_baselines_and_a_network_of_values() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut dataset = recordings(Layout::Series, &[2, 24]);
    let force = Quantity { name: "force".into(), unit: Some("N".into()) };
    dataset.targets = Targets::Values(Values::new(vec![force], (0..36).map(|i| i as f32 * 0.3).collect()));
    dataset.save(&at.join("skin.npz")).unwrap();
    says(at, 0, &["init", "skin.npz", "--output", "force.toml"]);
    let text = fs::read_to_string(at.join("force.toml")).unwrap();
    let of = "of = [\"layer-norm-mlp\", \"extra-trees\"]";
    for wanted in [
        "\"ridge\"",
        "\"extra-trees\"",
        "\"layer-norm-mlp\"",
        "deep-mlp",
        "loss = \"huber\"",
        "lags = [1, 2, 4, 8, 16]",
        of,
    ] {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
    assert!(!text.contains("majority") && !text.contains("label_smoothing"), "{text}");
    let table =
        says(at, 0, &["run", "force.toml", "--set", "train.epochs=2", "--set", "train.least_steps=1"]);
    assert!(table.contains("MAE N") && table.contains("mlp-and-trees"), "{table}");
}

#[test]
fn values_of_the_data_table_are_heard_before_the_choice() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    recordings(Layout::Series, &[12, 10]).save(&at.join("skin.npz")).unwrap();
    let chosen = |more: &[&str]| {
        let words = [&["run", "skin.npz", "--budget", "20s", "--print-config"], more].concat();
        says(at, 0, &words)
    };
    assert!(chosen(&[]).contains("quantile-code"));
    let image = chosen(&["--set", "data.layout=image"]);
    assert!(image.contains("resnet8-lite-2d") && image.contains("layout = \"image\""), "{image}");
    let channels = chosen(&["--set", "data.channels=[0, 1]", "-v"]);
    assert!(channels.contains("channels = [0, 1]"), "{channels}");
    let error = says(at, 2, &["run", "skin.npz", "--set", "data.chanels=[0]"]);
    assert!(error.contains("chanels") && error.contains("channels"), "{error}");
}
