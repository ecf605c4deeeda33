//! Scores that claims compare.

use taxel::learn::metrics::mean_sd;

/// The score that is compared.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Measure {
    /// Over all attributes.
    Accuracy,
    /// Accuracy on one attribute.
    Attribute(&'static str),
    /// Precision of the worst level of an attribute.
    WorstPrecision(&'static str),
    /// Recall of the worst level of an attribute.
    WorstRecall(&'static str),
    /// F1 of the best level of an attribute.
    BestF1(&'static str),
    /// How alike the levels of an attribute are: the SD of their F1, with a minus.
    Steadiness(&'static str),
}

impl Measure {
    /// Returns the attribute; none of the accuracy over all.
    pub fn attribute(self) -> Option<&'static str> {
        match self {
            Measure::Accuracy => None,
            Measure::Attribute(name)
            | Measure::WorstPrecision(name)
            | Measure::WorstRecall(name)
            | Measure::BestF1(name)
            | Measure::Steadiness(name) => Some(name),
        }
    }

    /// Describes the score.
    pub fn words(self) -> &'static str {
        match self {
            Measure::Accuracy | Measure::Attribute(_) => "accuracy",
            Measure::WorstPrecision(_) => "precision of the worst level",
            Measure::WorstRecall(_) => "recall of the worst level",
            Measure::BestF1(_) => "F1 of the best level",
            Measure::Steadiness(_) => "minus the SD of F1 over the levels",
        }
    }

    /// Returns the score of levels that have these precisions, recalls and F1, all in percent; none without levels, and of an
    /// accuracy, which levels do not tell.
    pub fn of_levels(self, levels: &[[f64; 3]]) -> Option<f64> {
        let [precisions, recalls, f1] = [0, 1, 2].map(|at| levels.iter().map(move |level| level[at]));
        match self {
            Measure::Accuracy | Measure::Attribute(_) => None,
            Measure::WorstPrecision(_) => precisions.min_by(f64::total_cmp),
            Measure::WorstRecall(_) => recalls.min_by(f64::total_cmp),
            Measure::BestF1(_) => f1.max_by(f64::total_cmp),
            Measure::Steadiness(_) => mean_sd(&f1.collect::<Vec<_>>()).1.map(|sd| -sd),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_a_worst_a_best_and_a_spread() {
        let levels = [[90.0, 70.0, 80.0], [60.0, 95.0, 74.0], [99.0, 80.0, 86.0]];
        let of = |measure: fn(&'static str) -> Measure| measure("hardness").of_levels(&levels);
        assert_eq!(of(Measure::WorstPrecision), Some(60.0));
        assert_eq!(of(Measure::WorstRecall), Some(70.0));
        assert_eq!(of(Measure::BestF1), Some(86.0));
        assert!((of(Measure::Steadiness).unwrap() + 6.0).abs() < 1e-9);
        assert_eq!((of(Measure::Attribute), Measure::BestF1("x").of_levels(&[])), (None, None));
    }
}
