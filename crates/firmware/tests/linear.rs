//! MiniRocket with ridge, ridge alone and gates: the same bits as the kernels'.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::linear::{convolutions, with_library};
use common::{C99, Case, SAMPLE, classes, gated, has_the_same_bits, samples, values, z_score};
use taxel_encodings::Scaling;
use taxel_firmware::{Answers, Encoding, Expected, Features, Library, Linear, Method, Spread};

/// Compares a linear model on features of scaled samples.
fn same_bits(name: &str, features: Features, scaling: &Scaling, answers: &Answers) {
    with_library(name, features, scaling, answers, |library| {
        let home = tempfile::tempdir().unwrap();
        has_the_same_bits(library, &home.path().join("firmware"), "cc", &C99);
    });
}

#[test]
fn rockets_and_ridges_have_the_same_bits() {
    let common::Own::Scaled(scaling) = z_score() else { panic!("a scale") };
    let convolutions = convolutions();
    let rocket = |levels| Features::Rocket { convolutions: &convolutions, levels };
    same_bits("rocket", rocket(false), &scaling, &classes(Some(0.7)));
    same_bits("rocket values", rocket(true), &Scaling::Raw, &values(Spread::Alike, Some(2.3)));
    same_bits("gated rocket", rocket(false), &scaling, &gated());
    same_bits("ridge", Features::Readings, &scaling, &values(Spread::Alike, None));
}

#[test]
fn gates_have_the_same_bits() {
    let case = Case::new("resnet8-lite-1d", z_score(), gated());
    let unknown = case.expected.gate.iter().filter(|(_, unknown)| *unknown).count();
    let mut distances: Vec<f32> = case.expected.gate.iter().map(|(distance, _)| *distance).collect();
    distances.sort_by(f32::total_cmp);
    assert!((20..180).contains(&unknown), "{unknown} of 200 are unknown, half are below {}", distances[100]);
    case.has_the_same_bits("cc", &C99);
}

#[test]
fn weights_of_another_number_are_refused() {
    let method = Method::Linear(Linear { features: Features::Readings, weights: &[1.0; 7], bias: &[0.0] });
    let encoding = (Encoding::Scaled(&Scaling::Raw), SAMPLE);
    let library = Library::new("ridge", method, encoding, classes(None), samples(), Expected::default());
    let error = library.size().unwrap_err().to_string();
    assert!(error.contains("it has 7 weights for 250 features"), "{error}");
}
