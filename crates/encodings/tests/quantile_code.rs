//! The quantile code against NumPy (`scripts/fixtures/quantile_code.py`), what holds for all readings, and what
//! is refused.

#![allow(clippy::unwrap_used)]

use std::ops::Range;

use ndarray::{Array3, ArrayD, Axis, Slice, concatenate};
use npyz::npz::NpzArchive;
use proptest::prelude::*;
use taxel_encodings::QuantileCode;

fn array(name: &str) -> Array3<f32> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/quantile_code.npz");
    let mut archive = NpzArchive::open(path).unwrap();
    let file = archive.by_name(name).unwrap().unwrap();
    let shape: Vec<usize> = file.shape().iter().map(|&n| n as usize).collect();
    let values: Vec<f32> = file.into_vec().unwrap();
    ArrayD::from_shape_vec(shape, values).unwrap().into_dimensionality().unwrap()
}

/// Some samples, channels or steps in time.
fn part(x: &Array3<f32>, axis: usize, range: Range<usize>) -> Array3<f32> {
    x.slice_axis(Axis(axis), Slice::from(range)).to_owned()
}

fn fitted(train: &Array3<f32>) -> QuantileCode {
    QuantileCode::default().fit(train.view()).unwrap()
}

#[test]
fn agrees_with_numpy() {
    for case in ["plain", "coarse", "resting", "short", "one_step", "many_channels", "constant"] {
        let [train, test, want] = ["train", "test", "code"].map(|part| array(&format!("{case}_{part}")));
        let code = fitted(&train);
        let x = concatenate(Axis(0), &[part(&train, 0, 0..1).view(), test.view()]).unwrap();
        let got = code.encode_batch(x.view()).unwrap();
        assert_eq!(got.shape(), want.shape(), "{case}");
        assert_eq!(code.shape(x.shape()[1], x.shape()[2]), want.shape()[1..], "{case}");
        for ((at, got), want) in got.indexed_iter().zip(&want) {
            // Neighbouring edges may be a thousandth of the readings apart.
            assert!((got - want).abs() <= 1e-3, "{case} {at:?}: {got} and {want}");
        }
    }
}

/// A wrong edge, a wrong view or a wrong mean over time is far more than the bound above.
#[test]
fn the_code_of_numpy_is_not_of_other_readings() {
    let [train, test, want] = ["train", "test", "code"].map(|part| array(&format!("plain_{part}")));
    let got = fitted(&train).encode_batch(test.view()).unwrap();
    let moved = (&got - &part(&want, 0, 0..3)).mapv(f32::abs);
    assert!(moved.iter().filter(|gap| **gap > 0.1).count() > got.len() / 20);
}

#[test]
fn the_fit_comes_back_from_a_file_bit_for_bit() {
    let [train, test] = ["train", "test"].map(|part| array(&format!("plain_{part}")));
    let code = fitted(&train);
    let read: QuantileCode = serde_json::from_str(&serde_json::to_string(&code).unwrap()).unwrap();
    assert_eq!(read, code);
    assert_eq!(read.encode_batch(test.view()).unwrap(), code.encode_batch(test.view()).unwrap());
}

