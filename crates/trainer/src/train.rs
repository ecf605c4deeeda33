//! Training and testing one network on one fold.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rand::RngExt;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use taxel_data::{Augment, Fold, Key, hold_back};
use taxel_engine::{Adam, Engine, Mode, Options, Sgdm};
use taxel_graph::{Graph, Weights};

use crate::config::{BatchNorm, By, Choose, OptimizerName, Train};
use crate::encode::{Encoded, Input};
use crate::error::{Error, Result};
use crate::labels::{Labels, Objective};
use crate::results::{Chosen, OtherStatistics, Trial};
use crate::session::{Best, Saver, Session};

/// One network on one fold.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// Name of the network in the experiment.
    pub label: &'a str,
    /// The network.
    pub graph: &'a Graph,
    /// How it is trained.
    pub train: &'a Train,
    /// What it chooses by itself.
    pub choose: Option<&'a Choose>,
    /// Tensors that it starts from; a head for another number of classes is made anew.
    pub checkpoint: Option<&'a Weights>,
    /// Seed of the experiment.
    pub seed: u64,
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold, from 0.
    pub fold: usize,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
}

/// What a task learns from.
#[derive(Debug, Clone, Copy)]
pub struct Material<'a> {
    /// Inputs of all samples.
    pub inputs: &'a [Input],
    /// Labels of all samples.
    pub labels: &'a Labels,
    /// What a validation part keeps even over the classes, one number per sample.
    pub strata: &'a [u32],
    /// What no two parts may share, one number per sample.
    pub units: Option<&'a [u32]>,
    /// Which samples are for what.
    pub fold: &'a Fold,
}

/// One line of `metrics.jsonl`, less its keys.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// Epoch, from 0.
    pub epoch: usize,
    /// Learning rate.
    pub lr: f64,
    /// Mean loss over the training samples, each as it was seen in this epoch.
    pub train_loss: f64,
    /// Share of them that was right, in %.
    pub train_accuracy: f64,
    /// Mean loss over the validation part after this epoch, where early stopping needs it; without label
    /// smoothing and class weights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_loss: Option<f64>,
    /// Share of the validation part that was right, in %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_accuracy: Option<f64>,
}

/// A trained network and what it says about the test samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// Parameters and batch-norm statistics.
    pub weights: Weights,
    /// What happened in training.
    pub epochs: Vec<Epoch>,
    /// What the fold has chosen by its validation part.
    pub chosen: Option<Chosen>,
    /// The epoch whose weights these are, with early stopping.
    pub best_epoch: Option<usize>,
    /// Probabilities `[test samples, outputs]`, in the order of the fold.
    pub probabilities: Vec<f32>,
    /// Mean loss over the test samples.
    pub test_loss: f64,
    /// The same weights with the other kind of batch-norm statistics.
    pub other_statistics: Option<OtherStatistics>,
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

/// What a training hears and says while it runs.
struct Watch<'a> {
    tick: &'a mut dyn FnMut(usize),
    cancel: &'a AtomicBool,
    saver: &'a mut Saver,
}

