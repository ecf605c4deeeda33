//! Reads one NumPy array from a stream: header, then values, never more than the header promises.
//!
//! npyz writes arrays, but does not read the header: it allocates as many bytes as a header claims, up to 4 GiB, and its
//! grammar calls itself for every bracket, without a limit.

use crate::dataset::precision::Precision;
use crate::options::Limits;
use crate::{Error, Result};
use half::f16;
use ndarray::{ArrayD, IxDyn, ShapeBuilder};
use std::io::{self, Read};

/// A header is a line of text; more than this is not one.
const MAX_HEADER: usize = 1 << 20;
/// Values per read.
const CHUNK: usize = 1 << 14;
/// Values that memory is claimed for on the header's word alone; beyond them it grows with the data.
const MAX_TRUST: u64 = 1 << 23;
/// The largest integer up to which f32 holds every integer.
const EXACT: u64 = 1 << 24;

/// How to fix an array of Python objects.
const OBJECTS: &str = "Python objects are pickled and not read: save texts with astype(str), numbers as numbers, and \
                       recordings of unequal length one array each beside y, or padded with NaN at the end";

/// The most values that an array may have, and how to fix one that has more.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cap {
    pub values: u64,
    pub hint: &'static str,
}

impl Cap {
    /// Returns the cap of samples.
    pub(crate) fn of_samples(limits: &Limits) -> Self {
        Self { values: limits.max_values, hint: "save fewer or smaller samples or raise limits.max_values" }
    }

    /// Returns the cap of labels and groups.
    pub(crate) fn of_labels(limits: &Limits) -> Self {
        Self { values: limits.max_samples, hint: "save fewer samples or raise limits.max_samples" }
    }

    /// Refuses an array of this shape.
    pub(crate) fn too_large(&self, at: &str, shape: &[u64]) -> Error {
        Error::TooLarge { at: at.into(), shape: shape.to_vec(), limit: self.values, hint: self.hint }
    }
}

/// The kinds of number an array may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberKind {
    Bool,
    Int,
    Uint,
    Float,
}

/// A parsed header.
#[derive(Debug, Clone)]
pub(crate) struct Header {
    /// As written, such as `<f4`.
    pub dtype: String,
    pub shape: Vec<u64>,
    /// The first axis runs fastest.
    pub fortran: bool,
    /// The highest byte comes first.
    pub big: bool,
    /// None for types that this crate does not read.
    pub kind: Option<NumberKind>,
    /// Bytes of a value.
    pub size: usize,
    /// MATLAB knows no vectors, only rows and columns, and keeps whole numbers as floats.
    pub matlab: bool,
}

/// Reads the magic, version and dictionary of an array; `at` is for messages.
pub(crate) fn read_header(reader: &mut dyn Read, at: &str) -> Result<Header> {
    let bad = |why: &str| Error::NotAnArray { at: at.into(), why: why.into() };
    let mut magic = [0; 8];
    read_all(reader, &mut magic, at, "its header is cut short")?;
    if &magic[..6] != b"\x93NUMPY" {
        return Err(bad("it does not start with \\x93NUMPY"));
    }
    let len = if magic[6] == 1 {
        let mut len = [0; 2];
        read_all(reader, &mut len, at, "its header is cut short")?;
        usize::from(u16::from_le_bytes(len))
    } else if matches!(magic[6], 2 | 3) {
        let mut len = [0; 4];
        read_all(reader, &mut len, at, "its header is cut short")?;
        u32::from_le_bytes(len) as usize
    } else {
        return Err(bad("its format version is not 1, 2 or 3"));
    };
    if len > MAX_HEADER {
        return Err(bad("its header claims more than a megabyte"));
    }
    let mut text = vec![0; len];
    read_all(reader, &mut text, at, "its header is cut short")?;
    let text = String::from_utf8_lossy(&text);
    parse_dict(&text).ok_or_else(|| bad("its header is not {'descr', 'fortran_order', 'shape'}"))
}

fn read_all(reader: &mut dyn Read, buffer: &mut [u8], at: &str, why: &str) -> Result<()> {
    reader.read_exact(buffer).map_err(|e| Error::NotAnArray {
        at: at.into(),
        why: match e.kind() {
            io::ErrorKind::UnexpectedEof => why.into(),
            _ => e.to_string(),
        },
    })
}

