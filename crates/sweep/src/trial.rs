//! A trial: one config, or one fold of it, and what makes it the same trial again.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use taxel_learn::FoldKey;
use toml::Table;

/// One line of the manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// BLAKE3 of resolved config, samples, program and, of a fold, its key: equal trials have equal results.
    pub identity: String,
    /// Name of the experiment.
    pub name: String,
    /// Its values of the varied keys, by dotted key.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub set: Map<String, Value>,
    /// The fold, where folds are trials of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fold: Option<TrialFold>,
    /// The samples.
    pub data: DataOf,
    /// Version and commit of the program that planned it; another one refuses to run it.
    pub program: String,
    /// The resolved config as TOML.
    pub config: String,
}

/// One fold of a run whose folds are trials of their own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrialFold {
    /// Identity of the whole run.
    pub run: String,
    /// How many folds it has.
    pub of: usize,
    /// Which one this is.
    #[serde(flatten)]
    pub key: FoldKey,
}

/// The samples of a trial.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DataOf {
    /// `simulated: ..` or `real: ..`.
    pub source: String,
    /// BLAKE3 of the samples.
    pub digest: String,
    /// Digest of the [facts](taxel_data::Facts) about them; empty in plans of older versions.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub facts: String,
    /// BLAKE3 of the files that networks start from; empty where there are none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub weights: String,
    /// Digest of the config's `[data]` table: the same data set, however it is seeded.
    pub set: String,
}

impl Trial {
    /// Returns the identity of the run that it is, or that it is a fold of.
    pub fn run(&self) -> &str {
        self.fold.as_ref().map_or(&self.identity, |piece| &piece.run)
    }

    /// Returns the name, settings and fold on one line.
    pub fn words(&self) -> String {
        let mut words = self.name.clone();
        for (key, value) in &self.set {
            words += &format!(" {key}={}", shown(value));
        }
        if let Some(piece) = &self.fold {
            words += &format!(" {}", piece.key);
        }
        words
    }
}

/// Returns a value as it stands in tables: text without quotes.
pub(crate) fn shown(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}

/// Returns the identity of a run: of its resolved config on its samples and from its weights by this program.
pub(crate) fn run_identity(config: &str, data: &DataOf, program: &str) -> String {
    hashed(&[config, &data.digest, &data.facts, &data.weights, program])
}

/// Returns the identity of one fold of a run.
pub(crate) fn fold_identity(run: &str, key: &FoldKey) -> String {
    hashed(&[run, &key.to_string()])
}

/// Returns the BLAKE3 digest of several texts; each with its length, so that no two lists are one.
pub(crate) fn hashed(parts: &[&str]) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

#[expect(clippy::expect_used, reason = "a resolved config is made of what TOML can write")]
pub(crate) fn toml_of(value: &impl Serialize) -> String {
    Table::try_from(value).expect("a table of a config").to_string()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn each_part_makes_another_identity() {
        let of = |config: &str, [digest, facts, weights]: [&str; 3], program: &str| {
            let [source, set] = ["", ""].map(String::from);
            let [digest, facts, weights] = [digest, facts, weights].map(String::from);
            run_identity(config, &DataOf { source, set, digest, facts, weights }, program)
        };
        let identity = of("seed = 1", ["d", "f", "w"], "0.1.0");
        assert_ne!(identity, of("seed = 2", ["d", "f", "w"], "0.1.0"));
        assert_ne!(identity, of("seed = 1", ["e", "f", "w"], "0.1.0"));
        assert_ne!(identity, of("seed = 1", ["d", "g", "w"], "0.1.0"));
        assert_ne!(identity, of("seed = 1", ["d", "f", "v"], "0.1.0"));
        assert_ne!(identity, of("seed = 1", ["d", "f", "w"], "0.1.1"));
        assert_ne!(of("ab", ["c", "", ""], ""), of("a", ["bc", "", ""], ""), "parts do not run together");
        let key = |fold| FoldKey { network: "mlp".into(), repetition: 0, fold };
        assert_ne!(fold_identity(&identity, &key(0)), fold_identity(&identity, &key(1)));
    }
}