impl Watch<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl Task<'_> {
    /// Trains on the fold's training samples and predicts its test samples. `tick` hears how many
    /// samples each step took; `None` if `cancel` was set.
    ///
    /// Fresh weights are keyed by network, repetition and fold, so networks may be added to an
    /// experiment without changing the others.
    ///
    /// # Errors
    /// [`Error::Diverged`] for a loss that is not finite, too few samples to hold some back, or what the
    /// engine refuses.
    pub fn run(
        &self,
        material: &Material,
        tick: &mut dyn FnMut(usize),
        cancel: &AtomicBool,
    ) -> Result<Option<Trained>> {
        self.run_saved(material, &mut Saver::none(), tick, cancel)
    }

    /// [`Task::run`] that goes on where `saver` has saved, and saves to it.
    pub(crate) fn run_saved(
        &self,
        material: &Material,
        saver: &mut Saver,
        tick: &mut dyn FnMut(usize),
        cancel: &AtomicBool,
    ) -> Result<Option<Trained>> {
        let mut session = saver.load()?;
        let mut watch = Watch { tick, cancel, saver };
        let Some((train, chosen)) = self.choose(material, &mut session, &mut watch)? else {
            return Ok(None);
        };
        let (rows, validation) = match &train.early_stopping {
            Some(stopping) => self.parts(material, stopping.validation, "stop")?,
            None => (material.fold.train.clone(), vec![]),
        };
        let Some(mut trainee) = self.fit(&train, material, &rows, &validation, &mut session, &mut watch)?
        else {
            return Ok(None);
        };
        let aside = Instant::now();
        let test = &material.fold.test;
        let mut other = match train.batch_norm {
            BatchNorm::Population if trainee.has_norms && !trainee.settled => {
                Some((BatchNorm::Moving, trainee.validate(test, material.labels)?))
            }
            _ => None,
        };
        let aside = aside.elapsed().as_secs_f64();
        if !trainee.settle(&rows, &watch)? {
            return Ok(None);
        }
        let train_seconds = watch.saver.seconds() - aside;
        let start = Instant::now();
        let (mut probabilities, test_loss) = trainee.test(test, material.labels)?;
        let test_seconds = start.elapsed().as_secs_f64();
        trainee.objective.probabilities(&mut probabilities);
        if let Some(&bad) = probabilities.iter().find(|p| !p.is_finite()) {
            return Err(trainee.diverged_at_the_end(bad));
        }
        let weights = trainee.engine.weights();
        if train.batch_norm == BatchNorm::Moving && trainee.has_norms {
            if !trainee.population(&rows, &watch)? {
                return Ok(None);
            }
            other = Some((BatchNorm::Population, trainee.validate(test, material.labels)?));
        }
        let other_statistics = other
            .filter(|(_, (loss, _))| loss.is_finite())
            .map(|(batch_norm, (test_loss, accuracy))| OtherStatistics { batch_norm, accuracy, test_loss });
        Ok(Some(Trained {
            weights,
            epochs: session.state.stage.epochs,
            chosen,
            best_epoch: session.state.stage.best.map(|best| best.epoch),
            probabilities,
            test_loss,
            other_statistics,
            train_seconds,
            test_seconds,
        }))
    }

    /// Samples times epochs that [`Task::run`] trains on at most.
    pub fn samples(&self, fold: &Fold) -> usize {
        let fitted = |train: &Train, share: Option<f64>| {
            let rows = fold.train.len();
            let held = share.filter(|_| fold.validation.is_empty()).map_or(0, |s| (rows as f64 * s) as usize);
            (rows - held) * train.epochs
        };
        let last = fitted(self.train, self.train.early_stopping.as_ref().map(|s| s.validation));
        let Some(choose) = self.choose else { return last };
        let trials = choose.combinations().into_iter().filter_map(|set| self.train.with(&set).ok());
        trials.map(|train| fitted(&train, Some(choose.validation))).sum::<usize>() + last
    }

    /// The rows that are trained on and those that choose: the protocol's, or held back from the
    /// training part.
    fn parts(&self, material: &Material, share: f64, purpose: &str) -> Result<(Vec<usize>, Vec<usize>)> {
        let fold = material.fold;
        if !fold.validation.is_empty() {
            return Ok((fold.train.clone(), fold.validation.clone()));
        }
        let purpose = format!("validation/{purpose}/r{}/f{}", self.repetition, self.fold);
        Ok(hold_back(&fold.train, material.strata, material.units, share, self.seed, &purpose)?)
    }

    /// Tries every combination of settings that the experiment leaves open; the training with the best
    /// one.
    fn choose(
        &self,
        material: &Material,
        session: &mut Session,
        watch: &mut Watch,
    ) -> Result<Option<(Train, Option<Chosen>)>> {
        let Some(choose) = self.choose else { return Ok(Some((self.train.clone(), None))) };
        let combinations = choose.combinations();
        let refuse = |problem: crate::config::Problem| Error::Value {
            place: self.label.into(),
            key: problem.key,
            value: problem.value,
            reason: problem.reason,
        };
        let (rows, validation) = self.parts(material, choose.validation, "choose")?;
        while session.state.trials.len() < combinations.len() {
            let combination = &combinations[session.state.trials.len()];
            let train = self.train.with(combination).map_err(refuse)?;
            // Early stopping sees the same part: it, too, is never tested on.
            let stopping = if train.early_stopping.is_some() { validation.as_slice() } else { &[] };
            let scores = match self.fit(&train, material, &rows, stopping, session, watch) {
                Ok(None) => return Ok(None),
                Ok(Some(mut trainee)) => {
                    if !trainee.settle(&rows, watch)? {
                        return Ok(None);
                    }
                    Some(trainee.validate(&validation, material.labels)?)
                }
                // A rate that is too high is an answer, not a failure.
                Err(Error::Diverged { .. }) => None,
                Err(error) => return Err(error),
            };
            let set = combination.iter().map(|(key, value)| (key.clone(), value.clone())).collect();
            session.state.trials.push(Trial {
                set,
                loss: scores.map(|(loss, _)| loss).filter(|loss| loss.is_finite()),
                accuracy: scores.map(|(_, accuracy)| accuracy),
            });
            session.next_stage();
            watch.saver.save(session, None)?;
        }
        let trials = session.state.trials.clone();
        let mut best: Option<usize> = None;
        for (i, trial) in trials.iter().enumerate() {
            let (Some(loss), Some(accuracy)) = (trial.loss, trial.accuracy) else { continue };
            let beats = |other: &Trial| {
                let (least, most) = (other.loss.unwrap_or(f64::INFINITY), other.accuracy.unwrap_or(0.0));
                is_better(choose.by, (loss, accuracy), (least, most))
            };
            if best.is_none_or(|b| beats(&trials[b])) {
                best = Some(i);
            }
        }
        let Some(best) = best else {
            return Err(Error::NothingChosen {
                network: self.label.into(),
                repetition: self.repetition,
                fold: self.fold,
                trials: trials.len(),
            });
        };
        let train = self.train.with(&combinations[best]).map_err(refuse)?;
        Ok(Some((train, Some(Chosen { set: trials[best].set.clone(), trials }))))
    }

    /// Trains on `rows`; with a validation part, the weights are those of its best epoch. What remains to be
    /// done is [`Trainee::settle`].
    fn fit<'m>(
        &self,
        train: &Train,
        material: &Material<'m>,
        rows: &[usize],
        validation: &[usize],
        session: &mut Session,
        watch: &mut Watch,
    ) -> Result<Option<Trainee<'m>>> {
        let mut trainee = Trainee::new(self, train, material, rows)?;
        session.restore(&mut trainee.engine)?;
        let done = session.state.stage.epochs.len();
        (watch.tick)(done * rows.len());
        let patience = train.early_stopping.as_ref().map_or(usize::MAX, |s| s.patience);
        for epoch in done..train.epochs {
            // Asked before the epoch, so that a resumed stage that was over stays over.
            let waited = session.state.stage.best.map_or(0, |best| epoch - 1 - best.epoch);
            if waited >= patience {
                (watch.tick)((train.epochs - epoch) * rows.len());
                break;
            }
            let Some(mut line) = trainee.epoch(epoch, rows, material.labels, watch)? else {
                return Ok(None);
            };
            if let Some(stopping) = train.early_stopping.as_ref().filter(|_| !validation.is_empty()) {
                if train.batch_norm == BatchNorm::Population && !trainee.population(rows, watch)? {
                    return Ok(None);
                }
                let (loss, accuracy) = trainee.validate(validation, material.labels)?;
                if !loss.is_finite() {
                    return Err(trainee.diverged_at_the_end(loss as f32));
                }
                (line.validation_loss, line.validation_accuracy) = (Some(loss), Some(accuracy));
                let stage = &mut session.state.stage;
                if stage.best.is_none_or(|b| is_better(stopping.by, (loss, accuracy), (b.loss, b.accuracy))) {
                    stage.best = Some(Best { epoch, loss, accuracy });
                    session.best = Some(trainee.engine.weights());
                }
            }
            session.state.stage.epochs.push(line);
            watch.saver.save(session, Some(&trainee.engine))?;
        }
        if let Some(best) = &session.best {
            trainee.engine.set_weights(best)?;
            // Their statistics are those of their own epoch.
            trainee.settled = true;
        }
        Ok(Some(trainee))
    }
}

