//! Joins the rows of arrays, each a reading, to recordings.

use crate::dataset::raw::{NamedColumn, Raw};
use crate::dataset::targets::Values;
use crate::error::plural;
use crate::formats::archive::Archive;
use crate::formats::stored::{Column, StoredValues, column};
use crate::length::ragged::Ragged;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{Place, Purpose};
use crate::targets::options::TargetOf;
use crate::targets::steps::StepTargets;
use crate::{Error, Result};
use std::collections::HashMap;
use taxel_base::Layout;

/// The recording of each row of `x`.
pub(crate) struct Readings {
    /// The array that says it.
    name: String,
    /// Names of the recordings, in the order in which they begin.
    recordings: Vec<String>,
    /// Rows of each, in their order.
    rows: Vec<Vec<usize>>,
    /// The array is in the file.
    is_held: bool,
    /// Readings in a row, where rows are pieces of a series.
    piece: Option<usize>,
}

impl Readings {
    /// Reads which recording each row of the samples of `raw` belongs to; none where rows are samples.
    ///
    /// Recordings for a model that was trained on readings may lie in a file without that array: they are one recording.
    pub fn of(
        archive: &mut Archive,
        raw: &Raw,
        options: &ReadOptions,
        place: &Place,
    ) -> Result<Option<Self>> {
        let Some(name) = options.recording.clone() else { return Ok(None) };
        let rank = raw.x.sample_shape().len();
        let is_held = archive.saved().contains(&name);
        match place.purpose {
            // A model that was trained on readings also takes whole recordings.
            Purpose::Predict { rank: wanted } if rank == wanted => return Ok(None),
            Purpose::Predict { .. } if !is_held => {
                let rows = vec![(0..raw.x.len()).collect()];
                return Ok(Some(Self {
                    name,
                    recordings: vec![raw.name.clone()],
                    rows,
                    is_held,
                    piece: None,
                }));
            }
            _ => {}
        }
        let why = "names the recording of each row of x [R, C] or [R, H, W], or with layout = \"series\" [R, C, k]; other \
                   arrays are recordings already: leave it out";
        let is_step = options.target == Some(TargetOf::Step);
        let is_split = raw.x_name.contains(" with ") || raw.x_name == "the other arrays";
        let is_other = !(1..=2).contains(&rank) || is_split;
        refuse_set(&raw.file, &[("recording", is_other)], why)?;
        let why = "says that a row of y holds the targets of several time steps, and with recording = \"...\" a row is one: \
                   leave it out";
        refuse_set(&raw.file, &[("target", is_step)], why)?;
        let texts = texts(archive, &name, options)?;
        if texts.len() != raw.x.len() {
            let (file, x, samples) = (raw.file.clone(), raw.x_name.clone(), raw.x.len());
            return Err(Error::Length { file, array: name, len: texts.len(), x, samples });
        }
        let (mut recordings, mut rows, mut places) = (vec![], Vec::<Vec<usize>>::new(), HashMap::new());
        for (row, text) in texts.into_iter().enumerate() {
            let at = *places.entry(text.clone()).or_insert_with(|| {
                recordings.push(text);
                rows.push(vec![]);
                rows.len() - 1
            });
            rows[at].push(row);
        }
        let is_series = options.layout.or(raw.facts.layout) == Some(Layout::Series);
        let piece = raw.x.sample_shape().get(1).copied().filter(|_| is_series);
        Ok(Some(Self { name, recordings, rows, is_held, piece }))
    }

    /// Makes recordings of the rows of a file, with all that is said of the rows.
    pub fn joined(self, raw: Raw) -> Result<Raw> {
        let rank = raw.x.sample_shape().len();
        let readings = |row: &usize| std::iter::repeat_n(*row, self.in_row());
        let order: Vec<usize> = self.rows.iter().flatten().flat_map(readings).collect();
        let moved = |values: &[i64], width: usize| -> Vec<i64> {
            let row = |row: &usize| values.get(row * width..(row + 1) * width).unwrap_or_default().to_vec();
            order.iter().flat_map(row).collect()
        };
        // Another number of targets than of rows is refused later.
        let fits = raw.y.len() == raw.x.len() * raw.columns;
        let y = if fits { moved(&raw.y, raw.columns) } else { raw.y.clone() };
        let values = raw.values.as_ref().map(|values| {
            let is_whole = values.values().len() == raw.x.len() * values.quantities().len();
            if is_whole {
                Values::new(values.quantities().to_vec(), values.of(&order))
            } else {
                values.clone()
            }
        });
        let groups = raw.groups.as_ref().map(|groups| self.of_each(groups, &raw)).transpose()?;
        let official = raw.official.as_ref().map(|marks| self.of_each(marks, &raw)).transpose()?;
        let origins = self
            .recordings
            .iter()
            .map(|name| if self.is_held { format!("{} {name}", self.name) } else { name.clone() });
        let origins = origins.collect();
        let read_as = raw.read_as.iter().cloned().chain(self.said()).collect();
        let steps = StepTargets { steps: self.lengths(), change: String::new() };
        let x = self.join(&raw.x);
        let format = if rank == 1 || self.piece.is_some() { Layout::Series } else { Layout::Sequence };
        let joined = Raw { x, y, values, groups, official, origins, read_as, format: Some(format), ..raw };
        let joined = Raw { recording: Some(self.name.clone()), ..joined };
        Ok(self.with_targets(joined, steps))
    }

