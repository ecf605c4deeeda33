//! Targets of time steps, in place of one for each recording.

use crate::length::length::Length;
use crate::{Error, Result};

/// The time steps that rows of targets belong to, recording after recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StepTargets {
    /// Time steps of each recording, each with a row of targets.
    pub steps: Vec<usize>,
    /// Says where a target changes within a recording.
    pub change: String,
}

impl StepTargets {
    /// Counts the rows of targets.
    pub fn rows(&self) -> usize {
        self.steps.iter().sum()
    }

    /// Returns the first row of each recording.
    fn firsts(&self) -> Vec<usize> {
        let next = |at: &mut usize, steps: &usize| Some(std::mem::replace(at, *at + steps));
        self.steps.iter().scan(0, next).collect()
    }

    /// Returns the rows of each recording.
    pub fn ranges(&self) -> Vec<std::ops::Range<usize>> {
        self.firsts().into_iter().zip(&self.steps).map(|(first, steps)| first..first + steps).collect()
    }

    /// Returns the row of the last time step of windows of `to` steps, by recording and first step.
    pub fn at_ends(&self, windows: &[(usize, usize)], to: usize) -> Vec<usize> {
        let firsts = self.firsts();
        windows.iter().map(|(recording, start)| firsts[*recording] + start + to - 1).collect()
    }

    /// Returns the first row of each recording, where `is_same` of every row and the one before within each; otherwise the
    /// first recording that changes, and the row where it does.
    pub fn constant(&self, is_same: impl Fn(usize, usize) -> bool) -> Result<Vec<usize>, (usize, usize)> {
        for (recording, rows) in self.ranges().into_iter().enumerate() {
            if let Some(row) = rows.skip(1).find(|row| !is_same(row - 1, *row)) {
                return Err((recording, row));
            }
        }
        Ok(self.firsts())
    }

    /// Refuses targets of time steps without windows to take them.
    pub fn refuse_without_windows(&self, file: &str, rule: Option<Length>) -> Result<()> {
        if matches!(rule, Some(Length::Window { .. })) {
            return Ok(());
        }
        Err(Error::file(
            file,
            format!(
                "{}; say one for all its rows, or, where the target changes within a recording: give length = {{ kind = \
                 \"window\", to = .. }} (--length window:READINGS), and a window has the target of its last reading",
                self.change
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_has_the_row_of_its_last_step() {
        let steps = StepTargets { steps: vec![4, 3], change: String::new() };
        assert_eq!(steps.at_ends(&[(0, 0), (0, 2), (1, 1)], 2), [1, 3, 6]);
        let of = |rows: &[i64]| steps.constant(|a, b| rows[a] == rows[b]);
        assert_eq!(of(&[1, 1, 1, 1, 2, 2, 2]), Ok(vec![0, 4]));
        assert_eq!(of(&[1, 1, 1, 1, 2, 2, 3]), Err((1, 6)));
    }
}
