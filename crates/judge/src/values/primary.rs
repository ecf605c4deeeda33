//! The metric that methods are compared by.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use taxel_data::Task;
use taxel_learn::metrics::{Direction, Metric, MetricUnit};
use taxel_report::numbers::{digits, tenth};

/// The primary metric of a task with its unit: names columns, says values in words, orders them.
///
/// ```
/// use taxel_data::{Quantity, Task};
/// use taxel_judge::Primary;
///
/// let force = Quantity { name: "force".into(), unit: Some("N".into()) };
/// let primary = Primary::of(&Task::Values(vec![force]));
/// assert_eq!((primary.head().as_str(), primary.column("low").as_str()), ("MAE N", "mae_low"));
/// assert!(primary.prefers(0.4, 0.5));
/// assert_eq!(primary.loss(0.25), 0.25);
/// assert_eq!(Primary::default().column("low"), "accuracy_low_percent");
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Named", into = "Named")]
pub struct Primary {
    metric: &'static Metric,
    unit: Option<String>,
}

/// How it is written.
#[derive(Serialize, Deserialize)]
struct Named {
    metric: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
}

impl TryFrom<Named> for Primary {
    type Error = String;

    fn try_from(named: Named) -> Result<Self, String> {
        let tasks = [Task::Classes(vec![]), Task::Values(vec![])];
        let metric = tasks.iter().find_map(|task| Metric::named(task, &named.metric));
        let metric = metric.ok_or_else(|| format!("{:?} is no metric", named.metric))?;
        Ok(Primary { metric, unit: named.unit })
    }
}

impl From<Primary> for Named {
    fn from(primary: Primary) -> Self {
        Named { metric: primary.metric.name.into(), unit: primary.unit }
    }
}

/// Accuracy, the primary metric of classes.
impl Default for Primary {
    fn default() -> Self {
        Primary::of(&Task::Classes(vec![]))
    }
}

impl Eq for Primary {}

impl Hash for Primary {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.metric.name, &self.unit).hash(state);
    }
}

impl PartialEq for Primary {
    fn eq(&self, other: &Self) -> bool {
        (self.metric.name, &self.unit) == (other.metric.name, &other.unit)
    }
}

impl Primary {
    /// Returns the primary metric of `task`, with the unit of its first quantity.
    pub fn of(task: &Task) -> Self {
        let metric = Metric::primary(task);
        Primary { metric, unit: metric.unit_of(task) }
    }

