//! The table of metrics: name, unit and direction of each, task by task.
//!
//! A new metric is one entry here.

use taxel_data::{Quantity, Task};

use crate::error::{Error, Result};
use crate::metrics::{
    Detections, LevelScores, Levels, MacroScores, MeanEstimate, Outcome, Scores, Terms, average_precision,
    mean_sd, quantile, roc_area,
};

/// The unit of a metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MetricUnit {
    /// Percent; differences are percentage points.
    Percent,
    /// A number without a unit.
    Number,
    /// The unit of the quantity.
    Quantity,
    /// Percent of the range of the true values, which quantities in different units have in common.
    Range,
    /// Seconds.
    Seconds,
    /// Time steps.
    Steps,
}

impl MetricUnit {
    /// Returns what a share is multiplied by: 100 for percent, 1 otherwise.
    pub fn scale(self) -> f64 {
        match self {
            MetricUnit::Percent | MetricUnit::Range => 100.0,
            MetricUnit::Number | MetricUnit::Quantity | MetricUnit::Seconds | MetricUnit::Steps => 1.0,
        }
    }
}

/// Which of two values is the better one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// The higher one.
    Higher,
    /// The lower one.
    Lower,
}

/// A measure of predictions.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Name in `results.json` and configs: `accuracy`.
    pub name: &'static str,
    /// Name in tables and charts: `F1`.
    pub title: &'static str,
    /// Its unit.
    pub unit: MetricUnit,
    /// Which of two values is the better one.
    pub direction: Direction,
    /// Whether it has a column in the table of a run.
    pub is_shown: bool,
    /// Whether it has one where each time step has its own class, such as slip.
    is_of_events: bool,
    of: fn(&Task, &Outcome) -> Result<f64>,
    /// The contribution of each sample, before [`MetricUnit::scale`]. None where the metric is no mean over samples.
    terms: Option<fn(&Outcome, usize) -> Vec<f64>>,
}

/// Metrics of classes and levels; of several attributes each is the mean over them.
const OF_LABELS: &[Metric] = OF_TWO_CLASSES.split_at(OF_TWO_CLASSES.len() - OF_EVENTS).0;

/// Metrics of levels, which have an order, so that a miss by one level is not a miss by nine.
const OF_LEVELS: &[Metric] = &of_levels();

const fn of_levels() -> [Metric; OF_LABELS.len() + 2] {
    let mut all = [WITHIN_ONE; OF_LABELS.len() + 2];
    let mut at = 0;
    while at < OF_LABELS.len() {
        all[at] = OF_LABELS[at];
        at += 1;
    }
    all[at + 1] = LEVEL_ERROR;
    all
}

const WITHIN_ONE: Metric = Metric {
    of: |task, outcome| {
        let share = |_, level: &LevelScores| level.within_one.unwrap_or(0.0);
        Ok(100.0 * mean_of_attributes(task, outcome, share)?)
    },
    ..Metric::of_labels("within_one_level", "within one level")
};

const LEVEL_ERROR: Metric = Metric {
    unit: MetricUnit::Number,
    direction: Direction::Lower,
    is_shown: false,
    of: |task, outcome| mean_of_attributes(task, outcome, |_, level| level.mean_absolute_error),
    ..Metric::of_labels("level_error", "mean level error")
};

/// Metrics that two classes have besides.
const OF_EVENTS: usize = 7;

