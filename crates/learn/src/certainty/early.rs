//! How often a model is right that decides before a sample is whole.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::certainty::answers::answers;
use crate::certainty::held_out::HeldOut;
use crate::certainty::temperature::{fitted_temperature, tempered};
use crate::metrics::{Levels, wilson};

/// Confidences that are tried.
const CONFIDENCES: [f64; 7] = [0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99];
/// Probabilities that are tried for a confidence, as shares of the way from it to 1.
const STEPS: [f64; 10] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 0.95, 0.99];
/// One-sided 95 % quantile of the normal distribution.
const Z: f64 = 1.645;

/// The probability of [`EarlyRecord::least`] where none is known: no answer is so sure.
const NEVER: f64 = 2.0;

/// Early decisions of held-out samples at one confidence.
///
/// Beginnings get ten chances to be sure, and the wrong ones are sure by chance more often than whole samples are. So an answer may
/// have to be surer than `confidence` to be right as often as that says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarlyRecord {
    /// The share of early decisions that is to be right, 0..1.
    pub confidence: f64,
    /// The probability that the likeliest class of every attribute must reach for that, `confidence` or above; above 1 where
    /// none was right so often. 0 in cards of before, which decided at `confidence`.
    #[serde(default)]
    pub least: f64,
    /// Samples that were decided before they were whole: each part at the probability of the other parts, and at `confidence`
    /// where none was right so often.
    pub decided: usize,
    /// Of all samples.
    pub of: usize,
    /// Share of the samples decided early that were right in every attribute, 0..1; 0 without any.
    pub right: f64,
    /// Mean share of a sample, of all, that had been seen when it was decided, 0..1.
    pub seen: f64,
    /// The share of the commonest answer, 0..1: what is right by chance.
    pub chance: f64,
}

/// How sure the answers to the beginnings of one sample are, and whether they are right: one for each tenth, none where there is
/// no answer.
struct Beginnings {
    part: u32,
    answers: Vec<Option<(f64, bool)>>,
}

/// Counts of samples that were decided early.
#[derive(Clone, Copy, Default)]
struct Decided {
    count: usize,
    right: usize,
    /// Sum of the shares that had been seen, of all samples.
    seen: f64,
}

impl Decided {
    /// Decides each sample at its first beginning that reaches its probability.
    fn of<'b>(samples: impl IntoIterator<Item = &'b Beginnings>, least: impl Fn(&Beginnings) -> f64) -> Self {
        let mut all = Decided::default();
        for sample in samples {
            let (tenths, least) = (sample.answers.len(), least(sample));
            let mut early = sample.answers[..tenths - 1].iter().enumerate();
            let first =
                early.find_map(|(at, answer)| answer.filter(|(sure, _)| *sure >= least).map(|it| (at, it.1)));
            all.count += usize::from(first.is_some());
            all.right += usize::from(first.is_some_and(|(_, is_right)| is_right));
            all.seen += first.map_or(1.0, |(at, _)| (at + 1) as f64 / tenths as f64);
        }
        all
    }

    /// Finds the least probability at which as many early decisions are right as `confidence` says. That itself where nothing
    /// is decided at it.
    fn least<'b>(samples: impl Iterator<Item = &'b Beginnings> + Clone, confidence: f64) -> f64 {
        let decided = |least: f64| Decided::of(samples.clone(), |_| least);
        if decided(confidence).count == 0 {
            return confidence;
        }
        let mut steps = STEPS.iter().map(|step| confidence + (1.0 - confidence) * step);
        let is_right = |least: &f64| {
            let Decided { count, right, .. } = decided(*least);
            count > 0 && right as f64 >= confidence * count as f64
        };
        steps.find(is_right).unwrap_or(NEVER)
    }
}

impl EarlyRecord {
    /// Decides the samples of `starts` (the first tenth of each, the first two, ..., the whole) at each confidence, each part with
    /// the temperatures and the probabilities of the others.
    pub(super) fn all(starts: &[HeldOut], levels: &Levels) -> Vec<Self> {
        let Some(whole) = starts.last().filter(|whole| !whole.is_empty()) else { return vec![] };
        let sure: Vec<BTreeMap<(u32, usize), (f64, bool)>> =
            starts.iter().map(|start| by_place(start, levels)).collect();
        let beginnings = |place: &(u32, usize)| Beginnings {
            part: place.0,
            answers: sure.iter().map(|tenth| tenth.get(place).copied()).collect(),
        };
        let samples: Vec<Beginnings> = sure[starts.len() - 1].keys().map(beginnings).collect();
        let mut counts: BTreeMap<&[u32], usize> = BTreeMap::new();
        whole
            .truth
            .chunks_exact(levels.sizes().len())
            .for_each(|labels| *counts.entry(labels).or_default() += 1);
        let commonest = counts.values().max().copied().unwrap_or(0);
        let record = |&confidence: &f64| {
            let least = Decided::least(samples.iter(), confidence);
            let of_others = |part: &u32| {
                let others = samples.iter().filter(|sample| sample.part != *part);
                (*part, Decided::least(others, confidence))
            };
            let parts: BTreeMap<u32, f64> = whole.each_part().iter().map(of_others).collect();
            let decided =
                Decided::of(&samples, |sample| if least > 1.0 { confidence } else { parts[&sample.part] });
            EarlyRecord {
                confidence,
                least,
                decided: decided.count,
                of: whole.len(),
                right: decided.right as f64 / decided.count.max(1) as f64,
                seen: decided.seen / whole.len() as f64,
                chance: commonest as f64 / whole.len() as f64,
            }
        };
        CONFIDENCES.iter().map(record).collect()
    }

