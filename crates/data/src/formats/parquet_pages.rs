//! Reads the heads of the pages of a Parquet file, before memory is claimed on their word.
//!
//! After "Apache Parquet, Thrift definition", `PageHeader`, in Thrift's compact protocol: of each field the
//! distance to its number and its type, numbers in groups of seven bits.

/// Most structs in structs of a header that is not damaged.
const MAX_DEPTH: usize = 16;
/// Most values that a byte can stand for, beyond the first: deflate packs 1032 bytes into one at best.
const PACKED: u64 = 1032;
/// Values and bytes that cost little, however few bytes they are said to come from.
const FEW: u64 = 1 << 20;

/// The head of a page.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Page {
    /// Bytes of the head.
    pub head: usize,
    /// Bytes after it, as stored and as they are unpacked.
    pub stored: u64,
    unpacked: u64,
    values: u64,
    is_dictionary: bool,
}

impl Page {
    /// Reads the head of a page; none where it is damaged or not whole.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut reader = Thrift { bytes, at: 0 };
        let mut page = Self::default();
        reader.fields(0, &mut |path, value| {
            let value = u64::try_from(value).unwrap_or(u64::MAX);
            match path {
                [2] => page.unpacked = value,
                [3] => page.stored = value,
                [5 | 8, 1] => page.values = value,
                [7, 1] => (page.values, page.is_dictionary) = (value, true),
                _ => {}
            }
        })?;
        page.head = reader.at;
        Some(page)
    }

    /// Checks whether the stored bytes can hold what the head says; `rows` of one value each may be many equal ones.
    pub fn is_likely(&self, rows: u64) -> bool {
        let packed = self.stored.saturating_mul(PACKED).saturating_add(FEW);
        let most = if self.is_dictionary { self.unpacked } else { packed.max(rows) };
        self.unpacked <= packed && self.values <= most
    }
}

struct Thrift<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Thrift<'_> {
    fn byte(&mut self) -> Option<u8> {
        let byte = self.bytes.get(self.at).copied();
        self.at += 1;
        byte
    }

    fn number(&mut self) -> Option<u64> {
        let mut out = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            out |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Some(out);
            }
        }
        None
    }

    /// Reads a signed number: negative and positive ones alternate.
    fn signed(&mut self) -> Option<i64> {
        let zigzag = self.number()?;
        Some((zigzag >> 1) as i64 ^ -((zigzag & 1) as i64))
    }

    fn skip(&mut self, bytes: u64) -> Option<()> {
        self.at = self.at.checked_add(usize::try_from(bytes).ok()?)?;
        (self.at <= self.bytes.len()).then_some(())
    }

    /// Reads the fields of a struct, and hands whole numbers to `say` with the path of field numbers that leads to them.
    fn fields(&mut self, depth: usize, say: &mut dyn FnMut(&[i64], i64)) -> Option<()> {
        if depth > MAX_DEPTH {
            return None;
        }
        let mut id = 0;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Some(());
            }
            id = match head >> 4 {
                0 => self.signed()?,
                more => id + i64::from(more),
            };
            match head & 0xF {
                3 => say(&[id], i64::from(self.byte()?)),
                4..=6 => say(&[id], self.signed()?),
                12 => self.fields(depth + 1, &mut |path, value| say(&[&[id], path].concat(), value))?,
                other => self.value(other, depth)?,
            }
        }
    }

    /// Passes over a value.
    fn value(&mut self, kind: u8, depth: usize) -> Option<()> {
        match kind {
            1 | 2 => Some(()),
            3 => self.skip(1),
            4..=6 => self.number().map(|_| ()),
            7 => self.skip(8),
            8 => self.number().and_then(|size| self.skip(size)),
            12 => self.fields(depth + 1, &mut |_, _| {}),
            // No head of a page that is written today holds lists.
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_says_sizes_and_values() {
        // type 0, unpacked 300, stored 20, data page { values 1000, .., statistics { min: "ab" } }
        let bytes =
            [0x15, 0, 0x15, 0xD8, 0x04, 0x15, 40, 0x2C, 0x15, 0xD0, 0x0F, 0x4C, 0x18, 2, b'a', b'b', 0, 0, 0];
        let page = Page::read(&bytes).unwrap();
        let want = Page { head: bytes.len(), stored: 20, unpacked: 300, values: 1000, is_dictionary: false };
        assert_eq!(page, want);
        assert!(page.is_likely(0));
        for cut in 0..bytes.len() {
            assert_eq!(Page::read(&bytes[..cut]), None, "{cut}");
        }
        assert!(!Page { unpacked: 1 << 31, ..Page::read(&bytes).unwrap() }.is_likely(0));
        let dictionary = Page { is_dictionary: true, ..Page::read(&bytes).unwrap() };
        assert!(!dictionary.is_likely(0), "1000 values of 300 bytes");
        assert_eq!(Page::read(&[0x1C; 90]), None, "structs without end");
    }
}
