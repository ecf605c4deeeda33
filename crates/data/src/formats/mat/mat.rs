//! Reads a MATLAB file of version 5, 6 or 7: one element per variable, each compressed by itself since version 7.
//!
//! After MathWorks, "MAT-File Format", chapter 1, as far as a data set needs it: dense real arrays of numbers. Crates for it
//! hold whole files in memory. Here only names and shapes of variables are; values are streamed.

use crate::formats::npy::{Header, NumberKind};
use crate::{Error, Result};
use flate2::read::ZlibDecoder;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes before the first element.
const START: u64 = 128;
/// Most elements of a file, and axes of an array, where they are not damaged.
const MAX_ELEMENTS: usize = 100_000;
const MAX_AXES: usize = 32;
/// MATLAB allows 63 letters.
const MAX_NAME: usize = 1024;

/// Types of elements.
pub(crate) const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// An open file.
pub(crate) struct MatArchive {
    pub file: String,
    reader: BufReader<File>,
    big: bool,
    pub variables: Vec<Variable>,
}

pub(crate) struct Variable {
    pub name: String,
    /// Position of its element.
    pub at: u64,
    pub header: Header,
}

impl MatArchive {
    /// Opens a file and lists its variables.
    pub fn open(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let io = Error::io(path);
        let handle = File::open(path).map_err(&io)?;
        let len = handle.metadata().map_err(&io)?.len();
        if len == 0 {
            return Err(Error::EmptyFile { file });
        }
        let mut reader = BufReader::new(handle);
        let big = is_big_endian(&mut reader, &file)?;
        let place = file.clone();
        let mut archive = MatArchive { file, reader, big, variables: vec![] };
        let mut at = START;
        while at < len {
            if archive.variables.len() == MAX_ELEMENTS {
                return Err(damaged(&place, format!("holds more than {MAX_ELEMENTS} variables")));
            }
            let (end, element) = archive.element(at)?;
            let found = element.variable().map_err(|why| why.at(&place, at))?;
            let found = found.map(|(name, header, _)| Variable { name, at, header });
            if end > len {
                return Err(damaged(&place, format!("is cut short: it has {len} of at least {end} bytes")));
            }
            archive.variables.extend(found);
            at = end;
        }
        Ok(archive)
    }

    /// Returns the position of a variable, and its element.
    pub fn element_of(&mut self, name: &str) -> Result<Option<(u64, Element<'_>)>> {
        match self.variables.iter().find(|v| v.name == name).map(|v| v.at) {
            None => Ok(None),
            Some(at) => self.element(at).map(|(_, element)| Some((at, element))),
        }
    }

    /// Returns the end of the element at a position, and the element uncompressed.
    pub fn element(&mut self, at: u64) -> Result<(u64, Element<'_>)> {
        let (file, big) = (self.file.clone(), self.big);
        self.reader.seek(SeekFrom::Start(at)).map_err(Error::io(&file))?;
        let mut stream: Box<dyn Read + '_> = Box::new(&mut self.reader);
        let cut = |why: Broken| why.at(&file, at);
        let (kind, bytes) = tag(&mut stream, big).map_err(cut)?;
        let end = at + 8 + u64::from(bytes);
        stream = Box::new(stream.take(bytes.into()));
        match kind {
            MATRIX => {}
            COMPRESSED => {
                stream = Box::new(ZlibDecoder::new(stream));
                let (kind, bytes) = tag(&mut stream, big).map_err(cut)?;
                if kind != MATRIX {
                    return Err(Broken::Is(format!("compressed type {kind}")).at(&file, at));
                }
                stream = Box::new(stream.take(bytes.into()));
            }
            other => return Err(Broken::Is(format!("type {other}")).at(&file, at)),
        }
        Ok((end, Element { stream, big }))
    }
}

pub(crate) fn damaged(file: &str, why: impl Into<String>) -> Error {
    Error::file(file, format!("{}; copy it again or save it anew with save(..., '-v7')", why.into()))
}

/// Reads the first 128 bytes: version of the file and order of its bytes.
fn is_big_endian(reader: &mut dyn Read, file: &str) -> Result<bool> {
    let not = |why: &str| {
        let how = "write it with save(..., '-v7')";
        Error::file(file, format!("is not a MATLAB file of version 5 to 7 ({why}); {how}"))
    };
    let mut start = vec![];
    reader.take(START).read_to_end(&mut start).map_err(Error::io(file))?;
    if start.len() < START as usize {
        return Err(not("it ends before its header does"));
    }
    match (&start[126..], &start[124..126]) {
        (b"IM", [0, 1]) => Ok(false),
        (b"MI", [1, 0]) => Ok(true),
        (b"IM" | b"MI", _) => Err(not("its version is another one")),
        _ => Err(not("it has no such header; version 4 is not read")),
    }
}

/// The reason why an element cannot be read.
pub(crate) enum Broken {
    Read(io::Error),
    Is(String),
}

impl Broken {
    pub fn at(self, place: &str, at: u64) -> Error {
        let why = match self {
            Broken::Read(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                format!("is cut short in the element at byte {at}")
            }
            Broken::Read(e) => {
                format!("is damaged in the element at byte {at} ({})", e.to_string().to_lowercase())
            }
            Broken::Is(what) => format!("has at byte {at} {what}, which is no variable of numbers or text"),
        };
        damaged(place, why)
    }
}

impl From<io::Error> for Broken {
    fn from(e: io::Error) -> Self {
        Broken::Read(e)
    }
}

