//! Finds the channels and the time among the keys of lines of JSON.

use crate::Result;
use crate::dataset::channel_names::numbered;
use crate::formats::json_time_step::TimeStep;
use crate::formats::table::column_kind::{ColumnCells, ColumnKind};
use crate::formats::table::column_name::ColumnName;
use crate::formats::table::decorated::DecoratedCells;
use crate::formats::table::options::{Clock, TableOptions};
use crate::formats::table::time_text;

/// The columns of a line: names and number of values of each; an array is one column without a name.
pub(crate) struct JsonColumns {
    /// All columns of numbers, in the order of the first line.
    pub names: Vec<(String, usize)>,
    /// The column of time stamps, and their unit.
    time: Option<(String, Clock)>,
    /// Positions of the channels among `names`.
    channels: Vec<usize>,
    /// Keys that are no channels, and why.
    pub left_out: Vec<String>,
    /// Keys of text whose values look like numbers.
    pub doubts: Vec<String>,
}

impl JsonColumns {
    /// Finds the columns of a file by its first line, and what they are by all of them. Keys that are named in the options or
    /// that a model reads are channels whatever they are called. Says why there are none in the inner result.
    pub fn of(
        mut steps: impl Iterator<Item = Result<(usize, TimeStep)>>,
        options: &TableOptions,
        model: &[String],
    ) -> Result<Result<Self, String>> {
        let Some((line, first)) = steps.next().transpose()? else {
            return Ok(Ok(Self {
                names: vec![],
                time: None,
                channels: vec![],
                left_out: vec![],
                doubts: vec![],
            }));
        };
        let is_array = matches!(first.names.as_slice(), [(name, _)] if name.is_empty());
        if is_array {
            return Ok(Ok(Self {
                names: first.names,
                time: None,
                channels: vec![0],
                left_out: vec![],
                doubts: vec![],
            }));
        }
        let texts = first.texts.iter().map(|(name, _)| (name.clone(), 0));
        let keys: Vec<(String, usize)> = first.names.iter().cloned().chain(texts).collect();
        if let Err(why) = all_known(&keys, options, !model.is_empty()) {
            return Ok(Err(why));
        }
        let mut cells: Vec<ColumnCells> = keys.iter().map(|(name, _)| ColumnCells::new(Some(name))).collect();
        let mut decorated: Vec<DecoratedCells> = keys.iter().map(|_| DecoratedCells::default()).collect();
        let mut add = |line: usize, step: &TimeStep| {
            let mut is_open = false;
            let columns = keys.iter().zip(cells.iter_mut().zip(&mut decorated));
            for ((name, _), (cells, decorated)) in columns.filter(|(_, (cells, _))| cells.is_open()) {
                match (step.text(name), step.number(name)) {
                    (Some(text), _) => {
                        cells.add(line as u64, text, None);
                        decorated.add(text, || format!("line {line}"));
                    }
                    (None, Some(number)) => cells.add(line as u64, "", Some(number)),
                    (None, None) => {}
                }
                is_open |= cells.is_open();
            }
            is_open
        };
        let mut is_open = add(line, &first);
        while let Some((line, step)) = steps.next().filter(|_| is_open).transpose()? {
            is_open = add(line, &step);
        }
        let kinds = cells.into_iter().map(ColumnCells::kind);
        let doubts = keys.iter().zip(&decorated);
        let doubts = doubts.map(|((name, _), cells)| (name.clone(), cells.of_text("key", name))).collect();
        Ok(Self { names: first.names, time: None, channels: vec![], left_out: vec![], doubts: vec![] }
            .with(keys, kinds, options, model)
            .map(|found| found.doubting(doubts)))
    }

    /// Keeps the doubts about keys that are passed over as text.
    fn doubting(mut self, doubts: Vec<(String, Option<String>)>) -> Self {
        let is_text = |name: &String| self.left_out.contains(&format!("key {name:?} (text)"));
        self.doubts =
            doubts.into_iter().filter(|(name, _)| is_text(name)).filter_map(|(_, words)| words).collect();
        self
    }

