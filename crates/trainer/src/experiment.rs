//! From a TOML file, `[quick]` and command line overrides to a checked [`Config`].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::config::lines::{lines_of, place_of};
use crate::config::{Config, Problem};
use crate::error::{Error, Result};

/// What the command line changes in a config, in this order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Overrides {
    /// Whether the values of `[quick]` replace the full ones.
    pub quick: bool,
    /// `a.b=c`: a dotted key and a TOML value; what is no TOML value is taken as text. Elements of
    /// arrays go by their position: `networks.0.train.epochs=5`.
    pub set: Vec<String>,
    /// Recordings in place of the config's data source.
    pub data: Option<String>,
    /// A seed in place of the config's.
    pub seed: Option<u64>,
}

/// A checked config that remembers where its values were written.
#[derive(Debug, Clone)]
pub struct Experiment {
    config: Config,
    file: String,
    /// Dotted key to where its value was written.
    places: BTreeMap<String, String>,
    quick: bool,
}

impl Experiment {
    /// Reads the config file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML, an unknown key, a value of the wrong type or
    /// outside its range: with file, line and what would do.
    pub fn load(path: &Path, overrides: &Overrides) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::parse(&text, &path.display().to_string(), overrides)
    }

    /// Reads a config from `text`; `file` is its name in messages.
    ///
    /// # Errors
    /// As [`Experiment::load`].
    pub fn parse(text: &str, file: &str, overrides: &Overrides) -> Result<Self> {
        let located = |e: toml::de::Error| {
            let (place, line) = place_of(text, file, e.span());
            Error::Config { place, message: e.message().trim().replace('\n', "; "), line }
        };
        // Read as a config first: only the text knows lines and columns.
        let whole: Config = toml::from_str(text).map_err(located)?;
        let mut table: Table = toml::from_str(text).map_err(located)?;
        table.remove("quick");
        let mut places = lines_of(text, file).map_err(located)?;
        if overrides.quick {
            if whole.quick.is_empty() {
                return Err(Error::Config {
                    place: file.into(),
                    message: "has no [quick] table; leave --quick out".into(),
                    line: String::new(),
                });
            }
            for (key, value) in leaves(&whole.quick) {
                let place = places.get(&format!("quick.{key}")).cloned().unwrap_or_else(|| file.into());
                put(&mut table, &key, value, &place, &mut places)?;
            }
        }
        for set in &overrides.set {
            let place = format!("--set {set}");
            let Some((key, value)) = set.split_once('=') else {
                let message = "must be key=value, such as train.epochs=20".into();
                return Err(Error::Config { place, message, line: String::new() });
            };
            put(&mut table, key.trim(), parse_value(value.trim()), &place, &mut places)?;
        }
        if let Some(data) = &overrides.data {
            let place = format!("--data {data}");
            if let Some(Value::Table(data)) = table.get_mut("data") {
                for simulated in ["scene", "samples", "without", "set"] {
                    data.remove(simulated);
                }
            }
            put(&mut table, "data.path", Value::String(data.clone()), &place, &mut places)?;
        }
        let mut config = config_of(&table, file)?;
        if let Some(seed) = overrides.seed {
            config.seed = seed;
            places.insert("seed".into(), "--seed".into());
        }
        let mut experiment = Experiment { config, file: file.into(), places, quick: overrides.quick };
        experiment.config.check().map_err(|problem| experiment.refuse(problem))?;
        experiment.config.fill_defaults();
        Ok(experiment)
    }

    /// The resolved config.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// `runs/<name>`, with `-quick` behind it under `--quick`.
    pub fn default_out(&self) -> PathBuf {
        let suffix = if self.quick { "-quick" } else { "" };
        Path::new("runs").join(format!("{}{suffix}", self.config.name))
    }

    /// The resolved config as TOML; reading it back gives the same experiment.
    ///
    /// # Errors
    /// Never for a checked config; the serialiser's complaint otherwise.
    pub fn to_toml(&self) -> Result<String> {
        let refuse = |e: toml::ser::Error| Error::Config {
            place: self.file.clone(),
            message: e.to_string(),
            line: String::new(),
        };
        // By way of a table: keys are sorted, and plain values come before tables.
        let table = Table::try_from(&self.config).map_err(refuse)?;
        toml::to_string(&table).map_err(refuse)
    }

    /// The file or folder of recordings with environment variables filled in; `None` for a scene.
    ///
    /// # Errors
    /// A variable that is not set, named with the line that uses it.
    pub fn data_path(&self) -> Result<Option<PathBuf>> {
        let Some(path) = &self.config.data.path else { return Ok(None) };
        let way_out = "give the data set itself with --data PATH";
        self.expanded("data.path", path, way_out).map(Some)
    }

    /// The checkpoint that a network starts from, likewise; `None` for fresh weights.
    ///
    /// # Errors
    /// As [`Experiment::data_path`].
    pub fn weights_path(&self, network: usize) -> Result<Option<PathBuf>> {
        let Some(path) = &self.config.networks[network].weights else { return Ok(None) };
        let way_out = "write the file's own path in the config";
        self.expanded(&format!("networks.{network}.weights"), path, way_out).map(Some)
    }

    fn expanded(&self, key: &str, path: &str, way_out: &str) -> Result<PathBuf> {
        let refuse =
            |reason: String| self.refuse(Problem { key: key.into(), value: format!("{path:?}"), reason });
        let mut expanded = String::new();
        let mut rest = path;
        while let Some((before, after)) = rest.split_once("${") {
            let Some((name, tail)) = after.split_once('}') else {
                return Err(refuse("`${` has no `}`".into()));
            };
            let value = std::env::var(name).map_err(|_| {
                refuse(format!(
                    "environment variable {name} is not set; set it to the folder that holds the file \
                     (export {name}=/path/to/folder), or {way_out}"
                ))
            })?;
            expanded.push_str(before);
            expanded.push_str(&value);
            rest = tail;
        }
        expanded.push_str(rest);
        Ok(PathBuf::from(expanded))
    }

    /// A [`Error::Value`] with the place where the value was written.
    pub(crate) fn refuse(&self, problem: Problem) -> Error {
        let Problem { key, value, reason } = problem;
        let mut written = key.as_str();
        let place = loop {
            if let Some(place) = self.places.get(written) {
                break place.clone();
            }
            // A value that was left out belongs to its table.
            match written.rsplit_once('.') {
                Some((parent, _)) => written = parent,
                None => break self.file.clone(),
            }
        };
        Error::Value { place, key, value, reason }
    }
}

