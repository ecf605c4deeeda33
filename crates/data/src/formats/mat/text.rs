//! Reads texts in a MATLAB file: a char matrix, one text a row, or a cell array of them.

use crate::Result;
use crate::formats::archive::Texts;
use crate::formats::mat::mat::{Broken, Element, Form, MATRIX, MatArchive};
use crate::formats::npy::Cap;
use std::io::{Cursor, Read};

/// Classes of variables.
const CELL: u32 = 1;
const CHAR: u32 = 4;
/// Most bytes of a text in a cell, its header included, and of a char matrix.
const MAX_CELL: u32 = 1 << 16;
const MAX_MATRIX: u64 = 1 << 26;
/// Most bytes of all cells, about 170 for a word.
const MAX_ALL: u64 = 1 << 30;

/// Reads the texts of a variable; none of one that holds something else.
pub(crate) fn read(archive: &mut MatArchive, name: &str, place: &str, cap: Cap) -> Result<Option<Texts>> {
    let Some((at, mut element)) = archive.element_of(name)? else { return Ok(None) };
    let texts = (|| {
        let Form { class, shape, .. } = element.form()?;
        match (class, shape.as_slice()) {
            (CHAR, &[_, _]) => {
                let values = rows(&mut element, &shape)?;
                Ok(Some(Texts { shape: vec![shape[0]], values }))
            }
            (CELL, &[rows, columns]) => cells(&mut element, rows, columns, cap),
            _ => Ok(None),
        }
    })();
    texts.map_err(|why: Broken| why.at(place, at)).and_then(|texts| match texts {
        Some(texts) if texts.values.len() as u64 > cap.values => Err(cap.too_large(place, &texts.shape)),
        other => Ok(other),
    })
}

/// Reads the texts of a cell array; none where a cell holds something else.
fn cells(element: &mut Element, rows: u64, columns: u64, cap: Cap) -> Result<Option<Texts>, Broken> {
    let count = rows.saturating_mul(columns);
    if count > cap.values {
        return Err(Broken::Is(format!("a cell array of {count} cells")));
    }
    let (mut stored, mut all) = (vec![], 0);
    for _ in 0..count {
        let (kind, bytes) = element.tag()?;
        all += u64::from(bytes);
        if kind != MATRIX || bytes > MAX_CELL || all > MAX_ALL {
            return Err(Broken::Is(format!("a cell of type {kind} and {bytes} bytes")));
        }
        let mut cell = vec![0; bytes as usize];
        element.stream.read_exact(&mut cell)?;
        // An empty cell has no content at all.
        if cell.is_empty() {
            return Ok(None);
        }
        let mut cell = Element { stream: Box::new(Cursor::new(cell)), big: element.big };
        let Form { class, shape, .. } = cell.form()?;
        if class != CHAR || shape.len() != 2 || shape[0] > 1 {
            return Ok(None);
        }
        stored.push(self::rows(&mut cell, &shape)?.pop().unwrap_or_default());
    }
    Ok(Some(Texts::of_cells(&stored, rows, columns)))
}

/// Refuses texts in another encoding: bytes that are replaced would make one class of two.
fn no_text() -> Broken {
    Broken::Is("a text that is neither UTF-8 nor UTF-16; save it again".into())
}

/// Reads the rows of a char matrix, without the blanks at their end.
fn rows(element: &mut Element, shape: &[u64]) -> Result<Vec<String>, Broken> {
    let (rows, columns) = (shape[0] as usize, shape[1] as usize);
    if shape[0].saturating_mul(shape[1]) > MAX_MATRIX {
        return Err(Broken::Is(format!("a text of {rows} by {columns} characters")));
    }
    let (kind, mut bytes, follow) = element.start()?;
    if follow > 0 {
        (&mut element.stream).take(follow.min(4 * MAX_MATRIX)).read_to_end(&mut bytes)?;
    }
    let wide =
        |pair: &[u8; 2]| if element.big { u16::from_be_bytes(*pair) } else { u16::from_le_bytes(*pair) };
    let characters: Vec<char> = match kind {
        // UTF-8, or bytes.
        1 | 2 | 16 => std::str::from_utf8(&bytes).map_err(|_| no_text())?.chars().collect(),
        // UTF-16.
        4 | 17 => char::decode_utf16(bytes.as_chunks::<2>().0.iter().map(wide))
            .collect::<Result<_, _>>()
            .map_err(|_| no_text())?,
        other => return Err(Broken::Is(format!("characters stored as type {other}"))),
    };
    if characters.len() != rows * columns {
        return Err(Broken::Is(format!("{} characters of {rows} by {columns}", characters.len())));
    }
    let row = |r: usize| (0..columns).map(|c| characters[c * rows + r]).collect::<String>();
    Ok((0..rows).map(|r| row(r).trim_end().to_string()).collect())
}
