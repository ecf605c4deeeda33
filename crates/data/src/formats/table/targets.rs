//! The targets of a table: labels or values, of recordings or of their rows.

use crate::dataset::labels::by_name;
use crate::dataset::raw::{Names, SampleFacts};
use crate::dataset::targets::Values;
use crate::formats::clock::Timing;
use crate::formats::table::label_changes::StepLabels;
use crate::formats::table::recording::TableRecording;
use crate::formats::table::text_columns::TableText;
use crate::layout::array_labels::named;
use crate::layout::names_file;
use crate::options::ReadOptions;
use crate::targets::options::TargetOf;
use crate::targets::steps::StepTargets;
use crate::targets::texts::TextTargets;
use crate::{Error, Result};

/// The labels of a table, or its values.
#[derive(Default)]
pub(crate) struct TableTargets {
    pub y: Vec<i64>,
    pub names: Option<Names>,
    pub values: Option<Values>,
    pub steps: Option<StepTargets>,
}

/// The columns of targets of a table that was read.
pub(crate) struct StoredTargets<'t> {
    pub table: &'t TableText,
    pub all: &'t [TableRecording],
    /// Of the columns.
    pub names: &'t [String],
}

impl StoredTargets<'_> {
    /// Returns labels as positions among their names: those of the file beside, or those that occur; or values, as the
    /// options, fractions or the file beside say. `steps` are the labels of rows that change within their recording.
    pub fn read(
        &self,
        steps: Option<&StepLabels>,
        timing: Option<Timing>,
        (names, facts): (Option<Names>, &SampleFacts),
        options: &ReadOptions,
    ) -> Result<TableTargets> {
        let of_recordings = || self.all.iter().flat_map(|recording| recording.labels.clone()).collect();
        let texts = steps.map_or_else(of_recordings, |steps| steps.texts.clone());
        if texts.is_empty() {
            return Ok(TableTargets { names, ..TableTargets::default() });
        }
        let file = &self.table.file;
        if let Some(steps) = steps.filter(|_| options.target == Some(TargetOf::Recording)) {
            let why = "say one for all its rows, or leave target = \"recording\" out";
            return Err(Error::file(file, format!("{}; {why}", steps.steps.change)));
        }
        // Who lists the numbers as classes means classes.
        if names.is_some() && !options.wants_values() {
            return self.labels(texts, names, steps, timing);
        }
        let targets = TextTargets { names: self.names, texts: &texts };
        let values = targets.values(options, facts.quantities.is_some(), |row| self.place(row, steps));
        let Some(values) = values.map_err(|why| Error::file(file, why))? else {
            return self.labels(texts, names, steps, timing);
        };
        let (steps, values) = match steps {
            None => (None, values),
            Some(steps) => {
                let (steps, values) = steps.at_equal_steps(values, timing, file, options)?;
                (Some(steps), values)
            }
        };
        let columns: Vec<(&str, usize)> = self.names.iter().map(|name| (name.as_str(), 1)).collect();
        let values = Some(Values::new(names_file::quantities(facts, &columns)?, values));
        Ok(TableTargets { values, steps, ..TableTargets::default() })
    }

    /// Returns the name of a row of targets in messages.
    fn place(&self, row: usize, steps: Option<&StepLabels>) -> String {
        let Some(steps) = steps else {
            let kind = if self.table.is_text() { "line" } else { "row" };
            return format!("{kind} {}", self.all[row].line);
        };
        let ranges = steps.steps.ranges();
        let number = ranges.partition_point(|rows| rows.end <= row);
        format!("row {} of recording {:?}", row - ranges[number].start + 1, self.all[number].name)
    }

    /// Returns texts as labels.
    fn labels(
        &self,
        texts: Vec<String>,
        names: Option<Names>,
        steps: Option<&StepLabels>,
        timing: Option<Timing>,
    ) -> Result<TableTargets> {
        let (file, width, y) = (&self.table.file, self.names.len(), self.names.join(", "));
        if let Some((row, column)) = (TextTargets { names: self.names, texts: &texts }).first_empty() {
            let place = self.place(row, steps);
            let why = format!("{place}, column {column}: \"\" is empty; fill it in or leave its row out");
            return Err(Error::file(file, why));
        }
        if let Some(steps) = steps.filter(|_| timing.is_some_and(|timing| !timing.is_regular)) {
            return Err(Error::file(
                file,
                format!(
                    "{}, and its time stamps are irregular: labels cannot be brought to equal steps; write one label for a \
                     recording, or leave the time out with table.ignore",
                    steps.steps.change
                ),
            ));
        }
        let numbers: Option<Vec<i64>> = texts.iter().map(|text| whole_number(text)).collect();
        let (y, names) = match (names, numbers) {
            (Some(names), Some(numbers)) if names.columns.iter().any(|known| !known.contains(&texts[0])) => {
                (numbers, names)
            }
            (Some(names), _) => (named(texts, width, &y, file, Some(&names))?.values, names),
            (None, _) if width > 1 => {
                let labels = named(texts, width, &y, file, None)?;
                let no_names = Names { file: y, columns: vec![], is_given: false };
                (labels.values, labels.names.unwrap_or(no_names))
            }
            (None, _) => {
                let (classes, values) = by_name(texts);
                let names = Names { file: y, columns: vec![classes], is_given: true };
                (values.into_iter().map(i64::from).collect(), names)
            }
        };
        let steps = steps.map(|steps| steps.steps.clone());
        Ok(TableTargets { y, names: Some(names), values: None, steps })
    }
}

/// Returns the whole number that a label is: `2`, or `2.0` as pandas writes it where one label was missing.
fn whole_number(text: &str) -> Option<i64> {
    let of_float = || text.parse::<f64>().ok().filter(|number| number.fract() == 0.0 && number.abs() < 1e15);
    text.parse().ok().or_else(|| of_float().map(|number| number as i64))
}
