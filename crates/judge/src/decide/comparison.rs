//! Networks on the same test parts: what differs between them, and how sure that is.

use std::collections::BTreeMap;

use taxel_data::Task;
use taxel_learn::{FoldRecord, Protocol};

use super::statistics::{cluster_bootstrap, corrected_t, mcnemar, signed_rank};
use crate::case::Case;
use crate::error::Result;
use crate::values::{Primary, Test};

/// Resamples of a bootstrap interval.
const DRAWS: usize = 2000;

/// Predictions of all networks of a run.
pub struct Comparison {
    /// Finished folds by network.
    pub networks: Vec<(String, Vec<FoldRecord>)>,
    /// Cluster of each sample of the data set; the bootstrap draws whole clusters.
    pub clusters: Vec<u32>,
    /// The task of the run.
    pub task: Task,
    /// How the run was divided.
    pub protocol: Protocol,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// A fold with what each of its samples adds to the primary metric.
struct ScoredFold<'r> {
    record: &'r FoldRecord,
    terms: Vec<f64>,
    scale: f64,
    /// Attributes.
    width: usize,
}

/// Predictions of one network for some samples of a test part.
#[derive(Clone, Copy)]
pub struct Predicted<'a> {
    fold: &'a ScoredFold<'a>,
    rows: &'a [usize],
}

impl<'a> Predicted<'a> {
    /// Returns the true and predicted labels of each sample, one per attribute; nothing of values.
    pub fn each(self) -> impl Iterator<Item = (&'a [u32], &'a [u32])> {
        let Predicted { fold, rows } = self;
        let (truth, predicted) = fold.record.outcome.labels();
        rows.iter().filter_map(move |&row| {
            let places = row * fold.width..(row + 1) * fold.width;
            Some((truth.get(places.clone())?, predicted.get(places)?))
        })
    }

    /// Returns the primary metric.
    pub fn score(self) -> f64 {
        let sum: f64 = self.rows.iter().filter_map(|&row| self.fold.terms.get(row)).sum();
        self.fold.scale * sum / self.rows.len().max(1) as f64
    }

    /// Returns the share of right labels of one attribute in %; the primary metric without one.
    pub fn accuracy(self, attribute: Option<usize>) -> f64 {
        let Some(at) = attribute else { return self.score() };
        let right = self.each().filter(|(truth, predicted)| truth[at] == predicted[at]).count();
        100.0 * right as f64 / self.rows.len().max(1) as f64
    }
}

/// The size of a difference, and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// In the unit of the statistic.
    pub size: f64,
    /// None where nothing tells how much it varies.
    pub interval: Option<[f64; 2]>,
    /// Two-sided; none where there is only a bootstrap.
    pub p: Option<f64>,
}

/// A value of the predictions of several networks; none where it is undefined.
pub type Statistic<'s> = &'s dyn Fn(&[Predicted]) -> Option<f64>;

impl Comparison {
    /// Collects the predictions of all networks and baselines of a run.
    pub fn of(case: &Case) -> Self {
        let tested = case.results.networks.iter().filter(|n| !n.folds.is_empty());
        let records = |name: &String| (name.clone(), case.records(name).cloned().collect());
        Comparison {
            networks: tested.map(|network| records(&network.network)).collect(),
            clusters: case.dataset.clusters(),
            task: case.task().clone(),
            protocol: case.results.protocol.clone(),
            seed: case.results.seed,
        }
    }

    fn records(&self, name: &str) -> &[FoldRecord] {
        self.networks.iter().find(|(known, _)| known == name).map_or(&[], |(_, records)| records)
    }

