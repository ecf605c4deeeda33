//! Reads class names and facts from `labels.json` or `<name>.classes.json`.

use crate::dataset::raw::{Names, SampleFacts};
use crate::dataset::source::Source;
use crate::dataset::targets::Quantity;
use crate::formats::clock::RATE_TOLERANCE;
use crate::formats::text::read_text;
use crate::layout::listing::last;
use crate::options::{Limits, ReadOptions};
use crate::tare::Tare;
use crate::targets::quantities::named_after;
use crate::{Error, Result};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Why a value is no tare.
const NO_TARE: &str = "not a text such as \"recording:18\"";

/// Name of the file that describes everything in its folder.
pub(crate) const NAMES: &str = "labels.json";

/// Reads class names and facts beside `data`: from `<name>.classes.json`, else from `labels.json`.
///
/// Either file is `["a", "b"]`, or an object with that list under `classes`; for labels `[N, k]`
/// a list of k such lists. An object may also give the source of the samples (`source`, a text: `simulated: fingertip`),
/// their axes (`layout`: `series`, `image`, ...), the names of their channels (`channels`, a list), `unit` (a text), `rate`
/// (a number, Hz), highest value (`full_scale`, a number in that unit) and readings at rest (`tare`, a text: `recording:18`). [`convert`](crate::write::convert) also writes `group_array` and `test_array`,
/// which name the arrays of groups and marks, and `origins`, which lists where each sample comes from. `values` names the
/// quantities of arrays that hold values beside the labels. Other keys are for people and not read.
///
/// Where `needs_names`, a file of facts alone is refused.
pub(crate) fn beside(
    data: &Path,
    needs_names: bool,
    limits: &Limits,
) -> Result<(Option<Names>, SampleFacts)> {
    let stem = data.file_stem().unwrap_or_default().to_string_lossy();
    let paths = [format!("{stem}.classes.json"), NAMES.into()].map(|name| data.with_file_name(name));
    let Some(path) = paths.iter().find(|path| path.exists()) else {
        return Ok((None, SampleFacts::default()));
    };
    let (columns, facts) = read(path, limits)?;
    if needs_names && columns.is_none() && facts.quantities.is_none() {
        return Err(Error::labels_form(&path.display().to_string(), "has no key \"classes\""));
    }
    Ok((columns.map(|columns| Names { file: last(path), columns, is_given: true }), facts))
}

/// Reads the file of names at one of `paths` for recordings whose classes have names already: the facts, and the order of
/// `classes` where it lists them. The names must be the same.
pub(crate) fn of_named(
    paths: &[PathBuf],
    classes: &[String],
    limits: &Limits,
) -> Result<(Option<Vec<usize>>, SampleFacts)> {
    let Some(path) = paths.iter().find(|path| path.is_file()) else {
        return Ok((None, SampleFacts::default()));
    };
    let (columns, facts) = read(path, limits)?;
    let Some(columns) = columns else { return Ok((None, facts)) };
    let listed = columns.concat();
    let order: Option<Vec<usize>> =
        listed.iter().map(|name| classes.iter().position(|class| class == name)).collect();
    match order.filter(|order| columns.len() == 1 && order.len() == classes.len()) {
        Some(order) => Ok((Some(order), facts)),
        None => {
            let why = format!("names the classes {}, but they are {}", listed.join(", "), classes.join(", "));
            Err(Error::labels_form(&path.display().to_string(), why))
        }
    }
}

/// Returns the quantities of arrays or columns of values, each of so many numbers a row: as the file of names says, or by
/// their own names.
pub(crate) fn quantities(facts: &SampleFacts, arrays: &[(&str, usize)]) -> Result<Vec<Quantity>> {
    if let Some(named) = facts.values_of(arrays.iter().map(|(name, _)| *name)) {
        return Ok(named);
    }
    let width: usize = arrays.iter().map(|(_, width)| width).sum();
    match &facts.quantities {
        None => Ok(named_after(arrays)),
        Some(named) if named.len() == width => Ok(named.clone()),
        Some(named) => {
            let names = arrays.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" with ");
            let why = format!("names {} quantities, but {names} has {width} columns", named.len());
            Err(Error::labels_form(&facts.file, why))
        }
    }
}

