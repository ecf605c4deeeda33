//! Sentences for a curve, and for all of them together.

use taxel_judge::{Contrast, Primary};
use taxel_report::numbers::{between, digits};

use crate::shrunk::{Curve, Shrunk};

/// Returns a difference in words: `-0.4 points (-1.9 to +1.1)`.
fn difference(primary: &Primary, contrast: &Contrast) -> String {
    let signed = primary.show_signed();
    let interval = contrast.interval.map_or(String::new(), between(signed));
    format!("{}{interval}", primary.with_points(&signed(zero(primary, contrast.difference))))
}

/// Returns a loss in words: `lost 3.1 points (1.0 to 5.2)`.
fn loss(primary: &Primary, contrast: &Contrast) -> String {
    let (show, lost) = (primary.show(), primary.loss(contrast.difference));
    let interval = contrast.interval.map_or(String::new(), |bounds| {
        let [low, high] = primary.losses(bounds).map(|bound| show(zero(primary, bound)));
        format!(" ({low} to {high})")
    });
    if lost > 0.0 {
        format!("lost {}{interval}", primary.with_points(&show(lost)))
    } else {
        format!("lost nothing ({})", difference(primary, contrast))
    }
}

/// Returns 0 for values that would print as `-0.0`.
fn zero(primary: &Primary, value: f64) -> f64 {
    if primary.is_percent() && value.abs() < 0.05 { 0.0 } else { value }
}

/// Returns a large loss in words: `30 points`, `1.25 N`.
pub fn roughly(primary: &Primary, loss: f64) -> String {
    primary.with_points(&if primary.is_percent() { format!("{loss:.0}") } else { digits(loss) })
}

/// Describes the knee of a curve with its evidence: how it does on the test parts, and what the next smaller setting
/// loses.
pub fn knee_words(curve: &Curve, primary: &Primary, margin: f64) -> String {
    let at = curve.knee.map_or(0, |knee| knee + 1);
    let next = curve.steps.get(at).map(|step| {
        let part = match (&step.refused, step.inner, step.outer) {
            (Some(reason), ..) => reason.clone(),
            (_, Some(inner), Some(outer)) => {
                let (outer, inner) = (loss(primary, &outer), loss(primary, &inner));
                format!("{outer} on the test parts ({inner} on inner folds)")
            }
            (_, Some(inner), None) => format!("{} on inner folds", loss(primary, &inner)),
            _ => "was not tried".into(),
        };
        format!("{}: {part}", step.label)
    });
    let Some(knee) = curve.knee.and_then(|knee| curve.steps.get(knee)) else {
        let next = next.map_or(String::new(), |next| format!("; {next}"));
        return format!("Nothing may go of {}{next}.", curve.whole);
    };
    let evidence = match (knee.outer, knee.inner) {
        (Some(outer), _) => format!("{} on the test parts", difference(primary, &outer)),
        (None, Some(inner)) => format!("{} on inner folds", difference(primary, &inner)),
        (None, None) => "no evidence".into(),
    };
    let next = next.map_or("; nothing smaller was tried".into(), |next| format!("; {next}"));
    let evidence =
        match knee.outer.and_then(|contrast| contrast.interval).map(|bounds| primary.losses(bounds)[1]) {
            // The same question as of a choice: could a loss that matters have been missed?
            Some(most) if most > margin => {
                format!("{evidence}, where a loss of {} could have been missed", primary.show()(most))
            }
            _ => evidence,
        };
    let doubt = match knee.outer {
        Some(outer) if !outer.suffices(margin, primary) => {
            ". The test parts do not bear out what the inner folds said: take the next larger setting"
        }
        _ => "",
    };
    format!("{} suffice: {evidence}{next}{doubt}.", knee.label)
}