    /// Returns a record with what its samples add to the primary metric: once for all resamples of a bootstrap.
    fn scored_fold<'r>(&self, record: &'r FoldRecord) -> ScoredFold<'r> {
        let metric = Primary::of(&self.task).metric();
        let terms = metric.terms(&self.task, &record.outcome).unwrap_or_default();
        ScoredFold { record, terms, scale: metric.unit.scale(), width: self.task.attributes().len() }
    }

    /// Returns the test parts that all of `names` predicted: one record each.
    fn parts(&self, names: &[&str]) -> Vec<Vec<ScoredFold<'_>>> {
        let Some((first, rest)) = names.split_first() else { return vec![] };
        let same = |a: &FoldRecord, b: &FoldRecord| {
            (a.key.repetition, a.key.fold) == (b.key.repetition, b.key.fold) && a.index == b.index
        };
        let together = |record| {
            let others = rest.iter().map(|name| self.records(name).iter().find(|r| same(record, r)));
            let all = std::iter::once(Some(record)).chain(others).collect::<Option<Vec<_>>>()?;
            Some(all.into_iter().map(|record| self.scored_fold(record)).collect())
        };
        self.records(first).iter().filter_map(together).collect()
    }

    /// Returns the test for these networks: where there is but one test part McNemar's, of values the signed-rank test.
    pub fn test(&self) -> Test {
        let most = self.networks.iter().map(|(_, records)| records.len()).max().unwrap_or(0);
        match self.task {
            _ if most > 1 => Test::NadeauBengio,
            Task::Classes(_) | Task::Levels(_) => Test::McNemar,
            Task::Values(_) => Test::Wilcoxon,
        }
    }

    /// Returns the ratio of test samples to possible training samples, for Nadeau and Bengio's correction.
    ///
    /// A learning curve trains on few of the samples that are not tested; there the ratio is that of the
    /// split, since parts overlap no more for leaving some out.
    fn ratio(&self, parts: &[Vec<ScoredFold>]) -> f64 {
        let of = |record: &FoldRecord| {
            let tested = record.index.len();
            let trained = match self.protocol {
                Protocol::FewSamples { .. } => self.clusters.len().saturating_sub(tested),
                _ => record.train_samples,
            };
            tested as f64 / trained.max(1) as f64
        };
        parts.iter().map(|part| of(part[0].record)).sum::<f64>() / parts.len().max(1) as f64
    }

    /// Returns a statistic over the test parts of `names`: with several parts by the corrected resampled t-test,
    /// with one by the bootstrap over groups or samples. None where no part defines it.
    ///
    /// # Errors
    /// A statistic that is not finite.
    pub fn effect(&self, names: &[&str], statistic: Statistic, confidence: f64) -> Result<Option<Effect>> {
        let parts = self.parts(names);
        let on = |part: &[ScoredFold], rows: &[usize]| {
            let predictions: Vec<Predicted> = part.iter().map(|fold| Predicted { fold, rows }).collect();
            statistic(&predictions)
        };
        let whole = |part: &Vec<ScoredFold>| on(part, &(0..part[0].record.index.len()).collect::<Vec<_>>());
        let values: Vec<f64> = parts.iter().filter_map(whole).collect();
        match (values.as_slice(), parts.as_slice()) {
            ([], _) => Ok(None),
            ([size], [part]) => {
                let clusters = self.clusters_of(part);
                let purpose = names.join(" ");
                let on_part = |rows: &[usize]| on(part, rows);
                let interval =
                    cluster_bootstrap(&clusters, on_part, confidence, DRAWS, (self.seed, &purpose))?;
                Ok(Some(Effect { size: *size, interval, p: None }))
            }
            ([size], _) => Ok(Some(Effect { size: *size, interval: None, p: None })),
            _ => {
                let test = corrected_t(&values, self.ratio(&parts), confidence)?;
                Ok(Some(Effect { size: test.mean, interval: test.interval, p: Some(test.p) }))
            }
        }
    }

    /// Returns the score of `a` less that of `b`, with a p of [`Comparison::test`]: the primary metric, or the accuracy of
    /// one attribute. With several attributes McNemar's test counts a sample for the network that gets more of them
    /// right.
    ///
    /// # Errors
    /// None that records of a run cause.
    pub fn difference(&self, a: &str, b: &str, attribute: Option<usize>) -> Result<Option<Effect>> {
        let statistic = |both: &[Predicted]| Some(both[0].accuracy(attribute) - both[1].accuracy(attribute));
        let Some(mut effect) = self.effect(&[a, b], &statistic, 0.95)? else { return Ok(None) };
        // A t interval of two folds may go beyond what accuracies can differ by.
        let primary = Primary::of(&self.task);
        effect.interval = effect.interval.map(|bounds| primary.clamped_difference(bounds));
        if let [part] = self.parts(&[a, b]).as_slice() {
            effect.p = Some(match self.task {
                Task::Classes(_) | Task::Levels(_) => mcnemar_of(part, attribute),
                Task::Values(_) => self.signed_rank_of(part)?,
            });
        }
        Ok(Some(effect))
    }

    /// Returns the cluster of each sample of a part.
    fn clusters_of(&self, part: &[ScoredFold]) -> Vec<u32> {
        part[0].record.index.iter().map(|&row| self.clusters[row]).collect()
    }

    /// Returns the p-value of the signed-rank test on what samples add to the metric; of grouped samples on the means of the groups,
    /// since those of one group are not independent.
    fn signed_rank_of(&self, part: &[ScoredFold]) -> Result<f64> {
        let mut groups: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
        let each = part[0].terms.iter().zip(&part[1].terms);
        for (cluster, (a, b)) in self.clusters_of(part).into_iter().zip(each) {
            let (sum, count) = groups.entry(cluster).or_default();
            *sum += a - b;
            *count += 1;
        }
        signed_rank(&groups.into_values().map(|(sum, count)| sum / count as f64).collect::<Vec<_>>())
    }

    /// Returns a value of each test part that two networks share.
    pub fn values(&self, a: &str, b: &str, value: impl Fn(Predicted) -> f64) -> (Vec<f64>, Vec<f64>) {
        let of = |fold: &ScoredFold| {
            let rows: Vec<usize> = (0..fold.record.index.len()).collect();
            value(Predicted { fold, rows: &rows })
        };
        self.parts(&[a, b]).iter().map(|part| (of(&part[0]), of(&part[1]))).unzip()
    }
}

fn mcnemar_of(part: &[ScoredFold], attribute: Option<usize>) -> f64 {
    let (mut only_a, mut only_b) = (0, 0);
    for row in 0..part[0].record.index.len() {
        let right = |fold| Predicted { fold, rows: &[row] }.accuracy(attribute);
        let (a, b) = (right(&part[0]), right(&part[1]));
        only_a += u64::from(a > b);
        only_b += u64::from(b > a);
    }
    mcnemar(only_a, only_b)
}
