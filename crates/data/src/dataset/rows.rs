//! The recording that each sample of a data set is, or is a window of.

use crate::check::duplicates::units;
use crate::dataset::digest::RowHash;
use crate::dataset::raw::Raw;
use crate::dataset::target_steps::TargetSteps;
use crate::length::length::Length;
use crate::targets::steps::StepTargets;
use std::collections::HashSet;

/// The recording of each sample.
pub(crate) struct RecordingRows {
    /// As read.
    pub recordings: Vec<usize>,
    /// First time step of each, where samples are windows.
    starts: Option<Vec<usize>>,
    /// Of each sample's recording: of the channels that are used, as long as it was recorded.
    hashes: Vec<RowHash>,
}

impl RecordingRows {
    /// Takes the `kept` recordings, or `windows` of them: position in `kept`, first time step.
    pub fn new(row_hash: &[RowHash], kept: &[usize], windows: Option<Vec<(usize, usize)>>) -> Self {
        let (recordings, starts) = match windows {
            None => (kept.to_vec(), None),
            Some(windows) => {
                let (at, starts): (Vec<usize>, Vec<usize>) = windows.into_iter().unzip();
                (at.into_iter().map(|at| kept[at]).collect(), Some(starts))
            }
        };
        Self { hashes: recordings.iter().map(|row| row_hash[*row]).collect(), recordings, starts }
    }

    /// Returns the row of targets of each sample: that of its recording or, where time steps have their own, of its last one;
    /// `positions` are those of its recording and first step, `to` its time steps.
    pub fn target_rows(&self, steps: Option<&StepTargets>, to: usize) -> Vec<usize> {
        match (steps, &self.starts) {
            (Some(steps), Some(starts)) => {
                let windows: Vec<(usize, usize)> =
                    self.recordings.iter().copied().zip(starts.iter().copied()).collect();
                steps.at_ends(&windows, to)
            }
            _ => self.recordings.clone(),
        }
    }

    /// Returns the last step of each sample, where time steps have targets of their own; they follow at `rate` Hz.
    pub fn target_steps(&self, raw: &Raw, rule: Option<Length>, rate: Option<f64>) -> Option<TargetSteps> {
        let (Some(Length::Window { to, hop }), Some(starts), true) =
            (rule, &self.starts, raw.steps.is_some())
        else {
            return None;
        };
        Some(TargetSteps {
            recordings: self.recordings.iter().map(|recording| *recording as u32).collect(),
            steps: starts.iter().map(|start| (start + to - 1) as u32).collect(),
            hop: hop.unwrap_or(to) as u32,
            rate,
        })
    }

    /// Keeps the samples at these places only.
    pub fn select(&self, places: &[usize]) -> Self {
        let of = |all: &Vec<usize>| places.iter().map(|at| all[*at]).collect::<Vec<_>>();
        Self {
            recordings: of(&self.recordings),
            starts: self.starts.as_ref().map(of),
            hashes: places.iter().map(|at| self.hashes[*at]).collect(),
        }
    }

    /// Checks whether samples are windows.
    pub fn is_cut(&self) -> bool {
        self.starts.is_some()
    }

    /// Returns a value of each sample's recording.
    pub fn of<T>(&self, value: impl Fn(usize) -> T) -> Vec<T> {
        self.recordings.iter().map(|row| value(*row)).collect()
    }

    /// Lists the recordings of `kept` without a sample.
    pub fn left_out<'k>(&self, kept: &'k [usize]) -> impl Iterator<Item = usize> + use<'k> {
        let held: HashSet<usize> = self.recordings.iter().copied().collect();
        kept.iter().copied().filter(move |row| !held.contains(row))
    }

    /// Returns for each sample the first sample of its recording or of an exact copy of that.
    pub fn units(&self) -> Vec<u32> {
        units(&self.hashes)
    }

    /// Returns the hash of each sample's recording.
    pub fn hashes(self) -> Vec<RowHash> {
        self.hashes
    }

    /// Lists the origin of each sample: `take1.csv`, or as a window `take1.csv[300..]`.
    pub fn origins(&self, raw: &Raw) -> Vec<String> {
        let origin = |(i, row): (usize, &usize)| match &self.starts {
            None => raw.origins[*row].clone(),
            Some(starts) => format!("{}[{}..]", raw.origins[*row], starts[i]),
        };
        self.recordings.iter().enumerate().map(origin).collect()
    }
}
