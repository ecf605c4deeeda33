//! Predictions of the models of a row's folds for the samples that they have not seen, and for their beginnings.

use ndarray::{ArrayD, Axis};
use rayon::prelude::*;
use taxel_learn::FoldKey;
use taxel_learn::certainty::{Gates, HeldOut, Place, fitted_apart};

use super::apart::Apart;
use super::early::{SHARES, started};
use super::guarding::trained_on;
use super::parts::{BATCH, outcome, parts, predict};
use super::threads::on;
use crate::case::Case;
use crate::error::Result;

/// Most test samples of a row whose beginnings are predicted; the others are left out evenly.
const BEGINNINGS: usize = 1000;

/// Predictions of the models of one row for the test samples of their folds, of the first repetition.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutRow {
    /// With logits, if the method has any.
    pub whole: HeldOut,
    /// For the first tenth of each sample, the first two tenths, ..., the whole; nothing for samples without time.
    pub starts: Vec<HeldOut>,
}

/// Predicts the test samples of the row `name` and their beginnings on `threads` threads. None of values.
///
/// # Errors
/// Models that are missing.
pub fn held_out(case: &Case, name: &str, threads: usize) -> Result<Option<HeldOutRow>> {
    let Some(none) = no_samples(case, name)? else { return Ok(None) };
    let mut whole = vec![none.clone()];
    let alone = |clean: &ArrayD<f32>| vec![clean.clone()];
    gather(case, (name, usize::MAX), threads, &mut whole, &alone)?;
    let spec = &case.dataset.spec;
    let (_, ticks, _) = spec.around_time();
    let mut starts = vec![];
    if spec.layout.time_axis().is_some() && ticks > 1 {
        starts = vec![none; SHARES.len()];
        let begun =
            |clean: &ArrayD<f32>| SHARES.map(|seen| started(case, clean, seen, spec.padding())).into();
        gather(case, (name, BEGINNINGS), threads, &mut starts, &begun)?;
    }
    Ok(whole.pop().map(|whole| HeldOutRow { whole, starts }))
}

/// Fits temperature and gates of each fold of the rows `names` to at most `most` test samples of the other folds. Of values, which
/// have no probabilities, the gate of readings.
///
/// # Errors
/// Models that are missing.
pub(super) fn apart(case: &Case, names: &[&str], most: usize, threads: usize) -> Result<Apart> {
    let mut all = Apart::new();
    if case.dataset.targets.labels().is_none() {
        for name in names {
            all.extend(of_readings(case, name, most)?);
        }
        return Ok(all);
    }
    for name in names {
        let Some(none) = no_samples(case, name)? else { return Ok(all) };
        let mut whole = vec![none];
        gather(case, (name, most), threads, &mut whole, &|clean| vec![clean.clone()])?;
        let raw = (case.dataset.spec.layout, &*case.dataset.x);
        let (levels, keeps_groups) = (case.levels(), case.results.protocol.keeps_groups());
        let of_folds = whole.iter().flat_map(|held| fitted_apart(held, raw, &levels, keeps_groups));
        all.extend(of_folds.map(|(fold, fitted)| ((name.to_string(), fold), fitted)));
    }
    Ok(all)
}

/// Fits the gate of readings of each fold of a row to at most `most` test samples of the other folds.
fn of_readings(case: &Case, name: &str, most: usize) -> Result<Apart> {
    let raw = (case.dataset.spec.layout, &*case.dataset.x);
    let groups = case.dataset.groups.as_deref().filter(|_| case.results.protocol.keeps_groups());
    let (parts, _) = parts(case, &[name], most)?;
    let of_fold = |fold: usize| {
        let others = parts.iter().filter(|part| parts.len() == 1 || part.fold != fold);
        let rows: Vec<usize> = others.flat_map(|part| part.rows.iter().copied()).collect();
        let groups: Option<Vec<u32>> = groups.map(|groups| rows.iter().map(|row| groups[*row]).collect());
        ((name.to_string(), fold as u32), (1.0, Gates::of_readings(&rows, groups.as_deref(), raw)))
    };
    Ok(parts.iter().map(|part| of_fold(part.fold)).collect())
}

/// Begins without samples, but with the places of the models of a row. None of values.
fn no_samples(case: &Case, name: &str) -> Result<Option<HeldOut>> {
    let Some(mut none) = HeldOut::of_dataset(&case.dataset) else { return Ok(None) };
    for record in case.first_repetition(name) {
        let places = places_of(case, &record.key)?;
        none.places.extend(places.map(|places| (record.key.fold as u32, places)));
    }
    Ok(Some(none))
}

/// Finds where the network of a fold has the samples that it was trained on. None of a baseline, and where one cannot be
/// encoded.
fn places_of(case: &Case, key: &FoldKey) -> Result<Option<Vec<Place>>> {
    let model = case.model(key)?;
    if model.card().graph().is_none() {
        return Ok(None);
    }
    // A record that is not the protocol's is scored all the same.
    let Ok(rows) = trained_on(case, key) else { return Ok(None) };
    let samples = case.dataset.x.select(Axis(0), &rows);
    let Ok(logits) = model.predictor(BATCH, 1)?.logits(&samples) else { return Ok(None) };
    let labels = case.dataset.targets.labels().map_or(vec![], |labels| labels.of(&rows));
    Ok(Place::of_logits(&logits, &labels, &case.levels()))
}

/// Predicts what `inputs` makes of the test samples of each part, and adds each to its own of `all`.
fn gather(
    case: &Case,
    (name, most): (&str, usize),
    threads: usize,
    all: &mut [HeldOut],
    inputs: &dyn Fn(&ArrayD<f32>) -> Vec<ArrayD<f32>>,
) -> Result<()> {
    let (parts, _) = parts(case, &[name], most)?;
    for part in &parts {
        let clean = case.dataset.x.select(Axis(0), &part.rows);
        let inputs = inputs(&clean);
        for key in &part.keys {
            let predictor = case.model(key)?.predictor(BATCH, 1)?;
            let predict =
                || inputs.par_iter().map(|x| predict(&predictor, &clean, x)).collect::<Result<Vec<_>>>();
            let outputs = on(taxel_learn::threads(Some(threads)), predict)?;
            for (held, outputs) in all.iter_mut().zip(outputs) {
                let refused = outputs.refused.clone();
                let logits = if predictor.has_logits() { outputs.logits.clone() } else { vec![] };
                let outcome = outcome(&case.dataset.targets, part, outputs);
                held.add(part.fold as u32, &part.rows, &outcome, &logits, &case.dataset, &refused);
            }
        }
    }
    Ok(())
}
