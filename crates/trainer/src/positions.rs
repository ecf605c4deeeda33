//! Where in a config file, or on the command line, a value was written.

use std::collections::BTreeMap;
use std::ops::Range;

use taxel_learn::Problem;
use toml::de::{DeTable, DeValue};

use crate::error::Error;
use crate::misread::Misread;

/// Where the values of a config were written.
#[derive(Debug, Clone)]
pub(crate) struct Positions {
    file: String,
    /// By dotted key; elements of arrays go by their position.
    known: BTreeMap<String, Position>,
}

#[derive(Debug, Clone)]
struct Position {
    /// `file:line`, or the option on the command line.
    at: String,
    /// Columns of the key and of the value, and the line itself.
    inside: Option<(usize, usize, String)>,
}

impl Positions {
    /// Finds every key of `text`.
    ///
    /// # Errors
    /// A text that is no TOML.
    pub fn of(text: &str, file: &str) -> Result<Self, Error> {
        let table = DeTable::parse(text).map_err(|e| {
            let (place, line) = place_of(text, file, e.span());
            Error::Config { place, message: e.message().trim().replace('\n', "; "), line }
        })?;
        let mut positions = Positions { file: file.into(), known: BTreeMap::new() };
        positions.walk(text, table.get_ref(), "");
        Ok(positions)
    }

    fn walk(&mut self, text: &str, table: &DeTable<'_>, prefix: &str) {
        for (key, value) in table.iter() {
            let path = match prefix {
                "" => key.get_ref().to_string(),
                _ => format!("{prefix}.{}", key.get_ref()),
            };
            self.add(text, &path, key.span().start, value.span().start);
            self.walk_value(text, value.get_ref(), &path);
        }
    }

    fn walk_value(&mut self, text: &str, value: &DeValue<'_>, path: &str) {
        match value {
            DeValue::Table(table) => self.walk(text, table, path),
            DeValue::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    let (path, at) = (format!("{path}.{i}"), item.span().start);
                    self.add(text, &path, at, at);
                    self.walk_value(text, item.get_ref(), &path);
                }
            }
            _ => {}
        }
    }

    /// Adds a place. The first place of a table is its header, later ones add keys to it.
    fn add(&mut self, text: &str, path: &str, key: usize, value: usize) {
        let (number, key, shown) = line(text, key);
        let inside = Some((key, line(text, value).1, shown.to_string()));
        let place = Position { at: format!("{}:{number}", self.file), inside };
        self.known.entry(path.into()).or_insert(place);
    }

    /// Notes that `key` was written somewhere else.
    pub fn put(&mut self, key: &str, at: &str) {
        let below = format!("{key}.");
        self.known.retain(|known, _| known != key && !known.starts_with(&below));
        self.known.insert(key.into(), Position { at: at.into(), inside: None });
    }

    /// Makes the positions below `from` count for `key` too.
    pub fn copy(&mut self, from: &str, key: &str) {
        let (below, prefix) = (format!("{from}."), format!("{key}."));
        let copied = self.known.iter().filter(|(known, _)| *known == from || known.starts_with(&below));
        let copied: Vec<(String, Position)> = copied
            .map(|(known, place)| (known.replacen(&below, &prefix, 1).replace(from, key), place.clone()))
            .collect();
        self.put(key, &self.file.clone());
        self.known.extend(copied);
    }

    /// Returns the place of `key`, and whether the key itself stands there: a value that was left out belongs to its
    /// table, one that a network takes over to `[train]`.
    fn nearest(&self, key: &str) -> Option<(&Position, bool)> {
        let written = self.written(key);
        let network = key.strip_prefix("networks.").and_then(|rest| rest.split_once('.'));
        let shared =
            network.and_then(|(_, key)| key.starts_with("train.").then(|| self.written(key)).flatten());
        match (written, shared) {
            (Some((_, missing)), Some((place, less))) if less < missing => Some((place, less == 0)),
            (written, _) => written.map(|(place, missing)| (place, missing == 0)),
        }
    }

    /// Returns the place of `key` or of the nearest table around it, and how many parts of the key are missing there.
    fn written(&self, key: &str) -> Option<(&Position, usize)> {
        let (mut written, mut missing) = (key, 0);
        loop {
            if let Some(place) = self.known.get(written) {
                return Some((place, missing));
            }
            (written, missing) = (written.rsplit_once('.')?.0, missing + 1);
        }
    }

    /// Makes an error of a value out of range, with the place where it was written.
    pub fn refuse(&self, problem: Problem) -> Error {
        let Problem { key, value, reason } = problem;
        let place = self.nearest(&key).map_or(self.file.clone(), |(place, _)| place.at.clone());
        Error::Value { place, key, value, reason }
    }

    /// Makes an error of a value that could not be read, likewise.
    pub fn misread(&self, misread: Misread) -> Error {
        let Misread { key, message, unknown, .. } = misread;
        let Some((place, exact)) = self.nearest(&key) else { return Error::config(&self.file, message) };
        let number = place.at.rsplit(':').next().unwrap_or_default();
        match (&place.inside, exact) {
            (Some((in_key, in_value, shown)), true) => {
                // An unknown key is shown itself, a wrong value where it stands.
                let column = if unknown.is_some() { in_key } else { in_value };
                let line = format!("\n  {number} | {}", shown.trim_end());
                Error::Config { place: format!("{}:{column}", place.at), message, line }
            }
            // The key stands on the command line.
            (None, true) => Error::config(&place.at, message),
            _ => Error::config(&place.at, format!("{key}: {message}")),
        }
    }
}

/// Returns line from 1, column from 1, and the text of the line that holds byte `at`.
fn line(text: &str, at: usize) -> (usize, usize, &str) {
    let at = text.floor_char_boundary(at.min(text.len()));
    let before = &text[..at];
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    let end = text[at..].find('\n').map_or(text.len(), |i| at + i);
    (before.matches('\n').count() + 1, before[start..].chars().count() + 1, &text[start..end])
}

/// Returns `file:line:column` of a byte range, and the line itself for display below a message.
fn place_of(text: &str, file: &str, span: Option<Range<usize>>) -> (String, String) {
    let Some(span) = span else { return (file.into(), String::new()) };
    let (number, column, content) = line(text, span.start);
    let content = content.trim_end();
    let shown = if content.is_empty() { String::new() } else { format!("\n  {number} | {content}") };
    (format!("{file}:{number}:{column}"), shown)
}
