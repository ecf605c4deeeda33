//! The networks that claims are tested on: of one run, or of several on the same samples.

use taxel::learn::{FoldKey, FoldRecord, NetworkResults};

use taxel::judge::Case;
use taxel::judge::statistics::{Look, looks};
use taxel::judge::{Comparison, Result, Statistic};
use taxel::judge::{Judged, Judgement};

use super::contrast::Contrast;
use crate::printed::Papers;

/// A network has learned where it got this share of the way from chance to 100 % on its training samples, in the last
/// epoch. Less says that it was stopped too early or not at all led to learn, so nothing follows about the network.
const LEARNED: f64 = 0.75;

/// A network of a run, and where its training started.
#[derive(Debug, Clone)]
pub(crate) struct RunNetwork {
    /// Name in the experiment.
    pub name: String,
    /// Scores, layers, inputs.
    pub judged: Judged,
    /// Whether training started from a checkpoint.
    pub checkpoint: bool,
    /// Layers that training left as they were.
    pub frozen: Vec<String>,
}

impl RunNetwork {
    /// Returns the scores.
    pub fn results(&self) -> &NetworkResults {
        &self.judged.results
    }
}

/// The networks of one run, or of several on the same samples.
pub(crate) struct Benchmark<'a> {
    /// Names of the runs.
    pub name: String,
    /// Of the first run.
    pub judgement: &'a Judgement,
    /// Their predictions.
    pub comparison: Comparison,
    /// In the order of the runs.
    pub entries: Vec<RunNetwork>,
    /// Networks that have not learned, with their accuracy on the training samples in percent.
    pub untrained: Vec<(RunNetwork, f64)>,
    /// Accuracy of guessing, in percent.
    pub chance: f64,
    /// Seconds of training of each finished fold.
    pub seconds: Vec<(FoldKey, f64)>,
    /// Look-alikes: classes by label.
    pub look_alikes: Vec<Vec<u32>>,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// Tables as the papers print them.
    pub printed: &'a Papers,
}

impl<'a> Benchmark<'a> {
    /// Returns the networks of one run.
    ///
    /// # Errors
    /// A data set without samples; a finished fold whose times cannot be read.
    pub fn of(case: &Case, judgement: &'a Judgement, printed: &'a Papers) -> Result<Self> {
        let results = &judgement.results;
        let entry = |judged: &Judged| RunNetwork {
            name: judged.results.network.clone(),
            // Without one there is nothing that training could have changed.
            checkpoint: !judged.results.changes.is_empty(),
            frozen: judged.frozen.clone(),
            judged: judged.clone(),
        };
        let class = |name: &String| {
            let at = results.task.output_names().iter().position(|known| known == name);
            at.map(|at| at as u32)
        };
        let groups = results.look_alikes.values();
        let comparison = Comparison::of(case);
        let chance = case.chance()?;
        let (mut entries, mut untrained) = (vec![], vec![]);
        for one in judgement.networks.iter().filter(|n| n.results.mean.is_some()).map(entry) {
            let trained = training_score(&comparison, &one.name);
            // What is frozen is not expected to fit.
            match trained.filter(|_| one.frozen.is_empty()) {
                Some(score) if score < chance + LEARNED * (100.0 - chance) => untrained.push((one, score)),
                _ => entries.push(one),
            }
        }
        Ok(Benchmark {
            name: results.name.clone(),
            judgement,
            comparison,
            entries,
            untrained,
            chance,
            seconds: seconds(case)?,
            look_alikes: groups.map(|names| names.iter().filter_map(class).collect()).collect(),
            confidence: 0.95,
            printed,
        })
    }

    /// Checks whether each repetition simulated a world of its own.
    pub fn is_fresh(&self) -> bool {
        self.judgement.results.protocol.worlds().is_some()
    }

    /// Returns the scene or data set, without what was left out of it.
    pub fn scene(&self) -> &str {
        self.judgement.results.source.name.split(' ').next().unwrap_or_default()
    }

    /// Returns how many seconds the training of a fold took; none where nobody measured.
    pub fn train_seconds(&self, record: &FoldRecord) -> Option<f64> {
        self.seconds.iter().find(|(key, _)| *key == record.key).map(|(_, seconds)| *seconds)
    }

    /// Lists what may be looked at: the run as it is, or of one on fresh worlds the first quarter, half and all, as far as
    /// they are done, each at its own confidence.
    pub fn looks(&self) -> Vec<Self> {
        let protocol = &self.judgement.results.protocol;
        if !self.is_fresh() {
            return vec![self.with_confidence(self.confidence)];
        }
        let finished = self.comparison.networks.iter().map(|(_, records)| records.len()).max().unwrap_or(0);
        let planned = looks(protocol.repetitions());
        planned.into_iter().filter(|look| look.repetitions <= finished).map(|look| self.at(look)).collect()
    }

    /// Returns the whole run with intervals of this confidence.
    pub fn with_confidence(&self, confidence: f64) -> Self {
        self.at(Look { repetitions: usize::MAX, confidence })
    }