/// Metrics of two classes: the last ones judge how well the second is told, such as slip, by its probability and in time.
const OF_TWO_CLASSES: &[Metric] = &[
    Metric {
        of: |task, outcome| macro_mean(task, outcome, |scores| scores.accuracy),
        terms: Some(share_right),
        ..Metric::of_labels("accuracy", "accuracy")
    },
    Metric {
        of: |task, outcome| macro_mean(task, outcome, |scores| scores.precision),
        ..Metric::of_labels("precision", "precision")
    },
    Metric {
        of: |task, outcome| macro_mean(task, outcome, |scores| scores.recall),
        ..Metric::of_labels("recall", "recall")
    },
    Metric {
        of: |task, outcome| macro_mean(task, outcome, |scores| scores.f1),
        ..Metric::of_labels("f1", "F1")
    },
    Metric {
        is_shown: false,
        of: balanced_accuracy,
        ..Metric::of_labels("balanced_accuracy", "balanced accuracy")
    },
    Metric {
        unit: MetricUnit::Number,
        direction: Direction::Lower,
        is_shown: false,
        of: |task, outcome| Ok(calibration(task, outcome)?.0),
        ..Metric::of_labels("calibration_error", "calibration error")
    },
    Metric {
        unit: MetricUnit::Number,
        direction: Direction::Lower,
        is_shown: false,
        of: |task, outcome| Ok(calibration(task, outcome)?.1),
        ..Metric::of_labels("brier", "Brier score")
    },
    Metric {
        of: |_, outcome| Ok(ranking(outcome, roc_area)),
        ..Metric::of_events("auroc", "AUROC", MetricUnit::Percent, Direction::Higher)
    },
    Metric {
        of: |_, outcome| Ok(ranking(outcome, average_precision)),
        ..Metric::of_events("average_precision", "average precision", MetricUnit::Percent, Direction::Higher)
    },
    Metric {
        of: |_, outcome| Ok(detected(outcome, |found, _| Some(100.0 * found.missed_share()?))),
        ..Metric::of_events("missed_events", "missed events", MetricUnit::Percent, Direction::Lower)
    },
    Metric {
        of: |_, outcome| Ok(detected(outcome, |found, rate| Some(found.delay()? / rate?))),
        ..Metric::of_events("delay", "delay", MetricUnit::Seconds, Direction::Lower)
    },
    Metric {
        of: |_, outcome| Ok(detected(outcome, |found, rate| found.delay().filter(|_| rate.is_none()))),
        ..Metric::of_events("delay_steps", "delay", MetricUnit::Steps, Direction::Lower)
    },
    Metric {
        of: |_, outcome| Ok(detected(outcome, |found, rate| Some(false_alarms(found, 60.0 * rate?)))),
        ..Metric::of_events(ALARMS[0], "false alarms per minute", MetricUnit::Number, Direction::Lower)
    },
    Metric {
        of: |_, outcome| {
            let alarms = |found: &Detections, rate: Option<f64>| match rate {
                Some(_) => None,
                None => Some(false_alarms(found, 1000.0)),
            };
            Ok(detected(outcome, alarms))
        },
        ..Metric::of_events(ALARMS[1], "false alarms per 1000 steps", MetricUnit::Number, Direction::Lower)
    },
];

/// Metrics of which time steps with classes of their own have one: with a known rate, and without.
const ALARMS: [&str; 2] = ["false_alarms_per_minute", "false_alarms_per_1000_steps"];

/// Metrics of values in one unit; of several quantities each is the mean over them.
const OF_VALUES: &[Metric] = &[
    Metric {
        of: |task, outcome| mean_over(task, outcome, |errors, _| mean_sd(&absolute(errors)).0),
        terms: Some(|outcome, width| {
            errors(outcome, width).iter().map(|row| mean_sd(&absolute(row)).0).collect()
        }),
        ..Metric::new("mae", "MAE", MetricUnit::Quantity, Direction::Lower)
    },
    Metric {
        of: |task, outcome| mean_over(task, outcome, |errors, _| mean_sd(&squares(errors)).0.sqrt()),
        ..Metric::new("rmse", "RMSE", MetricUnit::Quantity, Direction::Lower)
    },
    R2,
    Metric {
        of: |task, outcome| mean_over(task, outcome, |errors, _| within(errors, 0.5)),
        is_shown: false,
        ..Metric::new("median_error", "median error", MetricUnit::Quantity, Direction::Lower)
    },
    Metric {
        of: |task, outcome| mean_over(task, outcome, |errors, _| within(errors, 0.95)),
        ..Metric::new("p95_error", "95 % of errors within", MetricUnit::Quantity, Direction::Lower)
    },
    Metric { is_shown: false, ..RELATIVE_MAE },
];

/// Metrics of values in several units: each is the mean over the quantities of a number that does not depend on their units.
const OF_MIXED_VALUES: &[Metric] = &[RELATIVE_MAE, R2];

const R2: Metric = Metric {
    of: |task, outcome| mean_over(task, outcome, r_squared),
    ..Metric::new("r2", "R²", MetricUnit::Number, Direction::Higher)
};

const RELATIVE_MAE: Metric = Metric {
    of: |task, outcome| {
        let share = |errors: &[f64], truth: &[f64]| mean_sd(&absolute(errors)).0 / range(truth);
        Ok(100.0 * mean_over(task, outcome, share)?)
    },
    terms: Some(|outcome, width| {
        let ranges: Vec<f64> =
            (0..width).map(|quantity| range(&truth_of(outcome, quantity, width))).collect();
        let of_row = |row: &Vec<f64>| {
            let shares = row.iter().zip(&ranges).map(|(error, range)| error.abs() / range);
            shares.sum::<f64>() / width as f64
        };
        errors(outcome, width).iter().map(of_row).collect()
    }),
    ..Metric::new("relative_mae", "relative MAE", MetricUnit::Range, Direction::Lower)
};

/// Returns the metrics of a task; the first is its primary one, which choices go by.
pub fn metrics(task: &Task) -> &'static [Metric] {
    match task {
        Task::Classes(classes) if classes.len() == 2 => OF_TWO_CLASSES,
        Task::Classes(_) => OF_LABELS,
        Task::Levels(_) => OF_LEVELS,
        Task::Values(quantities) if in_several_units(quantities) => OF_MIXED_VALUES,
        Task::Values(_) => OF_VALUES,
    }
}

