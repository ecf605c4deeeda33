//! Training in bf16. What needs the processor's products is ignored where `scripts/check` finds none.

#![allow(clippy::unwrap_used)]

mod common;

use common::{batch, mixed, weights};
use taxel_engine::{Engine, EngineOptions, Error, Mode, Precision, Sgdm, supports};
use taxel_graph::{Graph, Scheme, Weights};

fn options(batch: usize, threads: usize, precision: Precision) -> EngineOptions {
    EngineOptions { batch, threads, precision, ..EngineOptions::default() }
}

/// Returns the losses of some steps on one batch, and the weights after them.
fn train(graph: &Graph, threads: usize, precision: Precision, steps: usize) -> (Vec<f32>, Weights) {
    const N: usize = 20;
    let weights = Weights::init(graph, Scheme::Pytorch, 3, "test");
    let mut engine = Engine::new(graph, &weights, options(N, threads, precision)).unwrap();
    let inputs: Vec<Vec<f32>> = (graph.inputs().zip(1..))
        .map(|(node, salt)| {
            let len = N * node.shape.iter().product::<usize>();
            (0..len).map(|i| ((i * 7919 + salt * 104_729) % 2003) as f32 / 1001.0 - 1.0).collect()
        })
        .collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let labels: Vec<u32> = (0..N as u32).map(|i| i % 3).collect();
    let step = Sgdm { lr: 0.002, momentum: 0.9, weight_decay: 1e-4 };
    let losses = (0..steps).map(|_| {
        engine.forward(&inputs, N, Mode::Train).unwrap();
        let loss = engine.backward(&labels).unwrap();
        engine.sgdm(&step);
        loss
    });
    (losses.collect(), engine.weights())
}

fn graph(name: &str) -> Graph {
    taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap()
}

/// Networks with every kind of product: linear, recurrent, along one to three axes, strided, grouped.
const NETWORKS: [&str; 6] = ["mlp", "lstm", "tactnet6-gru", "resnet8-lite-1d", "hybrid-resvgg", "tactnet3d"];

#[test]
fn is_refused_with_the_reason_where_the_processor_lacks_it() {
    let graph = mixed();
    let made = Engine::new(&graph, &weights(&graph), options(2, 1, Precision::Bf16));
    match (supports(Precision::Bf16), made) {
        (Ok(()), Ok(_)) => {}
        (Err(reason), Err(error @ Error::Precision { .. })) => {
            assert_eq!(error.to_string(), reason.to_string());
            assert!(error.to_string().contains("bf16") && error.to_string().contains("f32"), "{error}");
        }
        (supported, made) => panic!("{supported:?}, but {:?}", made.err()),
    }
    assert!(supports(Precision::F32).is_ok());
}

#[test]
#[ignore = "needs avx512_bf16"]
fn threads_do_not_change_a_bit_needs_bf16() {
    for name in NETWORKS {
        let graph = graph(name);
        let one = train(&graph, 1, Precision::Bf16, 2);
        for threads in [2, 3] {
            assert_eq!(train(&graph, threads, Precision::Bf16, 2), one, "{name}, {threads} threads");
        }
    }
}

#[test]
#[ignore = "needs avx512_bf16"]
fn losses_are_those_of_floats_but_for_the_rounding_needs_bf16() {
    for name in NETWORKS {
        let graph = graph(name);
        let (floats, _) = train(&graph, 1, Precision::F32, 6);
        let (halves, _) = train(&graph, 1, Precision::Bf16, 6);
        assert_ne!(floats, halves, "{name}: nothing was rounded");
        for (float, half) in floats.iter().zip(&halves) {
            assert!((float - half).abs() < 0.02 * floats[0], "{name}: {floats:?} and {halves:?}");
        }
        assert!(halves[5] < halves[0], "{name} learns: {halves:?}");
    }
}

#[test]
#[ignore = "needs avx512_bf16"]
fn gradients_of_every_layer_are_close_to_those_of_floats_needs_bf16() {
    /// Gradients of a few samples nearly cancel in the first layers, and their rounding does not.
    const N: usize = 48;
    let gradients = |precision| {
        let graph = mixed();
        let mut engine = Engine::new(&graph, &weights(&graph), options(N, 1, precision)).unwrap();
        let ([image, signal], labels) = batch(N, 1);
        engine.forward(&[&image, &signal], N, Mode::Train).unwrap();
        engine.backward(&labels).unwrap();
        engine.gradients()
    };
    let (floats, halves) = (gradients(Precision::F32), gradients(Precision::Bf16));
    let mut rounded = 0;
    let all = floats.iter().flat_map(|(_, float)| &float.data).map(|v| v * v).sum::<f32>().sqrt();
    for (name, float) in floats.iter() {
        let half = &halves.get(name).unwrap().data;
        let square = |values: &mut dyn Iterator<Item = f32>| values.map(|v| v * v).sum::<f32>().sqrt();
        let far = square(&mut float.data.iter().zip(half).map(|(a, b)| a - b));
        let scale = square(&mut float.data.iter().copied());
        assert!(far <= 0.05 * scale + 0.005 * all, "{name}: {far} of {scale}, {all} over all");
        rounded += usize::from(far > 0.0);
    }
    assert!(rounded > 5, "{rounded} gradients differ");
}
