//! The result table: aligned text, Markdown, JSON.
//!
//! Measured scores and those that authors report on their data never share a column.

use std::fmt;

use serde_json::{Value, json};
use taxel_base::{Grid, thousands};
use taxel_data::Task;

use crate::error::Result;
use crate::latency::Latency;
use crate::metrics::{Metric, MetricUnit, Scores, shown};
use crate::run::folder::RunFolder;
use crate::run::results::{NetworkResults, Results};
use crate::training::recipe::BatchNorm;

/// The table of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultsTable {
    caption: Vec<String>,
    grid: Grid,
    json: Value,
}

impl ResultsTable {
    /// Makes the table of a run folder.
    ///
    /// # Errors
    /// A damaged file in it.
    pub fn of(folder: &RunFolder) -> Result<Self> {
        let timings = folder.timings()?;
        let latency = |network: &str| {
            timings.iter().filter(|t| t.key.network == network).find_map(|timing| timing.latency)
        };
        Ok(Self::new(&folder.results()?, latency))
    }

    /// Makes the table of `results`, with the latency of each network where it was measured.
    pub fn new(results: &Results, latency: impl Fn(&str) -> Option<Latency>) -> Self {
        let latencies: Vec<Option<Latency>> = results.networks.iter().map(|n| latency(&n.network)).collect();
        let networks: Vec<Value> = results
            .networks
            .iter()
            .zip(&latencies)
            .map(|(network, latency)| object(network, *latency))
            .collect();
        let json = json!({
            "name": results.name,
            "complete": results.complete,
            "missing_folds": results.missing.len(),
            "source": results.source,
            "samples": results.samples,
            "classes": results.task.output_names(),
            "protocol": results.protocol,
            "left_out": results.left_out,
            "shortcut": results.shortcut,
            "leaks": results.leaks,
            "seed": results.seed,
            "unit": results.unit,
            "networks": networks,
        });
        ResultsTable { caption: caption(results), grid: grid(results, &latencies), json }
    }

    /// Returns the same numbers as one JSON object.
    pub fn json(&self) -> &Value {
        &self.json
    }

    /// Returns the table in Markdown, with its caption above.
    pub fn markdown(&self) -> String {
        format!("{}\n\n{}", self.caption.join("  \n"), self.grid.markdown())
    }
}

impl fmt::Display for ResultsTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in &self.caption {
            writeln!(f, "{line}")?;
        }
        write!(f, "\n{}", self.grid)
    }
}

/// Makes one row per network, names to the left and numbers to the right.
fn grid(results: &Results, latencies: &[Option<Latency>]) -> Grid {
    let mut grid = Grid::new().left("network");
    let shown = shown(&results.task, results.networks.iter().filter_map(|network| network.mean.as_ref()));
    let titles = shown.iter().map(|metric| match metric.unit {
        MetricUnit::Quantity | MetricUnit::Seconds | MetricUnit::Steps => metric.with_unit(&results.task),
        MetricUnit::Percent | MetricUnit::Number | MetricUnit::Range => metric.title.to_string(),
    });
    for head in ["parameters", "MACs"].map(String::from).into_iter().chain(titles) {
        grid = grid.right(head);
    }
    let attributes = match &results.task {
        Task::Levels(attributes) => attributes.as_slice(),
        Task::Classes(_) | Task::Values(_) => &[],
    };
    for attribute in attributes {
        grid = grid.right(&attribute.name).right(format!("{} off by", attribute.name));
    }
    grid = grid.right("latency ms");
    let published = results.networks.iter().any(|n| n.published.is_some());
    let papers = papers(results);
    if published {
        grid = grid.right(match papers.as_slice() {
            [one] => format!("published ({one}, own data)"),
            _ => "published (own data)".into(),
        });
    }
    for (network, latency) in results.networks.iter().zip(latencies) {
        let name = if network.diverged > 0 { " (diverged)" } else { "" };
        let mut row = vec![
            format!("{}{name}", network.network),
            thousands(network.costs.parameters),
            thousands(network.costs.macs),
        ];
        row.extend(shown.iter().map(|metric| score(network, metric)));
        for i in 0..attributes.len() {
            row.extend(match network.attributes.get(i) {
                Some(scores) => {
                    let accuracy = 100.0 * scores.scores.accuracy;
                    [format!("{accuracy:.2}"), format!("{:.2}", scores.mean_absolute_error)]
                }
                None => ["-".into(), "-".into()],
            });
        }
        row.push(latency.map_or("-".into(), |l| format!("{:.3}", l.p50_ms)));
        if published {
            row.push(published_cell(network, papers.len() > 1));
        }
        grid.row(row);
    }
    grid
}

