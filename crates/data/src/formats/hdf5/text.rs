//! Texts in an HDF5 file, and in a MATLAB file of version 7.3: rows of characters, or cells of them.

use crate::formats::archive::Texts;
use crate::formats::hdf5::hdf5::{Archive, REFERENCES, Stored, damaged, sound, text_size};
use crate::formats::npy::Cap;
use crate::{Error, Result};
use hdf5_reader::{Dataset, Datatype};
use std::collections::HashMap;

/// Most bytes of all texts of a data set.
const MAX_ALL: usize = 1 << 26;
/// Bytes of a reference to a text: its length, an address of eight bytes, a number.
const REFERENCE: usize = 16;

/// The texts of a data set; none of one that holds something else.
pub(crate) fn read(archive: &Archive, name: &str, place: &str, cap: Cap) -> Result<Option<Texts>> {
    let Some(variable) = archive.variable(name) else { return Ok(None) };
    let (shape, dtype) = variable.form();
    let (shape, dataset) = (shape.to_vec(), &variable.dataset);
    let count = shape.iter().try_fold(1u64, |all, axis| all.checked_mul(*axis));
    let is_text = ["text", "char", "cell"].contains(&dtype);
    if is_text && count.is_none_or(|count| count > cap.values) {
        return Err(Error::TooLarge { at: place.into(), shape, limit: cap.values, hint: cap.hint });
    }
    match (dtype, shape.as_slice()) {
        ("text", [_] | [_, _]) => Ok(Some(Texts { values: texts(dataset, place)?, shape })),
        ("char", &[rows, _]) => Ok(Some(Texts { shape: vec![rows], values: characters(dataset, place)? })),
        ("cell", &[rows, columns]) => cells(archive, dataset, place, rows, columns),
        _ => Ok(None),
    }
}

fn texts(dataset: &Dataset, place: &str) -> Result<Vec<String>> {
    let text = |bytes: &[u8]| {
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(&bytes[..end]).trim_end().to_string()
    };
    if let Some(size) = text_size(dataset.dtype()) {
        let bytes = sound(place, || dataset.read_raw_bytes())?;
        return Ok(bytes.chunks_exact(size.max(1)).map(text).collect());
    }
    let ends = sound(place, || Ok(dataset.vlen_reference_size()))?;
    if ends != REFERENCE {
        return Err(damaged(place, "its texts lie elsewhere than eight bytes say"));
    }
    let references = sound(place, || dataset.read_array::<Stored<REFERENCE>>())?;
    let (mut all, mut out) = (0, vec![]);
    for own in references {
        let bytes = sound(place, || dataset.resolve_vlen_reference_bytes(&own.0, 1))?;
        all += bytes.len();
        if all > MAX_ALL {
            return Err(damaged(place, "its texts are longer than the file"));
        }
        out.push(text(&bytes));
    }
    Ok(out)
}

/// The rows of a matrix of characters, which lie column by column, without the blanks that fill them up.
fn characters(dataset: &Dataset, place: &str) -> Result<Vec<String>> {
    let &[columns, rows] = dataset.shape() else { return Ok(vec![]) };
    let units = sound(place, || dataset.read_array::<u16>())?;
    let units: Vec<u16> = units.into_iter().collect();
    let row = |row: u64| {
        let own = (0..columns).filter_map(|column| units.get((column * rows + row) as usize).copied());
        let text: String =
            char::decode_utf16(own).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        text.trim_end().to_string()
    };
    Ok((0..rows).map(row).collect())
}

/// The texts of a cell array, which lie column by column; none where a cell holds something else.
fn cells(
    archive: &Archive,
    dataset: &Dataset,
    place: &str,
    rows: u64,
    columns: u64,
) -> Result<Option<Texts>> {
    if !matches!(dataset.dtype(), Datatype::Reference { size: 8, .. }) {
        return Ok(None);
    }
    let references = sound(place, || dataset.read_array::<Stored<8>>())?;
    let group = sound(place, || archive.held.group(REFERENCES))?;
    let kept = sound(place, || group.datasets())?;
    let kept: HashMap<u64, &Dataset> = kept.iter().map(|own| (own.address(), own)).collect();
    let (mut all, mut stored) = (0, vec![]);
    for own in references {
        let is_short = |own: &&&Dataset| {
            matches!(own.shape(), [_, 1]) && matches!(own.dtype(), Datatype::FixedPoint { size: 2, .. })
        };
        let Some(own) = kept.get(&u64::from_le_bytes(own.0)).filter(is_short) else { return Ok(None) };
        let text = characters(own, place)?.pop().unwrap_or_default();
        all += text.len();
        if all > MAX_ALL {
            return Err(damaged(place, "its texts are longer than the file"));
        }
        stored.push(text);
    }
    let (r, c) = (rows as usize, columns as usize);
    if stored.len() != r * c {
        return Ok(None);
    }
    let values = (0..stored.len()).map(|i| stored[(i % c) * r + i / c].clone()).collect();
    let shape = if r.min(c) == 1 { vec![rows * columns] } else { vec![rows, columns] };
    Ok(Some(Texts { shape, values }))
}
