//! From raw TOML to values with types, with the key at which reading gave up.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::misread::{Misread, joined};
use crate::value_reader::ValueReader;

/// Reads the value at `key`.
///
/// # Errors
/// An unknown key or a value of the wrong type, by its full key.
pub(crate) fn read<T: DeserializeOwned>(key: &str, value: Value) -> Result<T, Misread> {
    T::deserialize(ValueReader(value.clone())).map_err(|found| culprit::<T>(&value, found).below(key))
}

/// Returns the error with the key within the table where reading stopped. The paths of tables with a `kind` end at the
/// table: the culprit is then the key without which another thing is wrong, or nothing.
fn culprit<T: DeserializeOwned>(whole: &Value, found: Misread) -> Misread {
    if let Some(unknown) = &found.unknown {
        return Misread { key: joined(&found.key, unknown), ..found };
    }
    let Some(table) = at(whole, &found.key).and_then(Value::as_table) else { return found };
    for name in table.keys().filter(|name| !["kind", "name"].contains(&name.as_str())) {
        let mut without = whole.clone();
        if let Some(Value::Table(table)) = at_mut(&mut without, &found.key) {
            table.remove(name);
        }
        let same =
            T::deserialize(ValueReader(without)).err().is_some_and(|other| other.message == found.message);
        if !same {
            return Misread { key: joined(&found.key, name), ..found };
        }
    }
    found
}

fn parts(key: &str) -> impl Iterator<Item = &str> {
    key.split('.').filter(|part| !part.is_empty())
}

/// Finds the value at a dotted key.
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

/// Returns a value as the table that TOML writes for it.
pub(crate) fn table_of(value: &impl serde::Serialize) -> Table {
    #[expect(clippy::expect_used, reason = "settings are made of what TOML can write")]
    Table::try_from(value).expect("settings are a table")
}

/// Returns a table as it is written on one line.
pub(crate) fn one_line(table: &Table) -> String {
    let entries: Vec<String> = table.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    format!("{{ {} }}", entries.join(", "))
}
