//! How a run answers a claim.

use std::cmp::Ordering;

use taxel_trainer::metrics::Confusion;

use super::Outcome;
use super::field::{Entrant, Field};
use crate::contest::{Answers, Effect};
use crate::error::Result;
use crate::statistics::{independent, spread_ratio};

/// What a run says about a claim.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answer {
    pub outcome: Outcome,
    pub effect: String,
    pub size: Option<f64>,
    pub interval: Option<[f64; 2]>,
}

/// What is compared.
#[derive(Debug, Clone, Copy)]
pub(super) enum Measure {
    /// Over all attributes.
    Accuracy,
    /// Accuracy on one attribute.
    Attribute(&'static str),
    /// Precision of the worst level of an attribute.
    WorstPrecision(&'static str),
}

/// What keeps a run from being asked.
fn lacks(what: impl Into<String>) -> Answer {
    let outcome = Outcome::CannotBeTested;
    Answer { outcome, effect: format!("the run lacks {}", what.into()), size: None, interval: None }
}

/// Holds where the interval lies above `least`.
fn above(least: f64, effect: String, own: Effect) -> Answer {
    let outcome = match own.interval {
        Some([low, _]) if low > least => Outcome::Holds,
        Some(_) => Outcome::DoesNotHold,
        None => Outcome::CannotBeTested,
    };
    let effect = match own.interval {
        Some(_) => effect,
        None => format!("{effect}; the run lacks test parts or groups that tell how much it varies"),
    };
    Answer { outcome, effect, size: Some(own.size), interval: own.interval }
}

/// By lower bound: what comes nearest to refuting a claim first. An effect without an interval comes behind
/// those that refute the claim and before those that do not.
fn nearest(least: f64) -> impl Fn(&(String, Effect), &(String, Effect)) -> Ordering {
    let low = move |own: &Effect| own.interval.map_or(least, |[low, _]| low);
    move |a, b| low(&a.1).total_cmp(&low(&b.1))
}

/// Against each of several: the one that comes nearest to refuting the claim.
fn against_all(least: f64, effects: Vec<(String, Effect)>) -> Answer {
    let (count, first) = (effects.len(), effects.into_iter().min_by(nearest(least)));
    let Some((effect, own)) = first else { return lacks("test parts that the networks share") };
    let of = if count > 1 { format!("; nearest of {count}") } else { String::new() };
    above(least, format!("{effect}{of}"), own)
}

/// Some of the names that are in nobody's run.
fn missing(run: &Field, names: &[&str]) -> Vec<String> {
    names.iter().filter(|name| run.find(name).is_none()).map(ToString::to_string).collect()
}

fn accuracy(both: &[Answers]) -> Option<f64> {
    Some(both[0].accuracy(None) - both[1].accuracy(None))
}

/// `one` is better than each of `others`.
pub(super) fn beats(run: &Field, one: &str, others: &[&str], measure: Measure) -> Result<Answer> {
    let (what, attribute) = match measure {
        Measure::Accuracy => ("accuracy", None),
        Measure::Attribute(name) => ("accuracy", Some(name)),
        Measure::WorstPrecision(name) => ("precision of the worst level", Some(name)),
    };
    let attributes = &run.judgement.results.attributes;
    let at = attribute.map(|name| attributes.iter().position(|own| own.name == name));
    if let (Some(None), Some(name)) = (at, attribute) {
        return Ok(lacks(format!("the attribute {name}")));
    }
    let at = at.flatten();
    let absent = missing(run, &[&[one], others].concat());
    let Some(own) = run.find(one).filter(|_| absent.is_empty()) else {
        return Ok(lacks(absent.join(", ")));
    };
    let levels = at.map_or(0, |at| attributes[at].classes.len());
    let value = |answers: Answers| match measure {
        Measure::WorstPrecision(_) => worst_precision(answers, at.unwrap_or(0), levels),
        _ => Some(answers.accuracy(at)),
    };
    let difference = |both: &[Answers]| Some(value(both[0])? - value(both[1])?);
    let mut effects = vec![];
    for other in others.iter().filter_map(|name| run.find(name)) {
        let names = [own.name.as_str(), other.name.as_str()];
        if let Some(effect) = run.contest.effect(&names, &difference, 0.95)? {
            let of = attribute.map_or(String::new(), |name| format!(" of {name}"));
            effects.push((format!("{what}{of}: {} less {}, points", own.name, other.name), effect));
        }
    }
    Ok(against_all(0.0, effects))
}

/// In %, over the levels that occur.
fn worst_precision(answers: Answers, attribute: usize, levels: usize) -> Option<f64> {
    let (truth, predicted): (Vec<u32>, Vec<u32>) =
        answers.each().map(|(truth, predicted)| (truth[attribute], predicted[attribute])).unzip();
    let classes = Confusion::new(&truth, &predicted, levels).ok()?.per_class();
    let precisions = classes.iter().filter(|class| class.support > 0).map(|class| class.precision);
    precisions.min_by(f64::total_cmp).map(|worst| 100.0 * worst)
}

/// The first of `ones` that the run has is less than `margin` points worse than each of `others`.
pub(super) fn close(run: &Field, ones: &[&str], others: &[&str], margin: f64) -> Result<Answer> {
    let absent = missing(run, others);
    let Some(own) = ones.iter().find_map(|name| run.find(name)) else {
        return Ok(lacks([&[ones[0].to_string()], absent.as_slice()].concat().join(", ")));
    };
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let rivals: Vec<&Entrant> = others.iter().filter_map(|name| run.find(name)).collect();
    not_worse(run, own, &rivals, margin)
}

/// Tuned from a checkpoint, `one` is less than `margin` points worse than `other`.
pub(super) fn tuned_close(run: &Field, one: &str, other: &str, margin: f64) -> Result<Answer> {
    match (run.tuned(one), run.tuned(other)) {
        (Some(own), Some(rival)) => not_worse(run, own, &[rival], margin),
        _ => Ok(lacks(format!("{one} and {other}, both tuned from a checkpoint"))),
    }
}

fn not_worse(run: &Field, own: &Entrant, others: &[&Entrant], margin: f64) -> Result<Answer> {
    let mut effects = vec![];
    for other in others {
        if let Some(effect) = run.contest.effect(&[&own.name, &other.name], &accuracy, 0.95)? {
            let effect_text =
                format!("accuracy: {} less {}, points; holds above -{margin}", own.name, other.name);
            effects.push((effect_text, effect));
        }
    }
    Ok(against_all(-margin, effects))
}

/// Of all mistakes the one that takes the first class for the second is the commonest.
pub(super) fn commonest_error(run: &Field, zoo: &str, [from, to]: [&str; 2]) -> Result<Answer> {
    let classes = &run.judgement.results.classes;
    let label = |name: &str| classes.iter().position(|known| known == name);
    let Some(own) = run.find(zoo) else { return Ok(lacks(zoo)) };
    let (Some(first), Some(second)) = (label(from), label(to)) else {
        return Ok(lacks(format!("the classes {from} and {to}")));
    };
    let mut effects = vec![];
    for (truth, name) in classes.iter().enumerate() {
        for (predicted, said) in classes.iter().enumerate() {
            if truth == predicted || (truth, predicted) == (first, second) {
                continue;
            }
            let more = |answers: &[Answers]| {
                Some(share(answers[0], [first, second]) - share(answers[0], [truth, predicted]))
            };
            if let Some(effect) = run.contest.effect(&[&own.name], &more, 0.95)? {
                let text = format!("{from} taken for {to} less {name} for {said}, % of all test samples");
                effects.push((text, effect));
            }
        }
    }
    Ok(against_all(0.0, effects))
}

/// Samples of the first class that are taken for the second, in % of all.
fn share(answers: Answers, [from, to]: [usize; 2]) -> f64 {
    let (mut count, mut all) = (0, 0);
    for (truth, predicted) in answers.each() {
        all += 1;
        count += usize::from((truth[0] as usize, predicted[0] as usize) == (from, to));
    }
    100.0 * f64::from(u32::try_from(count).unwrap_or(u32::MAX)) / f64::from(all.max(1))
}

/// How much more `one` varies over the folds than `other`, in %.
fn spread(run: &Field, one: &str, other: &str) -> Result<Option<(String, Effect)>> {
    let (Some(own), Some(rival)) = (run.find(one), run.find(other)) else { return Ok(None) };
    let (a, b) = run.contest.values(&own.name, &rival.name, |answers| answers.accuracy(None));
    if a.len() < 3 {
        return Ok(None);
    }
    let text = format!("SD over folds: {} more than {}, %", own.name, rival.name);
    let effect = |ratio: crate::statistics::SpreadRatio| Effect {
        size: 100.0 * (ratio.ratio - 1.0),
        interval: Some(ratio.interval.map(|bound| 100.0 * (bound - 1.0))),
        p: None,
    };
    Ok(spread_ratio(&a, &b, 0.95)?.map(|ratio| (text, effect(ratio))))
}

/// `one` varies more over the folds than `other`.
pub(super) fn larger_spread(run: &Field, one: &str, other: &str) -> Result<Answer> {
    let absent = missing(run, &[one, other]);
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let effect = spread(run, one, other)?;
    Ok(effect.map_or_else(|| lacks("folds that differ"), |own| against_all(0.0, vec![own])))
}

/// `one` varies less over the folds than each of `others`.
pub(super) fn smallest_spread(run: &Field, one: &str, others: &[&str]) -> Result<Answer> {
    let absent = missing(run, &[&[one], others].concat());
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let effects = others.iter().map(|other| spread(run, other, one)).collect::<Result<Vec<_>>>()?;
    let known: Vec<_> = effects.into_iter().flatten().collect();
    Ok(if known.len() < others.len() { lacks("folds that differ") } else { against_all(0.0, known) })
}

/// Every network that the run both tunes and trains with all but its classifier frozen: by name of
/// MobileNetV2's body, or no convolution of it having changed.
pub(super) fn tuned_beats_frozen(run: &Field) -> Result<Answer> {
    let still = |e: &Entrant| {
        let changes = &e.judged.weight_changes;
        !changes.is_empty() && changes.iter().all(|layer| layer.change == 0.0)
    };
    let named = |e: &Entrant| e.frozen.iter().any(|part| part == "features");
    let frozen = run.full().filter(|e| e.checkpoint && !e.frozen.is_empty() && (named(e) || still(e)));
    let mut effects = vec![];
    for one in frozen {
        let tuned =
            |e: &&Entrant| e.checkpoint && e.frozen.is_empty() && e.results().zoo == one.results().zoo;
        let Some(tuned) = run.full().find(tuned) else { continue };
        if let Some(effect) = run.contest.effect(&[&tuned.name, &one.name], &accuracy, 0.95)? {
            let text = format!("accuracy of {}: {} less {}, points", one.results().zoo, tuned.name, one.name);
            effects.push((text, effect));
        }
    }
    match effects.is_empty() {
        true => Ok(lacks("a network from a checkpoint both tuned and frozen up to its classifier")),
        false => Ok(against_all(0.0, effects)),
    }
}

/// Freezing `range` costs less than `margin` points against tuning everything.
pub(super) fn freezing_costs(run: &Field, zoo: &str, range: &str, margin: f64) -> Result<Answer> {
    let own = |e: &&Entrant| e.results().zoo == zoo && e.checkpoint && e.frozen == [range];
    let (frozen, tuned) = (run.full().find(own), run.tuned(zoo));
    match (frozen, tuned) {
        (Some(frozen), Some(tuned)) => not_worse(run, frozen, &[tuned], margin),
        _ => Ok(lacks(format!("{zoo} from a checkpoint, once tuned and once with {range} frozen"))),
    }
}

/// The deeper a convolution, the less tuning changes it: rank correlation with Fisher's interval.
pub(super) fn early_layers_change_most(run: &Field, zoo: &str) -> Result<Answer> {
    let tuned = run
        .full()
        .find(|e| e.results().zoo == zoo && e.frozen.is_empty() && e.judged.weight_changes.len() > 3);
    let Some(own) = tuned else {
        return Ok(lacks(format!("{zoo} tuned from a checkpoint that is still at hand")));
    };
    let changes: Vec<f64> = own.judged.weight_changes.iter().map(|layer| layer.change).collect();
    let depth: Vec<f64> = (0..changes.len()).map(|at| at as f64).collect();
    let r = -correlation(&ranks(&depth), &ranks(&changes));
    let half = 1.96 / (changes.len() as f64 - 3.0).sqrt();
    // Perfect order has no variance: Fisher's transform of 1 is infinite.
    let z = r.clamp(-0.999_999, 0.999_999).atanh();
    let effect = Effect { size: r, interval: Some([(z - half).tanh(), (z + half).tanh()]), p: None };
    let text =
        format!("rank correlation of earliness and weight change, {} layers of {}", changes.len(), own.name);
    Ok(above(0.0, text, effect))
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |value: f64| values.iter().filter(|v| **v < value).count() as f64;
    let equal = |value: f64| values.iter().filter(|v| **v == value).count() as f64;
    values.iter().map(|&v| below(v) + (equal(v) + 1.0) / 2.0).collect()
}

/// 0 where either does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(a - mean_a, b - mean_b)).sum::<f64>();
    let size = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if size > 0.0 { sum(&|a, b| a * b) / size } else { 0.0 }
}

/// Stitched networks are made of two runs and never trained: no run folder holds one.
pub(super) fn stitched(_: &Field) -> Result<Answer> {
    Ok(lacks("a stitched network: taxel stitch makes one of two trained networks, and no run trains it"))
}

/// More sensing elements add more than `least` points: two runs of one scene, the same network in both.
pub(super) fn resolution_matters(
    run: &Field,
    others: &[&Field],
    [few, many]: [usize; 2],
    least: f64,
) -> Result<Answer> {
    let size = |field: &Field| match field.judgement.results.sample_shape.as_slice() {
        [height, width] if height == width => Some(*height),
        _ => None,
    };
    let source = |field: &Field| field.judgement.results.source.clone();
    let coarse = others.iter().find(|other| size(other) == Some(few) && source(other) == source(run));
    let (Some(coarse), true) = (coarse, size(run) == Some(many)) else {
        return Ok(lacks(format!(
            "{many} × {many} elements, or a second run of its scene with {few} × {few} beside it"
        )));
    };
    let mut effects = vec![];
    for fine in run.full().filter(|e| !e.judged.rival) {
        let twin = coarse.full().find(|e| e.name == fine.name && e.results().zoo == fine.results().zoo);
        let known = |e: &Entrant| Some((e.results().mean?.accuracy, e.results().interval?));
        let (Some(a), Some(b)) = (known(fine), twin.and_then(known)) else { continue };
        // A mean over folds may lie a little outside an interval over samples.
        let wide = |(size, [low, high]): (f64, [f64; 2])| (size, [low.min(size), high.max(size)]);
        let (size, interval) = independent(wide(a), wide(b))?;
        let text = format!(
            "accuracy of {}: {many} less {few} elements a side, points; holds above {least}",
            fine.name
        );
        effects.push((text, Effect { size, interval: Some(interval), p: None }));
    }
    match effects.is_empty() {
        true => Ok(lacks("a network that the run with fewer elements has too")),
        false => Ok(against_all(least, effects)),
    }
}

/// TactNet3D among some entrants: the one that bears its name first.
fn three<'f>(entrants: impl Iterator<Item = &'f Entrant>) -> Option<&'f Entrant> {
    let own: Vec<&Entrant> =
        entrants.filter(|e| ["tactnet3d", "tactnet3d-51"].contains(&e.results().zoo.as_str())).collect();
    let plain =
        |e: &&&Entrant| e.name == e.results().zoo || e.name.starts_with(&format!("{}.n", e.results().zoo));
    own.iter().find(plain).or(own.first()).copied()
}

