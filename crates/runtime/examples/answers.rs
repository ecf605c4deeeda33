//! CPU time of one answer, engine against frozen network, in turns: `cargo run --release -p taxel-runtime --example
//! answers -- [network …]`.

use std::hint::black_box;
use std::time::{Duration, Instant};

use taxel_engine::{Evaluator, Options};
use taxel_graph::{Scheme, Weights};
use taxel_runtime::Frozen;

/// Nanoseconds that this thread has had a CPU.
fn cpu() -> Option<u64> {
    std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
}

/// Nanoseconds per call over about a tenth of a second.
fn clock(mut call: impl FnMut()) -> Option<f64> {
    let (begun, from) = (Instant::now(), cpu()?);
    let mut calls = 0u32;
    while begun.elapsed() < Duration::from_millis(100) {
        call();
        calls += 1;
    }
    Some((cpu()? - from) as f64 / f64::from(calls))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    println!("{:<20} {:>12} {:>12} {:>7}", "network", "engine µs", "frozen µs", "times");
    let mut product = (0.0, 0);
    for entry in taxel_zoo::Registry::built_in().entries() {
        if !asked.is_empty() && !asked.contains(&entry.name) {
            continue;
        }
        let graph = entry.graph(&taxel_zoo::Settings::new())?;
        if graph.parameter_count() > 80_000_000 {
            continue;
        }
        let weights = Weights::init(&graph, Scheme::Pytorch, 0, "answers");
        let len = |node: &taxel_graph::Node| node.shape.iter().product();
        let inputs: Vec<Vec<f32>> = graph
            .inputs()
            .map(|node| (0..len(node)).map(|i| (i % 101) as f32 / 50.0 - 1.0).collect())
            .collect();
        let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let evaluator =
            Evaluator::new(&graph, &weights, Options { batch: 1, threads: 1, ..Options::default() })?;
        let (frozen, mut memory) = (Frozen::new(&graph, &weights)?, evaluator.workspace());
        let mut workspace = frozen.workspace();
        let (mut before, mut after) = (vec![], vec![]);
        for _ in 0..7 {
            let engine = clock(|| {
                black_box(evaluator.answer(&mut memory, &inputs, 1).is_ok());
            });
            let frozen = clock(|| {
                black_box(frozen.answer(&mut workspace, &inputs).is_ok());
            });
            before.extend(engine);
            after.extend(frozen);
        }
        let [before, after] = [before, after].map(|mut times| {
            times.sort_by(f64::total_cmp);
            times.get(times.len() / 2).copied().unwrap_or(f64::NAN) / 1e3
        });
        product = (product.0 + (before / after).ln(), product.1 + 1);
        println!("{:<20} {before:>12.2} {after:>12.2} {:>7.2}", entry.name, before / after);
    }
    println!("geometric mean {:.2}", (product.0 / f64::from(product.1)).exp());
    Ok(())
}
