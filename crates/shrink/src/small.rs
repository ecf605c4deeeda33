//! The smaller model beside the whole: what each reads, is and costs.

use ndarray::Axis;
use taxel_judge::Case;
use taxel_learn::metrics::Scores;
use taxel_learn::{Costs, FoldRecord, Model, Reduction, Score};

use crate::combine::Together;
use crate::error::{Error, Result};
use crate::shrunk::{ModelSummary, Shrunk, SmallSpeed};

/// Seconds that timing a model takes at most.
const BUDGET: f64 = 2.0;

/// Returns both models of a shrunk run: of the smaller one what was `found`, trained on everything.
///
/// # Errors
/// A reduction that does not fit the samples.
pub fn pair(
    case: &Case,
    shrunk: &Shrunk,
    found: &Together,
    model: &Model,
    reduction: &Reduction,
) -> Result<Vec<ModelSummary>> {
    let spec = &case.dataset.spec;
    let plan = reduction.plan(spec.layout, &spec.shape);
    let plan = plan.map_err(|error| Error::value("axes", reduction.words(), error.to_string()))?;
    let row = case.results.networks.iter().find(|row| row.network == shrunk.network);
    let whole = row.map_or(Costs { parameters: 0, bytes: 0, macs: 0, flops: 0 }, |row| row.costs);
    // A baseline has no graph, and says what it costs; as in the table of a run, the most that any fold needs.
    let fitted = found
        .records
        .iter()
        .filter_map(|record| record.costs)
        .max_by_key(|costs| (costs.macs, costs.parameters));
    let costs = model.card().graph().map(|graph| graph.cost().into()).or(fitted).unwrap_or(whole);
    let small = |name: &str, reads: String, readings, (score, score_interval), costs: Costs| {
        let Costs { parameters, bytes, macs, .. } = costs;
        ModelSummary { name: name.into(), reads, readings, score, score_interval, parameters, macs, bytes }
    };
    let outer = &found.combined.outer;
    let scored = (outer.score, outer.score_interval);
    Ok(vec![
        small("whole", "everything".into(), spec.shape.iter().product(), shrunk.whole, whole),
        small("shrunk", reduction.words(), plan.shape().iter().product(), scored, costs),
    ])
}

/// Measures how long a prediction of either takes on this machine.
///
/// # Errors
/// A model that cannot be read, or that refuses a sample.
pub fn speed(case: &Case, network: &str, small: &Model) -> Result<SmallSpeed> {
    let Some(record) = case.records(network).next() else {
        return Err(Error::file(case.folder.path(), "has no finished fold of the network"));
    };
    let whole = case.model(&record.key)?;
    let samples = case.dataset.x.select(Axis(0), &record.index);
    let time = |model: &Model| taxel_judge::speed(model, &samples, BUDGET);
    let (whole, small) = (time(&whole)?.whole, time(small)?.whole);
    Ok(SmallSpeed {
        whole_p50_ms: whole.p50_ms,
        whole_p95_ms: whole.p95_ms,
        small_p50_ms: small.p50_ms,
        small_p95_ms: small.p95_ms,
    })
}

/// Returns the score of the smaller model's recipe on the test parts.
///
/// # Errors
/// Damaged records.
pub fn score(case: &Case, records: &[FoldRecord], interval: Option<[f64; 2]>) -> Result<Option<Score>> {
    let each: Vec<Scores> =
        records.iter().map(|record| Ok(record.scores(case.task())?)).collect::<Result<_>>()?;
    let (Some(mean), sd) = Scores::mean_sd(&each.iter().collect::<Vec<_>>()) else { return Ok(None) };
    let protocol = case.results.protocol.clone();
    Ok(Some(Score { protocol, folds: each.len(), mean, sd, interval }))
}
