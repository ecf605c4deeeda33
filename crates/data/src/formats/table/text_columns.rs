//! Reads the cells of a table in CSV or Parquet, with the place of each for messages.

use crate::dataset::labels::mark_of;
use crate::formats::csv_file;
use crate::formats::csv_text::CsvText;
#[cfg(feature = "parquet")]
use crate::formats::parquet_file::ParquetFile;
use crate::formats::text::csv_reader;
use crate::options::Limits;
use crate::{Error, Result};
use std::path::Path;

/// A table as text: its header, and its rows one after the other.
pub(crate) struct TableText {
    pub file: String,
    pub header: Vec<String>,
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

/// One row; `line` is its line in CSV, its number in Parquet.
pub(crate) struct TableRow<'t> {
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
        Ok(Self { file, header, rows: RowSource::Parquet(files) })
    }

    /// Opens a table that is text.
    pub fn of_csv(path: &Path, limits: &Limits) -> Result<Self> {
        let file = path.display().to_string();
        let table = CsvText::read(path, limits)?;
        let separator = table.separator();
        let text = table.text;
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
        Ok(Self { file, header, rows: RowSource::Csv { text, separator } })
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
                    if !file.rows(|line, record| take(TableRow { line, record, table: self }))? {
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
            if !take(TableRow { line, record: &record, table: self })? {
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
        Ok(places.into_iter().partition(|at| is_numeric[*at]))
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

    /// Reads a time stamp, which is finite.
    pub fn stamp(&self, at: usize) -> Result<f64> {
        let stamp = self.text(at).parse::<f64>().ok().filter(|stamp| stamp.is_finite());
        stamp
            .ok_or_else(|| self.refuse(at, "is no time stamp; write seconds as a number, or say table.clock"))
    }

    /// Reads a mark of a sample to test on: a whole number, or `train` and `test`.
    pub fn mark(&self, at: usize) -> Result<i64> {
        let text = self.text(at);
        let whole = text.parse::<f64>().ok().filter(|mark| mark.fract() == 0.0).map(|mark| mark as i64);
        let number = text.parse().ok().or(whole);
        number
            .or_else(|| mark_of(text))
            .ok_or_else(|| self.refuse(at, "is no mark; write 0 or train, and 1 or test"))
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
        let (line, column) = (self.line, &self.table.header[at]);
        let text: String = self.text(at).chars().take(40).collect();
        self.table.refuse(format!("line {line}, column {column}: {text:?} {why}"))
    }
}
