//! Reads the targets of arrays: labels of classes, or values of one or several quantities.

use crate::dataset::one_hot::class_of;
use crate::dataset::raw::{Names, SampleFacts};
use crate::dataset::targets::Values;
use crate::formats::archive::Archive;
use crate::formats::npy::{Cap, Header, NumberKind};
use crate::formats::stored::{Column, StoredValues, column, columns, parts_differ};
use crate::layout::array_labels::{StoredLabels, read_labels};
use crate::layout::names_file;
use crate::options::ReadOptions;
use crate::targets::options::{TargetOf, TaskKind};
use crate::targets::texts::TextTargets;
use crate::{Error, Result};

/// Why arrays of floats are no classes.
const NO_CLASSES: &str = "holds floats, which are values, and task = \"classes\" takes whole numbers (0.0 and 1.0 too) and texts; \
                          leave task out to learn values, or round them";

/// Targets, as labels or as values.
#[derive(Default)]
pub(crate) struct ArrayTargets {
    pub labels: StoredLabels,
    pub values: Option<Values>,
    /// Time steps in a row, where the arrays hold the target of each.
    pub steps: Option<usize>,
}

/// The arrays of targets, and what is known of them.
pub(crate) struct TargetArrays<'t> {
    /// By name of a target: one array, or that of the training and that of the test samples.
    pub arrays: &'t [Vec<String>],
    pub names: Option<&'t Names>,
    pub facts: &'t SampleFacts,
    pub options: &'t ReadOptions,
    /// Number of samples.
    pub samples: usize,
}

/// The values of one target.
struct OneTarget {
    name: String,
    /// Values of a row.
    width: usize,
    /// Time steps in a row of the array.
    steps: Option<usize>,
    values: Vec<f32>,
}

/// The content of an array.
#[derive(PartialEq)]
enum Holds {
    Floats,
    Whole,
    Texts,
}

/// Takes whole floats as labels: 0.0, 1.0 and 2.0 are classes for whoever calls them so.
fn as_labels(read: &ArrayTargets, values: &[f32], width: usize) -> ArrayTargets {
    let values = values.iter().map(|value| *value as i64).collect();
    let labels = StoredLabels { values, columns: width.max(1), names: None };
    ArrayTargets { labels, values: None, steps: read.steps }
}

