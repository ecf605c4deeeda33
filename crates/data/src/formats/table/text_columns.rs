//! Reads the cells of a table in CSV or Parquet, with the place of each for messages.

use crate::dataset::precision::Precision;
use crate::formats::csv_file;
#[cfg(feature = "parquet")]
use crate::formats::parquet_file::ParquetFile;
use crate::formats::table::options::Clock;
use crate::formats::text::{csv_reader, read_text, without_mark};
use crate::options::Limits;
use crate::{Error, Result};
use std::path::Path;

/// A table as text: its header, and its rows one after the other.
pub(crate) struct TableText {
    pub file: String,
    pub header: Vec<String>,
    /// Rows of a recording follow one another.
    pub is_in_order: bool,
    rows: RowSource,
}

enum RowSource {
    Csv {
        text: String,
        separator: u8,
    },
    /// Of equal columns, one after the other.
    #[cfg(feature = "parquet")]
    Parquet(Vec<ParquetFile>),
}

/// One row; `line` is its line in CSV, its number in its file of Parquet.
pub(crate) struct TableRow<'t> {
    pub line: u64,
    /// The file that holds it.
    pub file: &'t str,
    record: &'t csv::StringRecord,
    table: &'t TableText,
}

impl TableText {
    /// Refuses two columns of one name.
    pub fn with_different_names(self) -> Result<Self> {
        let mut columns = self.header.iter().enumerate();
        let twice = columns.find(|(at, name)| !name.is_empty() && self.header[..*at].contains(name));
        match twice {
            Some((_, name)) => Err(self.refuse(format!("two columns are named {name:?}; rename one"))),
            None => Ok(self),
        }
    }

    /// Opens a table that is one file of Parquet.
    #[cfg(feature = "parquet")]
    pub fn of_parquet(path: &Path, limits: &Limits) -> Result<Self> {
        Self::of_files(path.display().to_string(), &[path.to_path_buf()], limits)
    }

    /// Opens a table of which each file of Parquet holds some rows.
    #[cfg(feature = "parquet")]
    pub fn of_files(file: String, paths: &[std::path::PathBuf], limits: &Limits) -> Result<Self> {
        let (mut files, mut header): (Vec<ParquetFile>, Vec<String>) = (vec![], vec![]);
        for path in paths {
            let opened = ParquetFile::open(path, limits)?;
            if files.is_empty() {
                header = opened.header();
            } else if opened.header() != header {
                return Err(Error::file(path, format!("has other columns than {}", paths[0].display())));
            }
            files.push(opened);
        }
        Ok(Self { file, header, is_in_order: false, rows: RowSource::Parquet(files) })
    }

    /// Opens a table that is text.
    pub fn of_csv(path: &Path, limits: &Limits) -> Result<Self> {
        let file = path.display().to_string();
        let mut text = read_text(path, limits)?;
        text.drain(..text.len() - without_mark(&text).len());
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let count = |separator: &u8| first.bytes().filter(|byte| byte == separator).count();
        // The last of several that are equally frequent: the comma.
        let separator = [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',');
        let mut header = csv::StringRecord::new();
        let is_there =
            csv_reader(&text, separator, false).read_record(&mut header).map_err(Error::csv(&file))?;
        let header: Vec<String> = header.iter().map(String::from).collect();
        if !is_there || header.iter().all(String::is_empty) {
            return Err(Error::EmptyFile { file });
        }
        if header.iter().all(|name| name.parse::<f64>().is_ok()) {
            let why = "its first line is all numbers; write the names of the columns there, or, where the file is \
                       one recording, put it in a folder of its class";
            return Err(Error::file(file, why));
        }
        Ok(Self { file, header, is_in_order: false, rows: RowSource::Csv { text, separator } })
    }

    /// Checks whether a column holds numbers of more than 32 bits.
    pub fn is_wide(&self, at: usize) -> bool {
        match (&self.rows, at) {
            (RowSource::Csv { .. }, _) => true,
            #[cfg(feature = "parquet")]
            (RowSource::Parquet(files), at) => files.iter().any(|file| file.is_wide(at)),
        }
    }

    /// Returns the unit of a column whose type says that it holds time stamps.
    pub fn clock(&self, at: usize) -> Option<Clock> {
        match (&self.rows, at) {
            (RowSource::Csv { .. }, _) => None,
            #[cfg(feature = "parquet")]
            (RowSource::Parquet(files), at) => files.iter().find_map(|file| file.clock(&self.header[at])),
        }
    }

    /// Refuses channels whose signal f32 does not hold; `channels` are their columns.
    pub fn refuse_lossy(&self, precision: &Precision, channels: &[usize]) -> Result<()> {
        let Some(lossy) = precision.lossy() else { return Ok(()) };
        let name = channels.get(lossy.channel).map_or("", |at| &self.header[*at]);
        Err(self.refuse(format!("column {name:?} {lossy} with table.ignore")))
    }

    /// Checks whether rows are lines of text.
    pub fn is_text(&self) -> bool {
        matches!(self.rows, RowSource::Csv { .. })
    }

    /// Refuses rows of a recording that do not follow one another.
    #[cfg(feature = "parquet")]
    pub fn in_order(self) -> Self {
        Self { is_in_order: true, ..self }
    }

