//! All knees together, loosened until inner folds say that they do.

use std::slice::from_ref;

use taxel_judge::{Contrast, Primary};
use taxel_learn::FoldRecord;

use crate::cache::Cache;
use crate::curves::{Context, Outer};
use crate::error::Result;
use crate::ladder::{Cut, Ladder};
use crate::shrunk::{Combined, Curve};

/// Combinations that are tried at most.
const TRIES: usize = 6;

/// A combination that was tested.
pub struct Together {
    /// The reduction on each axis.
    pub cuts: Vec<Cut>,
    /// Its scores, in words and numbers.
    pub combined: Combined,
    /// Its predictions for the test parts.
    pub records: Vec<FoldRecord>,
}

/// Result of combining all knees.
pub enum Combining {
    /// A combination that was tested.
    Combination(Box<Together>),
    /// None; in words, what was tried.
    None(Vec<String>),
}

/// Predictions of a combination, beside the whole where they have test parts in common; none where it cannot be trained.
type Tried = Option<(Vec<FoldRecord>, Option<Contrast>)>;

/// Trains the knees of all curves together. Where they lose too much on inner folds, or cannot be trained, the axis that lost
/// most by itself takes its next larger setting; the last combination that is tried is tested all the same.
///
/// # Errors
/// An error that ends the shrinking.
pub fn together(
    context: &Context,
    cache: &mut Cache,
    outers: &[Outer],
    tried: &[(Ladder, Curve)],
) -> Result<Combining> {
    search(tried, (&context.primary, context.margin), &mut |is_inner, cuts| {
        let predictions = if is_inner {
            cache.expect(outers.iter().map(|outer| outer.inner.len()).sum());
            context.on_inner(cache, outers, "together", cuts)
        } else {
            cache.expect(outers.len());
            context.on_outer(cache, outers, "together", cuts)
        };
        match predictions {
            Ok(records) => {
                let contrast = context.beside(outers, is_inner, from_ref(&records))?.pop().flatten();
                Ok(Some((records, contrast)))
            }
            Err(error) if error.is_of_setting() => Ok(None),
            Err(error) => Err(error),
        }
    })
}

/// Searches the largest combination that suffices. `request` trains a combination: on inner folds where its first
/// argument is true, else for the test parts.
fn search(
    tried: &[(Ladder, Curve)],
    (primary, margin): (&Primary, f64),
    request: &mut dyn FnMut(bool, &[&Cut]) -> Result<Tried>,
) -> Result<Combining> {
    // Position of the setting on each axis that has one.
    let mut chosen: Vec<(usize, usize)> =
        tried.iter().enumerate().filter_map(|(axis, (_, curve))| Some((axis, curve.knee?))).collect();
    let mut loosened = vec![];
    for attempt in 1..=TRIES {
        if chosen.is_empty() {
            break;
        }
        let steps: Vec<_> = chosen.iter().map(|&(axis, at)| &tried[axis].0.steps[at]).collect();
        let cuts: Vec<&Cut> = steps.iter().map(|step| &step.cut).collect();
        let parts: Vec<String> = steps.iter().map(|step| step.label.clone()).collect();
        let inner = request(true, &cuts)?.and_then(|(_, contrast)| contrast);
        let does = inner.is_some_and(|contrast| contrast.suffices(margin, primary));
        let is_last = chosen.len() == 1 || attempt == TRIES;
        let tried_out = if does || is_last { request(false, &cuts)? } else { None };
        if let Some((records, Some(outer))) = tried_out {
            let cuts = cuts.into_iter().cloned().collect();
            let combined = Combined { parts, loosened, inner, outer };
            return Ok(Combining::Combination(Box::new(Together { cuts, combined, records })));
        }
        let lost = match inner {
            Some(_) if does => "could not be trained on whole training parts".into(),
            Some(contrast) => {
                let lost = primary.difference(primary.loss(contrast.difference));
                format!("lost {lost} on inner folds")
            }
            None => "could not be trained on inner folds".into(),
        };
        loosened.push(format!("Together, {} {lost}.", parts.join("; ")));
        loosen(&mut chosen, primary, tried);
    }
    Ok(Combining::None(loosened))
}

