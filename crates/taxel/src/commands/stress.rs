//! `taxel stress`: the saved networks of a run under graded faults.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::judge::{Alarms, NetworkStress, Stress as Tested, StressOptions, named_scores, stress};
use taxel::reporting::open;
use taxel_faults::Fault;

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::threads::Threads;
use crate::commands::judging::stress_options;
use crate::terminal::progress::progress;
use crate::terminal::signals::leave_with;
use crate::terminal::tables;
use crate::{out, outln};

/// Corrupts the test samples of a run on purpose and scores its saved networks again.
///
/// Faults act on raw readings, before any encoding, in five severities (docs/faults.md). Printed are the
/// accuracy lost per fault, in percentage points (of values what is added to the mean absolute error, in its unit),
/// mean over severities, and the first severity at which half of the margin above chance is gone: !3.
#[derive(Args)]
#[command(after_help = "Examples:  taxel stress runs/quickstart
           taxel stress runs/quickstart --fault gain --fault drift --severity 3
           taxel stress runs/quickstart --format json > stress.json")]
pub struct Stress {
    /// A run folder.
    #[arg(value_hint = ValueHint::DirPath)]
    run: PathBuf,
    /// Tests this fault only; may be given several times [default: all that the samples can have].
    #[arg(long, value_name = "FAULT")]
    fault: Vec<Fault>,
    /// Tests this severity only, 1 to 5.
    #[arg(long, value_name = "N")]
    severity: Option<u8>,
    /// Most test samples of each network under faults.
    #[arg(long, alias = "samples", value_name = "N", default_value_t = 1000)]
    max_samples: usize,
    /// Tests each network behind a guard as well, fitted on the training samples of each fold, and counts its false alarms.
    /// Models that have a guard are tested without it as well.
    #[arg(long, alias = "guard")]
    compare_guard: bool,
    #[command(flatten)]
    format: OutputFormat,
    #[command(flatten)]
    threads: Threads,
}

impl Stress {
    pub fn run(self) -> CommandResult {
        let options = StressOptions {
            faults: self.fault,
            severity: self.severity,
            samples: self.max_samples.max(1),
            guard: self.compare_guard,
            ..stress_options(self.threads.count()?)
        };
        leave_with("stopped; nothing was written: the same command begins again")?;
        let case = open(&self.run)?;
        let progress = progress();
        let outcomes = stress(&case, &options, &|steps| progress.start(steps), &|| progress.step(1));
        progress.finish();
        let outcomes = outcomes?;
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&named_scores(&outcomes)?)?);
        } else {
            print(&outcomes);
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn print(outcomes: &Tested) {
    let Tested { samples, of, range, chance, primary, .. } = outcomes;
    let (show, longer) = (primary.show(), primary.show_longer());
    let thinned = if samples < of { format!(" of {of}") } else { String::new() };
    let guessed = if range.from_samples { " (of the samples: no full scale is known)" } else { "" };
    outln!(
        "{samples}{thinned} test samples, readings {} to {}{guessed}, {} {}",
        range.low,
        range.high,
        primary.chance(),
        primary.value(*chance)
    );
    outln!(
        "{} in {}, mean over severities; !n: half of the margin is gone at n\n",
        primary.lost(false),
        primary.in_points()
    );
    let clean = primary.head_of("clean");
    let mut header = vec!["network", clean.as_str(), "mean", "mCE %"];
    header.extend(outcomes.faults.iter().map(|about| about.fault.name()));
    let rows: Vec<Vec<String>> = outcomes
        .networks
        .iter()
        .map(|network| {
            let error = network.corruption_error.map_or("-".into(), |e| format!("{e:.0}"));
            let mut row =
                vec![network.network.clone(), longer(network.clean.score), show(network.mean_loss), error];
            row.extend(network.curves.iter().map(|curve| {
                let broken = curve.breaks_at.map_or(String::new(), |at| format!(" !{at}"));
                show(curve.loss(network.clean, primary)) + &broken
            }));
            row
        })
        .collect();
    let right: Vec<usize> = (1..header.len()).collect();
    out!("{}", tables::table(&header, &rows, &right));
    print_guarded(outcomes);
    if let Some(reference) = &outcomes.reference {
        outln!("\nmCE: errors relative to {reference}'s, mean over faults; below 100 is steadier than it");
    }
    for (fault, reason) in &outcomes.left_out {
        outln!("left out: {fault}: {reason}");
    }
    outln!();
    for network in &outcomes.networks {
        outln!("{}: {}", network.network, network.verdict);
    }
}

/// Prints every network without a guard and with one.
fn print_guarded(outcomes: &Tested) {
    let Some(alarms) =
        outcomes.alarms.filter(|_| outcomes.networks.iter().any(|network| network.other.is_some()))
    else {
        return;
    };
    let (primary, show) = (&outcomes.primary, outcomes.primary.show());
    let (lost, title) = (primary.points(), primary.title());
    outln!("\nwithout a guard > with one, {lost} lost of the clean {title} as saved");
    let clean = primary.head_of("clean");
    let mut header = vec!["network", clean.as_str(), "mean"];
    header.extend(outcomes.faults.iter().map(|about| about.fault.name()));
    let both = |sides: [f64; 2]| sides.map(show).join(" > ");
    let row = |network: &NetworkStress| {
        let sides = network.sides()?;
        let mut row = vec![
            network.network.clone(),
            both(sides.map(|(clean, ..)| clean.score)),
            both(sides.map(|(.., loss)| loss)),
        ];
        let losses = sides.map(|(_, curves, _)| {
            curves.iter().map(|curve| curve.loss(network.clean, primary)).collect::<Vec<_>>()
        });
        row.extend(losses[0].iter().zip(&losses[1]).map(|(off, on)| both([*off, *on])));
        Some(row)
    };
    let rows: Vec<Vec<String>> = outcomes.networks.iter().filter_map(row).collect();
    let right: Vec<usize> = (1..header.len()).collect();
    out!("{}", tables::table(&header, &rows, &right));
    let Alarms { samples, alarmed, replaced, elements } = alarms;
    outln!(
        "false alarms: in {alarmed} of {samples} clean test samples, {replaced} channels or taxels of {elements} a sample"
    );
}
