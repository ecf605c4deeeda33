//! Rouhafzay et al. 2021: which sensors networks for pictures suit.

use super::benchmark::{Benchmark, RunNetwork};
use super::contrast::{Contrast, POINT};
use super::finding::{Finding, accuracy, against_all, between_runs, effects, lacks};
use super::transfer::{all_tuned, is_body_frozen};
use taxel::judge::{Predicted, Result};

/// Scenes with a camera behind a gel, and those with pressure or electrodes.
const OPTICAL: &str = "gel";
const OTHERS: [&str; 2] = ["imprint", "hand"];

/// Tests that networks tuned on an optical sensor are further above chance than the same networks tuned on others.
pub(super) fn optical_first(run: &Benchmark, others: &[&Benchmark]) -> Result<Finding> {
    let is =
        |run: &Benchmark, scene: &str| run.scene() == scene && run.judgement.results.source.is_simulated();
    let rivals: Vec<&&Benchmark> =
        others.iter().filter(|other| OTHERS.iter().any(|scene| is(other, scene))).collect();
    if !is(run, OPTICAL) || rivals.is_empty() {
        return Ok(lacks("an optical sensor, with a run on pressure or electrodes beside it"));
    }
    let twin = |entry: &RunNetwork, of: &Benchmark| {
        all_tuned(of).find(|other| other.results().zoo == entry.results().zoo).cloned()
    };
    let pairs: Vec<(RunNetwork, RunNetwork, &Benchmark)> = all_tuned(run)
        .flat_map(|one| rivals.iter().filter_map(move |of| Some((one.clone(), twin(one, of)?, **of))))
        .collect();
    let mut found = vec![];
    for (one, other, of) in &pairs {
        let text =
            format!("accuracy above chance of {}: {} less {}, points", one.results().zoo, run.name, of.name);
        found.extend(between_runs(run, [one, other], [run.chance, of.chance], pairs.len(), text)?);
    }
    Ok(if found.is_empty() {
        lacks("a network that both runs tune from a checkpoint")
    } else {
        against_all(0.0, found)
    })
}

/// Tests that no network with a frozen body is more than `within` points above chance on `elements` × `elements` elements.
pub(super) fn frozen_at_chance(run: &Benchmark, elements: usize, within: f64) -> Result<Finding> {
    let frozen: Vec<&RunNetwork> = run.full().filter(|entry| is_body_frozen(entry)).collect();
    if run.judgement.results.sample_shape != [elements, elements] || frozen.is_empty() {
        return Ok(lacks(format!(
            "a network frozen up to its classifier on {elements} × {elements} elements"
        )));
    }
    at_chance(run, &frozen, within)
}

/// Tests that no network is more than `within` points above chance on a single time step of 7 × 3 electrodes. Those that
/// have not learned take part: the claim is that they cannot.
pub(super) fn single_step_at_chance(run: &Benchmark, within: f64) -> Result<Finding> {
    let untrained = run.untrained.iter().map(|(entry, _)| entry);
    let networks: Vec<&RunNetwork> = run.full().chain(untrained).filter(|e| !e.judged.baseline).collect();
    if run.judgement.results.sample_shape != [1, 7, 3] || networks.is_empty() {
        return Ok(lacks("a network on single time steps of 7 × 3 electrodes"));
    }
    at_chance(run, &networks, within)
}

fn at_chance(run: &Benchmark, networks: &[&RunNetwork], within: f64) -> Result<Finding> {
    let below = |predicted: &[Predicted]| Some(run.chance - predicted[0].accuracy(None));
    let mut found = vec![];
    for network in networks {
        let text = format!("chance less accuracy of {}, points", network.name);
        found.extend(run.contrast(text, &[&network.name], &below, networks.len())?);
    }
    Ok(against_all(-within, found))
}

/// Label of a network on grey in all three channels, behind its name.
const GREY: &str = "-grey";

/// Tests that a network does as well with grey in red alone as with grey in all three channels, to a point either way.
pub(super) fn channels_alike(run: &Benchmark) -> Result<Finding> {
    let is_grey = |entry: &&RunNetwork| entry.name.ends_with(GREY);
    let red = |grey: &RunNetwork| {
        all_tuned(run).find(|e| !is_grey(e) && e.results().zoo == grey.results().zoo).cloned()
    };
    let pairs: Vec<(&RunNetwork, RunNetwork)> =
        all_tuned(run).filter(is_grey).filter_map(|grey| Some((grey, red(grey)?))).collect();
    let mut found: Vec<Contrast> = vec![];
    for (grey, red) in &pairs {
        let words = |pair: &str| format!("accuracy: {pair}, points");
        for (one, other) in [(*grey, red), (red, *grey)] {
            found.extend(effects(run, one, &[other], &accuracy, 2 * pairs.len(), words)?);
        }
    }
    Ok(if found.is_empty() {
        lacks(format!("a network tuned on grey in red alone and, as {GREY}, on grey in three channels"))
    } else {
        against_all(-POINT, found)
    })
}