/// Returns the value of each metric of the task, in its unit; those that these samples do not define are left out.
///
/// # Errors
/// As [`Metric::of`].
pub fn scores(task: &Task, outcome: &Outcome) -> Result<Scores> {
    let value = |metric: &Metric| Ok((metric.name, metric.of(task, outcome)?));
    let each = metrics(task).iter().map(value).collect::<Result<Vec<_>>>()?;
    Ok(Scores::new(each.into_iter().filter(|(_, value)| !value.is_nan())))
}

/// Returns the metrics that have a column in the table of these scores: those of events where time steps have classes of
/// their own, and where some of the scores have the metric.
pub fn shown<'s>(task: &Task, each: impl IntoIterator<Item = &'s Scores>) -> Vec<&'static Metric> {
    let of_events = |scores: &&Scores| ALARMS.iter().any(|name| scores.get(name).is_some());
    let timed: Vec<&Scores> = each.into_iter().filter(of_events).collect();
    let is_held = |metric: &Metric| timed.iter().any(|scores| scores.get(metric.name).is_some());
    metrics(task).iter().filter(|metric| metric.is_shown || metric.is_of_events && is_held(metric)).collect()
}

/// Checks whether quantities are several that are not all known to be in one unit: their errors cannot be averaged.
fn in_several_units(quantities: &[Quantity]) -> bool {
    let [first, others @ ..] = quantities else { return false };
    !others.is_empty() && (first.unit.is_none() || others.iter().any(|other| other.unit != first.unit))
}

/// Lists the names of the metrics of all tasks; one that several have comes once for each.
pub(crate) fn metric_names() -> impl Iterator<Item = &'static str> {
    OF_TWO_CLASSES.iter().chain(OF_VALUES).map(|metric| metric.name)
}

impl Metric {
    const fn new(name: &'static str, title: &'static str, unit: MetricUnit, direction: Direction) -> Self {
        let (is_shown, is_of_events) = (true, false);
        Metric { name, title, unit, direction, is_shown, is_of_events, of: |_, _| Ok(0.0), terms: None }
    }

    const fn of_labels(name: &'static str, title: &'static str) -> Self {
        Metric::new(name, title, MetricUnit::Percent, Direction::Higher)
    }

    const fn of_events(
        name: &'static str,
        title: &'static str,
        unit: MetricUnit,
        direction: Direction,
    ) -> Self {
        Metric { is_shown: false, is_of_events: true, ..Metric::new(name, title, unit, direction) }
    }

    /// Returns the metric by which methods for `task` are compared and chosen.
    pub fn primary(task: &Task) -> &'static Metric {
        &metrics(task)[0]
    }

    /// Returns the metric of that name.
    pub fn named(task: &Task, name: &str) -> Option<&'static Metric> {
        metrics(task).iter().find(|metric| metric.name == name)
    }

    /// Returns its value for `outcome`, in its unit; NaN where the samples do not define it, as a ranking of one class.
    ///
    /// # Errors
    /// An outcome of another task, or of no samples.
    pub fn of(&self, task: &Task, outcome: &Outcome) -> Result<f64> {
        (self.of)(task, outcome)
    }

    /// Returns what each sample adds: the metric is their mean times [`MetricUnit::scale`]. None where it is no mean over
    /// samples.
    pub fn terms(&self, task: &Task, outcome: &Outcome) -> Option<Vec<f64>> {
        let width = match task {
            Task::Classes(_) => 1,
            Task::Levels(attributes) => attributes.len(),
            Task::Values(quantities) => quantities.len(),
        };
        self.terms.map(|terms| terms(outcome, width.max(1)))
    }

    /// Estimates its value from what samples add ([`Metric::terms`]), before [`MetricUnit::scale`]; `samples` and `groups`
    /// name the sample and the group of each.
    pub fn estimate(&self, terms: &[f64], samples: &[u32], groups: Option<&[u32]>) -> Option<MeanEstimate> {
        let kind = if self.unit == MetricUnit::Percent { Terms::Shares } else { Terms::Amounts };
        MeanEstimate::of(terms, samples, groups, kind)
    }

    /// Returns its value over the samples of all `outcomes` together; 0 without samples, and for a metric that is no
    /// mean over samples.
    pub fn pooled<'o>(&self, task: &Task, outcomes: impl IntoIterator<Item = &'o Outcome>) -> f64 {
        let terms = outcomes.into_iter().filter_map(|outcome| self.terms(task, outcome));
        let terms: Vec<f64> = terms.flatten().collect();
        self.unit.scale() * terms.iter().sum::<f64>() / terms.len().max(1) as f64
    }

    /// Returns what its values are counted in: `%`, or the unit of the first quantity; none of a plain number.
    pub fn unit_of(&self, task: &Task) -> Option<String> {
        match self.unit {
            MetricUnit::Percent | MetricUnit::Range => Some("%".into()),
            MetricUnit::Number => None,
            MetricUnit::Seconds => Some("s".into()),
            MetricUnit::Steps => Some("steps".into()),
            MetricUnit::Quantity => task.quantities().first()?.unit.clone(),
        }
    }

    /// Returns its title with its unit: `MAE N`.
    pub fn with_unit(&self, task: &Task) -> String {
        [Some(self.title.to_string()), self.unit_of(task)].into_iter().flatten().collect::<Vec<_>>().join(" ")
    }

    /// Returns its name in a sentence: `macro-F1`.
    pub fn in_words(&self) -> &'static str {
        if self.name == "f1" { "macro-F1" } else { self.title }
    }

    /// Checks whether `a` is better than `b`.
    pub fn prefers(&self, a: f64, b: f64) -> bool {
        match self.direction {
            Direction::Higher => a > b,
            Direction::Lower => a < b,
        }
    }

    /// Returns by how much `a` is worse than `b`: above 0 where it is.
    pub fn worsening(&self, a: f64, b: f64) -> f64 {
        match self.direction {
            Direction::Higher => b - a,
            Direction::Lower => a - b,
        }
    }
}

