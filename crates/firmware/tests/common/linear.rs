//! Linear models on features, and what the kernels predict with them.

use taxel_encodings::Scaling;
use taxel_firmware::{Answers, Encoding, Expected, Features, Library, Linear, Method};
use taxel_kernels::double;
use taxel_kernels::rocket::{Dilated, Rocket};

use super::{OUTPUTS, SAMPLE, answered, samples};

/// Convolutions of all kinds: dilations up to the length of a sample, one channel or several, with and without ends.
pub fn convolutions() -> Vec<Dilated> {
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

/// Hands over the library of a linear model on features of scaled samples.
pub fn with_library(
    name: &str,
    features: Features,
    scaling: &Scaling,
    answers: &Answers,
    run: impl FnOnce(&Library),
) {
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
    run(&library);
}
