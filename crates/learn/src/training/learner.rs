//! An engine with what it learns: epochs, batch-norm statistics, tests.

use std::sync::Arc;

use rand::RngExt;
use taxel_data::{Key, Task};
use taxel_engine::{Engine, EngineOptions, Mode, Precision};
use taxel_graph::{Graph, Halves, Op, Targets, Weights};

use crate::encoding::{Encoded, Input};
use crate::error::{Error, Result};
use crate::estimator::estimator::TrainingSet;
use crate::estimator::trainable::Trainable;
use crate::metrics::{Metric, Outcome};
use crate::model::ready::Ready;
use crate::model::responder::Responder;
use crate::training::epoch::Epoch;
use crate::training::feature_cache::{CachedFeatures, halves, is_norm, predict_alike, unchanged_nodes};
use crate::training::feed::{Feed, read_by};
use crate::training::hooks::Hooks;
use crate::training::objective::Objective;
use crate::training::objective_of::objective;
use crate::training::part::TrainingKey;
use crate::training::pass::TrainingPass;
use crate::training::raw_changes::RawChanges;
use crate::training::recipe::{BatchNorm, Recipe};

/// Test samples that are gathered at a time.
const AT_ONCE: usize = 64;

/// The answers of a trained network for some samples.
pub(crate) struct Tested {
    /// Probabilities or values `[n, outputs]`.
    pub answers: Vec<f32>,
    /// How far below and above them it expects the true values; empty where it says nothing of it.
    pub spread: Vec<f32>,
    /// Their mean loss.
    pub loss: f64,
}

/// An engine with what it learns.
pub(crate) struct Learner<'d> {
    network: &'d Trainable,
    set: &'d TrainingSet<'d>,
    dropout: u64,
    recipe: Recipe,
    task: Task,
    steps: usize,
    /// Samples of a batch.
    pub batch: usize,
    /// Whether there are batch norms whose statistics training moves.
    pub has_norms: bool,
    /// Whether the batch-norm statistics are those that the recipe wants.
    pub settled: bool,
    pub objective: Box<dyn Objective + 'd>,
    /// Of the whole network, or of what lies behind its frozen part.
    pub engine: Engine,
    /// All tensors as they were at first, where the engine has not all of them.
    first: Option<Weights>,
    /// The network in two, where tests may run one after the other.
    halves: Option<Halves>,
    feed: Feed<'d>,
    /// How much each sample of the data set counts, 1 on average over the training samples; none where all count alike.
    weights: Option<Vec<f32>>,
}

impl<'d> Learner<'d> {
    /// Makes the learner of a network with its first weights, to learn from `rows`.
    ///
    /// # Errors
    /// Weights or frozen nodes that do not fit the graph, an input that is not encoded.
    pub fn new(
        network: &'d Trainable,
        set: &'d TrainingSet<'d>,
        recipe: &Recipe,
        rows: &[usize],
    ) -> Result<Self> {
        let (graph, dataset) = (&network.graph, set.dataset);
        let objective = objective(recipe, graph, dataset, rows);
        let weights = first_weights(network, set.part, recipe, &*objective)?;
        let largest = rows.len().max(set.fold.test.len()).max(set.fold.validation.len());
        let batch = recipe.batch_size.min(largest).max(1);
        let options = EngineOptions {
            batch,
            threads: set.threads,
            frozen: recipe.frozen.clone(),
            frozen_statistics: recipe.frozen_statistics,
            decay: recipe.optimizer.decay(),
            precision: recipe.precision,
        };
        let unchanged = unchanged_nodes(graph, recipe).map_err(taxel_engine::Error::from)?;
        let has_norms = graph.nodes().iter().zip(&unchanged).any(|(node, stays)| is_norm(node) && !stays);
        let halves = halves(graph, recipe, dataset.len());
        let (engine, first, features) = match &halves {
            Some(halves) => {
                let (engine, features) = engine_behind(halves, graph, set, &weights, options)?;
                (engine, Some(weights), Some(features))
            }
            None => (Engine::new(graph, &weights, options)?, None, None),
        };
        let (faults, augment) = (recipe.faults.as_ref(), recipe.augment.as_ref());
        let read = read_by(graph, set.inputs);
        let changes = RawChanges::new(faults, augment, (dataset, rows), &read, set.part)?;
        let purpose = set.part.purpose(&format!("dropout/{}", graph.name()));
        Ok(Learner {
            network,
            set,
            dropout: taxel_base::seed::rng(set.part.seed, &purpose).random(),
            recipe: recipe.clone(),
            task: dataset.task(),
            steps: rows.len().div_ceil(batch),
            batch,
            has_norms,
            settled: recipe.batch_norm == BatchNorm::Running,
            objective,
            engine,
            first,
            halves: halves.filter(predict_alike),
            feed: Feed::new(graph, set.inputs)?.under(changes).behind(features),
            weights: dataset.weights_over(rows),
        })
    }

