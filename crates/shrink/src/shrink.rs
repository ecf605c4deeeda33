//! A run shrunk, from its folds to the page and the smaller model.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold};
use taxel_judge::{Case, Criteria, mean_score, named_scores};
use taxel_learn::{FoldRecord, Model, NetworkResults, Progress, Teacher, sensor};
use taxel_trainer::{Experiment, Variant};
use taxel_zoo::Registry;

use crate::axis::Axis;
use crate::cache::{Cache, Request};
use crate::combine::{Combining, Together, together};
use crate::curves::{Context, Outer, SHARE, TrainingPart, curve, said};
use crate::error::{Error, Result};
use crate::ladder::{Cut, Ladder, LadderInputs, ladder};
use crate::options::ShrinkOptions;
use crate::page::shrunk_page;
use crate::plan::{Division, Estimate};
use crate::ranking;
use crate::sensors::sensors;
use crate::shrunk::{Curve, Shrunk, SmallSpeed};
use crate::small;
use crate::words::shrunk_words;

/// A loss that would matter, in percentage points, or in % of what knowing nothing scores.
const MARGIN: f64 = 2.0;
/// A loss on inner folds after which nothing smaller is trained, in the same.
const HOPELESS: f64 = 25.0;
/// Name of the smaller model's file.
const MODEL: &str = "shrunk.safetensors";
/// Name of its experiment's file.
const CONFIG: &str = "shrunk.toml";
/// Name of the file with everything that was found out.
const RESULT: &str = "shrink.json";
/// Name of the file with the times of predictions.
const SPEED: &str = "speed.json";
/// Folder of finished trainings.
const RECORDS: &str = "records";
/// A quick look trains for so many times fewer epochs.
const QUICK_EPOCHS: usize = 4;

/// The result of shrinking.
pub struct Finished {
    /// Everything that was found out.
    pub shrunk: Shrunk,
    /// Time of a prediction; none where no smaller model was written.
    pub speed: Option<SmallSpeed>,
    /// The page.
    pub page: PathBuf,
    /// The smaller model; none where nothing may go, or where it could not be trained on all samples.
    pub model: Option<PathBuf>,
}