/// Networks that see single frames.
fn two<'f>(entrants: impl Iterator<Item = &'f Entrant>) -> Vec<&'f Entrant> {
    entrants.filter(|e| !e.judged.rival && e.judged.inputs == ["image"]).collect()
}

const BOTH: &str = "TactNet3D and a 2D network";

/// TactNet3D beats every 2D network that is trained on as many grasps.
pub(super) fn three_beats_two(run: &Field, count: usize) -> Result<Answer> {
    let (Some(three), two) = (three(run.with(count)), two(run.with(count))) else {
        return Ok(lacks(format!("{BOTH} trained on {count} samples per class")));
    };
    if two.is_empty() {
        return Ok(lacks(format!("a 2D network trained on {count} samples per class")));
    }
    against_two(run, three, &two, 0.95).map(|effects| against_all(0.0, effects))
}

fn against_two(
    run: &Field,
    three: &Entrant,
    two: &[&Entrant],
    confidence: f64,
) -> Result<Vec<(String, Effect)>> {
    let mut effects = vec![];
    for other in two {
        if let Some(effect) = run.contest.effect(&[&three.name, &other.name], &accuracy, confidence)? {
            effects.push((format!("accuracy: {} less {}, points", three.name, other.name), effect));
        }
    }
    Ok(effects)
}

