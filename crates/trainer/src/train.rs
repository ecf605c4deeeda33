//! Training and testing one network on one fold.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use taxel_data::Fold;
use taxel_engine::{Engine, Mode, Options, Sgdm};
use taxel_graph::{Graph, Weights};

use crate::config::{BatchNorm, Train};
use crate::encode::{Encoded, Input};
use crate::error::{Error, Result};
use crate::metrics::{argmax, softmax};

/// One network on one fold.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// Name of the network in the experiment.
    pub label: &'a str,
    /// The network.
    pub graph: &'a Graph,
    /// How it is trained.
    pub train: &'a Train,
    /// Seed of the experiment.
    pub seed: u64,
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold, from 0.
    pub fold: usize,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
}

/// One line of `metrics.jsonl`, less its keys.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// Epoch, from 0.
    pub epoch: usize,
    /// Learning rate.
    pub lr: f64,
    /// Mean cross-entropy over the training samples, each as it was seen in this epoch.
    pub train_loss: f64,
    /// Share of them that was right, in %.
    pub train_accuracy: f64,
}

/// A trained network and what it says about the test samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// Parameters and batch-norm statistics.
    pub weights: Weights,
    /// What happened in training.
    pub epochs: Vec<Epoch>,
    /// Probabilities `[test samples, classes]`, in the order of the fold.
    pub probabilities: Vec<f32>,
    /// Seconds of training, batch-norm statistics included.
    pub train_seconds: f64,
    /// Seconds of testing.
    pub test_seconds: f64,
}

/// The order in which an epoch visits the training samples: a function of its arguments alone.
pub fn shuffled(train: &[usize], seed: u64, repetition: usize, fold: usize, epoch: usize) -> Vec<usize> {
    shuffle(train, seed, &format!("shuffle/r{repetition}/f{fold}/e{epoch}"))
}

fn shuffle(train: &[usize], seed: u64, purpose: &str) -> Vec<usize> {
    let mut order = train.to_vec();
    order.shuffle(&mut taxel_seed::rng(seed, purpose));
    order
}

impl Task<'_> {
    /// Trains on the fold's training samples and predicts its test samples. `tick` hears how many
    /// samples each step took; `None` if `cancel` was set.
    ///
    /// Fresh weights are keyed by network, repetition and fold, so networks may be added to an
    /// experiment without changing the others.
    ///
    /// # Errors
    /// [`Error::Diverged`] for a loss that is not finite, or what the engine refuses.
    pub fn run(
        &self,
        inputs: &[Input],
        y: &[u32],
        fold: &Fold,
        tick: &mut dyn FnMut(usize),
        cancel: &AtomicBool,
    ) -> Result<Option<Trained>> {
        let start = Instant::now();
        let Task { graph, train, seed, repetition, .. } = *self;
        let purpose = format!("init/{}/r{repetition}/f{}", graph.name(), self.fold);
        let weights = Weights::init(graph, train.init, seed, &purpose);
        let batch = train.batch_size.min(fold.train.len().max(fold.test.len())).max(1);
        let mut engine =
            Engine::new(graph, &weights, Options { batch, threads: self.threads, ..Options::default() })?;
        let mut feed = Feed::new(graph, inputs)?;
        let mut epochs = Vec::with_capacity(train.epochs);
        for epoch in 0..train.epochs {
            let order = shuffled(&fold.train, seed, repetition, self.fold, epoch);
            let lr = train.schedule.rate(train.optimizer.lr, epoch, train.epochs);
            let step = Sgdm {
                lr: lr as f32,
                momentum: train.optimizer.momentum as f32,
                weight_decay: train.optimizer.weight_decay as f32,
            };
            let (mut loss_sum, mut correct) = (0.0, 0);
            for (number, rows) in order.chunks(batch).enumerate() {
                if cancel.load(Ordering::Relaxed) {
                    return Ok(None);
                }
                let labels: Vec<u32> = rows.iter().map(|&row| y[row]).collect();
                let logits = feed.forward(&mut engine, rows, Mode::Train)?;
                let classes = logits.len() / rows.len();
                correct += argmax(logits, classes).iter().zip(&labels).filter(|(a, b)| a == b).count();
                let loss = engine.backward(&labels)?;
                if !loss.is_finite() {
                    return Err(self.diverged(epoch, number, loss, step.lr));
                }
                engine.sgdm(&step);
                loss_sum += f64::from(loss) * rows.len() as f64;
                tick(rows.len());
            }
            let n = order.len().max(1) as f64;
            let train_accuracy = 100.0 * correct as f64 / n;
            epochs.push(Epoch { epoch, lr, train_loss: loss_sum / n, train_accuracy });
        }
        if train.batch_norm == BatchNorm::Population && graph.buffer_count() > 0 {
            engine.begin_population();
            let order = shuffle(&fold.train, seed, &format!("population/r{repetition}/f{}", self.fold));
            for rows in order.chunks(batch) {
                if cancel.load(Ordering::Relaxed) {
                    return Ok(None);
                }
                feed.forward(&mut engine, rows, Mode::Train)?;
            }
            engine.end_population();
        }
        let train_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let mut probabilities = vec![];
        for rows in fold.test.chunks(batch) {
            probabilities.extend_from_slice(feed.forward(&mut engine, rows, Mode::Eval)?);
        }
        let classes = probabilities.len() / fold.test.len().max(1);
        softmax(&mut probabilities, classes);
        if let Some(&bad) = probabilities.iter().find(|p| !p.is_finite()) {
            let (last, steps) = (train.epochs.saturating_sub(1), fold.train.len().div_ceil(batch));
            let lr = train.schedule.rate(train.optimizer.lr, last, train.epochs);
            return Err(self.diverged(last, steps.saturating_sub(1), bad, lr as f32));
        }
        let test_seconds = start.elapsed().as_secs_f64();
        let weights = engine.weights();
        Ok(Some(Trained { weights, epochs, probabilities, train_seconds, test_seconds }))
    }

    fn diverged(&self, epoch: usize, batch: usize, loss: f32, lr: f32) -> Error {
        let network = self.label.to_string();
        Error::Diverged { network, repetition: self.repetition, fold: self.fold, epoch, batch, loss, lr }
    }
}