/// Whether a validation's loss and accuracy are better than another's.
fn is_better(by: By, (loss, accuracy): (f64, f64), (other_loss, other_accuracy): (f64, f64)) -> bool {
    match by {
        By::Loss => loss < other_loss,
        By::Accuracy => accuracy > other_accuracy || accuracy == other_accuracy && loss < other_loss,
    }
}

/// An engine with what it learns.
struct Trainee<'m> {
    label: String,
    key: (u64, usize, usize),
    dropout: u64,
    train: Train,
    batch: usize,
    steps: usize,
    has_norms: bool,
    /// Whether the batch-norm statistics are those that the experiment wants.
    settled: bool,
    objective: Objective,
    engine: Engine,
    feed: Feed<'m>,
}

impl<'m> Trainee<'m> {
    fn new(task: &Task, train: &Train, material: &Material<'m>, rows: &[usize]) -> Result<Self> {
        let Task { graph, seed, repetition, fold, .. } = *task;
        let mut weights =
            Weights::init(graph, train.init, seed, &format!("init/{}/r{repetition}/f{fold}", graph.name()));
        if let Some(checkpoint) = task.checkpoint {
            weights.start_from(graph, checkpoint, false).map_err(taxel_engine::Error::from)?;
        }
        let largest = rows.len().max(material.fold.test.len()).max(material.fold.validation.len());
        let batch = train.batch_size.min(largest).max(1);
        let frozen = taxel_zoo::matlab::resolve(graph, &train.frozen).map_err(taxel_engine::Error::from)?;
        let options = Options { batch, threads: task.threads, frozen };
        let purpose = format!("dropout/{}/r{repetition}/f{fold}", graph.name());
        Ok(Trainee {
            label: task.label.into(),
            key: (seed, repetition, fold),
            dropout: taxel_seed::rng(seed, &purpose).random(),
            train: train.clone(),
            batch,
            steps: rows.len().div_ceil(batch),
            has_norms: graph.buffer_count() > 0,
            settled: train.batch_norm == BatchNorm::Moving,
            objective: Objective::new(train, material.labels.levels(), &material.labels.of(rows)),
            engine: Engine::new(graph, &weights, options)?,
            feed: Feed::new(graph, material.inputs)?,
        })
    }

