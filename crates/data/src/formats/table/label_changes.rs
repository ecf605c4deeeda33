//! Labels that change within a recording of a long table.

use crate::Result;
use crate::formats::clock::Timing;
use crate::formats::table::columns::TableColumns;
use crate::formats::table::recording::TableRecording;
use crate::formats::table::text_columns::TableRow;
use crate::formats::timed::Timed;
use crate::options::ReadOptions;
use crate::targets::steps::StepTargets;
use std::collections::HashMap;

/// Rows whose labels differ from those of the row before in their recording. Nothing is kept of recordings of one label.
#[derive(Default)]
pub(crate) struct LabelChanges {
    /// Of each recording that changes: a row, and the labels from there on.
    of_recording: HashMap<usize, Vec<(usize, Vec<String>)>>,
    /// Says where the first change is.
    first: Option<String>,
}

impl LabelChanges {
    /// Looks at the `labels` of the row at a place of the recording numbered `number`.
    pub fn see(
        &mut self,
        number: usize,
        place: usize,
        recording: &TableRecording,
        labels: Vec<String>,
        row: &TableRow,
        columns: &TableColumns,
    ) {
        let known = self.of_recording.get(&number).and_then(|changes| changes.last());
        let before = known.map_or(&recording.labels, |(_, labels)| labels);
        let Some(at) = labels.iter().zip(before).position(|(now, before)| now != before) else { return };
        if self.first.is_none() {
            let kind = if row.table().is_text() { "lines" } else { "rows" };
            let (column, name) = (&row.table().header[columns.labels[at]], &recording.name);
            let (said, now) = (&recording.labels[at], &labels[at]);
            self.first = Some(format!(
                "{kind} {} and {} are both recording {name:?}, but {column} is {said:?} and {now:?}",
                recording.line, row.line
            ));
        }
        self.of_recording.entry(number).or_default().push((place, labels));
    }

    /// Returns the labels of all rows; none where no recording changes.
    pub fn of_rows(self, recordings: &[TableRecording], timed: &Timed) -> Option<StepLabels> {
        let change = self.first?;
        let mut texts = vec![];
        for (number, (recording, rows)) in recordings.iter().zip(&timed.rows).enumerate() {
            let mut changes = self.of_recording.get(&number).into_iter().flatten().peekable();
            let mut labels = &recording.labels;
            for place in 0..*rows {
                if let Some((_, now)) = changes.next_if(|(at, _)| *at == place) {
                    labels = now;
                }
                texts.extend(labels.iter().cloned());
            }
        }
        let steps = StepTargets { steps: timed.rows.clone(), change };
        Some(StepLabels { steps, texts, stamps: timed.stamps.clone() })
    }
}

/// The labels of each row, recording after recording.
pub(crate) struct StepLabels {
    pub steps: StepTargets,
    /// Row by row, of each column of labels.
    pub texts: Vec<String>,
    /// Time stamps of the rows in seconds; empty without a clock.
    stamps: Vec<f64>,
}

impl StepLabels {
    /// Brings values of the rows to the equal steps of the channels.
    pub fn at_equal_steps(
        &self,
        values: Vec<f32>,
        timing: Option<Timing>,
        file: &str,
        options: &ReadOptions,
    ) -> Result<(StepTargets, Vec<f32>)> {
        let Self { steps, stamps, .. } = self;
        if timing.is_none_or(|timing| timing.is_regular) {
            return Ok((steps.clone(), values));
        }
        let width = values.len() / steps.rows().max(1);
        let timed = Timed { width, rows: steps.steps.clone(), stamps: stamps.clone(), values };
        // Rows of one axis stay rows: only channels over time are turned.
        let even = timed.into_recordings(timing, &[width], file, options)?;
        let lengths = even.lengths(0);
        let values = even.each().flatten().copied().collect();
        Ok((StepTargets { steps: lengths, change: steps.change.clone() }, values))
    }
}
