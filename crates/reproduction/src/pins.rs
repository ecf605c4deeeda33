//! Expected values for the small experiment of each paper: `tests/papers/pins.json`.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use taxel::experiment::run;
use taxel::learn::{FoldKey, NetworkResults, Silent};
use taxel::{Experiment, Overrides, Registry, RunFolder, RunOptions};

use crate::error::{Error, Result};
use crate::pages::read;

/// Seeds whose spread tells what one seed may show.
const SEEDS: u64 = 10;
/// A rate that changes no weight, as in `tests/papers.rs`.
const FIXED: [&str; 2] = ["train.optimizer.lr=1e-30", "train.epochs=1"];
const CHOICE: &str = r#"choose.grid={"optimizer.lr"=[1e-30]}"#;

/// Pins of one paper.
struct Pins {
    paper: String,
    /// Networks as they were drawn: costs, losses, confusion.
    fixed: Vec<Value>,
    /// Accuracies of trained networks, one for each seed, in %.
    trained: Vec<Value>,
}

/// Runs every config of `folder` as it was drawn and with ten seeds, and writes `pins.json` beside them. Returns its path.
///
/// # Errors
/// A config that cannot be run, a file that cannot be written.
pub fn pin(folder: &Path) -> Result<PathBuf> {
    let entries = fs::read_dir(folder).map_err(|e| Error::file(folder, e))?;
    let mut configs: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    configs.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    configs.sort();
    let all = configs.iter().map(|config| of_config(config)).collect::<Result<Vec<_>>>()?;
    let path = folder.join("pins.json");
    let text = text(&all);
    taxel::base::files::write_whole(&path, text.as_bytes()).map_err(|e| Error::file(&path, e))?;
    Ok(path)
}

fn of_config(config: &Path) -> Result<Pins> {
    let chooses = read(config)?.contains("[choose]");
    let mut sets: Vec<String> = FIXED.map(String::from).into();
    sets.extend(chooses.then(|| CHOICE.into()));
    let fixed = finished(config, sets, |folder, network| {
        let key = FoldKey { network: network.network.clone(), repetition: 0, fold: 0 };
        let fold = folder.record(&key)?;
        let first = fold.as_ref().and_then(|fold| fold.epochs.first());
        Ok(json!({
            "network": network.network,
            "parameters": network.costs.parameters,
            "macs": network.costs.macs,
            "train_loss": first.map(|epoch| epoch.train_loss),
            "test_loss": fold.as_ref().map(|fold| fold.test_loss),
            "accuracy": network.score("accuracy"),
            "confusion": network.confusion,
        }))
    })?;
    let mut trained: Vec<(String, Vec<f64>)> = vec![];
    for seed in 0..SEEDS {
        let found = finished(config, vec![format!("seed={seed}")], |_, network| {
            let accuracy = network.score("accuracy").map_or(0.0, |score| (100.0 * score).round() / 100.0);
            Ok((network.network.clone(), accuracy))
        })?;
        for (name, accuracy) in found {
            match trained.iter_mut().find(|(known, _)| *known == name) {
                Some((_, accuracies)) => accuracies.push(accuracy),
                None => trained.push((name, vec![accuracy])),
            }
        }
    }
    let trained = trained.into_iter().map(|(name, accuracy)| json!({"network": name, "accuracy": accuracy}));
    let paper = config.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(Pins { paper, fixed, trained: trained.collect() })
}

/// Runs a config with some values set; returns what `of` says of each of its networks.
fn finished<T>(
    config: &Path,
    set: Vec<String>,
    of: impl Fn(&RunFolder, &NetworkResults) -> taxel::learn::Result<T>,
) -> Result<Vec<T>> {
    let folder = tempfile::tempdir().map_err(|e| Error::file(config, e))?;
    let registry = Registry::built_in();
    let overrides = Overrides { set, ..Overrides::default() };
    let experiment = Experiment::load(config, &overrides, &registry).map_err(taxel::Error::from)?;
    let (out, options) = (folder.path().join("run"), RunOptions::default());
    let stop = AtomicBool::new(false);
    let run =
        run(&experiment, &registry, Some(&out), &options, &Silent, &stop).map_err(taxel::Error::from)?;
    let results = run.results().map_err(taxel::Error::from)?;
    let all = results.networks.iter().map(|network| of(&run, network)).collect::<taxel::learn::Result<_>>();
    Ok(all.map_err(taxel::Error::from)?)
}

/// Returns JSON with a line for each network, so that a diff names what has moved.
fn text(all: &[Pins]) -> String {
    let papers: Vec<String> = all
        .iter()
        .map(|pins| {
            let rows = |networks: &[Value]| {
                networks.iter().map(|network| format!("   {}", line(network))).collect::<Vec<_>>().join(",\n")
            };
            let kinds = [("fixed", &pins.fixed), ("trained", &pins.trained)];
            let kinds = kinds.map(|(kind, networks)| format!("  \"{kind}\": [\n{}\n  ]", rows(networks)));
            format!(" \"{}\": {{\n{}\n }}", pins.paper, kinds.join(",\n"))
        })
        .collect();
    format!("{{\n{}\n}}\n", papers.join(",\n"))
}

/// Returns a value on one line, with a space behind each comma and colon.
fn line(value: &Value) -> String {
    match value {
        Value::Array(all) => format!("[{}]", all.iter().map(line).collect::<Vec<_>>().join(", ")),
        Value::Object(all) => {
            let pairs: Vec<String> =
                all.iter().map(|(key, pin)| format!("\"{key}\": {}", line(pin))).collect();
            format!("{{{}}}", pairs.join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn papers() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/papers")
    }

    #[test]
    fn pins_are_written_as_they_are_committed() {
        let committed = fs::read_to_string(papers().join("pins.json")).unwrap();
        let value: Value = serde_json::from_str(&committed).unwrap();
        let rows = |kinds: &Value, kind: &str| kinds[kind].as_array().unwrap().clone();
        let pins = |(paper, kinds): (&String, &Value)| Pins {
            paper: paper.clone(),
            fixed: rows(kinds, "fixed"),
            trained: rows(kinds, "trained"),
        };
        let all: Vec<Pins> = value.as_object().unwrap().iter().map(pins).collect();
        assert_eq!(text(&all), committed);
    }
}
