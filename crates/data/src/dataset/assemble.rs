//! Makes a data set of stored arrays: leaves out rows and channels, checks labels and groups.

use crate::check::duplicates::{contradictory, duplicate_sets, later_copies};
use crate::dataset::dataset::Dataset;
use crate::dataset::digest::{RowHash, digest, hash_rows};
use crate::dataset::full_scale::refuse_far_below;
use crate::dataset::labels::Labels;
use crate::dataset::one_hot::{LabelForm, settle, unsaid};
use crate::dataset::problems::{Problem, Problems};
use crate::dataset::raw::Raw;
use crate::dataset::rows::RecordingRows;
use crate::dataset::source::Source;
use crate::dataset::targets::{Targets, Values};
use crate::dataset::validate::{
    channels, class_names, gaps, groups, labels, official, one_class, unclear_names, wrong_length,
};
use crate::length::lengths::Lengths;
use crate::length::one_length::{EqualSamples, samples};
use crate::options::{Drop, ReadOptions};
use crate::{Error, Result};
use std::collections::HashMap;

/// A data set with everything that keeps it from being used.
#[derive(Debug)]
pub(crate) struct Checked {
    pub dataset: Dataset,
    pub problems: Vec<Problem>,
    /// The form of the labels.
    pub label_form: LabelForm,
    /// Where recordings are unequal or a rule is given.
    pub lengths: Option<Lengths>,
    /// Time steps of each recording, where a rule has made them one length.
    pub readings: Option<Vec<usize>>,
}

/// Builds the data set; faults of the content are collected, faults of the options end it.
pub(crate) fn assemble(mut raw: Raw, options: &ReadOptions) -> Result<Checked> {
    let label_form = settle(&mut raw, options);
    let attribute = attribute(&raw, options)?;
    let channels = channels(&raw, options)?;
    let mut faults = Problems::default();
    if label_form == LabelForm::Unsaid {
        faults.push(unsaid(&raw));
    }
    let values = raw.values.take();
    let (table, classes) = numbered(&raw, values.as_ref(), options, &mut faults)?;
    unclear_names(&raw, &classes, &mut faults);
    let groups = groups(&raw, options, &mut faults)?;
    let official = official(&raw, options, &mut faults);
    let row_hash = raw.x.hashes(channels.as_deref());
    let keep = keep(&raw, &row_hash, &table, &classes, options, &mut faults);
    let kept: Vec<usize> = (0..keep.len()).filter(|row| keep[*row]).collect();
    if kept.is_empty() {
        return Err(Error::NoSamples { at: format!("{}: after drop", raw.file) });
    }
    let mut dropped: Vec<String> =
        (0..keep.len()).filter(|row| !keep[*row]).map(|row| raw.origins[row].clone()).collect();

    let mut of_values = Problems::default();
    let x = std::mem::take(&mut raw.x);
    let EqualSamples { x, spec, windows, lengths, readings } =
        samples(&raw, x, &kept, channels.as_deref(), options, &mut of_values)?;
    if let Err(fault) = refuse_far_below(&raw.facts.file, x.view(), spec.full_scale) {
        of_values.push(fault);
    }
    let rows = RecordingRows::new(&row_hash, &kept, windows);
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
        digest: digest(&x, Some(&targets), groups.as_deref()),
        targets,
        official: official.map(|test| rows.of(|row| test[row])),
        groups,
        group_name,
        units: Some(rows.units()),
        origins: rows.origins(&raw),
        dropped,
        row_hash: if readings.is_some() { hash_rows(&x) } else { rows.hashes() },
        dtype: raw.dtype,
        name: raw.name,
        x,
    };
    dataset.learn_attributes(&options.attributes)?;
    Ok(Checked { dataset, problems: faults.0, label_form, lengths, readings })
}

/// Returns the column of labels that is learned, from 0; refuses one that is not there.
fn attribute(raw: &Raw, options: &ReadOptions) -> Result<usize> {
    let (attribute, columns) = (options.attribute.unwrap_or(0), raw.columns);
    if attribute >= columns {
        let held = format!("{} has {columns} columns (0..{})", raw.y_name, columns - 1);
        return Err(Error::file(&raw.file, format!("attribute = {attribute} is out of range: {held}")));
    }
    Ok(attribute)
}

/// Returns the labels of all samples as numbers, `[samples, columns]`, and the names of each column. Values get the
/// numbers by which copies are compared, without names.
fn numbered(
    raw: &Raw,
    values: Option<&Values>,
    options: &ReadOptions,
    faults: &mut Problems,
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

/// Returns the classes of the samples in `rows`: the labels of the column `attribute`, and all columns where there are
/// several.
fn classes_of(
    raw: &Raw,
    rows: &RecordingRows,
    table: &[u32],
    classes: Vec<Vec<String>>,
    attribute: usize,
    faults: &mut Problems,
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

/// Checks that each sample has one row of finite values. Returns a number for each sample by which copies are compared:
/// equal rows have the same.
fn check_values(raw: &Raw, values: &Values, faults: &mut Problems) -> Result<Vec<u32>> {
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

/// Returns the name of the groups, and the group of each sample. Windows without groups are grouped by recording, so that
/// no recording is trained on and tested.
fn grouped(groups: Option<(String, Vec<u32>)>, rows: &RecordingRows) -> (Option<String>, Option<Vec<u32>>) {
    match groups {
        Some((name, values)) => (Some(name), Some(rows.of(|row| values[row]))),
        None if rows.is_cut() => (Some("recording".into()), Some(rows.of(|row| row as u32))),
        None => (None, None),
    }
}

/// Says of each row whether it stays; copies with different labels are dropped, refused or kept, as `options` say.
fn keep(
    raw: &Raw,
    row_hash: &[RowHash],
    table: &[u32],
    classes: &[Vec<String>],
    options: &ReadOptions,
    faults: &mut Problems,
) -> Vec<bool> {
    let rows: Vec<&[u32]> = table.chunks(raw.columns).collect();
    let sets = duplicate_sets(row_hash);
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
        let (first, second) = (labelled(set[0]), labelled(second));
        let rows: usize = torn.iter().map(Vec::len).sum();
        faults.push(Error::file(
            &raw.file,
            format!(
                "{first} and {second} are the same recording, {rows} such rows; set drop = [\"contradictory\"]"
            ),
        ));
    }
    if options.drop.contains(&Drop::Duplicates) {
        for row in later_copies(&sets, &rows) {
            keep[row] = false;
        }
    }
    keep
}

/// Returns the source of the samples: a scene that was saved and read again is still simulated, all else is recorded.
fn source(raw: &Raw) -> Source {
    match &raw.facts.source {
        Some(scene) if scene.is_simulated() => Source::simulated(format!("{} ({})", scene.name, raw.name)),
        _ => Source::real(raw.name.clone()),
    }
}
