//! The certainty of a model, fitted to held-out predictions, for its card.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter};

use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::certainty::answers::answers;
use crate::certainty::early::EarlyRecord;
use crate::certainty::held_out::{HeldOut, LEAST, large_groups};
use crate::certainty::readings::Readings;
use crate::certainty::reliability::Reliability;
use crate::certainty::seen::{Seen, tenth_of};
use crate::certainty::sets::AnswerSet;
use crate::certainty::temperature::{fitted_temperature, matched_temperature, tempered};
use crate::error::Result;
use crate::metrics::{BINS, Levels};
use crate::run::protocol::Protocol;

/// Draws of a model whose probabilities are right.
const DRAWS: usize = 200;

/// How the probabilities of a model are brought to what they say, and how well that works.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certainty {
    /// Divides the logits before the softmax; above 1 the model was too sure.
    pub temperature: f64,
    /// The same for samples of which the first tenth is there, the first two, ...: ten, the last of the whole. Beginnings are
    /// answered too surely, so that one temperature does not fit them. Empty where that was not measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tenths: Vec<f64>,
    /// Held-out samples that were decided early, at each confidence. Empty where that was not measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub early: Vec<EarlyRecord>,
    /// The predictions that it was fitted on.
    pub fitted_on: FittedOn,
    /// Expected calibration errors, 0..1.
    pub calibration_error: CalibrationErrors,
    /// Mean probability of the answers at the temperature of the other parts, 0..1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// The largest distance in a group of five samples or more between the mean probability of its answers and the share that
    /// is right, 0..1; none without groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_group_gap: Option<f64>,
    /// Sets of classes at 80, 90, 95 and 99 %.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<AnswerSet>,
    /// How sure answers are right where samples are broken; none where that was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub under_faults: Option<SureAnswers>,
    /// Whether a sample is like those that were learned; none where the logits were not known, and of methods without logits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<Seen>,
    /// Whether the readings of a sample are like those that were learned; none where they were too few, or all equal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readings: Option<Readings>,
}

/// The predictions that a certainty was fitted on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedOn {
    /// Number of predictions; a sample that was tested in two repetitions counts twice.
    pub samples: usize,
    /// Number of groups; none without groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub groups: Option<usize>,
    /// How the samples were held out.
    pub parts: HeldOutParts,
    /// BLAKE3 of their data set.
    pub digest: String,
}

impl FittedOn {
    /// Counts predictions of these `groups`, of the data set of that digest.
    pub(super) fn of(samples: usize, groups: Option<&[u32]>, parts: HeldOutParts, digest: &str) -> Self {
        let groups = groups.map(|groups| groups.iter().collect::<BTreeSet<_>>().len());
        FittedOn { samples, groups, parts, digest: digest.into() }
    }
}

/// Answers of held-out samples that are 90 % sure or more, at the temperature of the other parts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SureAnswers {
    /// Their share of all answers, 0..1.
    pub share: f64,
    /// The share of them that is right, 0..1; 0 where there are none.
    pub right: f64,
}

/// How samples were held out from the trainings that answered them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeldOutParts {
    /// By the parts of a run, in which groups stay together.
    Groups,
    /// By the parts of a run, in which samples of one group may be on both sides. New groups may be answered too surely.
    Mixed,
    /// Recordings of their own.
    Recordings,
}

impl HeldOutParts {
    /// Says how the folds of a protocol hold samples out.
    pub fn of(protocol: &Protocol) -> Self {
        if protocol.keeps_groups() { HeldOutParts::Groups } else { HeldOutParts::Mixed }
    }
}

/// Expected calibration errors (Guo et al. 2017), 0..1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationErrors {
    /// As the model answers by itself.
    pub before: f64,
    /// With the temperature of the other parts, each part in turn.
    pub after: f64,
    /// The mean error of a model whose probabilities are right, with as many samples of as much confidence: a few samples in a
    /// bin are never right as often as they should be.
    pub floor: f64,
}