    /// Trains in one pass over `rows`; `None` if cancelled. The result is a function of weights, part and epoch.
    ///
    /// # Errors
    /// [`Error::Diverged`] for a loss that is not finite.
    pub fn epoch(&mut self, epoch: usize, rows: &[usize], hooks: &mut Hooks) -> Result<Option<Epoch>> {
        let TrainingKey { seed, repetition, fold } = self.set.part;
        let order = self.set.part.shuffled(rows, epoch);
        let lr = self.recipe.rate(epoch);
        let occasion = format!("e{epoch}");
        let (mut loss_sum, mut score, mut seen) = (0.0, 0.0, 0);
        for (number, rows) in order.chunks(self.batch).enumerate() {
            if hooks.is_cancelled() {
                return Ok(None);
            }
            self.engine.set_dropout(self.dropout, (epoch * self.steps + number) as u64);
            let key = Key { seed, repetition, fold, epoch, sample: 0 };
            let augment = self.recipe.augment.as_ref().map(|augment| (augment, key));
            let pass = TrainingPass { occasion: &occasion, augment };
            let logits = self.feed.train(&mut self.engine, rows, pass)?;
            let (sum, terms) = self.objective.score(logits, rows);
            (score, seen) = (score + sum, seen + terms);
            let of_row = |weights: &Vec<f32>| rows.iter().map(|row| weights[*row]).collect::<Vec<_>>();
            let (engine, weights) = (&mut self.engine, self.weights.as_ref().map(of_row));
            let mut backward = |loss, targets: Targets| match &weights {
                Some(weights) => engine.backward_weighted(loss, targets, weights),
                None => engine.backward_with(loss, targets),
            };
            let loss = self.objective.backward(rows, self.set.teacher, &mut backward)?;
            if !loss.is_finite() {
                return Err(self.diverged(epoch, number, loss, lr));
            }
            if let Some(clip) = self.recipe.clip {
                self.engine.clip_gradients(clip as f32);
            }
            self.recipe.optimizer.step(&mut self.engine, lr);
            loss_sum += f64::from(loss) * rows.len() as f64;
            (hooks.tick)(rows.len());
        }
        Ok(Some(Epoch {
            epoch,
            lr,
            train_loss: loss_sum / order.len().max(1) as f64,
            train_score: score / seen.max(1) as f64,
            validation_loss: None,
            validation_score: None,
        }))
    }

    /// Makes the batch-norm statistics what the recipe wants them to be; false if cancelled.
    ///
    /// # Errors
    /// An error of the engine.
    pub fn settle(&mut self, rows: &[usize], hooks: &Hooks) -> Result<bool> {
        if !self.settled && !self.recompute(rows, hooks)? {
            return Ok(false);
        }
        self.settled = true;
        Ok(true)
    }

    /// Computes batch-norm statistics over the whole training part, under its faults and the changes of its readings if it has
    /// some; false if cancelled. Training does not see them.
    ///
    /// # Errors
    /// An error of the engine.
    pub fn recompute(&mut self, rows: &[usize], hooks: &Hooks) -> Result<bool> {
        if !self.has_norms {
            return Ok(true);
        }
        self.engine.begin_recomputing();
        self.engine.set_dropout(self.dropout, 1 << 32);
        let TrainingKey { seed, repetition, fold } = self.set.part;
        let key = Key { seed, repetition, fold, epoch: self.recipe.epochs, sample: 0 };
        // Moved images keep their mean and variance, other than readings with another gain.
        let augment = self.recipe.augment.as_ref().filter(|augment| augment.changes_readings());
        let pass = TrainingPass { occasion: "population", augment: augment.map(|augment| (augment, key)) };
        for rows in self.set.part.shuffle(rows, &self.set.part.purpose("population")).chunks(self.batch) {
            if hooks.is_cancelled() {
                return Ok(false);
            }
            self.feed.train(&mut self.engine, rows, pass)?;
        }
        self.engine.end_recomputing();
        Ok(true)
    }

    /// Returns all parameters and statistics as they are now, as the model has them.
    ///
    /// # Errors
    /// A network whose outputs cannot be brought to the unit of the targets.
    pub fn weights(&self) -> Result<Weights> {
        let weights = match &self.first {
            None => self.engine.weights(),
            Some(first) => {
                let mut weights = first.clone();
                self.engine.weights().iter().for_each(|(name, tensor)| weights.insert(name, tensor.clone()));
                weights
            }
        };
        self.objective.finished(&self.network.graph, weights)
    }

    /// Computes answers for `rows` and their mean loss, of the network as its file will predict: frozen, with `weights`.
    ///
    /// # Errors
    /// An error of the runtime.
    pub fn test(&mut self, weights: &Weights, rows: &[usize]) -> Result<Tested> {
        let responder = |graph, weights| Responder::floats(graph, weights, self.batch, self.set.threads);
        let each = self.batch.max(AT_ONCE);
        let (responder, mut features) = match &self.halves {
            Some(Halves { body, head }) => {
                let (inputs, by) = (encoded(body, self.set.inputs), (each, self.set.threads));
                let features = CachedFeatures::tested(body, &weights.only(body), inputs, by, self.set.cache)?;
                (responder(head, &weights.only(head))?, Some(features))
            }
            None => (responder(&self.network.graph, weights)?, None),
        };
        let mut logits = vec![];
        for rows in rows.chunks(each) {
            logits.extend(match &mut features {
                Some(features) => responder.decide(&[features.rows(rows)?], rows.len())?,
                None => responder.decide(&self.feed.rows(rows), rows.len())?,
            });
        }
        let loss = self.objective.test_loss(&logits, rows)?;
        let spread = self.objective.spread_of_model(&logits);
        Ok(Tested { answers: self.objective.answers_of_model(logits), spread, loss })
    }

