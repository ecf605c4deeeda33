//! Neither encoding nor prediction allocates.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;
#[path = "support/transforms.rs"]
mod transforms;

use allocation_counter::measure;
use ndarray::Axis;
use support::candidates;
use taxel_learn::fit;
use transforms::{samples, transforms};

/// Does it twice: what is looked up once per process is looked up the first time.
fn allocates_nothing(what: &str, mut work: impl FnMut()) {
    work();
    assert_eq!(measure(work).count_total, 0, "{what}");
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
        let mut broken = reading.clone();
        broken[..40].fill(400.0);
        allocates_nothing(&format!("{} behind its guard", candidate.name), || {
            predictor.predict_one(&mut workspace, &broken).unwrap();
        });
        assert_eq!(workspace.found().len(), 1);
    }
}
