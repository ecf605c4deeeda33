//! Steps of one network on request, for comparisons against other programs.
//!
//! ```text
//! cargo run --release -p taxel-engine --example steps -- resnet8-lite-2d --batch 64 --threads 1
//! ```
//!
//! Compiles the network, prepares one fixed pseudo-random batch, warms up, prints a line about itself and
//! then obeys its standard input, one JSON line per order:
//!
//! | order | what is done | answer |
//! |---|---|---|
//! | `run K` | K training steps (forward, loss, backward, SGDM), or K answers with `--eval` | `{"cpu_s", "wall_s", "steps", "loss"}` |
//! | `memory` | – | `{"peak_rss_kib"}` |
//! | `quit` or end of input | ends | – |
//!
//! `scripts/bench_training.py` drives it; `scripts/twin/steps.py` is the same program in PyTorch.
//!
//! # CPU time
//! The sum over `/proc/self/task/*/schedstat`, whose first number is the time in ns that one living thread
//! ran. The engine's threads live as long as the engine, so none is missed, for any number of threads.
//! The kernel brings a running thread's number up to date at its next tick or switch; the calling thread
//! yields before it reads, which leaves errors far below 1 ms. Without schedstat the user and system time
//! of `/proc/self/stat` is taken, in ticks of 10 ms. Either way, K should fill 0.1 s or more.

use std::error::Error;
use std::io::{BufRead, Write};
use std::time::Instant;
use std::{env, fs, io, process, thread};

use serde_json::{Value, json};
use taxel_engine::{Engine, EngineOptions, Mode, Precision, Sgdm};
use taxel_graph::{Scheme, Weights};
use taxel_zoo::Settings;

const USAGE: &str =
    "steps NETWORK [--batch B] [--threads T] [--eval] [--precision f32|bf16] [--set key=value]...";
const WARM_UP: usize = 3;
const SGDM: Sgdm = Sgdm { lr: 1e-3, momentum: 0.9, weight_decay: 0.0 };

type Result<T> = std::result::Result<T, Box<dyn Error>>;

struct Arguments {
    network: String,
    batch: usize,
    threads: usize,
    eval: bool,
    precision: Precision,
    settings: Settings,
}

impl Arguments {
    fn parse(mut words: impl Iterator<Item = String>) -> Result<Self> {
        let mut network = None;
        let (mut batch, mut threads, mut eval, mut settings) = (64, 1, false, Settings::new());
        let mut precision = Precision::F32;
        while let Some(word) = words.next() {
            match word.as_str() {
                "--batch" => batch = positive(&word, words.next())?,
                "--threads" => threads = positive(&word, words.next())?,
                "--eval" => eval = true,
                "--precision" => {
                    let value = words.next().ok_or("--precision needs f32 or bf16")?;
                    precision = serde_json::from_value(Value::from(value))?;
                }
                "--set" => {
                    let pair = words.next().ok_or("--set needs key=value")?;
                    let (key, value) = pair
                        .split_once('=')
                        .ok_or_else(|| format!("--set {pair}: write key=value, as in --set classes=5"))?;
                    let value = serde_json::from_str(value).unwrap_or_else(|_| Value::from(value));
                    settings.insert(key.into(), value);
                }
                _ if word.starts_with('-') => return Err(format!("unknown option {word}; {USAGE}").into()),
                _ if network.is_some() => {
                    return Err(format!("one network at a time, {word} is too many; {USAGE}").into());
                }
                _ => network = Some(word),
            }
        }
        let network = network.ok_or_else(|| format!("which network? {USAGE}"))?;
        Ok(Arguments { network, batch, threads, eval, precision, settings })
    }
}

fn positive(option: &str, value: Option<String>) -> Result<usize> {
    let value = value.ok_or_else(|| format!("{option} needs a number"))?;
    value
        .parse()
        .ok()
        .filter(|&number| number > 0)
        .ok_or_else(|| format!("{option} {value}: not a positive whole number").into())
}

/// The engine with the batch that it is fed.
struct Bench {
    engine: Engine,
    inputs: Vec<Vec<f32>>,
    labels: Vec<u32>,
    eval: bool,
    /// Facts about the network, sent before the first order.
    about: Value,
}