/// The margin of TactNet3D is larger with the fewest than with the most samples per class.
pub(super) fn margin_shrinks(run: &Field) -> Result<Answer> {
    let counts = run.counts();
    let (Some(&few), Some(&many)) = (counts.first(), counts.last().filter(|_| counts.len() > 1)) else {
        return Ok(lacks("a learning curve"));
    };
    let (Some(a), Some(b)) = (three(run.with(few)), three(run.with(many))) else {
        return Ok(lacks(BOTH));
    };
    let margins = |all: &[Answers]| {
        let right: Vec<f64> = all.iter().map(|answers| answers.accuracy(None)).collect();
        Some((right[0] - right[1]) - (right[2] - right[3]))
    };
    let mut effects = vec![];
    for c in two(run.with(few)) {
        let Some(d) = two(run.with(many)).into_iter().find(|d| d.results().zoo == c.results().zoo) else {
            continue;
        };
        if let Some(effect) = run.contest.effect(&[&a.name, &c.name, &b.name, &d.name], &margins, 0.95)? {
            let zoo = &c.results().zoo;
            effects
                .push((format!("margin over {zoo}: with {few} less with {many} per class, points"), effect));
        }
    }
    Ok(if effects.is_empty() { lacks(BOTH) } else { against_all(0.0, effects) })
}