impl Certainty {
    /// Fits a temperature to held-out predictions of attributes of these `levels`; it is 1 where none lowers the calibration error.
    /// `seed` chooses the draws of the floor. None of fewer than 30 samples.
    ///
    /// # Errors
    /// Labels that do not fit the probabilities.
    pub fn fit(
        held: &HeldOut,
        levels: &Levels,
        parts: HeldOutParts,
        digest: &str,
        seed: u64,
    ) -> Result<Option<Self>> {
        let fitted = Self::fit_with_reliability(held, levels, parts, digest, seed)?;
        Ok(fitted.map(|(certainty, _)| certainty))
    }

    /// Fits as [`Certainty::fit`], and sorts the same answers by how sure they are.
    ///
    /// # Errors
    /// As [`Certainty::fit`].
    pub fn fit_with_reliability(
        held: &HeldOut,
        levels: &Levels,
        parts: HeldOutParts,
        digest: &str,
        seed: u64,
    ) -> Result<Option<(Self, Reliability)>> {
        let held = &held.divided();
        let fitted = fitted_temperature(&held.probabilities, &held.truth, levels.sizes());
        let Some(temperature) = fitted.filter(|_| held.len() >= LEAST) else { return Ok(None) };
        let error =
            |held: &HeldOut| levels.calibration(&held.probabilities, &held.truth).map(|(error, _)| error);
        let (before, at_others) = (error(held)?, at_other_temperatures(held, levels, temperature));
        // A temperature that makes the probabilities worse is none: the likelihood that it is fitted to is another measure.
        let is_better = error(&at_others)? < before;
        let (temperature, after) = if is_better { (temperature, at_others) } else { (1.0, held.clone()) };
        let answers = answers(&after.probabilities, &after.truth, levels);
        let groups = large_groups(held.groups.as_deref());
        let gap = |members: &Vec<usize>| {
            let all = members.iter().flat_map(|row| &answers[*row]);
            let gaps = all.map(|(sure, right)| sure - f64::from(u8::from(*right)));
            (gaps.sum::<f64>() / (members.len() * levels.sizes().len()) as f64).abs()
        };
        let certainty = Certainty {
            temperature,
            tenths: vec![],
            early: vec![],
            fitted_on: FittedOn::of(held.len(), held.groups.as_deref(), parts, digest),
            calibration_error: CalibrationErrors {
                before,
                after: error(&after)?,
                floor: floor(&answers, seed),
            },
            confidence: Some(mean_confidence(&answers)),
            worst_group_gap: groups.iter().map(gap).max_by(f64::total_cmp),
            sets: AnswerSet::fit(&after, levels),
            under_faults: None,
            seen: None,
            readings: None,
        };
        Ok(Some((certainty, Reliability::of(&answers))))
    }
}

impl Certainty {
    /// Fits the gate to logits of held-out samples, and to those of their beginnings: the first tenth, the first two, ..., the
    /// whole. Fits a temperature to each of these. What has too few samples is left out.
    pub fn with_logits(self, held: &HeldOut, starts: &[HeldOut], levels: &Levels) -> Self {
        let (held, starts) = (&held.divided(), &starts.iter().map(HeldOut::divided).collect::<Vec<_>>());
        let fit = |start: &HeldOut| {
            let fitted = fitted_temperature(&start.probabilities, &start.truth, levels.sizes());
            fitted.filter(|_| start.len() >= LEAST)
        };
        let tenths = starts.iter().map(fit).collect::<Option<Vec<f64>>>();
        let seen = Seen::fit(held, levels).map(|seen| seen.with_tenths(held, starts, levels));
        let early = tenths.as_ref().map_or(vec![], |_| EarlyRecord::all(starts, levels));
        Certainty { seen, early, tenths: tenths.unwrap_or_default(), ..self }
    }