/// Returns the mean over the attributes of a score of each.
fn mean_of_attributes(
    task: &Task,
    outcome: &Outcome,
    score: impl Fn(usize, &LevelScores) -> f64,
) -> Result<f64> {
    let (truth, predicted) = outcome.labels();
    let each = Levels::of_task(task).scores(truth, predicted)?;
    let sum: f64 = each.iter().enumerate().map(|(at, attribute)| score(at, attribute)).sum();
    Ok(sum / each.len().max(1) as f64)
}

/// Returns the mean over the attributes in %; of the classes that were trained.
fn macro_mean(task: &Task, outcome: &Outcome, score: fn(&MacroScores) -> f64) -> Result<f64> {
    let of_one = |at: usize, attribute: &LevelScores| {
        score(&attribute.confusion.scores_without(outcome.untrained(at)))
    };
    Ok(100.0 * mean_of_attributes(task, outcome, of_one)?)
}

/// Returns the mean recall of the classes that occur, in % (scikit-learn's `balanced_accuracy_score`): classes of few
/// samples count as much as those of many.
fn balanced_accuracy(task: &Task, outcome: &Outcome) -> Result<f64> {
    let of_one = |at: usize, attribute: &LevelScores| {
        let trained = |class: &usize| !outcome.untrained(at).iter().any(|other| *other as usize == *class);
        let classes = attribute.per_level.iter().enumerate();
        let present = classes.filter(|(class, scores)| scores.support > 0 && trained(class));
        let recalls: Vec<f64> = present.map(|(_, scores)| scores.recall).collect();
        // Where no class is left, nothing can be right.
        if recalls.is_empty() { 0.0 } else { mean_sd(&recalls).0 }
    };
    Ok(100.0 * mean_of_attributes(task, outcome, of_one)?)
}

/// Returns in % how well the probability of the second of two classes ranks samples; NaN where `area` is not defined.
fn ranking(outcome: &Outcome, area: fn(&[f32], &[bool]) -> Option<f64>) -> f64 {
    let second: Vec<f32> = outcome.outputs().chunks_exact(2).map(|row| row[1]).collect();
    let is_second: Vec<bool> = outcome.labels().0.iter().map(|label| *label == 1).collect();
    100.0 * area(&second, &is_second).unwrap_or(f64::NAN)
}

/// Returns a value of the events that were found, given the steps per second; NaN where samples are no time steps, and where
/// they do not define it.
fn detected(outcome: &Outcome, value: fn(&Detections, Option<f64>) -> Option<f64>) -> f64 {
    let Some(at) = outcome.steps() else { return f64::NAN };
    let (truth, predicted) = outcome.labels();
    let is_second = |labels: &[u32]| labels.iter().map(|label| *label == 1).collect::<Vec<_>>();
    value(&Detections::of(&is_second(truth), &is_second(predicted), at), at.rate).unwrap_or(f64::NAN)
}

/// Returns the false alarms in so many steps.
fn false_alarms(found: &Detections, steps: f64) -> f64 {
    found.false_alarms() as f64 * steps / found.steps() as f64
}

/// Returns the calibration error and the Brier score.
fn calibration(task: &Task, outcome: &Outcome) -> Result<(f64, f64)> {
    Levels::of_task(task).calibration(outcome.outputs(), outcome.labels().0)
}

