//! Noise through every reader, layout and protocol, with every known trap planted one at a time.
//!
//! Labels have nothing to do with values here. A run must therefore score at chance, be refused, or say in its results what
//! makes its scores doubtful. `--nocapture` shows what became of each case.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "noise/cases.rs"]
mod cases;
#[path = "sets/mod.rs"]
mod sets;

use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use serde_json::Value;
use taxel::learn::{RunOptions, Silent};
use taxel::{Experiment, Layout, Overrides, Protocol, Registry, Results};

use cases::{Case, May, Plan};

/// Standard errors above chance that luck does not reach in any of some thousand scores. Folds share samples, so that it
/// reaches further than among independent guesses.
const ERRORS: f64 = 4.5;
/// Threads that take cases.
const THREADS: usize = 2;

/// Cases in which noise scores above chance without a word, by the words of their line, and why.
const KNOWN: &[(&str, &str)] = &[];

/// The end of a case.
#[derive(Debug, Clone, PartialEq)]
enum Outcome {
    Refused(String),
    /// Kinds of leaks in the results, and the best method.
    Said(Vec<String>, Score),
    Chance(Score),
    /// A method scores above chance and the results say nothing.
    Learned(Score),
}

/// The method that lies highest above its limit.
#[derive(Debug, Clone, PartialEq)]
struct Score {
    method: String,
    accuracy: f64,
    limit: f64,
    classes: Vec<String>,
}

impl Display for Score {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [accuracy, limit] = [self.accuracy, self.limit].map(|share| 100.0 * share);
        write!(f, "{} {accuracy:.1} % (limit {limit:.1})", self.method)
    }
}

impl Display for Outcome {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Refused(why) => write!(f, "refused: {}", why.chars().take(120).collect::<String>()),
            Outcome::Said(kinds, score) => write!(f, "said: {}; {score}", kinds.join(", ")),
            Outcome::Chance(score) => write!(f, "chance: {score}"),
            Outcome::Learned(score) => write!(f, "LEARNED: {score}"),
        }
    }
}

