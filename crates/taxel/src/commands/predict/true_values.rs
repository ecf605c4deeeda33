//! True values of predicted recordings, where their files hold them.

use taxel::Predictions;
use taxel::base::thousands;
use taxel::data::{Targets, Task, Values};
use taxel::learn::metrics::{Metric, Outcome, metrics};

/// True values of recordings, in the order of a model's quantities.
pub struct TrueValues {
    values: Values,
}

impl TrueValues {
    /// Takes `values` that are the quantities of `task`, by name and unit. Values without a name of their own are those of a task of one
    /// quantity.
    ///
    /// # Errors
    /// Says what differs, where they are other quantities.
    pub fn new(task: &Task, values: &Values) -> Result<Self, String> {
        let wanted = task.quantities();
        let ordered = values.of_quantities(wanted);
        let refuse = |here: String| {
            let wanted = wanted.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            format!("the recordings have values of {here}, and the model answers {wanted}: nothing is scored")
        };
        Ok(TrueValues { values: ordered.map_err(refuse)? })
    }

    /// Returns all of them.
    #[cfg(feature = "lab")]
    pub fn into_values(self) -> Values {
        self.values
    }

    /// Returns the values of sample `i`; none where one is not known.
    pub fn of(&self, i: usize) -> Option<Vec<f32>> {
        Some(self.values.of(&[i])).filter(|row| row.iter().all(|value| value.is_finite()))
    }

    /// Prints one value of sample `i`, as a cell of a table.
    pub fn cell(&self, i: usize, quantity: usize) -> String {
        self.of(i).map_or(String::new(), |row| format!("{:.3}", row[quantity]))
    }

    /// Says how far off the predictions are, by the metrics of the task.
    pub fn score(&self, predictions: &Predictions) -> Option<String> {
        let known: Vec<usize> = (0..predictions.len()).filter(|i| self.of(*i).is_some()).collect();
        let said = known.iter().flat_map(|i| predictions.row(*i)).copied().collect();
        let targets = Targets::Values(self.values.clone());
        let (task, outcome) = (targets.task(), Outcome::new(&targets, &known, said));
        let shown = metrics(&task).iter().filter(|metric| metric.is_shown);
        let of = |metric: &Metric| {
            let value = metric.of(&task, &outcome).ok()?;
            let unit = metric.unit_of(&task).map_or(String::new(), |unit| format!(" {unit}"));
            Some(format!("{} {value:.3}{unit}", metric.title))
        };
        let scores: Vec<String> = shown.filter_map(of).collect();
        let count = thousands(known.len() as u64);
        (!known.is_empty()).then(|| format!("{} over {count} samples", scores.join(", ")))
    }
}
