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

/// What all networks predicted in a run.
pub struct Comparison {
    /// Finished folds by network.
    pub networks: Vec<(String, Vec<FoldRecord>)>,
    /// What is drawn as one by the bootstrap, per sample of the data set.
    pub clusters: Vec<u32>,
    /// What is learned.
    pub task: Task,
    /// How the run was divided.
    pub protocol: Protocol,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// A fold with what each of its samples adds to the primary metric.
struct Told<'r> {
    record: &'r FoldRecord,
    terms: Vec<f64>,
    scale: f64,
    /// Attributes.
    width: usize,
}

/// Predictions of one network for some samples of a test part.
#[derive(Clone, Copy)]
pub struct Answers<'a> {
    told: &'a Told<'a>,
    rows: &'a [usize],
}

impl<'a> Answers<'a> {
    /// True and predicted labels of each sample, one per attribute; nothing of values.
    pub fn each(self) -> impl Iterator<Item = (&'a [u32], &'a [u32])> {
        let Answers { told, rows } = self;
        let (truth, predicted) = told.record.outcome.labels();
        rows.iter().filter_map(move |&row| {
            let own = row * told.width..(row + 1) * told.width;
            Some((truth.get(own.clone())?, predicted.get(own)?))
        })
    }

    /// Returns the primary metric.
    pub fn score(self) -> f64 {
        let sum: f64 = self.rows.iter().filter_map(|&row| self.told.terms.get(row)).sum();
        self.told.scale * sum / self.rows.len().max(1) as f64
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

/// One value of some answers; none where they leave it undefined.
pub type Statistic<'s> = &'s dyn Fn(&[Answers]) -> Option<f64>;

impl Comparison {
    /// All networks and baselines of a run.
    pub fn of(case: &Case) -> Self {
        let tested = case.results.networks.iter().filter(|n| !n.folds.is_empty());
        let records = |name: &String| (name.clone(), case.records(name).cloned().collect());
        Comparison {
            networks: tested.map(|own| records(&own.network)).collect(),
            clusters: case.dataset.clusters(),
            task: case.task().clone(),
            protocol: case.results.protocol.clone(),
            seed: case.results.seed,
        }
    }

    fn records(&self, name: &str) -> &[FoldRecord] {
        self.networks.iter().find(|(own, _)| own == name).map_or(&[], |(_, records)| records)
    }

    /// A record with what its samples add to the primary metric: once for all resamples of a bootstrap.
    fn told<'r>(&self, record: &'r FoldRecord) -> Told<'r> {
        let metric = Primary::of(&self.task).metric();
        let terms = metric.terms(&self.task, &record.outcome).unwrap_or_default();
        Told { record, terms, scale: metric.unit.scale(), width: self.task.attributes().len() }
    }

    /// Test parts that all of `names` have answered: one record each.
    fn parts(&self, names: &[&str]) -> Vec<Vec<Told<'_>>> {
        let Some((first, rest)) = names.split_first() else { return vec![] };
        let same = |a: &FoldRecord, b: &FoldRecord| {
            (a.key.repetition, a.key.fold) == (b.key.repetition, b.key.fold) && a.index == b.index
        };
        let together = |record| {
            let others = rest.iter().map(|name| self.records(name).iter().find(|r| same(record, r)));
            let all = std::iter::once(Some(record)).chain(others).collect::<Option<Vec<_>>>()?;
            Some(all.into_iter().map(|record| self.told(record)).collect())
        };
        self.records(first).iter().filter_map(together).collect()
    }

    /// The test for these networks: where there is but one test part McNemar's, of values the signed-rank test.
    pub fn test(&self) -> Test {
        let most = self.networks.iter().map(|(_, records)| records.len()).max().unwrap_or(0);
        match self.task {
            _ if most > 1 => Test::NadeauBengio,
            Task::Classes(_) | Task::Levels(_) => Test::McNemar,
            Task::Values(_) => Test::Wilcoxon,
        }
    }

    /// Test samples for each one that training could have had: what Nadeau and Bengio's correction needs.
    ///
    /// A learning curve trains on few of the samples that are not tested; there the ratio is that of the
    /// split, since parts overlap no more for leaving some out.
    fn ratio(&self, parts: &[Vec<Told>]) -> f64 {
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

    /// A statistic over the test parts of `names`: with several parts by the corrected resampled t-test,
    /// with one by the bootstrap over groups or samples. None where no part defines it.
    ///
    /// # Errors
    /// A statistic that is not finite.
    pub fn effect(&self, names: &[&str], statistic: Statistic, confidence: f64) -> Result<Option<Effect>> {
        let parts = self.parts(names);
        let on = |part: &[Told], rows: &[usize]| {
            let answers: Vec<Answers> = part.iter().map(|told| Answers { told, rows }).collect();
            statistic(&answers)
        };
        let whole = |part: &Vec<Told>| on(part, &(0..part[0].record.index.len()).collect::<Vec<_>>());
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

    /// Score of `a` less that of `b`, with a p of [`Comparison::test`]: the primary metric, or the accuracy of one
    /// attribute. With several attributes McNemar's test counts a sample for the network that gets more of them right.
    ///
    /// # Errors
    /// None that records of a run cause.
    pub fn difference(&self, a: &str, b: &str, attribute: Option<usize>) -> Result<Option<Effect>> {
        let statistic = |both: &[Answers]| Some(both[0].accuracy(attribute) - both[1].accuracy(attribute));
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

    /// What is drawn as one, per sample of a part.
    fn clusters_of(&self, part: &[Told]) -> Vec<u32> {
        part[0].record.index.iter().map(|&row| self.clusters[row]).collect()
    }

    /// The signed-rank test on what samples add to the metric; of grouped samples on the means of the groups, since
    /// those of one group are not independent.
    fn signed_rank_of(&self, part: &[Told]) -> Result<f64> {
        let mut groups: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
        let each = part[0].terms.iter().zip(&part[1].terms);
        for (cluster, (a, b)) in self.clusters_of(part).into_iter().zip(each) {
            let (sum, count) = groups.entry(cluster).or_default();
            *sum += a - b;
            *count += 1;
        }
        signed_rank(&groups.into_values().map(|(sum, count)| sum / count as f64).collect::<Vec<_>>())
    }

    /// A value of each test part that two networks share.
    pub fn values(&self, a: &str, b: &str, value: impl Fn(Answers) -> f64) -> (Vec<f64>, Vec<f64>) {
        let of = |told: &Told| {
            let rows: Vec<usize> = (0..told.record.index.len()).collect();
            value(Answers { told, rows: &rows })
        };
        self.parts(&[a, b]).iter().map(|part| (of(&part[0]), of(&part[1]))).unzip()
    }
}

fn mcnemar_of(part: &[Told], attribute: Option<usize>) -> f64 {
    let (mut only_a, mut only_b) = (0, 0);
    for row in 0..part[0].record.index.len() {
        let right = |told| Answers { told, rows: &[row] }.accuracy(attribute);
        let (a, b) = (right(&part[0]), right(&part[1]));
        only_a += u64::from(a > b);
        only_b += u64::from(b > a);
    }
    mcnemar(only_a, only_b)
}
