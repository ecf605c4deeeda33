//! Raw tables over raw tables: `[quick]`, `--set`, one network's own settings.

use toml::{Table, Value};

use crate::error::{Error, Result};
use crate::positions::Positions;

/// Keys that say what kind of thing a table describes: half of another kind's keys would not fit it.
const KINDS: [&str; 2] = ["kind", "name"];
/// Settings that one optimiser takes over from another.
const SHARED: [&str; 2] = ["lr", "weight_decay"];

/// Merges the values of `over` into `base`, key by key. A table of another kind replaces the one below; only the
/// settings of all optimisers stay.
pub(crate) fn merged(base: &Table, over: &Table) -> Table {
    let kind = KINDS.into_iter().find(|kind| base.contains_key(*kind));
    let other = kind.is_some_and(|kind| over.contains_key(kind) && over[kind] != base[kind]);
    let mut table = if other { shared(base) } else { base.clone() };
    for (key, value) in over {
        let value = match (table.get(key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => Value::Table(merged(below, above)),
            _ => value.clone(),
        };
        table.insert(key.clone(), value);
    }
    table
}

fn shared(table: &Table) -> Table {
    let entries = table.iter().filter(|(key, _)| SHARED.contains(&key.as_str()));
    entries.map(|(key, value)| (key.clone(), value.clone())).collect()
}

/// Lists dotted keys and values of nested tables. A table with a `kind` is one value, and so is a grid, whose keys
/// are dotted themselves.
pub(crate) fn leaves(table: &Table) -> Vec<(String, Value)> {
    let mut found = vec![];
    for (key, value) in table {
        match value {
            Value::Table(inner) if !inner.contains_key("kind") && key != "grid" => {
                found.extend(leaves(inner).into_iter().map(|(rest, v)| (format!("{key}.{rest}"), v)));
            }
            _ => found.push((key.clone(), value.clone())),
        }
    }
    found
}

/// Puts `value` at the dotted `key`; `place` is where it was written.
///
/// # Errors
/// A key that leads nowhere.
pub(crate) fn put(
    table: &mut Table,
    key: &str,
    value: Value,
    place: &str,
    positions: &mut Positions,
) -> Result<()> {
    let refuse = |message: String| Error::config(place, message);
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
    positions.put(key, place);
    Ok(())
}

/// Renames the keys of `[data]` that older versions wrote with a hyphen, such as `group-block`.
pub(crate) fn with_snake_keys(table: &mut Table) {
    let Some(Value::Table(data)) = table.get_mut("data") else { return };
    let rename = |table: &mut Table| {
        let old: Vec<String> = table.keys().filter(|key| key.contains('-')).cloned().collect();
        for key in old {
            if let Some(value) = table.remove(&key) {
                table.entry(key.replace('-', "_")).or_insert(value);
            }
        }
    };
    rename(data);
    if let Some(Value::Table(limits)) = data.get_mut("limits") {
        rename(limits);
    }
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

/// Reads a TOML value; text that is none is taken as a string.
pub(crate) fn parse_value(text: &str) -> Value {
    match toml::from_str::<Table>(&format!("value = {text}")) {
        Ok(mut table) if table.len() == 1 => {
            table.remove("value").unwrap_or_else(|| Value::String(text.into()))
        }
        _ => Value::String(text.into()),
    }
}
