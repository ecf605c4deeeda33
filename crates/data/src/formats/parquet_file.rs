//! Reads a Parquet file as a table of texts and numbers, row by row.

use crate::formats::parquet_cells::{CellShape, wide};
use crate::formats::parquet_pages::Page;
use crate::formats::table::options::Clock;
use crate::options::Limits;
use crate::{Error, Result};
use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::record::Field;
use parquet::schema::types::Type;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use taxel_base::quiet::caught;

/// Most bytes of the head of a page; smallest and largest values may be in it.
const MAX_HEAD: usize = 1 << 18;
/// Most columns of a file that is not damaged, and most numbers of a column of lists.
const MAX_COLUMNS: usize = 1 << 16;

/// Endings of Parquet files.
pub(crate) const ENDINGS: &[&str] = &["parquet", "pq"];

/// A file whose heads were checked. It is closed while no rows are read, since a set may have thousands. A column of lists,
/// of lists of lists or of structs of numbers is as many columns as its first row has numbers.
pub(crate) struct ParquetFile {
    file: String,
    path: PathBuf,
    /// Columns by name, and how the values of each lie in a row.
    columns: Vec<(String, CellShape)>,
    /// Units of the columns of the type TIMESTAMP.
    clocks: Vec<(String, Clock)>,
    /// Whether each of these values has more than 32 bits.
    is_wide: Vec<bool>,
    /// Number of rows, as its heads say.
    pub rows: usize,
    /// Size of the file.
    pub bytes: usize,
}

impl ParquetFile {
    /// Opens a file and reads its columns.
    pub fn open(path: &Path, limits: &Limits) -> Result<Self> {
        let file = path.display().to_string();
        let mut opened = Self {
            file: file.clone(),
            path: path.into(),
            columns: vec![],
            clocks: vec![],
            is_wide: vec![],
            rows: 0,
            bytes: 0,
        };
        let reader = opened.reader()?;
        let rows = reader.metadata().file_metadata().num_rows();
        let samples = u64::try_from(rows).unwrap_or(u64::MAX);
        if samples > limits.max_values {
            let hint = "take fewer rows or raise limits.max_values";
            return Err(limits.too_large(&file, &[samples as usize], hint));
        }
        opened.refuse_unlikely(&reader)?;
        let fields = reader.metadata().file_metadata().schema().get_fields();
        opened.clocks =
            fields.iter().filter_map(|field| Some((field.name().into(), clock(field)?))).collect();
        opened.rows = usize::try_from(samples).unwrap_or(0);
        opened.bytes = path.metadata().map_or(0, |about| about.len() as usize);
        let (mut columns, mut is_wide) = (vec![], vec![]);
        opened.fields(|_, fields| {
            columns = fields.iter().map(|(name, field)| (name.clone(), CellShape::of(field))).collect();
            fields.iter().for_each(|(_, field)| wide(field, &mut is_wide));
            Ok(false)
        })?;
        if columns.is_empty() {
            let schema = reader.metadata().file_metadata().schema();
            columns =
                schema.get_fields().iter().map(|field| (field.name().to_string(), CellShape::One)).collect();
        }
        (opened.columns, opened.is_wide) = (columns, is_wide);
        if opened.header().len() > MAX_COLUMNS {
            return Err(damaged(&file, &format!("it has more than {MAX_COLUMNS} columns")));
        }
        Ok(opened)
    }

    fn reader(&self) -> Result<SerializedFileReader<Bounded>> {
        let io = Error::io(&self.path);
        let file = File::open(&self.path).map_err(&io)?;
        let len = file.metadata().map_err(&io)?.len();
        match len {
            0 => Err(Error::EmptyFile { file: self.file.clone() }),
            _ => sound(&self.file, || SerializedFileReader::new(Bounded { file, len })),
        }
    }

    /// Returns the path, for messages.
    pub fn name(&self) -> &str {
        &self.file
    }

    /// Returns the names of the columns; those of lists with the place of each number, from 0: `taxels.0.1`.
    pub fn header(&self) -> Vec<String> {
        let mut names = vec![];
        self.columns.iter().for_each(|(name, shape)| shape.name(name, &mut names));
        names
    }

    /// Returns the unit of a column of the type TIMESTAMP; none of another column.
    pub fn clock(&self, column: &str) -> Option<Clock> {
        self.clocks.iter().find(|(name, _)| name == column).map(|(_, clock)| *clock)
    }

    /// Checks whether a column of the header holds numbers of more than 32 bits.
    pub fn is_wide(&self, at: usize) -> bool {
        self.is_wide.get(at).copied().unwrap_or_default()
    }

