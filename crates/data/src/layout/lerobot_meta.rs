//! Reads what `meta/` of a set of LeRobot says: the features with their shapes and names, and the names of tasks.

use crate::dataset::raw::{Names, Raw};
use crate::formats::parquet_file::ParquetFile;
use crate::formats::text::read_text;
use crate::options::{Limits, ReadOptions};
use crate::{Error, Result};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Names of the column of names in `meta/tasks.parquet`: an index of pandas, with a name of its own or without.
const TASK: [&str; 2] = ["task", "__index_level_0__"];

/// A feature of `meta/info.json`.
struct Feature {
    name: String,
    dtype: String,
    shape: Vec<usize>,
    /// One for each number, where there are as many.
    names: Vec<String>,
}

/// The features of a set, as `meta/info.json` describes them.
pub(crate) struct Features {
    file: String,
    all: Vec<Feature>,
}

impl Features {
    /// Reads them; none where the file lists none.
    pub fn read(root: &Path, limits: &Limits) -> Result<Self> {
        let path = root.join("meta/info.json");
        let info: Value = serde_json::from_str(&read_text(&path, limits)?)
            .map_err(|e| Error::file(&path, format!("is no JSON ({e})")))?;
        let features = info["features"].as_object().into_iter().flatten();
        let all = features.map(|(name, about)| Feature::of(name, about)).collect();
        Ok(Self { file: path.display().to_string(), all })
    }

