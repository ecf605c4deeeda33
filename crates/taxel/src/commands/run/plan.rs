//! `taxel run --plan`: what a run would cost, before anything is trained.

use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use taxel::Experiment;
use taxel::base::Grid;
use taxel::experiment::{RowCost, Runner};
use taxel::shrink::curve_folds;

use crate::commands::shrink::time_words;
use crate::outln;

/// A run and its learning curve before they begin.
pub struct PlannedRun {
    name: String,
    source: String,
    protocol: String,
    samples: usize,
    threads: usize,
    rows: Vec<RowCost>,
    /// Trainings of a learning curve; or why there can be none.
    curve: Result<usize, String>,
    /// Whether rows are trained again without some classes.
    has_unknown: bool,
}

impl PlannedRun {
    /// Counts the trainings of an experiment, and tries each method for a moment.
    ///
    /// # Errors
    /// Samples that the experiment cannot learn from.
    pub fn of(runner: &Runner, threads: usize, cancel: &AtomicBool) -> taxel::experiment::Result<Self> {
        let (config, dataset) = (runner.experiment.config(), runner.dataset);
        let folds = curve_folds(dataset, &config.protocol, config.seed);
        let (curve, folds) = match folds {
            Ok(folds) => (Ok(folds.len()), folds),
            Err(error) => (Err(error.to_string()), vec![]),
        };
        Ok(PlannedRun {
            name: config.name.clone(),
            source: dataset.source.to_string(),
            protocol: config.protocol.words(&dataset.task()),
            samples: dataset.len(),
            threads,
            rows: runner.costs(&folds, cancel)?,
            curve,
            has_unknown: config.unknown.is_some(),
        })
    }

    fn trainings(&self) -> usize {
        self.rows.iter().map(|row| row.trainings).sum()
    }

    /// Returns the seconds of all rows that could be tried.
    fn seconds(&self) -> f64 {
        self.rows.iter().filter_map(|row| row.seconds).sum::<f64>() / self.threads as f64
    }

    /// Returns the least and the most seconds of a learning curve, which is one of the row that will be taken.
    fn of_curve(&self) -> Option<[f64; 2]> {
        let seconds = self.rows.iter().filter_map(|row| Some(row.further? / self.threads as f64));
        let ends = seconds.fold([f64::INFINITY, 0.0], |[low, high], one| [one.min(low), one.max(high)]);
        (ends[0] <= ends[1]).then_some(ends)
    }

    pub fn json(&self) -> Value {
        let rows = self.rows.iter().map(|row| {
            json!({ "network": row.network, "trainings": row.trainings,
                "seconds": row.seconds.map(|seconds| seconds / self.threads as f64) })
        });
        let curve = match &self.curve {
            Ok(trainings) => json!({ "trainings": trainings, "seconds": self.of_curve() }),
            Err(reason) => json!({ "refused": reason }),
        };
        json!({
            "name": self.name, "source": self.source, "samples": self.samples, "protocol": self.protocol,
            "threads": self.threads, "rows": rows.collect::<Vec<_>>(), "seconds": self.seconds(),
            "trainings": self.trainings(), "learning_curve": curve,
        })
    }

    pub fn print(&self) {
        outln!("{}: {} ({} samples), {}\n", self.name, self.source, self.samples, self.protocol);
        let about = |seconds: Option<f64>| {
            seconds.map_or("cannot be tried".into(), |seconds| time_words(seconds / self.threads as f64))
        };
        let mut grid = Grid::new().left("network").right("trainings").right("about");
        for row in &self.rows {
            grid.row([row.network.clone(), row.trainings.to_string(), about(row.seconds)]);
        }
        outln!("{}", grid.ruled());
        let trainings = self.trainings();
        let threads =
            if self.threads == 1 { "one thread".into() } else { format!("{} threads", self.threads) };
        outln!(
            "the run: {trainings} trainings, about {} on {threads}, tests not counted",
            time_words(self.seconds())
        );
        if self.has_unknown {
            outln!("[unknown] trains rows again without some classes, which is not counted");
        }
        match (&self.curve, self.of_curve()) {
            (Err(reason), _) => outln!("no learning curve: {reason}"),
            (Ok(_), None) => {}
            (Ok(trainings), Some([low, high])) => outln!(
                "its learning curve (taxel report --learning-curve): {trainings} trainings of the row that is taken, {} to {}",
                time_words(low),
                time_words(high)
            ),
        }
    }
}

/// Prints the costs of each experiment.
///
/// # Errors
/// As [`PlannedRun::of`].
pub fn print_plans(
    experiments: &[Experiment],
    registry: &taxel::Registry,
    (threads, is_json): (usize, bool),
    cancel: &AtomicBool,
) -> Result<(), Box<dyn std::error::Error>> {
    for experiment in experiments {
        let dataset = experiment.dataset()?;
        let plan = PlannedRun::of(&Runner { experiment, registry, dataset: &dataset }, threads, cancel)?;
        if is_json {
            outln!("{}", serde_json::to_string(&plan.json())?);
        } else {
            plan.print();
        }
    }
    Ok(())
}
