//! `taxel choose`: the smallest network that suffices.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum, ValueHint};
use taxel::judge::{Across, Choice, CostKind, Criteria, Evidence, Judgement, across, choose, named_scores};
use taxel::reporting::open;

use crate::CommandResult;
use crate::commands::arguments::bytes::bytes;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::threads::Threads;
use crate::commands::judging::{judgement, stress_options};
use crate::terminal::signals::leave_with;
use crate::terminal::tables;
use crate::{out, outln};

/// Names the smallest network of a run that is accurate enough, with the evidence.
///
/// A network suffices if it is not significantly worse than the most accurate one: by the corrected
/// resampled t-test over folds and repetitions (Nadeau and Bengio). With one or two folds, McNemar's exact test over
/// all test samples is used, of grouped samples a test on their groups. Holm's correction is over the table. Of those
/// the fastest (or smallest) is chosen; baselines take part. Nothing that seems to lose more than --margin points is
/// chosen, and where the data could not have seen such a loss, it says so. Runs on values are compared by their mean
/// absolute error (with one or two folds by Wilcoxon's signed-rank test), losses are in its unit.
///
/// Methods that lose half of their margin above chance at severity 1 of a common fault (noise, drift, gain, dead, jitter) are
/// chosen only where nothing steadier suffices, unless --clean-only. That needs faults measured: by taxel report.
///
/// With --max-flash or --max-ram only what fits a microcontroller with FPU as C is chosen: networks in floats or in eight bits (`taxel
/// quantize RUN` adds those), MiniRocket and ridge. What does not fit is named with its bytes (docs/firmware.md).
///
/// Speed is measured on this machine unless the run folder holds a judgement.json; --max-loss corrupts test
/// samples on purpose first. Five or more RUNs that share networks are ranked together too (Friedman, with
/// Nemenyi's critical difference).
///
/// Exit code 0: something is chosen for every run; 1: for some run nothing suffices.
#[derive(Args)]
#[command(after_help = "Examples:  taxel choose runs/quickstart
           taxel choose runs/quickstart --by size --margin 2
           taxel choose runs/quickstart --max-loss 20
           taxel choose runs/glove --max-flash 64k --max-ram 16k
           taxel choose runs/ucr-* --format json > choices.json")]
pub struct Choose {
    /// Run folders.
    #[arg(required = true, value_hint = ValueHint::DirPath)]
    run: Vec<PathBuf>,
    /// The cost that is to be small: time per sample on one thread, bytes, or multiply-accumulates.
    #[arg(long, value_enum, value_name = "COST", default_value = "latency")]
    by: By,
    /// Level of significance of all comparisons together, between 0 and 1.
    #[arg(long, value_name = "ALPHA", default_value_t = 0.05)]
    alpha: f64,
    /// The most accuracy that faults may cost on average, in percentage points; of values in the unit of the error.
    #[arg(long, value_name = "POINTS")]
    max_loss: Option<f64>,
    /// A loss of accuracy that would matter, in percentage points; of values in the unit of the error [default: 5; of
    /// values 5 % of the error of always giving the mean].
    #[arg(long, value_name = "POINTS")]
    margin: Option<f64>,
    /// Chooses by clean samples alone, whatever common faults do.
    #[arg(long)]
    clean_only: bool,
    /// Flash of a microcontroller that it has to fit as C, code and tables: 64k, 1M, or bytes.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    max_flash: Option<u64>,
    /// RAM of a microcontroller that it has to fit as C, workspace and time steps: 16k, or bytes. Stack is left out.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    max_ram: Option<u64>,
    #[command(flatten)]
    format: OutputFormat,
    #[command(flatten)]
    threads: Threads,
}

#[derive(Clone, Copy, ValueEnum)]
enum By {
    Latency,
    Size,
    Macs,
}