fn word(stream: &mut dyn Read, big: bool) -> io::Result<u32> {
    let mut bytes = [0; 4];
    stream.read_exact(&mut bytes)?;
    Ok(if big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
}

/// Reads type and length in bytes.
fn tag(stream: &mut dyn Read, big: bool) -> Result<(u32, u32), Broken> {
    Ok((word(stream, big)?, word(stream, big)?))
}

/// Name, header and values of a variable.
type Content<'a> = (String, Header, Box<dyn Read + 'a>);

/// Class, shape and name of a variable.
pub(crate) struct Form {
    pub class: u32,
    pub complex: bool,
    pub shape: Vec<u64>,
    pub name: String,
}

/// The content of a variable's element.
pub(crate) struct Element<'a> {
    pub stream: Box<dyn Read + 'a>,
    pub big: bool,
}

impl<'a> Element<'a> {
    /// Reads the variable, without values where it holds no numbers; none for variables that MATLAB keeps for itself.
    pub fn variable(mut self) -> Result<Option<Content<'a>>, Broken> {
        let Form { class, complex, shape, name } = self.form()?;
        if name.is_empty() {
            return Ok(None);
        }
        let mut header = Header {
            dtype: dtype(class, complex),
            shape,
            fortran: true,
            big: self.big,
            kind: None,
            size: 0,
            matlab: true,
        };
        if !(6..=15).contains(&class) || complex {
            return Ok(Some((name, header, Box::new(io::empty()))));
        }
        let (stored, small, bytes) = self.start()?;
        let Some((kind, size)) = number(stored) else {
            return Err(Broken::Is(format!("numbers stored as type {stored}")));
        };
        (header.kind, header.size) = (Some(kind), size);
        Ok(Some((name, header, Box::new(Cursor::new(small).chain(self.stream.take(bytes))))))
    }

    /// Reads class, shape and name, which come first.
    pub fn form(&mut self) -> Result<Form, Broken> {
        let flags = word(&mut self.part(16)?.as_slice(), self.big)?;
        let (class, complex) = (flags & 0xFF, flags & 0x800 != 0);
        // Objects such as `categorical` and `table` have no shape.
        let shape = if class == 17 { vec![] } else { self.part(4 * MAX_AXES)? };
        let axes = shape.chunks_exact(4).map(|mut axis| word(&mut axis, self.big).map(u64::from));
        let shape = axes.collect::<io::Result<_>>()?;
        let name = String::from_utf8_lossy(&self.part(MAX_NAME)?).into_owned();
        Ok(Form { class, complex, shape, name })
    }

    /// Reads type and length in bytes of the next part.
    pub fn tag(&mut self) -> Result<(u32, u32), Broken> {
        tag(&mut self.stream, self.big)
    }

    /// Reads the type of the next part, the bytes within its tag, and the number of bytes that follow.
    pub fn start(&mut self) -> Result<(u32, Vec<u8>, u64), Broken> {
        let first = word(&mut self.stream, self.big)?;
        if first >> 16 == 0 {
            return Ok((first, vec![], word(&mut self.stream, self.big)?.into()));
        }
        let mut bytes = vec![0; 4];
        self.stream.read_exact(&mut bytes)?;
        bytes.truncate((first >> 16) as usize);
        Ok((first & 0xFFFF, bytes, 0))
    }

    /// Reads the next part whole, with the bytes that fill it up to eight.
    fn part(&mut self, most: usize) -> Result<Vec<u8>, Broken> {
        let (_, mut bytes, follow) = self.start()?;
        if follow > most as u64 {
            return Err(Broken::Is(format!("a header part of {follow} bytes")));
        }
        let len = follow as usize;
        if len > 0 {
            bytes = vec![0; len.next_multiple_of(8)];
            self.stream.read_exact(&mut bytes)?;
            bytes.truncate(len);
        }
        Ok(bytes)
    }
}

/// Returns NumPy's name of a class of numbers, and MATLAB's name of any other.
fn dtype(class: u32, complex: bool) -> String {
    let name = match class {
        1 => "cell",
        2 => "struct",
        4 => "char",
        5 => "sparse",
        6 => "<f8",
        7 => "<f4",
        8 => "|i1",
        9 => "|u1",
        10 => "<i2",
        11 => "<u2",
        12 => "<i4",
        13 => "<u4",
        14 => "<i8",
        15 => "<u8",
        16 => "function",
        _ => "object",
    };
    if complex { format!("complex {name}") } else { name.into() }
}

/// Returns kind and size of stored numbers: whole doubles are stored in as few bytes as they need.
fn number(stored: u32) -> Option<(NumberKind, usize)> {
    Some(match stored {
        1 => (NumberKind::Int, 1),
        2 => (NumberKind::Uint, 1),
        3 => (NumberKind::Int, 2),
        4 => (NumberKind::Uint, 2),
        5 => (NumberKind::Int, 4),
        6 => (NumberKind::Uint, 4),
        7 => (NumberKind::Float, 4),
        9 => (NumberKind::Float, 8),
        12 => (NumberKind::Int, 8),
        13 => (NumberKind::Uint, 8),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_ends_early_is_cut_short_and_another_error_is_said() {
        let said = |kind: io::ErrorKind| Broken::Read(kind.into()).at("a.mat", 128).to_string();
        let (cut, other) = (said(io::ErrorKind::UnexpectedEof), said(io::ErrorKind::InvalidData));
        assert!(cut.contains("cut short") && !other.contains("cut short"), "{cut}; {other}");
    }
}
