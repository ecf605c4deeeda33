//! How long each method of an experiment takes here, measured for a moment.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use taxel_data::{Dataset, Fold};
use taxel_learn::{RowWork, RunOptions, Silent, Work, clean};
use taxel_zoo::Registry;

use crate::error::Result;
use crate::experiment::Experiment;
use crate::run::Runner;
use crate::variant::Variant;

/// Samples that each method is tried on.
const TRIED: usize = 256;
/// Epochs of which the time of one is measured.
const MORE_EPOCHS: usize = 4;

/// The time that one method takes, measured on a few samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Name of the network or baseline.
    pub name: String,
    /// Whether it is a network, whose time grows with its epochs.
    pub is_network: bool,
    /// Seconds for one sample before the first epoch, such as its encoding; of a baseline for all.
    pub begin: f64,
    /// Seconds for one sample in one epoch; 0 of a baseline.
    pub epoch: f64,
}

/// The trainings of one row, and about how long they take on one thread.
#[derive(Debug, Clone, PartialEq)]
pub struct RowCost {
    /// Name of the row.
    pub network: String,
    /// Trainings of the run.
    pub trainings: usize,
    /// Their seconds; none of a method that could not be tried.
    pub seconds: Option<f64>,
    /// Seconds of trainings on further folds.
    pub further: Option<f64>,
}

impl Estimate {
    fn seconds(&self, work: &Work) -> f64 {
        self.begin * work.samples as f64 + self.epoch * work.seen as f64
    }

    /// Returns the time of the average of these members, which trains each of them again.
    fn of_average(name: &str, members: &[&Estimate]) -> Self {
        let networks: Vec<f64> =
            members.iter().filter(|member| member.is_network).map(|network| network.epoch).collect();
        Estimate {
            name: name.into(),
            is_network: !networks.is_empty(),
            begin: members.iter().map(|member| member.begin).sum(),
            // The samples that it sees are those of all its networks.
            epoch: networks.iter().sum::<f64>() / networks.len().max(1) as f64,
        }
    }
}

/// Measures a few epochs of each network, and each baseline, on up to 256 samples. What cannot be fitted to them is left out. Names of
/// fault-augmented networks are those of `[harden]`, and an average takes what its members take.
pub(crate) fn measured(
    experiment: &Experiment,
    (registry, dataset): (&Registry, &Dataset),
    names: &[String],
    cancel: &AtomicBool,
) -> Result<Vec<Estimate>> {
    let step = dataset.len().div_ceil(TRIED).max(1);
    let rows: Vec<usize> = (0..dataset.len()).step_by(step).collect();
    let few = dataset.select(&rows);
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    let timed = |name: &str, epochs: usize| -> Result<Option<f64>> {
        let changes = Variant { epochs: Some(epochs), ..Variant::default() };
        let experiment = experiment.variant(name, &changes, registry)?.without_search();
        let runner = Runner { experiment: &experiment, registry, dataset: &few };
        let begun = Instant::now();
        // None where it cannot be fitted: the run leaves it out with its reason.
        let fitted = runner.fit(name, &options, None, &Silent, cancel).ok().flatten();
        Ok(fitted.map(|_| begun.elapsed().as_secs_f64() / rows.len().max(1) as f64))
    };
    let averages = &experiment.config().averages;
    let mut estimates: Vec<Estimate> = vec![];
    for name in names {
        if let Some(average) = averages.iter().find(|average| average.label == *name) {
            let find = |member: &String| estimates.iter().find(|estimate| estimate.name == *member);
            if let Some(members) = average.of.iter().map(find).collect::<Option<Vec<_>>>() {
                estimates.push(Estimate::of_average(name, &members));
            }
            continue;
        }
        let Some(begin) = timed(name, 1)? else { continue };
        let is_network = experiment.network(clean(name)).is_some();
        let more = if is_network { timed(name, 1 + MORE_EPOCHS)?.unwrap_or(begin) - begin } else { 0.0 };
        let epoch = more.max(0.0) / MORE_EPOCHS as f64;
        estimates.push(Estimate { name: name.clone(), is_network, begin, epoch });
    }
    Ok(estimates)
}

impl Runner<'_> {
    /// Counts the trainings of each row of the run, and estimates how long they take on one thread, and those on `further` folds. Each
    /// method is tried for a moment on up to 256 samples; nothing else is trained, and nothing is written.
    ///
    /// # Errors
    /// As [`crate::run()`], before anything is trained.
    pub fn costs(&self, further: &[Fold], cancel: &AtomicBool) -> Result<Vec<RowCost>> {
        let rows = self.validation()?.work(further).map_err(|error| self.experiment.located(error))?;
        let mut names: Vec<String> = rows.iter().map(|row| row.candidate.clone()).collect();
        names.dedup();
        let estimates = measured(self.experiment, (self.registry, self.dataset), &names, cancel)?;
        let of = |row: RowWork| {
            let estimate = estimates.iter().find(|estimate| estimate.name == row.candidate);
            RowCost {
                trainings: row.run.trainings,
                seconds: estimate.map(|estimate| estimate.seconds(&row.run)),
                further: estimate.map(|estimate| estimate.seconds(&row.further)),
                network: row.network,
            }
        };
        Ok(rows.into_iter().map(of).collect())
    }
}
