//! Writes a data set as an `.npz` with its names beside it, to be read back equal.

use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use taxel_base::files::write_whole;

use crate::dataset::dataset::Dataset;
use crate::dataset::labels::Labels;
use crate::write::archive::Npz;

/// Names of the arrays that are written beside groups.
const ARRAYS: [&str; 3] = ["x", "y", "test"];

impl Dataset {
    /// Writes the samples as the `.npz` at `path`, with `<name>.classes.json` beside it: [`load`](crate::load) reads it back
    /// with the same digest.
    ///
    /// - `x` `[N, ...]` f32.
    /// - `y` `[N]`, or `[N, k]` of attributes, whose names are not kept; groups `[N]` under their own name; `test`
    ///   `[N]`, 1 for the samples that the authors test on.
    /// - in JSON the axes, class names, names of channels, unit, rate (Hz), full scale, source of simulated samples, names of the arrays of
    ///   groups and marks, and origin of each sample.
    ///
    /// Rest values and the table or topics that samples were cut from are not kept.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        write(self, path).map(|_| ()).map_err(|(_, error)| error)
    }
}

/// Writes the arrays and the names beside them. Returns both files, or the one that cannot be written.
pub(crate) fn write(data: &Dataset, path: &Path) -> Result<[PathBuf; 2], (PathBuf, io::Error)> {
    let group = group_array(data);
    let names = path.with_extension("classes.json");
    let text = format!("{:#}\n", facts(data, group.as_deref()));
    let arrays = arrays(data, group.as_deref()).map_err(|error| (path.into(), error))?;
    write_whole(&names, text.as_bytes()).map_err(|error| (names.clone(), error))?;
    write_whole(path, &arrays).map_err(|error| (path.into(), error))?;
    Ok([path.into(), names])
}

/// Returns the name of the array of groups.
fn group_array(data: &Dataset) -> Option<String> {
    data.groups.as_ref()?;
    let name = data.group_name.clone().filter(|name| !ARRAYS.contains(&name.as_str()));
    Some(name.unwrap_or_else(|| "group".into()))
}

/// Returns all columns of labels; none where the targets are values.
fn labels(data: &Dataset) -> Option<&Labels> {
    data.targets.columns().or(data.targets.labels())
}

fn arrays(data: &Dataset, group: Option<&str>) -> io::Result<Vec<u8>> {
    let mut npz = Npz::default();
    let x = data.x.as_standard_layout();
    npz.add("x", x.shape(), x.as_slice().unwrap_or_default())?;
    let shape = |columns: usize| if columns == 1 { vec![data.len()] } else { vec![data.len(), columns] };
    if let Some(labels) = labels(data) {
        let values: Vec<i64> = labels.values().iter().copied().map(i64::from).collect();
        npz.add("y", &shape(labels.attributes().len()), &values)?;
    }
    if let Some(values) = data.targets.values() {
        npz.add("y", &shape(values.quantities().len()), values.values())?;
    }
    if let (Some(name), Some(groups)) = (group, &data.groups) {
        let groups: Vec<i64> = groups.iter().copied().map(i64::from).collect();
        npz.add(name, &[data.len()], &groups)?;
    }
    if let Some(test) = &data.official {
        let marks: Vec<i64> = test.iter().copied().map(i64::from).collect();
        npz.add("test", &[data.len()], &marks)?;
    }
    npz.finish()
}

/// Returns the facts that [`names_file`](crate::layout::names_file) reads.
fn facts(data: &Dataset, group: Option<&str>) -> Value {
    let spec = &data.spec;
    let simulated = data.source.is_simulated().then(|| data.source.to_string());
    // An f32 in as many digits as it needs, which JSON writes as f64.
    let full_scale = spec.full_scale.and_then(|full| full.to_string().parse::<f64>().ok());
    let said = [
        ("source", simulated.map(Value::from)),
        ("layout", Some(spec.layout.name().into())),
        ("channels", (!spec.channel_names.is_empty()).then(|| json!(spec.channel_names))),
        ("unit", spec.unit.clone().map(Value::from)),
        ("rate", spec.rate.map(Value::from)),
        ("full_scale", full_scale.map(Value::from)),
        ("depth", spec.depth.map(Value::from)),
        ("group_array", group.map(Value::from)),
        ("test_array", data.official.as_ref().map(|_| "test".into())),
        ("origins", Some(json!(data.origins))),
    ];
    let (key, names) = names(data);
    let mut map = Map::from_iter([(key.to_string(), names)]);
    map.extend(said.into_iter().filter_map(|(key, value)| Some((key.to_string(), value?))));
    Value::Object(map)
}

/// Returns the names of classes, of each column's levels, or of quantities, with the key that they go by.
fn names(data: &Dataset) -> (&'static str, Value) {
    let Some(labels) = labels(data) else { return ("quantities", json!(data.task().quantities())) };
    let names: Vec<&Vec<String>> = labels.attributes().iter().map(|attribute| &attribute.classes).collect();
    match names.as_slice() {
        [one] => ("classes", json!(one)),
        all => ("classes", json!(all)),
    }
}
