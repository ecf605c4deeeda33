//! A Parquet file as a table of texts and numbers, row by row.

use crate::formats::parquet_pages::Page;
use crate::options::Limits;
use crate::{Error, Result};
use bytes::Bytes;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::record::Field;
use std::fmt::Write;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use taxel_base::quiet::caught;

/// Most bytes of the head of a page; smallest and largest values may be in it.
const MAX_HEAD: usize = 1 << 18;
/// Columns beyond which a file is damaged, and numbers of a column that holds lists.
const MAX_COLUMNS: usize = 1 << 16;

/// What the names of files end in.
pub(crate) const ENDINGS: &[&str] = &["parquet", "pq"];

/// A file that is sound as far as its heads say; closed while no rows are read, since a set may have thousands. A
/// column of lists is as many columns as its first row has numbers.
pub(crate) struct ParquetFile {
    file: String,
    path: PathBuf,
    /// Columns by name, and how many values each has in a row; none for a single one.
    columns: Vec<(String, Option<usize>)>,
    /// As its heads say.
    pub rows: usize,
    /// Of the whole file.
    pub bytes: usize,
}

impl ParquetFile {
    /// Opens a file and reads what its columns are.
    pub fn open(path: &Path, limits: &Limits) -> Result<Self> {
        let file = path.display().to_string();
        let mut own = Self { file: file.clone(), path: path.into(), columns: vec![], rows: 0, bytes: 0 };
        let reader = own.reader()?;
        let rows = reader.metadata().file_metadata().num_rows();
        let samples = u64::try_from(rows).unwrap_or(u64::MAX);
        if samples > limits.max_values {
            return Err(Error::TooLarge {
                at: file,
                shape: vec![samples],
                limit: limits.max_values,
                hint: "take fewer rows or raise limits.max_values",
            });
        }
        own.refuse_unlikely(&reader)?;
        own.rows = usize::try_from(samples).unwrap_or(0);
        own.bytes = path.metadata().map_or(0, |about| about.len() as usize);
        let mut columns = vec![];
        own.fields(|_, fields| {
            columns = fields.iter().map(|(name, field)| (name.clone(), width(field))).collect();
            Ok(false)
        })?;
        if columns.is_empty() {
            let schema = reader.metadata().file_metadata().schema();
            columns = schema.get_fields().iter().map(|field| (field.name().to_string(), None)).collect();
        }
        own.columns = columns;
        match own.header().len() > MAX_COLUMNS {
            true => Err(own.damaged(&format!("it has more than {MAX_COLUMNS} columns"))),
            false => Ok(own),
        }
    }

    fn reader(&self) -> Result<SerializedFileReader<Bounded>> {
        let io = |e: std::io::Error| Error::Io { file: self.file.clone(), kind: e.kind() };
        let file = File::open(&self.path).map_err(io)?;
        let len = file.metadata().map_err(io)?.len();
        match len {
            0 => Err(Error::EmptyFile { file: self.file.clone() }),
            _ => sound(&self.file, || SerializedFileReader::new(Bounded { file, len })),
        }
    }

    /// Names of the columns; of lists with the place of each number, from 0.
    pub fn header(&self) -> Vec<String> {
        let of = |(name, width): &(String, Option<usize>)| match width {
            None => vec![name.clone()],
            Some(width) => (0..*width).map(|i| format!("{name}.{i}")).collect(),
        };
        self.columns.iter().flat_map(of).collect()
    }

    /// Hands the cells of every row, and its number from 1, to `take` until it answers false.
    pub fn rows(&self, mut take: impl FnMut(u64, &csv::StringRecord) -> Result<bool>) -> Result<bool> {
        let (mut record, mut cell) = (csv::StringRecord::new(), String::new());
        self.fields(|row, fields| {
            record.clear();
            for ((name, field), (column, wanted)) in fields.iter().zip(&self.columns) {
                if name != column || width(field) != *wanted && !matches!(field, Field::Null) {
                    let wanted = wanted.map_or("one value".into(), |count| format!("{count} values"));
                    return Err(self.refuse(format!(
                        "row {row}: column {column:?} does not hold {wanted}, as the first row does"
                    )));
                }
                let single = std::slice::from_ref(field);
                let cells = match field {
                    Field::ListInternal(list) => list.elements(),
                    _ => single,
                };
                for own in cells {
                    cell.clear();
                    write_cell(own, &mut cell);
                    record.push_field(&cell);
                }
                if let (Field::Null, Some(count)) = (field, wanted) {
                    (1..*count).for_each(|_| record.push_field(""));
                }
            }
            take(row, &record)
        })
    }

