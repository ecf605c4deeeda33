//! Finds the channels and the time of a text that is one recording.

use crate::dataset::channel_names::{listed, places};
use crate::formats::table::column_kind::ColumnKind;
use crate::formats::table::decorated::doubts_of_texts;
use crate::formats::table::options::Clock;
use crate::formats::table::text_columns::TableText;
use crate::options::ReadOptions;
use crate::{Error, Result};

/// The columns of one recording by their role.
pub(crate) struct RecordingColumns {
    pub time: Option<(usize, Clock)>,
    /// The channels in their order.
    pub channels: Vec<usize>,
    /// Columns that are no channels, and why, for the card.
    pub left_out: Vec<String>,
    /// Columns of text whose cells look like numbers.
    pub doubts: Vec<String>,
}

impl RecordingColumns {
    /// Finds the columns. Channels are those that the options or the model name, else all numbers that are neither time nor an
    /// index.
    pub fn of(table: &TableText, options: &ReadOptions) -> Result<Self> {
        let ignored: Vec<usize> = positions(table, &options.table.ignore, "table.ignore")?;
        let is_model = !options.channel_names.is_empty();
        // What is known of a table says nothing of a file without names.
        let wanted = if !options.table.columns.is_empty() && table.is_named {
            Some(positions(table, &options.table.columns, "table.columns")?)
        } else if table.is_named && is_model {
            Some(positions(table, &options.channel_names, "")?)
        } else {
            None
        };
        let open: Vec<usize> = (0..table.header.len()).filter(|at| !ignored.contains(at)).collect();
        let kinds = table.kinds(&open)?;
        let named = match &options.table.time {
            Some(name) if is_model => position(table, name, "table.time").ok(),
            Some(name) => Some(position(table, name, "table.time")?),
            None => None,
        };
        let mut found = Self { time: None, channels: vec![], left_out: vec![], doubts: vec![] };
        let mut texts = vec![];
        for (at, kind) in open.into_iter().zip(kinds) {
            let is_wanted = wanted.as_ref().is_some_and(|wanted| wanted.contains(&at));
            let is_time = named == Some(at);
            match kind {
                ColumnKind::Time(clock)
                    if is_time || named.is_none() && found.time.is_none() && !is_wanted =>
                {
                    found.time = Some((at, options.table.clock.unwrap_or(clock)));
                }
                _ if is_time => found.time = Some((at, options.table.clock.unwrap_or(Clock::Seconds))),
                ColumnKind::Disguised(first) if is_wanted || wanted.is_none() => {
                    return Err(table.refuse_disguised(at, &first));
                }
                ColumnKind::Text if is_wanted && table.is_named => {
                    let why =
                        format!("column {:?} is to be a channel and holds no numbers", table.header[at]);
                    return Err(table.refuse(why));
                }
                _ if wanted.is_some() => {}
                // Without names the first cell is refused.
                ColumnKind::Text if !table.is_named => found.channels.push(at),
                ColumnKind::Channel => found.channels.push(at),
                ColumnKind::Time(_) => found.leave_out(table, at, "time"),
                ColumnKind::LeftOut(why) => found.leave_out(table, at, why),
                ColumnKind::Text | ColumnKind::Disguised(_) => {
                    texts.push(at);
                    found.leave_out(table, at, "text");
                }
            }
        }
        found.left_out.extend(ignored.iter().map(|at| format!("column {:?}", table.header[*at])));
        if let Some(wanted) = wanted {
            found.channels = wanted;
        }
        found.doubts = doubts_of_texts(table, &texts)?;
        if found.channels.is_empty() {
            return Err(no_channels(table)?);
        }
        Ok(found)
    }

    fn leave_out(&mut self, table: &TableText, at: usize, why: &str) {
        self.left_out.push(format!("column {:?} ({why})", table.header[at]));
    }

    /// Brings the channels into the order of those of the first file, which has the same names.
    pub fn arrange(&mut self, table: &TableText, names: &[String], first: &str) -> Result<()> {
        let how = "use the same columns in all files, or name those to read with table.columns";
        let refuse = |why: String| table.refuse(format!("{why}; {how}"));
        let held: Vec<String> = self.channels.iter().map(|at| table.header[*at].clone()).collect();
        let by_name = places(names, &held).map_err(|why| refuse(format!("{why}, and {first} has it")))?;
        if let Some(name) = held.iter().find(|name| !names.contains(name)) {
            return Err(refuse(format!("has a channel {name:?}, and {first} has none")));
        }
        if let Some(places) = by_name {
            self.channels = places.into_iter().map(|at| self.channels[at]).collect();
        }
        Ok(())
    }
}

/// Says why a file has no channels.
fn no_channels(table: &TableText) -> Result<Error> {
    let mut has_rows = false;
    table.rows(|_| {
        has_rows = true;
        Ok(false)
    })?;
    if !has_rows {
        return Ok(table.refuse("holds a header but no rows; one row per time step".into()));
    }
    let held = listed(&table.header);
    Ok(table.refuse(format!("has no column of numbers that is a channel; it has {held}")))
}

/// Finds the columns that an option names; without an option the channels of a model.
fn positions(table: &TableText, names: &[String], option: &str) -> Result<Vec<usize>> {
    names.iter().map(|name| position(table, name, option)).collect()
}

fn position(table: &TableText, name: &str, option: &str) -> Result<usize> {
    let at = table.header.iter().position(|column| column == name);
    at.or_else(|| table.header.iter().position(|column| column.eq_ignore_ascii_case(name)))
        .ok_or_else(|| missing(table, name, option))
}

fn missing(table: &TableText, name: &str, option: &str) -> Error {
    let held = listed(&table.header);
    table.refuse(match option {
        "" => format!("has no channel {name:?}, which the model reads; it has {held}; rename the column"),
        option => format!("has no column {name:?}, which {option} names; it has {held}"),
    })
}
