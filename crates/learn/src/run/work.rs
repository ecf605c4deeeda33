//! The work of a run, counted before it begins.

use taxel_data::Fold;

use crate::estimator::candidate::Candidate;
use crate::run::plan::{PlannedRow, RunPlan};

/// The trainings of one row of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RowWork {
    /// Name of the row.
    pub network: String,
    /// Name of the candidate that is trained; of a learning curve several rows have one.
    pub candidate: String,
    /// The trainings on the folds of the run.
    pub run: Work,
    /// The trainings on further folds.
    pub further: Work,
}

/// A number of trainings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// Trainings.
    pub trainings: usize,
    /// Training samples of all of them.
    pub samples: usize,
    /// The same times epochs, at most; 0 of a baseline.
    pub seen: usize,
}

impl Work {
    fn of<'f>(candidate: &Candidate, folds: impl Iterator<Item = &'f Fold>) -> Self {
        folds.fold(Work::default(), |sum, fold| Work {
            trainings: sum.trainings + 1,
            samples: sum.samples + fold.train.len(),
            seen: sum.seen + candidate.estimator.samples(fold),
        })
    }
}

impl RunPlan<'_> {
    /// Counts what each row trains, on its own folds and on `further` ones.
    pub fn work(&self, further: &[Fold]) -> Vec<RowWork> {
        let of = |row: &PlannedRow| {
            let candidate = &self.candidates[row.candidate];
            let keys = self.keys.iter().filter(|key| key.network == row.name);
            RowWork {
                network: row.name.clone(),
                candidate: candidate.name.clone(),
                run: Work::of(candidate, keys.filter_map(|key| self.fold(key))),
                further: Work::of(candidate, further.iter()),
            }
        };
        self.rows.iter().map(of).collect()
    }
}