    /// Checks whether decisions at this confidence are no better than chance, as far as held-out samples can tell: the lower
    /// end of a one-sided 95 % interval (Wilson 1927) is not above the share of the commonest answer. False without a decision.
    pub fn is_chance(&self) -> bool {
        self.decided > 0 && wilson(self.right, self.decided as f64, Z)[0] <= self.chance
    }

    /// Checks whether held-out samples that were decided early were right less often than the confidence says, however sure
    /// their answers.
    pub fn is_unreached(&self) -> bool {
        self.least > 1.0
    }
}

/// Returns how sure the answer to each sample is, the least of all attributes, and whether all are right: by part and position in
/// the data set.
fn by_place(start: &HeldOut, levels: &Levels) -> BTreeMap<(u32, usize), (f64, bool)> {
    let mut all = BTreeMap::new();
    for part in start.each_part() {
        let others = start.select(|row| start.parts[row] != part);
        let own = start.select(|row| start.parts[row] == part);
        let temperature = fitted_temperature(&others.probabilities, &others.truth, levels.sizes());
        let mut probabilities = own.probabilities;
        tempered(&mut probabilities, levels.sizes(), temperature.unwrap_or(1.0));
        for (place, answers) in own.rows.iter().zip(answers(&probabilities, &own.truth, levels)) {
            let least = answers.iter().map(|(sure, _)| *sure).fold(1.0, f64::min);
            all.insert((part, *place), (least, answers.iter().all(|(_, right)| *right)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers to 200 samples of two classes: of `tenth` tenths all are `sure` and right in `right` of 100.
    fn start(right: usize, sure: f32) -> HeldOut {
        let truth: Vec<u32> = (0..200).map(|sample| sample % 2).collect();
        let answer = |(sample, label): (usize, &u32)| {
            let is_right = sample / 2 % 100 < right;
            let class = if is_right { *label } else { 1 - *label };
            if class == 0 { [sure, 1.0 - sure] } else { [1.0 - sure, sure] }
        };
        let probabilities = truth.iter().enumerate().flat_map(answer).collect();
        HeldOut { probabilities, truth, parts: vec![0; 200], rows: (0..200).collect(), ..HeldOut::default() }
    }

    #[test]
    fn beginnings_that_know_nothing_are_chance_and_do_not_decide() {
        let starts: Vec<HeldOut> =
            (1..=10).map(|tenth| start(if tenth < 6 { 50 } else { 97 }, 0.92)).collect();
        let records = EarlyRecord::all(&starts, &Levels::new(&[2]));
        assert_eq!(records.len(), CONFIDENCES.len());
        // One part alone has no temperature of others: as sure as it says.
        let at_90 = records[4];
        assert_eq!((at_90.decided, at_90.chance), (200, 0.5));
        assert!((at_90.seen - 0.1).abs() < 1e-9, "{at_90:?}");
        assert!(
            at_90.is_chance() && at_90.is_unreached() && !records[5].is_chance(),
            "0.95 is never reached: {records:?}"
        );
        let parts =
            |held: &HeldOut| HeldOut { parts: (0..200).map(|row| row / 2 % 2).collect(), ..held.clone() };
        let apart = EarlyRecord::all(&starts.iter().map(parts).collect::<Vec<_>>(), &Levels::new(&[2]));
        assert!(
            apart[4].decided == 200 && (apart[4].seen - 0.6).abs() < 1e-9,
            "calibrated beginnings wait: {apart:?}"
        );
        assert!(!apart[4].is_chance() && apart[4].right > 0.95);
    }

    #[test]
    fn an_answer_must_be_surer_where_beginnings_are_too_sure() {
        // Of two parts of 100 samples each half is answered at 0.92 and right in 70 %, half at 0.985 and right in 96 %.
        let sample = |row: u32| {
            let (is_sure, number) = (row % 2 == 1, row / 2 % 50);
            let answer = if is_sure { (0.985, number < 48) } else { (0.92, number < 35) };
            Beginnings { part: row / 100, answers: [vec![Some(answer); 9], vec![Some((1.0, true))]].concat() }
        };
        let samples: Vec<Beginnings> = (0..200).map(sample).collect();
        let at = |least: f64| {
            let Decided { count, right, .. } = Decided::of(&samples, |_| least);
            (count, right)
        };
        assert_eq!((at(0.9), at(0.95)), ((200, 166), (100, 96)));
        let least = Decided::least(samples.iter(), 0.9);
        assert!(least > 0.92 && least <= 0.985, "{least}");
        assert_eq!(Decided::least(samples.iter(), 0.8), 0.8, "83 % are right already");
        assert_eq!(Decided::least(samples.iter(), 0.99), 0.99, "nothing is so sure");
        // Sure and wrong however sure: never.
        let wrong = |sample: &Beginnings| {
            let answers = sample.answers.iter().map(|answer| answer.map(|(sure, _)| (sure, false))).collect();
            Beginnings { answers, ..*sample }
        };
        let wrong: Vec<Beginnings> = samples.iter().map(wrong).collect();
        assert_eq!(Decided::least(wrong.iter(), 0.9), NEVER);
    }
}
