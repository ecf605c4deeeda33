//! The folder that is recorded into: class folders, sessions in them, and `labels.json`.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use taxel::base::FileError;
use taxel::base::files::write_whole;

use super::files::{FileKind, read_back};
use super::take::Taken;

/// The file of facts.
const FACTS: &str = "labels.json";
/// Its key with what is recorded, which only this command reads.
const RECORDED: &str = "recorded";
/// Share by which the rate of a sensor may differ from that of the set: by its time stamps, and by arrivals.
const AGREES: (f64, f64) = (0.02, 0.1);

/// Facts that all recordings of a set have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct SetFacts {
    pub channels: Vec<String>,
    /// Time steps per second (Hz).
    pub rate: f64,
    pub unit: Option<String>,
    pub full_scale: Option<f64>,
    /// Time steps of a recording, those at rest included.
    pub rows: usize,
    /// The first of them that are at rest; 0 for none.
    pub rest: usize,
    pub is_stamped: bool,
    pub files: FileKind,
}

/// A recording that was kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Its path below the folder.
    pub file: String,
    pub label: String,
}

/// A folder with recordings.
pub struct RecordedSet {
    folder: PathBuf,
    session: String,
    facts: Option<SetFacts>,
    /// `labels.json`, with what others wrote into it.
    json: Map<String, Value>,
    /// Recordings of each label, also of labels that are not recorded now.
    counts: BTreeMap<String, usize>,
    /// Those of this call, the last one last.
    pub kept: Vec<Kept>,
    /// Keeps a second process out, until it is dropped.
    lock: Option<File>,
}

impl RecordedSet {
    /// Opens a folder, or one that is to be made.
    ///
    /// # Errors
    /// A folder that holds something else, or that another process records into.
    pub fn open(folder: &Path, session: Option<&str>) -> Result<Self, FileError> {
        let refuse = |why: String| FileError::new(folder, why);
        if folder.exists() && !folder.is_dir() {
            return Err(refuse("is a file, and recordings need a folder; give another path".into()));
        }
        let lock = locked(folder)?;
        let path = folder.join(FACTS);
        let json = if path.exists() { read_facts(&path)? } else { Map::new() };
        let facts = facts_of(&json, &path)?;
        let (counts, sessions) =
            if folder.exists() { recordings(folder)? } else { (BTreeMap::new(), vec![]) };
        if facts.is_none() && folder.exists() && entries(folder)?.iter().any(|name| !name.starts_with('.')) {
            return Err(refuse(
                "holds something that `taxel record` did not make; record into another folder".into(),
            ));
        }
        let session = match session {
            Some(name) => name.to_string(),
            None => (1..)
                .map(|n| format!("session-{n}"))
                .find(|name| !sessions.contains(name))
                .unwrap_or_default(),
        };
        Ok(RecordedSet { folder: folder.into(), session, facts, json, counts, kept: vec![], lock })
    }

    /// Returns what the recordings so far have in common; none where nothing is recorded.
    pub fn facts(&self) -> Option<&SetFacts> {
        self.facts.as_ref()
    }

    /// Lists the labels that have recordings, by name.
    pub fn labels(&self) -> Vec<String> {
        self.counts.keys().cloned().collect()
    }

    /// Returns where a recording lies.
    pub fn path_of(&self, kept: &Kept) -> PathBuf {
        self.folder.join(&kept.file)
    }

    pub fn session(&self) -> &str {
        &self.session
    }

    /// Begins another session.
    pub fn next_session(&mut self) {
        let number = |name: &str| name.strip_prefix("session-").and_then(|n| n.parse::<u32>().ok());
        let taken = recordings(&self.folder).map(|(_, sessions)| sessions).unwrap_or_default();
        let last = taken.iter().filter_map(|name| number(name)).max().unwrap_or(0);
        self.session = format!("session-{}", last.max(number(&self.session).unwrap_or(0)) + 1);
    }

    /// Counts the recordings of each label.
    pub fn counts(&self, labels: &[String]) -> Vec<usize> {
        labels.iter().map(|label| self.counts.get(label).copied().unwrap_or(0)).collect()
    }