/// Returns for each sample the share of its labels that is right, 0 to 1.
fn share_right(outcome: &Outcome, width: usize) -> Vec<f64> {
    let (truth, predicted) = outcome.labels();
    let right = |(truth, predicted): (&[u32], &[u32])| {
        truth.iter().zip(predicted).filter(|(a, b)| a == b).count() as f64 / width as f64
    };
    truth.chunks_exact(width).zip(predicted.chunks_exact(width)).map(right).collect()
}

/// Returns the errors of each sample, one per quantity.
fn errors(outcome: &Outcome, width: usize) -> Vec<Vec<f64>> {
    let Outcome::Values { truth, predicted, .. } = outcome else { return vec![] };
    let row = |(truth, predicted): (&[f32], &[f32])| {
        predicted.iter().zip(truth).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect()
    };
    truth.chunks_exact(width).zip(predicted.chunks_exact(width)).map(row).collect()
}

/// Returns the mean over the quantities of a value of their errors and true values.
fn mean_over(task: &Task, outcome: &Outcome, value: fn(&[f64], &[f64]) -> f64) -> Result<f64> {
    let (Outcome::Values { .. }, Task::Values(quantities)) = (outcome, task) else {
        return Err(Error::Metrics {
            what: "predictions",
            reason: "are labels where values are needed".into(),
        });
    };
    let width = quantities.len().max(1);
    let rows = errors(outcome, width);
    if rows.is_empty() {
        return Err(Error::Metrics { what: "predicted values", reason: "there are none".into() });
    }
    let of_column = |column: usize| {
        let errors: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        value(&errors, &truth_of(outcome, column, width))
    };
    Ok((0..width).map(of_column).sum::<f64>() / width as f64)
}

/// Returns the true values of one quantity.
fn truth_of(outcome: &Outcome, quantity: usize, width: usize) -> Vec<f64> {
    let Outcome::Values { truth, .. } = outcome else { return vec![] };
    truth.iter().skip(quantity).step_by(width).map(|v| f64::from(*v)).collect()
}

/// Returns the distance of the largest and the least value; 1 where they are equal.
fn range(values: &[f64]) -> f64 {
    let (least, most) = (
        values.iter().copied().fold(f64::INFINITY, f64::min),
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    );
    if most > least { most - least } else { 1.0 }
}

/// Returns the size that a share of the errors does not pass.
fn within(errors: &[f64], share: f64) -> f64 {
    let mut sizes = absolute(errors);
    sizes.sort_by(f64::total_cmp);
    quantile(&sizes, share)
}

fn absolute(errors: &[f64]) -> Vec<f64> {
    errors.iter().map(|error| error.abs()).collect()
}

fn squares(errors: &[f64]) -> Vec<f64> {
    errors.iter().map(|error| error * error).collect()
}

