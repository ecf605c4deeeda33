//! Measures how far the beginning of a recording alone tells its class.
//!
//! Before anything is touched a sensor cannot know what comes. Where the first time step tells the class all the same, the
//! recordings were made in blocks of one class, or they begin in contact: a drift, a warm sensor or an offset goes with the
//! class, and a network may learn that.

use crate::check::voters::{NEIGHBOURS, Voters, measured};
use crate::dataset::dataset::Dataset;
use ndarray::ArrayViewD;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// Numbers of a time step at most: of more channels or taxels neighbours are averaged.
const NUMBERS: usize = 64;
/// Share of the way from chance to every sample that is worth a warning.
const SUSPICIOUS: f64 = 0.25;
/// Standard errors above chance that are worth one: neighbours vote for each other, so that luck reaches further than among
/// independent guesses.
const ERRORS: f64 = 5.0;

/// A part at the beginning of each recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beginning {
    /// The first time step.
    FirstStep,
    /// The mean of the first tenth of the time steps.
    FirstTenth,
}

/// The share of samples whose class their beginning alone tells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EarlyClass {
    /// The part that was looked at.
    pub part: Beginning,
    /// Share that the five nearest neighbours put into the right class by it, 0..1. Samples of the same group do not vote,
    /// nor do copies.
    pub accuracy: f64,
    /// Share of the largest class, 0..1.
    pub chance: f64,
    /// Samples of the same group were kept from voting.
    pub by_group: bool,
    /// Samples that were measured.
    pub samples: usize,
    /// The channel that alone tells most, and the share that it tells.
    pub channel: Option<(String, f64)>,
}

impl EarlyClass {
    /// Measures the first time step and the first tenth of the samples of a data set. Empty for samples without time or
    /// classes, for fewer than 40 of them, for a single class, and where a value is not finite.
    pub fn of(dataset: &Dataset) -> Vec<Self> {
        let parts = [Beginning::FirstStep, Beginning::FirstTenth];
        parts.into_iter().filter_map(|part| Self::by(part, dataset)).collect()
    }

    fn by(part: Beginning, dataset: &Dataset) -> Option<Self> {
        dataset.targets.labels()?;
        let axis = dataset.spec.layout.time_axis()?;
        let steps = *dataset.spec.shape.get(axis)?;
        let taken = match part {
            Beginning::FirstStep => 1,
            Beginning::FirstTenth => steps / 10,
        };
        let is_told = part == Beginning::FirstTenth && taken < 2;
        if steps < 2 || is_told {
            return None;
        }
        let y = dataset.strata();
        let rows = measured(&y)?;
        let numbers = |row: &usize| beginning(dataset.x.index_axis(ndarray::Axis(0), *row), axis, taken);
        let table: Vec<Vec<f64>> = rows.iter().map(numbers).collect();
        let names = names(dataset, table.first()?.len());
        let (groups, copies) = (dataset.groups.as_deref(), dataset.units.as_deref());
        let voters = Voters::of((names, table), &rows, &y, groups, copies)?;
        let accuracy = voters.accuracy(&voters.table);
        let mut found = Self {
            part,
            accuracy,
            chance: voters.chance,
            by_group: voters.by_group,
            samples: rows.len(),
            channel: None,
        };
        if found.is_suspicious() && voters.names.len() <= NUMBERS {
            let alone = |(at, name): (usize, &String)| (name.clone(), voters.accuracy_by(at));
            found.channel =
                voters.names.iter().enumerate().map(alone).max_by(|(_, a), (_, b)| a.total_cmp(b));
        }
        Some(found)
    }

    /// Checks whether the beginning tells a quarter of the way from chance to every sample or more, and more than luck does.
    pub fn is_suspicious(&self) -> bool {
        let above = self.accuracy - self.chance;
        let error = (self.chance * (1.0 - self.chance) / self.samples as f64).sqrt();
        above >= SUSPICIOUS * (1.0 - self.chance) && above >= ERRORS * error
    }
}

/// Returns the mean over the first `taken` time steps of each channel or taxel, neighbours averaged where there are many.
fn beginning(sample: ArrayViewD<f32>, axis: usize, taken: usize) -> Vec<f64> {
    let mut first = sample;
    first.slice_axis_inplace(ndarray::Axis(axis), ndarray::Slice::from(..taken));
    let mean = first.mapv(f64::from).mean_axis(ndarray::Axis(axis));
    let values: Vec<f64> = mean.map_or(vec![], |mean| mean.into_iter().collect());
    let each = values.len().div_ceil(NUMBERS).max(1);
    values.chunks(each).map(|part| part.iter().sum::<f64>() / part.len() as f64).collect()
}

/// Returns a name for each number: that of the channel where each is one.
fn names(dataset: &Dataset, count: usize) -> Vec<String> {
    let known = &dataset.spec.channel_names;
    if known.len() == count { known.clone() } else { (0..count).map(|at| at.to_string()).collect() }
}

impl Display for EarlyClass {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let part = match self.part {
            Beginning::FirstStep => "the first time step",
            Beginning::FirstTenth => "the first tenth of a recording",
        };
        let votes = if self.by_group { "among other groups" } else { "among the other samples" };
        write!(
            f,
            "{part} alone tells the class of {:.1} % (chance {:.1} %, {NEIGHBOURS} nearest {votes})",
            100.0 * self.accuracy,
            100.0 * self.chance
        )?;
        match &self.channel {
            Some((name, share)) => write!(f, ", channel {name} alone of {:.1} %", 100.0 * share),
            None => Ok(()),
        }
    }
}
