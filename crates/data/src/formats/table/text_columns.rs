//! Reads the cells of a table in CSV or Parquet, with the place of each for messages.

use crate::dataset::labels::mark_of;
use crate::dataset::precision::{Precision, is_rounded_whole};
use crate::formats::csv_text::CsvText;
#[cfg(feature = "parquet")]
use crate::formats::parquet_file::ParquetFile;
use crate::formats::table::column_kind::{ColumnCells, ColumnKind, Disguised, numbers_columns};
use crate::formats::table::filled_in::FilledIn;
use crate::formats::table::number_form::{NumberForm, is_filled_in};
use crate::formats::table::options::Clock;
use crate::formats::table::row_source::RowSource;
use crate::formats::table::separators::{Separators, plain};
use crate::formats::table::time_text;
use crate::formats::text::{csv_reader, line_of};
use crate::options::Limits;
use crate::{Error, Result};
use std::borrow::Cow;
use std::path::Path;

/// Up to here f32 holds every whole number.
const EXACT: f32 = 16_777_216.0;

/// A table as text: its header, and its rows one after the other.
pub(crate) struct TableText {
    pub file: String,
    /// Names of the columns; their numbers from 1 where a recording has no header.
    pub header: Vec<String>,
    /// The header is in the file.
    pub is_named: bool,
    /// Names by which it is decided what the columns are, where those of the header say less.
    pub meanings: Vec<String>,
    /// The file is one recording, of which messages number the columns.
    is_recording: bool,
    /// Rows of a recording follow one another.
    pub is_in_order: bool,
    /// The lines of its file that are no rows, for people.
    pub left_out: Option<String>,
    rows: RowSource,
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
    fn new(file: String, header: Vec<String>, rows: RowSource) -> Self {
        let (is_recording, is_in_order, meanings) = (false, false, vec![]);
        Self { file, header, is_named: true, meanings, is_recording, is_in_order, left_out: None, rows }
    }

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
        let rows = RowSource::Parquet(files);
        Ok(Self::new(file, header, rows))
    }

    /// Opens a table that is text.
    pub fn of_csv(path: &Path, limits: &Limits) -> Result<Self> {
        let table = Self::of_text(path, limits)?;
        let header = table.header.iter().map(String::as_str);
        if header.clone().all(|name| name.parse::<f64>().is_ok()) && !numbers_columns(header) {
            let why = "its first line is all numbers; write the names of the columns there, or, where the file is \
                       one recording, put it in a folder of its class";
            return Err(table.refuse(why.into()));
        }
        Ok(table)
    }

    /// Opens a text that is one recording, under a header or without one. Its first line may be one that numbers the columns
    /// where it `may_number` them.
    pub fn of_recording(path: &Path, limits: &Limits, may_number: bool) -> Result<Self> {
        let mut table = Self { is_recording: true, ..Self::of_text(path, limits)? };
        if !table.begins_with_names(may_number)? {
            table.header = (1..=table.header.len()).map(|column| column.to_string()).collect();
            table.is_named = false;
        }
        Ok(table)
    }

    /// Opens a text whose first line is the header.
    fn of_text(path: &Path, limits: &Limits) -> Result<Self> {
        let file = path.display().to_string();
        let CsvText { text, said, left_out } = CsvText::read(path, limits)?;
        let separators = Separators::of(&text, said);
        let mut header = csv::StringRecord::new();
        let mut reader = csv_reader(&text, separators.column, false);
        let is_there = reader.read_record(&mut header).map_err(Error::csv(&file))?;
        let header: Vec<String> = header.iter().map(String::from).collect();
        if !is_there || header.iter().all(String::is_empty) {
            return Err(Error::EmptyFile { file });
        }
        let rows = RowSource::Csv { text, separators };
        Ok(Self { left_out, ..Self::new(file, header, rows) })
    }

    /// Checks whether the first line of a recording is a header: it has no number, or it numbers the columns.
    fn begins_with_names(&self, may_number: bool) -> Result<bool> {
        let has_comma = self.has_decimal_commas();
        if self.header.iter().any(|cell| plain(cell, has_comma).parse::<f64>().is_ok()) {
            return Ok(may_number && numbers_columns(self.header.iter().map(String::as_str)));
        }
        if self.header.iter().any(|cell| NumberForm::of(cell).is_none()) {
            return Ok(true);
        }
        // `5V` is a name above numbers.
        let mut is_name = false;
        self.rows(|row| {
            is_name = (0..self.header.len()).all(|at| row.long(at).is_some());
            Ok(false)
        })?;
        Ok(is_name)
    }

    /// Checks whether decimals are written with commas.
    pub fn has_decimal_commas(&self) -> bool {
        self.rows.has_decimal_commas()
    }

    /// Checks whether a column holds numbers of more than 32 bits.
    pub fn is_wide(&self, at: usize) -> bool {
        self.rows.is_wide(at)
    }

    /// Returns the unit of a column whose type says that it holds time stamps.
    pub fn clock(&self, at: usize) -> Option<Clock> {
        self.rows.clock(&self.header[at])
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
        self.rows.dtype()
    }

    /// Estimates the number of rows, at most as many as its bytes can hold, to reserve memory.
    pub fn likely_rows(&self, channels: usize) -> usize {
        self.rows.likely_rows(channels)
    }

    /// Hands every row to `take` until it returns false.
    pub fn rows(&self, mut take: impl FnMut(TableRow) -> Result<bool>) -> Result<()> {
        let (text, separator) = match &self.rows {
            RowSource::Csv { text, separators } => (text, separators.column),
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
        let (mut is_header, mut first_line) = (self.is_named, None);
        while reader.read_record(&mut record).map_err(Error::csv(&self.file))? {
            #[expect(clippy::expect_used, reason = "a reader notes where a record starts")]
            let start = record.position().expect("a record that was read");
            let line = line_of(text, start);
            let first_line = *first_line.get_or_insert(line);
            if record.len() != self.header.len() {
                let (file, got, want) = (self.file.clone(), record.len(), self.header.len());
                return Err(Error::RaggedCsv { file, line, got, first_line, want });
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

    /// Decides what the columns `places` are.
    pub fn kinds(&self, places: &[usize]) -> Result<Vec<ColumnKind>> {
        let name = |at: &usize| {
            let names = if self.meanings.is_empty() { &self.header } else { &self.meanings };
            self.is_named.then(|| names[*at].as_str())
        };
        let mut columns: Vec<ColumnCells> = places.iter().map(|at| ColumnCells::new(name(at))).collect();
        self.rows(|row| {
            let mut is_open = false;
            for (at, cells) in places.iter().zip(&mut columns).filter(|(_, cells)| cells.is_open()) {
                cells.add(row.line, row.text(*at), row.long(*at));
                is_open |= cells.is_open();
            }
            Ok(is_open)
        })?;
        // A date is no value of a sensor, and its type says its unit.
        let typed = |(at, cells): (&usize, ColumnCells)| match (cells.kind(), self.clock(*at)) {
            (kind @ ColumnKind::LeftOut(_), _) | (kind, None) => kind,
            (_, Some(clock)) => ColumnKind::Time(clock),
        };
        Ok(places.iter().zip(columns).map(typed).collect())
    }

    /// Counts the cells of a column that are filled in where there is no value.
    pub fn filled_in(&self, at: usize) -> FilledIn {
        let mut filled = FilledIn::default();
        // A row that cannot be read is refused when its turn comes.
        let _ = self.rows(|row| {
            filled.add(row.text(at));
            Ok(true)
        });
        filled
    }

    /// Refuses a column of numbers that do not read as numbers.
    pub fn refuse_disguised(&self, at: usize, first: &Disguised) -> Error {
        let (column, Disguised { line, cell, form }) = (&self.header[at], first);
        let hint = form.hint();
        self.refuse(format!(
            "line {line}, column {column}: {cell:?} {hint}, or name the column with table.ignore if it is no channel"
        ))
    }

    pub fn refuse(&self, why: String) -> Error {
        Error::file(&self.file, why)
    }
}

impl<'t> TableRow<'t> {
    /// Returns the table that it is a row of.
    pub fn table(&self) -> &'t TableText {
        self.table
    }

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

    /// Reads a label: with a decimal point where it is a number; it may be empty.
    pub fn label(&self, at: usize) -> String {
        let plain = self.plain(at);
        let is_number = plain.parse::<f64>().is_ok();
        if is_number { plain.into_owned() } else { self.text(at).to_string() }
    }

    pub fn number(&self, at: usize) -> Result<f32> {
        let number: f32 = self.plain(at).parse().map_err(|_| self.no_number(at))?;
        if number.abs() >= EXACT && self.long(at).is_some_and(is_rounded_whole) {
            let why = "does not fit f32 (integers to 2^24 = 16777216); subtract an offset, or name a column that is no \
                       channel with table.ignore";
            return Err(self.refuse(at, why));
        }
        Ok(number)
    }

    /// Reads a number of 64 bits.
    pub fn long_number(&self, at: usize) -> Result<f64> {
        self.long(at).ok_or_else(|| self.no_number(at))
    }

    /// Returns a number of 64 bits, where the cell is one.
    pub fn long(&self, at: usize) -> Option<f64> {
        self.plain(at).parse().ok()
    }

    /// Returns a cell with a decimal point, where the table writes commas.
    fn plain(&self, at: usize) -> Cow<'_, str> {
        plain(self.text(at), self.table.has_decimal_commas())
    }

    /// Reads a time stamp, which is finite: a number, or a date with a time as seconds.
    pub fn stamp(&self, at: usize) -> Result<f64> {
        let stamp = self.long(at).or_else(|| time_text::seconds(self.text(at)));
        stamp.filter(|stamp| stamp.is_finite()).ok_or_else(|| {
            self.refuse(
                at,
                "is no time stamp; write seconds as a number or 2024-05-01T12:00:00.5, or say table.clock",
            )
        })
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
        let form = NumberForm::of(text);
        let filled = if is_filled_in(text) { self.table.filled_in(at).said() } else { String::new() };
        if self.table.is_recording {
            let text = text.chars().take(40).collect();
            let hint = format!("{}{filled}", form.map_or("", NumberForm::short_hint));
            return Error::CsvNumber {
                file: self.table.file.clone(),
                line: self.line,
                column: at + 1,
                text,
                hint,
            };
        }
        let why = match form {
            _ if text.is_empty() => "is empty; fill it in or leave its row out",
            Some(NumberForm::DecimalComma) => "is not a number; write decimals with points",
            Some(form) => form.hint(),
            None => "is not a number; correct it, or name a column that is no channel with table.ignore",
        };
        self.refuse(at, &format!("{why}{filled}"))
    }

    fn refuse(&self, at: usize, why: &str) -> Error {
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
