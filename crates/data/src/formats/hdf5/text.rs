//! Reads texts in an HDF5 file, and in a MATLAB file of version 7.3: rows of characters, or cells of them.

use crate::formats::archive::Texts;
use crate::formats::hdf5::hdf5::{Hdf5Archive, REFERENCES, RawValue, Variable, damaged, sound, text_size};
use crate::formats::npy::Cap;
use crate::{Error, Result};
use hdf5_reader::{Dataset, Datatype};
use std::collections::HashMap;

/// Most bytes of all texts of a data set.
const MAX_ALL: usize = 1 << 26;
/// Bytes of a reference to a text: its length, an address of eight bytes, a number.
const REFERENCE: usize = 16;

/// Reads the texts of a data set; none of one that holds something else.
pub(crate) fn read(archive: &Hdf5Archive, name: &str, place: &str, cap: Cap) -> Result<Option<Texts>> {
    let Some(Variable { dataset, header, .. }) = archive.variable(name) else { return Ok(None) };
    let (shape, dtype) = (header.shape.clone(), header.dtype.as_str());
    let count = shape.iter().try_fold(1u64, |all, axis| all.checked_mul(*axis));
    let is_text = ["text", "char", "cell"].contains(&dtype);
    if is_text && count.is_none_or(|count| count > cap.values) {
        return Err(cap.too_large(place, &shape));
    }
    match (dtype, shape.as_slice()) {
        ("text", [_] | [_, _]) => Ok(Some(Texts { values: texts(dataset, place)?, shape })),
        ("char", &[rows, _]) => Ok(Some(Texts { shape: vec![rows], values: characters(dataset, place)? })),
        ("cell", &[rows, columns]) => cells(archive, dataset, place, rows, columns),
        _ => Ok(None),
    }
}

/// Refuses texts that are stored otherwise than they say: bytes that are replaced would make one class of two.
fn no_text(place: &str) -> Error {
    Error::file(place, "holds a text that is neither UTF-8 nor UTF-16; save it as UTF-8")
}

fn texts(dataset: &Dataset, place: &str) -> Result<Vec<String>> {
    let text = |bytes: &[u8]| -> Result<String> {
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        let text = std::str::from_utf8(&bytes[..end]).map_err(|_| no_text(place))?;
        Ok(text.trim_end().to_string())
    };
    if let Some(size) = text_size(dataset.dtype()) {
        let bytes = sound(place, || dataset.read_raw_bytes())?;
        return bytes.chunks_exact(size.max(1)).map(text).collect();
    }
    let ends = sound(place, || Ok(dataset.vlen_reference_size()))?;
    if ends != REFERENCE {
        return Err(damaged(place, "its texts lie elsewhere than eight bytes say"));
    }
    let references = sound(place, || dataset.read_array::<RawValue<REFERENCE>>())?;
    let (mut all, mut out) = (0, vec![]);
    for reference in references {
        let bytes = sound(place, || dataset.resolve_vlen_reference_bytes(&reference.0, 1))?;
        all += bytes.len();
        if all > MAX_ALL {
            return Err(damaged(place, "its texts are longer than the file"));
        }
        out.push(text(&bytes)?);
    }
    Ok(out)
}

/// Reads the rows of a matrix of characters, which lie column by column, without the blanks at their end.
fn characters(dataset: &Dataset, place: &str) -> Result<Vec<String>> {
    let &[columns, rows] = dataset.shape() else { return Ok(vec![]) };
    let units = sound(place, || dataset.read_array::<u16>())?;
    let units: Vec<u16> = units.into_iter().collect();
    let row = |row: u64| -> Result<String> {
        let units = (0..columns).filter_map(|column| units.get((column * rows + row) as usize).copied());
        let text: String = char::decode_utf16(units).collect::<Result<_, _>>().map_err(|_| no_text(place))?;
        Ok(text.trim_end().to_string())
    };
    (0..rows).map(row).collect()
}

/// Reads the texts of a cell array; none where a cell holds something else.
fn cells(
    archive: &Hdf5Archive,
    dataset: &Dataset,
    place: &str,
    rows: u64,
    columns: u64,
) -> Result<Option<Texts>> {
    if !matches!(dataset.dtype(), Datatype::Reference { size: 8, .. }) {
        return Ok(None);
    }
    let references = sound(place, || dataset.read_array::<RawValue<8>>())?;
    let group = sound(place, || archive.held.group(REFERENCES))?;
    let kept = sound(place, || group.datasets())?;
    let kept: HashMap<u64, &Dataset> = kept.iter().map(|cell| (cell.address(), cell)).collect();
    let (mut all, mut stored) = (0, vec![]);
    for reference in references {
        let is_text = |cell: &&&Dataset| {
            matches!(cell.shape(), [_, 1]) && matches!(cell.dtype(), Datatype::FixedPoint { size: 2, .. })
        };
        let Some(cell) = kept.get(&u64::from_le_bytes(reference.0)).filter(is_text) else { return Ok(None) };
        let text = characters(cell, place)?.pop().unwrap_or_default();
        all += text.len();
        if all > MAX_ALL {
            return Err(damaged(place, "its texts are longer than the file"));
        }
        stored.push(text);
    }
    let is_whole = stored.len() as u64 == rows * columns;
    Ok(is_whole.then(|| Texts::of_cells(&stored, rows, columns)))
}
