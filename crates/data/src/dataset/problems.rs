//! Problems of a data set's content, each kind once.

use crate::Error;

/// One kind of problem: its first occurrence and how often it occurs.
#[derive(Debug)]
pub(crate) struct Problem {
    pub first: Error,
    pub count: usize,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.first)?;
        match self.count {
            0 | 1 => Ok(()),
            count => write!(f, " (and {} more like it)", count - 1),
        }
    }
}

/// Collects problems.
#[derive(Default)]
pub(crate) struct Problems(pub Vec<Problem>);

impl Problems {
    pub fn push(&mut self, first: Error) {
        self.0.push(Problem { first, count: 1 });
    }

    /// Counts one more problem of the kind that `seen` remembers; only the first is written out.
    pub fn more(&mut self, seen: &mut Option<usize>, error: impl FnOnce() -> Error) {
        match *seen {
            Some(at) => self.0[at].count += 1,
            None => {
                *seen = Some(self.0.len());
                self.push(error());
            }
        }
    }
}
