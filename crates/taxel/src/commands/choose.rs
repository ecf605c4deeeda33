//! `taxel choose`: the smallest network that suffices.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use taxel::judge::{Across, Choice, CostKind, Criteria, Evidence, Judgement, across, choose, named_scores};
use taxel::reporting::open;

use crate::commands::judging::{judgement, stress_options};
use crate::commands::signals::leave_with;
use crate::{Outcome, text};

/// Names the smallest network of a run that suffices, with the evidence.
///
/// A network suffices if it is not significantly worse than the most accurate one: by the corrected
/// resampled t-test over folds and repetitions (Nadeau and Bengio), or McNemar's exact test where there is
/// one test part, with Holm's correction over the table. Of those the fastest (or smallest) is chosen;
/// baselines take part. Nothing that seems to lose more than --margin points is chosen, and where the
/// data could not have seen such a loss, it says so. Runs on values are compared by their mean absolute error (on one
/// test part by Wilcoxon's signed-rank test), losses are in its unit.
///
/// Speed is measured on this machine unless the run folder holds a judgement.json; --max-loss breaks test
/// samples on purpose first. Five or more RUNs that share networks are ranked together too (Friedman, with
/// Nemenyi's critical difference).
///
/// Exit code 0: something is chosen for every run; 1: for some run nothing suffices.
#[derive(Args)]
#[command(after_help = "Examples:  taxel choose runs/quickstart
           taxel choose runs/quickstart --by size --margin 2
           taxel choose runs/quickstart --max-loss 20
           taxel choose runs/ucr-* --json > choices.json")]
pub struct Choose {
    /// Run folders.
    #[arg(required = true)]
    run: Vec<PathBuf>,
    /// What is to be small: time per sample on one thread, bytes, or multiply-accumulates.
    #[arg(long, value_enum, default_value = "latency")]
    by: Small,
    /// Level of significance over the whole table.
    #[arg(long, default_value_t = 0.05)]
    alpha: f64,
    /// The most accuracy that faults may cost on average, in percentage points; of values in the unit of the error.
    #[arg(long, value_name = "POINTS")]
    max_loss: Option<f64>,
    /// A loss of accuracy that would matter, in percentage points; of values in the unit of the error [default: 5; of
    /// values 5 % of the error of always giving the mean].
    #[arg(long, value_name = "POINTS")]
    margin: Option<f64>,
    /// Prints everything as one JSON object.
    #[arg(long)]
    json: bool,
    /// Caps the threads of the stress test [default: all cores]; results do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Small {
    Latency,
    Size,
    Macs,
}

impl Choose {
    pub fn run(self) -> Outcome {
        let cost = match self.by {
            Small::Latency => CostKind::Latency,
            Small::Size => CostKind::Size,
            Small::Macs => CostKind::Macs,
        };
        let criteria = Criteria { cost, alpha: self.alpha, max_loss: self.max_loss, margin: self.margin };
        leave_with("stopped; what was measured is in judgement.json: the same command goes on")?;
        let stress = criteria.max_loss.map(|_| stress_options(self.threads));
        let (mut judgements, mut choices) = (vec![], vec![]);
        for path in &self.run {
            let case = open(path)?;
            criteria.check(&case.primary())?;
            let judgement = judgement(&case, stress.clone())?;
            let choice = choose(&case, &judgement, &criteria)?;
            judgements.push(judgement);
            choices.push(choice);
        }
        let ranked = across(&judgements.iter().collect::<Vec<_>>(), criteria.alpha)?;
        if self.json {
            let one = |(run, choice): (&PathBuf, &Choice)| serde_json::json!({"run": run.display().to_string(), "choice": choice});
            let runs: Vec<_> = self.run.iter().zip(&choices).map(one).collect();
            let all = serde_json::json!({"choices": runs, "across": ranked});
            println!("{}", serde_json::to_string_pretty(&named_scores(&all)?)?);
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
    println!("{}: {}, {}", path.display(), results.source, judgement.protocol);
    println!();
    let unit = match choice.criteria.cost {
        CostKind::Latency => "ms",
        CostKind::Size => "kB",
        CostKind::Macs => "MACs",
    };
    let stressed = choice.evidence.iter().any(|own| own.mean_loss.is_some());
    let (primary, head) = (&choice.primary, choice.primary.head());
    let mut header = vec!["network", head.as_str(), "against best", "95 % interval", "p (Holm)", unit];
    if stressed {
        header.push("lost to faults");
    }
    header.push("");
    let mut evidence: Vec<&Evidence> = choice.evidence.iter().collect();
    evidence.sort_by(|a, b| primary.order(b.score, a.score));
    let rows: Vec<Vec<String>> = evidence.iter().map(|own| row(own, choice, stressed)).collect();
    let right: Vec<usize> = (1..header.len() - 1).collect();
    print!("{}", text::table(&header, &rows, &right));
    println!();
    for words in &choice.words {
        println!("{words}");
    }
    println!();
}

fn row(own: &Evidence, choice: &Choice, stressed: bool) -> Vec<String> {
    let dash = || "-".to_string();
    let best = own.network == choice.best;
    let (primary, longer) = (&choice.primary, choice.primary.show_longer());
    let signed = |value: f64| match primary.is_percent() {
        true => format!("{value:+.2}"),
        false => primary.show_signed()(value),
    };
    let cost = |cost: f64| match choice.criteria.cost {
        CostKind::Latency => format!("{cost:.3}"),
        CostKind::Size => format!("{:.1}", cost / 1e3),
        CostKind::Macs => format!("{cost:.0}"),
    };
    let mut cells = vec![
        own.network.clone(),
        longer(own.score),
        if best { dash() } else { signed(own.difference) },
        own.interval.map_or_else(dash, |[low, high]| format!("{} to {}", signed(low), signed(high))),
        own.p_holm.map_or_else(dash, |p| if p < 0.001 { "< 0.001".into() } else { format!("{p:.3}") }),
        own.cost.map_or_else(dash, cost),
    ];
    if stressed {
        cells.push(own.mean_loss.map_or_else(dash, primary.show()));
    }
    cells.push(match (&own.refused, own.worse) {
        _ if choice.chosen.as_ref() == Some(&own.network) => "chosen".into(),
        (_, true) => "worse".into(),
        (Some(reason), _) => reason.clone(),
        _ if best => "best".into(),
        _ => "not told apart from the best".into(),
    });
    cells
}

fn print_across(ranked: &Across) {
    println!("{} data sets together: {}", ranked.runs.len(), ranked.runs.join(", "));
    println!();
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
    print!("{}", text::table(&header, &rows, &[1, 2, 3]));
    println!();
    println!("critical difference of mean ranks at {}: {:.2}", ranked.alpha, ranked.critical_difference);
    for words in &ranked.words {
        println!("{words}");
    }
}