#[test]
fn what_does_not_fit_is_refused() {
    let [train, mut test] = ["train", "test"].map(|part| array(&format!("plain_{part}")));
    let code = fitted(&train);
    let refused = |x: &Array3<f32>| code.encode_batch(x.view()).unwrap_err().to_string();
    let four = part(&test, 1, 0..4);
    assert!(refused(&four).starts_with("readings: expected [N, 5, T], the channels that were fitted"));
    assert!(refused(&Array3::zeros((1, 5, 0))).starts_with("readings: expected [N, 5, T]"));
    test[[1, 2, 3]] = f32::NAN;
    assert!(refused(&test).starts_with("reading 3 of channel 2 of sample 1 is NaN"));
    let error = QuantileCode::default().fit(test.view()).unwrap_err().to_string();
    assert!(error.starts_with("reading 3 of channel 2 of sample 1 is NaN"), "{error}");
    let error = QuantileCode::default().fit(Array3::zeros((0, 5, 9)).view()).unwrap_err().to_string();
    assert!(error.starts_with("training data: expected at least one reading"), "{error}");
    let unfitted = QuantileCode::default().encode_batch(train.view()).unwrap_err().to_string();
    assert!(unfitted.starts_with("readings: expected [N, 0, T]"), "{unfitted}");

    let json = serde_json::to_value(&code).unwrap();
    let spoiled = |key: &str, value: serde_json::Value| {
        let mut json = json.clone();
        json["views"][6][key] = value;
        let code: QuantileCode = serde_json::from_value(json).unwrap();
        code.encode_batch(train.view()).unwrap_err().to_string()
    };
    assert_eq!(spoiled("sd", 0.0.into()), "sd of view 2 of channel 1 = 0: must be positive and finite");
    let edges = spoiled("edges", vec![1.0, 1.0].into());
    assert_eq!(edges, "edge of view 2 of channel 1 = 1: must be ascending and finite");
    // Descending; and so near each other that a ramp between them has no finite slope.
    for edges in [vec![2.0, 1.0], vec![0.0, 1e-40]] {
        assert!(spoiled("edges", edges.into()).ends_with("must be ascending and finite"));
    }
    let many: Vec<f32> = (0..26u8).map(f32::from).collect();
    assert!(spoiled("edges", many.into()).starts_with("number of edges of view 2 of channel 1 = 26"));
}

fn readings() -> impl Strategy<Value = Array3<f32>> {
    let size = (2usize..6, 1usize..4, 1usize..60);
    size.prop_flat_map(|(n, channels, length)| {
        // Coarse, fine and huge readings.
        let value = prop_oneof![
            (0i8..6).prop_map(f32::from),
            -1f32..1.0,
            prop_oneof![Just(-3e37f32), Just(1e-30), Just(3e37)]
        ];
        proptest::collection::vec(value, n * channels * length)
            .prop_map(move |values| Array3::from_shape_vec((n, channels, length), values).unwrap())
    })
}

proptest! {
    #[test]
    fn ramps_lie_in_0_to_1_and_scores_within_8(x in readings()) {
        let code = fitted(&part(&x, 0, 1..x.shape()[0]));
        let got = code.encode_batch(x.view()).unwrap();
        let scores = got.shape()[1] - 4 * x.shape()[1];
        prop_assert!(part(&got, 1, 0..scores).iter().all(|v| (0.0..=1.0 + 1e-6).contains(v)));
        let scores = part(&got, 1, scores..got.shape()[1]);
        prop_assert!(scores.iter().all(|v| (-8.001..=8.001).contains(v)));
    }

    #[test]
    fn samples_do_not_see_each_other(x in readings()) {
        let code = fitted(&x);
        let all = code.encode_batch(x.view()).unwrap();
        for (sample, want) in x.axis_chunks_iter(Axis(0), 1).zip(all.axis_chunks_iter(Axis(0), 1)) {
            prop_assert_eq!(code.encode_batch(sample).unwrap(), want);
        }
    }

    /// In which order the training samples come changes no edge.
    #[test]
    fn the_order_of_the_samples_changes_nothing(x in readings()) {
        let mut turned = x.clone();
        turned.invert_axis(Axis(0));
        let edges = |code: QuantileCode| {
            let json = serde_json::to_value(code).unwrap();
            json["views"].as_array().unwrap().iter().map(|view| view["edges"].clone()).collect::<Vec<_>>()
        };
        prop_assert_eq!(edges(fitted(&x)), edges(fitted(&turned)));
    }

    /// One reading more in one view moves no ramp of it down.
    #[test]
    fn larger_readings_have_larger_ramps(x in readings(), more in 0f32..3.0) {
        let code = fitted(&x);
        let rows = (code.shape(x.shape()[1], 1)[0] - 4 * x.shape()[1]) / (4 * x.shape()[1]);
        let ramps = |x: &Array3<f32>| part(&code.encode_batch(x.view()).unwrap(), 1, 0..rows);
        let (low, high) = (ramps(&x), ramps(&x.mapv(|v| v + more)));
        prop_assert!(low.iter().zip(&high).all(|(low, high)| *low <= *high + 1e-6));
    }
}
