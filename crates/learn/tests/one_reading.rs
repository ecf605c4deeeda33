//! One raw reading after the other: the inputs and predictions of many at once, bit for bit.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;
#[path = "support/transforms.rs"]
mod transforms;

use ndarray::Axis;
use support::{bits, candidates};
use taxel_learn::fit;
use transforms::{samples, transforms};

#[test]
fn one_reading_becomes_the_input_of_many_bit_for_bit() {
    for (transform, shape) in transforms() {
        let x = samples(&shape);
        let all = transform.apply(&x, "many").unwrap();
        let mut compiled = transform.compile(&shape, "one").unwrap();
        assert_eq!(compiled.shape(), &all.shape()[1..], "{transform:?}");
        let mut input = vec![f32::NAN; compiled.shape().iter().product()];
        for (one, want) in x.outer_iter().zip(all.outer_iter()) {
            let reading: Vec<f32> = one.iter().copied().collect();
            compiled.encode(&reading, &mut input).unwrap();
            let want: Vec<f32> = want.iter().copied().collect();
            assert_eq!(bits(&input), bits(&want), "{transform:?}");
        }
    }
}

#[test]
fn what_cannot_be_encoded_is_refused_as_among_many() {
    for (transform, shape) in transforms() {
        let n = shape.iter().product::<usize>();
        let mut compiled = transform.compile(&shape, "one").unwrap();
        let mut input = vec![0.0; compiled.shape().iter().product()];
        let reading = vec![f32::NAN; n];
        let error = compiled.encode(&reading, &mut input).unwrap_err().to_string();
        assert!(error.contains("NaN") && error.starts_with("one: "), "{transform:?}: {error}");
        let short: Vec<f32> = samples(&shape).into_iter().take(n - 1).collect();
        let error = compiled.encode(&short, &mut input).unwrap_err().to_string();
        assert!(error.contains(&format!("expected {n} values")), "{transform:?}: {error}");
        // Axes that the array's way refuses, too.
        let other = [&[2, 2, 2][..], &shape].concat();
        let many = transform.apply(&samples(&other), "one").unwrap_err().to_string();
        assert_eq!(transform.compile(&other, "one").unwrap_err().to_string(), many);
    }
}

#[test]
fn one_reading_gets_the_answer_of_many_bit_for_bit() {
    let (dataset, encoding, candidates) = candidates();
    for candidate in candidates {
        let predictor = fit(&candidate, &dataset, &encoding).unwrap().predictor(8, 1).unwrap();
        let all = predictor.predict(&dataset.x).unwrap();
        let mut workspace = predictor.workspace().unwrap();
        for (row, want) in all.outputs.chunks(all.width()).enumerate() {
            let reading: Vec<f32> = dataset.x.index_axis(Axis(0), row).iter().copied().collect();
            let prediction = predictor.predict_one(&mut workspace, &reading).unwrap();
            assert_eq!(bits(prediction), bits(want), "{}, sample {row}", candidate.name);
        }
        let error = predictor.predict_one(&mut workspace, &[0.0]).unwrap_err().to_string();
        assert!(error.contains("this one has 1 values"), "{error}");
    }
}

/// Threads share a predictor, each with a workspace of its own.
#[test]
fn threads_share_a_predictor() {
    fn shared<T: Send + Sync>() {}
    shared::<taxel_learn::Predictor>();
    fn moved<T: Send>() {}
    moved::<taxel_learn::Workspace>();
}
