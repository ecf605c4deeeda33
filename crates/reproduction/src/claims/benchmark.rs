//! The networks that claims are tested on: of one run, or of several on the same samples.

use taxel::learn::NetworkResults;

use taxel::judge::Case;
use taxel::judge::Comparison;
use taxel::judge::{Judged, Judgement};

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
    /// Look-alikes: classes by label.
    pub look_alikes: Vec<Vec<u32>>,
}

impl<'a> Benchmark<'a> {
    /// Returns the networks of one run.
    pub fn of(case: &Case, judgement: &'a Judgement) -> Self {
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
        Benchmark {
            name: results.name.clone(),
            judgement,
            comparison: Comparison::of(case),
            entries: judgement.networks.iter().filter(|n| n.results.mean.is_some()).map(entry).collect(),
            look_alikes: groups.map(|names| names.iter().filter_map(class).collect()).collect(),
        }
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
