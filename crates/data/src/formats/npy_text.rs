//! Reads texts in a NumPy array: `<U8` (UTF-32) and `|S8` (bytes).

use crate::formats::npy::{Cap, Header, fill};
use crate::{Error, Result};
use std::io::Read;

/// Most characters of a text.
const MAX_LENGTH: usize = 1 << 12;
/// Most bytes of all texts together.
const MAX_BYTES: u64 = 1 << 28;

/// Returns the bytes of a text and of a character; none for other types.
fn sizes(dtype: &str) -> Option<(usize, usize)> {
    let width = match dtype.get(1..2)? {
        "U" => 4,
        "S" => 1,
        _ => return None,
    };
    let length: usize = dtype.get(2..)?.parse().ok()?;
    (length <= MAX_LENGTH).then_some((length * width, width))
}

/// Checks whether an array holds texts.
pub(crate) fn is_text(header: &Header) -> bool {
    sizes(&header.dtype).is_some()
}

/// Reads the texts in C order; the stream must end with them.
pub(crate) fn read(header: &Header, reader: &mut dyn Read, at: &str, cap: Cap) -> Result<Vec<String>> {
    let Some((size, width)) = sizes(&header.dtype) else {
        return Err(Error::Dtype { at: at.into(), dtype: header.dtype.clone(), wanted: "texts are U or S" });
    };
    let count = header.count(at, cap)?;
    let want = count.saturating_mul(size as u64);
    if want > MAX_BYTES {
        let cap = Cap { values: MAX_BYTES / size.max(1) as u64, hint: "save fewer or shorter texts" };
        return Err(cap.too_large(at, &header.shape));
    }
    let (mut texts, mut bytes) = (vec![], vec![0; size]);
    for done in 0..count {
        let got = fill(reader, &mut bytes, at)?;
        if got < size {
            return Err(Error::Truncated { at: at.into(), got: done * size as u64 + got as u64, want });
        }
        let text: Option<String> = match width {
            1 => String::from_utf8(bytes.clone()).ok(),
            _ => bytes.as_chunks::<4>().0.iter().map(|unit| character(*unit, header.big)).collect(),
        };
        let text = text.ok_or_else(|| {
            let seen = String::from_utf8_lossy(&bytes).into_owned();
            let why = format!(
                "text {done}, like {:?}, is not UTF-8; save it as str (dtype U)",
                seen.trim_end_matches('\0')
            );
            Error::file(at, why)
        })?;
        texts.push(text.trim_end_matches('\0').to_string());
    }
    if fill(reader, &mut [0], at)? != 0 {
        return Err(Error::Excess { at: at.into(), want, shape: header.shape.clone() });
    }
    Ok(header.in_rows(texts))
}

fn character(unit: [u8; 4], big: bool) -> Option<char> {
    let code = if big { u32::from_be_bytes(unit) } else { u32::from_le_bytes(unit) };
    char::from_u32(code)
}