/// Shrinks `network` of the run `case`, of `experiment`, into the folder `out`. `say` hears the estimate before anything is trained.
///
/// # Errors
/// A run that cannot be shrunk, a folder that holds something, [`Error::Stopped`] if `cancel` was set.
pub fn shrink(
    (case, experiment, registry): (&Case, &Experiment, &Registry),
    network: &str,
    out: &Path,
    options: &ShrinkOptions,
    say: &dyn Fn(&Estimate),
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<Finished> {
    check(case, experiment, network, options)?;
    // What cannot be trained by itself is refused while nothing is written.
    experiment.variant(network, &Variant::default(), registry)?;
    let dataset = &case.dataset;
    let context = context(case, experiment, network, options)?;
    let (ladders, left_out) = ladders(experiment, network, dataset, registry, options);
    let plan = Division::new(case, &context, &ladders, options)?;
    let records = prepare(out, options.resume)?;
    let mut cache = Cache::new((experiment, registry, dataset), records, options.threads, progress, cancel);
    let estimate = plan.estimate(case, &context);
    say(&estimate);
    cache.expect(estimate.trainings);
    progress.start(plan.samples(case, &context));
    let trained = train(&context, &mut cache, case, plan, ladders);
    progress.finish();
    let trained = trained?;
    let mut shrunk = gathered(case, &context, options, left_out, &trained)?;
    let mut speed = None;
    if let (Combining::Combination(found), Some(Ok((model, experiment)))) = (trained.found, trained.small) {
        let reduction = &experiment.config().encoding.reduce;
        shrunk.models = small::pair(case, &shrunk, &found, &model, reduction)?;
        let interval = found.combined.outer.score_interval;
        let model = model.with_score(small::score(case, &found.records, interval)?);
        speed = Some(small::speed(case, network, &model)?);
        model.save(&out.join(MODEL))?;
        write(&out.join(CONFIG), experiment.to_toml().as_bytes())?;
    }
    shrunk.words = shrunk_words(&shrunk);
    let page = finish(out, &shrunk, speed.as_ref())?;
    let model = speed.is_some().then(|| out.join(MODEL));
    Ok(Finished { shrunk, speed, page, model })
}

/// Results of all trainings.
struct Trained {
    outers: Vec<Outer>,
    tried: Vec<(Ladder, Curve)>,
    found: Combining,
    small: Option<SmallerModel>,
}

/// The smaller model, trained on everything, and its experiment; or why it could not be trained.
type SmallerModel = std::result::Result<(Model, Experiment), String>;

/// Does all trainings, the smaller model's last.
fn train(
    context: &Context,
    cache: &mut Cache,
    case: &Case,
    plan: Division,
    ladders: Vec<Ladder>,
) -> Result<Trained> {
    let ranked = ladders.iter().any(|ladder| ladder.axis == Axis::Sensors);
    let outers = plan.outers(context, cache, ranked)?;
    let mut tried = vec![];
    for ladder in ladders {
        let curve = curve(context, cache, &outers, &ladder)?;
        cache.progress.say(&format!("{}: {}", curve.title, curve.words));
        tried.push((ladder, curve));
    }
    let found = together(context, cache, &outers, &tried)?;
    let small = match &found {
        Combining::Combination(combination) => Some(small_model(context, cache, case, &outers, combination)?),
        Combining::None(_) => None,
    };
    Ok(Trained { outers, tried, found, small })
}

/// Returns the result without the models and the sentences.
fn gathered(
    case: &Case,
    context: &Context,
    options: &ShrinkOptions,
    left_out: Vec<(String, String)>,
    trained: &Trained,
) -> Result<Shrunk> {
    let Trained { outers, tried, found, small } = trained;
    let whole: Vec<FoldRecord> = outers.iter().map(|outer| outer.whole.clone()).collect();
    let (protocol, seed) = (&case.results.protocol, case.results.seed);
    let mut notes = notes(case, context, outers, options);
    let combined = match found {
        Combining::Combination(combination) => Some(combination.combined.clone()),
        Combining::None(words) => {
            notes.extend(words.iter().cloned());
            None
        }
    };
    if let Some(Err(reason)) = small {
        notes.push(format!(
            "No smaller model was written: on all samples it could not be trained ({reason})."
        ));
    }
    Ok(Shrunk {
        run: case.results.name.clone(),
        network: context.name.into(),
        source: case.results.source.to_string(),
        samples: context.dataset.len(),
        protocol: protocol.words(&context.dataset.task()),
        parts: outers.len(),
        inner: outers.iter().map(|outer| outer.inner.len()).max().unwrap_or(0),
        primary: context.primary.clone(),
        margin: context.margin,
        alpha: context.alpha,
        notes,
        whole: mean_score(&whole, context.dataset, protocol, seed)?.unwrap_or((0.0, None)),
        curves: tried.iter().map(|(_, curve)| curve.clone()).collect(),
        left_out,
        combined,
        models: vec![],
        words: vec![],
    })
}

/// Writes what was found out, the page last.
fn finish(out: &Path, shrunk: &Shrunk, speed: Option<&SmallSpeed>) -> Result<PathBuf> {
    let json =
        |value: serde_json::Result<String>, path: &Path| value.map_err(|error| Error::file(path, error));
    let (result, times) = (out.join(RESULT), out.join(SPEED));
    let text = named_scores(shrunk).and_then(|value| serde_json::to_string_pretty(&value));
    write(&result, json(text, &result)?.as_bytes())?;
    match speed {
        Some(speed) => write(&times, json(serde_json::to_string_pretty(speed), &times)?.as_bytes())?,
        // A smaller model of an earlier margin would be none of this one.
        None => [MODEL, CONFIG, SPEED].iter().try_for_each(|name| remove(&out.join(name)))?,
    }
    shrunk_page(shrunk, speed, out)
}

fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::file(path, error)),
        _ => Ok(()),
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    taxel_base::files::write_whole(path, bytes).map_err(|error| Error::file(path, error))
}

fn check(case: &Case, experiment: &Experiment, network: &str, options: &ShrinkOptions) -> Result<()> {
    let ShrinkOptions { margin, alpha, inner, epochs, .. } = *options;
    Criteria { margin, alpha, ..Criteria::default() }.check(&case.primary())?;
    if !(2..=100).contains(&inner) {
        return Err(Error::value("inner", inner, "must be in 2..=100"));
    }
    if epochs == Some(0) {
        return Err(Error::value("epochs", 0, "must be 1 or more"));
    }
    let refuse = |reason: &str| Err(Error::file(case.folder.path(), reason));
    if case.results.protocol.per_class().is_some() {
        return refuse("is a learning curve: shrink a run whose folds train on all samples");
    }
    if !experiment.config().encoding.reduce.is_whole() {
        return refuse("reads less of each sample already (encoding.reduce): shrink the run of the whole");
    }
    let floats = case.results.in_floats(network);
    if floats != network {
        let reason = format!("is in eight bits: shrink {floats:?}, then quantize the smaller model");
        return Err(Error::value("network", network, reason));
    }
    let known = || case.results.networks.iter().map(|row| row.network.as_str());
    if case.records(network).next().is_none() {
        let hint = taxel_base::names::hint(network, known());
        return Err(Error::value("network", network, format!("has no finished fold in this run; {hint}")));
    }
    Ok(())
}

/// Makes the folder with its place for records.
fn prepare(out: &Path, resume: bool) -> Result<PathBuf> {
    let is_used = out.read_dir().is_ok_and(|mut entries| entries.next().is_some());
    if is_used && !resume {
        return Err(Error::file(
            out,
            "exists and is not empty; --resume goes on with it, --output gives another folder",
        ));
    }
    let records = out.join(RECORDS);
    std::fs::create_dir_all(&records).map_err(|error| Error::file(&records, error))?;
    Ok(records)
}

