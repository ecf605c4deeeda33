//! A small model of series, and time steps for it.

#![allow(dead_code, clippy::unwrap_used)]

use ndarray::ArrayD;
use taxel_data::{Dataset, Layout};
use taxel_graph::Network;
use taxel_learn::{Candidate, Encoding, Model, Recipe, fit};

pub const CHANNELS: usize = 2;
pub const TICKS: usize = 12;

/// Presses of three classes, the first channel a ramp of another slope, the second a wave.
pub fn model() -> Model {
    let x = ArrayD::from_shape_fn(vec![30, CHANNELS, TICKS], |at| match at[1] {
        0 => (1 + at[0] % 3) as f32 * at[2] as f32,
        _ => ((at[0] * 5 + at[2]) as f32).sin(),
    });
    let labels: Vec<&str> = (0..30).map(|i| ["soft", "medium", "stiff"][i % 3]).collect();
    let presses = Dataset::new("presses", Layout::Series, x, &labels).unwrap();
    let net = Network::new("linear");
    let logits = net.input("signal", &[CHANNELS, TICKS]).flatten().linear("fc", 3);
    let graph = net.finish(&[("logits", logits)]).unwrap();
    let candidate = Candidate::network(graph, Recipe { epochs: 10, ..Recipe::default() });
    fit(&candidate, &presses, &Encoding::default()).unwrap()
}

/// Time step number `t` of a stream.
pub fn reading(t: usize) -> [f32; CHANNELS] {
    let t = t as f32;
    [10.0 + 8.0 * (0.7 * t).sin(), (1.3 * t).cos()]
}