    /// One pass over `rows`; `None` if cancelled. A function of weights, seed, repetition, fold and epoch.
    fn epoch(
        &mut self,
        epoch: usize,
        rows: &[usize],
        labels: &Labels,
        watch: &mut Watch,
    ) -> Result<Option<Epoch>> {
        let (seed, repetition, fold) = self.key;
        let order = shuffled(rows, seed, repetition, fold, epoch);
        let lr = self.train.schedule.rate(self.train.optimizer.lr, epoch, self.train.epochs);
        let (mut loss_sum, mut correct, mut seen) = (0.0, 0, 0);
        for (number, rows) in order.chunks(self.batch).enumerate() {
            if watch.is_cancelled() {
                return Ok(None);
            }
            let batch = labels.of(rows);
            self.engine.set_dropout(self.dropout, (epoch * self.steps + number) as u64);
            let key = Key { seed, repetition, fold, epoch, sample: 0 };
            let augment = self.train.augment.as_ref().map(|augment| (augment, key));
            let logits = self.feed.augmented(&mut self.engine, rows, augment)?;
            correct += self.objective.correct(logits, &batch);
            seen += batch.len();
            let engine = &mut self.engine;
            let loss =
                self.objective.backward(&batch, |loss, targets| engine.backward_with(loss, targets))?;
            if !loss.is_finite() {
                return Err(self.diverged(epoch, number, loss, lr));
            }
            self.step(lr);
            loss_sum += f64::from(loss) * rows.len() as f64;
            (watch.tick)(rows.len());
        }
        let train_accuracy = 100.0 * correct as f64 / seen.max(1) as f64;
        let train_loss = loss_sum / order.len().max(1) as f64;
        let (validation_loss, validation_accuracy) = (None, None);
        Ok(Some(Epoch { epoch, lr, train_loss, train_accuracy, validation_loss, validation_accuracy }))
    }