/// In at least one pair of counts TactNet3D trained on few samples beats every 2D network trained on many.
/// Intervals are widened for the number of pairs (Bonferroni).
pub(super) fn few_beat_many(run: &Field, few: &[usize], many: &[usize]) -> Result<Answer> {
    let counts = run.counts();
    let pairs: Vec<(usize, usize)> = few
        .iter()
        .flat_map(|&few| many.iter().map(move |&many| (few, many)))
        .filter(|(few, many)| counts.contains(few) && counts.contains(many))
        .collect();
    let confidence = 1.0 - 0.05 / pairs.len().max(1) as f64;
    let mut cases = vec![];
    for (few, many) in &pairs {
        let (Some(three), two) = (three(run.with(*few)), two(run.with(*many))) else { continue };
        let effects = against_two(run, three, &two, confidence)?;
        cases.extend(effects.into_iter().min_by(nearest(0.0)));
    }
    let best = cases.into_iter().max_by(nearest(0.0));
    Ok(match best {
        Some((text, effect)) => above(0.0, format!("{text}; best of {} cases", pairs.len()), effect),
        None => lacks(format!("{BOTH} trained on few ({few:?}) and many ({many:?}) samples per class")),
    })
}

/// The share of mistakes that stay inside a group of look-alikes is larger for TactNet3D; with `count`
/// samples per class where there is a learning curve, as in the paper's figures.
pub(super) fn within_look_alikes(run: &Field, count: usize) -> Result<Answer> {
    if run.look_alikes.is_empty() {
        return Ok(lacks("groups of look-alikes (data.look_alikes)"));
    }
    let entrants: Vec<&Entrant> =
        if run.counts().contains(&count) { run.with(count).collect() } else { run.full().collect() };
    let own = three(entrants.iter().copied());
    let rivals = two(entrants.iter().copied());
    let (Some(own), false) = (own, rivals.is_empty()) else { return Ok(lacks(BOTH)) };
    let inside = |answers: Answers| {
        let (mut errors, mut within) = (0, 0);
        for (truth, predicted) in answers.each().filter(|(truth, predicted)| truth[0] != predicted[0]) {
            let both = |group: &Vec<u32>| group.contains(&truth[0]) && group.contains(&predicted[0]);
            errors += 1;
            within += u32::from(run.look_alikes.iter().any(both));
        }
        (errors > 0).then(|| 100.0 * f64::from(within) / f64::from(errors))
    };
    let more = |both: &[Answers]| Some(inside(both[0])? - inside(both[1])?);
    let mut effects = vec![];
    for other in rivals {
        if let Some(effect) = run.contest.effect(&[&own.name, &other.name], &more, 0.95)? {
            let text = format!("errors inside look-alikes: {} less {}, % of errors", own.name, other.name);
            effects.push((text, effect));
        }
    }
    Ok(if effects.is_empty() { lacks("errors to look at") } else { against_all(0.0, effects) })
}