/// Settings of a network as the zoo reads them.
pub(crate) fn settings(set: &Table) -> taxel_zoo::Settings {
    match serde_json::to_value(set) {
        Ok(serde_json::Value::Object(settings)) => settings,
        _ => taxel_zoo::Settings::new(),
    }
}

fn config_of(table: &Table, place: &str) -> Result<Config> {
    Value::Table(table.clone()).try_into().map_err(|e: toml::de::Error| Error::Config {
        place: place.into(),
        message: e.to_string().trim().replace('\n', " "),
        line: String::new(),
    })
}

/// Dotted keys and values of nested tables. A table with a `kind` is one value: half of another
/// kind's keys would not fit it.
fn leaves(table: &Table) -> Vec<(String, Value)> {
    let mut found = vec![];
    for (key, value) in table {
        match value {
            // A grid has dotted keys of its own and is replaced whole, as a table of one kind is.
            Value::Table(inner) if !inner.contains_key("kind") && key != "grid" => {
                found.extend(leaves(inner).into_iter().map(|(rest, v)| (format!("{key}.{rest}"), v)));
            }
            _ => found.push((key.clone(), value.clone())),
        }
    }
    found
}

/// Puts `value` at the dotted `key` and makes sure that the config can still be read.
fn put(
    table: &mut Table,
    key: &str,
    value: Value,
    place: &str,
    places: &mut BTreeMap<String, String>,
) -> Result<()> {
    let refuse = |message: String| Error::Config { place: place.into(), message, line: String::new() };
    let mut parts: Vec<&str> = key.split('.').map(str::trim).collect();
    let last = parts.pop().unwrap_or_default();
    if last.is_empty() || parts.contains(&"") || last == "quick" && parts.is_empty() {
        return Err(refuse(format!("`{key}` is not a key, such as train.epochs")));
    }
    let mut root = Value::Table(std::mem::take(table));
    let mut at = &mut root;
    for part in parts {
        at = match at {
            Value::Table(inner) => inner.entry(part).or_insert_with(|| Value::Table(Table::new())),
            Value::Array(_) => element(at, part).map_err(&refuse)?,
            other => return Err(refuse(format!("`{part}` lies in {other}, which is no table"))),
        };
    }
    match at {
        Value::Table(inner) => {
            inner.insert(last.into(), value);
        }
        Value::Array(_) => *element(at, last).map_err(&refuse)? = value,
        other => return Err(refuse(format!("`{last}` lies in {other}, which is no table"))),
    }
    if let Value::Table(whole) = root {
        *table = whole;
    }
    let stale = format!("{key}.");
    places.retain(|known, _| !known.starts_with(&stale));
    places.insert(key.into(), place.into());
    config_of(table, place).map(|_| ())
}

fn element<'a>(array: &'a mut Value, index: &str) -> std::result::Result<&'a mut Value, String> {
    let Value::Array(items) = array else { return Err("no array".into()) };
    let count = items.len();
    index
        .parse::<usize>()
        .ok()
        .and_then(|i| items.get_mut(i))
        .ok_or_else(|| format!("`{index}` is not a position in an array of {count}, counted from 0"))
}

fn parse_value(text: &str) -> Value {
    match toml::from_str::<Table>(&format!("value = {text}")) {
        Ok(mut table) if table.len() == 1 => {
            table.remove("value").unwrap_or_else(|| Value::String(text.into()))
        }
        _ => Value::String(text.into()),
    }
}
