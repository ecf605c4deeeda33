//! The reference of configs and commands: schema, page, manual pages. What is committed is what the code says.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::{Value, json};
use taxel::{Registry, experiment};

#[path = "support/schema.rs"]
mod schema;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every committed config as JSON, with its path.
fn configs() -> Vec<(String, Value)> {
    let mut folders = vec![root().join("configs")];
    let mut found = vec![];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "toml") {
                let text = std::fs::read_to_string(&path).unwrap();
                let table: toml::Table = toml::from_str(&text).unwrap();
                found.push((path.display().to_string(), serde_json::to_value(table).unwrap()));
            }
        }
    }
    assert!(found.len() > 50, "{}", found.len());
    found
}

fn committed(file: &str) -> String {
    std::fs::read_to_string(root().join("docs").join(file)).unwrap_or_default()
}

/// Checks a committed file; the message says how it is written anew.
fn is_current(file: &str, written: &str, command: &str) {
    let old = committed(file);
    let differs = old.lines().zip(written.lines()).position(|(old, new)| old != new);
    let line = differs.unwrap_or(old.lines().count().min(written.lines().count())) + 1;
    assert!(
        old == written,
        "docs/{file} is not what the code says from line {line} on: {command} > docs/{file}"
    );
}

#[test]
fn page_and_schema_are_those_of_the_code() {
    let registry = Registry::built_in();
    let schema = serde_json::to_string_pretty(&experiment::schema(&registry)).unwrap() + "\n";
    is_current("config.schema.json", &schema, "cargo run --release -- schema");
    is_current("config.md", &experiment::page(&registry), "cargo run --release -- schema --page");
}

/// An editor joins the path of the first line to the folder of the config, as taplo does.
#[test]
fn every_committed_config_names_the_schema() {
    let schema = root().join("docs/config.schema.json").canonicalize().unwrap();
    for (path, _) in configs() {
        let text = std::fs::read_to_string(&path).unwrap();
        let named = text.lines().next().unwrap().strip_prefix("#:schema ").unwrap_or_default();
        let file = Path::new(&path).parent().unwrap().join(named);
        assert_eq!(
            file.canonicalize().ok().as_ref(),
            Some(&schema),
            "{path}: the first line names {named:?}"
        );
    }
}

#[test]
fn the_schema_accepts_every_committed_config() {
    let schema = experiment::schema(&Registry::built_in());
    for (path, config) in configs() {
        let found = schema::problems(&schema, &config);
        assert!(found.is_empty(), "{path}: {found:?}");
    }
}

#[test]
fn the_schema_refuses_what_taxel_refuses() {
    let schema = experiment::schema(&Registry::built_in());
    let good = json!({ "name": "a", "data": { "scene": "fingertip" }, "networks": [{ "name": "mlp" }] });
    assert_eq!(schema::problems(&schema, &good), [""; 0]);
    for (pointer, bad) in [
        ("", json!({ "epochs": 3 })),
        ("/data", json!({ "sample": 3 })),
        ("/data", json!({ "path": "x.npz" })),
        ("/data", json!({ "set": { "session": 3 } })),
        ("/networks/0", json!({ "set": { "hiden": 3 } })),
        ("/networks/0", json!({ "train": { "epochs": "many" } })),
        ("", json!({ "train": { "optimizer": { "name": "sgd" } } })),
        ("", json!({ "train": { "early_stopping": { "patient": 3 } } })),
        ("", json!({ "protocol": { "kind": "k-fold", "test": 0.2 } })),
        ("", json!({ "encoding": { "image": { "kind": "gadf", "red": true } } })),
        ("", json!({ "baselines": ["k-nm"] })),
        ("", json!({ "harden": { "faults": { "kinds": ["noises"] } } })),
    ] {
        let mut config = good.clone();
        let table = config.pointer_mut(pointer).unwrap().as_object_mut().unwrap();
        table.extend(bad.as_object().unwrap().clone());
        assert!(!schema::problems(&schema, &config).is_empty(), "{config} is accepted");
        let text = toml::to_string(&config).unwrap();
        let read = taxel::Experiment::parse(&text, "a.toml", &Default::default(), &Registry::built_in());
        assert!(read.is_err(), "taxel reads {text}");
    }
}

/// Collects the keys of a config; those that a person chooses are names, not keys.
fn keys(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(table) => {
            for (key, below) in table {
                found.insert(key.clone());
                let named = ["look_alikes", "grid", "levels", "factors"].contains(&key.as_str());
                if !named {
                    keys(below, &format!("{path}.{key}"), found);
                }
            }
        }
        Value::Array(all) => all.iter().for_each(|one| keys(one, path, found)),
        _ => {}
    }
}

#[test]
fn every_key_of_every_committed_config_stands_on_the_page() {
    let page = committed("config.md");
    for (path, config) in configs() {
        let mut found = BTreeSet::new();
        keys(&config, "", &mut found);
        for key in found {
            let stands = page.contains(&format!("- `{key}`:")) || page.contains(&format!("**`{key} = "));
            assert!(stands, "{path}: `{key}` stands nowhere on docs/config.md");
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man1");
    let output = Command::cargo_bin("taxel").unwrap().args(["man", "--output"]).arg(&pages).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["taxel", "taxel-run", "taxel-data-check", "taxel-sweep-plan"] {
        let page = std::fs::read_to_string(pages.join(format!("{name}.1"))).unwrap();
        assert!(page.contains(".SH NAME") && page.contains(".TH"), "{name}: {page}");
    }
    let run = std::fs::read_to_string(pages.join("taxel-run.1")).unwrap();
    assert!(run.contains("budget"), "options stand on the page: {run}");
}
