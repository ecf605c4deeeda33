//! Networks on the same test parts: what differs between them, and how sure that is.

use std::collections::BTreeMap;

use taxel_data::{Dataset, Task};
use taxel_learn::metrics::{MeanEstimate, Terms, t_quantile};
use taxel_learn::{FoldRecord, Protocol};

use super::statistics::{cluster_bootstrap, corrected_t, grouped_pairs, mcnemar, signed_rank};
use crate::case::Case;
use crate::error::Result;
use crate::values::{Primary, Test};

/// Resamples of a bootstrap interval.
const DRAWS: usize = 2000;

/// Test parts over which a t-test says next to nothing: with two its quantile is 12.7.
const FEW_PARTS: usize = 2;

/// Predictions of all networks of a run.
pub struct Comparison {
    /// Finished folds by network.
    pub networks: Vec<(String, Vec<FoldRecord>)>,
    /// Cluster of each sample of the data set, samples of which count together.
    pub clusters: Vec<u32>,
    /// Whether clusters are groups; else they are exact copies of one sample.
    pub is_grouped: bool,
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

    /// Returns the record of the whole fold.
    pub fn record(self) -> &'a FoldRecord {
        self.fold.record
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
    /// Standard error; none where no part of the interval says.
    pub error: Option<f64>,
}

impl Effect {
    /// Makes an effect whose interval is even on the scale of Student's t, with so many degrees of freedom.
    fn of(size: f64, interval: Option<[f64; 2]>, p: Option<f64>, freedom: f64, confidence: f64) -> Self {
        let quantile = t_quantile(freedom, (1.0 + confidence) / 2.0);
        let error = interval.map(|[low, high]| (high - low) / (2.0 * quantile));
        Effect { size, interval, p, error: error.filter(|error| *error > 0.0) }
    }
}

/// A value of the predictions of several networks; none where it is undefined.
pub type Statistic<'s> = &'s dyn Fn(&[Predicted]) -> Option<f64>;

impl Comparison {
    /// Collects the predictions of all networks and baselines of a run.
    pub fn of(case: &Case) -> Self {
        let tested = case.results.networks.iter().filter(|n| !n.folds.is_empty());
        let records = |name: &String| (name.clone(), case.records(name).cloned().collect());
        let networks = tested.map(|network| records(&network.network)).collect();
        let (protocol, seed) = (&case.results.protocol, case.results.seed);
        Comparison::of_records(networks, &case.dataset, protocol, seed)
    }

    /// Collects the predictions in records of folds of `dataset`.
    pub fn of_records(
        networks: Vec<(String, Vec<FoldRecord>)>,
        dataset: &Dataset,
        protocol: &Protocol,
        seed: u64,
    ) -> Self {
        Comparison {
            networks,
            clusters: dataset.clusters(),
            is_grouped: dataset.groups.is_some(),
            task: dataset.task(),
            protocol: protocol.clone(),
            seed,
        }
    }

    /// Returns the comparison over the first repetitions alone.
    pub fn first_repetitions(&self, count: usize) -> Self {
        let first = |records: &[FoldRecord]| {
            records.iter().filter(|record| record.key.repetition < count).cloned().collect()
        };
        Comparison {
            networks: self.networks.iter().map(|(name, records)| (name.clone(), first(records))).collect(),
            clusters: self.clusters.clone(),
            is_grouped: self.is_grouped,
            task: self.task.clone(),
            protocol: self.protocol.clone(),
            seed: self.seed,
        }
    }