    fn step(&mut self, lr: f64) {
        if let Some(clip) = self.train.clip {
            self.engine.clip_gradients(clip as f32);
        }
        let optimizer = &self.train.optimizer;
        let [first, second] = optimizer.betas.unwrap_or([0.9, 0.999]);
        let adam = Adam {
            lr,
            betas: (first, second),
            eps: optimizer.eps.unwrap_or(1e-8),
            weight_decay: optimizer.weight_decay,
        };
        match optimizer.name {
            OptimizerName::Sgdm => self.engine.sgdm(&Sgdm {
                lr: lr as f32,
                momentum: optimizer.momentum as f32,
                weight_decay: optimizer.weight_decay as f32,
            }),
            OptimizerName::Adam => self.engine.adam(&adam),
            OptimizerName::Adamw => self.engine.adamw(&adam),
        }
    }

    /// Batch-norm statistics as the experiment wants them; false if cancelled.
    fn settle(&mut self, rows: &[usize], watch: &Watch) -> Result<bool> {
        if !self.settled && !self.population(rows, watch)? {
            return Ok(false);
        }
        self.settled = true;
        Ok(true)
    }

    /// Batch-norm statistics over the whole training part; false if cancelled. Training does not see them.
    fn population(&mut self, rows: &[usize], watch: &Watch) -> Result<bool> {
        if !self.has_norms {
            return Ok(true);
        }
        let (seed, repetition, fold) = self.key;
        self.engine.begin_population();
        self.engine.set_dropout(self.dropout, 1 << 32);
        for rows in shuffle(rows, seed, &format!("population/r{repetition}/f{fold}")).chunks(self.batch) {
            if watch.is_cancelled() {
                return Ok(false);
            }
            self.feed.forward(&mut self.engine, rows, Mode::Train)?;
        }
        self.engine.end_population();
        Ok(true)
    }

    /// Logits of `rows` and their mean loss.
    fn test(&mut self, rows: &[usize], labels: &Labels) -> Result<(Vec<f32>, f64)> {
        let mut logits = vec![];
        for rows in rows.chunks(self.batch) {
            logits.extend_from_slice(self.feed.forward(&mut self.engine, rows, Mode::Eval)?);
        }
        let loss = self.objective.value(&logits, &labels.of(rows));
        Ok((logits, loss))
    }

    /// Mean loss of `rows`, and the share that is right in %.
    fn validate(&mut self, rows: &[usize], labels: &Labels) -> Result<(f64, f64)> {
        let (logits, loss) = self.test(rows, labels)?;
        let labels = labels.of(rows);
        Ok((loss, 100.0 * self.objective.correct(&logits, &labels) as f64 / labels.len().max(1) as f64))
    }

    fn diverged(&self, epoch: usize, batch: usize, loss: f32, lr: f64) -> Error {
        let (_, repetition, fold) = self.key;
        let network = self.label.clone();
        Error::Diverged { network, repetition, fold, epoch, batch, loss, lr: lr as f32 }
    }

