//! From an opened run folder to its [`Judgement`].

use taxel_trainer::{
    Environment, FoldKey, FoldRecord, NetworkResults, Predictor, Results, RunFolder, Timing,
};

use crate::case::Case;
use crate::error::Result;
use crate::examples::examples;
use crate::judgement::{EpochPoint, Judged, Judgement, Kind};
use crate::speed::Speed;
use crate::stress::{StressOptions, chance, stress};

/// What a judgement may cost, and who hears how far it is.
pub struct Options<'a> {
    /// Faults to try; none leaves the stress test out.
    pub stress: Option<StressOptions>,
    /// Seconds for timing one network.
    pub budget: f64,
    /// Hears what is being done.
    pub say: &'a (dyn Fn(&str) + Sync),
    /// Hears how many steps the stress test has.
    pub start: &'a dyn Fn(u64),
    /// Hears every step of it.
    pub tick: &'a (dyn Fn() + Sync),
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            stress: Some(StressOptions::default()),
            budget: 2.0,
            say: &|_| {},
            start: &|_| {},
            tick: &|| {},
        }
    }
}

/// Measures everything that a report says about a run: speed first, while nothing else runs.
///
/// # Errors
/// Models that are missing or damaged, readings that cannot be broken.
pub fn judge(case: &Case, options: &Options) -> Result<Judgement> {
    let contestants = case.contestants();
    let timings = case.folder.timings()?;
    let mut networks = vec![];
    for own in &case.results.networks {
        let records = case.records(&own.network)?;
        let speed = match records.first() {
            Some(first) if contestants.contains(&own.network.as_str()) => {
                (options.say)(&format!("timing {}", own.network));
                Some(Speed::measure(case, &first.key, options.budget)?)
            }
            _ => None,
        };
        networks.push(judged(case, own, &records, &timings, speed)?);
    }
    mark_front(&mut networks);
    let stress = match &options.stress {
        Some(wanted) => {
            (options.say)("breaking test samples on purpose");
            Some(stress(case, wanted, options.start, options.tick)?)
        }
        None => None,
    };
    let results = Results { networks: vec![], ..case.results.clone() };
    let (seed, source, digest) = (results.seed, results.source.as_str(), results.data_digest.as_str());
    Ok(Judgement {
        kind: if source.starts_with("simulated: ") { Kind::Simulated } else { Kind::Real },
        protocol: results.protocol.words(),
        environment: case.folder.environment()?,
        judged_on: Environment::now(1, seed, source, digest),
        chance: chance(case),
        examples: examples(case)?,
        networks,
        stress,
        results,
    })
}

fn judged(
    case: &Case,
    own: &NetworkResults,
    records: &[FoldRecord],
    timings: &[Timing],
    speed: Option<Speed>,
) -> Result<Judged> {
    let times: Vec<&Timing> = timings.iter().filter(|t| t.key.network == own.network).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let all: Vec<f64> = values.collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    let epochs = records.iter().map(|r| r.epochs.len()).max().unwrap_or(0);
    let per_epoch = times.iter().zip(records).filter(|(_, r)| !r.epochs.is_empty());
    let model = match records.first() {
        Some(first) => Some(case.predictor(&first.key, 1, 1)?),
        None => None,
    };
    Ok(Judged {
        baseline: model.as_ref().is_some_and(|model| model.graph().is_none()),
        inputs: model.iter().flat_map(Predictor::inputs).map(String::from).collect(),
        speed,
        train_seconds: mean(&mut times.iter().map(|t| t.train_seconds)),
        epoch_seconds: (epochs > 0)
            .then(|| mean(&mut per_epoch.map(|(t, r)| t.train_seconds / r.epochs.len() as f64))),
        calibration_error: mean(&mut own.folds.iter().map(|fold| fold.calibration_error)),
        on_front: false,
        training: (0..epochs).map(|epoch| point(epoch, records)).collect(),
        results: own.clone(),
    })
}

/// Mean of one epoch over the folds that got so far.
fn point(epoch: usize, records: &[FoldRecord]) -> EpochPoint {
    let lines: Vec<_> = records.iter().filter_map(|r| r.epochs.get(epoch)).collect();
    let mean = |value: &dyn Fn(&taxel_trainer::Epoch) -> Option<f64>| {
        let all: Vec<f64> = lines.iter().filter_map(|line| value(line)).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    };
    EpochPoint {
        epoch,
        train_loss: mean(&|line| Some(line.train_loss)).unwrap_or(f64::NAN),
        train_accuracy: mean(&|line| Some(line.train_accuracy)).unwrap_or(f64::NAN),
        validation_loss: mean(&|line| line.validation_loss),
        validation_accuracy: mean(&|line| line.validation_accuracy),
    }
}

/// Marks those for which no other is at least as fast and at least as accurate, and better in one.
fn mark_front(networks: &mut [Judged]) {
    let place = |n: &Judged| Some((n.speed?.whole_p50_ms, n.results.mean?.accuracy));
    let places: Vec<Option<(f64, f64)>> = networks.iter().map(place).collect();
    for (network, own) in networks.iter_mut().zip(&places) {
        let Some((ms, accuracy)) = *own else { continue };
        let beaten = places.iter().flatten().any(|&(other_ms, other)| {
            other_ms <= ms && other >= accuracy && (other_ms < ms || other > accuracy)
        });
        network.on_front = !beaten;
    }
}

impl Judgement {
    /// The judgement in a run folder, if there is one and it is about the run as it is now.
    ///
    /// # Errors
    /// A damaged file.
    pub fn read(case: &Case) -> Result<Option<Self>> {
        let read: Option<Judgement> = case.folder.read("judgement.json")?;
        let own = |j: &Judgement| {
            let networks: Vec<&NetworkResults> = j.networks.iter().map(|n| &n.results).collect();
            let now: Vec<&NetworkResults> = case.results.networks.iter().collect();
            networks == now && j.results.data_digest == case.results.data_digest
        };
        Ok(read.filter(own))
    }

    /// Writes the judgement into its run folder, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &RunFolder) -> Result<()> {
        Ok(folder.write("judgement.json", self)?)
    }
}

/// Key of the first fold of a network.
pub(crate) fn first_fold(network: &str) -> FoldKey {
    FoldKey { network: network.into(), repetition: 0, fold: 0 }
}
