//! Reads data sets of an HDF5 file, also of a MATLAB file of version 7.3, as named arrays.
//!
//! Only the list of data sets is in memory; values are streamed, some rows at a time. MATLAB stores arrays with their axes
//! reversed, texts as numbers, and cells as references.

use crate::formats::npy::{Header, NumberKind};
use crate::layout::order::natural;
use crate::{Error, Result};

use hdf5_reader::group::Group;
use hdf5_reader::{
    ByteOrder, Dataset, Datatype, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem, StringSize,
    VarLenKind,
};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use taxel_base::quiet::caught;

/// The first bytes of HDF5, and of MATLAB's own before it.
#[cfg(feature = "matlab")]
const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";
const MATLAB: &[u8] = b"MATLAB 7.3";
/// Most groups within groups, and objects in all of them, of a file that is not damaged.
const MAX_DEPTH: usize = 16;
const MAX_OBJECTS: usize = 100_000;
/// Most bytes that one stored byte can hold: deflate packs 1032 into one at best.
const PACKED: u64 = 1032;
/// Bytes read at a time.
const SLAB: u64 = 1 << 20;
/// Groups in which MATLAB keeps the contents of cells, and its objects.
pub(crate) const REFERENCES: &str = "#refs#";
const SUBSYSTEM: &str = "#subsystem#";

/// Checks whether a file is HDF5 by its first bytes.
#[cfg(feature = "matlab")]
pub(crate) fn is_hdf5(path: &Path) -> bool {
    start_of(path).is_some_and(|start| start.starts_with(MAGIC) || start.starts_with(MATLAB))
}

fn start_of(path: &Path) -> Option<Vec<u8>> {
    let mut start = vec![];
    File::open(path).ok()?.take(MATLAB.len() as u64).read_to_end(&mut start).ok()?;
    Some(start)
}

/// An open file.
pub(crate) struct Hdf5Archive {
    pub file: String,
    pub held: Hdf5File,
    pub is_matlab: bool,
    /// Most bytes that the file can hold, unpacked.
    pub most: u64,
    pub variables: Vec<Variable>,
}

pub(crate) struct Variable {
    /// Its path below the root.
    pub name: String,
    pub dataset: Dataset,
    pub header: Header,
}

impl Hdf5Archive {
    /// Opens a file and lists its data sets.
    pub fn open(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let len = path.metadata().map_err(Error::io(path))?.len();
        if len == 0 {
            return Err(Error::EmptyFile { file });
        }
        let most = len.saturating_mul(PACKED).saturating_add(SLAB);
        let bytes = usize::try_from(most).unwrap_or(usize::MAX);
        let options = OpenOptions::default()
            .with_chunk_cache_bytes(0)
            .with_max_chunk_bytes(bytes)
            .with_max_read_bytes(bytes)
            .with_max_object_header_bytes(len.min(1 << 26) as usize);
        let held = sound(&file, || Hdf5File::open_with_options(path, options))?;
        let is_matlab = start_of(path).is_some_and(|start| start.starts_with(MATLAB));
        let root = sound(&file, || held.root_group())?;
        let mut archive = Self { file, held, is_matlab, most, variables: vec![] };
        let mut left = MAX_OBJECTS;
        archive.list(&root, "", 0, &mut left)?;
        archive.variables.sort_by(|a, b| natural(&a.name, &b.name));
        Ok(archive)
    }

    /// Lists the data sets below a group.
    fn list(&mut self, group: &Group, below: &str, depth: usize, left: &mut usize) -> Result<()> {
        let (groups, datasets) = sound(&self.file, || group.members())?;
        let objects = groups.len() + datasets.len();
        *left =
            left.checked_sub(objects + 1).ok_or_else(|| damaged(&self.file, "it holds too many objects"))?;
        if depth > MAX_DEPTH {
            return Err(damaged(&self.file, "its groups lie too deep in one another"));
        }
        for dataset in datasets {
            let name = format!("{below}{}", dataset.name());
            let header = self.header(&dataset);
            self.variables.push(Variable { name, dataset, header });
        }
        for group in groups {
            let is_kept = self.is_matlab && [REFERENCES, SUBSYSTEM].contains(&group.name());
            if !is_kept {
                self.list(&group, &format!("{below}{}/", group.name()), depth + 1, left)?;
            }
        }
        Ok(())
    }

    /// Describes type and shape of a data set as NumPy does.
    fn header(&self, dataset: &Dataset) -> Header {
        let mut shape = dataset.shape().to_vec();
        if self.is_matlab {
            shape.reverse();
        }
        let class = self.class(dataset);
        let (dtype, kind, size, big) = match class.as_deref() {
            Some(class @ ("char" | "cell" | "struct" | "function_handle")) => {
                (class.to_string(), None, 0, false)
            }
            _ => number(dataset.dtype()),
        };
        Header { dtype, shape, fortran: self.is_matlab, big, kind, size, matlab: self.is_matlab }
    }

    /// Returns the class that MATLAB gives it.
    fn class(&self, dataset: &Dataset) -> Option<String> {
        if !self.is_matlab {
            return None;
        }
        caught(|| dataset.attribute("MATLAB_class").ok()?.read_string().ok()).flatten()
    }

    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|v| v.name == name)
    }
}

pub(crate) fn damaged(file: &str, why: &str) -> Error {
    Error::file(file, format!("is not readable as HDF5 ({why}); copy it again or write it anew"))
}