    /// Returns the mean loss of `rows`, and each of `metrics` in its unit.
    ///
    /// # Errors
    /// An error of the engine.
    pub fn validate<const N: usize>(
        &mut self,
        rows: &[usize],
        metrics: [&Metric; N],
    ) -> Result<(f64, [f64; N])> {
        let mut logits = vec![];
        for rows in rows.chunks(self.batch) {
            logits.extend_from_slice(self.feed.forward(&mut self.engine, rows, Mode::Eval)?);
        }
        let loss = self.objective.loss(&logits, rows);
        let (answers, mut scores) = (self.objective.answers(logits), [0.0; N]);
        for (score, metric) in scores.iter_mut().zip(metrics) {
            *score = self.score(metric, answers.clone(), rows)?;
        }
        Ok((loss, scores))
    }

    /// Returns the mean loss and the primary metric of the network as its file would predict now.
    ///
    /// # Errors
    /// An error of the runtime.
    pub fn test_scores(&mut self, rows: &[usize]) -> Result<(f64, f64)> {
        let Tested { answers, loss, .. } = self.test(&self.weights()?, rows)?;
        Ok((loss, self.score(Metric::primary(&self.task), answers, rows)?))
    }

    fn score(&self, metric: &Metric, answers: Vec<f32>, rows: &[usize]) -> Result<f64> {
        if rows.is_empty() {
            return Ok(0.0);
        }
        let outcome = Outcome::new(&self.set.dataset.targets, rows, answers);
        Ok(match metric.terms(&self.task, &outcome) {
            Some(terms) => metric.unit.scale() * terms.iter().sum::<f64>() / terms.len() as f64,
            None => metric.of(&self.task, &outcome)?,
        })
    }

    fn diverged(&self, epoch: usize, batch: usize, loss: f32, lr: f64) -> Error {
        let TrainingKey { repetition, fold, .. } = self.set.part;
        let network = self.set.name.into();
        Error::Diverged { network, repetition, fold, epoch, batch, loss, lr: lr as f32 }
    }

    /// Makes the error of a last epoch that left the finite numbers.
    pub fn diverged_at_the_end(&self, value: f32) -> Error {
        let last = self.recipe.epochs.saturating_sub(1);
        self.diverged(last, self.steps.saturating_sub(1), value, self.recipe.rate(last))
    }
}

/// Returns the weights that training starts from.
fn first_weights(
    network: &Trainable,
    part: TrainingKey,
    recipe: &Recipe,
    objective: &dyn Objective,
) -> Result<Weights> {
    let graph = &network.graph;
    let purpose = part.purpose(&format!("init/{}", graph.name()));
    let mut weights = Weights::init(graph, recipe.init, part.seed, &purpose);
    if let Some(start) = network.start.as_deref() {
        let drawn = weights.start_from(graph, start, false).map_err(taxel_engine::Error::from)?;
        if drawn.is_empty() {
            weights = objective.begun(graph, weights)?;
        }
    }
    Ok(weights)
}

/// Builds the engine of the head only, and the cache that gives it the features of the frozen body; `options` are those
/// of the whole network.
fn engine_behind(
    Halves { body, head }: &Halves,
    graph: &Graph,
    set: &TrainingSet,
    weights: &Weights,
    options: EngineOptions,
) -> Result<(Engine, CachedFeatures)> {
    // Features are predictions, and those are made in f32.
    let of_body = EngineOptions { frozen: vec![], precision: Precision::F32, ..options.clone() };
    let inputs = encoded(body, set.inputs);
    let features = CachedFeatures::learned(body, &weights.only(body), inputs, of_body, set.cache)?;
    let frozen = left(head, graph, &options.frozen).map_err(taxel_engine::Error::from)?;
    let options = EngineOptions { frozen, ..options };
    Ok((Engine::new(head, &weights.only(head), options)?, features))
}

/// Returns the inputs that `graph` reads, in its order.
fn encoded(graph: &Graph, inputs: &[Input]) -> Vec<Arc<Encoded>> {
    read_by(graph, inputs).iter().map(|input| Arc::clone(&input.encoded)).collect()
}

/// Returns the names of the nodes of a part of `graph` that `frozen` covers.
fn left(part: &Graph, graph: &Graph, frozen: &[String]) -> taxel_graph::Result<Vec<String>> {
    let covered = graph.nodes().iter().zip(graph.covered(frozen)?).filter(|(_, covered)| *covered);
    let in_part = |name: &str| part.nodes().iter().any(|node| node.name == name && node.op != Op::Input);
    Ok(covered.map(|(node, _)| node.name.clone()).filter(|name| in_part(name)).collect())
}
