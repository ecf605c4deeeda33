//! A study: the settings that a sweep varies, read from TOML and checked.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use taxel_base::files::read_text;
use toml::{Table, Value};

use crate::error::{Error, Result};

/// A study: base configs and what is varied in them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Name of the sweep's folder and of its page. Default the name of the file.
    #[serde(default)]
    pub name: String,
    /// One config or several, relative to this file; several are an axis of their own.
    pub config: Configs,
    /// Whether the values of the configs' `[quick]` tables are used.
    #[serde(default)]
    pub quick: bool,
    /// Whether every fold is a trial of its own.
    #[serde(default)]
    pub folds: Folds,
    /// Values that every trial has, by dotted key.
    #[serde(default)]
    pub set: Table,
    /// Values to try by dotted key: every combination.
    #[serde(default)]
    pub grid: Table,
    /// Points: values that change together.
    #[serde(default)]
    pub list: Vec<Table>,
    /// Points that are drawn.
    pub random: Option<Random>,
    /// The file itself.
    #[serde(skip)]
    pub file: PathBuf,
}

/// One config or several.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Configs {
    /// The base of all trials.
    One(PathBuf),
    /// Whole configs as an axis.
    Several(Vec<PathBuf>),
}

/// Size of a trial.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Folds {
    /// A config with all its folds.
    #[default]
    Together,
    /// One fold of one network of a config.
    Apart,
}

/// Points that are drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Random {
    /// How many.
    pub draws: usize,
    /// Seed of the draws, not of the experiments. Default 0.
    #[serde(default)]
    pub seed: u64,
    /// Distributions by dotted key: [`Draw`].
    pub over: Table,
}

/// How one value is drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Draw {
    /// Evenly between two numbers.
    Uniform([f64; 2]),
    /// Evenly between the logarithms of two positive numbers.
    #[serde(alias = "log-uniform")]
    LogUniform([f64; 2]),
    /// A whole number from the first to the second.
    Integer([i64; 2]),
    /// One of these.
    Choice(Vec<Value>),
}

/// Most bytes of a study.
const MAX_BYTES: u64 = 1 << 20;

impl Study {
    /// Reads `path`.
    ///
    /// # Errors
    /// A file that cannot be read, an unknown key, no config.
    pub fn load(path: &Path) -> Result<Self> {
        let text = read_text(path, MAX_BYTES).map_err(|e| Error::io(path, "read", e))?;
        let refuse = |reason: String| Error::file(path, reason);
        let mut study: Study = toml::from_str(&text).map_err(|e| refuse(e.to_string().trim().into()))?;
        study.file = path.into();
        if study.name.is_empty() {
            study.name = path.file_stem().unwrap_or_default().to_string_lossy().into();
        }
        taxel_learn::file_name("name", &study.name).map_err(|e| refuse(e.to_string()))?;
        if study.configs().is_empty() {
            return Err(refuse("config = []: name at least one config".into()));
        }
        Ok(study)
    }

    /// Returns the paths of the configs, from the folder of the study.
    pub fn configs(&self) -> Vec<PathBuf> {
        let base = self.file.parent().unwrap_or(Path::new(""));
        let all = match &self.config {
            Configs::One(one) => std::slice::from_ref(one),
            Configs::Several(all) => all,
        };
        all.iter().map(|path| base.join(path)).collect()
    }
}

impl Random {
    /// Returns the distributions by dotted key.
    ///
    /// # Errors
    /// Nothing to draw, or a range that is none.
    pub(crate) fn over(&self) -> std::result::Result<Vec<(String, Draw)>, String> {
        if self.draws == 0 {
            return Err("random.draws = 0: must be at least 1".into());
        }
        let draw = |(key, value): (String, Value)| {
            let draw: Draw = value.clone().try_into().map_err(|_| {
                format!(
                    "random.over.{key} = {value}: must be one of {{ uniform = [0.0, 1.0] }}, \
                     {{ log_uniform = [1e-4, 1e-1] }}, {{ integer = [8, 64] }}, {{ choice = [..] }}"
                )
            })?;
            draw.check().map_err(|reason| format!("random.over.{key}: {reason}"))?;
            Ok((key, draw))
        };
        values(&self.over).into_iter().map(draw).collect()
    }
}

impl Draw {
    fn check(&self) -> std::result::Result<(), String> {
        let holds = match self {
            Draw::Uniform([low, high]) => low < high && (high - low).is_finite(),
            Draw::LogUniform([low, high]) => 0.0 < *low && low < high && high.is_finite(),
            Draw::Integer([low, high]) => low <= high,
            Draw::Choice(values) => !values.is_empty(),
        };
        if holds {
            Ok(())
        } else {
            Err(match self {
                Draw::Choice(_) => "needs values to choose from".into(),
                Draw::LogUniform(ends) => format!("{ends:?} must be two positive numbers, the smaller first"),
                Draw::Uniform(ends) => format!("{ends:?} must be two numbers, the smaller first"),
                Draw::Integer(ends) => format!("{ends:?} must be two whole numbers, the smaller first"),
            })
        }
    }
}

/// Tables that are one value: how something is drawn.
const DRAWS: [&str; 5] = ["uniform", "log_uniform", "log-uniform", "integer", "choice"];

/// Returns the dotted keys and values of nested tables, so that `train.epochs = 3` and `"train.epochs" = 3` are the same. A
/// table with a text as `kind` or `name` is one value, as in a config.
pub(crate) fn values(table: &Table) -> Vec<(String, Value)> {
    let mut found = vec![];
    for (key, value) in table {
        match value {
            Value::Table(inner) if !is_value(inner) => {
                found.extend(values(inner).into_iter().map(|(rest, v)| (format!("{key}.{rest}"), v)));
            }
            _ => found.push((key.clone(), value.clone())),
        }
    }
    found
}

fn is_value(table: &Table) -> bool {
    let draw = table.len() == 1 && DRAWS.iter().any(|draw| table.contains_key(*draw));
    // A list of names, or how one is drawn, is an axis below the table.
    let is_named = ["kind", "name"].iter().any(|key| table.get(*key).is_some_and(Value::is_str));
    draw || table.is_empty() || is_named
}
