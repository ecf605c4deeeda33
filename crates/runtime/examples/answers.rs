//! Answers of one network on request, for `scripts/bench_answers.py` and `scripts/arm64.py`.
//!
//! `answers resnet8-lite-1d frozen` (or `bf16`, `int8`, `engine`) prints a JSON line about itself; then each line `run N` on
//! standard input is N predictions of one sample, and a JSON line with the CPU time that they took.

use std::error::Error;
use std::hint::black_box;
use std::io::BufRead;

use taxel_engine::{EngineOptions, Evaluator};
use taxel_graph::{Node, Scheme, Weights};
use taxel_runtime::{Frozen, Observer};

/// Nanoseconds that this thread has had a CPU.
fn cpu() -> Result<u64, Box<dyn Error>> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(text.split(' ').next().ok_or("no CPU time in schedstat")?.parse()?)
}

/// Obeys orders until there are no more.
fn obey(mut predict: impl FnMut() -> bool) -> Result<(), Box<dyn Error>> {
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let count: u32 = line.strip_prefix("run ").ok_or("orders are `run N`")?.parse()?;
        let from = cpu()?;
        for _ in 0..count {
            if !black_box(predict()) {
                return Err("no prediction".into());
            }
        }
        println!("{{\"answers\": {count}, \"cpu_s\": {}}}", (cpu()? - from) as f64 / 1e9);
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [network, how] = arguments.as_slice() else {
        return Err("usage: answers NETWORK frozen|bf16|int8|engine".into());
    };
    let graph = taxel_zoo::find(network)?.graph(&taxel_zoo::Settings::new())?;
    let weights = Weights::init(&graph, Scheme::Pytorch, 0, "answers");
    let values =
        |node: &Node| (0..node.shape.iter().product()).map(|i| (i % 101) as f32 / 50.0 - 1.0).collect();
    let inputs: Vec<Vec<f32>> = graph.inputs().map(values).collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let shapes: Vec<&[usize]> = graph.inputs().map(|node| node.shape.as_slice()).collect();
    let macs = graph.cost().macs;
    println!("{{\"inputs\": {shapes:?}, \"parameters\": {}, \"macs\": {macs}}}", graph.parameter_count());
    match how.as_str() {
        "frozen" => {
            let frozen = Frozen::new(&graph, &weights)?;
            let mut workspace = frozen.workspace();
            obey(|| frozen.predict(&mut workspace, &inputs).is_ok())
        }
        "bf16" => {
            let frozen = Frozen::half(&graph, &weights)?;
            let mut workspace = frozen.workspace();
            obey(|| frozen.predict(&mut workspace, &inputs).is_ok())
        }
        "int8" => {
            // Speed does not depend on what the ranges are.
            let mut observer = Observer::new(&graph, &weights)?;
            observer.see(&inputs)?;
            let frozen = Frozen::quantized(&graph, &weights, &observer.ranges())?;
            let mut workspace = frozen.workspace();
            obey(|| frozen.predict(&mut workspace, &inputs).is_ok())
        }
        "engine" => {
            let options = EngineOptions { batch: 1, threads: 1, ..EngineOptions::default() };
            let evaluator = Evaluator::new(&graph, &weights, options)?;
            let mut workspace = evaluator.workspace();
            obey(|| evaluator.predict(&mut workspace, &inputs, 1).is_ok())
        }
        other => Err(format!("`{other}` is none of `frozen`, `bf16`, `int8` and `engine`").into()),
    }
}
