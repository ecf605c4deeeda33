//! Lines of a stream of bytes, each with the time of its arrival, in memory of a fixed size.

use std::io::{self, ErrorKind, Read};
use std::time::Instant;

/// Bytes asked for at a time.
const CHUNK: usize = 1 << 16;

/// A line of the input.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum InputLine<'l> {
    /// A line, without its end.
    Whole(&'l [u8]),
    /// A line that is longer than any time step; it was passed over.
    TooLong,
}

/// Parts bytes into lines.
pub(crate) struct Lines<R> {
    from: R,
    buffer: Vec<u8>,
    /// Range of the buffer that is not returned yet.
    start: usize,
    end: usize,
    /// Where to look on for the end of the line.
    looked: usize,
    most: usize,
    too_long: bool,
    ended: bool,
    /// When the last bytes came.
    arrived: Instant,
}

impl<R: Read> Lines<R> {
    /// Makes a reader of lines of at most `most` bytes.
    pub fn new(from: R, most: usize) -> Self {
        let buffer = vec![0; most + CHUNK];
        let arrived = Instant::now();
        Lines { from, buffer, start: 0, end: 0, looked: 0, most, too_long: false, ended: false, arrived }
    }

    /// Returns when the last byte of the last line came.
    pub fn arrived(&self) -> Instant {
        self.arrived
    }

    /// Returns the next line; none at the end. A source that has nothing for a while is read again.
    ///
    /// # Errors
    /// The error of the source.
    pub fn next(&mut self) -> io::Result<Option<InputLine<'_>>> {
        loop {
            let unseen = &self.buffer[self.looked..self.end];
            let found = unseen.iter().position(|byte| *byte == b'\n').map(|at| self.looked + at);
            if let Some(at) = found.or((self.ended && self.start < self.end).then_some(self.end)) {
                let line = self.start..at;
                self.start = (at + 1).min(self.end);
                self.looked = self.start;
                let too_long = std::mem::take(&mut self.too_long) || line.len() > self.most;
                return Ok(Some(if too_long {
                    InputLine::TooLong
                } else {
                    InputLine::Whole(&self.buffer[line])
                }));
            }
            if self.ended {
                return Ok(std::mem::take(&mut self.too_long).then_some(InputLine::TooLong));
            }
            self.looked = self.end;
            if self.end - self.start > self.most {
                (self.too_long, self.start) = (true, self.end);
            }
            if self.buffer.len() - self.end < CHUNK {
                self.buffer.copy_within(self.start..self.end, 0);
                (self.end, self.looked) = (self.end - self.start, self.looked - self.start);
                self.start = 0;
            }
            match self.from.read(&mut self.buffer[self.end..]) {
                Ok(0) => self.ended = true,
                Ok(count) => {
                    self.arrived = Instant::now();
                    self.end += count;
                }
                Err(e)
                    if matches!(
                        e.kind(),
                        ErrorKind::Interrupted | ErrorKind::TimedOut | ErrorKind::WouldBlock
                    ) => {}
                Err(e) => return Err(e),
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Hands out at most so many bytes at a time.
    struct Slow<'b>(&'b [u8], usize);

    impl Read for Slow<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(self.0.len()).min(into.len());
            into[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    /// Reads all lines as text, `-` for one that is too long.
    fn all(bytes: &[u8], piece: usize, most: usize) -> Vec<String> {
        let mut lines = Lines::new(Slow(bytes, piece), most);
        let mut found = vec![];
        while let Some(line) = lines.next().unwrap() {
            found.push(match line {
                InputLine::Whole(line) => String::from_utf8(line.to_vec()).unwrap(),
                InputLine::TooLong => "-".into(),
            });
        }
        found
    }

    #[test]
    fn lines_come_whole_in_whatever_pieces() {
        for piece in [1, 2, 3, 5, 100] {
            assert_eq!(all(b"ab\n\ncd\r\nlast", piece, 10), ["ab", "", "cd\r", "last"], "{piece}");
            assert_eq!(all(b"ab\n", piece, 10), ["ab"]);
            assert_eq!(all(b"", piece, 10), [""; 0]);
            assert_eq!(all(b"123456\n12345\n1234567", piece, 5), ["-", "12345", "-"], "{piece}");
        }
    }

    #[test]
    fn what_never_ends_takes_no_more_memory() {
        let long = vec![b'x'; 10 * CHUNK];
        let mut lines = Lines::new(&long[..], 100);
        let before = lines.buffer.capacity();
        assert_eq!(lines.next().unwrap(), Some(InputLine::TooLong));
        assert_eq!(lines.next().unwrap(), None);
        assert_eq!(lines.buffer.capacity(), before);
    }
}
