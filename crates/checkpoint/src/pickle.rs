//! The memory that a pickle would take, counted before anybody reads it: candle's reader believes the length of a
//! text and the number of copies that the file states.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use zip::ZipArchive;

use crate::error::Cause;

/// Objects that a pickle may copy, besides one for each of its bytes; `torch.save` copies fewer than that.
const COPIES: u64 = 1 << 18;

/// Refuses an archive whose pickles would take more memory than they are worth; `length` is the file's.
pub(crate) fn check(path: &Path, length: u64) -> Result<(), Cause> {
    let damaged = |why: &str| Cause::Pth(format!("is damaged: its pickle {why}"));
    let refuse = |e: zip::result::ZipError| Cause::Pth(e.to_string());
    let mut archive = ZipArchive::new(BufReader::new(File::open(path)?)).map_err(refuse)?;
    for at in 0..archive.len() {
        let file = archive.by_index(at).map_err(refuse)?;
        if !file.name().map_err(refuse)?.ends_with("data.pkl") {
            continue;
        }
        // It lies in the archive as it is.
        let mut pickle = vec![];
        file.take(length + 1).read_to_end(&mut pickle)?;
        if pickle.len() as u64 > length {
            return Err(damaged("is larger than the file"));
        }
        let most = COPIES + pickle.len() as u64;
        if Walk::new(&pickle).copies(most).is_none_or(|copies| copies > most) {
            return Err(damaged("makes no sense"));
        }
    }
    Ok(())
}

/// A walk through a pickle that keeps of each object how many it holds, itself included.
struct Walk<'a> {
    rest: &'a [u8],
    /// None for a mark.
    stack: Vec<Option<u64>>,
    memo: HashMap<u32, u64>,
    copies: u64,
}

impl<'a> Walk<'a> {
    fn new(pickle: &'a [u8]) -> Self {
        Walk { rest: pickle, stack: vec![], memo: HashMap::new(), copies: 0 }
    }

    /// Counts how many objects are copied, `most` at most and a few; none for a pickle that ends too early.
    fn copies(mut self, most: u64) -> Option<u64> {
        while self.copies <= most {
            match self.take(1)?[0] {
                b'.' => break,
                code => self.step(code)?,
            }
        }
        Some(self.copies)
    }

    /// Takes one operation. Those that candle does not know end its reading, and this.
    fn step(&mut self, code: u8) -> Option<()> {
        match code {
            0x80 => drop(self.take(1)?),
            b'c' => {
                self.line()?;
                self.line()?;
                self.push(1);
            }
            b'K' => self.constant(1)?,
            b'M' => self.constant(2)?,
            b'J' => self.constant(4)?,
            b'G' => self.constant(8)?,
            0x8a => {
                let count = self.number(1)?;
                self.constant(count)?;
            }
            b'X' => {
                let count = self.number(4)?;
                self.constant(count)?;
            }
            b'N' | b')' | b']' | b'}' | b'd' | 0x88 | 0x89 => self.push(1),
            b'(' => self.stack.push(None),
            b'Q' => self.join(1),
            0x85 => self.join(1),
            0x86 | 0x81 | b'R' | b'b' | b'a' => self.join(2),
            0x87 | b's' => self.join(3),
            b't' => {
                let sum = self.marked();
                self.push(sum + 1);
            }
            b'e' | b'u' => {
                let sum = self.marked();
                let before = self.pop();
                self.push(before + sum);
            }
            b'q' | b'r' => {
                let at = self.number(if code == b'q' { 1 } else { 4 })?;
                let last = self.stack.last().copied().flatten().unwrap_or(0);
                self.copies += last;
                self.memo.insert(at as u32, last);
            }
            b'h' | b'j' => {
                let at = self.number(if code == b'h' { 1 } else { 4 })?;
                let copied = self.memo.get(&(at as u32)).copied().unwrap_or(0);
                self.copies += copied;
                self.push(copied);
            }
            _ => return None,
        }
        Some(())
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn line(&mut self) -> Option<()> {
        let end = self.rest.iter().position(|byte| *byte == b'\n')?;
        self.take(end + 1).map(drop)
    }

    /// Takes a number of that many bytes, the least significant first.
    fn number(&mut self, bytes: usize) -> Option<usize> {
        Some(self.take(bytes)?.iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte)))
    }

    fn constant(&mut self, bytes: usize) -> Option<()> {
        self.take(bytes)?;
        self.push(1);
        Some(())
    }

    fn push(&mut self, size: u64) {
        self.stack.push(Some(size));
    }

    /// Takes the last object off: 0 where a pickle takes more than it has given, which candle refuses.
    fn pop(&mut self) -> u64 {
        self.stack.pop().flatten().unwrap_or(0)
    }

    /// Joins the last `count` objects to one.
    fn join(&mut self, count: usize) {
        let sum: u64 = (0..count).map(|_| self.pop()).sum();
        self.push(sum + 1);
    }

    /// Takes everything off down to the last mark.
    fn marked(&mut self) -> u64 {
        let mut sum = 0;
        while let Some(Some(size)) = self.stack.pop() {
            sum += size;
        }
        sum
    }
}