    /// Gives the keys their roles.
    fn with(
        mut self,
        keys: Vec<(String, usize)>,
        kinds: impl Iterator<Item = ColumnKind>,
        options: &TableOptions,
        model: &[String],
    ) -> Result<Self, String> {
        for (at, ((name, count), kind)) in keys.into_iter().zip(kinds).enumerate() {
            if options.ignore.contains(&name) {
                self.left_out.push(format!("key {name:?}"));
                continue;
            }
            let is_single = count <= 1;
            let is_of_model = model.iter().any(|channel| is_channel_of(channel, &name));
            let is_wanted = count > 0 && (is_of_model || options.columns.contains(&name));
            let is_time = options.time.as_ref().is_some_and(|time| *time == name);
            let other_name = !is_single && ColumnName::of(&name) != ColumnName::Open;
            match kind {
                ColumnKind::Time(clock) if is_single && (is_time || self.may_be_time(options, is_wanted)) => {
                    self.time = Some((name, options.clock.unwrap_or(clock)));
                }
                _ if is_time => self.time = Some((name, options.clock.unwrap_or(Clock::Seconds))),
                _ if is_wanted => self.channels.push(at),
                ColumnKind::Disguised(first) => {
                    let (line, cell, hint) = (first.line, first.cell, first.form.hint());
                    return Err(format!(
                        "line {line}, key {name:?}: {cell:?} {hint}, or name it with table.ignore"
                    ));
                }
                _ if !options.columns.is_empty() => {}
                ColumnKind::Time(_) => self.left_out.push(format!("key {name:?} (time)")),
                ColumnKind::LeftOut(why) if is_single => self.left_out.push(format!("key {name:?} ({why})")),
                _ if other_name && matches!(ColumnName::of(&name), ColumnName::Time(_)) => {
                    self.left_out.push(format!("key {name:?} (time)"));
                }
                _ if count == 0 => self.left_out.push(format!("key {name:?} (text)")),
                _ => self.channels.push(at),
            }
        }
        let place = |at: &usize| options.columns.iter().position(|name| *name == self.names[*at].0);
        self.channels.sort_by_key(place);
        Ok(self)
    }

    fn may_be_time(&self, options: &TableOptions, is_wanted: bool) -> bool {
        options.time.is_none() && self.time.is_none() && !is_wanted
    }

    /// Counts the channels.
    pub fn width(&self) -> usize {
        self.channels.iter().map(|at| self.names[*at].1).sum()
    }

    /// Returns the names of the channels; empty where a line is an array.
    pub fn channel_names(&self) -> Vec<String> {
        numbered(self.channels.iter().map(|at| (self.names[*at].0.as_str(), self.names[*at].1)))
    }

    /// Returns the time stamp of a step, where there are some, and its unit; none of one that has no number there.
    pub fn stamp(&self, step: &TimeStep) -> Option<(Option<f64>, Clock)> {
        let (name, clock) = self.time.as_ref()?;
        Some((step.number(name).or_else(|| time_text::seconds(step.text(name)?)), *clock))
    }

    /// Returns the values of the channels of a step that is arranged.
    pub fn values(&self, step: &TimeStep) -> impl Iterator<Item = f64> {
        let start = |column: usize| self.names[..column].iter().map(|(_, count)| count).sum::<usize>();
        self.channels.iter().flat_map(move |at| {
            let start = start(*at);
            step.numbers[start..start + self.names[*at].1].iter().copied()
        })
    }

    /// Says for the card how lines were read.
    pub fn described(&self) -> String {
        let time = self.time.as_ref().map(|(name, clock)| format!(", time by {name:?} in {}", clock.name()));
        format!("{}{}", crate::error::plural(self.width(), "channel"), time.unwrap_or_default())
    }
}

/// Refuses keys that the options name and the first line has not.
fn all_known(keys: &[(String, usize)], options: &TableOptions, is_model: bool) -> Result<(), String> {
    let named = [("ignore", &options.ignore), ("columns", &options.columns)];
    let all = named.into_iter().flat_map(|(option, names)| names.iter().map(move |name| (option, name)));
    // A model remembers the time of its table.
    let time = options.time.iter().filter(|_| !is_model).map(|name| ("time", name));
    for (option, name) in all.chain(time) {
        if !keys.iter().any(|(key, _)| key == name) {
            let held = keys.iter().map(|(key, _)| key.as_str()).collect::<Vec<_>>().join(", ");
            return Err(format!("has no key {name:?}, which table.{option} names; it has {held}"));
        }
    }
    Ok(())
}

/// Checks whether a channel is one of the numbers under a key: `taxels` or `taxels[3]`.
fn is_channel_of(channel: &str, key: &str) -> bool {
    channel
        .strip_prefix(key)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('[') && rest.ends_with(']'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_of_a_key_by_its_whole_index() {
        for channel in ["taxels", "taxels[3]"] {
            assert!(is_channel_of(channel, "taxels"), "{channel}");
        }
        for channel in ["taxels[3", "taxels2]", "tax", "taxels_left"] {
            assert!(!is_channel_of(channel, "taxels"), "{channel}");
        }
    }
}
