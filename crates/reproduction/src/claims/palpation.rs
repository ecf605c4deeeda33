//! Gandarias et al. 2019b and Pastor et al. 2019: sequences against single frames.

use super::benchmark::{Benchmark, RunNetwork};
use super::contrast::{Contrast, strongest, weakest};
use super::finding::{Finding, accuracy, against_all, effects, lacks};
use taxel::judge::Predicted;
use taxel::judge::Result;

/// Returns TactNet3D among some entries: the one that bears its name first.
fn three<'f>(entries: impl Iterator<Item = &'f RunNetwork>) -> Option<&'f RunNetwork> {
    let entries: Vec<&RunNetwork> =
        entries.filter(|e| ["tactnet3d", "tactnet3d-51"].contains(&e.results().zoo.as_str())).collect();
    let plain =
        |e: &&&RunNetwork| e.name == e.results().zoo || e.name.starts_with(&format!("{}.n", e.results().zoo));
    entries.iter().find(plain).or(entries.first()).copied()
}

/// Returns the networks that see single frames.
fn two<'f>(entries: impl Iterator<Item = &'f RunNetwork>) -> Vec<&'f RunNetwork> {
    entries.filter(|e| !e.judged.baseline && e.judged.inputs == ["image"]).collect()
}

const BOTH: &str = "TactNet3D and a 2D network";

/// Tests that TactNet3D beats every 2D network that is trained on as many grasps.
pub(super) fn three_beats_two(run: &Benchmark, count: usize) -> Result<Finding> {
    let (Some(three), two) = (three(run.with(count)), two(run.with(count))) else {
        return Ok(lacks(format!("{BOTH} trained on {count} samples per class")));
    };
    if two.is_empty() {
        return Ok(lacks(format!("a 2D network trained on {count} samples per class")));
    }
    Ok(against_all(0.0, effects(run, three, &two, &accuracy, two.len(), accuracy_words)?))
}

fn accuracy_words(pair: &str) -> String {
    format!("accuracy: {pair}, points")
}

/// Tests that the margin of TactNet3D is larger with the fewest than with the most samples per class.
pub(super) fn margin_shrinks(run: &Benchmark) -> Result<Finding> {
    let counts = run.counts();
    let (Some(&few), Some(&many)) = (counts.first(), counts.last().filter(|_| counts.len() > 1)) else {
        return Ok(lacks("a learning curve"));
    };
    // The same network on both ends: of an unfinished run another one may have the counts that the first lacks.
    let Some(a) = three(run.with(few).filter(|entry| with_count(run, entry, few, many).is_some())) else {
        return Ok(lacks(BOTH));
    };
    let Some(b) = with_count(run, a, few, many) else { return Ok(lacks(BOTH)) };
    let margins = |all: &[Predicted]| {
        let right: Vec<f64> = all.iter().map(|predictions| predictions.accuracy(None)).collect();
        Some((right[0] - right[1]) - (right[2] - right[3]))
    };
    let mut contrasts = vec![];
    let twos = two(run.with(few));
    for c in &twos {
        let Some(d) = two(run.with(many)).into_iter().find(|d| d.results().zoo == c.results().zoo) else {
            continue;
        };
        let text = format!("margin over {}: with {few} less with {many} per class, points", c.results().zoo);
        contrasts.extend(run.contrast(text, &[&a.name, &c.name, &b.name, &d.name], &margins, twos.len())?);
    }
    Ok(if contrasts.is_empty() { lacks(BOTH) } else { against_all(0.0, contrasts) })
}

/// Returns the row of an `entry` that is trained on `few` samples per class where it is trained on `many`.
fn with_count<'r>(run: &'r Benchmark, entry: &RunNetwork, few: usize, many: usize) -> Option<&'r RunNetwork> {
    let name = format!("{}.n{many}", entry.name.strip_suffix(&format!(".n{few}"))?);
    run.with(many).find(|entry| entry.name == name)
}

/// Tests that in at least one pair of counts TactNet3D trained on few samples beats every 2D network trained on many.
/// Intervals are widened for the number of pairs (Bonferroni).
pub(super) fn few_beat_many(run: &Benchmark, few: &[usize], many: &[usize]) -> Result<Finding> {
    let counts = run.counts();
    let pairs: Vec<(usize, usize)> = few
        .iter()
        .flat_map(|&few| many.iter().map(move |&many| (few, many)))
        .filter(|(few, many)| counts.contains(few) && counts.contains(many))
        .collect();
    let wider = run.with_confidence(run.refuting(pairs.len()));
    let mut cases = vec![];
    for (few, many) in &pairs {
        let (Some(three), two) = (three(run.with(*few)), two(run.with(*many))) else { continue };
        let contrasts = effects(&wider, three, &two, &accuracy, two.len(), accuracy_words)?;
        cases.extend(weakest(0.0, &contrasts).cloned());
    }
    Ok(match strongest(0.0, &cases) {
        Some(best) => {
            let effect = format!("{}; best of {} cases", best.effect, pairs.len());
            against_all(0.0, vec![Contrast { effect, ..best.clone() }])
        }
        None => lacks(format!("{BOTH} trained on few ({few:?}) and many ({many:?}) samples per class")),
    })
}

