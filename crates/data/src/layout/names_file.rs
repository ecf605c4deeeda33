//! Class names and facts from `labels.json` or `<name>.classes.json`.

use crate::dataset::raw::{Facts, Names};
use crate::dataset::source::Source;
use crate::dataset::targets::Quantity;
use crate::formats::text::read_text;
use crate::options::Limits;
use crate::{Error, Result};
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Name of the file that speaks of everything in its folder.
pub(crate) const NAMES: &str = "labels.json";

/// Looks for class names beside `npz`: first `<name>.classes.json`, then `labels.json`.
///
/// Either file is `["a", "b"]`, or an object with that list under `classes`; for labels `[N, k]`
/// a list of k such lists. An object may also say where the samples come from (`source`, a text:
/// `simulated: fingertip`), what their axes are (`layout`: `series`, `image`, ...), their `unit` (a text),
/// `rate` (a number, Hz), and how high readings go (`full_scale`, a number in that unit). As
/// [`convert`](crate::write::convert) writes them, `group_array` and `test_array` name the arrays of groups and of marks,
/// and `origins` lists where each sample comes from. Other keys are for people and not read.
pub(crate) fn beside(npz: &Path, limits: &Limits) -> Result<(Option<Names>, Facts)> {
    #[expect(clippy::expect_used, reason = "the archive was opened: it is a file")]
    let stem = npz.file_stem().expect("a file has a name").to_string_lossy();
    for name in [format!("{stem}.classes.json"), NAMES.to_string()] {
        let path = npz.with_file_name(&name);
        if path.exists() {
            let (columns, facts) = read(&path, limits)?;
            let file = path.display().to_string();
            let names = columns.map(|columns| Names { file: name, columns, is_told: true });
            if names.is_none() && facts.quantities.is_none() {
                return Err(Error::LabelsForm { file, why: "has no key \"classes\"".into() });
            }
            return Ok((names, facts));
        }
    }
    Ok((None, Facts::default()))
}

/// The same where classes need no list: a file of facts alone will do.
pub(crate) fn lenient(data: &Path, limits: &Limits) -> Result<(Option<Names>, Facts)> {
    let stem = data.file_stem().unwrap_or_default().to_string_lossy();
    let paths = [format!("{stem}.classes.json"), NAMES.into()].map(|name| data.with_file_name(name));
    let Some(path) = paths.iter().find(|path| path.is_file()) else { return Ok((None, Facts::default())) };
    let (columns, facts) = read(path, limits)?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((columns.map(|columns| Names { file, columns, is_told: true }), facts))
}

/// What the file of names at one of `paths` says of recordings whose classes have names already: the facts, and
/// the order of `classes` where it lists them; they must be the same names then.
pub(crate) fn of_named(
    paths: &[PathBuf],
    classes: &[String],
    limits: &Limits,
) -> Result<(Option<Vec<usize>>, Facts)> {
    let Some(path) = paths.iter().find(|path| path.is_file()) else { return Ok((None, Facts::default())) };
    let (columns, facts) = read(path, limits)?;
    let Some(columns) = columns else { return Ok((None, facts)) };
    let listed = columns.concat();
    let order: Option<Vec<usize>> =
        listed.iter().map(|name| classes.iter().position(|class| class == name)).collect();
    match order.filter(|order| columns.len() == 1 && order.len() == classes.len()) {
        Some(order) => Ok((Some(order), facts)),
        None => {
            let why = format!("names the classes {}, but they are {}", listed.join(", "), classes.join(", "));
            Err(Error::LabelsForm { file: path.display().to_string(), why })
        }
    }
}

/// Class names per column of labels, if they are listed, and facts.
fn read(path: &Path, limits: &Limits) -> Result<(Option<Vec<Vec<String>>>, Facts)> {
    let file = path.display().to_string();
    let text = read_text(path, limits)?;
    let value: Value = serde_json::from_str(&text)
        .map_err(|e| Error::LabelsJson { file: file.clone(), why: e.to_string().to_lowercase() })?;
    let facts = facts(&value, &file)?;
    let form = |why: String| Error::LabelsForm { file: file.clone(), why };
    let list = match &value {
        Value::Object(map) => match map.get("classes") {
            Some(list) => list,
            None => return Ok((None, facts)),
        },
        other => other,
    };
    let list = list.as_array().ok_or_else(|| form(format!("classes is {}, not a list", kind(list))))?;
    if list.is_empty() {
        return Err(form("classes is empty".into()));
    }
    let nested: Option<Vec<&Vec<Value>>> = list.iter().map(Value::as_array).collect();
    let Some(nested) = nested else {
        return Ok((Some(vec![strings(list, "classes", &file)?]), facts));
    };
    let column = |(column, names): (usize, &Vec<Value>)| match names.as_slice() {
        [] => Err(form(format!("classes[{column}] is empty"))),
        names => strings(names, &format!("classes[{column}]"), &file),
    };
    Ok((Some(nested.into_iter().enumerate().map(column).collect::<Result<_>>()?), facts))
}

/// What an object says of the readings; of a list, nothing. `null` says nothing.
fn facts(value: &Value, file: &str) -> Result<Facts> {
    let given = |key: &'static str| value.get(key).filter(|given| !given.is_null()).map(|given| (key, given));
    let refuse = |key: &'static str, given: &Value, wanted: String| Error::Fact {
        at: file.into(),
        key,
        value: given.to_string(),
        wanted,
    };
    let text = |(key, given): (&'static str, &Value)| {
        given.as_str().map(String::from).ok_or_else(|| refuse(key, given, "not a text".into()))
    };
    let texts = |(key, given): (&'static str, &Value)| {
        let list = given.as_array().map(|list| list.iter().map(|own| own.as_str().map(String::from)));
        list.and_then(Iterator::collect).ok_or_else(|| refuse(key, given, "not a list of texts".into()))
    };
    let number = |(key, given): (&'static str, &Value)| {
        // A reading is an f32.
        let number = given.as_f64().filter(|v| *v as f32 > 0.0 && (*v as f32).is_finite());
        number.ok_or_else(|| refuse(key, given, "not a number above 0".into()))
    };
    let quantities = |(key, given): (&'static str, &Value)| {
        let read = serde_json::from_value::<Vec<Quantity>>(given.clone()).ok().filter(|all| !all.is_empty());
        let wanted = "not a list such as [{ \"name\": \"force\", \"unit\": \"N\" }]";
        read.ok_or_else(|| refuse(key, given, wanted.into()))
    };
    let layout = |(key, given): (&'static str, &Value)| {
        let known = || format!("none of {}", Layout::ALL.map(Layout::name).join(", "));
        let named = given.as_str().and_then(|name| name.parse::<Layout>().ok());
        named.ok_or_else(|| refuse(key, given, known()))
    };
    Ok(Facts {
        file: file.into(),
        // Whoever says anything else recorded the samples.
        source: given("source").map(text).transpose()?.and_then(|text| text.parse::<Source>().ok()),
        layout: given("layout").map(layout).transpose()?,
        unit: given("unit").map(text).transpose()?,
        rate: given("rate").map(number).transpose()?,
        stamped: None,
        full_scale: given("full_scale").map(number).transpose()?.map(|number| number as f32),
        group_array: given("group_array").map(text).transpose()?,
        test_array: given("test_array").map(text).transpose()?,
        origins: given("origins").map(texts).transpose()?,
        quantities: given("quantities").map(quantities).transpose()?,
    })
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