    /// Hands the cells of every row, and its number from 1, to `take` until it returns false.
    pub fn rows(&self, mut take: impl FnMut(u64, &csv::StringRecord) -> Result<bool>) -> Result<bool> {
        let (mut record, mut cell) = (csv::StringRecord::new(), String::new());
        self.fields(|row, fields| {
            record.clear();
            for ((name, field), (column, wanted)) in fields.iter().zip(&self.columns) {
                if name != column || !wanted.fits(field) {
                    let wanted = wanted.described();
                    let why = format!(
                        "row {row}: column {column:?} does not hold {wanted}, as the first row does; write equally many in \
                         each"
                    );
                    return Err(Error::file(&self.file, why));
                }
                wanted.write(field, &mut cell, &mut record);
            }
            take(row, &record)
        })
    }

    /// Hands the fields of every row to `take` until it returns false. Returns whether all rows were taken.
    fn fields(&self, mut take: impl FnMut(u64, &[(String, Field)]) -> Result<bool>) -> Result<bool> {
        let reader = self.reader()?;
        let mut rows = sound(&self.file, || reader.get_row_iter(None))?;
        let mut number = 0;
        loop {
            let Some(row) = sound(&self.file, || rows.next().transpose())? else { return Ok(true) };
            number += 1;
            if !take(number, &row.into_columns())? {
                return Ok(false);
            }
        }
    }

    /// Refuses pages that say more than their bytes can hold.
    fn refuse_unlikely(&self, reader: &SerializedFileReader<Bounded>) -> Result<()> {
        let io = Error::io(&self.path);
        let mut handle = BufReader::new(File::open(&self.path).map_err(&io)?);
        let mut bytes = vec![];
        for group in reader.metadata().row_groups() {
            let rows = u64::try_from(group.num_rows()).unwrap_or(0);
            for column in group.columns() {
                let (start, len) = sound(&self.file, || Ok(column.byte_range()))?;
                let rows = if column.column_descr().max_rep_level() == 0 { rows } else { 0 };
                let (mut at, end) = (start, start.saturating_add(len));
                while at < end {
                    handle.seek(SeekFrom::Start(at)).map_err(&io)?;
                    bytes.clear();
                    // Most heads are short.
                    for most in [256, MAX_HEAD] {
                        let more = (most as u64).min(end - at).saturating_sub(bytes.len() as u64);
                        (&mut handle).take(more).read_to_end(&mut bytes).map_err(&io)?;
                        if Page::read(&bytes).is_some() {
                            break;
                        }
                    }
                    let page = Page::read(&bytes).filter(|page| page.is_likely(rows));
                    let page = page.ok_or_else(|| {
                        damaged(&self.file, &format!("its page at byte {at} cannot be what it says"))
                    })?;
                    at = at.saturating_add(page.head as u64).saturating_add(page.stored);
                }
            }
        }
        Ok(())
    }
}

/// Returns the unit of a column of the type TIMESTAMP.
fn clock(field: &Type) -> Option<Clock> {
    let about = field.get_basic_info();
    match (about.logical_type_ref(), about.converted_type()) {
        (Some(LogicalType::Timestamp(of)), _) => Some(match of.unit {
            TimeUnit::MILLIS => Clock::Milliseconds,
            TimeUnit::MICROS => Clock::Microseconds,
            TimeUnit::NANOS => Clock::Nanoseconds,
        }),
        (_, ConvertedType::TIMESTAMP_MILLIS) => Some(Clock::Milliseconds),
        (_, ConvertedType::TIMESTAMP_MICROS) => Some(Clock::Microseconds),
        _ => None,
    }
}

fn damaged(file: &str, why: &str) -> Error {
    Error::file(file, format!("is not readable as Parquet ({why}); copy it again or write it anew"))
}

/// Runs the library, and turns its errors and panics into ours.
fn sound<T>(file: &str, work: impl FnOnce() -> Result<T, ParquetError>) -> Result<T> {
    match caught(work) {
        Some(Ok(value)) => Ok(value),
        Some(Err(e)) => Err(damaged(file, &e.to_string().to_lowercase())),
        None => Err(damaged(file, "it cannot be taken apart")),
    }
}

/// A file of which no more is read than it has.
struct Bounded {
    file: File,
    len: u64,
}

impl Length for Bounded {
    fn len(&self) -> u64 {
        self.len
    }
}

impl ChunkReader for Bounded {
    type T = BufReader<File>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        self.file.get_read(start)
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        if start.checked_add(length as u64).is_none_or(|end| end > self.len) {
            return Err(ParquetError::EOF("it is cut short".into()));
        }
        self.file.get_bytes(start, length)
    }
}