    fn at(&self, look: Look) -> Self {
        Benchmark {
            name: self.name.clone(),
            judgement: self.judgement,
            comparison: self.comparison.first_repetitions(look.repetitions),
            entries: self.entries.clone(),
            untrained: self.untrained.clone(),
            chance: self.chance,
            seconds: self.seconds.clone(),
            look_alikes: self.look_alikes.clone(),
            confidence: look.confidence,
            printed: self.printed,
        }
    }

    /// Measures a statistic of some networks, one of `count` contrasts of a claim; none where no test part defines it.
    ///
    /// # Errors
    /// A statistic that is not finite.
    pub fn contrast(
        &self,
        words: String,
        names: &[&str],
        statistic: Statistic,
        count: usize,
    ) -> Result<Option<Contrast>> {
        let Some(measured) = self.comparison.effect(names, statistic, self.confidence)? else {
            return Ok(None);
        };
        let refuting = match count {
            0 | 1 => measured,
            _ => self.comparison.effect(names, statistic, self.refuting(count))?.unwrap_or(measured),
        };
        Ok(Some(Contrast::new(words, measured, refuting)))
    }

    /// Returns the confidence at which one of `count` contrasts refutes a claim over all of them.
    pub fn refuting(&self, count: usize) -> f64 {
        1.0 - (1.0 - self.confidence) / count.max(1) as f64
    }

    /// Describes the networks of these names that take no part: not in the run, or not trained.
    pub fn absent(&self, names: &[&str]) -> Vec<String> {
        let one = |name: &str| match self.untrained.iter().find(|(entry, _)| entry.results().zoo == name) {
            Some((_, score)) => {
                format!("{name} trained to its end (right on {score:.0} % of its training samples)")
            }
            None => name.to_string(),
        };
        names.iter().copied().filter(|name| self.find(name).is_none()).map(one).collect()
    }

    /// Puts runs on the same samples, divided alike, together. Of two networks of one name the first stays.
    pub fn join(all: Vec<Self>) -> Vec<Self> {
        let mut joined: Vec<Self> = vec![];
        for other in all {
            let same = |one: &&mut Self| {
                let (a, b) = (&one.judgement.results, &other.judgement.results);
                (&a.data_digest, &a.protocol, a.seed) == (&b.data_digest, &b.protocol, b.seed)
            };
            let Some(first) = joined.iter_mut().find(same) else {
                joined.push(other);
                continue;
            };
            first.name = format!("{} + {}", first.name, other.name);
            let known = |name: &str| first.entries.iter().any(|entry| entry.name == name);
            let new: Vec<RunNetwork> = other.entries.into_iter().filter(|e| !known(&e.name)).collect();
            let wanted = |name: &String| new.iter().any(|entry| entry.name == *name);
            first
                .comparison
                .networks
                .extend(other.comparison.networks.into_iter().filter(|(name, _)| wanted(name)));
            first.entries.extend(new);
            first.untrained.extend(other.untrained);
            first.seconds.extend(other.seconds);
        }
        joined
    }

    /// Returns the networks that take part where nothing is said about training samples: of a learning curve's rows
    /// those with the most.
    pub fn full(&self) -> impl Iterator<Item = &RunNetwork> {
        let most = self.entries.iter().filter_map(|e| e.results().per_class).max();
        self.entries.iter().filter(move |e| e.results().per_class == most)
    }

    /// Returns the network of the zoo, where there are several the one that bears its name.
    pub fn find(&self, zoo: &str) -> Option<&RunNetwork> {
        let candidates = || self.full().filter(|e| e.results().zoo == zoo && e.frozen.is_empty());
        candidates().find(|e| e.name == zoo).or_else(|| candidates().next())
    }

    /// Returns the network of the zoo that started from a checkpoint and was tuned as a whole.
    pub fn tuned(&self, zoo: &str) -> Option<&RunNetwork> {
        self.full().find(|e| e.results().zoo == zoo && e.checkpoint && e.frozen.is_empty())
    }

    /// Returns the networks that are trained on `count` samples of each class.
    pub fn with(&self, count: usize) -> impl Iterator<Item = &RunNetwork> {
        self.entries.iter().filter(move |e| e.results().per_class == Some(count))
    }

    /// Returns the numbers of training samples of each class, ascending; empty without a learning curve.
    pub fn counts(&self) -> Vec<usize> {
        let mut counts: Vec<usize> = self.entries.iter().filter_map(|e| e.results().per_class).collect();
        counts.sort_unstable();
        counts.dedup();
        counts
    }
}

/// Reads how long the trainings of a run took.
fn seconds(case: &Case) -> Result<Vec<(FoldKey, f64)>> {
    let mut all = vec![];
    for network in &case.results.networks {
        for record in case.records(&network.network) {
            let timing = case.folder.timing(&record.key)?;
            all.extend(timing.map(|timing| (timing.key, timing.train_seconds)));
        }
    }
    Ok(all)
}

/// Returns the mean accuracy on the training samples in the last epoch, in percent; none of a baseline.
fn training_score(comparison: &Comparison, name: &str) -> Option<f64> {
    let records = comparison.records(name).iter();
    let last: Vec<f64> = records.filter_map(|r| Some(r.epochs.last()?.train_score)).collect();
    (!last.is_empty()).then(|| last.iter().sum::<f64>() / last.len() as f64)
}
