//! The same bits behind every encoding, and of values with their intervals.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{C99, Case, Own, SAMPLE, classes, code, values, z_score};
use taxel_encodings::{History, Scaling};
use taxel_firmware::Spread;

/// A history of these lags, scaled row by row.
fn history(lags: &[usize]) -> Own {
    let rows = SAMPLE[0] * (1 + lags.len());
    let wave = |i: usize| (i as f32 * 1.7).sin();
    let mean = (0..rows).map(|i| 20.0 * wave(i)).collect();
    let sd = (0..rows).map(|i| 30.0 + 20.0 * wave(i + 3)).collect();
    Own::History(History { lags: lags.to_vec() }, Scaling::ZScore { mean, sd })
}

#[test]
fn quantile_codes_have_the_same_bits() {
    Case::new("resnet8-lite-1d", code(768, 40), classes(Some(1.4))).has_the_same_bits("cc", &C99);
    // Steps of unequal length, and as many as there are readings.
    Case::new("fcn-1d", code(200, 12), classes(None)).has_the_same_bits("cc", &C99);
    Case::new("mlp", code(60, 50), values(Spread::Alike, Some(0.7))).has_the_same_bits("cc", &C99[1..4]);
}

#[test]
fn histories_have_the_same_bits_and_a_ring_of_their_length() {
    let case = Case::new("deep-mlp", history(&[1, 2, 4, 8, 16, 32]), values(Spread::LogVariance, Some(1.9)));
    case.has_the_same_bits("cc", &C99[..4]);
    assert_eq!(case.library().size().unwrap().ring, 33 * 5 * 4);
    Case::new("mlp", history(&[7]), classes(Some(0.8))).has_the_same_bits("cc", &C99[1..4]);
    Case::new("mlp", history(&[]), classes(None)).has_the_same_bits("cc", &C99[1..4]);
}

#[test]
fn values_and_their_intervals_have_the_same_bits() {
    for spread in [Spread::Alike, Spread::LogVariance, Spread::Quantiles] {
        for half in [None, Some(1.37)] {
            Case::new("resnet8-lite-1d", z_score(), values(spread, half)).has_the_same_bits("cc", &C99[1..4]);
        }
    }
}

#[test]
#[ignore = "needs a C++ compiler"]
fn the_code_is_cpp_as_well() {
    let flags: [&[&str]; 1] = [&["-x", "c++", "-std=c++17", "-O2"]];
    Case::new("resnet8-lite-1d", code(200, 12), values(Spread::Quantiles, Some(1.2)))
        .has_the_same_bits("c++", &flags);
    Case::new("mlp", history(&[3]), classes(None)).has_the_same_bits("c++", &flags);
}

#[test]
fn what_an_encoding_cannot_take_is_refused() {
    let case = Case::new("mlp", history(&[7]), classes(None));
    let mut library = case.library();
    library.sample = [5, 7];
    let error = library.files().unwrap_err().to_string();
    assert!(error.contains("cannot be exported as C") && error.contains('7'), "{error}");
    library.sample = SAMPLE;
    library.answers = values(Spread::LogVariance, None);
    let error = library.files().unwrap_err().to_string();
    assert!(error.contains("it has 3 outputs, and \"force\" 0 in µN need 2"), "{error}");
}
