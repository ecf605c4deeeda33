//! Every file under `configs/` parses, fits its data and runs.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};

use assert_cmd::Command;

fn configs(folder: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs").join(folder);
    let mut paths: Vec<PathBuf> = std::fs::read_dir(root).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    assert!(!paths.is_empty());
    paths
}

fn run_quick(config: &Path) {
    let folder = tempfile::tempdir().unwrap();
    run_quick_into(&folder.path().join("run"), config, &[]);
}

fn run_quick_into(out: &Path, config: &Path, variables: &[(&str, &Path)]) {
    let mut command = Command::cargo_bin("taxel").unwrap();
    command.envs(variables.iter().copied());
    command.args([
        "run",
        config.to_str().unwrap(),
        "--quick",
        "--format",
        "json",
        "--output",
        out.to_str().unwrap(),
    ]);
    let output = command.output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{}: {error}", config.display());
    let table: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(table["complete"], true, "{}", config.display());
}

#[test]
fn simulated_ones_run() {
    configs("").iter().for_each(|config| run_quick(config));
}

#[test]
fn hardness_ones_run() {
    configs("hardness").iter().for_each(|config| run_quick(config));
}

#[test]
fn palpation_ones_run() {
    with_weights("palpation", false).iter().for_each(|config| run_quick(config));
}

#[test]
fn strength_ones_run() {
    configs("strength").iter().for_each(|config| run_quick(config));
}

fn holds(path: &Path, variable: &str) -> bool {
    std::fs::read_to_string(path).unwrap().contains(&format!("${{{variable}}}"))
}

/// Configs of a folder that start from ImageNet weights, or those that start from none.
fn with_weights(folder: &str, wanted: bool) -> Vec<PathBuf> {
    let mut paths = configs(folder);
    paths.retain(|path| holds(path, "TAXEL_WEIGHTS") == wanted && !holds(path, "TAXEL_EYES"));
    paths
}

#[test]
fn visuotactile_ones_run() {
    with_weights("visuotactile", false).iter().for_each(|config| run_quick(config));
}

#[test]
fn visuotactile_and_palpation_ones_run_on_eyes_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let (eyes, with_pictures) =
        (folder.path().join("eyes"), [configs("visuotactile"), configs("palpation")].concat());
    let first = with_pictures.iter().find(|path| path.ends_with("eyes.toml")).unwrap();
    run_quick_into(&eyes, first, &[]);
    let with_eyes: Vec<&PathBuf> = with_pictures.iter().filter(|path| holds(path, "TAXEL_EYES")).collect();
    assert_eq!(with_eyes.len(), 12);
    for (i, config) in with_eyes.into_iter().enumerate() {
        let variables = [("TAXEL_EYES", eyes.join("models"))];
        let variables = variables.each_ref().map(|(name, path)| (*name, path.as_path()));
        run_quick_into(&folder.path().join(i.to_string()), config, &variables);
    }
}

#[test]
#[ignore = "needs TAXEL_WEIGHTS"]
fn visuotactile_ones_run_needs_weights() {
    with_weights("visuotactile", true).iter().for_each(|config| run_quick(config));
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn real_ones_run() {
    with_weights("real", false).iter().for_each(|config| run_quick(config));
}

#[test]
#[ignore = "needs TAXEL_DATA and TAXEL_WEIGHTS"]
fn real_ones_run_needs_weights() {
    with_weights("real", true).iter().for_each(|config| run_quick(config));
}

fn says_what_is_missing(configs: &[PathBuf], variable: &str) {
    assert!(!configs.is_empty());
    for config in configs {
        let mut command = Command::cargo_bin("taxel").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let command = command.env_remove(variable).current_dir(folder.path());
        let output = command.args(["run", "--quick", config.to_str().unwrap()]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains(variable) && error.contains(config.to_str().unwrap()), "{error}");
    }
}

#[test]
fn real_ones_say_what_is_missing() {
    says_what_is_missing(&configs("real"), "TAXEL_DATA");
}

#[test]
fn visuotactile_ones_say_what_is_missing() {
    says_what_is_missing(&with_weights("visuotactile", true), "TAXEL_WEIGHTS");
}
