//! From raw TOML to values with types, with the key at which reading gave up.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// A value that could not be read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Misread {
    /// Dotted path of the key.
    pub key: String,
    /// What is wrong and what would do.
    pub message: String,
}

/// Reads the value at `key`.
///
/// # Errors
/// An unknown key or a value of the wrong type, by its own key.
pub(crate) fn read<T: DeserializeOwned>(key: &str, value: Value) -> Result<T, Misread> {
    attempt(value.clone()).map_err(|found| {
        let found = culprit::<T>(&value, found);
        let key = match (key, found.key.as_str()) {
            (_, "") => key.to_string(),
            ("", own) => own.to_string(),
            (key, own) => format!("{key}.{own}"),
        };
        Misread { key, message: found.message }
    })
}

fn attempt<T: DeserializeOwned>(value: Value) -> Result<T, Misread> {
    serde_path_to_error::deserialize(value).map_err(|e: serde_path_to_error::Error<toml::de::Error>| {
        let path = e.path().to_string();
        // `networks[0].name` is `networks.0.name` everywhere else.
        let key = path.replace('[', ".").replace(']', "").trim_start_matches('.').to_string();
        Misread { key, message: plain(&e.inner().message().trim().replace('\n', "; ")) }
    })
}

/// A message without the names of this program's types.
fn plain(message: &str) -> String {
    match message.split_once(", expected ") {
        Some((what, kind)) if kind.starts_with("internally tagged enum ") || kind.starts_with("struct ") => {
            format!("{what}, expected a table")
        }
        _ => message.into(),
    }
}

/// The key within the table where reading stopped: the paths of tables with a `kind` end at the table. The
/// culprit is the key without which another thing is wrong, or nothing.
fn culprit<T: DeserializeOwned>(whole: &Value, found: Misread) -> Misread {
    if let Some(unknown) =
        found.message.strip_prefix("unknown field `").and_then(|rest| rest.split('`').next())
    {
        let named = found.key == unknown || found.key.ends_with(&format!(".{unknown}"));
        let key = if named { found.key } else { join(&found.key, unknown) };
        return Misread { key, message: found.message };
    }
    let Some(table) = at(whole, &found.key).and_then(Value::as_table) else { return found };
    for name in table.keys().filter(|name| !["kind", "name"].contains(&name.as_str())) {
        let mut without = whole.clone();
        if let Some(Value::Table(table)) = at_mut(&mut without, &found.key) {
            table.remove(name);
        }
        let same = attempt::<T>(without).err().is_some_and(|other| other.message == found.message);
        if !same {
            return Misread { key: join(&found.key, name), message: found.message };
        }
    }
    found
}

fn join(key: &str, name: &str) -> String {
    if key.is_empty() { name.into() } else { format!("{key}.{name}") }
}

fn parts(key: &str) -> impl Iterator<Item = &str> {
    key.split('.').filter(|part| !part.is_empty())
}

/// The value at a dotted key.
pub(crate) fn at<'v>(value: &'v Value, key: &str) -> Option<&'v Value> {
    parts(key).try_fold(value, |value, part| match value {
        Value::Table(table) => table.get(part),
        Value::Array(items) => items.get(part.parse::<usize>().ok()?),
        _ => None,
    })
}

fn at_mut<'v>(value: &'v mut Value, key: &str) -> Option<&'v mut Value> {
    parts(key).try_fold(value, |value, part| match value {
        Value::Table(table) => table.get_mut(part),
        Value::Array(items) => items.get_mut(part.parse::<usize>().ok()?),
        _ => None,
    })
}

/// A value as the table that TOML writes for it.
pub(crate) fn table_of(value: &impl serde::Serialize) -> Table {
    #[expect(clippy::expect_used, reason = "settings are made of what TOML can write")]
    Table::try_from(value).expect("settings are a table")
}

/// A table as it would be written on one line.
pub(crate) fn one_line(table: &Table) -> String {
    let entries: Vec<String> = table.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    format!("{{ {} }}", entries.join(", "))
}