    /// Returns the metric.
    pub fn metric(&self) -> &'static Metric {
        self.metric
    }

    /// Checks whether it is accuracy: files of classes do not name it.
    pub fn is_accuracy(&self) -> bool {
        *self == Primary::default()
    }

    /// Checks whether it is a percentage, differences of which are percentage points.
    pub fn is_percent(&self) -> bool {
        self.metric.unit == MetricUnit::Percent
    }

    /// Checks whether `a` is better than `b`.
    pub fn prefers(&self, a: f64, b: f64) -> bool {
        self.metric.prefers(a, b)
    }

    /// Returns by how much `a` is worse than `b`: above 0 where it is.
    pub fn worsening(&self, a: f64, b: f64) -> f64 {
        self.metric.worsening(a, b)
    }

    /// Returns a number that is higher for a better value.
    pub fn merit(&self, value: f64) -> f64 {
        match self.metric.direction {
            Direction::Higher => value,
            Direction::Lower => -value,
        }
    }

    /// Orders values, the better one as the greater.
    pub fn order(&self, a: f64, b: f64) -> Ordering {
        self.merit(a).total_cmp(&self.merit(b))
    }

    /// Returns what a difference, one's value less another's, loses: above 0 where the one is worse.
    pub fn loss(&self, difference: f64) -> f64 {
        -self.merit(difference)
    }

    /// Returns the interval of the loss from that of the difference.
    pub fn losses(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let (a, b) = (self.loss(low), self.loss(high));
        if a > b { [b, a] } else { [a, b] }
    }

    /// Returns `points` percentage points in its unit: of a metric in the unit of a quantity so many percent of
    /// `chance`, which knowing nothing scores.
    pub fn share(&self, points: f64, chance: f64) -> f64 {
        if self.is_percent() { points } else { points / 100.0 * chance.abs() }
    }

    /// Returns how far a value is from perfect: what is missing of 100 %, or the error itself. None where the metric is
    /// neither.
    pub fn error(&self, value: f64) -> Option<f64> {
        match self.metric.direction {
            Direction::Lower => Some(value),
            Direction::Higher => self.is_percent().then_some(100.0 - value),
        }
    }

    /// Returns the least and the highest value that it can have.
    pub fn range(&self) -> (f64, f64) {
        match self.metric.unit {
            MetricUnit::Percent => (0.0, 100.0),
            MetricUnit::Quantity | MetricUnit::Range | MetricUnit::Seconds | MetricUnit::Steps => {
                (0.0, f64::INFINITY)
            }
            MetricUnit::Number => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    /// Returns its values within what is possible.
    pub fn clamped(&self, interval: [f64; 2]) -> [f64; 2] {
        let (least, most) = self.range();
        interval.map(|bound| bound.clamp(least, most))
    }

    /// Returns its differences within what is possible.
    pub fn clamped_difference(&self, interval: [f64; 2]) -> [f64; 2] {
        if self.is_percent() { interval.map(|bound| bound.clamp(-100.0, 100.0)) } else { interval }
    }

    /// Returns its name in files: `accuracy`, `mae`.
    pub fn name(&self) -> &'static str {
        self.metric.name
    }

    /// Returns its name in a sentence: `accuracy`, `MAE`.
    pub fn title(&self) -> &'static str {
        self.metric.title
    }

    /// Returns its name at the beginning of a sentence: `Accuracy`, `MAE`.
    pub fn heading(&self) -> String {
        let mut letters = self.title().chars();
        letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
    }

    /// Returns its unit: `%`, `N`; empty where it has none.
    pub fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or_default()
    }

    /// Returns the head of a column: `accuracy %`, `MAE N`.
    pub fn head(&self) -> String {
        format!("{} {}", self.title(), self.unit()).trim_end().into()
    }

    /// Returns the title of an axis: `accuracy (%)`, `MAE (N)`.
    pub fn axis(&self) -> String {
        match self.unit.as_deref() {
            Some(unit) => format!("{} ({unit})", self.title()),
            None => self.title().into(),
        }
    }

    /// Returns the title of an axis at the beginning of a sentence: `Accuracy (%)`.
    pub fn axis_begins(&self) -> String {
        self.axis().replacen(self.title(), &self.heading(), 1)
    }

    /// Returns `head` with the unit of a difference behind it: `mean loss, pp`, `mean loss, N`.
    pub fn head_of_loss(&self, head: &str) -> String {
        match (self.is_percent(), self.unit.as_deref()) {
            (true, _) => format!("{head}, pp"),
            (false, Some(unit)) => format!("{head}, {unit}"),
            (false, None) => head.into(),
        }
    }

    /// Returns `head` with its unit behind it: `clean %`, `clean N`.
    pub fn head_of(&self, head: &str) -> String {
        format!("{head} {}", self.unit()).trim_end().into()
    }

    /// Returns the name of a CSV column of its values: `accuracy_low_percent`, `mae_low`; without `what` of the value
    /// itself.
    pub fn column(&self, what: &str) -> String {
        let name = if what.is_empty() { self.name().into() } else { format!("{}_{what}", self.name()) };
        if self.is_percent() { format!("{name}_percent") } else { name }
    }

    /// Returns the name of a CSV column of differences: `loss_points`, `loss`.
    pub fn column_of_loss(&self, name: &str) -> String {
        if self.is_percent() { format!("{name}_points") } else { name.into() }
    }

    /// Returns how tables show its numbers.
    pub fn show(&self) -> fn(f64) -> String {
        if self.is_percent() { tenth } else { digits }
    }

    /// Returns how terminals show its numbers, with one digit more.
    pub fn show_longer(&self) -> fn(f64) -> String {
        if self.is_percent() { |value| format!("{value:.2}") } else { digits }
    }

    /// Returns how its differences are shown, with their sign.
    pub fn show_signed(&self) -> fn(f64) -> String {
        if self.is_percent() {
            |value| format!("{value:+.1}")
        } else {
            |value| format!("{}{}", if value < 0.0 { "" } else { "+" }, digits(value))
        }
    }

    /// Returns a value with its unit: `93.5 %`, `0.412 N`.
    pub fn value(&self, value: f64) -> String {
        format!("{} {}", self.show()(value), self.unit()).trim_end().into()
    }

    /// Returns a value with the name of the metric where the unit does not say it: `93.5 %`, `MAE 0.412 N`.
    pub fn named_value(&self, value: f64) -> String {
        if self.is_percent() { self.value(value) } else { format!("{} {}", self.title(), self.value(value)) }
    }

    /// Returns what the numbers of differences are called: `points`, `N`.
    pub fn points(&self) -> &str {
        if self.is_percent() { "points" } else { self.unit() }
    }

    /// Returns a printed difference with its unit: `3.1 points`, `0.12 N`.
    pub fn with_points(&self, number: &str) -> String {
        format!("{number} {}", self.points()).trim_end().into()
    }

    /// Returns a margin as it was given: `5 points`, `0.0213 N`.
    pub fn margin(&self, margin: f64) -> String {
        self.with_points(&if self.is_percent() { margin.to_string() } else { digits(margin) })
    }

    /// Returns a difference with its unit, without a minus of a rounded zero: `3.1 points`, `0.12 N`.
    pub fn difference(&self, value: f64) -> String {
        self.with_points(&self.show()(value))
    }

    /// Returns what losses are counted in, in a sentence: `percentage points`, `N`.
    pub fn in_points(&self) -> String {
        match (self.is_percent(), self.unit.as_deref()) {
            (true, _) => "percentage points".into(),
            (false, Some(unit)) => unit.into(),
            (false, None) => format!("units of {}", self.title()),
        }
    }

    /// Returns what is lost, at the beginning of a sentence or within: accuracy goes down, an error goes up.
    pub fn lost(&self, begins: bool) -> String {
        let title = if begins { self.heading() } else { self.title().into() };
        match self.metric.direction {
            Direction::Higher => format!("{title} lost"),
            Direction::Lower => format!("{title} added"),
        }
    }

    /// Returns what knowing nothing of the sample scores: chance, or of values the error of the mean.
    pub fn chance(&self) -> &'static str {
        if self.is_percent() { "chance" } else { "error of the mean" }
    }

    /// Returns the same at the beginning of a sentence.
    pub fn chance_heading(&self) -> &'static str {
        if self.is_percent() { "Chance" } else { "Error of the mean" }
    }

    /// Returns what a method is better by than knowing nothing.
    pub fn margin_of_chance(&self) -> &'static str {
        if self.is_percent() { "margin above chance" } else { "margin below the error of the mean" }
    }

    /// Returns the parts of which a learning curve takes so many samples each.
    pub fn stratum(&self) -> &'static str {
        if self.is_percent() { "class" } else { "part of the range" }
    }

    /// Returns what a method does that knows nothing of the sample.
    pub fn knowing_nothing(&self) -> &'static str {
        if self.is_percent() { "always naming the commonest class" } else { "always giving the mean" }
    }
}

