//! How long predictions and trainings take.

use super::benchmark::Benchmark;
use super::contrast::Contrast;
use super::finding::{Finding, against_all, lacks};
use taxel::judge::{Effect, Predicted, Result};

/// Tests that each of `quick` takes less time for a prediction than each of `slow`: of one sample on one thread. The interval
/// is that between 95 % of one's predictions and half of the other's, both ways: wider than that of a median.
pub(super) fn predicts_faster(run: &Benchmark, quick: &[&str], slow: &[&str]) -> Result<Finding> {
    let absent = run.absent(&[quick, slow].concat());
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let mut found = vec![];
    for one in quick.iter().filter_map(|zoo| run.find(zoo)) {
        for other in slow.iter().filter_map(|zoo| run.find(zoo)) {
            let (Some(fast), Some(late)) = (one.judged.speed, other.judged.speed) else {
                return Ok(lacks("measured times"));
            };
            let (fast, late) = (fast.network, late.network);
            let measured = Effect {
                size: late.p50_ms - fast.p50_ms,
                interval: Some([late.p50_ms - fast.p95_ms, late.p95_ms - fast.p50_ms]),
                p: None,
                error: None,
            };
            let text = format!("time of a prediction: {} less {}, ms", other.name, one.name);
            found.push(Contrast { margin: None, ..Contrast::new(text, measured, measured) });
        }
    }
    Ok(against_all(0.0, found))
}

/// Tests that `zoo` is trained in less time than each of `others`.
pub(super) fn trains_fastest(run: &Benchmark, zoo: &str, others: &[&str]) -> Result<Finding> {
    let absent = run.absent(&[&[zoo], others].concat());
    let Some(own) = run.find(zoo).filter(|_| absent.is_empty()) else {
        return Ok(lacks(absent.join(", ")));
    };
    if run.comparison.records(&own.name).len() < 2 {
        return Ok(lacks(format!("a second training of {zoo}")));
    }
    let more = |both: &[Predicted]| {
        let [own, other] = [0, 1].map(|at| run.train_seconds(both[at].record()));
        Some(other? - own?)
    };
    let mut found = vec![];
    for other in others.iter().filter_map(|zoo| run.find(zoo)) {
        let text = format!("training: {} less {}, s", other.name, own.name);
        let contrast = run.contrast(text, &[&own.name, &other.name], &more, others.len())?;
        found.extend(contrast.map(|found| Contrast { margin: None, ..found }));
    }
    Ok(if found.is_empty() { lacks("measured times of training") } else { against_all(0.0, found) })
}
