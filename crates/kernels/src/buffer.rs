//! Memory that starts on a cache line.

use std::ops::{Deref, DerefMut};

/// Cache line and widest vector, in floats.
const LINE: usize = 16;

/// A fixed number of floats, zero at first, starting on a 64-byte boundary: vectors then never straddle
/// cache lines.
#[derive(Debug, Default)]
pub struct Buffer {
    data: Vec<f32>,
    start: usize,
    len: usize,
}

impl Buffer {
    /// Makes a buffer of `len` zeros.
    pub fn zeros(len: usize) -> Self {
        if len == 0 {
            return Buffer::default();
        }
        let data = vec![0.0f32; len + LINE - 1];
        // A boundary that cannot be found costs speed, nothing else.
        let start = data.as_ptr().align_offset(4 * LINE).min(LINE - 1);
        Buffer { data, start, len }
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.data[self.start..self.start + self.len]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.data[self.start..self.start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_on_a_cache_line_and_is_zero() {
        for len in [0, 1, 15, 16, 17, 1000] {
            let mut buffer = Buffer::zeros(len);
            assert_eq!(*buffer, vec![0.0; len]);
            assert!(len == 0 || (buffer.as_ptr() as usize).is_multiple_of(64));
            buffer.fill(1.0);
            assert_eq!(buffer.len(), len);
        }
    }
}