impl Bench {
    fn new(arguments: &Arguments) -> Result<Self> {
        let &Arguments { batch, threads, eval, precision, .. } = arguments;
        let graph = taxel_zoo::find(&arguments.network)?.graph(&arguments.settings)?;
        let weights = Weights::init(&graph, Scheme::Pytorch, 0, "steps");
        let options = EngineOptions { batch, threads, precision, ..EngineOptions::default() };
        let engine = Engine::new(&graph, &weights, options)?;
        let shapes: Vec<&[usize]> = graph.inputs().map(|node| node.shape.as_slice()).collect();
        let inputs =
            shapes.iter().zip(1..).map(|(shape, salt)| noise(batch * shape.iter().product::<usize>(), salt));
        let [(_, output)] = graph.outputs() else { return Err("a network with one output is needed".into()) };
        let classes = graph.nodes()[*output].shape[0] as u32;
        Ok(Bench {
            engine,
            inputs: inputs.collect(),
            labels: (0..batch as u32).map(|sample| sample % classes).collect(),
            eval,
            about: json!({
                "network": arguments.network,
                "version": env!("CARGO_PKG_VERSION"),
                "batch": batch,
                "threads": threads,
                "precision": precision,
                "inputs": shapes,
                "classes": classes,
                "parameters": graph.parameter_count(),
            }),
        })
    }

    /// Training loss of the last of `steps` steps; none in evaluation.
    fn run(&mut self, steps: usize) -> Result<Option<f32>> {
        let inputs: Vec<&[f32]> = self.inputs.iter().map(Vec::as_slice).collect();
        let (batch, mut loss) = (self.labels.len(), None);
        for _ in 0..steps {
            if self.eval {
                self.engine.forward(&inputs, batch, Mode::Eval)?;
            } else {
                self.engine.forward(&inputs, batch, Mode::Train)?;
                loss = Some(self.engine.backward(&self.labels)?);
                self.engine.sgdm(&SGDM);
            }
        }
        Ok(loss)
    }

    fn timed(&mut self, steps: usize) -> Result<Value> {
        let (cpu, wall) = (cpu_seconds()?, Instant::now());
        let loss = self.run(steps)?;
        let wall_s = wall.elapsed().as_secs_f64();
        let cpu_s = cpu_seconds()? - cpu;
        Ok(json!({ "cpu_s": cpu_s, "wall_s": wall_s, "steps": steps, "loss": loss }))
    }
}

/// Values in -1..1 that look random and are the same every time (splitmix64).
fn noise(len: usize, salt: u64) -> Vec<f32> {
    let mut state = salt << 32;
    let next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    std::iter::repeat_with(next).take(len).collect()
}

/// Time that all threads ran so far; see the top of this file.
fn cpu_seconds() -> Result<f64> {
    thread::yield_now();
    let mut nanoseconds = 0;
    for task in fs::read_dir("/proc/self/task").map_err(|e| format!("/proc/self/task: {e}"))? {
        let Ok(line) = fs::read_to_string(task?.path().join("schedstat")) else { return cpu_ticks() };
        nanoseconds += line.split(' ').next().and_then(|n| n.parse::<u64>().ok()).unwrap_or(0);
    }
    if nanoseconds > 0 { Ok(nanoseconds as f64 / 1e9) } else { cpu_ticks() }
}

/// User and system time of the process, in ticks of 10 ms.
fn cpu_ticks() -> Result<f64> {
    let line = fs::read_to_string("/proc/self/stat")?;
    // Fields 14 and 15; the name, field 2, may hold blanks and ends with the last parenthesis.
    let (_, fields) = line.rsplit_once(')').ok_or("/proc/self/stat: no process name")?;
    let ticks = fields
        .split_whitespace()
        .skip(11)
        .take(2)
        .map(str::parse::<u64>)
        .sum::<std::result::Result<u64, _>>()?;
    Ok(ticks as f64 / 100.0)
}

fn peak_memory() -> Result<Value> {
    let status = fs::read_to_string("/proc/self/status")?;
    let peak =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")).ok_or("/proc/self/status: no VmHWM")?;
    Ok(json!({ "peak_rss_kib": peak.trim().trim_end_matches(" kB").parse::<u64>()? }))
}

fn obey() -> Result<()> {
    let arguments = Arguments::parse(env::args().skip(1))?;
    let mut bench = Bench::new(&arguments)?;
    bench.run(WARM_UP)?;
    let mut out = io::stdout();
    writeln!(out, "{}", bench.about)?;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let answer = match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["run", steps] => bench.timed(positive("run", Some(steps.into()))?)?,
            ["memory"] => peak_memory()?,
            ["quit"] => break,
            _ => return Err(format!("unknown order `{line}`; known: run K, memory, quit").into()),
        };
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn main() {
    if let Err(error) = obey() {
        eprintln!("steps: {error}");
        process::exit(2);
    }
}