fn context<'a>(
    case: &'a Case,
    experiment: &Experiment,
    network: &'a str,
    options: &ShrinkOptions,
) -> Result<Context<'a>> {
    let (primary, chance) = (case.primary(), case.chance()?);
    let spec = &case.dataset.spec;
    let fewer = || experiment.network(network).map(|network| network.train.epochs.div_ceil(QUICK_EPOCHS));
    let epochs = options.epochs.or(options.quick.then(fewer).flatten());
    let is_sound = |row: &&NetworkResults| {
        // A row in eight bits is no network of the experiment: inner folds cannot train it.
        row.hardening.is_none() && row.quantized.is_none() && row.diverged == 0
    };
    let sound = case.results.networks.iter().filter(is_sound);
    let merit = |row: &&NetworkResults| row.primary().map_or(f64::NEG_INFINITY, |score| primary.merit(score));
    let best = sound.max_by(|a, b| merit(a).total_cmp(&merit(b))).map_or(network, |row| row.network.as_str());
    Ok(Context {
        name: network,
        dataset: &case.dataset,
        sensors: sensors(spec.layout, &spec.shape),
        protocol: case.results.protocol.clone(),
        seed: case.results.seed,
        epochs,
        margin: options.margin.unwrap_or_else(|| primary.share(MARGIN, chance)),
        hopeless: primary.share(HOPELESS, chance),
        alpha: options.alpha,
        // A teacher of full length beside shorter trainings would be no fair look.
        best: if epochs.is_some() { network.into() } else { best.into() },
        primary,
    })
}

/// Returns a ladder for each axis, and why others have none.
fn ladders(
    experiment: &Experiment,
    network: &str,
    dataset: &Dataset,
    registry: &Registry,
    options: &ShrinkOptions,
) -> (Vec<Ladder>, Vec<(String, String)>) {
    let number = |key: &str| experiment.number(network, key, registry);
    let width_mult = experiment.width_mult(network, registry);
    let depth = experiment.depth(network, registry);
    let spec = &dataset.spec;
    let facts = LadderInputs { spec, number: &number, width_mult, depth, quick: options.quick };
    let (mut found, mut left_out) = (vec![], vec![]);
    let wanted: BTreeSet<Axis> = options.axes.iter().copied().collect();
    for axis in wanted {
        match ladder(axis, &facts) {
            Ok(ladder) => found.push(ladder),
            Err(reason) => left_out.push((axis.title().to_string(), reason)),
        }
    }
    (found, left_out)
}

/// Trains the smaller model on everything. Returns it with its experiment.
fn small_model(
    context: &Context,
    cache: &mut Cache,
    case: &Case,
    outers: &[Outer],
    found: &Together,
) -> Result<SmallerModel> {
    let dataset = context.dataset;
    let all: Vec<usize> = (0..dataset.len()).collect();
    let facts = sensor(dataset, &all).sensor;
    let rankings: Vec<Vec<usize>> = outers.iter().map(|outer| outer.part.ranking.clone()).collect();
    let part = TrainingPart { ranking: ranking::together(&rankings), range: [facts.low, facts.high] };
    let cuts: Vec<&Cut> = found.cuts.iter().collect();
    let changes = context.changes(&cuts, &part);
    // Its outputs are those of the run's folds for samples that they had not seen.
    let teacher = cuts.iter().any(|cut| matches!(cut, Cut::Set(..))).then(|| {
        let mut teacher = Teacher::new(SHARE, dataset.len(), dataset.task().outputs());
        case.records(&context.best).for_each(|record| teacher.tell(&record.index, record.outcome.outputs()));
        teacher
    });
    let fold = Fold { train: all, test: vec![], validation: vec![] };
    // No fold of the run has this number.
    let place = (0, u32::MAX as usize);
    let request = Request {
        name: context.name,
        label: "smaller model",
        changes: &changes,
        place,
        fold: &fold,
        teacher: teacher.as_ref(),
    };
    cache.expect(1);
    match cache.train(request) {
        Ok(tested) if tested.record.diverged => Ok(Err("its loss ended far above that of guessing".into())),
        Ok(tested) => Ok(Ok((tested.model.of_everything(), cache.experiment_of(&request)?.clone()))),
        Err(error) if error.is_of_setting() => Ok(Err(said(&error))),
        Err(error) => Err(error),
    }
}

/// Says where time was saved: fewer parts, epochs or inner folds than a full look.
fn notes(case: &Case, context: &Context, outers: &[Outer], options: &ShrinkOptions) -> Vec<String> {
    let mut notes = vec![];
    let all = case.records(context.name).count();
    if outers.len() < all {
        notes.push(format!("A quick look: {} of {all} test parts, with few settings.", outers.len()));
    }
    if let Some(epochs) = context.epochs {
        notes.push(format!(
            "Everything was trained for {epochs} epochs, the whole too, and not as long as in the run: what a full training \
             needs may be less or more."
        ));
    }
    if outers.iter().any(|outer| outer.inner.len() < options.inner) {
        notes.push("A training part has fewer groups than inner folds were asked for.".into());
    }
    notes
}
