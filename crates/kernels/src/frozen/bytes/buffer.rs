//! Bytes that start on a cache line.

use std::ops::{Deref, DerefMut};

/// Cache line and widest vector.
const LINE: usize = 64;

/// A fixed number of bytes, starting on a 64-byte boundary.
#[derive(Debug, Default)]
pub struct Bytes {
    data: Vec<u8>,
    start: usize,
    len: usize,
}

impl Bytes {
    /// Bytes that a convolution may read behind the last value: it takes them by four. What they hold does not matter.
    pub const SPARE: usize = 3;

    /// Makes a buffer of `len` times `value`.
    pub fn filled(len: usize, value: u8) -> Self {
        if len == 0 {
            return Bytes::default();
        }
        let data = vec![value; len + LINE - 1];
        // A boundary that cannot be found costs speed, nothing else.
        let start = data.as_ptr().align_offset(LINE).min(LINE - 1);
        Bytes { data, start, len }
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.data[self.start..self.start + self.len]
    }
}

impl DerefMut for Bytes {
    fn deref_mut(&mut self) -> &mut [u8] {
        &mut self.data[self.start..self.start + self.len]
    }
}