/// Gives the axis whose setting lost most by itself the next larger setting, or removes it.
fn loosen(chosen: &mut Vec<(usize, usize)>, primary: &Primary, tried: &[(Ladder, Curve)]) {
    let lost = |&(axis, at): &(usize, usize)| {
        tried[axis].1.steps[at].inner.map_or(0.0, |contrast| primary.loss(contrast.difference))
    };
    let most = chosen.iter().enumerate().max_by(|(_, a), (_, b)| lost(a).total_cmp(&lost(b)));
    let Some((place, _)) = most else { return };
    match chosen[place].1 {
        0 => {
            chosen.remove(place);
        }
        _ => chosen[place].1 -= 1,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use crate::shrunk::CurveStep;

    use super::*;
    use crate::axis::Axis;
    use crate::error::Error;
    use crate::ladder::LadderStep;

    fn contrast(difference: f64) -> Contrast {
        let score = 90.0 + difference;
        Contrast { score, score_interval: None, difference, interval: None, p_holm: None, worse: false }
    }

    /// Makes an axis of five settings, the smallest of them its knee; each loses `lost` more than the one before.
    fn axis(axis: Axis, lost: f64) -> (Ladder, Curve) {
        let step = |at: usize| LadderStep {
            label: format!("{axis} {at}"),
            short: at.to_string(),
            cut: Cut::Set("width", toml::Value::Integer(at as i64)),
        };
        let curve_step = |at: usize| CurveStep {
            label: format!("{axis} {at}"),
            short: at.to_string(),
            kept: vec![],
            inner: Some(contrast(-lost * (at + 1) as f64)),
            outer: None,
            refused: None,
        };
        let (whole, short) = ("all".to_string(), "all".to_string());
        let steps = (0..5).map(step).collect();
        let ladder = Ladder { axis, whole: whole.clone(), short: short.clone(), steps };
        let steps = (0..5).map(curve_step).collect();
        let (name, title) = (axis.name().into(), axis.title().into());
        (ladder, Curve { axis: name, title, whole, short, steps, knee: Some(4), words: String::new() })
    }

    /// Returns the combination found with these losses on inner folds and test parts, and the number of trainings on either.
    fn found(
        tried: &[(Ladder, Curve)],
        inner: impl Fn(&[usize]) -> Option<f64>,
        outer: impl Fn(&[usize]) -> Option<f64>,
    ) -> (Combining, [usize; 2]) {
        let mut trainings = [0, 0];
        let found = search(tried, (&Primary::default(), 2.0), &mut |is_inner, cuts| {
            trainings[usize::from(!is_inner)] += 1;
            let place = |cut: &&Cut| match cut {
                Cut::Set(_, toml::Value::Integer(at)) => *at as usize,
                _ => panic!(),
            };
            let at: Vec<usize> = cuts.iter().map(place).collect();
            let lost = if is_inner { inner(&at) } else { outer(&at) };
            Ok(lost.map(|lost| (vec![], Some(contrast(-lost)))))
        });
        (found.unwrap(), trainings)
    }

    #[test]
    fn the_axis_that_lost_most_is_loosened_until_inner_folds_say_that_it_does() {
        let tried = [axis(Axis::Rate, 0.1), axis(Axis::Bits, 0.3)];
        let (outcome, trainings) = found(&tried, |at| Some(if at[1] > 2 { 5.0 } else { 1.0 }), |_| Some(1.5));
        let Combining::Combination(outcome) = outcome else { panic!() };
        assert_eq!(outcome.combined.parts, ["rate 4", "bits 2"]);
        assert_eq!(outcome.combined.loosened[0], "Together, rate 4; bits 4 lost 5.0 points on inner folds.");
        assert_eq!((outcome.combined.loosened.len(), outcome.combined.outer), (2, contrast(-1.5)));
        assert_eq!(trainings, [3, 1], "the test parts are asked once");
    }

    #[test]
    fn the_last_combination_is_tested_whatever_inner_folds_say() {
        let tried = [axis(Axis::Rate, 0.1), axis(Axis::Bits, 0.1)];
        let (outcome, trainings) = found(&tried, |_| Some(9.0), |_| Some(9.0));
        let Combining::Combination(outcome) = outcome else { panic!() };
        assert_eq!((outcome.combined.inner, trainings), (Some(contrast(-9.0)), [6, 1]));
    }

    #[test]
    fn a_combination_that_cannot_be_trained_is_loosened_and_stops_nothing() {
        let tried = [axis(Axis::Rate, 0.1), axis(Axis::Bits, 0.3)];
        let (outcome, trainings) = found(&tried, |_| Some(1.0), |at| (at[1] < 4).then_some(1.0));
        let Combining::Combination(outcome) = outcome else { panic!() };
        let words = "Together, rate 4; bits 4 could not be trained on whole training parts.";
        assert_eq!((outcome.combined.loosened, trainings), (vec![words.to_string()], [2, 2]));
        let (outcome, trainings) = found(&tried, |_| None, |_| None);
        let Combining::None(words) = outcome else { panic!() };
        assert_eq!((words.len(), trainings), (6, [6, 1]));
        assert_eq!(words[0], "Together, rate 4; bits 4 could not be trained on inner folds.");
    }

    #[test]
    fn what_stops_everything_stops_it_and_no_knee_is_no_combination() {
        let tried = [axis(Axis::Rate, 0.1)];
        let stopped = search(&tried, (&Primary::default(), 2.0), &mut |_, _| {
            Err(Error::Stopped { folder: String::new() })
        });
        assert!(matches!(stopped, Err(Error::Stopped { .. })));
        let (outcome, trainings) = found(&[], |_| None, |_| None);
        assert!(matches!(outcome, Combining::None(words) if words.is_empty() && trainings == [0, 0]));
    }
}