    /// Takes the facts of a sensor: those of the set, or the first.
    ///
    /// # Errors
    /// A sensor, or options, that do not agree with the recordings that are there.
    pub fn agree(&mut self, wanted: SetFacts) -> Result<&SetFacts, FileError> {
        let file = self.folder.join(FACTS);
        if let Some(known) = &self.facts {
            let differs = |what: &str, there: String, here: String| {
                let how = "record into another folder, or as before";
                FileError::new(&file, format!("{what} is {there}, and {here} here; {how}"))
            };
            let share = if wanted.is_stamped && known.is_stamped { AGREES.0 } else { AGREES.1 };
            if (wanted.rate / known.rate - 1.0).abs() > share {
                return Err(differs("rate", format!("{} Hz", known.rate), format!("{} Hz", wanted.rate)));
            }
            if wanted.rest != known.rest {
                let words = |rest: usize| {
                    if rest == 0 { "no rest".into() } else { format!("{rest} readings at rest") }
                };
                return Err(differs("tare", words(known.rest), words(wanted.rest)));
            }
            if wanted.rows != known.rows {
                let seconds = |facts: &SetFacts| (facts.rows - facts.rest) as f64 / known.rate;
                return Err(differs(
                    "the length of a recording",
                    format!("{:.3} s", seconds(known)),
                    format!("{:.3} s", seconds(&wanted)),
                ));
            }
            if wanted.files != known.files {
                let [there, here] = [known, &wanted].map(|facts| facts.files.ending().to_string());
                return Err(differs("the kind of files", there, here));
            }
            if wanted.is_stamped != known.is_stamped {
                let words = |is_stamped| if is_stamped { "by time stamps" } else { "counted" };
                return Err(differs("time", words(known.is_stamped).into(), words(wanted.is_stamped).into()));
            }
            for (what, there, here) in [
                ("unit", known.unit.clone(), wanted.unit.clone()),
                (
                    "full_scale",
                    known.full_scale.map(|v| v.to_string()),
                    wanted.full_scale.map(|v| v.to_string()),
                ),
            ] {
                if here.is_some() && here != there {
                    return Err(differs(what, there.unwrap_or("not known".into()), here.unwrap_or_default()));
                }
            }
        }
        Ok(self.facts.get_or_insert(wanted))
    }

    /// Writes a recording, and reads it back.
    ///
    /// # Errors
    /// A file that cannot be written, or that is not read as it was recorded.
    pub fn keep(&mut self, label: &str, taken: &Taken, rest: &[f32], began: f64) -> Result<Kept, FileError> {
        let Some(facts) = self.facts.clone() else {
            return Err(FileError::new(&self.folder, "has no facts"));
        };
        let folder = self.folder.join(label).join(&self.session);
        fs::create_dir_all(&folder).map_err(|e| FileError::io(&folder, "created", &e))?;
        if self.lock.is_none() {
            self.lock = locked(&self.folder)?;
        }
        let name = format!("{:03}.{}", next_number(&folder), facts.files.ending());
        let file = format!("{label}/{}/{name}", self.session);
        let path = folder.join(name);
        let bytes = facts.files.bytes(&facts.channels, taken, began);
        let bytes = bytes.map_err(|why| FileError::new(&path, why))?;
        if self.kept.is_empty() {
            self.write_facts(&facts)?;
        }
        write_whole(&path, &bytes).map_err(|e| FileError::io(&path, "written", &e))?;
        if let Err(why) = read_back(&path, &facts.channels, taken) {
            let _ = fs::remove_file(&path);
            return Err(FileError::new(&path, format!("is not read as it was recorded: {why}")));
        }
        let kept = Kept { file: file.clone(), label: label.into() };
        self.kept.push(kept.clone());
        *self.counts.entry(label.into()).or_default() += 1;
        let list = self.recorded("recordings");
        list.push(json!({
            "file": file, "label": label, "began": (1e3 * began).round() / 1e3, "rest": rest,
            "missing": taken.missing, "evened": taken.is_evened,
        }));
        self.write_facts(&facts)?;
        Ok(kept)
    }

    /// Throws the last recording of this call away.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn throw_away(&mut self) -> Result<Option<Kept>, FileError> {
        let (Some(last), Some(facts)) = (self.kept.pop(), self.facts.clone()) else { return Ok(None) };
        let path = self.folder.join(&last.file);
        fs::remove_file(&path).map_err(|e| FileError::io(&path, "removed", &e))?;
        // A folder of a class without files is refused by readers; one with files stays.
        for folder in path.ancestors().skip(1).take(2) {
            let _ = fs::remove_dir(folder);
        }
        if let Some(count) = self.counts.get_mut(&last.label) {
            *count = count.saturating_sub(1);
        }
        self.recorded("recordings").retain(|entry| entry["file"] != last.file.as_str());
        self.write_facts(&facts)?;
        Ok(Some(last))
    }

    fn recorded(&mut self, key: &str) -> &mut Vec<Value> {
        let recorded = self.json.entry(RECORDED).or_insert_with(|| json!({}));
        if !recorded[key].is_array() {
            recorded[key] = json!([]);
        }
        match &mut recorded[key] {
            Value::Array(list) => list,
            _ => unreachable!("it is a list by now"),
        }
    }

    fn write_facts(&mut self, facts: &SetFacts) -> Result<(), FileError> {
        let path = self.folder.join(FACTS);
        let mut set = |key: &str, value: Value| self.json.insert(key.into(), value);
        set("layout", json!("series"));
        set("channels", json!(facts.channels));
        set("rate", json!(facts.rate));
        if let Some(unit) = &facts.unit {
            set("unit", json!(unit));
        }
        if let Some(full_scale) = facts.full_scale {
            set("full_scale", json!(full_scale));
        }
        if facts.rest > 0 {
            set("tare", json!(format!("recording:{}", facts.rest)));
        }
        self.recorded("recordings");
        let recorded = &mut self.json[RECORDED];
        recorded["time"] = json!(if facts.is_stamped { "stamps" } else { "counted" });
        recorded["readings"] = json!(facts.rows);
        recorded["rest"] = json!(facts.rest);
        recorded["files"] = json!(facts.files.ending());
        let text = serde_json::to_string_pretty(&self.json).unwrap_or_default() + "\n";
        write_whole(&path, text.as_bytes()).map_err(|e| FileError::io(&path, "written", &e))
    }
}