    fn diverged_at_the_end(&self, value: f32) -> Error {
        let last = self.train.epochs.saturating_sub(1);
        let lr = self.train.schedule.rate(self.train.optimizer.lr, last, self.train.epochs);
        self.diverged(last, self.steps.saturating_sub(1), value, lr)
    }
}
/// Gathers the rows of a batch into one slice per input of the graph.
struct Feed<'a> {
    inputs: Vec<&'a Encoded>,
    /// What lies beyond the edges of an input's images, per channel.
    rests: Vec<Option<Vec<f32>>>,
    batches: Vec<Vec<f32>>,
}

impl<'a> Feed<'a> {
    fn new(graph: &Graph, inputs: &'a [Input]) -> Result<Self> {
        let find = |node: &taxel_graph::Node| inputs.iter().find(|input| input.name == node.name);
        let found: Vec<&Input> = graph.inputs().filter_map(find).collect();
        if found.len() != graph.inputs().len() {
            let model = graph.name().to_string();
            let reason = "an input of the network is not encoded".to_string();
            return Err(taxel_engine::Error::Batch { model, reason }.into());
        }
        let rests = found.iter().map(|input| input.transform.rest()).collect();
        let inputs: Vec<&Encoded> = found.iter().map(|input| &*input.encoded).collect();
        Ok(Feed { batches: vec![vec![]; inputs.len()], inputs, rests })
    }

    fn gather(&mut self, rows: &[usize]) {
        for (input, batch) in self.inputs.iter().zip(&mut self.batches) {
            input.gather(rows, batch);
        }
    }

    fn run<'e>(&self, engine: &'e mut Engine, n: usize, mode: Mode) -> Result<&'e [f32]> {
        let slices: Vec<&[f32]> = self.batches.iter().map(Vec::as_slice).collect();
        Ok(engine.forward(&slices, n, mode)?)
    }

    fn forward<'e>(&mut self, engine: &'e mut Engine, rows: &[usize], mode: Mode) -> Result<&'e [f32]> {
        self.gather(rows);
        self.run(engine, rows.len(), mode)
    }

    /// A training pass over `rows`; with an augmentation, over what it makes of them under `key`.
    fn augmented<'e>(
        &mut self,
        engine: &'e mut Engine,
        rows: &[usize],
        augment: Option<(&Augment, Key)>,
    ) -> Result<&'e [f32]> {
        self.gather(rows);
        for ((input, rest), batch) in self.inputs.iter().zip(&self.rests).zip(&mut self.batches) {
            let (Some((augment, key)), Some(rest)) = (augment, rest) else { continue };
            let (&[channels, height, width, ref frames @ ..], len) = (input.shape(), input.len()) else {
                continue;
            };
            let frames: usize = frames.iter().product();
            for (&sample, values) in rows.iter().zip(batch.chunks_exact_mut(len)) {
                let warp = augment.draw(&Key { sample, ..key });
                // Each channel has its own value at rest.
                for (channel, plane) in values.chunks_exact_mut(len / channels).enumerate() {
                    let outside = rest.get(channel).or(rest.first()).copied().unwrap_or(0.0);
                    warp.apply(plane, [1, height, width, frames], outside);
                }
            }
        }
        self.run(engine, rows.len(), Mode::Train)
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
    /// Times a network: 200 runs after 20 to warm up; fewer (at least 5 after 1) where that would take over 2 s.
    ///
    /// # Errors
    /// What the engine refuses.
    pub fn measure(graph: &Graph, weights: &Weights, inputs: &[Input], row: usize) -> Result<Self> {
        let mut engine = Engine::new(graph, weights, Options { batch: 1, threads: 1, ..Options::default() })?;
        let mut feed = Feed::new(graph, inputs)?;
        Self::of(|| feed.forward(&mut engine, &[row], Mode::Eval).map(|logits| logits[0]))
    }

    /// Times `answer`, as [`Latency::measure`] does.
    ///
    /// # Errors
    /// What `answer` refuses.
    pub(crate) fn of<T>(mut answer: impl FnMut() -> Result<T>) -> Result<Self> {
        let mut run = || -> Result<f64> {
            let start = Instant::now();
            std::hint::black_box(answer()?);
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