/// TactNet3D takes an object for its twin (`name` and `name` + `suffix`) less often than 2D networks do.
pub(super) fn twins_told_apart(run: &Field, suffix: &str) -> Result<Answer> {
    let classes = &run.judgement.results.classes;
    let label = |name: &str| classes.iter().position(|known| known == name);
    let pair = |name: &String| Some((label(name.strip_suffix(suffix)?)? as u32, label(name)? as u32));
    let pairs: Vec<(u32, u32)> = classes.iter().filter_map(pair).collect();
    if pairs.is_empty() {
        return Ok(lacks(format!("objects with twins (a name and the same with {suffix})")));
    }
    let own = three(run.full());
    let rivals = two(run.full());
    let (Some(own), false) = (own, rivals.is_empty()) else { return Ok(lacks(BOTH)) };
    let told = |answers: Answers| {
        let (mut all, mut mistaken) = (0, 0);
        for (truth, predicted) in answers.each() {
            let twin = pairs.iter().find_map(|&(a, b)| match truth[0] {
                own if own == a => Some(b),
                own if own == b => Some(a),
                _ => None,
            });
            all += u32::from(twin.is_some());
            mistaken += u32::from(twin == Some(predicted[0]));
        }
        (all > 0).then(|| 100.0 - 100.0 * f64::from(mistaken) / f64::from(all))
    };
    let more = |both: &[Answers]| Some(told(both[0])? - told(both[1])?);
    let mut effects = vec![];
    for other in rivals {
        if let Some(effect) = run.contest.effect(&[&own.name, &other.name], &more, 0.95)? {
            let text = format!("twins told apart: {} less {}, % of their grasps", own.name, other.name);
            effects.push((text, effect));
        }
    }
    Ok(against_all(0.0, effects))
}