impl TargetArrays<'_> {
    /// Reads them.
    pub fn read(&self, archive: &mut Archive) -> Result<ArrayTargets> {
        let options = self.options;
        // Who names classes or attributes means labels, however they are stored.
        let is_labelled =
            self.names.is_some() || options.attribute.is_some() || !options.attributes.is_empty();
        let are_values = self.facts.values_of(self.arrays.iter().map(|halves| halves[0].as_str())).is_some();
        if options.wants_values() || are_values && options.task.is_none() {
            return self.values(archive);
        }
        if is_labelled {
            return self.labels(archive);
        }
        let mut holds = vec![];
        for halves in self.arrays {
            holds.push(self.holds(archive, &halves[0])?);
        }
        if !holds.contains(&Holds::Floats) {
            return match holds.as_slice() {
                [Holds::Texts] => self.texts(archive),
                _ => self.labels(archive),
            };
        }
        let read = self.values(archive)?;
        let values = read.values.as_ref().map_or(&[][..], |values| values.values());
        let width = values.len() / self.rows(&read).max(1);
        // Many frameworks store one-hot classes as floats; who names quantities means values.
        let is_one_hot = width > 1 && values.chunks_exact(width).all(|row| class_of(row).is_some());
        if is_one_hot && self.facts.quantities.is_none() && self.arrays.len() == 1 && read.steps.is_none() {
            return self.labels(archive);
        }
        // MATLAB keeps whole numbers as floats too.
        let is_whole = || values.iter().all(|value| value.fract() == 0.0);
        if archive.counts_from_one() && self.facts.quantities.is_none() && is_whole() {
            return self.labels(archive);
        }
        if options.task == Some(TaskKind::Classes) {
            if self.arrays.len() == 1 && is_whole() {
                return Ok(as_labels(&read, values, width));
            }
            return Err(Error::file(archive.at(&self.arrays[0].join(" with ")), NO_CLASSES));
        }
        Ok(read)
    }

    /// Counts the rows of targets that were read.
    fn rows(&self, read: &ArrayTargets) -> usize {
        self.samples * read.steps.unwrap_or(1)
    }

    /// Finds out what an array holds.
    fn holds(&self, archive: &mut Archive, array: &str) -> Result<Holds> {
        let is_float = |header: Header| header.kind == Some(NumberKind::Float) || header.matlab;
        match archive.header(array) {
            // Texts of MATLAB have a header of numbers.
            Some(header) if header.matlab && header.kind.is_some() => {
                let cap = Cap::of_labels(&self.options.limits);
                let texts = archive.texts(array, &archive.at(array), cap)?;
                Ok(if texts.is_some() { Holds::Texts } else { Holds::Floats })
            }
            Some(header) if header.kind.is_some() => {
                Ok(if is_float(header) { Holds::Floats } else { Holds::Whole })
            }
            _ => Ok(Holds::Texts),
        }
    }

    /// Reads labels; those of several arrays only where the options call them attributes.
    fn labels(&self, archive: &mut Archive) -> Result<ArrayTargets> {
        let [one] = self.arrays else { return self.attributes(archive) };
        let limits = &self.options.limits;
        if !self.is_of_steps() {
            let labels = read_labels(archive, one, self.names, limits, self.samples)?;
            return Ok(ArrayTargets { labels, ..ArrayTargets::default() });
        }
        let cells = archive.shape(&one[0]).iter().fold(1, |all: u64, axis| all.saturating_mul(*axis));
        let cells = cells.min(limits.max_samples) as usize;
        let mut labels = read_labels(archive, one, self.names, limits, cells)?;
        let steps = labels.columns;
        labels.columns = 1;
        if labels.names.as_ref().is_some_and(|names| !names.is_given && names.columns.len() > 1) {
            let why = "holds texts for each time step; save whole numbers, and name them in labels.json";
            return Err(Error::file(archive.at(&one.join(" with ")), why));
        }
        Ok(ArrayTargets { labels, values: None, steps: Some(steps) })
    }

    /// Reads labels of several arrays side by side.
    fn attributes(&self, archive: &mut Archive) -> Result<ArrayTargets> {
        let names: Vec<String> = self.arrays.iter().map(|halves| halves.join(" with ")).collect();
        if self.options.attribute.is_none() && self.options.attributes.is_empty() {
            return Err(Error::file(
                archive.file(),
                format!(
                    "{} hold whole numbers or texts, which are classes; say task = \"values\" (--task values) if they are \
                     measured, or name them all to learn several attributes: attributes = [\"...\", \"...\"]",
                    names.join(" and ")
                ),
            ));
        }
        let mut columns = vec![];
        for halves in self.arrays {
            let labels = read_labels(archive, halves, None, &self.options.limits, self.samples)?;
            if labels.columns != 1 || labels.names.is_some() || labels.values.len() != self.samples {
                let at = archive.at(&halves.join(" with "));
                let why =
                    "is no [N] of whole numbers from 0, as attributes of several arrays are; save it so";
                return Err(Error::file(at, why));
            }
            columns.push(labels.values);
        }
        let values =
            (0..self.samples).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
        let labels = StoredLabels { values, columns: columns.len(), names: self.names.cloned() };
        Ok(ArrayTargets { labels, ..ArrayTargets::default() })
    }

    /// Reads an array of texts: names of classes, or numbers as text.
    fn texts(&self, archive: &mut Archive) -> Result<ArrayTargets> {
        let halves = &self.arrays[0];
        let read = self.labels(archive)?;
        let Some(names) = read.labels.names.as_ref().filter(|_| read.labels.columns == 1) else {
            return Ok(read);
        };
        let texts: Vec<String> =
            read.labels.values.iter().map(|label| names.columns[0][*label as usize].clone()).collect();
        let name = halves.join(" with ");
        let targets = TextTargets { names: std::slice::from_ref(&name), texts: &texts };
        let place = |row: usize| format!("{name}[{row}]");
        let values = targets.values(self.options, false, place);
        let Some(values) = values.map_err(|why| Error::file(archive.file(), why))? else { return Ok(read) };
        let quantities = names_file::quantities(self.facts, &[(&name, 1)])?;
        Ok(ArrayTargets { values: Some(Values::new(quantities, values)), ..ArrayTargets::default() })
    }

    /// Reads values, those of several arrays side by side.
    fn values(&self, archive: &mut Archive) -> Result<ArrayTargets> {
        let mut all: Vec<OneTarget> = vec![];
        for halves in self.arrays {
            let one = self.one(archive, halves)?;
            let rows = |one: &OneTarget| one.values.len() / one.width;
            if let Some(first) = all.first().filter(|first| rows(first) != rows(&one)) {
                return Err(Error::file(
                    archive.file(),
                    format!(
                        "{} has {} rows of targets and {} has {}; give both a row for each sample",
                        first.name,
                        rows(first),
                        one.name,
                        rows(&one)
                    ),
                ));
            }
            all.push(one);
        }
        let named: Vec<(&str, usize)> = all.iter().map(|one| (one.name.as_str(), one.width)).collect();
        let quantities = names_file::quantities(self.facts, &named)?;
        let rows = all.first().map_or(0, |one| one.values.len() / one.width);
        let row =
            |at: usize| all.iter().flat_map(move |one| &one.values[at * one.width..(at + 1) * one.width]);
        let values = (0..rows).flat_map(row).copied().collect();
        let steps = all.first().and_then(|one| one.steps);
        Ok(ArrayTargets {
            labels: StoredLabels::default(),
            values: Some(Values::new(quantities, values)),
            steps,
        })
    }

    fn is_of_steps(&self) -> bool {
        self.options.target == Some(TargetOf::Step)
    }

    /// Reads the values of one target.
    fn one(&self, archive: &mut Archive, halves: &[String]) -> Result<OneTarget> {
        let (name, limits) = (halves.join(" with "), &self.options.limits);
        if self.holds(archive, &halves[0])? == Holds::Texts {
            let wanted = "values are numbers: save y as a float array";
            let Column { values, columns } = column(archive, halves, "y", wanted, limits)?;
            let (StoredValues::Texts(texts), Some(1)) = (values, columns) else {
                return Err(Error::file(archive.at(&name), wanted));
            };
            let targets = TextTargets { names: std::slice::from_ref(&name), texts: &texts };
            let options = ReadOptions { task: Some(TaskKind::Values), ..ReadOptions::default() };
            let values = targets.values(&options, false, |row| format!("{name}[{row}]"));
            let values = values.map_err(|why| Error::file(archive.file(), why))?.unwrap_or_default();
            return Ok(OneTarget { name, width: 1, steps: None, values });
        }
        let cap = if self.is_of_steps() { Cap::of_samples(limits) } else { Cap::of_labels(limits) };
        let (mut all, mut shape_of_row) = (vec![], None);
        for array in halves {
            let (shape, values) = archive.with(array, "y", |header, reader, at| {
                let shape = self.row_of(&header.as_column(), at)?;
                Ok((shape, header.read_f32(reader, at, cap, 1)?))
            })?;
            if *shape_of_row.get_or_insert(shape) != shape {
                return Err(parts_differ(archive, halves, array));
            }
            all.extend(values);
        }
        let (width, steps) = shape_of_row.unwrap_or((1, None));
        Ok(OneTarget { name, width, steps, values: all })
    }

    /// Returns the quantities of a row of targets, and the time steps of a sample where a row is one.
    fn row_of(&self, header: &Header, at: &str) -> Result<(usize, Option<usize>)> {
        let (shape, is_of_steps) = (&header.shape, self.is_of_steps());
        match (shape.as_slice(), columns(shape)) {
            (&[_, steps], _) if is_of_steps && steps > 0 => Ok((1, Some(steps as usize))),
            (&[_, steps, width], _) if is_of_steps && steps > 0 && width > 0 => {
                Ok((width as usize, Some(steps as usize)))
            }
            (_, Some(columns)) if !is_of_steps => Ok((columns, None)),
            _ => Err(Error::Shape {
                at: at.into(),
                shape: shape.clone(),
                wanted: if is_of_steps {
                    "targets of time steps are [N, T], or [N, T, k] of k quantities"
                } else {
                    "values are [N], or [N, k] of k quantities"
                },
            }),
        }
    }
}
