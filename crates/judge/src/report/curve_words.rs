//! The gain of more training recordings, in sentences.

use taxel_report::numbers::digits;

use crate::values::{CurveGain, LearningCurve, Primary};

/// Says what more recordings would bring: `with 40 of each class: 88.2 %; 20 more of each class: +2.1 points [0.0, 4.3]`. Beside the
/// score of the test parts stands the forecast of inner folds, which have not seen them.
pub fn curve_words(curve: &LearningCurve, primary: &Primary) -> Vec<String> {
    let of_each = if curve.per.is_empty() { String::new() } else { format!(" of each {}", curve.per) };
    let Some(last) = curve.whole.as_ref().or(curve.points.last()) else { return vec![] };
    let count = |count: f64| if count.fract() == 0.0 { format!("{count:.0}") } else { digits(count) };
    let mut words = vec![format!(
        "{} has {} with {} training recordings{of_each}.",
        curve.network,
        primary.named_value(last.score),
        count(last.count)
    )];
    let Some(law) = &curve.law else {
        words.push(
            "Its scores follow no law of fewer and fewer recordings, so nothing is said of more.".into(),
        );
        return words;
    };
    let show = primary.show();
    let score = |error: f64| if primary.is_percent() { 100.0 - error } else { error };
    let scores = |ends: [f64; 2]| {
        let [a, b] = ends.map(score);
        format!("[{}, {}]", show(a.min(b)), show(a.max(b)))
    };
    if let (Some((error, ends)), Some(_)) = (law.forecast, &curve.whole) {
        let sizes = curve.points.iter().map(|point| count(point.count)).collect::<Vec<_>>().join(", ");
        words.push(format!(
            "Inner folds, which have no test sample, forecast {} {} from {sizes} recordings{of_each}.",
            primary.named_value(score(error)),
            scores(ends)
        ));
    }
    for CurveGain { more, gain, interval: [low, high] } in &law.gains {
        let sign = if primary.is_percent() { "+" } else { "-" };
        let ends = format!("[{}, {}]", show(*low), show(*high));
        words.push(format!("{} more{of_each}: {sign}{} {ends}.", count(*more), primary.difference(*gain)));
    }
    words.push(match law.level {
        Some((floor, ends)) => {
            format!("It levels off at {} {}.", primary.named_value(score(floor)), scores(ends))
        }
        None => "Where it levels off cannot be told from these sizes.".into(),
    });
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::{CurveLaw, CurvePoint};
    use taxel_data::Task;

    #[test]
    fn gains_and_level_are_said_with_their_intervals() {
        let task = Task::Classes(vec!["a".into(), "b".into()]);
        let point = |count, score| CurvePoint { count, scores: vec![score], score };
        let gains = vec![CurveGain { more: 20.0, gain: 2.04, interval: [0.0, 4.1] }];
        let (level, forecast) = (Some((9.0, [6.0, 12.0])), Some((14.0, [12.5, 15.0])));
        let law = CurveLaw { floor: 9.0, scale: 40.0, rate: 0.5, level, forecast, gains };
        let curve = LearningCurve {
            network: "mlp".into(),
            per: "class".into(),
            points: vec![point(16.0, 80.0), point(32.0, 85.5)],
            whole: Some(point(40.0, 86.5)),
            law: Some(law),
        };
        assert_eq!(
            curve_words(&curve, &Primary::of(&task)),
            [
                "mlp has 86.5 % with 40 training recordings of each class.",
                "Inner folds, which have no test sample, forecast 86.0 % [85.0, 87.5] from 16, 32 recordings of each class.",
                "20 more of each class: +2.0 points [0.0, 4.1].",
                "It levels off at 91.0 % [88.0, 94.0].",
            ]
        );
        let words = curve_words(&LearningCurve { law: None, ..curve }, &Primary::of(&task));
        assert!(words[1].contains("no law"), "{words:?}");
    }
}