/// Returns JSON for other programs, its keys named after the metric that each part says it is in (`primary`): of values
/// `accuracy` becomes `mae`. Files that are read again keep one key for all metrics.
///
/// # Errors
/// A value that is no JSON.
pub fn named_scores(value: &impl Serialize) -> serde_json::Result<Value> {
    // By text: a value of f32 keeps its digits.
    let value = serde_json::from_str(&serde_json::to_string(value)?)?;
    Ok(named(value, Primary::default().name()))
}

fn named(value: Value, metric: &str) -> Value {
    match value {
        Value::Array(all) => all.into_iter().map(|value| named(value, metric)).collect(),
        Value::Object(map) => {
            let recorded =
                map.get("primary").and_then(|primary| primary["metric"].as_str()).map(str::to_string);
            let metric = recorded.as_deref().unwrap_or(metric);
            let key = |key: String| match key.strip_prefix("accuracy") {
                Some(rest) if rest.is_empty() || rest.starts_with('_') => format!("{metric}{rest}"),
                _ => key,
            };
            map.into_iter().map(|(name, value)| (key(name), named(value, metric))).collect()
        }
        plain => plain,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn keys_are_named_after_the_metric() {
        let of = |primary: Value| json!({"primary": primary, "all": [{"accuracy": 1.0, "accuracy_interval": [0.5, 2.0]}]});
        let mae = json!({"metric": "mae", "unit": "N"});
        let want = json!({"primary": mae, "all": [{"mae": 1.0, "mae_interval": [0.5, 2.0]}]});
        assert_eq!(named_scores(&of(mae)).unwrap(), want);
        assert_eq!(named_scores(&of(Value::Null)).unwrap(), of(Value::Null));
    }

    #[test]
    fn losses_are_above_0_where_a_score_is_worse() {
        let quantity = taxel_data::Quantity { name: "force".into(), unit: Some("N".into()) };
        let (mae, accuracy) = (Primary::of(&Task::Values(vec![quantity])), Primary::default());
        assert_eq!((mae.loss(0.5), accuracy.loss(0.5)), (0.5, -0.5));
        assert_eq!((mae.losses([-1.0, 2.0]), accuracy.losses([-1.0, 2.0])), ([-1.0, 2.0], [-2.0, 1.0]));
        assert_eq!((mae.chance(), accuracy.margin_of_chance()), ("error of the mean", "margin above chance"));
        assert_eq!((mae.share(5.0, 2.0), accuracy.share(5.0, 50.0)), (0.1, 5.0));
        assert_eq!((mae.value(0.4121), accuracy.value(93.52)), ("0.412 N".into(), "93.5 %".into()));
    }
}