    /// Leaves targets to the time steps, or where none changes within its recording, to the recordings.
    fn with_targets(&self, mut raw: Raw, mut steps: StepTargets) -> Raw {
        let rows = steps.rows();
        let columns = raw.columns;
        let constant = match &raw.values {
            Some(values) if values.values().len() == rows * values.quantities().len() => {
                let bits = |row: usize| values.of(&[row]).into_iter().map(f32::to_bits).collect::<Vec<_>>();
                steps.constant(|a, b| bits(a) == bits(b))
            }
            None if !raw.y.is_empty() && raw.y.len() == rows * columns => {
                let row = |row: usize| &raw.y[row * columns..(row + 1) * columns];
                steps.constant(|a, b| row(a) == row(b))
            }
            _ => return raw,
        };
        match constant {
            Ok(firsts) => {
                raw.values = raw.values.map(|all| Values::new(all.quantities().to_vec(), all.of(&firsts)));
                if !raw.y.is_empty() {
                    let row = |row: &usize| &raw.y[row * columns..(row + 1) * columns];
                    raw.y = firsts.iter().flat_map(row).copied().collect();
                }
            }
            Err((recording, row)) => {
                let place = row - steps.ranges()[recording].start;
                let held = &self.rows[recording];
                steps.change = format!(
                    "rows {} and {} are both {} {}, but differ in {}",
                    held[(place - 1) / self.in_row()],
                    held[place / self.in_row()],
                    self.name,
                    self.recordings[recording],
                    raw.y_name
                );
                raw.steps = Some(steps);
            }
        }
        raw
    }

    /// Says for the card how rows were joined.
    fn said(&self) -> Vec<String> {
        let count = plural(self.recordings.len(), "recording");
        let held = self.piece.map_or("readings".into(), |piece| format!("{piece} readings each"));
        let joined = format!("rows as {held} of {count} by {:?}", self.name);
        let is_apart = |rows: &&Vec<usize>| rows.windows(2).any(|pair| pair[1] != pair[0] + 1);
        let apart = self.rows.iter().filter(is_apart).count();
        let lie =
            (apart > 0).then(|| format!("rows of {} lie apart, and are joined", plural(apart, "recording")));
        std::iter::once(joined).chain(lie).collect()
    }

    /// Returns what is said of each recording by each of its rows alike.
    fn of_each(&self, (name, of_rows): &NamedColumn, raw: &Raw) -> Result<NamedColumn> {
        if of_rows.len() != raw.x.len() {
            let (file, x, samples) = (raw.file.clone(), raw.x_name.clone(), raw.x.len());
            return Err(Error::Length { file, array: name.clone(), len: of_rows.len(), x, samples });
        }
        let one = |(recording, rows): (&String, &Vec<usize>)| {
            let first = of_rows[rows[0]];
            match rows.iter().find(|row| of_rows[**row] != first) {
                None => Ok(first),
                Some(row) => Err(Error::file(
                    &raw.file,
                    format!(
                        "{name} is {first} in row {} and {} in row {row}, which are both {} {recording}; {name} holds whole \
                         recordings: name finer recordings, or another array",
                        rows[0], of_rows[*row], self.name
                    ),
                )),
            }
        };
        let each: Vec<i64> = self.recordings.iter().zip(&self.rows).map(one).collect::<Result<_>>()?;
        Ok((name.clone(), each))
    }

    /// Returns the readings of each recording.
    fn lengths(&self) -> Vec<usize> {
        self.rows.iter().map(|rows| rows.len() * self.in_row()).collect()
    }

    fn in_row(&self) -> usize {
        self.piece.unwrap_or(1)
    }

    /// Joins rows `[C]`, or pieces `[C, k]`, to recordings `[C, T]`, and rows `[H, W]` to `[T, H, W]`.
    fn join(&self, x: &Ragged) -> Ragged {
        let all: Vec<&[f32]> = x.each().collect();
        let lengths = self.lengths();
        let mut values = Vec::with_capacity(all.iter().map(|row| row.len()).sum());
        match (x.sample_shape(), self.piece) {
            (&[channels], _) | (&[channels, _], Some(_)) => {
                for rows in &self.rows {
                    for channel in 0..channels {
                        let of_row = |row: &usize| &all[*row][channel * self.in_row()..][..self.in_row()];
                        values.extend(rows.iter().flat_map(of_row));
                    }
                }
                Ragged::of_lengths(values, vec![channels, 0], 1, lengths)
            }
            (shape, _) => {
                self.rows.iter().flatten().for_each(|row| values.extend_from_slice(all[*row]));
                Ragged::of_lengths(values, [&[0], shape].concat(), 0, lengths)
            }
        }
    }
}

/// Reads the names of recordings, one for each row: whole numbers or texts.
fn texts(archive: &mut Archive, name: &str, options: &ReadOptions) -> Result<Vec<String>> {
    let wanted = "names of recordings are whole numbers or texts: save an integer array";
    let arrays = [name.to_string()];
    let Column { values, columns } = column(archive, &arrays, "recording", wanted, &options.limits)?;
    if columns != Some(1) {
        let (at, shape) = (archive.at(name), archive.shape(name));
        return Err(Error::Shape {
            at,
            shape,
            wanted: "recordings are named by [R], one name for each row of x",
        });
    }
    Ok(match values {
        StoredValues::Texts(texts) => texts,
        StoredValues::Numbers(numbers) => numbers.iter().map(ToString::to_string).collect(),
    })
}
