//! Neither encoding nor prediction allocates.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;
#[path = "support/transforms.rs"]
mod transforms;

use allocation_counter::measure;
use ndarray::Axis;
use support::candidates;
use taxel_data::Dataset;
use taxel_learn::certainty::{Certainty, HeldOut, HeldOutParts};
use taxel_learn::metrics::Levels;
use taxel_learn::{Model, fit};
use transforms::{samples, transforms};

/// Does it twice: what is looked up once per process is looked up the first time.
fn allocates_nothing(what: &str, mut work: impl FnMut()) {
    work();
    assert_eq!(measure(work).count_total, 0, "{what}");
}

/// Returns the same model with temperature and gate, fitted to its own samples many times over: to be asked, not to be believed.
fn gated(model: &Model, dataset: &Dataset) -> Model {
    let predictor = model.predictor(8, 1).unwrap();
    let one = predictor.logits(&dataset.x).unwrap();
    let times = 30usize.div_ceil(dataset.len());
    let logits = if predictor.has_logits() { one.repeat(times) } else { vec![] };
    let truth = dataset.targets.labels().unwrap().values().repeat(times);
    let parts = (0..(times * dataset.len()) as u32).map(|row| row % 5).collect();
    let probabilities = predictor.finished(one.repeat(times));
    let rows = (0..times * dataset.len()).map(|row| row % dataset.len()).collect();
    let held = HeldOut { probabilities, logits, truth, parts, rows, ..HeldOut::default() };
    let levels = Levels::of_task(&dataset.task());
    let certainty = Certainty::fit(&held, &levels, HeldOutParts::Mixed, "own", 0).unwrap().unwrap();
    let certainty = certainty.with_logits(&held, &[], &levels);
    let raw = (dataset.spec.layout, &*dataset.x);
    model.clone().with_certainty(Some(certainty.with_readings(&held, raw, &levels)))
}

#[test]
fn neither_encoding_nor_answering_allocates() {
    for (transform, shape) in transforms() {
        let mut compiled = transform.compile(&shape, "one").unwrap();
        let mut input = vec![0.0; compiled.shape().iter().product()];
        let reading: Vec<f32> = samples(&shape).index_axis(Axis(0), 0).iter().copied().collect();
        allocates_nothing(&format!("{transform:?}"), || compiled.encode(&reading, &mut input).unwrap());
    }
    let (dataset, encoding, candidates) = candidates();
    let encoding = taxel_learn::Encoding { guard: true, ..encoding };
    let reading: Vec<f32> = dataset.x.index_axis(Axis(0), 0).iter().copied().collect();
    for candidate in candidates {
        let predictor = fit(&candidate, &dataset, &encoding).unwrap().predictor(8, 1).unwrap();
        let mut workspace = predictor.workspace().unwrap();
        allocates_nothing(&candidate.name, || {
            predictor.predict_one(&mut workspace, &reading).unwrap();
        });
        let gated = gated(&fit(&candidate, &dataset, &encoding).unwrap(), &dataset);
        let certainty = gated.card().certainty.clone().unwrap();
        assert!(certainty.readings.is_some() && certainty.has_gate(), "{}", candidate.name);
        let own = gated.predictor(8, 1).unwrap();
        let mut memory = own.workspace().unwrap();
        allocates_nothing(&format!("{} with temperature and gate", candidate.name), || {
            own.predict_start(&mut memory, &reading, 1.0).unwrap();
            assert!(own.familiarity(&mut memory, 1.0).is_some());
        });
        let mut broken = reading.clone();
        broken[..40].fill(400.0);
        allocates_nothing(&format!("{} behind its guard", candidate.name), || {
            predictor.predict_one(&mut workspace, &broken).unwrap();
        });
        assert_eq!(workspace.found().len(), 1);
    }
}