    /// Hands the fields of every row to `take` until it answers false; whether it never did.
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
        let io = |e: std::io::Error| Error::Io { file: self.file.clone(), kind: e.kind() };
        let mut handle = BufReader::new(File::open(&self.path).map_err(io)?);
        let mut bytes = vec![];
        for group in reader.metadata().row_groups() {
            let rows = u64::try_from(group.num_rows()).unwrap_or(0);
            for column in group.columns() {
                let (start, len) = sound(&self.file, || Ok(column.byte_range()))?;
                let rows = if column.column_descr().max_rep_level() == 0 { rows } else { 0 };
                let (mut at, end) = (start, start.saturating_add(len));
                while at < end {
                    handle.seek(SeekFrom::Start(at)).map_err(io)?;
                    bytes.clear();
                    // Most heads are short.
                    for most in [256, MAX_HEAD] {
                        let more = (most as u64).min(end - at).saturating_sub(bytes.len() as u64);
                        (&mut handle).take(more).read_to_end(&mut bytes).map_err(io)?;
                        if Page::read(&bytes).is_some() {
                            break;
                        }
                    }
                    let page = Page::read(&bytes).filter(|page| page.is_likely(rows));
                    let page = page.ok_or_else(|| {
                        self.damaged(&format!("its page at byte {at} cannot be what it says"))
                    })?;
                    at = at.saturating_add(page.head as u64).saturating_add(page.stored);
                }
            }
        }
        Ok(())
    }

    fn damaged(&self, why: &str) -> Error {
        Error::Parquet { file: self.file.clone(), why: why.into() }
    }

    fn refuse(&self, why: String) -> Error {
        Error::Table { file: self.file.clone(), why }
    }
}

/// How many numbers a list holds; none of a single value.
fn width(field: &Field) -> Option<usize> {
    match field {
        Field::ListInternal(list) => Some(list.len()),
        _ => None,
    }
}

/// A value as CSV has it; what is neither text nor number is in brackets, and no number.
fn write_cell(field: &Field, out: &mut String) {
    // Writing to a text does not fail.
    let _ = match field {
        Field::Null => Ok(()),
        Field::Bool(own) => write!(out, "{}", u8::from(*own)),
        Field::Str(own) => write!(out, "{own}"),
        Field::Float16(own) => write!(out, "{}", own.to_f32()),
        Field::Float(own) => write!(out, "{own}"),
        Field::Double(own) => write!(out, "{own}"),
        Field::TimestampMillis(own)
        | Field::TimestampMicros(own)
        | Field::TimeMicros(own)
        | Field::Long(own) => {
            write!(out, "{own}")
        }
        Field::Date(own) | Field::TimeMillis(own) => write!(out, "{own}"),
        Field::Group(_) | Field::ListInternal(_) | Field::MapInternal(_) | Field::Bytes(_) => {
            write!(out, "[...]")
        }
        other => write!(out, "{other}"),
    };
}

/// What the library answers, whatever it does.
fn sound<T>(file: &str, work: impl FnOnce() -> Result<T, ParquetError>) -> Result<T> {
    let why = match caught(work) {
        Some(Ok(value)) => return Ok(value),
        Some(Err(e)) => e.to_string().to_lowercase(),
        None => "it cannot be taken apart".into(),
    };
    Err(Error::Parquet { file: file.into(), why })
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
        match start.checked_add(length as u64).is_some_and(|end| end <= self.len) {
            true => self.file.get_bytes(start, length),
            false => Err(ParquetError::EOF("it is cut short".into())),
        }
    }
}
