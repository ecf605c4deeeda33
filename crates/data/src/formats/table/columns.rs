//! Finds the roles of the columns of a table, by options and header.

use crate::dataset::channel_names::listed;
use crate::formats::table::column_kind::ColumnKind;
use crate::formats::table::column_name::ColumnName;
use crate::formats::table::options::{Clock, TableForm, TableOptions};
use crate::formats::table::text_columns::TableText;
use crate::options::ReadOptions;
use crate::{Error, Result};

/// Names of the column of recordings, also followed by `_id`.
const RECORDING: [&str; 3] = ["recording", "series", "sequence"];
/// Names of the column of labels; the first that is there counts. `y` is one too, but not beside `x`: then it is an axis.
const LABEL: [&str; 3] = ["label", "class", "target"];

/// The columns of a table by their role, as positions.
pub(crate) struct TableColumns {
    pub form: TableForm,
    pub recording: Option<usize>,
    pub time: Option<(usize, Clock)>,
    /// Labels, or values of several quantities.
    pub labels: Vec<usize>,
    pub group: Option<usize>,
    /// Marks of the samples to test on.
    pub test: Option<usize>,
    /// Columns that may be channels: the named ones, or all others that are not ignored.
    pub rest: Vec<usize>,
    /// Columns that are no channels, and why.
    pub left_out: Vec<(usize, &'static str)>,
    /// Axes of the channels of a row; none where they are a list.
    pub shape: Vec<usize>,
}

impl TableColumns {
    /// Finds the columns in the `header`. A label is `needed` of a set to learn from.
    pub fn of(header: &[String], file: &str, options: &ReadOptions, needed: bool) -> Result<Self> {
        let header = Header { names: header, file };
        let table = &options.table;
        let ignored = |name: &String| header.named(name, "table.ignore");
        let ignored: Vec<usize> = table.ignore.iter().map(ignored).collect::<Result<_>>()?;
        let recording = header.recording(options, needed)?;
        let time = header.time(table, &ignored)?;
        let form = match (table.form, recording, time) {
            (Some(form), _, _) => form,
            (None, Some(_), _) => TableForm::Long,
            (None, None, None) => TableForm::Wide,
            (None, None, Some((at, _))) => {
                let time = &header.names[at];
                return Err(header.refuse(format!(
                    "has a column {time:?} but none that says which recording a row belongs to; name it with \
                     table.recording, or set table.form = \"wide\" where each row is a sample"
                )));
            }
        };
        if form == TableForm::Long && recording.is_none() {
            return Err(header.missing("recording", "table.recording"));
        }
        let labels: Vec<usize> = if options.names_y() {
            let option = options.y_option();
            options.y_names().iter().map(|name| header.named(name, option)).collect::<Result<_>>()?
        } else {
            let usual = LABEL.iter().find_map(|name| header.find(name)).or_else(|| header.lone_y());
            usual.into_iter().collect()
        };
        if needed && labels.is_empty() {
            return Err(header.missing("label", "y"));
        }
        let group = match &options.group {
            Some(name) => Some(header.named(name, "group")?),
            None => header.find("group"),
        };
        let test = options.test.as_ref().map(|name| header.named(name, "test")).transpose()?;
        let used = [recording, time.map(|(at, _)| at), group, test];
        let is_ignored = |at: usize| {
            // Another column of classes would give the answer away.
            ignored.contains(&at) || is_like_a_role(&header.names[at])
        };
        let is_free = |at: &usize| !used.contains(&Some(*at)) && !labels.contains(at) && !is_ignored(*at);
        let named = |name: &String| header.named(name, "table.columns");
        let rest = if table.columns.is_empty() {
            (0..header.names.len()).filter(is_free).collect()
        } else {
            table.columns.iter().map(named).collect::<Result<_>>()?
        };
        let shape = table.shape.clone();
        Ok(Self { form, recording, time, labels, group, test, rest, left_out: vec![], shape })
    }

