//! What claims are asked of: the networks of one run, or of several on the same samples.

use taxel_trainer::NetworkResults;

use crate::case::Case;
use crate::contest::Contest;
use crate::error::Result;
use crate::judgement::{Judged, Judgement};

/// A network of a run, and where its training started.
#[derive(Debug, Clone)]
pub(crate) struct Entrant {
    /// Name in the experiment.
    pub name: String,
    /// Scores, layers, inputs.
    pub judged: Judged,
    /// Whether training started from a checkpoint.
    pub checkpoint: bool,
    /// What training left as it was.
    pub frozen: Vec<String>,
}

impl Entrant {
    /// Scores.
    pub fn results(&self) -> &NetworkResults {
        &self.judged.results
    }
}

/// The networks of one run, or of several on the same samples.
pub(crate) struct Field<'a> {
    /// Names of the runs.
    pub name: String,
    /// Of the first run.
    pub judgement: &'a Judgement,
    /// Their answers.
    pub contest: Contest,
    /// In the order of the runs.
    pub entrants: Vec<Entrant>,
    /// Look-alikes: classes by label.
    pub look_alikes: Vec<Vec<u32>>,
}

impl<'a> Field<'a> {
    /// # Errors
    /// Damaged records.
    pub fn of(case: &Case, judgement: &'a Judgement) -> Result<Self> {
        let config = case.experiment.config();
        let entrant = |judged: &Judged| {
            let name = judged.results.network.clone();
            let own = config.network(&name);
            Entrant {
                checkpoint: own.is_some_and(|network| network.weights.is_some()),
                frozen: own.map(|network| network.train(&config.train).frozen).unwrap_or_default(),
                judged: judged.clone(),
                name,
            }
        };
        let class = |name: &String| {
            let at = judgement.results.classes.iter().position(|known| known == name);
            at.map(|at| at as u32)
        };
        let groups = config.data.look_alikes.values();
        Ok(Field {
            name: judgement.results.name.clone(),
            judgement,
            contest: Contest::of(case)?,
            entrants: judgement.networks.iter().filter(|n| n.results.mean.is_some()).map(entrant).collect(),
            look_alikes: groups.map(|names| names.iter().filter_map(class).collect()).collect(),
        })
    }

    /// Puts runs on the same samples, divided alike, together. Of two networks of one name the first stays.
    pub fn join(fields: Vec<Self>) -> Vec<Self> {
        let mut joined: Vec<Self> = vec![];
        for field in fields {
            let same = |own: &&mut Self| {
                let (a, b) = (&own.judgement.results, &field.judgement.results);
                (&a.data_digest, &a.protocol, a.seed) == (&b.data_digest, &b.protocol, b.seed)
            };
            let Some(own) = joined.iter_mut().find(same) else {
                joined.push(field);
                continue;
            };
            own.name = format!("{} + {}", own.name, field.name);
            let known = |name: &str| own.entrants.iter().any(|entrant| entrant.name == name);
            let new: Vec<Entrant> = field.entrants.into_iter().filter(|e| !known(&e.name)).collect();
            let wanted = |name: &String| new.iter().any(|entrant| entrant.name == *name);
            own.contest.networks.extend(field.contest.networks.into_iter().filter(|(name, _)| wanted(name)));
            own.entrants.extend(new);
        }
        joined
    }

    /// Entrants that take part where nothing is said about training samples: of a learning curve's rows
    /// those with the most.
    pub fn full(&self) -> impl Iterator<Item = &Entrant> {
        let most = self.entrants.iter().filter_map(|e| e.results().per_class).max();
        self.entrants.iter().filter(move |e| e.results().per_class == most)
    }

    /// The network of the zoo, where there are several the one that bears its name.
    pub fn find(&self, zoo: &str) -> Option<&Entrant> {
        let own = || self.full().filter(|e| e.results().zoo == zoo && e.frozen.is_empty());
        own().find(|e| e.name == zoo).or_else(|| own().next())
    }

    /// The network of the zoo that started from a checkpoint and was tuned as a whole.
    pub fn tuned(&self, zoo: &str) -> Option<&Entrant> {
        self.full().find(|e| e.results().zoo == zoo && e.checkpoint && e.frozen.is_empty())
    }

    /// Entrants that are trained on `count` samples of each class.
    pub fn with(&self, count: usize) -> impl Iterator<Item = &Entrant> {
        self.entrants.iter().filter(move |e| e.results().per_class == Some(count))
    }

    /// Training samples of each class, ascending; empty without a learning curve.
    pub fn counts(&self) -> Vec<usize> {
        let mut counts: Vec<usize> = self.entrants.iter().filter_map(|e| e.results().per_class).collect();
        counts.sort_unstable();
        counts.dedup();
        counts
    }
}