impl Choose {
    pub fn run(self) -> CommandResult {
        let cost = match self.by {
            By::Latency => CostKind::Latency,
            By::Size => CostKind::Size,
            By::Macs => CostKind::Macs,
        };
        let Choose { alpha, max_loss, margin, clean_only, max_flash, max_ram, .. } = self;
        let mut criteria = Criteria { cost, alpha, max_loss, margin, clean_only, room: None };
        leave_with("stopped; what was measured is in judgement.json: the same command goes on")?;
        let stress = match criteria.max_loss {
            Some(_) => Some(stress_options(self.threads.count()?)),
            None => None,
        };
        let (mut judgements, mut choices) = (vec![], vec![]);
        for path in &self.run {
            let case = open(path)?;
            if max_flash.or(max_ram).is_some() {
                criteria.room = Some(taxel::room(&case, max_flash, max_ram)?);
            }
            criteria.check(&case.primary())?;
            let judgement = judgement(&case, stress.clone())?;
            let choice = choose(&case, &judgement, &criteria)?;
            judgements.push(judgement);
            choices.push(choice);
        }
        let ranked = across(&judgements.iter().collect::<Vec<_>>(), criteria.alpha)?;
        if self.format.is_json() {
            let one = |(run, choice): (&PathBuf, &Choice)| serde_json::json!({"run": run.display().to_string(), "choice": choice});
            let runs: Vec<_> = self.run.iter().zip(&choices).map(one).collect();
            let all = serde_json::json!({"choices": runs, "across": ranked});
            outln!("{}", serde_json::to_string_pretty(&named_scores(&all)?)?);
        } else {
            for ((path, judgement), choice) in self.run.iter().zip(&judgements).zip(&choices) {
                print(path, judgement, choice);
            }
            if let Some(ranked) = &ranked {
                print_across(ranked);
            }
        }
        let all = choices.iter().all(|choice| choice.chosen.is_some());
        Ok(if all { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn print(path: &Path, judgement: &Judgement, choice: &Choice) {
    let results = &judgement.results;
    outln!("{}: {}, {}", path.display(), results.source, judgement.protocol);
    outln!();
    let unit = match choice.criteria.cost {
        CostKind::Latency => "ms",
        CostKind::Size => "kB",
        CostKind::Macs => "MACs",
    };
    let stressed = choice.evidence.iter().any(|network| network.mean_loss.is_some());
    let (primary, head) = (&choice.primary, choice.primary.head());
    let mut header = vec!["network", head.as_str(), "against best", "95 % interval", "p (Holm)", unit];
    if stressed {
        header.push("lost to faults");
    }
    header.push("");
    let mut evidence: Vec<&Evidence> = choice.evidence.iter().collect();
    evidence.sort_by(|a, b| primary.order(b.score, a.score));
    let rows: Vec<Vec<String>> = evidence.iter().map(|network| row(network, choice, stressed)).collect();
    let right: Vec<usize> = (1..header.len() - 1).collect();
    out!("{}", tables::table(&header, &rows, &right));
    outln!();
    for words in &choice.words {
        outln!("{words}");
    }
    outln!();
}

fn row(evidence: &Evidence, choice: &Choice, stressed: bool) -> Vec<String> {
    let dash = || "-".to_string();
    let best = evidence.network == choice.best;
    let (primary, longer) = (&choice.primary, choice.primary.show_longer());
    let signed = |value: f64| {
        if primary.is_percent() { format!("{value:+.2}") } else { primary.show_signed()(value) }
    };
    let cost = |cost: f64| match choice.criteria.cost {
        CostKind::Latency => format!("{cost:.3}"),
        CostKind::Size => format!("{:.1}", cost / 1e3),
        CostKind::Macs => format!("{cost:.0}"),
    };
    let mut cells = vec![
        evidence.network.clone(),
        longer(evidence.score),
        if best { dash() } else { signed(evidence.difference) },
        evidence.interval.map_or_else(dash, |[low, high]| format!("{} to {}", signed(low), signed(high))),
        evidence.p_holm.map_or_else(dash, |p| if p < 0.001 { "< 0.001".into() } else { format!("{p:.3}") }),
        evidence.cost.map_or_else(dash, cost),
    ];
    if stressed {
        cells.push(evidence.mean_loss.map_or_else(dash, primary.show()));
    }
    cells.push(match (&evidence.refused, evidence.worse) {
        _ if choice.chosen.as_ref() == Some(&evidence.network) => "chosen".into(),
        (_, true) => "worse".into(),
        (Some(reason), _) => reason.clone(),
        _ if best => "best".into(),
        _ => "not told apart from the best".into(),
    });
    cells
}

fn print_across(ranked: &Across) {
    outln!("{} data sets together: {}", ranked.runs.len(), ranked.runs.join(", "));
    outln!();
    let rows: Vec<Vec<String>> = (0..ranked.networks.len())
        .map(|at| {
            let p = ranked.p_holm[at].map_or("-".into(), |p| format!("{p:.3}"));
            let mean = ranked.scores.iter().map(|row| row[at]).sum::<f64>() / ranked.runs.len() as f64;
            let rank = ranked.friedman.ranks[at];
            let mean = ranked.primary.show_longer()(mean);
            vec![ranked.networks[at].clone(), format!("{rank:.2}"), mean, p]
        })
        .collect();
    let mean = format!("mean {}", ranked.primary.head());
    let header = ["network", "mean rank", &mean, "p (Wilcoxon, Holm)"];
    out!("{}", tables::table(&header, &rows, &[1, 2, 3]));
    outln!();
    outln!("critical difference of mean ranks at {}: {:.2}", ranked.alpha, ranked.critical_difference);
    for words in &ranked.words {
        outln!("{words}");
    }
}