/// Locks a folder, where it is there and its system can lock folders.
fn locked(folder: &Path) -> Result<Option<File>, FileError> {
    let lock = File::open(folder).ok();
    if let Some(Err(fs::TryLockError::WouldBlock)) = lock.as_ref().map(File::try_lock) {
        let why = "another taxel records into it; wait for it, or record into another folder";
        return Err(FileError::new(folder, why));
    }
    Ok(lock)
}

fn read_facts(path: &Path) -> Result<Map<String, Value>, FileError> {
    let text = taxel::base::files::read_text(path, 1 << 26).map_err(|e| FileError::io(path, "read", &e))?;
    serde_json::from_str(&text)
        .map_err(|e| FileError::new(path, format!("is not the object that `taxel record` writes: {e}")))
}

/// Returns the facts that `labels.json` says; none where it is not of this command.
fn facts_of(json: &Map<String, Value>, path: &Path) -> Result<Option<SetFacts>, FileError> {
    let Some(recorded) = json.get(RECORDED) else { return Ok(None) };
    let read = || {
        let channels = json.get("channels")?.as_array()?.iter().map(|name| name.as_str().map(String::from));
        let number = |key: &str| recorded.get(key)?.as_u64().and_then(|n| usize::try_from(n).ok());
        Some(SetFacts {
            channels: channels.collect::<Option<_>>()?,
            rate: json.get("rate")?.as_f64().filter(|rate| *rate > 0.0)?,
            unit: json.get("unit").and_then(Value::as_str).map(String::from),
            full_scale: json.get("full_scale").and_then(Value::as_f64),
            rows: number("readings")?,
            rest: number("rest")?,
            is_stamped: recorded.get("time")? == "stamps",
            // Of an earlier version, which wrote nothing else.
            files: recorded
                .get("files")
                .map_or(Some(FileKind::Csv), |name| FileKind::named(name.as_str()?))?,
        })
    };
    let why = "lacks facts that `taxel record` wrote (channels, rate, recorded.readings, recorded.rest, recorded.time); put \
               them back, or record into another folder";
    read().map(Some).ok_or_else(|| FileError::new(path, why))
}

/// Counts the recordings of each class folder, and lists the sessions.
fn recordings(folder: &Path) -> Result<(BTreeMap<String, usize>, Vec<String>), FileError> {
    let (mut counts, mut sessions) = (BTreeMap::new(), vec![]);
    for class in folders(folder)? {
        for session in folders(&folder.join(&class))? {
            let place = folder.join(&class).join(&session);
            let count = entries(&place)?.into_iter().filter(|name| number(name).is_some()).count();
            *counts.entry(class.clone()).or_insert(0) += count;
            if !sessions.contains(&session) {
                sessions.push(session);
            }
        }
    }
    Ok((counts, sessions))
}

fn folders(folder: &Path) -> Result<Vec<String>, FileError> {
    let mut names = entries(folder)?;
    names.retain(|name| !name.starts_with('.') && folder.join(name).is_dir());
    Ok(names)
}

fn entries(folder: &Path) -> Result<Vec<String>, FileError> {
    let read = fs::read_dir(folder).map_err(|e| FileError::io(folder, "read", &e))?;
    Ok(read.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
}

/// Returns the number after that of the last recording in a folder.
fn next_number(folder: &Path) -> u32 {
    let names = entries(folder).unwrap_or_default();
    names.iter().filter_map(|name| number(name)).max().unwrap_or(0) + 1
}

/// Returns the number of a recording by the name of its file.
fn number(name: &str) -> Option<u32> {
    let (number, ending) = name.rsplit_once('.')?;
    FileKind::named(ending)?;
    number.parse().ok()
}