    /// Brings the same model in other numbers to as much certainty: `probabilities` are what it answers by itself, and `wanted`
    /// what this model says of the same samples.
    pub fn matched(self, probabilities: &[f32], wanted: &[f32], sizes: &[usize]) -> Self {
        let temperature = matched_temperature(probabilities, wanted, sizes).unwrap_or(self.temperature);
        let tenths = self.tenths.iter().map(|tenth| tenth * temperature / self.temperature).collect();
        Certainty { temperature, tenths, ..self }
    }

    /// Returns the temperature for a sample of which the share `seen`, above 0 and at most 1, is there; none where that was not
    /// measured.
    pub fn at(&self, seen: f64) -> Option<f64> {
        if seen >= 1.0 { Some(self.temperature) } else { tenth_of(&self.tenths, seen).copied() }
    }

    /// Returns the early decisions at the highest confidence that was tried and is not above this one.
    pub fn early_at(&self, confidence: f64) -> Option<&EarlyRecord> {
        self.early.iter().rev().find(|record| record.confidence <= confidence + 1e-6)
    }

    /// Returns the sets at a share of 0.8, 0.9, 0.95 or 0.99.
    pub fn sets_at(&self, share: f64) -> Option<&AnswerSet> {
        self.sets.iter().find(|set| (set.share - share).abs() < 1e-9)
    }
}

fn mean_confidence(answers: &[Vec<(f64, bool)>]) -> f64 {
    let all = answers.iter().flatten();
    all.clone().map(|(sure, _)| sure).sum::<f64>() / all.count().max(1) as f64
}

/// Returns the predictions of each part at the temperature that the other parts fit, or at that `of_all` where these are few.
fn at_other_temperatures(held: &HeldOut, levels: &Levels, of_all: f64) -> HeldOut {
    let mut after = held.clone();
    for part in held.each_part() {
        let others = held.select(|row| held.parts[row] != part);
        let fitted = fitted_temperature(&others.probabilities, &others.truth, levels.sizes());
        let of_others = fitted.filter(|_| others.len() >= LEAST).unwrap_or(of_all);
        for (row, values) in after.probabilities.chunks_exact_mut(levels.outputs().max(1)).enumerate() {
            if held.parts[row] == part {
                tempered(values, levels.sizes(), of_others);
            }
        }
    }
    after
}

/// Returns the mean calibration error where each answer is right as often as its probability says.
fn floor(answers: &[Vec<(f64, bool)>], seed: u64) -> f64 {
    let width = answers.first().map_or(1, Vec::len);
    let mut rng = taxel_base::seed::rng(seed, "calibration-floor");
    let mut sum = 0.0;
    for _ in 0..DRAWS {
        for attribute in 0..width {
            let mut bins = [0.0f64; BINS];
            for answer in answers {
                let (sure, _) = answer[attribute];
                let right = f64::from(u8::from(rng.random::<f64>() < sure));
                bins[((sure * BINS as f64).ceil() as usize).clamp(1, BINS) - 1] += sure - right;
            }
            sum += bins.iter().map(|gap| gap.abs()).sum::<f64>() / answers.len().max(1) as f64;
        }
    }
    sum / (DRAWS * width) as f64
}

