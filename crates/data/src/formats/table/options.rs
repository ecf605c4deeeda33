//! Options of a table: the roles of its columns, where the header does not say them.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// How a table of many recordings is read; by default its header says it.
///
/// The columns of labels, groups and test marks are named by [`ReadOptions::y`](field@crate::ReadOptions::y),
/// [`ReadOptions::group`](crate::ReadOptions::group) and [`ReadOptions::test`](crate::ReadOptions::test).
///
/// As text, on a command line: `long`, `wide`, `long,recording=grasp,time=stamp,clock=ms,ignore=id`, `wide,shape=16x16`.
/// The empty text is the default.
///
/// ```
/// use taxel_data::{Clock, TableForm, TableOptions};
///
/// let table: TableOptions = "long,recording=grasp,clock=ms".parse()?;
/// assert_eq!((table.form, table.clock), (Some(TableForm::Long), Some(Clock::Milliseconds)));
/// assert_eq!(table.key(), r#"table = { form = "long", recording = "grasp", clock = "ms" }"#);
/// # Ok::<(), taxel_data::NotATable>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct TableOptions {
    /// Meaning of a row. Default long where there is a column of recordings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<TableForm>,
    /// The column that names the recording of a row. Default `recording`, `series` or `sequence`, also with `_id`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// The column of time stamps of a long table. Default `time`, `timestamp` or `t`, also with a unit: `time_ms`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// The unit of the time stamps. Default the end of the column's name, else seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock: Option<Clock>,
    /// Columns that are no channels, such as `id`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignore: Vec<String>,
    /// Columns that are the channels, in this order. Default all that hold numbers and have no other role.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// Axes that the channels of a row have, the last one fastest: `[16, 16]` of 256 taxels. A row of a wide table is
    /// then an image `[H, W]`, or with three axes what the layout says (`[3, H, W]` with `colour`); the rows of a
    /// recording are a sequence `[T, H, W]`. Default none: a row is a list.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shape: Vec<usize>,
}

/// Meaning of a row of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TableForm {
    /// One time step of all channels; the rows of a recording are its time steps.
    Long,
    /// One sample; its columns are features.
    Wide,
}

/// The unit of time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Clock {
    /// Seconds.
    #[serde(rename = "s")]
    Seconds,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Milliseconds,
    /// Microseconds.
    #[serde(rename = "us")]
    Microseconds,
    /// Nanoseconds.
    #[serde(rename = "ns")]
    Nanoseconds,
}

/// A text that does not say how a table is read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{text:?} is neither long nor wide, nor recording=NAME, time=NAME, clock=s, ms, us or ns, ignore=NAME, column=NAME or \
     shape=16x16; part several with commas"
)]
pub struct NotATable {
    text: String,
}

impl Clock {
    const ALL: [Self; 4] = [Self::Seconds, Self::Milliseconds, Self::Microseconds, Self::Nanoseconds];

    /// Returns the unit as it is written: `s`, `ms`, `us`, `ns`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Microseconds => "us",
            Self::Nanoseconds => "ns",
        }
    }

    /// Returns the number of units in a second.
    pub fn per_second(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e3,
            Self::Microseconds => 1e6,
            Self::Nanoseconds => 1e9,
        }
    }

    /// Finds the unit of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|clock| clock.name() == name)
    }
}

impl TableForm {
    /// Returns `long` or `wide`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Long => "long",
            Self::Wide => "wide",
        }
    }
}

impl TableOptions {
    /// Writes the options as in a config: `table = { form = "long" }`.
    pub fn key(&self) -> String {
        let word = |key: &str, word: Option<&str>| word.map(|word| format!("{key} = {word:?}"));
        let list = |key: &str, names: &[String]| (!names.is_empty()).then(|| format!("{key} = {names:?}"));
        let keys = [
            word("form", self.form.map(TableForm::name)),
            word("recording", self.recording.as_deref()),
            word("time", self.time.as_deref()),
            word("clock", self.clock.map(Clock::name)),
            list("ignore", &self.ignore),
            list("columns", &self.columns),
            (!self.shape.is_empty()).then(|| format!("shape = {:?}", self.shape)),
        ];
        format!("table = {{ {} }}", keys.into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

/// Parses axes as they are written: `16x16`; none of them is 0.
fn axes_of(text: &str) -> Option<Vec<usize>> {
    text.split('x').map(|axis| axis.parse().ok().filter(|axis| *axis > 0)).collect()
}

impl Display for TableForm {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for TableOptions {
    type Err = NotATable;

    fn from_str(text: &str) -> Result<Self, NotATable> {
        let mut table = Self::default();
        if text.is_empty() {
            return Ok(table);
        }
        for word in text.split(',').map(str::trim) {
            let refused = || NotATable { text: word.into() };
            match word.split_once('=').map(|(key, name)| (key.trim(), name.trim())) {
                None if word == "long" => table.form = Some(TableForm::Long),
                None if word == "wide" => table.form = Some(TableForm::Wide),
                Some(("recording", name)) if !name.is_empty() => table.recording = Some(name.into()),
                Some(("time", name)) if !name.is_empty() => table.time = Some(name.into()),
                Some(("clock", name)) if Clock::named(name).is_some() => table.clock = Clock::named(name),
                Some(("ignore", name)) if !name.is_empty() => table.ignore.push(name.into()),
                Some(("column", name)) if !name.is_empty() => table.columns.push(name.into()),
                Some(("shape", axes)) => table.shape = axes_of(axes).ok_or_else(refused)?,
                _ => return Err(refused()),
            }
        }
        Ok(table)
    }
}
