//! Measures how far a few numbers of a sample, without its shape, tell its class.
//!
//! A lighting, offset or gain that differs between the recordings of two classes tells them apart without touch. Such a
//! confound shows in the simplest numbers of a sample: if they alone go half of the way from chance to every sample, the set
//! is suspicious. It may be touch all the same (a larger object is felt by more taxels): only the person who recorded it
//! can say.

use ndarray::{ArrayD, Axis};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// Neighbours that vote.
const NEIGHBOURS: usize = 5;
/// With fewer samples luck looks like a shortcut.
const LEAST: usize = 40;
/// Most samples that are measured, spread evenly over all.
const MOST: usize = 4000;
/// With more channels their means are no longer a few numbers.
const CHANNELS: usize = 8;
/// Share of the way from chance to every sample that is worth a warning.
const SUSPICIOUS: f64 = 0.5;

/// The share of samples that their global statistics alone tell apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shortcut {
    /// The numbers of a sample: `mean`, `SD`, `lowest`, `highest`, and `mean of 0` for channel 0.
    pub statistics: Vec<String>,
    /// Share that the five nearest neighbours by these numbers put into the right class, 0..1. Samples of
    /// the same group do not vote, nor do copies.
    pub accuracy: f64,
    /// Share of the largest class, 0..1.
    pub chance: f64,
    /// Samples of the same group were kept from voting.
    pub by_group: bool,
}

impl Shortcut {
    /// Measures samples `[N, ...]` with labels `[N]`; channels lie along axis 1. `groups` `[N]` are
    /// sessions or objects, `copies` `[N]` the units of [`Dataset::units`](crate::Dataset::units).
    ///
    /// None for fewer than 40 samples, for a single class, and where a value is not finite.
    pub fn of(x: &ArrayD<f32>, y: &[u32], groups: Option<&[u32]>, copies: Option<&[u32]>) -> Option<Self> {
        let voters = Voters::of(x, y, groups, copies)?;
        let accuracy = voters.accuracy(&voters.table);
        let Voters { statistics, chance, by_group, .. } = voters;
        Some(Self { accuracy, statistics, chance, by_group })
    }

    /// Measures the same samples by each number alone, the most telling first; empty where [`of`](Self::of) is none.
    pub fn carriers(
        x: &ArrayD<f32>,
        y: &[u32],
        groups: Option<&[u32]>,
        copies: Option<&[u32]>,
    ) -> Vec<Carrier> {
        let Some(voters) = Voters::of(x, y, groups, copies) else { return vec![] };
        let carrier = |(at, statistic): (usize, &String)| {
            let column: Vec<Vec<f64>> = voters.table.iter().map(|line| vec![line[at]]).collect();
            let values =
                voters.as_measured.iter().zip(&voters.classes).map(|(line, class)| (line[at], *class));
            let accuracy = voters.accuracy(&column);
            Carrier { statistic: statistic.clone(), accuracy, values: values.collect() }
        };
        let mut all: Vec<Carrier> = voters.statistics.iter().enumerate().map(carrier).collect();
        all.sort_by(|a, b| b.accuracy.total_cmp(&a.accuracy));
        all
    }

    /// Checks whether the numbers go half of the way from chance to every sample, or further.
    pub fn is_suspicious(&self) -> bool {
        self.accuracy - self.chance >= SUSPICIOUS * (1.0 - self.chance)
    }
}

/// One of the numbers of a [`Shortcut`], alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Carrier {
    /// As in [`Shortcut::statistics`].
    pub statistic: String,
    /// As [`Shortcut::accuracy`], by this number alone.
    pub accuracy: f64,
    /// The number and the class of each sample that was measured.
    #[serde(skip)]
    pub values: Vec<(f64, u32)>,
}

/// The samples that are measured, by their numbers.
struct Voters {
    statistics: Vec<String>,
    /// `[sample][number]`.
    as_measured: Vec<Vec<f64>>,
    /// The same with mean 0 and SD 1 in each number.
    table: Vec<Vec<f64>>,
    classes: Vec<u32>,
    /// Samples of one unit do not vote for each other.
    units: Vec<u32>,
    chance: f64,
    by_group: bool,
}