impl Display for Certainty {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Certainty { temperature, fitted_on, calibration_error, worst_group_gap, .. } = self;
        let CalibrationErrors { before, after, floor } = calibration_error;
        let FittedOn { samples, groups, parts, .. } = fitted_on;
        write!(f, "temperature {temperature:.3}, fitted on {samples} held-out predictions")?;
        match (groups, parts) {
            (Some(groups), HeldOutParts::Groups) => write!(f, " of {groups} unseen groups")?,
            (Some(groups), HeldOutParts::Mixed) => {
                write!(f, " of {groups} groups that training had seen: new ones may be answered too surely")?;
            }
            (Some(groups), HeldOutParts::Recordings) => write!(f, " of {groups} groups")?,
            (None, _) => {}
        }
        let [before, after, floor] = [before, after, floor].map(|error| 100.0 * error);
        write!(f, "; calibration error {before:.1} -> {after:.1} (0 to expect: {floor:.1})")?;
        if let Some(gap) = worst_group_gap {
            write!(f, ", {:.1} in the worst group", 100.0 * gap)?;
        }
        if let Some(set) = self.sets_at(0.9) {
            let (covered, size) = (100.0 * set.covered, set.size);
            write!(f, "; 90 % sets covered {covered:.1} %")?;
            set.worst_group.map_or(Ok(()), |worst| write!(f, ", {:.1} in the worst group", 100.0 * worst))?;
            write!(f, ", {size:.2} classes")?;
            self.fitted_on.unpromised(set.share).map_or(Ok(()), |words| write!(f, "; {words}"))?;
        }
        let gate = if self.has_gate() { "says unknown" } else { "does not say unknown" };
        write!(f, "; {gate}")?;
        match self.under_faults {
            Some(SureAnswers { share, right }) if share > 0.0 => write!(
                f,
                "; under faults {:.0} % of the answers are 90 % sure, and {:.0} % of those are right",
                100.0 * share,
                100.0 * right
            ),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Draws predictions that are right as often as they say, and makes them `sharper` times as sure.
    fn drawn(samples: usize, sharper: f64, groups: Option<u32>) -> HeldOut {
        let mut rng = taxel_base::seed::rng(3, "held-out");
        let mut held = HeldOut { groups: groups.map(|_| vec![]), ..HeldOut::default() };
        for sample in 0..samples {
            let mut row = [(); 4].map(|()| (3.0 * rng.random::<f64>()).exp() as f32);
            let sum: f32 = row.iter().sum();
            row.iter_mut().for_each(|p| *p /= sum);
            let (mut left, mut label) = (rng.random::<f32>(), 0);
            while label < 3 && left > row[label] {
                left -= row[label];
                label += 1;
            }
            tempered(&mut row, &[4], 1.0 / sharper);
            held.probabilities.extend(row);
            held.truth.push(label as u32);
            held.parts.push(sample as u32 % 5);
            if let (Some(held), Some(groups)) = (&mut held.groups, groups) {
                held.push(sample as u32 % groups);
            }
        }
        held
    }

    fn fit(held: &HeldOut) -> Option<Certainty> {
        Certainty::fit(held, &Levels::new(&[4]), HeldOutParts::Groups, "d", 0).unwrap()
    }

    #[test]
    fn too_sure_and_too_shy_models_come_down_to_the_floor() {
        for sharper in [4.0, 0.25] {
            let certainty = fit(&drawn(800, sharper, Some(10))).unwrap();
            assert!((certainty.temperature / sharper - 1.0).abs() < 0.15, "{certainty}");
            let CalibrationErrors { before, after, floor } = certainty.calibration_error;
            assert!(before > 0.1 && after < floor + 0.02 && floor > 0.01, "{certainty}");
            assert!(certainty.worst_group_gap.unwrap() < 0.15, "{certainty}");
            assert_eq!(certainty.fitted_on.groups, Some(10));
        }
    }

    #[test]
    fn a_calibrated_model_stays_and_lies_at_its_floor() {
        let certainty = fit(&drawn(2000, 1.0, None)).unwrap();
        assert!((certainty.temperature - 1.0).abs() < 0.1, "{certainty}");
        let CalibrationErrors { after, floor, .. } = certainty.calibration_error;
        assert!((after - floor).abs() < 0.01, "{certainty}");
        assert_eq!(certainty.worst_group_gap, None);
    }

    #[test]
    fn few_predictions_fit_nothing() {
        assert_eq!(fit(&drawn(29, 1.0, None)), None);
        assert!(fit(&drawn(30, 1.0, None)).is_some());
    }
}