/// Returns 1 less the share of the variance that is left (scikit-learn's `r2_score`): 1 for true values that are all
/// equal and predicted exactly, 0 for equal ones that are not.
fn r_squared(errors: &[f64], truth: &[f64]) -> f64 {
    let mean = mean_sd(truth).0;
    let left: f64 = squares(errors).iter().sum();
    let whole: f64 = truth.iter().map(|value| (value - mean).powi(2)).sum();
    if whole > 0.0 { 1.0 - left / whole } else { f64::from(u8::from(left == 0.0)) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use taxel_data::{Attribute, Labels, Quantity, Targets, Values};

    use super::*;
    use crate::metrics::{BINS, brier, calibration_error, log_loss};

    fn force() -> Vec<Quantity> {
        vec![Quantity { name: "force".into(), unit: Some("N".into()) }]
    }

    #[test]
    fn metrics_of_values_are_those_of_scikit_learn() {
        let targets = Targets::Values(Values::new(force(), vec![3.0, -0.5, 2.0, 7.0]));
        let outcome = Outcome::new(&targets, &[0, 1, 2, 3], vec![2.5, 0.0, 2.0, 8.0]);
        let (task, of) = (targets.task(), |name: &str| {
            let task = targets.task();
            Metric::named(&task, name).unwrap().of(&task, &outcome).unwrap()
        });
        // sklearn.metrics: mean_absolute_error, root_mean_squared_error, r2_score of the example in their docs.
        assert!((of("mae") - 0.5).abs() < 1e-12);
        assert!((of("rmse") - 0.6123724356957945).abs() < 1e-12);
        assert!((of("r2") - 0.9486081370449679).abs() < 1e-12);
        let terms = Metric::primary(&task).terms(&task, &outcome).unwrap();
        assert_eq!(terms, [0.5, 0.5, 0.0, 1.0]);
        assert!(Metric::primary(&task).prefers(0.4, 0.5));
    }

    #[test]
    fn balanced_accuracy_is_that_of_scikit_learn() {
        let names = ["a".to_string(), "b".into(), "never".into()];
        let targets = Targets::classes(&names, &[0, 1, 0, 0, 1, 0]);
        let says = |class: u32| [0, 1, 2].map(|other| if other == class { 1.0 } else { 0.0 });
        let outcome = Outcome::new(&targets, &[0, 1, 2, 3, 4, 5], [0, 1, 0, 0, 0, 1].map(says).concat());
        let metric = Metric::named(&targets.task(), "balanced_accuracy").unwrap();
        // sklearn.metrics.balanced_accuracy_score of the example in its docs.
        assert!((metric.of(&targets.task(), &outcome).unwrap() - 62.5).abs() < 1e-12);
    }

    #[test]
    fn a_class_without_training_samples_is_no_0_in_macro_means() {
        let names = ["a".to_string(), "b".into(), "c".into()];
        // The last two samples are the training part: it has no sample of c.
        let targets = Targets::classes(&names, &[0, 1, 2, 0, 1]);
        let says = |class: u32| [0, 1, 2].map(|other| if other == class { 1.0 } else { 0.0 });
        let outcome = Outcome::new(&targets, &[0, 1, 2], [0, 1, 0].map(says).concat());
        let task = targets.task();
        let value =
            |outcome: &Outcome, name: &str| Metric::named(&task, name).unwrap().of(&task, outcome).unwrap();
        assert!((value(&outcome, "recall") - 200.0 / 3.0).abs() < 1e-12);
        let outcome = outcome.with_training(&targets, &[3, 4]);
        assert_eq!(outcome.untrained(0), [2]);
        assert_eq!((value(&outcome, "recall"), value(&outcome, "balanced_accuracy")), (100.0, 100.0));
        assert!((value(&outcome, "precision") - 75.0).abs() < 1e-12);
        assert!((value(&outcome, "f1") - 250.0 / 3.0).abs() < 1e-12);
        assert!((value(&outcome, "accuracy") - 200.0 / 3.0).abs() < 1e-12, "its samples are wrong answers");
    }

    #[test]
    fn the_primary_metric_is_the_mean_of_its_terms() {
        let classes = ["a".to_string(), "b".into()];
        let targets = Targets::classes(&classes, &[0, 1, 1]);
        let outcome = Outcome::new(&targets, &[0, 1, 2], vec![0.9, 0.1, 0.2, 0.8, 0.6, 0.4]);
        let (task, primary) = (targets.task(), Metric::primary(&targets.task()));
        let terms = primary.terms(&task, &outcome).unwrap();
        assert_eq!((primary.name, terms.as_slice()), ("accuracy", [1.0, 1.0, 0.0].as_slice()));
        let mean = primary.unit.scale() * terms.iter().sum::<f64>() / 3.0;
        assert!((primary.of(&task, &outcome).unwrap() - mean).abs() < 1e-12);
        assert_eq!(primary.worsening(80.0, 90.0), 10.0);
    }

    /// Returns the targets and predictions of a force and another quantity in `unit`, and of each alone.
    fn force_and_another(unit: &str) -> ([Targets; 3], [Vec<f32>; 3]) {
        let both = [force(), vec![Quantity { name: "other".into(), unit: Some(unit.into()) }]].concat();
        let truth = [vec![3.0, -0.5, 2.0, 7.0], vec![1.0, 4.0, 9.0, 16.0]];
        let said = [vec![2.5, 0.0, 2.0, 8.0], vec![1.0, 7.0, 9.0, 12.0]];
        let mixed = |each: &[Vec<f32>; 2]| (0..4).flat_map(|row| [each[0][row], each[1][row]]).collect();
        let alone = |at: usize| Targets::Values(Values::new(vec![both[at].clone()], truth[at].clone()));
        let targets = [Targets::Values(Values::new(both.clone(), mixed(&truth))), alone(0), alone(1)];
        (targets, [mixed(&said), said[0].clone(), said[1].clone()])
    }

    #[test]
    fn metrics_of_several_quantities_are_means_over_them() {
        let (targets, said) = force_and_another("N");
        let rows = [0, 1, 2, 3];
        let value = |at: usize, name: &str| {
            let (task, outcome) = (targets[at].task(), Outcome::new(&targets[at], &rows, said[at].clone()));
            Metric::named(&task, name).unwrap().of(&task, &outcome).unwrap()
        };
        for name in ["mae", "rmse", "r2", "median_error", "p95_error", "relative_mae"] {
            let mean = (value(1, name) + value(2, name)) / 2.0;
            assert!((value(0, name) - mean).abs() < 1e-12 && value(1, name) != value(2, name), "{name}");
        }
        let task = targets[0].task();
        let outcome = Outcome::new(&targets[0], &rows, said[0].clone());
        assert_eq!(Metric::primary(&task).terms(&task, &outcome).unwrap(), [0.25, 1.75, 0.0, 2.5]);
        assert_eq!(outcome.loss(&task).unwrap(), (0.25 + 0.25 + 9.0 + 1.0 + 16.0) / 8.0);
        assert!(outcome.fits(&task, 4) && !outcome.fits(&task, 8) && !outcome.fits(&force_task(), 4));
        assert!(!Outcome::new(&targets[0], &rows, vec![f32::NAN; 8]).fits(&task, 4));
        assert!(outcome.is_about(&targets[0], &rows) && !outcome.is_about(&targets[0], &[3, 2, 1, 0]));
        assert!(!outcome.is_about(&Targets::classes(&["a".to_string()], &[0; 4]), &rows));
    }

    #[test]
    fn errors_in_several_units_are_compared_as_shares_of_the_range() {
        let (targets, said) = force_and_another("mm");
        let (task, outcome) = (targets[0].task(), Outcome::new(&targets[0], &[0, 1, 2, 3], said[0].clone()));
        let primary = Metric::primary(&task);
        assert_eq!((primary.name, primary.unit_of(&task).as_deref()), ("relative_mae", Some("%")));
        // A mean error of 0.5 N of 7.5 N, and of 1.75 mm of 15 mm.
        let want = 100.0 * (0.5 / 7.5 + 1.75 / 15.0) / 2.0;
        assert!((primary.of(&task, &outcome).unwrap() - want).abs() < 1e-9);
        assert!((primary.pooled(&task, [&outcome]) - want).abs() < 1e-9);
        assert!(Metric::named(&task, "mae").is_none(), "a mean of newtons and millimetres says nothing");
        let unknown = ["a", "b"].map(|name| Quantity { name: name.into(), unit: None });
        assert_eq!(Metric::primary(&Task::Values(unknown.to_vec())).name, "relative_mae");
        assert_eq!(Metric::primary(&Task::Values(unknown[..1].to_vec())).name, "mae");
    }

    #[test]
    fn the_size_that_most_errors_do_not_pass_is_that_of_numpy() {
        // numpy.quantile([0.5, 2, 0, 1], [0.5, 0.95]).
        let errors = [0.5, -2.0, 0.0, 1.0];
        assert!((within(&errors, 0.5) - 0.75).abs() < 1e-12 && (within(&errors, 0.95) - 1.85).abs() < 1e-12);
    }

    fn force_task() -> Task {
        Task::Values(force())
    }

    #[test]
    fn a_pooled_metric_is_that_of_all_samples_together() {
        let (targets, said) = force_and_another("N");
        let of_rows =
            |rows: &[usize]| Outcome::new(&targets[1], rows, rows.iter().map(|row| said[1][*row]).collect());
        let (task, all) = (targets[1].task(), of_rows(&[0, 1, 2, 3]));
        let mae = Metric::primary(&task);
        let parts = [of_rows(&[0]), of_rows(&[1, 2, 3])];
        assert!((mae.pooled(&task, &parts) - mae.of(&task, &all).unwrap()).abs() < 1e-12);
        assert_eq!(
            (mae.pooled(&task, []), Metric::named(&task, "r2").unwrap().pooled(&task, &parts)),
            (0.0, 0.0)
        );
        let targets = Targets::classes(&["a".to_string(), "b".into()], &[0, 1, 1]);
        let of_rows = |rows: &[usize]| Outcome::new(&targets, rows, [0.9, 0.1].repeat(rows.len()));
        let (task, parts) = (targets.task(), [of_rows(&[0]), of_rows(&[1, 2])]);
        assert!((Metric::primary(&task).pooled(&task, &parts) - 100.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn r2_of_equal_true_values_is_that_of_scikit_learn() {
        // sklearn.metrics.r2_score([5, 5], [5, 5]) and ([5, 5], [5, 6]).
        assert_eq!((r_squared(&[0.0, 0.0], &[5.0, 5.0]), r_squared(&[0.0, 1.0], &[5.0, 5.0])), (1.0, 0.0));
    }

    #[test]
    fn metrics_of_several_attributes_are_means_over_them() {
        let attribute = |name: &str, levels: &[&str]| Attribute {
            name: name.into(),
            classes: levels.iter().map(|level| level.to_string()).collect(),
        };
        let attributes = vec![attribute("elasticity", &["1", "2"]), attribute("hardness", &["1", "2", "3"])];
        let targets = Targets::Levels(Labels::new(attributes, vec![0, 0, 0, 2, 1, 1, 0, 2]));
        let task = targets.task();
        let says = |levels: [u32; 2]| {
            let mut row = [0.0; 5];
            row[levels[0] as usize] = 1.0;
            row[2 + levels[1] as usize] = 1.0;
            row
        };
        let outputs = [[0, 0], [1, 2], [1, 2], [0, 2]].map(says).concat();
        let outcome = Outcome::new(&targets, &[0, 1, 2, 3], outputs);
        let value = |outcome: &Outcome, name: &str| {
            let metric = Metric::named(&task, name).unwrap();
            metric.of(&task, outcome).unwrap()
        };
        // Elasticity: recall 2 of 3 and 1 of 1; hardness: 1 of 1, 0 of 1, 2 of 2.
        assert!((value(&outcome, "accuracy") - 75.0).abs() < 1e-12);
        let balanced = 100.0 * (5.0 / 6.0 + 2.0 / 3.0) / 2.0;
        assert!((value(&outcome, "balanced_accuracy") - balanced).abs() < 1e-12);
        assert!((value(&outcome, "recall") - balanced).abs() < 1e-12);
        assert_eq!(Metric::primary(&task).terms(&task, &outcome).unwrap(), [1.0, 0.5, 0.5, 1.0]);
        // No training sample of the third hardness: the mean over that attribute leaves it out, the other keeps all.
        let outcome = outcome.with_training(&targets, &[0, 2]);
        assert_eq!((outcome.untrained(0), outcome.untrained(1)), ([].as_slice(), [2].as_slice()));
        let balanced = 100.0 * (5.0 / 6.0 + 1.0 / 2.0) / 2.0;
        assert!((value(&outcome, "balanced_accuracy") - balanced).abs() < 1e-12);
        assert!((value(&outcome, "recall") - balanced).abs() < 1e-12);
        assert!(outcome.fits(&task, 4) && !outcome.fits(&task, 3) && !outcome.fits(&force_task(), 4));
        let foreign = |at: usize, label: u32| {
            let mut other = outcome.clone();
            let Outcome::Labels { truth, .. } = &mut other else { return false };
            truth[at] = label;
            other.fits(&task, 4)
        };
        // A level of the other attribute is none of this one.
        assert!(foreign(1, 2) && !foreign(1, 3) && foreign(0, 1) && !foreign(0, 2));
        assert!(outcome.is_about(&targets, &[0, 1, 2, 3]) && !outcome.is_about(&targets, &[1, 0, 2, 3]));
    }

    #[test]
    fn the_better_value_is_preferred_and_only_it() {
        for (task, name, better, worse) in [
            (Task::Classes(vec![]), "accuracy", 90.0, 80.0),
            (Task::Classes(vec![]), "brier", 0.1, 0.5),
            (force_task(), "mae", 0.5, 2.0),
            (force_task(), "r2", 0.75, -1.0),
        ] {
            let metric = Metric::named(&task, name).unwrap();
            assert!(metric.prefers(better, worse) && !metric.prefers(worse, better), "{name}");
            assert!(!metric.prefers(worse, worse), "{name}");
            let distance = f64::abs(better - worse);
            assert_eq!(
                (metric.worsening(worse, better), metric.worsening(better, worse)),
                (distance, -distance),
                "{name}"
            );
        }
    }

    #[test]
    fn metrics_are_named_with_their_unit() {
        let classes = Task::Classes(vec![]);
        for (task, name, title, words) in [
            (&classes, "accuracy", "accuracy %", "accuracy"),
            (&classes, "f1", "F1 %", "macro-F1"),
            (&classes, "brier", "Brier score", "Brier score"),
            (&force_task(), "rmse", "RMSE N", "RMSE"),
            (&force_task(), "r2", "R²", "R²"),
            (&Task::Values(vec![]), "mae", "MAE", "MAE"),
        ] {
            let metric = Metric::named(task, name).unwrap();
            assert_eq!((metric.with_unit(task).as_str(), metric.in_words()), (title, words));
        }
    }

    #[test]
    fn probabilities_are_judged_by_their_own_metrics() {
        let classes = ["a".to_string(), "b".into()];
        let targets = Targets::classes(&classes, &[0, 1, 1]);
        let said = vec![0.9, 0.1, 0.2, 0.8, 0.6, 0.4];
        let (task, truth) = (targets.task(), [0, 1, 1]);
        let outcome = Outcome::new(&targets, &[0, 1, 2], said.clone());
        let value = |name: &str| Metric::named(&task, name).unwrap().of(&task, &outcome).unwrap();
        let error = calibration_error(&said, &truth, 2, BINS).unwrap();
        assert_eq!((value("calibration_error"), value("brier")), (error, brier(&said, &truth, 2).unwrap()));
        assert_eq!(outcome.loss(&task).unwrap(), log_loss(&said, &truth, 2).unwrap());
        assert_eq!(outcome.outputs(), said);
        let values = Targets::Values(Values::new(force(), vec![1.0, 2.0]));
        assert_eq!(Outcome::new(&values, &[0, 1], vec![3.0, 4.0]).outputs(), [3.0, 4.0]);
    }
}