/// Returns the result in sentences: what may go, what it costs, what is saved.
pub fn shrunk_words(shrunk: &Shrunk) -> Vec<String> {
    let mut words: Vec<String> =
        shrunk.curves.iter().map(|curve| format!("{}: {}", curve.title, curve.words)).collect();
    let Some(combined) = &shrunk.combined else {
        words.push(if shrunk.curves.iter().any(|curve| curve.knee.is_some()) {
            "What suffices by itself could not be trained together; no smaller model was written.".into()
        } else {
            format!("{} needs all that was tried; no smaller model was written.", shrunk.network)
        });
        return words;
    };
    let primary = &shrunk.primary;
    let evidence = difference(primary, &combined.outer);
    words.push(format!("All together ({}): {evidence} on the test parts.", combined.parts.join("; ")));
    let inner = match combined.inner {
        None => Some("could not be trained on inner folds".into()),
        Some(contrast) if contrast.suffices(shrunk.margin, primary) => None,
        Some(contrast) => Some(format!("{} on inner folds, too much", loss(primary, &contrast))),
    };
    if let Some(inner) = &inner {
        words.push(format!(
            "Together they {inner}, and no combination that was tried suffices there; this is the last of them: ship it only if \
             that does not matter."
        ));
    }
    if !combined.outer.suffices(shrunk.margin, primary) {
        let unseen = if inner.is_none() { ", which the inner folds did not show" } else { "" };
        words.push(format!(
            "Together they lose more on the test parts than {}{unseen}: ship it only if that does not matter.",
            primary.margin(shrunk.margin)
        ));
    }
    if let [whole, small] = shrunk.models.as_slice() {
        let share = |part: u64, all: u64| 100.0 * part as f64 / all.max(1) as f64;
        words.push(format!(
            "The smaller model reads {} of {} values of a recording and takes {:.0} % of the multiply-accumulates and {:.0} % of the \
             parameters.",
            small.readings,
            whole.readings,
            share(small.macs, whole.macs),
            share(small.parameters, whole.parameters),
        ));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shrunk::{Combined, CurveStep};

    fn contrast(difference: f64, half: f64) -> Option<Contrast> {
        Some(Contrast {
            score: 90.0 + difference,
            score_interval: None,
            difference,
            interval: Some([difference - half, difference + half]),
            p_holm: None,
            worse: false,
        })
    }

    fn step(left: usize, by: f64) -> CurveStep {
        CurveStep {
            label: format!("{left} of 28 channels"),
            short: left.to_string(),
            kept: vec![],
            inner: contrast(by, 2.0),
            outer: contrast(by, 1.5),
            refused: None,
        }
    }

    fn curve(knee: Option<usize>, steps: Vec<CurveStep>) -> Curve {
        let (axis, title) = ("sensors".into(), "Sensors".into());
        let (whole, short) = ("28 channels".into(), "28".into());
        Curve { axis, title, whole, short, steps, knee, words: String::new() }
    }

    #[test]
    fn a_knee_is_named_with_numbers() {
        let words = knee_words(&curve(Some(0), vec![step(7, -0.4), step(6, -3.1)]), &Primary::default(), 2.0);
        assert_eq!(
            words,
            "7 of 28 channels suffice: -0.4 points (-1.9 to +1.1) on the test parts; 6 of 28 channels: lost 3.1 points \
             (1.6 to 4.6) on the test parts (lost 3.1 points (1.1 to 5.1) on inner folds)."
        );
        let all = knee_words(&curve(None, vec![step(7, -5.0)]), &Primary::default(), 2.0);
        assert!(all.starts_with("Nothing may go of 28 channels; 7 of 28 channels: lost 5.0"), "{all}");
    }

    #[test]
    fn a_knee_says_what_loss_could_have_been_missed() {
        let mut curve = curve(Some(0), vec![step(7, -0.4)]);
        curve.steps[0].outer = contrast(-0.4, 9.0);
        let words = knee_words(&curve, &Primary::default(), 2.0);
        assert!(words.contains("on the test parts, where a loss of 9.4 could have been missed;"), "{words}");
    }

    #[test]
    fn a_next_setting_that_was_not_trained_says_why_once() {
        let reason = "not tried: 7 of 28 channels lost 30 points on inner folds";
        let next = CurveStep { inner: None, outer: None, refused: Some(reason.into()), ..step(6, 0.0) };
        let words = knee_words(&curve(Some(0), vec![step(7, -0.4), next]), &Primary::default(), 40.0);
        assert!(words.ends_with(&format!("; 6 of 28 channels: {reason}.")), "{words}");
    }

    #[test]
    fn a_knee_that_the_test_parts_contradict_says_so() {
        let mut curve = curve(Some(0), vec![step(7, -0.4)]);
        curve.steps[0].outer = contrast(-4.0, 1.0);
        let words = knee_words(&curve, &Primary::default(), 2.0);
        assert!(words.contains("do not bear out") && words.contains("nothing smaller was tried"), "{words}");
    }

    /// Makes a run whose knees together lose so much on inner folds and on the test parts.
    fn shrunk(together: Option<(Option<Contrast>, Contrast)>) -> Shrunk {
        Shrunk {
            run: "glove".into(),
            network: "mlp".into(),
            source: "simulated".into(),
            samples: 90,
            protocol: "3 folds".into(),
            parts: 3,
            inner: 2,
            primary: Primary::default(),
            margin: 2.0,
            alpha: 0.05,
            notes: vec![],
            whole: (90.0, None),
            curves: vec![curve(Some(0), vec![step(7, -0.4)])],
            left_out: vec![],
            combined: together.map(|(inner, outer)| Combined {
                parts: vec!["7 of 28 channels".into(), "2 bits".into()],
                loosened: vec![],
                inner,
                outer,
            }),
            models: vec![],
            words: vec![],
        }
    }

    #[test]
    fn together_is_said_what_inner_folds_and_test_parts_say() {
        let (little, much) = (contrast(-1.0, 1.0), contrast(-4.0, 1.0));
        let of = |inner, outer: Option<Contrast>| {
            shrunk_words(&shrunk(Some((inner, outer.unwrap()))))[1..].join(" ")
        };
        let all = "All together (7 of 28 channels; 2 bits): -1.0 points (-2.0 to +0.0) on the test parts.";
        assert_eq!(of(little, little), all);
        let words = of(much, little);
        assert!(
            words.contains("Together they lost 4.0 points (3.0 to 5.0) on inner folds, too much, and no"),
            "{words}"
        );
        assert!(!words.contains("more on the test parts"), "{words}");
        let words = of(little, much);
        assert!(
            words.contains("more on the test parts than 2 points, which the inner folds did not show: "),
            "{words}"
        );
        assert!(!words.contains("on inner folds"), "{words}");
        let words = of(much, much);
        assert!(
            words.contains("on inner folds, too much") && words.contains("than 2 points: ship"),
            "{words}"
        );
        assert!(of(None, little).contains("Together they could not be trained on inner folds, and no"));
    }

    #[test]
    fn no_combination_says_whether_anything_may_go_by_itself() {
        let mut shrunk = shrunk(None);
        assert!(
            shrunk_words(&shrunk)[1].starts_with("What suffices by itself could not be trained together; no")
        );
        shrunk.curves[0].knee = None;
        assert_eq!(shrunk_words(&shrunk)[1], "mlp needs all that was tried; no smaller model was written.");
    }
}