    /// Returns the finished folds of a network; none of one that is not there.
    pub fn records(&self, name: &str) -> &[FoldRecord] {
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

    /// Returns the test for these networks: with more than two test parts the corrected resampled t-test, else one over
    /// all samples.
    pub fn test(&self) -> Test {
        let most = self.networks.iter().map(|(_, records)| records.len()).max().unwrap_or(0);
        match self.task {
            _ if self.is_tested_over(most) => self.test_over_parts(),
            Task::Values(_) => Test::Wilcoxon,
            Task::Classes(_) | Task::Levels(_) if self.is_grouped => Test::GroupedPairs,
            Task::Classes(_) | Task::Levels(_) => Test::McNemar,
        }
    }

    /// Checks whether so many test parts are tested as wholes; fresh worlds from two on, since they share nothing.
    fn is_tested_over(&self, parts: usize) -> bool {
        parts > if self.is_fresh() { 1 } else { FEW_PARTS }
    }

    /// Returns the test over whole test parts.
    fn test_over_parts(&self) -> Test {
        if self.is_fresh() { Test::FreshWorlds } else { Test::NadeauBengio }
    }

    fn is_fresh(&self) -> bool {
        self.protocol.worlds().is_some()
    }

    /// Returns the ratio of test samples to possible training samples, for Nadeau and Bengio's correction.
    ///
    /// A learning curve trains on few of the samples that are not tested; there the ratio is that of the
    /// split, since parts overlap no more for leaving some out. Fresh worlds share nothing, so nothing is corrected.
    fn ratio(&self, parts: &[Vec<ScoredFold>]) -> f64 {
        if self.is_fresh() {
            return 0.0;
        }
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
                Ok(Some(Effect::of(*size, interval, None, f64::INFINITY, confidence)))
            }
            ([size], _) => Ok(Some(Effect { size: *size, interval: None, p: None, error: None })),
            _ => {
                let test = corrected_t(&values, self.ratio(&parts), confidence)?;
                let freedom = values.len() as f64 - 1.0;
                Ok(Some(Effect::of(test.mean, test.interval, Some(test.p), freedom, confidence)))
            }
        }
    }

    /// Returns the primary metric of the first of `names` over the test parts that all of them predicted, with its 95 %
    /// interval: that of the samples of a single part, else that of the mean over parts.
    ///
    /// # Errors
    /// None that records of a run cause.
    pub fn score(&self, names: &[&str]) -> Result<Option<Effect>> {
        let parts = self.parts(names);
        let [part] = parts.as_slice() else {
            return self.effect(names, &|predicted: &[Predicted]| Some(predicted[0].score()), 0.95);
        };
        let metric = Primary::of(&self.task).metric();
        let fold = &part[0];
        let groups = self.clusters_of(part);
        let samples = if self.is_grouped { rows_of(fold.record) } else { groups.clone() };
        let found = metric.estimate(&fold.terms, &samples, self.is_grouped.then_some(groups.as_slice()));
        let interval =
            found.and_then(|mean| mean.interval(0.95)).map(|ends| ends.map(|end| fold.scale * end));
        let rows: Vec<usize> = (0..fold.record.index.len()).collect();
        Ok(Some(Effect { size: Predicted { fold, rows: &rows }.score(), interval, p: None, error: None }))
    }

    /// Returns the score of `a` less that of `b`, as [`Comparison::tested`] has it.
    ///
    /// # Errors
    /// None that records of a run cause.
    pub fn difference(&self, a: &str, b: &str, attribute: Option<usize>) -> Result<Option<Effect>> {
        Ok(self.tested(a, b, attribute)?.map(|(effect, _)| effect))
    }

    /// Returns the score of `a` less that of `b` with its p, and the test that gave it: the primary metric, or the accuracy
    /// of one attribute. Over more than two test parts it is the corrected resampled t-test. Over fewer, and where all
    /// parts differ alike, it has no power: then all samples are tested together, each once however often it was
    /// tested. With several attributes McNemar's test counts a sample for the network that gets more of them right.
    ///
    /// # Errors
    /// None that records of a run cause.
    pub fn tested(&self, a: &str, b: &str, attribute: Option<usize>) -> Result<Option<(Effect, Test)>> {
        let parts = self.parts(&[a, b]);
        let statistic = |both: &[Predicted]| Some(both[0].accuracy(attribute) - both[1].accuracy(attribute));
        // A t interval of few folds may go beyond what accuracies can differ by.
        let primary = Primary::of(&self.task);
        let clamped = |effect: Effect| Effect {
            interval: effect.interval.map(|bounds| primary.clamped_difference(bounds)),
            ..effect
        };
        if self.is_tested_over(parts.len()) {
            let effect = self.effect(&[a, b], &statistic, 0.95)?;
            if let Some(effect) = effect.filter(|e| e.interval.is_some_and(|[low, high]| low < high)) {
                return Ok(Some((clamped(effect), self.test_over_parts())));
            }
        }
        if parts.is_empty() {
            return Ok(None);
        }
        let mut pairs = Pairs::default();
        let mut sizes = vec![];
        for part in &parts {
            let rows: Vec<usize> = (0..part[0].record.index.len()).collect();
            let of = |at: usize, rows: &[usize]| Predicted { fold: &part[at], rows }.accuracy(attribute);
            sizes.push(of(0, &rows) - of(1, &rows));
            pairs.differences.extend(rows.iter().map(|&row| of(0, &[row]) - of(1, &[row])));
            pairs.clusters.extend(self.clusters_of(part));
            pairs.rows.extend(rows_of(part[0].record));
        }
        let size = sizes.iter().sum::<f64>() / sizes.len() as f64;
        let (interval, p, test) = match self.task {
            Task::Classes(_) | Task::Levels(_) => self.pairs_of_labels(&pairs)?,
            Task::Values(_) => self.pairs_of_values(&pairs, &format!("{a} {b}"))?,
        };
        // Parts of unequal sizes weigh otherwise in the mean over parts.
        let interval = interval.map(|[low, high]| [low.min(size), high.max(size)]);
        Ok(Some((clamped(Effect { size, interval, p: Some(p), error: None }), test)))
    }

    /// Tests differences in percentage points.
    fn pairs_of_labels(&self, pairs: &Pairs) -> Result<(Option<[f64; 2]>, f64, Test)> {
        let shares: Vec<f64> = pairs.differences.iter().map(|points| points / 100.0).collect();
        let percent = |ends: [f64; 2]| ends.map(|end| 100.0 * end);
        if !self.is_grouped {
            let found = MeanEstimate::of(&shares, &pairs.clusters, None, Terms::Differences);
            let interval = found.and_then(|mean| mean.interval(0.95)).map(percent);
            return Ok((interval, mcnemar_of(pairs.means(&pairs.clusters)), Test::McNemar));
        }
        Ok(match grouped_pairs(&shares, &pairs.rows, &pairs.clusters, 0.95)? {
            Some(found) => (found.interval.map(percent), found.p, Test::GroupedPairs),
            // One group says nothing about others.
            None => (None, mcnemar_of(pairs.means(&pairs.rows)), Test::McNemar),
        })
    }

    /// Tests differences of values; of grouped samples the means of the groups, since those of one group are not
    /// independent.
    fn pairs_of_values(&self, pairs: &Pairs, purpose: &str) -> Result<(Option<[f64; 2]>, f64, Test)> {
        let mean = |at: &[usize]| {
            Some(at.iter().map(|&at| pairs.differences[at]).sum::<f64>() / at.len().max(1) as f64)
        };
        let interval = cluster_bootstrap(&pairs.clusters, mean, 0.95, DRAWS, (self.seed, purpose))?;
        Ok((interval, signed_rank(&pairs.means(&pairs.clusters))?, Test::Wilcoxon))
    }

    /// Returns the cluster of each sample of a part.
    fn clusters_of(&self, part: &[ScoredFold]) -> Vec<u32> {
        part[0].record.index.iter().map(|&row| self.clusters[row]).collect()
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

/// Differences of two networks, test after test.
#[derive(Default)]
struct Pairs {
    differences: Vec<f64>,
    clusters: Vec<u32>,
    /// The sample of each in the data set.
    rows: Vec<u32>,
}

impl Pairs {
    /// Returns the mean difference of all tests that bear the same name.
    fn means(&self, names: &[u32]) -> Vec<f64> {
        let mut each: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
        for (name, difference) in names.iter().zip(&self.differences) {
            let (sum, count) = each.entry(*name).or_default();
            *sum += difference;
            *count += 1;
        }
        each.into_values().map(|(sum, count)| sum / count as f64).collect()
    }
}

fn rows_of(record: &FoldRecord) -> Vec<u32> {
    record.index.iter().map(|&row| row as u32).collect()
}

fn mcnemar_of(differences: Vec<f64>) -> f64 {
    let count = |is: fn(f64) -> bool| differences.iter().filter(|d| is(**d)).count() as u64;
    mcnemar(count(|d| d > 0.0), count(|d| d < 0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::synthetic::{Player, Setting, player, random_splits, synthetic};
    use taxel_data::Quantity;
    use taxel_learn::metrics::Outcome;

    const LARGE: &[usize] = &[5, 6, 5, 4, 5];
    const SMALL: &[usize] = &[6, 6, 5, 5, 5];

    #[test]
    fn an_effect_has_the_standard_error_of_its_interval() {
        let players = vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
        let (comparison, _) = synthetic(&Setting::default(), players);
        let effect = comparison.difference("small", "large", None).unwrap().unwrap();
        // Differences -1, 0, 0, -1, 0 have the variance 0.3; a fold tests 100 samples for 400 in training.
        let error = ((0.2f64 + 0.25) * 0.3).sqrt();
        assert!((effect.error.unwrap() - error).abs() < 1e-9, "{effect:?}");
        // scipy.stats.t.ppf(0.975, 4)
        let [low, high] = effect.interval.unwrap();
        assert!((high - low - 2.0 * 2.7764451052 * error).abs() < 1e-6, "{effect:?}");
    }

    #[test]
    fn an_attribute_is_compared_by_its_own_labels() {
        let attributes = vec![("elasticity", vec!["0", "1"]), ("hardness", vec!["0", "1"])];
        let setting = Setting { protocol: random_splits(), parts: 1, attributes, ..Setting::default() };
        let with = |name, wrong: [usize; 2]| {
            let says = move |_: usize, row: usize, truth: &[u32]| -> Vec<u32> {
                truth.iter().zip(wrong).map(|(label, wrong)| (label + u32::from(row < wrong)) % 2).collect()
            };
            Player { says: Box::new(says), ..player(name, 1.0, &[]) }
        };
        let (comparison, _) = synthetic(&setting, vec![with("a", [0, 0]), with("b", [10, 30])]);
        let of = |attribute| comparison.difference("b", "a", attribute).unwrap().unwrap().size;
        assert_eq!([of(None), of(Some(0)), of(Some(1))], [-20.0, -10.0, -30.0]);
    }

    #[test]
    fn first_repetitions_are_those_below_the_count() {
        let setting = Setting { protocol: random_splits(), ..Setting::default() };
        let (comparison, _) = synthetic(&setting, vec![player("large", 10.0, LARGE)]);
        let kept = |count| {
            let first = comparison.first_repetitions(count);
            first.records("large").iter().map(|record| record.key.repetition).collect::<Vec<_>>()
        };
        assert_eq!((kept(2), kept(0), kept(9).len()), (vec![0, 1], vec![], 5));
    }

    #[test]
    fn no_interval_is_wider_than_accuracies_can_differ() {
        let setting = Setting { parts: 3, ..Setting::default() };
        let players = vec![player("large", 10.0, &[0; 3]), player("poor", 1.0, &[100, 60, 95])];
        let (comparison, _) = synthetic(&setting, players);
        let effect = comparison.difference("poor", "large", None).unwrap().unwrap();
        assert!((effect.size + 85.0).abs() < 1e-9 && effect.interval.unwrap()[0] == -100.0, "{effect:?}");
    }

    #[test]
    fn the_interval_of_unequal_parts_holds_their_mean() {
        let players = vec![player("large", 10.0, &[0, 0]), player("small", 1.0, &[5, 0])];
        let (mut comparison, _) = synthetic(&Setting { parts: 2, ..Setting::default() }, players);
        for (_, records) in &mut comparison.networks {
            records[0].index.truncate(10);
            let Outcome::Labels { truth, predicted, probabilities, .. } = &mut records[0].outcome else {
                continue;
            };
            truth.truncate(10);
            predicted.truncate(10);
            probabilities.truncate(20);
        }
        // Half of ten samples and none of 100: 25 points over parts, 4.5 over samples.
        let effect = comparison.difference("small", "large", None).unwrap().unwrap();
        let [low, high] = effect.interval.unwrap();
        assert!(effect.size == -25.0 && low == -25.0 && high > -4.5, "{effect:?}");
    }

    /// Makes one test part of 60 samples, the first `wrong` of which only `a` gets right, and names the cluster of each.
    fn one_part(wrong: &'static [usize], cluster: usize) -> Comparison {
        let setting =
            Setting { protocol: random_splits(), parts: 1, tested: 60, cluster, ..Setting::default() };
        synthetic(&setting, vec![player("a", 1.0, &[0]), player("b", 1.0, wrong)]).0
    }

    #[test]
    fn copies_of_a_sample_are_one_sample() {
        let mut comparison = one_part(&[6], 2);
        comparison.is_grouped = false;
        let (effect, test) = comparison.tested("b", "a", None).unwrap().unwrap();
        // Three of three one way: 2 / 8.
        assert!(test == Test::McNemar && (effect.p.unwrap() - 0.25).abs() < 1e-12, "{effect:?}");
    }

    #[test]
    fn a_score_over_groups_has_the_interval_of_its_samples_in_groups() {
        let comparison = one_part(&[15], 10);
        let interval = comparison.score(&["b"]).unwrap().unwrap().interval.unwrap();
        let right: Vec<f64> = (0..60).map(|row| f64::from(u8::from(row >= 15))).collect();
        let (samples, groups): (Vec<u32>, Vec<u32>) = (0..60).map(|row| (row, row / 10)).unzip();
        let mean = MeanEstimate::of(&right, &samples, Some(&groups), Terms::Shares).unwrap();
        assert_eq!(interval, mean.interval(0.95).unwrap().map(|end| 100.0 * end));
    }

    #[test]
    fn values_of_one_group_count_as_one() {
        let mut comparison = one_part(&[0], 10);
        comparison.task = Task::Values(vec![Quantity { name: "force".into(), unit: None }]);
        for (at, (_, records)) in comparison.networks.iter_mut().enumerate() {
            let predicted = (0..60).map(|row| at as f32 * (1.0 + row as f32 / 60.0)).collect();
            records[0].outcome = Outcome::Values { truth: vec![0.0; 60], predicted, spread: vec![] };
        }
        let (effect, test) = comparison.tested("b", "a", None).unwrap().unwrap();
        // Six of six groups one way: 2 / 64.
        assert_eq!((test, effect.p), (Test::Wilcoxon, Some(0.03125)));
    }
}