/// Gathers the rows of a batch into one slice per input of the graph.
struct Feed<'a> {
    inputs: Vec<&'a Encoded>,
    batches: Vec<Vec<f32>>,
}

impl<'a> Feed<'a> {
    fn new(graph: &Graph, inputs: &'a [Input]) -> Result<Self> {
        let find = |node: &taxel_graph::Node| inputs.iter().find(|input| input.name == node.name);
        let found: Vec<&Encoded> = graph.inputs().filter_map(find).map(|input| &*input.encoded).collect();
        if found.len() != graph.inputs().len() {
            let model = graph.name().to_string();
            let reason = "an input of the network is not encoded".to_string();
            return Err(taxel_engine::Error::Batch { model, reason }.into());
        }
        Ok(Feed { batches: vec![vec![]; found.len()], inputs: found })
    }

    fn forward<'e>(&mut self, engine: &'e mut Engine, rows: &[usize], mode: Mode) -> Result<&'e [f32]> {
        for (input, batch) in self.inputs.iter().zip(&mut self.batches) {
            input.gather(rows, batch);
        }
        let slices: Vec<&[f32]> = self.batches.iter().map(Vec::as_slice).collect();
        Ok(engine.forward(&slices, rows.len(), mode)?)
    }
}

/// Time of one sample through the trained network, batch 1, one thread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// Half of the runs took no longer, in ms.
    pub p50_ms: f64,
    /// 95 % of the runs took no longer, in ms.
    pub p95_ms: f64,
    /// Timed runs.
    pub runs: usize,
}

impl Latency {
    /// 200 runs after 20 to warm up; fewer (at least 5 after 1) where that would take over 2 s.
    ///
    /// # Errors
    /// What the engine refuses.
    pub fn measure(graph: &Graph, weights: &Weights, inputs: &[Input], row: usize) -> Result<Self> {
        let mut engine = Engine::new(graph, weights, Options { batch: 1, threads: 1, ..Options::default() })?;
        let mut feed = Feed::new(graph, inputs)?;
        let mut run = || -> Result<f64> {
            let start = Instant::now();
            std::hint::black_box(feed.forward(&mut engine, &[row], Mode::Eval)?);
            Ok(1e3 * start.elapsed().as_secs_f64())
        };
        let begin = Instant::now();
        let late = |done: usize, least: usize| done >= least && begin.elapsed().as_secs() >= 2;
        for done in 0..20 {
            if late(done, 1) {
                break;
            }
            run()?;
        }
        let mut times = vec![];
        while times.len() < 200 && !late(times.len(), 5) {
            times.push(run()?);
        }
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times[((share * times.len() as f64).ceil() as usize).clamp(1, times.len()) - 1];
        Ok(Latency { p50_ms: at(0.5), p95_ms: at(0.95), runs: times.len() })
    }
}