/// Reads class names per column of labels, if they are listed, and facts.
fn read(path: &Path, limits: &Limits) -> Result<(Option<Vec<Vec<String>>>, SampleFacts)> {
    let file = path.display().to_string();
    let form = |why: String| Error::labels_form(&file, why);
    let text = read_text(path, limits)?;
    let value: Value = serde_json::from_str(&text)
        .map_err(|e| form(format!("is not valid JSON ({})", e.to_string().to_lowercase())))?;
    let facts = facts(&value, &file)?;
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

/// Returns the facts that an object gives about the samples; a list gives none, and neither does `null`.
fn facts(value: &Value, file: &str) -> Result<SampleFacts> {
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
        let list = given.as_array().map(|list| list.iter().map(|text| text.as_str().map(String::from)));
        list.and_then(Iterator::collect).ok_or_else(|| refuse(key, given, "not a list of texts".into()))
    };
    let number = |(key, given): (&'static str, &Value)| {
        // Samples are f32.
        let number = given.as_f64().filter(|v| *v as f32 > 0.0 && (*v as f32).is_finite());
        number.ok_or_else(|| refuse(key, given, "not a number above 0".into()))
    };
    let depth = |(key, given): (&'static str, &Value)| {
        let bits = given.as_u64().filter(|bits| [8, 16].contains(bits));
        bits.map(|bits| bits as u8).ok_or_else(|| refuse(key, given, "neither 8 nor 16".into()))
    };
    let quantities = |(key, given): (&'static str, &Value)| {
        let read = serde_json::from_value::<Vec<Quantity>>(given.clone()).ok().filter(|all| !all.is_empty());
        let wanted = "not a list such as [{ \"name\": \"force\", \"unit\": \"N\" }]";
        read.ok_or_else(|| refuse(key, given, wanted.into()))
    };
    let values = |(key, given): (&'static str, &Value)| {
        let read = serde_json::from_value::<BTreeMap<String, Quantity>>(given.clone());
        let wanted = "not an object such as { \"force_n\": { \"name\": \"force\", \"unit\": \"N\" } }";
        read.map_err(|_| refuse(key, given, wanted.into()))
    };
    let layout = |(key, given): (&'static str, &Value)| {
        let known = || format!("none of {}", Layout::ALL.map(Layout::name).join(", "));
        let named = given.as_str().and_then(|name| name.parse::<Layout>().ok());
        named.ok_or_else(|| refuse(key, given, known()))
    };
    Ok(SampleFacts {
        file: file.into(),
        // Any other text says that the samples were recorded.
        source: given("source").map(text).transpose()?.and_then(|text| text.parse::<Source>().ok()),
        tare: given("tare")
            .map(|(key, given)| tare(given).ok_or_else(|| refuse(key, given, NO_TARE.into())))
            .transpose()?,
        layout: given("layout").map(layout).transpose()?,
        unit: given("unit").map(text).transpose()?,
        rate: given("rate").map(number).transpose()?,
        stamped: None,
        depth: given("depth").map(depth).transpose()?,
        full_scale: given("full_scale").map(number).transpose()?.map(|number| number as f32),
        group_array: given("group_array").map(text).transpose()?,
        test_array: given("test_array").map(text).transpose()?,
        origins: given("origins").map(texts).transpose()?,
        channels: given("channels").map(texts).transpose()?,
        quantities: given("quantities").map(quantities).transpose()?,
        values: given("values").map(values).transpose()?.unwrap_or_default(),
    })
}

/// Takes the rate (Hz) of the recordings' time stamps, where they have any.
///
/// # Errors
/// Another rate in the file of class names: one of the two is wrong, and nobody would see which. An option that says the rate
/// overrules both.
pub(crate) fn stamp(facts: &mut SampleFacts, rate: Option<f64>, options: &ReadOptions) -> Result<()> {
    let is_overruled = options.rate.is_some() || options.stamped.is_some();
    if let (Some(said), Some(found), false) = (facts.rate, rate, is_overruled)
        && (said - found).abs() > RATE_TOLERANCE * said
    {
        let why = format!(
            "says rate = {said} (Hz), and the time stamps of the recordings say {found} Hz; correct the rate, or give the column of \
             time its unit (time_ms), or say which rate holds (rate = {found} in [data], --rate)"
        );
        return Err(Error::file(&facts.file, why));
    }
    facts.stamped = rate.or(facts.stamped);
    Ok(())
}

/// Reads which readings of a recording are at rest.
fn tare(given: &Value) -> Option<Tare> {
    let tare = given.as_str()?.parse().ok()?;
    matches!(tare, Tare::Recording { .. } | Tare::Off).then_some(tare)
}

fn strings(list: &[Value], at: &str, file: &str) -> Result<Vec<String>> {
    let mut seen = HashMap::new();
    let mut names = Vec::with_capacity(list.len());
    for (i, value) in list.iter().enumerate() {
        let refuse = || Error::labels_form(file, format!("{at}[{i}] is {}, not a text", kind(value)));
        let name = value.as_str().ok_or_else(refuse)?;
        if let Some(first) = seen.insert(name, i) {
            let why = format!("classes {first} and {i} are both named {name:?}; give each its own name");
            return Err(Error::file(file, why));
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
