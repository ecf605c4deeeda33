//! From stored arrays to a data set: rows and channels to leave out, labels, groups.

use crate::check::duplicates::{contradictory, duplicate_sets, later_copies};
use crate::dataset::dataset::Dataset;
use crate::dataset::digest::digest;
use crate::dataset::labels::Labels;
use crate::dataset::one_hot::{Columns, settle, unsaid};
use crate::dataset::problems::{Faults, Problem};
use crate::dataset::raw::Raw;
use crate::dataset::rows::Rows;
use crate::dataset::source::Source;
use crate::dataset::targets::{Targets, Values};
use crate::dataset::validate::{
    channels, class_names, gaps, groups, labels, official, one_class, wrong_length,
};
use crate::length::lengths::Lengths;
use crate::length::one_length::{Samples, samples};
use crate::options::{Drop, ReadOptions};
use crate::{Error, Result};
use std::collections::HashMap;

/// A data set with everything that keeps it from being used.
#[derive(Debug)]
pub(crate) struct Checked {
    pub dataset: Dataset,
    pub problems: Vec<Problem>,
    /// What the columns of labels are.
    pub columns: Columns,
    /// Where recordings are unequal or a rule is given.
    pub lengths: Option<Lengths>,
    /// Readings of each recording along time, where a rule has made them one length.
    pub readings: Option<Vec<usize>>,
}

/// Builds the data set; faults of the content are collected, faults of the options end it.
pub(crate) fn assemble(mut raw: Raw, options: &ReadOptions) -> Result<Checked> {
    let kind = settle(&mut raw, options);
    let attribute = attribute(&raw, options)?;
    let channels = channels(&raw, options)?;
    let mut faults = Faults::default();
    if kind == Columns::Unsaid {
        faults.push(unsaid(&raw));
    }
    let values = raw.values.take();
    let (table, classes) = numbered(&raw, values.as_ref(), options, &mut faults)?;
    let groups = groups(&raw, options, &mut faults)?;
    let official = official(&raw, options, &mut faults);
    let keep = keep(&raw, &table, &classes, options, &mut faults);
    let kept: Vec<usize> = (0..keep.len()).filter(|row| keep[*row]).collect();
    if kept.is_empty() {
        return Err(Error::NoSamples { at: format!("{}: after drop", raw.file) });
    }
    let mut dropped: Vec<String> =
        (0..keep.len()).filter(|row| !keep[*row]).map(|row| raw.origins[row].clone()).collect();

    let mut of_values = Faults::default();
    let x = std::mem::take(&mut raw.x);
    let Samples { x, spec, windows, lengths, readings } =
        samples(&raw, x, &kept, channels.as_deref(), options, &mut of_values)?;
    let rows = Rows::new(&raw, &kept, windows);
    dropped.extend(rows.left_out(&kept).map(|row| raw.origins[row].clone()));
    if values.is_none() {
        gaps(&raw, &table, &rows.recordings, &classes, &mut faults);
    }
    faults.0.extend(of_values.0);

    let (group_name, groups) = grouped(groups, &rows);
    let targets = match &values {
        Some(values) => Targets::Values(Values::new(
            values.quantities().to_vec(),
            rows.recordings.iter().flat_map(|&row| values.of(&[row])).collect(),
        )),
        None => classes_of(&raw, &rows, &table, classes, attribute, &mut faults),
    };
    let mut dataset = Dataset {
        spec,
        source: source(&raw),
        digest: digest(&x, &targets, groups.as_deref()),
        targets,
        official: official.map(|test| rows.of(|row| test[row])),
        groups,
        group_name,
        units: Some(rows.units()),
        origins: rows.origins(&raw),
        dropped,
        row_hash: rows.hashes(),
        dtype: raw.dtype,
        name: raw.name,
        x,
    };
    dataset.learn_attributes(&options.attributes)?;
    Ok(Checked { dataset, problems: faults.0, columns: kind, lengths, readings })
}

/// Returns the column of labels that is learned, from 0; refuses one that is not there.
fn attribute(raw: &Raw, options: &ReadOptions) -> Result<usize> {
    let (attribute, columns) = (options.attribute.unwrap_or(0), raw.columns);
    if attribute >= columns {
        let (file, y, last) = (raw.file.clone(), raw.y_name.clone(), columns - 1);
        return Err(Error::Attribute { file, attribute, y, columns, last });
    }
    Ok(attribute)
}

