//! From a TOML file, `[quick]` and command line overrides to a checked [`Config`].

use std::path::{Path, PathBuf};

use taxel_base::files::{read_bytes, read_text};
use taxel_learn::Problem;
use taxel_zoo::Registry;
use toml::{Table, Value};

use crate::config::Config;
use crate::data::{Origin, RecordingsOrigin, SCENE_KEYS, SCENE_PATHS, SceneOrigin};
use crate::error::{Error, Result};
use crate::merge::{leaves, parse_value, put, with_snake_keys};
use crate::network::Network;
use crate::positions::Positions;
use crate::read::table_of;

/// Changes of the command line to a config, in this order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Overrides {
    /// Whether the values of `[quick]` replace the full ones.
    pub quick: bool,
    /// `a.b=c`: a dotted key and a TOML value; text that is no TOML value is taken as a string. Elements of
    /// arrays go by their position: `networks.0.train.epochs=5`.
    pub set: Vec<String>,
    /// Recordings in place of the config's data source. A relative path starts at the working folder. The
    /// experiment then bears the name of the recordings, and nothing published stands beside them.
    pub data: Option<PathBuf>,
    /// A seed in place of the config's.
    pub seed: Option<u64>,
    /// Where `set` was written, for messages. Default `--set` on the command line.
    pub place: Option<String>,
}

/// A checked config that remembers where its values were written.
#[derive(Debug, Clone)]
pub struct Experiment {
    pub(crate) config: Config,
    pub(crate) positions: Positions,
    quick: bool,
}

/// Most bytes of a config.
const MAX_BYTES: u64 = 1 << 20;

impl Experiment {
    /// Reads the config file at `path`; networks are those of `registry`.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML, an unknown key, a value of the wrong type or
    /// outside its range: with file, line and what would do.
    pub fn load(path: &Path, overrides: &Overrides, registry: &Registry) -> Result<Self> {
        let text = read_text(path, MAX_BYTES).map_err(|e| Error::io(path, "read", e))?;
        let mut experiment = Self::parse(&text, &path.display().to_string(), overrides, registry)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        experiment.make_absolute(folder).map_err(|e| Error::io(path, "located", e))?;
        Ok(experiment)
    }

    /// Reads a config from `text`; `file` is its name in messages. Relative paths stay as they are.
    ///
    /// # Errors
    /// As [`Experiment::load`].
    pub fn parse(text: &str, file: &str, overrides: &Overrides, registry: &Registry) -> Result<Self> {
        let mut positions = Positions::of(text, file)?;
        let syntax = |e: toml::de::Error| Error::config(file, e.message());
        let mut table: Table = toml::from_str(text).map_err(syntax)?;
        with_snake_keys(&mut table);
        let quick = match table.remove("quick") {
            Some(Value::Table(quick)) => quick,
            Some(other) => return Err(Error::config(file, format!("quick = {other} must be a table"))),
            None => Table::new(),
        };
        if overrides.quick {
            if quick.is_empty() {
                return Err(Error::config(file, "has no [quick] table; leave --quick out"));
            }
            for (key, value) in leaves(&quick) {
                put(&mut table, &key, value, file, &mut positions)?;
                positions.copy(&format!("quick.{key}"), &key);
            }
        }
        for set in &overrides.set {
            let place = format!("{} {set}", overrides.place.as_deref().unwrap_or("--set"));
            let Some((key, value)) = set.split_once('=') else {
                return Err(Error::config(place, "must be key=value, such as train.epochs=20"));
            };
            put(&mut table, key.trim(), parse_value(value.trim()), &place, &mut positions)?;
        }
        if let Some(data) = &overrides.data {
            replace_data(&mut table, data, &mut positions)?;
        }
        if let Some(seed) = overrides.seed {
            put(&mut table, "seed", Value::Integer(seed as i64), "--seed", &mut positions)?;
        }
        let config = Config::resolve(&table).map_err(|misread| positions.misread(misread))?;
        config.check(registry).map_err(|problem| positions.refuse(problem))?;
        Ok(Experiment { config, positions, quick: overrides.quick })
    }

    /// Returns the resolved config.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Returns `runs/<name>`, with `-quick` behind it under `--quick`.
    pub fn default_out(&self) -> PathBuf {
        let suffix = if self.quick { "-quick" } else { "" };
        Path::new("runs").join(format!("{}{suffix}", self.config.name))
    }

    /// Returns the resolved config as TOML; reading it back gives the same experiment.
    pub fn to_toml(&self) -> String {
        // By way of a table: keys are sorted, and plain values come before tables.
        table_of(&self.config).to_string()
    }

    /// Returns the file or folder of recordings with environment variables filled in; `None` for a scene.
    ///
    /// # Errors
    /// A variable that is not set, named with the line that uses it.
    pub fn data_path(&self) -> Result<Option<PathBuf>> {
        match &self.config.data.origin {
            Origin::Scene(_) => Ok(None),
            Origin::Recordings(recordings) => self.recordings_path(recordings).map(Some),
        }
    }

    pub(crate) fn recordings_path(&self, recordings: &RecordingsOrigin) -> Result<PathBuf> {
        let fix = "give the data set itself with --data PATH";
        self.expanded("data.path", &recordings.path, fix)
    }

    /// Returns the checkpoint that a network starts from, likewise; `None` for fresh weights.
    ///
    /// # Errors
    /// As [`Experiment::data_path`].
    pub fn weights_path(&self, network: usize) -> Result<Option<PathBuf>> {
        let Some(path) = &self.config.networks[network].weights else { return Ok(None) };
        let fix = "write the file's own path in the config";
        self.expanded(&format!("networks.{network}.weights"), path, fix).map(Some)
    }

