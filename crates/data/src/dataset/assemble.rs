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
use crate::targets::missing::{drops_missing, leave_out_missing, missing_in, no_target};
use crate::targets::quantities::renamed;
use crate::targets::rows::{check_values, refuse_steps};
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};
use std::ops::Range;

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
    /// Samples that were left out because they have no target.
    pub without_target: usize,
}

/// Builds the data set; faults of the content are collected, faults of the options end it.
pub(crate) fn assemble(mut raw: Raw, options: &ReadOptions) -> Result<Checked> {
    refuse_steps(&raw, options)?;
    let label_form = settle(&mut raw, options);
    let attribute = attribute(&raw, options)?;
    let channels = channels(&raw, options)?;
    let mut faults = Problems::default();
    if label_form == LabelForm::Unsaid {
        faults.push(unsaid(&raw));
    }
    let read = renamed(raw.values.take(), &raw, options)?;
    let values = compared(read.as_ref(), options);
    let (table, classes) = numbered(&raw, values.as_ref(), options, &mut faults)?;
    unclear_names(&raw, &classes, &mut faults);
    let groups = groups(&raw, options, &mut faults)?;
    let official = official(&raw, options, &mut faults);
    let row_hash = raw.x.hashes(channels.as_deref());
    let mut keep = keep(&raw, &row_hash, &table, &classes, options, &mut faults);
    let mut without_target = left_out_missing(&mut keep, values.as_ref(), &raw, options);
    let (kept, left): (Vec<usize>, Vec<usize>) = (0..keep.len()).partition(|row| keep[*row]);
    if kept.is_empty() {
        return Err(Error::NoSamples { at: format!("{}: after drop", raw.file) });
    }
    let mut dropped: Vec<String> = left.iter().map(|row| raw.origins[*row].clone()).collect();
    let mut of_values = Problems::default();
    let x = std::mem::take(&mut raw.x);
    let EqualSamples { x, spec, windows, lengths, readings } =
        samples(&raw, x, &kept, channels.as_deref(), options, &mut of_values)?;
    if let Err(fault) = refuse_far_below(&raw.facts.file, x.view(), spec.full_scale) {
        of_values.push(fault);
    }
    let rows = RecordingRows::new(&row_hash, &kept, windows);
    let WithTargets { x, rows, target_rows, left_out } =
        WithTargets::of(x, rows, &raw, values.as_ref(), options, &mut faults)?;
    without_target += left_out;
    dropped.extend(rows.left_out(&kept).map(|row| raw.origins[row].clone()));
    if values.is_none() {
        gaps(&raw, &table, &target_rows, &classes, &mut faults);
    }
    faults.0.extend(of_values.0);

    let (group_name, groups) = grouped(groups, &rows);
    let targets = match read {
        None => classes_of(&raw, &target_rows, &table, classes, attribute, &mut faults),
        Some(read) => targets_of(&read, &raw, &target_rows, options, &mut faults),
    };
    let targets = targets.at_steps(rows.target_steps(&raw, options.length, spec.rate));
    let mut dataset = Dataset {
        spec,
        source: source(&raw),
        digest: digest(&x, Some(&targets), groups.as_deref()),
        targets,
        official: official.map(|test| rows.of(|row| test[row])),
        groups,
        group_name,
        weights: None,
        units: Some(rows.units()),
        origins: rows.origins(&raw),
        dropped,
        warnings: raw.warnings,
        row_hash: if readings.is_some() { hash_rows(&x) } else { rows.hashes() },
        dtype: raw.dtype,
        name: raw.name,
        x,
    };
    dataset.learn_attributes(&options.attributes)?;
    Ok(Checked { dataset, problems: faults.0, label_form, lengths, readings, without_target })
}

/// Returns the values by which copies are compared: of events whether they are.
fn compared(read: Option<&Values>, options: &ReadOptions) -> Option<Values> {
    read.map(|read| options.event.as_ref().map_or_else(|| read.clone(), |event| event.marks(read)))
}

/// Returns the targets of the samples in `rows`: values, or the classes that an event makes of them.
fn targets_of(
    read: &Values,
    raw: &Raw,
    rows: &[usize],
    options: &ReadOptions,
    faults: &mut Problems,
) -> Targets {
    let values = read.of(rows);
    match &options.event {
        None => Targets::Values(Values::new(read.quantities().to_vec(), values)),
        Some(event) => event.targets(&values, raw, faults),
    }
}

/// Leaves out recordings without a value where the options say so, and returns their number.
fn left_out_missing(keep: &mut [bool], values: Option<&Values>, raw: &Raw, options: &ReadOptions) -> usize {
    let of_recordings = values.filter(|_| raw.steps.is_none() && drops_missing(options));
    of_recordings.map_or(0, |values| leave_out_missing(keep, values))
}

/// Samples, and the row of targets of each.
struct WithTargets {
    x: ArrayD<f32>,
    rows: RecordingRows,
    target_rows: Vec<usize>,
    /// Samples without a target that are left out.
    left_out: usize,
}

impl WithTargets {
    /// Finds the targets of samples; those without one are left out or refused, as the options say.
    fn of(
        x: ArrayD<f32>,
        rows: RecordingRows,
        raw: &Raw,
        values: Option<&Values>,
        options: &ReadOptions,
        faults: &mut Problems,
    ) -> Result<Self> {
        let to = options.length.map_or(0, |rule| rule.to());
        let target_rows = rows.target_rows(raw.steps.as_ref(), to);
        let missing = values.map_or(vec![], |values| missing_in(values, &target_rows));
        let (Some(first), Some(values)) = (missing.first(), values) else {
            return Ok(Self { x, rows, target_rows, left_out: 0 });
        };
        if !drops_missing(options) {
            let (first, origins) = ((target_rows[*first], target_rows.len()), rows.origins(raw));
            faults.push(no_target(raw, values, first, &missing, &origins));
            return Ok(Self { x, rows, target_rows, left_out: 0 });
        }
        let is_held = |at: &usize| missing.binary_search(at).is_err();
        let held: Vec<usize> = (0..target_rows.len()).filter(is_held).collect();
        if held.is_empty() {
            return Err(Error::NoSamples { at: format!("{}: after drop", raw.file) });
        }
        let target_rows = held.iter().map(|at| target_rows[*at]).collect();
        let (x, rows) = (x.select(Axis(0), &held), rows.select(&held));
        Ok(Self { x, rows, target_rows, left_out: missing.len() })
    }
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
    if raw.steps.is_none()
        && (raw.x.len() as u64).saturating_mul(raw.columns as u64) > options.limits.max_samples
    {
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
    rows: &[usize],
    table: &[u32],
    classes: Vec<Vec<String>>,
    attribute: usize,
    faults: &mut Problems,
) -> Targets {
    let columns = raw.columns;
    let y: Vec<u32> = rows.iter().map(|row| table[row * columns + attribute]).collect();
    one_class(raw, &classes[attribute], &y, faults);
    let labels = Labels::of_classes(&classes[attribute], &y);
    let of_row = |row: &usize| table[row * columns..(row + 1) * columns].to_vec();
    let several = (columns > 1).then(|| Labels::numbered(classes, rows.iter().flat_map(of_row).collect()));
    Targets::Classes { labels, columns: several, steps: None }
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
    let rows: Vec<&[u32]> = match &raw.steps {
        None => table.chunks(raw.columns).collect(),
        Some(steps) => {
            let of = |rows: Range<usize>| &table[rows.start * raw.columns..rows.end * raw.columns];
            steps.ranges().into_iter().map(of).collect()
        }
    };
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
