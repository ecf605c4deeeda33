//! A network with every kind of layer, and batches for it.

#![allow(clippy::unwrap_used, clippy::panic, dead_code)]

use taxel_engine::{Engine, EngineOptions, Mode};
use taxel_graph::{Activation, Conv, Graph, Network, Pool, Scheme, Weights};

/// image [3, 9, 8] and signal [2, 6] → logits [3].
pub fn mixed() -> Graph {
    let net = Network::new("mixed");
    let x = net.input("image", &[3, 9, 8]).conv("stem.conv", Conv::new(8, 3).same());
    let x = x.batch_norm("stem.bn").activation(Activation::Relu6).dropout(0.2);
    let x = x.channel_shuffle(2);
    let left = x.slice(0, 3).conv("left.conv", Conv::new(4, 3).same().no_bias()).batch_norm("left.bn").relu();
    let right = x.slice(3, 5).conv("right.conv", Conv::new(4, 1)).activation(Activation::HardSwish);
    let x = left.add(&right.scale("right.scale", 0.5)).max_pool(Pool::new(2)).adaptive_average_pool(2);
    let signal = net.input("signal", &[2, 6]);
    let wide = signal.conv("wide.conv", Conv::new(3, 2).dilation(3)).global_standard_deviation(1e-3);
    let last = signal.lstm("lstm", 5).concat(&signal.gru("gru", 4));
    let signal = last.dropout(0.5).concat(&wide);
    let x = x.flatten().linear("fc1", 6).layer_norm("ln").activation(Activation::Tanh).concat(&signal);
    net.finish(&[("logits", x.linear("fc2", 3))]).unwrap()
}

pub fn weights(graph: &Graph) -> Weights {
    Weights::init(graph, Scheme::Pytorch, 3, "test")
}

pub fn engine(batch: usize, threads: usize, frozen: &[&str]) -> Engine {
    let frozen = frozen.iter().map(|name| name.to_string()).collect();
    let graph = mixed();
    Engine::new(
        &graph,
        &weights(&graph),
        EngineOptions { batch, threads, frozen, ..EngineOptions::default() },
    )
    .unwrap()
}

/// Inputs and labels of batch `number` with `n` samples.
pub fn batch(n: usize, number: u64) -> ([Vec<f32>; 2], Vec<u32>) {
    let values = |len: usize, salt: u64| {
        let mut state = (number * 7 + salt) << 32;
        let next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            ((mixed ^ (mixed >> 27)) >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        std::iter::repeat_with(next).take(len).collect()
    };
    ([values(n * 3 * 9 * 8, 1), values(n * 2 * 6, 2)], (0..n).map(|i| (i % 3) as u32).collect())
}

/// One training pass over a batch; the gradients stay in the engine.
pub fn pass(engine: &mut Engine, n: usize, number: u64) -> f32 {
    let ([image, signal], labels) = batch(n, number);
    engine.forward(&[&image, &signal], n, Mode::Train).unwrap();
    engine.backward(&labels).unwrap()
}
