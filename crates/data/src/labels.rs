//! Class names from `labels.json` or `<name>.classes.json`.

use crate::options::Limits;
use crate::raw::Names;
use crate::{Error, Result};
use serde_json::Value;
use std::collections::HashMap;
use std::path::Path;

/// Looks for class names beside `npz`: first `<name>.classes.json`, then `labels.json`.
///
/// Either file is `["a", "b"]`, or an object with that list under `classes`; for labels `[N, k]`
/// a list of k such lists. A text under `source` says what the samples are
/// (`simulated: fingertip`), a number under `full_scale` how high its readings go. Other keys are for people and not read.
pub(crate) fn beside(npz: &Path, limits: &Limits) -> Result<Option<Names>> {
    let stem = npz.file_stem().unwrap_or_default().to_string_lossy();
    for name in [format!("{stem}.classes.json"), "labels.json".to_string()] {
        let path = npz.with_file_name(&name);
        if path.exists() {
            return read(&path, name, limits).map(Some);
        }
    }
    Ok(None)
}

fn read(path: &Path, name: String, limits: &Limits) -> Result<Names> {
    let file = path.display().to_string();
    let text = crate::folder::read_text(path, limits)?;
    let value: Value = serde_json::from_str(&text)
        .map_err(|e| Error::LabelsJson { file: file.clone(), why: e.to_string().to_lowercase() })?;
    let form = |why: String| Error::LabelsForm { file: file.clone(), why };
    let source = value.get("source").and_then(Value::as_str).map(String::from);
    let full_scale = match value.get("full_scale") {
        None | Some(Value::Null) => None,
        Some(given) => match given.as_f64().filter(|v| v.is_finite() && *v > 0.0) {
            Some(number) => Some(number),
            None => return Err(form(format!("full_scale is {given}, not a number above 0"))),
        },
    };
    let named = |columns| Names { file: name, columns, source, full_scale };
    let list = match &value {
        Value::Object(map) => map.get("classes").ok_or_else(|| form("has no key \"classes\"".into()))?,
        other => other,
    };
    let list = list.as_array().ok_or_else(|| form(format!("classes is {}, not a list", kind(list))))?;
    if list.is_empty() {
        return Err(form("classes is empty".into()));
    }
    if list.iter().all(Value::is_array) {
        let nested = |(column, names): (usize, &Value)| {
            let names = names.as_array().map(Vec::as_slice).unwrap_or_default();
            if names.is_empty() {
                return Err(form(format!("classes[{column}] is empty")));
            }
            strings(names, &format!("classes[{column}]"), &file)
        };
        let columns = list.iter().enumerate().map(nested).collect::<Result<_>>()?;
        return Ok(named(columns));
    }
    Ok(named(vec![strings(list, "classes", &file)?]))
}

fn strings(list: &[Value], at: &str, file: &str) -> Result<Vec<String>> {
    let mut seen = HashMap::new();
    let mut names = Vec::with_capacity(list.len());
    for (i, value) in list.iter().enumerate() {
        let name = value.as_str().ok_or_else(|| Error::LabelsForm {
            file: file.into(),
            why: format!("{at}[{i}] is {}, not a text", kind(value)),
        })?;
        if let Some(first) = seen.insert(name, i) {
            return Err(Error::ClassNamedTwice { file: file.into(), name: name.into(), first, second: i });
        }
        names.push(name.to_string());
    }
    Ok(names)
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}