    /// Returns the name of the format of the values.
    pub fn dtype(&self) -> &'static str {
        match self.rows {
            RowSource::Csv { .. } => "csv",
            #[cfg(feature = "parquet")]
            RowSource::Parquet(_) => "parquet",
        }
    }

    /// Estimates the number of rows, at most as many as its bytes can hold, to reserve memory.
    pub fn likely_rows(&self, channels: usize) -> usize {
        let (rows, values) = match &self.rows {
            // A value takes two bytes at least: a digit and a separator.
            RowSource::Csv { text, .. } => {
                (text.bytes().filter(|byte| *byte == b'\n').count() + 1, text.len() / 2)
            }
            #[cfg(feature = "parquet")]
            RowSource::Parquet(files) => files.iter().fold((0, 0), |(rows, values), file| {
                (rows + file.rows, usize::saturating_add(values, file.bytes))
            }),
        };
        rows.min(values / channels.max(1))
    }

    /// Hands every row to `take` until it returns false.
    pub fn rows(&self, mut take: impl FnMut(TableRow) -> Result<bool>) -> Result<()> {
        let (text, separator) = match &self.rows {
            RowSource::Csv { text, separator } => (text, *separator),
            #[cfg(feature = "parquet")]
            RowSource::Parquet(files) => {
                for file in files {
                    let name = file.name();
                    if !file.rows(|line, record| take(TableRow { line, file: name, record, table: self }))? {
                        break;
                    }
                }
                return Ok(());
            }
        };
        let mut reader = csv_reader(text, separator, false);
        let mut record = csv::StringRecord::new();
        let mut is_header = true;
        while reader.read_record(&mut record).map_err(Error::csv(&self.file))? {
            #[expect(clippy::expect_used, reason = "a reader notes where a record starts")]
            let start = record.position().expect("a record that was read");
            let line = csv_file::line_of(text, start);
            if record.len() != self.header.len() {
                let (file, got, want) = (self.file.clone(), record.len(), self.header.len());
                return Err(Error::RaggedCsv { file, line, got, first_line: 1, want });
            }
            if std::mem::take(&mut is_header) {
                continue;
            }
            if !take(TableRow { line, file: &self.file, record: &record, table: self })? {
                break;
            }
        }
        Ok(())
    }

    /// Divides the columns `places` into those in which a row holds a number, and the others.
    pub fn numeric(&self, places: Vec<usize>) -> Result<(Vec<usize>, Vec<usize>)> {
        let mut is_numeric = vec![false; self.header.len()];
        self.rows(|row| {
            let mut is_open = false;
            for at in &places {
                is_numeric[*at] |= row.text(*at).parse::<f32>().is_ok();
                is_open |= !is_numeric[*at];
            }
            Ok(is_open)
        })?;
        // A date is no value of a sensor.
        Ok(places.into_iter().partition(|at| is_numeric[*at] && self.clock(*at).is_none()))
    }

    pub fn refuse(&self, why: String) -> Error {
        Error::file(&self.file, why)
    }
}

impl TableRow<'_> {
    pub fn text(&self, at: usize) -> &str {
        self.record.get(at).unwrap_or_default()
    }

    /// Reads a text that must be there.
    pub fn named(&self, at: usize) -> Result<String> {
        match self.text(at) {
            "" => Err(self.refuse(at, "is empty")),
            text => Ok(text.into()),
        }
    }

    pub fn number(&self, at: usize) -> Result<f32> {
        self.text(at).parse().map_err(|_| self.no_number(at))
    }

    /// Reads a number of 64 bits.
    pub fn long_number(&self, at: usize) -> Result<f64> {
        self.text(at).parse().map_err(|_| self.no_number(at))
    }

    /// Reads a time stamp, which is finite.
    pub fn stamp(&self, at: usize) -> Result<f64> {
        let stamp = self.text(at).parse::<f64>().ok().filter(|stamp| stamp.is_finite());
        stamp
            .ok_or_else(|| self.refuse(at, "is no time stamp; write seconds as a number, or say table.clock"))
    }

    /// Reads a mark of a sample to test on: a whole number, or `train` and `test`.
    pub fn mark(&self, at: usize) -> Result<i64> {
        let text = self.text(at);
        match (text.parse::<i64>(), text.to_lowercase().as_str()) {
            (Ok(mark), _) => Ok(mark),
            (_, "train" | "training" | "false") => Ok(0),
            (_, "test" | "testing" | "true") => Ok(1),
            _ => Err(self.refuse(at, "is no mark; write 0 or train, and 1 or test")),
        }
    }

    fn no_number(&self, at: usize) -> Error {
        let text = self.text(at);
        let why = match (text.is_empty(), text.contains(',')) {
            (true, _) => "is empty; fill it in or leave its row out",
            (_, true) => "is not a number; write decimals with points",
            _ => "is not a number; correct it, or name a column that is no channel with table.ignore",
        };
        self.refuse(at, why)
    }

    fn refuse(&self, at: usize, why: &'static str) -> Error {
        let column = &self.table.header[at];
        let text: String = self.text(at).chars().take(40).collect();
        Error::file(self.file, format!("{}, column {column}: {text:?} {why}", self.place()))
    }

    /// Returns the name of its place in its file: a line of text, a row of Parquet.
    pub fn place(&self) -> String {
        let kind = if self.table.is_text() { "line" } else { "row" };
        format!("{kind} {}", self.line)
    }

    /// Refuses the row.
    pub fn refused(&self, why: &str) -> Error {
        Error::file(self.file, format!("{}: {why}", self.place()))
    }
}
