//! Training steps (forward, loss, backward, SGDM) and single predictions; ids are network/phase/batch.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use taxel_engine::{Engine, EngineOptions, Mode, Sgdm};
use taxel_graph::{Scheme, Weights};

const NETWORKS: [&str; 7] = [
    "mlp",
    "vgg6-lite-1d",
    "resnet8-lite-1d",
    "densenet6-lite-1d",
    "vgg6-lite-2d",
    "resnet8-lite-2d",
    "hybrid-resvgg",
];

fn networks(c: &mut Criterion) {
    for name in NETWORKS {
        let Ok(graph) = taxel_zoo::find(name).and_then(|e| e.graph(&taxel_zoo::Settings::new())) else {
            continue;
        };
        let weights = Weights::init(&graph, Scheme::Pytorch, 0, "bench");
        let mut group = c.benchmark_group(name);
        for (phase, batch) in [("train", 64), ("eval", 1)] {
            let Ok(mut engine) = Engine::new(
                &graph,
                &weights,
                EngineOptions { batch, threads: 1, ..EngineOptions::default() },
            ) else {
                continue;
            };
            let inputs: Vec<Vec<f32>> = graph
                .inputs()
                .map(|node| {
                    let len = batch * node.shape.iter().product::<usize>();
                    (0..len).map(|i| ((i * 37 % 101) as f32 - 50.0) / 50.0).collect()
                })
                .collect();
            let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
            let labels: Vec<u32> = (0..batch as u32).map(|i| i % 3).collect();
            let step = Sgdm { lr: 1e-3, momentum: 0.9, weight_decay: 0.0 };
            group.throughput(Throughput::Elements(batch as u64));
            group.bench_with_input(BenchmarkId::new(phase, batch), &xs, |b, xs| {
                b.iter(|| {
                    if phase == "train" {
                        let done = engine.forward(black_box(xs), batch, Mode::Train).is_ok();
                        black_box(engine.backward(&labels).is_ok() && done);
                        engine.sgdm(&step);
                    } else {
                        black_box(engine.forward(black_box(xs), batch, Mode::Eval).is_ok());
                    }
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, networks);
criterion_main!(benches);
