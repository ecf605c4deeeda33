//! The cells of a table in CSV or Parquet, with the place of each for messages.

use crate::formats::csv_file;
#[cfg(feature = "parquet")]
use crate::formats::parquet_file::ParquetFile;
use crate::formats::text::read_text;
use crate::options::Limits;
use crate::{Error, Result};
use std::path::Path;

/// A table as text: its header, and its rows one after the other.
pub(crate) struct TableText {
    pub file: String,
    pub header: Vec<String>,
    source: Source,
}

enum Source {
    Csv {
        text: String,
        separator: u8,
    },
    /// Of equal columns, one after the other.
    #[cfg(feature = "parquet")]
    Parquet(Vec<ParquetFile>),
}

/// One row; `line` is its line in CSV, its number in Parquet.
pub(crate) struct Row<'t> {
    pub line: u64,
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

    /// A table of which each file of Parquet holds some rows.
    #[cfg(feature = "parquet")]
    pub fn of_files(file: String, paths: &[std::path::PathBuf], limits: &Limits) -> Result<Self> {
        let mut table = Self { file, header: vec![], source: Source::Parquet(vec![]) };
        let mut files: Vec<ParquetFile> = vec![];
        for path in paths {
            let own = ParquetFile::open(path, limits)?;
            match files.first() {
                None => table.header = own.header(),
                Some(_) if own.header() != table.header => {
                    let why = format!("has other columns than {}", paths[0].display());
                    return Err(Error::Table { file: path.display().to_string(), why });
                }
                Some(_) => {}
            }
            files.push(own);
        }
        table.source = Source::Parquet(files);
        Ok(table)
    }

    /// Opens a table that is text.
    pub fn of_csv(path: &Path, limits: &Limits) -> Result<Self> {
        let file = path.display().to_string();
        let mut text = read_text(path, limits)?;
        if text.starts_with('\u{feff}') {
            text.drain(..'\u{feff}'.len_utf8());
        }
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let count = |separator: &u8| first.bytes().filter(|byte| byte == separator).count();
        // Of several equally frequent ones the last: the comma.
        let separator = [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',');
        let mut header = csv::StringRecord::new();
        let csv = |e: csv::Error| Error::Csv { file: file.clone(), why: e.to_string().to_lowercase() };
        let is_there = reader(&text, separator).read_record(&mut header).map_err(csv)?;
        let header: Vec<String> = header.iter().map(String::from).collect();
        if !is_there || header.iter().all(String::is_empty) {
            return Err(Error::EmptyFile { file });
        }
        if header.iter().all(|name| name.parse::<f64>().is_ok()) {
            let why = "its first line is all numbers; write the names of the columns there, or, where the file is \
                       one recording, put it in a folder of its class";
            return Err(Error::Table { file, why: why.into() });
        }
        Ok(Self { file, header, source: Source::Csv { text, separator } })
    }

    /// What the values are stored in.
    pub fn dtype(&self) -> &'static str {
        match self.source {
            Source::Csv { .. } => "csv",
            #[cfg(feature = "parquet")]
            Source::Parquet(_) => "parquet",
        }
    }

    /// How many rows of so many channels it has, as far as its bytes bear that out: for room, not for truth.
    pub fn likely_rows(&self, channels: usize) -> usize {
        let (rows, values) = match &self.source {
            // A number and what parts it from the next.
            Source::Csv { text, .. } => {
                (text.bytes().filter(|byte| *byte == b'\n').count() + 1, text.len() / 2)
            }
            #[cfg(feature = "parquet")]
            Source::Parquet(files) => files.iter().fold((0, 0), |(rows, values), own| {
                (rows + own.rows, usize::saturating_add(values, own.bytes))
            }),
        };
        rows.min(values / channels.max(1))
    }

    /// Hands every row to `take` until it answers false.
    pub fn rows(&self, mut take: impl FnMut(Row) -> Result<bool>) -> Result<()> {
        let (text, separator) = match &self.source {
            Source::Csv { text, separator } => (text, *separator),
            #[cfg(feature = "parquet")]
            Source::Parquet(files) => {
                for own in files {
                    if !own.rows(|line, record| take(Row { line, record, table: self }))? {
                        break;
                    }
                }
                return Ok(());
            }
        };
        let mut reader = reader(text, separator);
        let mut record = csv::StringRecord::new();
        let mut is_header = true;
        while reader.read_record(&mut record).map_err(|e| self.csv(e))? {
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
            if !take(Row { line, record: &record, table: self })? {
                break;
            }
        }
        Ok(())
    }

    /// Of the columns `places` those in which a row holds a number, and the others.
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
        Ok(places.into_iter().partition(|at| is_numeric[*at]))
    }

    pub fn refuse(&self, why: String) -> Error {
        Error::Table { file: self.file.clone(), why }
    }

    fn csv(&self, error: csv::Error) -> Error {
        Error::Csv { file: self.file.clone(), why: error.to_string().to_lowercase() }
    }
}

fn reader(text: &str, separator: u8) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .delimiter(separator)
        .from_reader(text.as_bytes())
}

impl Row<'_> {
    pub fn text(&self, at: usize) -> &str {
        self.record.get(at).unwrap_or_default()
    }

    /// A text that must be there.
    pub fn named(&self, at: usize) -> Result<String> {
        match self.text(at) {
            "" => Err(self.refuse(at, "is empty")),
            text => Ok(text.into()),
        }
    }

    pub fn number(&self, at: usize) -> Result<f32> {
        self.text(at).parse().map_err(|_| self.no_number(at))
    }

    /// A time stamp, which is finite.
    pub fn stamp(&self, at: usize) -> Result<f64> {
        let stamp = self.text(at).parse::<f64>().ok().filter(|stamp| stamp.is_finite());
        stamp
            .ok_or_else(|| self.refuse(at, "is no time stamp; write seconds as a number, or say table.clock"))
    }

    /// A mark of a sample to test on: a whole number, or `train` and `test`.
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
        Error::TableCell {
            file: self.table.file.clone(),
            line: self.line,
            column: self.table.header[at].clone(),
            text: self.text(at).chars().take(40).collect(),
            why,
        }
    }
}
