//! Where in a config file a key stands.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// Every dotted key of `text` with `file:line`; elements of arrays go by their position.
pub(crate) fn lines_of(text: &str, file: &str) -> Result<BTreeMap<String, String>, toml::de::Error> {
    let mut places = BTreeMap::new();
    let table = DeTable::parse(text)?;
    let mut place = |key: &str, at: usize| {
        // The first place of a table is its header, later ones add keys to it.
        places.entry(key.to_string()).or_insert_with(|| format!("{file}:{}", line(text, at).0));
    };
    walk(table.get_ref(), "", &mut place);
    Ok(places)
}

fn walk(table: &DeTable<'_>, prefix: &str, place: &mut dyn FnMut(&str, usize)) {
    for (key, value) in table.iter() {
        let path = match prefix {
            "" => key.get_ref().to_string(),
            _ => format!("{prefix}.{}", key.get_ref()),
        };
        place(&path, key.span().start);
        walk_value(value.get_ref(), &path, place);
    }
}

fn walk_value(value: &DeValue<'_>, path: &str, place: &mut dyn FnMut(&str, usize)) {
    match value {
        DeValue::Table(table) => walk(table, path, place),
        DeValue::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                let path = format!("{path}.{i}");
                place(&path, item.span().start);
                walk_value(item.get_ref(), &path, place);
            }
        }
        _ => {}
    }
}

/// Line from 1, column from 1, and the text of the line that holds byte `at`.
fn line(text: &str, at: usize) -> (usize, usize, &str) {
    let at = text.floor_char_boundary(at.min(text.len()));
    let before = &text[..at];
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    let end = text[at..].find('\n').map_or(text.len(), |i| at + i);
    (before.matches('\n').count() + 1, before[start..].chars().count() + 1, &text[start..end])
}

/// `file:line:column` of a byte range, and the line itself for display below a message.
pub(crate) fn place_of(text: &str, file: &str, span: Option<Range<usize>>) -> (String, String) {
    let Some(span) = span else { return (file.into(), String::new()) };
    let (number, column, content) = line(text, span.start);
    let content = content.trim_end();
    let shown = if content.is_empty() { String::new() } else { format!("\n  {number} | {content}") };
    (format!("{file}:{number}:{column}"), shown)
}
