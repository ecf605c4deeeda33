//! Gathers doubts about the files of a set: the first of each kind in words, and how many files have it too.

use crate::error::plural;

/// Doubts by their kind, in the order in which they arose.
#[derive(Debug, Default)]
pub(crate) struct FileDoubts(Vec<FileDoubt>);

#[derive(Debug)]
struct FileDoubt {
    kind: String,
    /// The doubt about the first file, and how to fix it.
    words: String,
    files: usize,
}

impl FileDoubts {
    /// Adds a doubt about a file: words are kept for the first of its kind.
    pub fn add(&mut self, kind: &str, words: String) {
        match self.0.iter_mut().find(|doubt| doubt.kind == kind) {
            Some(known) => known.files += 1,
            None => self.0.push(FileDoubt { kind: kind.into(), words, files: 1 }),
        }
    }

    /// Returns the words of each kind.
    pub fn said(self) -> Vec<String> {
        let one = |FileDoubt { words, files, .. }: FileDoubt| match files {
            1 => words,
            files => format!("{words} (and so in {})", plural(files - 1, "more file")),
        };
        self.0.into_iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_said_once() {
        let mut doubts = FileDoubts::default();
        for (kind, words) in [("a", "first"), ("b", "other"), ("a", "second"), ("a", "third")] {
            doubts.add(kind, words.into());
        }
        assert_eq!(doubts.said(), ["first (and so in 2 more files)", "other"]);
    }
}