/// Returns the labels of all samples as numbers, `[samples, columns]`, and the names of each column; of values those by
/// which copies are compared, without names.
fn numbered(
    raw: &Raw,
    values: Option<&Values>,
    options: &ReadOptions,
    faults: &mut Faults,
) -> Result<(Vec<u32>, Vec<Vec<String>>)> {
    // Labels for fewer samples may have many columns: too many for all samples.
    if (raw.x.len() as u64).saturating_mul(raw.columns as u64) > options.limits.max_samples {
        return Err(wrong_length(raw, &raw.y_name, raw.y.len() / raw.columns));
    }
    if let Some(values) = values {
        return Ok((check_values(raw, values, faults)?, vec![vec![]]));
    }
    let table = labels(raw, faults);
    let classes = class_names(raw, &table);
    Ok((table, classes))
}

/// Returns the classes of the samples in `rows`: those of the column `attribute`, and of all columns where there are
/// several.
fn classes_of(
    raw: &Raw,
    rows: &Rows,
    table: &[u32],
    classes: Vec<Vec<String>>,
    attribute: usize,
    faults: &mut Faults,
) -> Targets {
    let columns = raw.columns;
    let y: Vec<u32> = rows.of(|row| table[row * columns + attribute]);
    one_class(raw, &classes[attribute], &y, faults);
    let labels = Labels::of_classes(&classes[attribute], &y);
    let of_row = |row: &usize| table[row * columns..(row + 1) * columns].to_vec();
    let several =
        (columns > 1).then(|| Labels::numbered(classes, rows.recordings.iter().flat_map(of_row).collect()));
    Targets::Classes { labels, columns: several }
}

/// Checks values: one row of finite ones for each sample. Gives each sample the number of its values, equal ones the same,
/// by which copies are compared.
fn check_values(raw: &Raw, values: &Values, faults: &mut Faults) -> Result<Vec<u32>> {
    let (samples, width) = (raw.x.len(), values.quantities().len());
    let given = values.values().len() / width;
    if given != samples {
        return Err(wrong_length(raw, &raw.y_name, given));
    }
    let mut bad = None;
    for (i, value) in values.values().iter().enumerate().filter(|(_, value)| !value.is_finite()) {
        let sample = format!("{}: {}[{}]", raw.file, raw.y_name, i / width);
        faults.more(&mut bad, || Error::NotFinite { sample, index: vec![i % width], value: *value });
    }
    let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
    let number = |row: &[f32]| {
        let bits = row.iter().map(|value| value.to_bits()).collect();
        let next = numbers.len() as u32;
        *numbers.entry(bits).or_insert(next)
    };
    Ok(values.values().chunks_exact(width).map(number).collect())
}

/// What the groups are, and that of each sample. Windows without groups go by their recording: none is trained
/// on while another of it is tested.
fn grouped(groups: Option<(String, Vec<u32>)>, rows: &Rows) -> (Option<String>, Option<Vec<u32>>) {
    match groups {
        Some((name, values)) => (Some(name), Some(rows.of(|row| values[row]))),
        None if rows.is_cut() => (Some("recording".into()), Some(rows.of(|row| row as u32))),
        None => (None, None),
    }
}

/// Whether each row stays; copies with different labels are dropped, refused or left, as `options` say.
fn keep(
    raw: &Raw,
    table: &[u32],
    classes: &[Vec<String>],
    options: &ReadOptions,
    faults: &mut Faults,
) -> Vec<bool> {
    let rows: Vec<&[u32]> = table.chunks(raw.columns).collect();
    let sets = duplicate_sets(&raw.row_hash);
    let mut keep = vec![true; rows.len()];
    let torn = contradictory(&sets, &rows);
    if options.drop.contains(&Drop::Contradictory) {
        torn.iter().flatten().for_each(|row| keep[*row] = false);
    } else if options.deny_contradictory
        && let Some(set) = torn.first()
    {
        let second = set.iter().find(|row| rows[**row] != rows[set[0]]);
        #[expect(clippy::expect_used, reason = "what does not differ is no contradiction")]
        let second = *second.expect("another label");
        let labelled = |row: usize| {
            let attribute = options.attribute.unwrap_or(0);
            let label = rows[row][attribute];
            let name = classes[attribute].get(label as usize);
            let name = name.cloned().unwrap_or_else(|| label.to_string());
            format!("{} ({name})", raw.origins[row])
        };
        faults.push(Error::Contradiction {
            file: raw.file.clone(),
            first: labelled(set[0]),
            second: labelled(second),
            rows: torn.iter().map(Vec::len).sum(),
        });
    }
    if options.drop.contains(&Drop::Duplicates) {
        for row in later_copies(&sets, &rows) {
            keep[row] = false;
        }
    }
    keep
}

/// A scene that was saved and read again is still simulated; everything else is a recording.
fn source(raw: &Raw) -> Source {
    match &raw.facts.source {
        Some(scene) if scene.is_simulated() => Source::simulated(format!("{} ({})", scene.name, raw.name)),
        _ => Source::real(raw.name.clone()),
    }
}
