//! Networks on the same test parts: what differs between them, and how sure that is.

use taxel_learn::{FoldRecord, Protocol};

use super::statistics::{cluster_bootstrap, corrected_t, mcnemar};
use crate::case::Case;
use crate::error::Result;
use crate::values::Test;

/// Resamples of a bootstrap interval.
const DRAWS: usize = 2000;

/// What all networks answered in a run.
pub struct Comparison {
    /// Finished folds by network.
    pub networks: Vec<(String, Vec<FoldRecord>)>,
    /// What is drawn as one by the bootstrap, per sample of the data set.
    pub clusters: Vec<u32>,
    /// Attributes.
    pub width: usize,
    /// How the run was divided.
    pub protocol: Protocol,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// Answers of one network to some samples of a test part.
#[derive(Clone, Copy)]
pub struct Answers<'a> {
    record: &'a FoldRecord,
    rows: &'a [usize],
    width: usize,
}

impl<'a> Answers<'a> {
    /// True and predicted labels of each sample, one per attribute.
    pub fn each(self) -> impl Iterator<Item = (&'a [u32], &'a [u32])> {
        let Answers { record, rows, width } = self;
        rows.iter().map(move |&row| {
            let own = row * width..(row + 1) * width;
            (&record.outcome.labels().0[own.clone()], &record.outcome.labels().1[own])
        })
    }

    /// Share of right labels in %, over all attributes or one.
    pub fn accuracy(self, attribute: Option<usize>) -> f64 {
        let (mut right, mut all) = (0, 0);
        for (truth, predicted) in self.each() {
            let mut labels = truth.iter().zip(predicted).enumerate();
            let own = labels.by_ref().filter(|(at, _)| attribute.is_none_or(|wanted| wanted == *at));
            for (_, (truth, predicted)) in own {
                right += usize::from(truth == predicted);
                all += 1;
            }
        }
        100.0 * right as f64 / all.max(1) as f64
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
            width: case.levels().sizes().len(),
            protocol: case.results.protocol.clone(),
            seed: case.results.seed,
        }
    }

    fn records(&self, name: &str) -> &[FoldRecord] {
        self.networks.iter().find(|(own, _)| own == name).map_or(&[], |(_, records)| records)
    }

    /// Test parts that all of `names` have answered: one record each.
    fn parts(&self, names: &[&str]) -> Vec<Vec<&FoldRecord>> {
        let Some((first, rest)) = names.split_first() else { return vec![] };
        let same = |a: &FoldRecord, b: &FoldRecord| {
            (a.key.repetition, a.key.fold) == (b.key.repetition, b.key.fold) && a.index == b.index
        };
        let together = |record| {
            let others = rest.iter().map(|name| self.records(name).iter().find(|r| same(record, r)));
            std::iter::once(Some(record)).chain(others).collect::<Option<Vec<_>>>()
        };
        self.records(first).iter().filter_map(together).collect()
    }

    /// The test for accuracies of these networks: McNemar's where there is but one test part.
    pub fn test(&self) -> Test {
        let most = self.networks.iter().map(|(_, records)| records.len()).max().unwrap_or(0);
        if most > 1 { Test::NadeauBengio } else { Test::McNemar }
    }

    /// Test samples for each one that training could have had: what Nadeau and Bengio's correction needs.
    ///
    /// A learning curve trains on few of the samples that are not tested; there the ratio is that of the
    /// split, since parts overlap no more for leaving some out.
    fn ratio(&self, parts: &[Vec<&FoldRecord>]) -> f64 {
        let of = |record: &FoldRecord| {
            let tested = record.index.len();
            let trained = match self.protocol {
                Protocol::FewSamples { .. } => self.clusters.len().saturating_sub(tested),
                _ => record.train_samples,
            };
            tested as f64 / trained.max(1) as f64
        };
        parts.iter().map(|part| of(part[0])).sum::<f64>() / parts.len().max(1) as f64
    }

    /// A statistic over the test parts of `names`: with several parts by the corrected resampled t-test,
    /// with one by the bootstrap over groups or samples. None where no part defines it.
    ///
    /// # Errors
    /// A statistic that is not finite.
    pub fn effect(&self, names: &[&str], statistic: Statistic, confidence: f64) -> Result<Option<Effect>> {
        let parts = self.parts(names);
        let on = |part: &[&FoldRecord], rows: &[usize]| {
            let width = self.width;
            let answers: Vec<Answers> = part.iter().map(|record| Answers { record, rows, width }).collect();
            statistic(&answers)
        };
        let whole = |part: &Vec<&FoldRecord>| on(part, &(0..part[0].index.len()).collect::<Vec<_>>());
        let values: Vec<f64> = parts.iter().filter_map(whole).collect();
        match (values.as_slice(), parts.as_slice()) {
            ([], _) => Ok(None),
            ([size], [part]) => {
                let clusters: Vec<u32> = part[0].index.iter().map(|&row| self.clusters[row]).collect();
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

    /// Accuracy of `a` less that of `b` in percentage points, with a p of [`Comparison::test`]; over one
    /// attribute, or as the mean over all. With several attributes McNemar's test counts a sample for the
    /// network that gets more of them right.
    ///
    /// # Errors
    /// None that records of a run cause.
    pub fn difference(&self, a: &str, b: &str, attribute: Option<usize>) -> Result<Option<Effect>> {
        let statistic = |both: &[Answers]| Some(both[0].accuracy(attribute) - both[1].accuracy(attribute));
        let Some(mut effect) = self.effect(&[a, b], &statistic, 0.95)? else { return Ok(None) };
        // A t interval of two folds may go beyond what accuracies can differ by.
        effect.interval = effect.interval.map(|bounds| bounds.map(|bound| bound.clamp(-100.0, 100.0)));
        if let [part] = self.parts(&[a, b]).as_slice() {
            effect.p = Some(self.mcnemar(part, attribute));
        }
        Ok(Some(effect))
    }

    fn mcnemar(&self, part: &[&FoldRecord], attribute: Option<usize>) -> f64 {
        let (mut only_a, mut only_b) = (0, 0);
        for row in 0..part[0].index.len() {
            let right = |record| Answers { record, rows: &[row], width: self.width }.accuracy(attribute);
            let (a, b) = (right(part[0]), right(part[1]));
            only_a += u64::from(a > b);
            only_b += u64::from(b > a);
        }
        mcnemar(only_a, only_b)
    }

    /// A value of each test part that two networks share.
    pub fn values(&self, a: &str, b: &str, value: impl Fn(Answers) -> f64) -> (Vec<f64>, Vec<f64>) {
        let width = self.width;
        let of = |record: &FoldRecord| {
            let rows: Vec<usize> = (0..record.index.len()).collect();
            value(Answers { record, rows: &rows, width })
        };
        self.parts(&[a, b]).iter().map(|part| (of(part[0]), of(part[1]))).unzip()
    }
}