    /// Returns the file that holds a network, likewise, and the key that names it; `None` for one of the registry.
    ///
    /// # Errors
    /// As [`Experiment::data_path`].
    pub fn network_path(&self, network: usize) -> Result<Option<(&'static str, PathBuf)>> {
        let Some((key, path)) = self.config.networks[network].source() else { return Ok(None) };
        let fix = "write the file's own path in the config";
        let path = self.expanded(&format!("networks.{network}.{key}"), path, fix)?;
        Ok(Some((key, path)))
    }

    /// Returns the BLAKE3 of the files that networks come from or start from; empty where there are none.
    ///
    /// # Errors
    /// As [`Experiment::data_path`], and a file that cannot be read.
    pub fn weights_digest(&self) -> Result<String> {
        let mut hasher = blake3::Hasher::new();
        for network in 0..self.config.networks.len() {
            let of_network = self.network_path(network)?.map(|(_, path)| path);
            for path in of_network.into_iter().chain(self.weights_path(network)?) {
                let bytes = read_bytes(&path).map_err(|e| Error::io(&path, "read", e))?;
                hasher.update(blake3::hash(&bytes).as_bytes());
            }
        }
        let none = hasher.count() == 0;
        Ok(if none { String::new() } else { hasher.finalize().to_hex().to_string() })
    }

    /// Returns the settings of a scene, paths among them likewise.
    pub(crate) fn scene_settings(&self, scene: &SceneOrigin) -> Result<Table> {
        let mut set = scene.set.clone();
        for key in SCENE_PATHS {
            if let Some(Value::String(path)) = set.get_mut(key) {
                let fix = "write the folder's own path in the config";
                *path = self.expanded(&format!("data.set.{key}"), path, fix)?.display().to_string();
            }
        }
        Ok(set)
    }

    fn expanded(&self, key: &str, path: &str, fix: &str) -> Result<PathBuf> {
        let refuse = |reason: String| self.refuse(Problem::new(key, format!("{path:?}"), reason));
        let mut expanded = String::new();
        let mut rest = path;
        while let Some((before, after)) = rest.split_once("${") {
            let Some((name, tail)) = after.split_once('}') else {
                return Err(refuse("`${` has no `}`".into()));
            };
            let value = std::env::var(name).map_err(|_| {
                refuse(format!(
                    "environment variable {name} is not set; set it to the folder that holds the file \
                     (export {name}=/path/to/folder), or {fix}"
                ))
            })?;
            expanded.push_str(before);
            expanded.push_str(&value);
            rest = tail;
        }
        expanded.push_str(rest);
        Ok(PathBuf::from(expanded))
    }

    /// Makes paths that are relative to the config's folder absolute, so that a run folder opens from anywhere.
    fn make_absolute(&mut self, folder: &Path) -> std::io::Result<()> {
        // One spelling of the folder, so that a run can be resumed from anywhere.
        let folder = std::fs::canonicalize(if folder == Path::new("") { Path::new(".") } else { folder })?;
        let absolute = |path: &mut String| {
            // A path that begins with a variable has its folder from the machine.
            if !path.starts_with("${") && Path::new(path.as_str()).is_relative() {
                *path = folder.join(&*path).display().to_string();
            }
        };
        match &mut self.config.data.origin {
            Origin::Recordings(recordings) => absolute(&mut recordings.path),
            Origin::Scene(scene) => {
                for key in SCENE_PATHS {
                    if let Some(Value::String(path)) = scene.set.get_mut(key) {
                        absolute(path);
                    }
                }
            }
        }
        for Network { weights, onnx, file, .. } in &mut self.config.networks {
            [weights, onnx, file].into_iter().flatten().for_each(absolute);
        }
        Ok(())
    }

    /// Makes an error of a problem, with the place where the value was written.
    pub(crate) fn refuse(&self, problem: Problem) -> Error {
        self.positions.refuse(problem)
    }

    /// Adds to an error of learning the place of the value that it names.
    pub(crate) fn located(&self, error: taxel_learn::Error) -> Error {
        match error {
            taxel_learn::Error::Setting(problem) => self.refuse(problem),
            other => other.into(),
        }
    }
}

/// Puts the user's recordings in place of the config's data, with their name; title, expectation and published numbers
/// belong to other data and go.
fn replace_data(table: &mut Table, data: &Path, positions: &mut Positions) -> Result<()> {
    let place = format!("--data {}", data.display());
    if let Some(Value::Table(data)) = table.get_mut("data") {
        SCENE_KEYS.iter().for_each(|key| {
            data.remove(*key);
        });
    }
    let absolute = std::path::absolute(data).map_err(|e| Error::io(data, "located", e))?;
    put(table, "data.path", Value::String(absolute.display().to_string()), &place, positions)?;
    put(table, "name", Value::String(name_of(data)), &place, positions)?;
    for key in ["title", "expect"] {
        table.remove(key);
    }
    if let Some(Value::Array(networks)) = table.get_mut("networks") {
        for network in networks.iter_mut().filter_map(Value::as_table_mut) {
            network.remove("published");
        }
    }
    Ok(())
}

/// Returns the name of recordings as a file name: `my glove.npz` is `my-glove`.
pub fn name_of(data: &Path) -> String {
    let stem = data.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' };
    let name: String = stem.chars().map(plain).take(100).collect();
    match name.trim_start_matches('.') {
        "" => "data".into(),
        name => name.into(),
    }
}
