//! The networks of a finished run in eight bits, as rows of their own beside those in floats.

use std::time::Instant;

use ndarray::Axis;
use taxel_data::{Dataset, Fold};

use crate::error::{Error, Result};
use crate::estimator::candidate::Hardening;
use crate::json_file::write_json;
use crate::metrics::Outcome;
use crate::model::{Model, TrainedOn};
use crate::run::assemble::{assemble, fill};
use crate::run::folder::RunFolder;
use crate::run::model_latency::of_model;
use crate::run::records::{Costs, FoldKey, FoldRecord, Timing};
use crate::run::results::{FoldScores, NetworkResults, Results, ScoringContext};

/// Puts every network of a finished run beside itself in eight bits, as `<name>.int8`: each fold's model, calibrated on
/// training samples of that fold and tested on its test samples. Rows that were there before are measured again. Gives
/// the names of the new rows. `say` hears what is being done.
///
/// # Errors
/// A run that is not finished or was run on other samples, models that are missing or damaged, a folder that somebody
/// else writes to.
pub fn quantize_run(folder: &RunFolder, dataset: &Dataset, say: &dyn Fn(&str)) -> Result<Vec<String>> {
    let _lock = folder.lock()?;
    let (mut results, records) = folder.finished(dataset)?;
    if !results.complete {
        return Err(Error::folder(folder.path(), "is not finished; resume the run first"));
    }
    results.networks.retain(|row| row.quantized.is_none());
    let folds: Vec<Vec<Fold>> = (0..results.protocol.repetitions())
        .map(|repetition| results.protocol.folds(dataset, results.seed, repetition))
        .collect::<Result<_>>()?;
    let frame = ScoringContext::of(dataset, &results.look_alikes)?;
    let (mut rows, mut made, mut all) = (vec![], vec![], vec![]);
    for float in std::mem::take(&mut results.networks) {
        let of_row: Vec<FoldRecord> =
            records.iter().filter(|record| record.key.network == float.network).cloned().collect();
        let Some(first) = of_row.first() else {
            rows.push(float);
            continue;
        };
        let unmet = float.hardening.as_ref().is_some_and(|how| how.unmet.is_some());
        let is_network = folder.model(first)?.card().graph().is_some();
        let row = row(&float);
        all.extend(of_row.iter().cloned());
        if is_network && !unmet {
            say(&format!("{}: {} folds", row.network, of_row.len()));
            let fold = |record: &FoldRecord| {
                let train = train(folder, &results, &float, &folds, &record.key)?;
                one(folder, dataset, &row, (record, train))
            };
            let (new, costs): (Vec<_>, Vec<_>) =
                of_row.iter().map(fold).collect::<Result<Vec<_>>>()?.into_iter().unzip();
            all.extend(new);
            made.push(row.network.clone());
            rows.push(float);
            rows.push(NetworkResults { costs: costs.first().copied().unwrap_or(row.costs), ..row });
        } else {
            rows.push(float);
        }
    }
    results.networks = rows;
    let keys: Vec<FoldKey> = all.iter().map(|record| record.key.clone()).collect();
    fill(&mut results, &keys, &all, &frame)?;
    let timings = keys.iter().filter_map(|key| folder.timing(key).transpose()).collect::<Result<Vec<_>>>()?;
    assemble(folder, &results, &all, &timings)?;
    Ok(made)
}

/// Rows in eight bits of an earlier run of the folder that still stand beside their networks, with their records:
/// those of which `done` holds every fold of the network.
///
/// # Errors
/// A damaged record.
pub(crate) fn kept(
    folder: &RunFolder,
    before: Results,
    done: &[FoldRecord],
    dataset: &Dataset,
) -> Result<Vec<(NetworkResults, Vec<FoldRecord>)>> {
    let mut rows = vec![];
    for row in before.networks {
        let Some(float) = &row.quantized else { continue };
        let key = |network: &String, fold: &FoldScores| FoldKey {
            network: network.clone(),
            repetition: fold.repetition,
            fold: fold.fold,
        };
        let is_done = |fold: &FoldScores| done.iter().any(|record| record.key == key(float, fold));
        let mut records = vec![];
        for key_of in row.folds.iter().filter(|fold| is_done(fold)).map(|fold| key(&row.network, fold)) {
            let Some(record) = folder.record(&key_of)? else { continue };
            folder.check(&record, &key_of, dataset)?;
            records.push(record);
        }
        if !records.is_empty() && records.len() == row.folds.len() {
            rows.push((row, records));
        }
    }
    Ok(rows)
}

