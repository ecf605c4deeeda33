//! Any data set that can be read, as one plain form: arrays in a `.npz` and a file of names beside it.

use crate::assemble::{Checked, assemble};
use crate::dataset::Dataset;
use crate::labels::Labels;
use crate::length::{Length, Longer, Padding};
use crate::load::open;
use crate::options::Options;
use crate::reading_of::time_axis;
use crate::write::Npz;
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};
use serde_json::{Map, Value, json};
use std::io;
use std::path::{Path, PathBuf};
use taxel_files::write_whole;

/// Names of the arrays that are written beside groups.
const ARRAYS: [&str; 3] = ["x", "y", "test"];

/// What [`convert`] has written.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    /// The arrays, and the names beside them.
    pub files: [PathBuf; 2],
    /// Shape of `x`, samples first.
    pub shape: Vec<usize>,
    /// Shortest and longest recording, where shorter ones are filled up with NaN.
    pub padded: Option<[usize; 2]>,
}

/// Reads the data set at `path` and writes it to `output`, a `.npz`, with `<output>.classes.json` beside it:
/// [`load`](crate::load) reads it back with the same digest.
///
/// - `x` `[N, ...]` f32; recordings of unequal length end in NaN, unless [`Options::length`] says otherwise.
/// - `y` `[N]`, or `[N, k]` of attributes, whose names are not kept; groups `[N]` under their own name; `test`
///   `[N]`, 1 for the samples that the authors test on.
/// - in JSON what the axes are, class names, unit, rate (Hz), full scale, whether samples were simulated, which
///   arrays hold groups and marks, and where each sample came from.
///
/// # Errors
///
/// As [`load`](crate::load), but for unequal lengths; another ending of `output` than `.npz`; what the system says.
pub fn convert(path: &Path, options: &Options, output: &Path) -> Result<Converted> {
    if output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("npz")) {
        let (file, why) = (output.display().to_string(), "is the name of a .npz file to write");
        return Err(Error::Option { file, option: "output", why });
    }
    let (mut data, readings) = read(path, options)?;
    let axis = data.reading.layout.time_axis();
    let padded = match (readings, axis) {
        (Some(readings), Some(axis)) => {
            blank(&mut data.x, axis, &readings);
            Some([readings.iter().min(), readings.iter().max()].map(|n| n.copied().unwrap_or(0)))
        }
        _ => None,
    };
    let group = group_array(&data);
    let names = output.with_extension("classes.json");
    let text = format!("{:#}\n", facts(&data, group.as_deref()));
    let failed =
        |file: &Path, e: &io::Error| Error::Write { file: file.display().to_string(), why: e.to_string() };
    let arrays = arrays(&data, group.as_deref()).map_err(|e| failed(output, &e))?;
    write_whole(&names, text.as_bytes()).map_err(|e| failed(&names, &e))?;
    write_whole(output, &arrays).map_err(|e| failed(output, &e))?;
    Ok(Converted { files: [output.into(), names], shape: data.x.shape().to_vec(), padded })
}

/// The data set; unequal recordings without a rule are filled up to the longest, and the readings of each said.
fn read(path: &Path, options: &Options) -> Result<(Dataset, Option<Vec<usize>>)> {
    let mut raw = open(path, options)?;
    let mut options = options.clone();
    let time = time_axis(options.layout, raw.facts.layout, raw.format, &raw.dtype, raw.x.sample_shape());
    let mut is_filled = false;
    if let (Some(axis), None) = (time, options.length) {
        raw.x = std::mem::take(&mut raw.x).without_padding(axis);
        is_filled = raw.x.is_unequal();
        let to = raw.x.sample_shape()[axis];
        let fill = Length::Pad { to, value: Padding::Zero, longer: Longer::Refuse };
        options.length = is_filled.then_some(fill);
    }
    let Checked { dataset, problems, readings, .. } = assemble(raw, &options)?;
    match problems.into_iter().next() {
        Some(problem) => Err(problem.first),
        None => Ok((dataset, readings.filter(|_| is_filled))),
    }
}

/// What follows the readings of a recording becomes NaN.
fn blank(x: &mut ArrayD<f32>, axis: usize, readings: &[usize]) {
    for (mut sample, readings) in x.axis_iter_mut(Axis(0)).zip(readings) {
        sample.slice_axis_mut(Axis(axis), (*readings..).into()).fill(f32::NAN);
    }
}

/// The array that holds the groups.
fn group_array(data: &Dataset) -> Option<String> {
    data.groups.as_ref()?;
    let own = data.group_name.clone().filter(|name| !ARRAYS.contains(&name.as_str()));
    Some(own.unwrap_or_else(|| "group".into()))
}

/// All columns of labels, row by row.
fn labels(data: &Dataset) -> &Labels {
    data.columns.as_ref().unwrap_or(&data.labels)
}

fn arrays(data: &Dataset, group: Option<&str>) -> io::Result<Vec<u8>> {
    let mut npz = Npz::default();
    #[expect(clippy::expect_used, reason = "readers give C order")]
    npz.add("x", data.x.shape(), data.x.as_slice().expect("C order"))?;
    let labels = labels(data);
    let shape = match labels.attributes().len() {
        1 => vec![data.len()],
        columns => vec![data.len(), columns],
    };
    let values: Vec<i64> = labels.values().iter().copied().map(i64::from).collect();
    npz.add("y", &shape, &values)?;
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

/// What [`names_file`](crate::names_file) reads.
fn facts(data: &Dataset, group: Option<&str>) -> Value {
    let classes: Vec<&Vec<String>> = labels(data).attributes().iter().map(|own| &own.classes).collect();
    let reading = &data.reading;
    let simulated = data.source.is_simulated().then(|| data.source.to_string());
    // As JSON has it: an f32 in as many digits as it needs.
    let full_scale = reading.full_scale.and_then(|full| full.to_string().parse::<f64>().ok());
    let said = [
        ("source", simulated.map(Value::from)),
        ("layout", Some(reading.layout.name().into())),
        ("unit", reading.unit.clone().map(Value::from)),
        ("rate", reading.rate.map(Value::from)),
        ("full_scale", full_scale.map(Value::from)),
        ("group_array", group.map(Value::from)),
        ("test_array", data.official.as_ref().map(|_| "test".into())),
        ("origins", Some(json!(data.origins))),
    ];
    let classes = match classes.as_slice() {
        [one] => json!(one),
        all => json!(all),
    };
    let mut map = Map::from_iter([("classes".to_string(), classes)]);
    map.extend(said.into_iter().filter_map(|(key, value)| Some((key.to_string(), value?))));
    Value::Object(map)
}