impl Voters {
    /// Measures the samples; none where [`Shortcut::of`] is none.
    fn of(x: &ArrayD<f32>, y: &[u32], groups: Option<&[u32]>, copies: Option<&[u32]>) -> Option<Self> {
        let step = y.len().div_ceil(MOST).max(1);
        let rows: Vec<usize> = (0..y.len()).step_by(step).collect();
        if rows.len() < LEAST || x.ndim() < 2 || x.len_of(Axis(0)) != y.len() {
            return None;
        }
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        rows.iter().for_each(|&row| *counts.entry(y[row]).or_default() += 1);
        let largest = counts.values().max().copied().unwrap_or(0);
        if largest == rows.len() {
            return None;
        }
        let (statistics, as_measured) = table(x, &rows)?;
        let mut table = as_measured.clone();
        standardise(&mut table);
        let several = |groups: &&[u32]| groups.windows(2).any(|pair| pair[0] != pair[1]);
        let groups = groups.filter(|groups| groups.len() == y.len()).filter(several);
        let units = groups.or(copies.filter(|copies| copies.len() == y.len()));
        Some(Self {
            statistics,
            as_measured,
            table,
            classes: rows.iter().map(|row| y[*row]).collect(),
            units: rows.iter().map(|row| units.map_or(*row as u32, |units| units[*row])).collect(),
            chance: largest as f64 / rows.len() as f64,
            by_group: groups.is_some(),
        })
    }

    /// Returns the share of samples that the nearest of other units by `table` put into the right class.
    fn accuracy(&self, table: &[Vec<f64>]) -> f64 {
        let all = 0..table.len();
        let right = all.clone().filter(|&at| {
            let others = all.clone().filter(|&other| self.units[other] != self.units[at]);
            vote(table, at, others.map(|other| (other, self.classes[other]))) == Some(self.classes[at])
        });
        right.count() as f64 / table.len() as f64
    }
}

impl Display for Shortcut {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let numbers = match self.statistics.len() - 4 {
            0 => "mean, SD, lowest and highest value".into(),
            channels => format!("mean, SD, lowest and highest value and {channels} channel means"),
        };
        let votes = if self.by_group { "among other groups" } else { "among the other samples" };
        write!(
            f,
            "{numbers} of a sample alone tell {:.1} % of them (chance {:.1} %, {NEIGHBOURS} nearest {votes})",
            100.0 * self.accuracy,
            100.0 * self.chance
        )
    }
}

/// Returns the names of the statistics, and their values for each of `rows`; none where one is not finite.
fn table(x: &ArrayD<f32>, rows: &[usize]) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let channels = if x.ndim() > 2 && x.len_of(Axis(1)) <= CHANNELS { x.len_of(Axis(1)) } else { 0 };
    let mut names: Vec<String> = ["mean", "SD", "lowest", "highest"].map(String::from).to_vec();
    names.extend((0..channels).map(|channel| format!("mean of {channel}")));
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
        sum / count.max(1) as f64
    };
    let mut table = Vec::with_capacity(rows.len());
    for &row in rows {
        let sample = x.index_axis(Axis(0), row);
        let values = || sample.iter().map(|&v| f64::from(v));
        let middle = mean(&mut values());
        let mut line = vec![
            middle,
            mean(&mut values().map(|v| (v - middle).powi(2))).sqrt(),
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        ];
        let channel_mean =
            |channel| mean(&mut sample.index_axis(Axis(0), channel).iter().map(|&v| f64::from(v)));
        line.extend((0..channels).map(channel_mean));
        if !line.iter().all(|v| v.is_finite()) {
            return None;
        }
        table.push(line);
    }
    Some((names, table))
}

/// Brings every column to mean 0 and SD 1; a constant one to 0.
fn standardise(table: &mut [Vec<f64>]) {
    let n = table.len().max(1) as f64;
    for column in 0..table.first().map_or(0, Vec::len) {
        let mean = table.iter().map(|line| line[column]).sum::<f64>() / n;
        let sd = (table.iter().map(|line| (line[column] - mean).powi(2)).sum::<f64>() / n).sqrt();
        let sd = if sd > 1e-12 * mean.abs() { sd } else { f64::INFINITY };
        table.iter_mut().for_each(|line| line[column] = (line[column] - mean) / sd);
    }
}

/// Returns the class of most of the nearest; of equals the one with the nearer neighbours.
fn vote(table: &[Vec<f64>], at: usize, others: impl Iterator<Item = (usize, u32)>) -> Option<u32> {
    let mut nearest: Vec<(f64, u32)> = Vec::with_capacity(NEIGHBOURS + 1);
    for (other, class) in others {
        let distance: f64 = table[at].iter().zip(&table[other]).map(|(a, b)| (a - b) * (a - b)).sum();
        if nearest.len() == NEIGHBOURS && nearest.last().is_some_and(|(far, _)| *far <= distance) {
            continue;
        }
        let place = nearest.partition_point(|(near, _)| *near <= distance);
        nearest.insert(place, (distance, class));
        nearest.truncate(NEIGHBOURS);
    }
    let votes = |class: u32| nearest.iter().filter(|(_, vote)| *vote == class).count();
    // `max_by_key` returns the last of equals: in reversed order the nearest.
    nearest.iter().rev().map(|(_, class)| *class).max_by_key(|class| votes(*class))
}
