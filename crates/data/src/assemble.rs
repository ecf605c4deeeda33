//! From stored arrays to a data set: rows and channels to leave out, labels, groups.

use crate::dataset::Dataset;
use crate::duplicates::{contradictory, duplicate_sets, later_copies, units};
use crate::hash::digest;
use crate::labels::Labels;
use crate::npy::c_order;
use crate::one_hot::{Columns, settle, unsaid};
use crate::options::{Drop, Options};
use crate::problems::{Faults, Problem};
use crate::raw::Raw;
use crate::reading_of::reading;
use crate::source::Source;
use crate::validate::{
    channels, class_names, gaps, groups, labels, not_finite, official, one_class, wrong_length,
};
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};

/// A data set with everything that keeps it from being used.
#[derive(Debug)]
pub(crate) struct Checked {
    pub dataset: Dataset,
    pub problems: Vec<Problem>,
    /// What the columns of labels are.
    pub columns: Columns,
}

/// Builds the data set; faults of the content are collected, faults of the options end it.
pub(crate) fn assemble(mut raw: Raw, options: &Options) -> Result<Checked> {
    let kind = settle(&mut raw, options);
    let columns = raw.columns;
    let attribute = options.attribute.unwrap_or(0);
    if attribute >= columns {
        let last = columns - 1;
        return Err(Error::Attribute { file: raw.file, attribute, y: raw.y_name, columns, last });
    }
    let channels = channels(&raw, options)?;
    let mut faults = Faults::default();
    if kind == Columns::Unsaid {
        faults.push(unsaid(&raw));
    }
    // Labels for fewer samples may have many columns: too many for all samples.
    if (raw.x.shape()[0] as u64).saturating_mul(columns as u64) > options.limits.max_samples {
        return Err(wrong_length(&raw, &raw.y_name, raw.y.len() / columns));
    }
    let table = labels(&raw, &mut faults);
    let mut classes = class_names(&raw, &table);
    let groups = groups(&raw, options, &mut faults)?;
    let official = official(&raw, options, &mut faults);
    let keep = keep(&raw, &table, &classes, options, &mut faults);
    let kept: Vec<usize> = (0..keep.len()).filter(|row| keep[*row]).collect();
    if kept.is_empty() {
        return Err(Error::NoSamples { at: format!("{}: after drop", raw.file) });
    }
    gaps(&raw, &table, &kept, &classes, &mut faults);

    let x = chosen(std::mem::take(&mut raw.x), &kept, keep.len(), channels.as_deref());
    let origins: Vec<String> = kept.iter().map(|row| raw.origins[*row].clone()).collect();
    let separator = if raw.is_folder { "/" } else { ": " };
    not_finite(&x, channels.as_deref(), &mut faults, |row| {
        format!("{}{separator}{}", raw.file, origins[row])
    });
    let y: Vec<u32> = kept.iter().map(|row| table[row * columns + attribute]).collect();
    let (group_name, groups) = groups.unzip();
    let groups = groups.map(|values| kept.iter().map(|row| values[*row]).collect::<Vec<u32>>());
    let own = classes[attribute].clone();
    one_class(&raw, &own, &y, &mut faults);
    let of_row = |row: &usize| table[row * columns..(row + 1) * columns].to_vec();
    let several = (columns > 1)
        .then(|| Labels::numbered(std::mem::take(&mut classes), kept.iter().flat_map(of_row).collect()));
    let row_hash: Vec<_> = kept.iter().map(|row| raw.row_hash[*row]).collect();
    let mut dataset = Dataset {
        reading: reading(&raw, options, &x.shape()[1..])?,
        source: source(&raw),
        digest: digest(&x, &y, several.as_ref(), groups.as_deref()),
        labels: Labels::of_classes(&own, &y),
        columns: several,
        y,
        classes: own,
        official: official.map(|test| kept.iter().map(|row| test[*row]).collect()),
        groups,
        group_name,
        units: Some(units(&row_hash)),
        origins,
        dropped: (0..keep.len()).filter(|row| !keep[*row]).map(|row| raw.origins[row].clone()).collect(),
        row_hash,
        dtype: raw.dtype,
        name: raw.name,
        x,
    };
    dataset.learn_attributes(&options.attributes)?;
    Ok(Checked { dataset, problems: faults.0, columns: kind })
}

/// Whether each row stays; copies with different labels are dropped, refused or left, as `options` say.
fn keep(
    raw: &Raw,
    table: &[u32],
    classes: &[Vec<String>],
    options: &Options,
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

/// The kept rows, of `rows` in all, and channels of `x`, in C order.
fn chosen(mut x: ArrayD<f32>, kept: &[usize], rows: usize, channels: Option<&[usize]>) -> ArrayD<f32> {
    if kept.len() < rows {
        x = x.select(Axis(0), kept);
    }
    if let Some(channels) = channels {
        x = x.select(Axis(1), channels);
    }
    c_order(x)
}

/// A scene that was saved and read again is still simulated; everything else is a recording.
fn source(raw: &Raw) -> Source {
    match &raw.facts.source {
        Some(scene) if scene.is_simulated() => Source::simulated(format!("{} ({})", scene.name, raw.name)),
        _ => Source::real(raw.name.clone()),
    }
}
