//! The manifest: one trial a line, written and read line by line.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;

use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::trial::Trial;

/// The trials of a manifest with their position, from 0.
pub struct Manifest {
    path: PathBuf,
    lines: BufReader<File>,
    next: usize,
    line: Vec<u8>,
}

impl Manifest {
    /// Opens the manifest of a sweep, from trial `first` on.
    ///
    /// # Errors
    /// A file that cannot be read, or that has no such trial.
    pub fn open(folder: &SweepFolder, first: usize) -> Result<Self> {
        let path = folder.manifest();
        let file = File::open(&path).map_err(|e| Error::io(&path, "read", e))?;
        let mut lines = BufReader::with_capacity(1 << 16, file);
        for next in 0..first {
            if lines.skip_until(b'\n').map_err(|e| Error::io(&path, "read", e))? == 0 {
                return Err(Error::file(&path, format!("has {next} trials, none of number {first}")));
            }
        }
        Ok(Manifest { path, lines, next: first, line: vec![] })
    }

    fn read(&mut self) -> Result<Option<(usize, Trial)>> {
        self.line.clear();
        let read = self.lines.read_until(b'\n', &mut self.line);
        if read.map_err(|e| Error::io(&self.path, "read", e))? == 0 {
            return Ok(None);
        }
        let number = self.next;
        let trial = serde_json::from_slice(&self.line).map_err(|e| {
            let reason = format!("trial {number} cannot be read: {e}; plan the sweep again");
            Error::file(&self.path, reason)
        })?;
        self.next += 1;
        Ok(Some((number, trial)))
    }
}

impl Iterator for Manifest {
    type Item = Result<(usize, Trial)>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read().transpose()
    }
}

/// Adds one trial to a manifest that is being written.
pub(crate) fn write_line(out: &mut impl Write, trial: &Trial) -> std::io::Result<()> {
    serde_json::to_writer(&mut *out, trial)?;
    out.write_all(b"\n")
}
