//! MiniRocket with ridge, ridge alone and gates: the same bits as the kernels'.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{
    C99, Case, OUTPUTS, SAMPLE, answered, classes, gated, has_the_same_bits, samples, values, z_score,
};
use taxel_encodings::Scaling;
use taxel_firmware::{Answers, Encoding, Expected, Features, Library, Linear, Method, Spread};
use taxel_kernels::double;
use taxel_kernels::rocket::{Dilated, Rocket};

/// Convolutions of all kinds: dilations up to the length of a sample, one channel or several, with and without ends.
fn convolutions() -> Vec<Dilated> {
    let [channels, length] = SAMPLE;
    let one = |i: usize| {
        let dilation = 1 + i % ((length - 1) / 8);
        let inner = if i.is_multiple_of(2) { 0 } else { 4 * dilation };
        Dilated {
            dilation,
            twos: [i % 3, 3 + i % 2, 6 + i % 3],
            channels: (0..1 + i % channels).rev().collect(),
            biases: (0..i * 5 % 17).map(|b| ((b * 13 + i) as f32 * 0.37).sin() * 1.7).collect(),
            counted: inner..length - inner,
        }
    };
    (0..40).map(one).collect()
}

fn levels(recording: &[f32]) -> Vec<f32> {
    let channels = || recording.chunks(SAMPLE[1]);
    let mean =
        |channel: &[f32]| (channel.iter().map(|v| f64::from(*v)).sum::<f64>() / channel.len() as f64) as f32;
    channels().map(|channel| channel[SAMPLE[1] - 1]).chain(channels().map(mean)).collect()
}

/// Compares a linear model on features of scaled samples.
fn same_bits(name: &str, features: Features, scaling: &Scaling, answers: &Answers) {
    let rocket = match features {
        Features::Rocket { convolutions, .. } => {
            Some(Rocket::new(SAMPLE[0], SAMPLE[1], convolutions.to_vec()))
        }
        Features::Readings => None,
    };
    let samples = samples();
    let (mut weights, bias) = (vec![], [0.31, -0.7, 1e-3]);
    let mut expected = Expected::default();
    for sample in samples.values().chunks(SAMPLE[0] * SAMPLE[1]) {
        let mut scaled = vec![0.0; sample.len()];
        scaling.encode(SAMPLE[0], sample, &mut scaled).unwrap();
        let mut row = scaled.clone();
        if let (Some(rocket), Features::Rocket { levels: with, .. }) = (&rocket, features) {
            row = vec![0.0; rocket.features()];
            rocket.shares(&scaled, &mut rocket.work(), &mut row);
            row.extend(if with { levels(&scaled) } else { vec![] });
        }
        if weights.is_empty() {
            weights = (0..OUTPUTS * row.len()).map(|i| ((i * 37) as f32 * 0.7).sin() * 0.3).collect();
        }
        let mut products = vec![0.0; OUTPUTS];
        double::dots(&weights, &row, &mut products);
        let outputs: Vec<f32> =
            products.iter().zip(bias).map(|(sum, bias)| (sum + f64::from(bias)) as f32).collect();
        answered(&outputs, answers, &mut expected);
    }
    let differ = expected.outputs.chunks(OUTPUTS).filter(|row| **row != expected.outputs[..OUTPUTS]).count();
    assert!(differ > 100, "{name}: samples hardly differ");
    let method = Method::Linear(Linear { features, weights: &weights, bias: &bias });
    let encoding = (Encoding::Scaled(scaling), SAMPLE);
    let library = Library::new(name, method, encoding, answers.clone(), samples.clone(), expected);
    let home = tempfile::tempdir().unwrap();
    has_the_same_bits(&library, &home.path().join("firmware"), "cc", &C99);
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