fn object(network: &NetworkResults, latency: Option<Latency>) -> Value {
    json!({
        "network": network.network,
        "parameters": network.costs.parameters,
        "bytes": network.costs.bytes,
        "macs": network.costs.macs,
        "flops": network.costs.flops,
        "folds": network.folds.len(),
        "diverged": network.diverged,
        "per_class": network.per_class,
        "measured": {
            "mean": network.mean,
            "sd": network.sd,
            "interval": network.interval,
            "attributes": network.attributes,
        },
        "other_statistics": network.other_statistics,
        "latency_p50_ms": latency.map(|l| l.p50_ms),
        "latency_p95_ms": latency.map(|l| l.p95_ms),
        "published_on_own_data": network.published,
    })
}

fn caption(results: &Results) -> Vec<String> {
    let in_percent = if results.primary().unit == MetricUnit::Percent { " in %" } else { "" };
    let title = results.title.as_ref().map_or(String::new(), |title| format!(": {title}"));
    let mut lines = vec![
        format!("{}{title}", results.name),
        format!(
            "measured on: {} ({} samples, {}), {}, seed {}",
            results.source,
            results.samples,
            results.task.counted(),
            results.protocol.words(&results.task),
            results.seed
        ),
        format!(
            "scores{in_percent}, mean ± SD over folds (n - 1); latency: median of one sample, \
             from raw values to the answer, one thread"
        ),
    ];
    for (baseline, reason) in &results.left_out {
        lines.push(format!("left out: {baseline}: {reason}"));
    }
    lines.extend(results.batch_norm_words());
    lines.extend(results.leaks.iter().map(|leak| format!("mind: {leak}")));
    if let Some(shortcut) = &results.shortcut {
        lines.push(format!("mind: {shortcut}: confounded?"));
    }
    if let Some(words) = results.diverged_words() {
        lines.push(format!("diverged: {words}: their scores say nothing; lower the learning rate"));
    }
    match results.unfinished() {
        0 => {}
        folds => lines.push(format!("INCOMPLETE: {folds} folds are missing; resume the run")),
    }
    lines
}

impl Results {
    /// Lists the networks of which some training diverged, as `wild in 3 folds`; `None` where there are none.
    pub fn diverged_words(&self) -> Option<String> {
        let diverged = self.networks.iter().filter(|network| network.diverged > 0);
        let words: Vec<String> = diverged.map(|n| format!("{} in {} folds", n.network, n.diverged)).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// Folds that resuming the run would finish: missing, and not because their training diverged.
    pub fn unfinished(&self) -> usize {
        self.missing.len().saturating_sub(self.networks.iter().map(NetworkResults::stopped).sum())
    }

    /// Returns the effect of the choice of batch-norm statistics, a line per kind.
    pub fn batch_norm_words(&self) -> Vec<String> {
        let name = self.primary().name;
        let line = |kind: BatchNorm| {
            let changes = self.networks.iter().filter_map(|n| {
                let other = n.other_statistics.filter(|other| other.batch_norm == kind)?;
                let change = other.score - n.mean.as_ref()?.get(name)?;
                Some(format!("{} {:.2} ({change:+.2})", n.network, other.score))
            });
            let changes: Vec<String> = changes.collect();
            let words =
                || format!("{name} with {} batch-norm statistics: {}", kind.name(), changes.join(", "));
            (!changes.is_empty()).then(words)
        };
        [BatchNorm::Running, BatchNorm::Recomputed].into_iter().filter_map(line).collect()
    }
}

/// Papers that published numbers come from, each once.
fn papers(results: &Results) -> Vec<&str> {
    let mut papers = vec![];
    for published in results.networks.iter().filter_map(|n| n.published.as_ref()) {
        let paper = published.table.split(',').next().unwrap_or_default().trim();
        if !papers.contains(&paper) {
            papers.push(paper);
        }
    }
    papers
}

fn score(network: &NetworkResults, metric: &Metric) -> String {
    let of = |scores: &Option<Scores>| scores.as_ref().and_then(|scores| scores.get(metric.name));
    match (of(&network.mean), of(&network.sd)) {
        (Some(mean), Some(sd)) => format!("{mean:.2} ± {sd:.2}"),
        (Some(mean), None) => format!("{mean:.2}"),
        _ => "-".into(),
    }
}

fn published_cell(network: &NetworkResults, name_paper: bool) -> String {
    match &network.published {
        None => "-".into(),
        Some(published) => {
            let spread = match published.accuracy[..] {
                [mean, sd] => format!("{mean:.2} ± {sd:.2}"),
                [mean] => format!("{mean:.2}"),
                _ => "-".into(),
            };
            let paper = if name_paper { format!(" [{}]", published.table) } else { String::new() };
            format!("{spread}{paper}")
        }
    }
}