/// Tests that TactNet3D and every 2D network recognise more than `least` % after training on `count` grasps of each object.
pub(super) fn both_do_well(run: &Benchmark, count: usize, least: f64) -> Result<Finding> {
    let (Some(three), two) = (three(run.with(count)), two(run.with(count))) else {
        return Ok(lacks(format!("{BOTH} trained on {count} samples per class")));
    };
    let networks: Vec<&RunNetwork> = std::iter::once(three).chain(two).collect();
    if networks.len() < 2 {
        return Ok(lacks(format!("a 2D network trained on {count} samples per class")));
    }
    let mut found = vec![];
    for network in &networks {
        let text = format!("accuracy of {}, %", network.name);
        let of = |predicted: &[Predicted]| Some(predicted[0].accuracy(None));
        found.extend(run.contrast(text, &[&network.name], &of, networks.len())?);
    }
    Ok(against_all(least, found))
}

/// Tests that the share of mistakes that stay inside a group of look-alikes is larger for TactNet3D; with `count`
/// samples per class where there is a learning curve, as in the paper's figures.
pub(super) fn within_look_alikes(run: &Benchmark, count: usize) -> Result<Finding> {
    if run.look_alikes.is_empty() {
        return Ok(lacks("groups of look-alikes (data.look_alikes)"));
    }
    let entries: Vec<&RunNetwork> =
        if run.counts().contains(&count) { run.with(count).collect() } else { run.full().collect() };
    let network = three(entries.iter().copied());
    let baselines = two(entries.iter().copied());
    let (Some(network), false) = (network, baselines.is_empty()) else { return Ok(lacks(BOTH)) };
    let inside = |predictions: Predicted| {
        let (mut errors, mut within) = (0, 0);
        for (truth, predicted) in predictions.each().filter(|(truth, predicted)| truth[0] != predicted[0]) {
            let both = |group: &Vec<u32>| group.contains(&truth[0]) && group.contains(&predicted[0]);
            errors += 1;
            within += u32::from(run.look_alikes.iter().any(both));
        }
        (errors > 0).then(|| 100.0 * f64::from(within) / f64::from(errors))
    };
    let more = |both: &[Predicted]| Some(inside(both[0])? - inside(both[1])?);
    let words = |pair: &str| format!("errors inside look-alikes: {pair}, % of errors");
    let effects = effects(run, network, &baselines, &more, baselines.len(), words)?;
    Ok(if effects.is_empty() { lacks("errors to look at") } else { against_all(0.0, effects) })
}

/// Tests that TactNet3D takes an object for its twin (`name` and `name` + `suffix`) less often than 2D networks do.
pub(super) fn twins_told_apart(run: &Benchmark, suffix: &str) -> Result<Finding> {
    let classes = &run.judgement.results.task.output_names();
    let label = |name: &str| classes.iter().position(|known| known == name);
    let pair = |name: &String| Some((label(name.strip_suffix(suffix)?)? as u32, label(name)? as u32));
    let pairs: Vec<(u32, u32)> = classes.iter().filter_map(pair).collect();
    if pairs.is_empty() {
        return Ok(lacks(format!("objects with twins (a name and the same with {suffix})")));
    }
    let network = three(run.full());
    let baselines = two(run.full());
    let (Some(network), false) = (network, baselines.is_empty()) else { return Ok(lacks(BOTH)) };
    let told_apart = |predictions: Predicted| {
        let (mut all, mut mistaken) = (0, 0);
        for (truth, predicted) in predictions.each() {
            let twin = pairs.iter().find_map(|&(a, b)| match truth[0] {
                class if class == a => Some(b),
                class if class == b => Some(a),
                _ => None,
            });
            all += u32::from(twin.is_some());
            mistaken += u32::from(twin == Some(predicted[0]));
        }
        (all > 0).then(|| 100.0 - 100.0 * f64::from(mistaken) / f64::from(all))
    };
    let more = |both: &[Predicted]| Some(told_apart(both[0])? - told_apart(both[1])?);
    let words = |pair: &str| format!("twins told apart: {pair}, % of their grasps");
    Ok(against_all(0.0, effects(run, network, &baselines, &more, baselines.len(), words)?))
}