/// Makes the row in eight bits. Its scores are still those in floats, until they are computed.
fn row(float: &NetworkResults) -> NetworkResults {
    NetworkResults {
        network: format!("{}.int8", float.network),
        candidate: format!("{}.int8", float.candidate),
        // What is published was not measured so.
        published: None,
        other_statistics: None,
        changes: vec![],
        drawn: vec![],
        // Its twin is in eight bits, too.
        hardening: float
            .hardening
            .clone()
            .map(|how| Hardening { clean: how.clean.map(|clean| format!("{clean}.int8")), ..how }),
        quantized: Some(float.network.clone()),
        ..float.clone()
    }
}

/// Returns the training samples of a fold.
fn train<'f>(
    folder: &RunFolder,
    results: &Results,
    row: &NetworkResults,
    folds: &'f [Vec<Fold>],
    key: &FoldKey,
) -> Result<&'f [usize]> {
    // In a learning curve the number of samples says which.
    let counts = results.protocol.per_class().unwrap_or_default();
    let at =
        row.per_class.and_then(|count| counts.iter().position(|known| *known == count)).unwrap_or(key.fold);
    let fold = folds.get(key.repetition).and_then(|folds| folds.get(at));
    fold.map(|fold| fold.train.as_slice()).ok_or_else(|| {
        let reason = format!("holds a fold that its protocol does not make: {key}");
        Error::damaged(&folder.file("results.json"), reason)
    })
}

/// Computes one fold in eight bits and writes its model, record and timing. Returns the record and what the model
/// costs.
fn one(
    folder: &RunFolder,
    dataset: &Dataset,
    row: &NetworkResults,
    (float, train): (&FoldRecord, &[usize]),
) -> Result<(FoldRecord, Costs)> {
    let key = FoldKey { network: row.network.clone(), ..float.key.clone() };
    let start = Instant::now();
    let before = folder.model(float)?;
    let model = before.quantized(&dataset.x.select(Axis(0), train), &dataset.digest)?;
    let model = model.renamed(&row.candidate);
    let train_seconds = start.elapsed().as_secs_f64();
    let predictor = model.predictor(model.card().batch(), 1)?;
    let inputs = predictor.encode(&dataset.x.select(Axis(0), &float.index))?;
    let start = Instant::now();
    let outputs = predictor.predict_encoded(&inputs)?;
    let test_seconds = start.elapsed().as_secs_f64();
    let outcome =
        Outcome::new(&dataset.targets, &float.index, outputs).with_training(&dataset.targets, train);
    let record = FoldRecord {
        key: key.clone(),
        model: Some(model.write(&folder.model_path(&key))?),
        test_loss: outcome.loss(&dataset.task())?,
        outcome,
        chosen: None,
        best_epoch: None,
        costs: None,
        changes: vec![],
        other_statistics: None,
        epochs: vec![],
        ..float.clone()
    };
    let is_first = (float.key.repetition, float.key.fold) == (0, 0);
    let TrainedOn { samples, .. } = model.card().trained_on;
    let timing = Timing {
        key: key.clone(),
        train_seconds,
        samples: samples as u64,
        test_seconds,
        threads: 1,
        encoding_ms_per_sample: folder
            .timing(&float.key)?
            .map_or(0.0, |timing| timing.encoding_ms_per_sample),
        latency_without_encoding: None,
        latency: if is_first { Some(of_model(&model, dataset, float.index[0])?) } else { None },
    };
    write_json(&folder.timing_path(&key), &timing, false)?;
    write_json(&folder.record_path(&key), &record, false)?;
    Ok((record, costs(&model, row.costs)))
}

/// Returns the costs in floats, less three of four bytes of each weight in eight bits.
fn costs(model: &Model, float: Costs) -> Costs {
    let (mut weights, mut outputs) = (0, 0);
    for (name, tensor) in model.weights().iter() {
        if model.is_rounded(name) {
            weights += tensor.data.len() as u64;
            outputs += tensor.shape.first().copied().unwrap_or(0) as u64;
        }
    }
    Costs { bytes: float.bytes - 3 * weights + 4 * outputs, ..float }
}