    /// Decides by their cells what the columns are that may be channels: leaves the channels in `rest` and returns those of
    /// texts. Columns that the options name are channels whatever they are called.
    pub fn settle(&mut self, table: &TableText, options: &ReadOptions) -> Result<Vec<usize>> {
        let is_named = !options.table.columns.is_empty();
        let looked_at: Vec<usize> = self.rest.iter().copied().chain(self.time.map(|(at, _)| at)).collect();
        let (mut channels, mut texts) = (vec![], vec![]);
        let kinds = table.kinds(&looked_at)?;
        for (place, (at, kind)) in looked_at.into_iter().zip(kinds).enumerate() {
            let is_time = place == self.rest.len();
            match kind {
                ColumnKind::Time(clock) if is_time => {
                    self.time = Some((at, options.table.clock.unwrap_or(clock)));
                }
                _ if is_time => {}
                ColumnKind::Disguised(first) => return Err(table.refuse_disguised(at, &first)),
                ColumnKind::Text if is_named => {
                    let name = &table.header[at];
                    return Err(
                        table.refuse(format!("column {name:?} is to be a channel and holds no numbers"))
                    );
                }
                ColumnKind::Channel => channels.push(at),
                _ if is_named => channels.push(at),
                ColumnKind::Text => texts.push(at),
                ColumnKind::Time(clock) if self.form == TableForm::Long && self.time.is_none() => {
                    self.time = Some((at, options.table.clock.unwrap_or(clock)));
                }
                ColumnKind::Time(_) => self.left_out.push((at, "time")),
                ColumnKind::LeftOut(why) => self.left_out.push((at, why)),
            }
        }
        self.rest = channels;
        Ok(texts)
    }

    /// Lists the columns that are used beside the channels; the time of a sample is no feature of it.
    pub fn used(&self) -> impl Iterator<Item = usize> {
        let time = self.time.filter(|_| self.form == TableForm::Long).map(|(at, _)| at);
        let one = [self.recording, time, self.group, self.test];
        one.into_iter().flatten().chain(self.labels.iter().copied())
    }
}

/// Finds the column of recordings by its usual names.
pub(crate) fn recording_in(names: &[String]) -> Option<usize> {
    let is_it = |name: &String| {
        let name = name.to_lowercase();
        RECORDING.contains(&name.strip_suffix("_id").unwrap_or(&name))
    };
    names.iter().position(is_it)
}

/// Checks whether a column without a role is called like one with a role.
fn is_like_a_role(name: &str) -> bool {
    let is_named = LABEL.iter().chain(&["group"]).any(|role| role.eq_ignore_ascii_case(name));
    is_named || recording_in(&[name.into()]).is_some()
}

/// The names of the columns.
struct Header<'h> {
    names: &'h [String],
    file: &'h str,
}

impl Header<'_> {
    fn find(&self, name: &str) -> Option<usize> {
        let exact = self.names.iter().position(|column| column == name);
        exact.or_else(|| self.names.iter().position(|column| column.eq_ignore_ascii_case(name)))
    }

    fn lone_y(&self) -> Option<usize> {
        self.find("y").filter(|_| self.find("x").is_none())
    }

    /// Finds the column that an option names.
    fn named(&self, name: &str, option: &'static str) -> Result<usize> {
        self.find(name).ok_or_else(|| self.missing(name, option))
    }

    /// Finds the column of recordings: the named one, or that of a usual name. One that a model was trained with (not
    /// `needed`) may be missing.
    fn recording(&self, options: &ReadOptions, needed: bool) -> Result<Option<usize>> {
        match (&options.table.recording, &options.recording) {
            (Some(name), Some(other)) if name != other && needed => {
                let why =
                    format!("recording = {other:?} and table.recording = {name:?} are two columns; say one");
                Err(self.refuse(why))
            }
            (Some(name), _) => self.named(name, "table.recording").map(Some),
            (None, Some(name)) if needed => self.named(name, "recording").map(Some),
            (None, Some(name)) => Ok(self.find(name).or_else(|| recording_in(self.names))),
            (None, None) => Ok(recording_in(self.names)),
        }
    }

    /// Finds the column of time stamps: the named one, or that of a usual name that is not `ignored`.
    fn time(&self, table: &TableOptions, ignored: &[usize]) -> Result<Option<(usize, Clock)>> {
        let is_time = |at: &usize| matches!(ColumnName::of(&self.names[*at]), ColumnName::Time(_));
        let at = match &table.time {
            Some(name) => Some(self.named(name, "table.time")?),
            None => (0..self.names.len()).find(|at| !ignored.contains(at) && is_time(at)),
        };
        let clock = |at: usize| table.clock.or(Clock::of_column(&self.names[at])).unwrap_or(Clock::Seconds);
        Ok(at.map(|at| (at, clock(at))))
    }

    fn missing(&self, name: &str, option: &'static str) -> Error {
        let held = listed(self.names);
        self.refuse(format!("has no column {name:?}; name one with {option}. It has {held}"))
    }

    fn refuse(&self, why: String) -> Error {
        Error::file(self.file, why)
    }
}
