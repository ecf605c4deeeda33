//! Measures how far a few numbers of a sample, without its shape, tell its class.
//!
//! A lighting, offset or gain that differs between the recordings of two classes tells them apart without touch. Such a
//! confound shows in the simplest numbers of a sample: if they alone go half of the way from chance to every sample, the set
//! is suspicious. It may be touch all the same (a larger object is felt by more taxels): only the person who recorded it
//! can say.

use crate::check::voters::{NEIGHBOURS, Voters, measured};
use ndarray::{ArrayD, Axis};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

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
        let voters = voters(x, y, groups, copies)?;
        let accuracy = voters.accuracy(&voters.table);
        let Voters { names: statistics, chance, by_group, .. } = voters;
        Some(Self { accuracy, statistics, chance, by_group })
    }

    /// Measures the same samples by each number alone, the most telling first; empty where [`of`](Self::of) is none.
    pub fn carriers(
        x: &ArrayD<f32>,
        y: &[u32],
        groups: Option<&[u32]>,
        copies: Option<&[u32]>,
    ) -> Vec<Carrier> {
        let Some(voters) = voters(x, y, groups, copies) else { return vec![] };
        let carrier = |(at, statistic): (usize, &String)| {
            let values =
                voters.as_measured.iter().zip(&voters.classes).map(|(line, class)| (line[at], *class));
            let accuracy = voters.accuracy_by(at);
            Carrier { statistic: statistic.clone(), accuracy, values: values.collect() }
        };
        let mut all: Vec<Carrier> = voters.names.iter().enumerate().map(carrier).collect();
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

/// Measures the samples by their statistics; none where [`Shortcut::of`] is none.
fn voters(x: &ArrayD<f32>, y: &[u32], groups: Option<&[u32]>, copies: Option<&[u32]>) -> Option<Voters> {
    if x.ndim() < 2 || x.len_of(Axis(0)) != y.len() {
        return None;
    }
    let rows = measured(y)?;
    let (names, values) = table(x, &rows)?;
    Voters::of((names, values), &rows, y, groups, copies)
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