/// Runs a case below `folder`.
fn outcome(case: &Case, folder: &Path) -> Outcome {
    let (path, keys) = case.form.write(&case.set, &case.style, &folder.join("set"));
    let methods =
        if case.is_short() { r#""k-nn", "svm-linear", "mini-rocket""# } else { r#""k-nn", "svm-linear""# };
    let text = format!(
        "name = \"noise\"\nnetworks = []\nbaselines = [{methods}]\n[data]\npath = {:?}\n{keys}{}\n{}\n[protocol]\n{}\n",
        path.display().to_string(),
        case.data,
        case.more,
        case.plan.toml()
    );
    let registry = Registry::built_in();
    let (options, stop) = (RunOptions { threads: Some(1), ..RunOptions::default() }, AtomicBool::new(false));
    let experiment = Experiment::parse(&text, "noise.toml", &Overrides::default(), &registry);
    let experiment = experiment.unwrap_or_else(|error| panic!("{case}: {error}\n{text}"));
    let run =
        taxel::experiment::run(&experiment, &registry, Some(&folder.join("run")), &options, &Silent, &stop);
    match run {
        Err(error) => Outcome::Refused(error.to_string().replace(&folder.display().to_string(), "..")),
        Ok(run) => judged(&run.results().unwrap(), case),
    }
}

fn judged(results: &Results, case: &Case) -> Outcome {
    let score = score(results, case);
    let json = serde_json::to_value(results).unwrap();
    let leaks = json["leaks"].as_array().map_or(&[][..], Vec::as_slice);
    let mut kinds: Vec<String> =
        leaks.iter().filter_map(|leak| leak["kind"].as_str()).map(String::from).collect();
    if json.get("shortcut").is_some_and(|shortcut| *shortcut != Value::Null) {
        kinds.push("shortcut".into());
    }
    if !kinds.is_empty() {
        Outcome::Said(kinds, score)
    } else if score.accuracy > score.limit {
        Outcome::Learned(score)
    } else {
        Outcome::Chance(score)
    }
}

/// Finds the method that lies highest above chance, all folds of it together.
fn score(results: &Results, case: &Case) -> Score {
    let classes = results.task.attributes()[0].classes.clone();
    let scores = results.networks.iter().map(|row| {
        let counts = row.confusion.as_ref().unwrap().counts();
        let of_class: Vec<u64> = counts.iter().map(|line| line.iter().sum()).collect();
        let total: u64 = of_class.iter().sum();
        let right: u64 = counts.iter().enumerate().map(|(at, line)| line[at]).sum();
        let chance = *of_class.iter().max().unwrap() as f64 / total as f64;
        // Of samples that are tested in several repetitions, or are alike, only one says something new.
        let tested = total as f64 / results.protocol.repetitions() as f64 / results.samples as f64;
        let alone = case.units as f64 * tested.min(1.0);
        let limit = chance + ERRORS * (chance * (1.0 - chance) / alone).sqrt();
        let accuracy = right as f64 / total as f64;
        Score { method: row.network.clone(), accuracy, limit, classes: classes.clone() }
    });
    scores.max_by(|a, b| (a.accuracy - a.limit).total_cmp(&(b.accuracy - b.limit))).unwrap()
}

/// Says why an outcome is none that the case may have.
fn fault(case: &Case, outcome: &Outcome) -> Option<String> {
    let fits = |may: &May| match (may, outcome) {
        (May::Chance, Outcome::Chance(_)) => true,
        (May::Say(kind), Outcome::Said(kinds, _)) => kinds.iter().any(|said| said == kind),
        (May::Refuse(words), Outcome::Refused(why)) => why.contains(words),
        // A control: the trap is learned where no rule looks at it.
        (May::Bite, Outcome::Learned(_)) => true,
        (May::Bite, Outcome::Said(_, score)) => score.accuracy > score.limit,
        _ => false,
    };
    if !case.may.iter().any(fits) {
        return Some(format!("may be {:?}", case.may));
    }
    let wanted: Vec<String> = case.set.classes.clone();
    match outcome {
        Outcome::Chance(score) | Outcome::Said(_, score) if score.classes != wanted => {
            Some(format!("has the classes {}", score.classes.join(", ")))
        }
        _ => None,
    }
}

#[test]
fn noise_scores_at_chance_or_is_refused_or_headlined() {
    let all = cases::all();
    let (next, done) = (AtomicUsize::new(0), Mutex::new(vec![]));
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                while let Some((at, case)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|at| Some((at, all.get(at)?)))
                {
                    let folder = tempfile::tempdir().unwrap();
                    let begun = std::time::Instant::now();
                    let outcome = outcome(case, folder.path());
                    done.lock().unwrap().push((at, outcome, begun.elapsed()));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap();
    done.sort_by_key(|(at, ..)| *at);
    assert_eq!(done.len(), all.len(), "a case panicked");
    let (mut failed, mut unused) = (vec![], KNOWN.to_vec());
    for (at, outcome, time) in &done {
        let line = format!("{} | {outcome} | {} ms", all[*at], time.as_millis());
        println!("{line}");
        let Some(fault) = fault(&all[*at], outcome) else { continue };
        match KNOWN.iter().find(|(words, _)| line.contains(words)) {
            Some(known) => unused.retain(|other| other != known),
            None => failed.push(format!("{line}: {fault}")),
        }
    }
    println!("{} cases", done.len());
    assert!(failed.is_empty(), "{} of {} cases:\n{}", failed.len(), done.len(), failed.join("\n"));
    assert!(unused.is_empty(), "mended, take them from the list: {unused:?}");
}

/// The name of a protocol; a new kind needs a line here and cases.
fn kind(protocol: &Protocol) -> &'static str {
    match protocol {
        Protocol::KFold { .. } => "k-fold",
        Protocol::RandomSplits { .. } => "random-splits",
        Protocol::FewSamples { .. } => "few-samples",
        Protocol::LeaveGroupOut { .. } => "leave-group-out",
        Protocol::Official { .. } => "official",
        Protocol::Chronological { .. } => "chronological",
        // Simulates its samples: no file is read.
        Protocol::Fresh { .. } => "fresh",
    }
}

#[test]
fn every_reader_layout_and_protocol_is_audited() {
    let all = cases::all();
    let plain: Vec<&Case> = all.iter().filter(|case| case.trap.is_empty()).collect();
    for format in taxel::data::formats() {
        let of_format: Vec<&&Case> =
            plain.iter().filter(|case| case.form.formats().contains(&format.name)).collect();
        assert!(!of_format.is_empty(), "no case reads {}", format.name);
        assert!(
            all.iter().any(|case| !case.trap.is_empty() && case.form.formats().contains(&format.name)),
            "no trap is planted in {}",
            format.name
        );
        for ending in format.endings {
            assert!(
                of_format.iter().any(|case| case.form.ending() == Some(ending)),
                "no case reads .{ending} as {}",
                format.name
            );
        }
    }
    for layout in Layout::ALL {
        assert!(
            plain.iter().any(|case| case.set.layout == layout),
            "no case has the layout {}",
            layout.name()
        );
    }
    let of_plan = |plan: &Plan| serde_json::from_value::<Protocol>(plan.json()).unwrap();
    let kinds: BTreeSet<&str> = plain.iter().map(|case| kind(&of_plan(&case.plan))).collect();
    assert_eq!(kinds.len(), 6, "{kinds:?}");
}