/// Reads `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }` in any key order.
fn parse_dict(text: &str) -> Option<Header> {
    let (mut dtype, mut fortran, mut shape) = (None, None, None);
    let mut rest = text.trim().strip_prefix('{')?.trim_start();
    while !rest.starts_with('}') {
        let (key, after) = quoted(rest)?;
        rest = after.trim_start().strip_prefix(':')?.trim_start();
        match key {
            "descr" if rest.starts_with('[') => {
                // A record's fields may hold any text, so the last bracket ends them.
                let end = rest.rfind(']')?;
                dtype = Some(rest[..=end].to_string());
                rest = &rest[end + 1..];
                // The other keys sort after `descr` and hold no bracket.
            }
            "descr" => {
                let (value, after) = quoted(rest)?;
                dtype = Some(value.to_string());
                rest = after;
            }
            "fortran_order" => {
                if let Some(after) = rest.strip_prefix("True") {
                    (fortran, rest) = (Some(true), after);
                } else {
                    (fortran, rest) = (Some(false), rest.strip_prefix("False")?);
                }
            }
            "shape" => {
                let (inside, after) = rest.strip_prefix('(')?.split_once(')')?;
                let axes: Option<Vec<u64>> = inside
                    .split(',')
                    .map(str::trim)
                    .filter(|axis| !axis.is_empty())
                    .map(|axis| axis.trim_end_matches('L').parse().ok())
                    .collect();
                (shape, rest) = (Some(axes?), after);
            }
            _ => return None,
        }
        rest = rest.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    let dtype = dtype?;
    let (kind, size, big) = number(&dtype);
    Some(Header { shape: shape?, fortran: fortran?, big, kind, size, dtype, matlab: false })
}

fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

/// Returns kind, bytes per value and whether it is big-endian; no kind for types that this crate does not read.
fn number(dtype: &str) -> (Option<NumberKind>, usize, bool) {
    let mut chars = dtype.chars();
    let order = chars.next();
    let kind = match chars.next() {
        Some('b') => NumberKind::Bool,
        Some('i') => NumberKind::Int,
        Some('u') => NumberKind::Uint,
        Some('f') => NumberKind::Float,
        _ => return (None, 0, false),
    };
    let size: usize = chars.as_str().parse().unwrap_or(0);
    let known = match kind {
        NumberKind::Bool => size == 1,
        NumberKind::Int | NumberKind::Uint => matches!(size, 1 | 2 | 4 | 8),
        NumberKind::Float => matches!(size, 2 | 4 | 8),
    };
    let ordered = matches!(order, Some('<' | '>')) || (order == Some('|') && size == 1);
    ((known && ordered).then_some(kind), size, order == Some('>'))
}

impl Header {
    /// Turns a row or a column of a MATLAB file into a vector: one value per sample.
    pub(crate) fn as_column(&self) -> Self {
        let mut header = self.clone();
        if let (true, &[rows, columns]) = (self.matlab, self.shape.as_slice())
            && rows.min(columns) == 1
        {
            header.shape = vec![rows.max(columns)];
        }
        header
    }

    /// Describes type and shape in messages: `<f4 [4, 2, 3]`.
    pub(crate) fn described(&self) -> String {
        format!("{} {:?}", self.dtype, self.shape)
    }

    /// Counts the values, and refuses more than the cap.
    pub(crate) fn count(&self, at: &str, cap: Cap) -> Result<u64> {
        self.shape
            .iter()
            .try_fold(1u64, |product, axis| product.checked_mul(*axis))
            .filter(|count| *count <= cap.values)
            .ok_or_else(|| cap.too_large(at, &self.shape))
    }

    /// Counts the stored values from one place along an axis to the next, and the places; one of an array without that axis.
    fn along(&self, axis: usize) -> (u64, u64) {
        let Some(places) = self.shape.get(axis) else { return (1, 1) };
        let faster = if self.fortran { &self.shape[..axis] } else { &self.shape[axis + 1..] };
        (faster.iter().fold(1, |all: u64, axis| all.saturating_mul(*axis)).max(1), (*places).max(1))
    }

    /// Returns the index along each axis of the `flat`-th stored value.
    fn index(&self, mut flat: u64) -> Vec<usize> {
        let mut index = vec![0; self.shape.len()];
        let axes: Vec<usize> =
            if self.fortran { (0..index.len()).collect() } else { (0..index.len()).rev().collect() };
        for axis in axes {
            let length = self.shape[axis].max(1);
            index[axis] = (flat % length) as usize;
            flat /= length;
        }
        index
    }

    /// Checks whether values are pickled Python objects, which could run any code.
    pub(crate) fn is_pickled(&self) -> bool {
        !self.matlab && self.dtype.ends_with('O')
    }

    /// Refuses the type of the values; `wanted` says how to fix others than pickles.
    pub(crate) fn unsupported(&self, at: &str, wanted: &'static str) -> Error {
        let wanted = if self.is_pickled() { OBJECTS } else { wanted };
        Error::Dtype { at: at.into(), dtype: self.dtype.clone(), wanted }
    }

    /// Reads the values as f32 in C order; channels are those of `axis`: 1 of samples, 0 of one sample. The stream must end
    /// with the values.
    pub(crate) fn read_f32(
        &self,
        reader: &mut dyn Read,
        at: &str,
        cap: Cap,
        axis: usize,
    ) -> Result<ArrayD<f32>> {
        let mut precision = Precision::default();
        let not_f32 = |flat: u64, value: String| {
            let why = "does not fit f32 (integers to 2^24 = 16777216, floats to 3.4e38); rescale it or save it as f32";
            self.refuse_value(at, flat, value, why.into())
        };
        let (each, channels) = self.along(axis);
        let mut float = |flat, b: [u8; 8]| {
            let value = f64::from_le_bytes(b);
            let short = precision.rounded((flat / each % channels) as usize, value);
            if value.is_finite() && short.is_infinite() {
                return Err(not_f32(flat, format!("{value:e}")));
            }
            Ok(short)
        };
        let signed = |flat, v: i64| match v.unsigned_abs() {
            0..=EXACT => Ok(v as f32),
            _ => Err(not_f32(flat, v.to_string())),
        };
        let unsigned = |flat, v: u64| match v {
            0..=EXACT => Ok(v as f32),
            _ => Err(not_f32(flat, v.to_string())),
        };
        let wanted = "samples are booleans, u8..u64, i8..i64, f16, f32 or f64: convert it, one array for all \
                      samples";
        let values = match (self.kind, self.size) {
            (Some(NumberKind::Bool), _) => {
                self.values(reader, at, cap, |_, [b]: [u8; 1]| Ok(f32::from(u8::from(b != 0))))
            }
            (Some(NumberKind::Float), 2) => {
                self.values(reader, at, cap, |_, b| Ok(f16::from_le_bytes(b).to_f32()))
            }
            (Some(NumberKind::Float), 4) => self.values(reader, at, cap, |_, b| Ok(f32::from_le_bytes(b))),
            (Some(NumberKind::Float), _) => self.values(reader, at, cap, &mut float),
            (Some(NumberKind::Int), _) => self.integers(reader, at, cap, signed, unsigned),
            (Some(NumberKind::Uint), _) => self.integers(reader, at, cap, signed, unsigned),
            _ => return Err(self.unsupported(at, wanted)),
        }?;
        if let Some(lossy) = precision.lossy() {
            return Err(Error::file(at, format!("channel {} {lossy} of the file", lossy.channel)));
        }
        let axes: Vec<usize> = self.shape.iter().map(|axis| *axis as usize).collect();
        let shape = IxDyn(&axes).set_f(self.fortran);
        let array = ArrayD::from_shape_vec(shape, values)
            .map_err(|e| Error::NotAnArray { at: at.into(), why: e.to_string() })?;
        Ok(if array.is_standard_layout() { array } else { array.as_standard_layout().into_owned() })
    }

    /// Reads integers or booleans as i64 in C order, and also whole floats from a MATLAB file or of two axes. The stream
    /// must end with them.
    pub(crate) fn read_i64(
        &self,
        reader: &mut dyn Read,
        at: &str,
        cap: Cap,
        wanted: &'static str,
    ) -> Result<Vec<i64>> {
        let signed = |_, v| Ok(v);
        let unsigned = |flat, v: u64| {
            let why = "does not fit a signed 64-bit integer";
            i64::try_from(v).map_err(|_| self.refuse_value(at, flat, v.to_string(), why.into()))
        };
        let values = match self.kind {
            Some(NumberKind::Bool) => self.values(reader, at, cap, |_, [b]: [u8; 1]| Ok(i64::from(b != 0))),
            Some(NumberKind::Int | NumberKind::Uint) => self.integers(reader, at, cap, signed, unsigned),
            // Many frameworks store one-hot labels as floats.
            Some(NumberKind::Float) if self.matlab || self.shape.len() == 2 => {
                self.whole(reader, at, cap, wanted)
            }
            _ => return Err(self.unsupported(at, wanted)),
        }?;
        Ok(self.in_rows(values))
    }

    /// Brings the stored values of a table, or of a column, into rows.
    pub(crate) fn in_rows<T: Clone>(&self, values: Vec<T>) -> Vec<T> {
        if self.fortran && self.shape.len() == 2 {
            return by_rows(&values, self.shape[0] as usize, self.shape[1] as usize);
        }
        values
    }

    /// Reads floats that are whole.
    fn whole(&self, reader: &mut dyn Read, at: &str, cap: Cap, wanted: &'static str) -> Result<Vec<i64>> {
        let whole = |flat, value: f64| {
            // Up to 2^53 every whole number is a float.
            if value.fract() == 0.0 && value.abs() <= (1u64 << 53) as f64 {
                return Ok(value as i64);
            }
            let why = format!("is not a whole number; {wanted}");
            Err(self.refuse_value(at, flat, format!("{value:?}"), why))
        };
        match self.size {
            4 => self.values(reader, at, cap, |flat, b| whole(flat, f32::from_le_bytes(b).into())),
            _ => self.values(reader, at, cap, |flat, b| whole(flat, f64::from_le_bytes(b))),
        }
    }

    fn refuse_value(&self, at: &str, flat: u64, value: String, why: String) -> Error {
        Error::Value { at: at.into(), index: self.index(flat), value, why }
    }

    fn integers<T>(
        &self,
        reader: &mut dyn Read,
        at: &str,
        cap: Cap,
        signed: impl Fn(u64, i64) -> Result<T>,
        unsigned: impl Fn(u64, u64) -> Result<T>,
    ) -> Result<Vec<T>> {
        macro_rules! as_type {
            ($type:ty, $convert:ident) => {
                self.values(reader, at, cap, |flat, b| $convert(flat, <$type>::from_le_bytes(b).into()))
            };
        }
        match (self.kind == Some(NumberKind::Int), self.size) {
            (true, 1) => as_type!(i8, signed),
            (true, 2) => as_type!(i16, signed),
            (true, 4) => as_type!(i32, signed),
            (true, _) => as_type!(i64, signed),
            (false, 1) => as_type!(u8, unsigned),
            (false, 2) => as_type!(u16, unsigned),
            (false, 4) => as_type!(u32, unsigned),
            (false, _) => as_type!(u64, unsigned),
        }
    }

    /// Reads every value of `B` bytes, the lowest first, and makes sure that nothing follows.
    fn values<T, const B: usize>(
        &self,
        reader: &mut dyn Read,
        at: &str,
        cap: Cap,
        mut convert: impl FnMut(u64, [u8; B]) -> Result<T>,
    ) -> Result<Vec<T>> {
        let count = self.count(at, cap)?;
        let want = count.saturating_mul(B as u64);
        let mut values = Vec::with_capacity(count.min(MAX_TRUST) as usize);
        let mut buffer = vec![0; CHUNK * B];
        let mut done = 0u64;
        while done < count {
            let now = (count - done).min(CHUNK as u64) as usize;
            let got = fill(reader, &mut buffer[..now * B], at)?;
            if got < now * B {
                let got = done * B as u64 + got as u64;
                return Err(Error::Truncated { at: at.into(), got, want });
            }
            for bytes in buffer[..now * B].as_chunks_mut::<B>().0 {
                if self.big {
                    bytes.reverse();
                }
                values.push(convert(done, *bytes)?);
                done += 1;
            }
        }
        // The archive checks its sum only when it is read to the end.
        if fill(reader, &mut [0], at)? != 0 {
            return Err(Error::Excess { at: at.into(), want, shape: self.shape.clone() });
        }
        Ok(values)
    }
}

/// Fills the buffer as far as the stream goes.
pub(crate) fn fill(reader: &mut dyn Read, buffer: &mut [u8], at: &str) -> Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match reader.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(Error::Damaged { at: at.into(), why: e.to_string().to_lowercase() }),
        }
    }
    Ok(filled)
}

/// Brings values that lie column by column into rows.
pub(crate) fn by_rows<T: Clone>(values: &[T], rows: usize, columns: usize) -> Vec<T> {
    (0..values.len()).map(|i| values[(i % columns) * rows + i / columns].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_several_bytes_have_an_order() {
        for dtype in ["|i1", "<i1", ">f4", "|b1"] {
            assert!(number(dtype).0.is_some(), "{dtype}");
        }
        for dtype in ["|i4", "|f8", "=f4", "i4"] {
            assert!(number(dtype).0.is_none(), "{dtype}");
        }
    }
}