/// Runs the library, and turns its errors and panics into ours.
pub(crate) fn sound<T>(file: &str, work: impl FnOnce() -> hdf5_reader::error::Result<T>) -> Result<T> {
    match caught(work) {
        Some(Ok(value)) => Ok(value),
        Some(Err(e)) => Err(damaged(file, &e.to_string().to_lowercase())),
        None => Err(damaged(file, "it cannot be taken apart")),
    }
}

/// Returns NumPy's name of a type, its kind, its size, and whether the highest byte comes first.
fn number(dtype: &Datatype) -> (String, Option<NumberKind>, usize, bool) {
    let of = |letter: char, kind, size: u8, order: &ByteOrder| {
        let is_big = *order == ByteOrder::BigEndian;
        let mark = match (size, is_big) {
            (1, _) => '|',
            (_, true) => '>',
            (_, false) => '<',
        };
        let known = matches!(size, 1 | 2 | 4 | 8) && !(kind == NumberKind::Float && size == 1);
        (format!("{mark}{letter}{size}"), known.then_some(kind), usize::from(size), is_big)
    };
    match dtype {
        Datatype::FixedPoint { size, signed: true, byte_order } => {
            of('i', NumberKind::Int, *size, byte_order)
        }
        Datatype::FixedPoint { size, signed: false, byte_order } => {
            of('u', NumberKind::Uint, *size, byte_order)
        }
        Datatype::FloatingPoint { size, byte_order } => of('f', NumberKind::Float, *size, byte_order),
        Datatype::Enum { base, members } => match (&**base, members.len()) {
            (Datatype::FixedPoint { size: 1, byte_order, .. }, 2) => of('b', NumberKind::Bool, 1, byte_order),
            _ => number(base),
        },
        Datatype::Bitfield { size, byte_order } => of('u', NumberKind::Uint, *size, byte_order),
        Datatype::String { .. } | Datatype::VarLen { kind: VarLenKind::String, .. } => named("text"),
        Datatype::VarLen { .. } => named("lists of unequal length"),
        Datatype::Compound { .. } => named("compound"),
        Datatype::Reference { .. } => named("reference"),
        _ => named("opaque"),
    }
}

fn named(name: &str) -> (String, Option<NumberKind>, usize, bool) {
    (name.into(), None, 0, false)
}

/// Returns the bytes of a text of a fixed size; none of another type.
pub(crate) fn text_size(dtype: &Datatype) -> Option<usize> {
    match dtype {
        Datatype::String { size: StringSize::Fixed(size), .. } => Some(*size as usize),
        _ => None,
    }
}

/// A value as it is stored.
#[derive(Clone)]
pub(crate) struct RawValue<const N: usize>(pub [u8; N]);

impl<const N: usize> H5Type for RawValue<N> {
    fn hdf5_type() -> Datatype {
        Datatype::Opaque { size: N as u32, tag: String::new() }
    }

    fn from_bytes(bytes: &[u8], _: &Datatype) -> hdf5_reader::error::Result<Self> {
        let short = || hdf5_reader::error::Error::InvalidData("a value is cut short".into());
        bytes.get(..N).and_then(|bytes| bytes.try_into().ok()).map(Self).ok_or_else(short)
    }

    fn element_size(_: &Datatype) -> usize {
        N
    }
}

/// The values of a data set as a stream.
pub(crate) struct ValueStream<'d, const N: usize> {
    dataset: &'d Dataset,
    row: u64,
    /// Rows to read at a time: whole chunks, so that none is unpacked twice.
    rows: u64,
    slab: Vec<RawValue<N>>,
    /// Number of bytes of the slab that were handed out.
    used: usize,
}

impl<'d, const N: usize> ValueStream<'d, N> {
    pub fn new(dataset: &'d Dataset) -> Self {
        // Saturating, as a file without samples may claim any size.
        let row = dataset.shape().iter().skip(1).fold(N as u64, |row, axis| row.saturating_mul(*axis));
        let chunk = dataset.chunks().and_then(|chunk| chunk.first().copied()).map_or(1, u64::from).max(1);
        let rows = (SLAB / row.max(1)).max(1).next_multiple_of(chunk);
        Self { dataset, row: 0, rows, slab: vec![], used: 0 }
    }

    fn next(&mut self) -> io::Result<()> {
        let all = self.dataset.shape().first().copied().unwrap_or(0);
        (self.slab, self.used) = (vec![], 0);
        if self.row >= all {
            return Ok(());
        }
        let end = self.row.saturating_add(self.rows).min(all);
        let mut selected = SliceInfo::all(self.dataset.ndim());
        selected.selections[0] = SliceInfoElem::Slice { start: self.row, end, step: 1 };
        let slab = caught(|| self.dataset.read_slice::<RawValue<N>>(&selected));
        let slab = slab.ok_or_else(|| io::Error::other("it cannot be taken apart"))?;
        self.slab = slab.map_err(|e| io::Error::other(e.to_string()))?.into_iter().collect();
        self.row = end;
        Ok(())
    }
}

impl<const N: usize> Read for ValueStream<'_, N> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.used == N * self.slab.len() {
            self.next()?;
        }
        let mut count = 0;
        for byte in buffer {
            let Some(value) = self.slab.get(self.used / N) else { break };
            *byte = value.0[self.used % N];
            self.used += 1;
            count += 1;
        }
        Ok(count)
    }
}