    /// Returns the columns of `header` that a feature of this name has; none where it is no feature.
    pub fn columns<'h>(&self, name: &str, header: &'h [String]) -> Option<Vec<&'h String>> {
        let is_known = self.all.iter().any(|feature| feature.name == name);
        let columns: Vec<&String> = header.iter().filter(|column| suffix(column, name).is_some()).collect();
        (is_known || !columns.is_empty()).then_some(columns)
    }

    /// Refuses a feature of numbers below `observed` that the data do not hold as numbers, and lists those that are none.
    /// Time and indices among them are no channels.
    pub fn account(
        &self,
        raw: &mut Raw,
        observed: &str,
        header: &[String],
        options: &ReadOptions,
    ) -> Result<()> {
        for Feature { name, dtype, shape, .. } in &self.all {
            let mut columns = header.iter().filter(|column| suffix(column, name).is_some());
            let is_read = columns.any(|column| !raw.others.contains(column));
            let has_a_role = [options.group.as_ref(), options.test.as_ref()].contains(&Some(name))
                || options.y_names().contains(name);
            let is_left_out = has_a_role || options.table.ignore.contains(name);
            if is_read || is_left_out || !name.starts_with(observed) {
                continue;
            }
            let is_number = ["float", "int", "uint", "bool"].iter().any(|kind| dtype.starts_with(kind));
            if !is_number {
                raw.ignored.push(format!("feature {name} ({dtype})"));
            } else if options.table.columns.is_empty() && options.table.ignore.is_empty() {
                return Err(Error::file(
                    &self.file,
                    format!(
                        "feature {name} ({dtype} {shape:?}) is in no column of numbers of the data; write it there, or leave \
                         it out with table.ignore = [{name:?}]"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Returns the names of channels by their feature: `observation.state.elbow`, or by its place in it, `observation.tactile[0,1]`.
    pub fn name_channels(&self, raw: &mut Raw, header: &[String]) {
        let Some(table) = &raw.table else { return };
        raw.channel_names = table.columns.iter().map(|column| self.channel_name(column, header)).collect();
    }

    /// Returns the last part of the name of a channel: `elbow` of `observation.state.elbow`.
    pub fn meaning(&self, column: &str, header: &[String]) -> String {
        let name = self.channel_name(column, header);
        name.rsplit('.').next().unwrap_or(&name).into()
    }

    fn channel_name(&self, column: &str, header: &[String]) -> String {
        let known = self.all.iter().find(|feature| suffix(column, &feature.name).is_some());
        let Some(feature) = known else { return column.into() };
        let columns: Vec<&String> =
            header.iter().filter(|other| suffix(other, &feature.name).is_some()).collect();
        let Some(at) = columns.iter().position(|other| *other == column) else { return column.into() };
        let name = &feature.name;
        if columns.len() == 1 && feature.names.len() != 1 {
            return name.clone();
        }
        if let Some(named) = feature.names.get(at).filter(|_| feature.names.len() == columns.len()) {
            return format!("{name}.{named}");
        }
        if feature.shape.iter().product::<usize>() != columns.len() {
            return column.into();
        }
        let mut left = at;
        let mut place: Vec<String> = vec![];
        for axis in feature.shape.iter().rev() {
            place.insert(0, (left % axis).to_string());
            left /= axis;
        }
        format!("{name}[{}]", place.join(","))
    }
}

/// Returns what follows the name of a feature in that of a column: nothing, or `.0.1`; none of another feature.
fn suffix<'c>(column: &'c str, feature: &str) -> Option<&'c str> {
    column.strip_prefix(feature).filter(|rest| {
        let mut places = rest.split('.');
        places.next() == Some("") && places.all(|place| !place.is_empty() && place.parse::<usize>().is_ok())
            || rest.starts_with('.') && !rest[1..].contains('.')
    })
}

impl Feature {
    fn of(name: &str, about: &Value) -> Self {
        let axis = |axis: &Value| axis.as_u64().and_then(|axis| usize::try_from(axis).ok());
        let shape = about["shape"].as_array().map(|all| all.iter().filter_map(axis).collect());
        let mut names = vec![];
        texts(&about["names"], &mut names);
        let is_twice = names.iter().enumerate().any(|(at, name)| names[..at].contains(name));
        if is_twice {
            names.clear();
        }
        let dtype = about["dtype"].as_str().unwrap_or_default().into();
        Self { name: name.into(), dtype, shape: shape.unwrap_or_default(), names }
    }
}

/// Gathers the texts of a list, of lists in it, or of the one list of an object: `{"motors": ["elbow"]}`.
fn texts(value: &Value, out: &mut Vec<String>) {
    match value {
        Value::String(text) => out.push(text.clone()),
        Value::Array(all) => all.iter().for_each(|one| texts(one, out)),
        Value::Object(all) if all.len() == 1 => all.values().for_each(|one| texts(one, out)),
        _ => {}
    }
}

/// Gives the classes, which are numbers of tasks, the names that `meta/tasks.jsonl` or `meta/tasks.parquet` has.
pub(crate) fn name_tasks(raw: &mut Raw, root: &Path, limits: &Limits) -> Result<()> {
    let Some(names) = &mut raw.names else { return Ok(()) };
    let Some((file, tasks)) = tasks(root, limits)? else {
        raw.read_as.push(
            "classes are the numbers of tasks: there is no meta/tasks.jsonl or meta/tasks.parquet".into(),
        );
        return Ok(());
    };
    let path = root.join(file);
    let mut named: Vec<String> = vec![];
    for number in names.columns.iter().flatten() {
        let name = number.parse().ok().and_then(|number: i64| tasks.get(&number));
        let name = name.ok_or_else(|| Error::file(&path, format!("does not name task {number}; add it")))?;
        if named.contains(name) {
            return Err(Error::file(
                &path,
                format!("two tasks are named {name:?}; give each a name of its own"),
            ));
        }
        named.push(name.clone());
    }
    *names = Names { file: file.into(), columns: vec![named], is_given: true };
    Ok(())
}

/// Reads the names of the tasks by their numbers, and the file that says them.
fn tasks(root: &Path, limits: &Limits) -> Result<Option<(&'static str, BTreeMap<i64, String>)>> {
    let (lines, table) = ("meta/tasks.jsonl", "meta/tasks.parquet");
    let path = root.join(lines);
    if !path.is_file() {
        let path = root.join(table);
        return if path.is_file() { Ok(Some((table, task_table(&path, limits)?))) } else { Ok(None) };
    }
    let mut tasks = BTreeMap::new();
    for (at, line) in
        read_text(&path, limits)?.lines().enumerate().filter(|(_, line)| !line.trim().is_empty())
    {
        let refuse = |why: &str| Error::file(&path, format!("line {}: {why}", at + 1));
        let task: Value = serde_json::from_str(line).map_err(|e| refuse(&format!("is no JSON ({e})")))?;
        let (Some(number), Some(name)) = (task["task_index"].as_i64(), task["task"].as_str()) else {
            return Err(refuse(
                "does not say task_index and task; write {\"task_index\": 0, \"task\": \"press\"}",
            ));
        };
        if tasks.insert(number, name.into()).is_some() {
            return Err(refuse(&format!("names task {number} a second time; leave one out")));
        }
    }
    Ok(Some((lines, tasks)))
}

fn task_table(path: &Path, limits: &Limits) -> Result<BTreeMap<i64, String>> {
    let file = ParquetFile::open(path, limits)?;
    let header = file.header();
    let place = |name: &str| header.iter().position(|column| column == name);
    let number = place("task_index");
    let name = TASK.iter().find_map(|name| place(name)).or_else(|| {
        // An index of another name is the one column that is left.
        let mut others = (0..header.len()).filter(|at| Some(*at) != number);
        others.next().filter(|_| others.next().is_none())
    });
    let (Some(number), Some(name)) = (number, name) else {
        let why = format!("has no columns task_index and task; it has {}", header.join(", "));
        return Err(Error::file(path, why));
    };
    let mut tasks = BTreeMap::new();
    file.rows(|row, record| {
        let text = |at: usize| record.get(at).unwrap_or_default();
        let index: i64 = text(number).parse().map_err(|_| {
            Error::file(path, format!("row {row}: task_index is {:?}, no whole number", text(number)))
        })?;
        if tasks.insert(index, text(name).to_string()).is_some() {
            return Err(Error::file(
                path,
                format!("row {row}: names task {index} a second time; leave one out"),
            ));
        }
        Ok(true)
    })?;
    Ok(tasks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_belongs_to_the_feature_that_it_begins_with() {
        let of = |column: &'static str| suffix(column, "observation.state");
        assert_eq!((of("observation.state"), of("observation.state.0")), (Some(""), Some(".0")));
        assert_eq!((of("observation.state.1.12"), of("observation.state.x")), (Some(".1.12"), Some(".x")));
        assert_eq!(
            (of("observation.state_2.0"), of("observation.states"), of("action.0")),
            (None, None, None)
        );
        assert_eq!(of("observation.state.left.0"), None, "another feature");
    }
}
