//! Training and testing one network on one fold.

use std::time::Instant;

use taxel_data::{Fold, hold_back};
use taxel_graph::Weights;

use crate::error::{Error, Result};
use crate::estimator::estimator::TrainingSet;
use crate::estimator::search::{Chosen, Trial};
use crate::estimator::trainable::Trainable;
use crate::metrics::Metric;
use crate::model::digest;
use crate::problem::Problem;
use crate::run::records::OtherStatistics;
use crate::training::epoch::Epoch;
use crate::training::feature_cache::halves;
use crate::training::hooks::Hooks;
use crate::training::learner::{Learner, Tested};
use crate::training::part::TrainingKey;
use crate::training::recipe::{BatchNorm, Recipe};
use crate::training::session::{Best, Session};

/// One network on one fold.
pub(crate) struct Training<'a> {
    /// The network and how it is trained.
    pub network: &'a Trainable,
    /// The samples that it learns from and is tested on.
    pub set: &'a TrainingSet<'a>,
}

/// A trained network and what it says about the test samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TrainedNetwork {
    /// Parameters and batch-norm statistics.
    pub weights: Weights,
    /// The recipe; where the fold has chosen one, that one.
    pub recipe: Recipe,
    /// Samples that were predicted at a time.
    pub batch: usize,
    /// The epochs of the training.
    pub epochs: Vec<Epoch>,
    /// The choice of the fold by its validation part.
    pub chosen: Option<Chosen>,
    /// The epoch whose weights these are, with early stopping.
    pub best_epoch: Option<usize>,
    /// Whether the training loss of that epoch, or of the last one, is far above that of knowing nothing.
    pub diverged: bool,
    /// Outputs `[test samples, outputs]`, in the order of the fold.
    pub outputs: Vec<f32>,
    /// How far below and above them it expects the true values; empty where it says nothing of it.
    pub spread: Vec<f32>,
    /// Mean loss over the test samples.
    pub test_loss: f64,
    /// The same weights with the other kind of batch-norm statistics.
    pub other_statistics: Option<OtherStatistics>,
    /// Seconds of training, batch-norm statistics included.
    pub train_seconds: f64,
    /// Seconds of testing.
    pub test_seconds: f64,
}

impl Training<'_> {
    /// Trains on the fold's training samples and predicts its test samples; `None` if cancelled. Goes on
    /// where the saver has saved.
    ///
    /// Fresh weights are keyed by network, repetition and fold, so networks may be added to an
    /// experiment without changing the others.
    ///
    /// # Errors
    /// [`Error::Diverged`] for a loss that is not finite, too few samples to hold some back, or what the
    /// engine refuses.
    pub fn run(&self, hooks: &mut Hooks) -> Result<Option<TrainedNetwork>> {
        let mut session = hooks.saver.load(|| self.digest())?;
        let Some((recipe, chosen)) = self.choose(&mut session, hooks)? else { return Ok(None) };
        let (rows, validation) = match &recipe.early_stopping {
            Some(stopping) => self.parts(stopping.validation, "stop", "train.early_stopping.validation")?,
            None => (self.set.fold.train.clone(), vec![]),
        };
        let Some(learner) = self.fit(&recipe, &rows, &validation, &mut session, hooks)? else {
            return Ok(None);
        };
        let stage = session.state.stage;
        let best_epoch = stage.best.map(|best| best.epoch);
        let tested = best_epoch.map_or(stage.epochs.last(), |best| stage.epochs.get(best));
        let diverged = tested.is_some_and(|epoch| learner.objective.is_diverged(epoch.train_loss));
        let Some(tested) = self.test(learner, &recipe, &rows, hooks)? else { return Ok(None) };
        Ok(Some(TrainedNetwork { chosen, best_epoch, diverged, epochs: stage.epochs, ..tested }))
    }

    /// Computes the digest of all that the weights depend on.
    fn digest(&self) -> String {
        let Trainable { graph, recipe, search, start } = self.network;
        let TrainingKey { seed, repetition, fold } = self.set.part;
        let transforms: Vec<_> = self.set.inputs.iter().map(|input| (input.name, &input.transform)).collect();
        let mut settings = serde_json::json!({
            "graph": graph, "recipe": recipe, "search": search, "start": start.as_deref().map(digest),
            "part": [seed, repetition as u64, fold as u64], "inputs": transforms,
            "data": self.set.dataset.digest, "facts": self.set.dataset.facts(),
            "rows": [&self.set.fold.train, &self.set.fold.validation],
        });
        // Its session has the tensors behind the frozen part alone.
        if let Some(halves) = halves(graph, recipe, self.set.dataset.len()) {
            settings["behind"] = halves.body.outputs()[0].0.as_str().into();
        }
        if let Some(teacher) = self.set.teacher {
            settings["teacher"] = teacher.digest().into();
        }
        blake3::hash(settings.to_string().as_bytes()).to_hex().to_string()
    }

    /// Predicts the test samples, with both kinds of batch-norm statistics.
    fn test(
        &self,
        mut learner: Learner,
        recipe: &Recipe,
        rows: &[usize],
        hooks: &Hooks,
    ) -> Result<Option<TrainedNetwork>> {
        let aside = Instant::now();
        let test = &self.set.fold.test;
        let mut other = match recipe.batch_norm {
            BatchNorm::Recomputed if learner.has_norms && !learner.settled => {
                Some((BatchNorm::Running, learner.test_scores(test)?))
            }
            _ => None,
        };
        let aside = aside.elapsed().as_secs_f64();
        if !learner.settle(rows, hooks)? {
            return Ok(None);
        }
        let train_seconds = hooks.saver.seconds() - aside;
        let weights = learner.weights()?;
        let start = Instant::now();
        let Tested { answers: outputs, spread, loss: test_loss } = learner.test(&weights, test)?;
        let test_seconds = start.elapsed().as_secs_f64();
        if let Some(&bad) = outputs.iter().find(|p| !p.is_finite()) {
            return Err(learner.diverged_at_the_end(bad));
        }
        if recipe.batch_norm == BatchNorm::Running && learner.has_norms {
            if !learner.recompute(rows, hooks)? {
                return Ok(None);
            }
            other = Some((BatchNorm::Recomputed, learner.test_scores(test)?));
        }
        let other_statistics = other
            .filter(|(_, (loss, _))| loss.is_finite() && !test.is_empty())
            .map(|(batch_norm, (test_loss, score))| OtherStatistics { batch_norm, score, test_loss });
        Ok(Some(TrainedNetwork {
            weights,
            recipe: recipe.clone(),
            batch: learner.batch,
            epochs: vec![],
            chosen: None,
            best_epoch: None,
            diverged: false,
            outputs,
            spread,
            test_loss,
            other_statistics,
            train_seconds,
            test_seconds,
        }))
    }

    /// Returns samples times epochs that [`Training::run`] trains on at most.
    pub fn samples(network: &Trainable, fold: &Fold) -> usize {
        let fitted = |recipe: &Recipe, share: Option<f64>| {
            let rows = fold.train.len();
            let held = share.filter(|_| fold.validation.is_empty()).map_or(0, |s| (rows as f64 * s) as usize);
            (rows - held) * recipe.for_samples(rows - held).epochs
        };
        let recipe = &network.recipe;
        let last = fitted(recipe, recipe.early_stopping.as_ref().map(|s| s.validation));
        let Some(search) = &network.search else { return last };
        let trials = search.grid.iter().map(|tried| fitted(&tried.recipe, Some(search.validation)));
        trials.sum::<usize>() + last
    }

    /// Returns the rows that are trained on and those that choose: the protocol's, or held back from the training
    /// part by the share that `key` gives.
    fn parts(&self, share: f64, purpose: &str, key: &str) -> Result<(Vec<usize>, Vec<usize>)> {
        let fold = self.set.fold;
        if !fold.validation.is_empty() {
            return Ok((fold.train.clone(), fold.validation.clone()));
        }
        let purpose = self.set.part.purpose(&format!("validation/{purpose}"));
        hold_back(
            &fold.train,
            &self.set.dataset.strata(),
            self.set.units,
            share,
            self.set.part.seed,
            &purpose,
        )
        .map_err(|error| match error {
            taxel_data::Error::NothingToHoldBack { .. } => {
                let how_to_fix = "give another share, record more samples or leave the table out";
                Problem::new(key, share, format!("{error}; {how_to_fix}")).into()
            }
            other => other.into(),
        })
    }

    /// Tries every recipe that is left open; the best one.
    fn choose(&self, session: &mut Session, hooks: &mut Hooks) -> Result<Option<(Recipe, Option<Chosen>)>> {
        let task = self.set.dataset.task();
        let Some(search) = &self.network.search else {
            return Ok(Some((self.network.recipe.for_task(&task), None)));
        };
        let metric = search.by.metric("choose.by", &task)?;
        let (rows, validation) = self.parts(search.validation, "choose", "choose.validation")?;
        while session.state.trials.len() < search.grid.len() {
            let tried = &search.grid[session.state.trials.len()];
            // Early stopping sees the same part: it, too, is never tested on.
            let stopping = if tried.recipe.early_stopping.is_some() { validation.as_slice() } else { &[] };
            let scores = match self.fit(&tried.recipe.for_task(&task), &rows, stopping, session, hooks) {
                Ok(None) => return Ok(None),
                Ok(Some(mut learner)) => {
                    if !learner.settle(&rows, hooks)? {
                        return Ok(None);
                    }
                    let (loss, [score]) = learner.validate(&validation, [metric])?;
                    Some((loss, score))
                }
                // A rate that is too high loses the comparison; the others go on.
                Err(Error::Diverged { .. }) => None,
                Err(error) => return Err(error),
            };
            session.state.trials.push(Trial {
                set: tried.set.clone(),
                loss: scores.map(|(loss, _)| loss).filter(|loss| loss.is_finite()),
                score: scores.map(|(_, score)| score),
            });
            session.next_stage();
            if hooks.saver.save(session, None)? {
                return Ok(None);
            }
        }
        let trials = session.state.trials.clone();
        let Some(best) = search.best(metric, &trials) else {
            let TrainingKey { repetition, fold, .. } = self.set.part;
            return Err(Error::NothingChosen {
                network: self.set.name.into(),
                repetition,
                fold,
                trials: trials.len(),
            });
        };
        let recipe = search.grid[best].recipe.for_task(&task);
        Ok(Some((recipe, Some(Chosen { set: trials[best].set.clone(), trials }))))
    }

    /// Trains on `rows`; with a validation part, the weights are those of its best epoch. What remains to be
    /// done is [`Learner::settle`].
    fn fit(
        &self,
        recipe: &Recipe,
        rows: &[usize],
        validation: &[usize],
        session: &mut Session,
        hooks: &mut Hooks,
    ) -> Result<Option<Learner<'_>>> {
        let recipe = &recipe.for_samples(rows.len());
        let mut learner = Learner::new(self.network, self.set, recipe, rows)?;
        session.restore(&mut learner.engine)?;
        let done = session.state.stage.epochs.len();
        (hooks.tick)(done * rows.len());
        let patience = recipe.early_stopping.as_ref().map_or(usize::MAX, |s| s.patience);
        for epoch in done..recipe.epochs {
            // Asked before the epoch, so that a resumed stage that was over stays over.
            let waited = session.state.stage.best.map_or(0, |best| epoch - 1 - best.epoch);
            if waited >= patience {
                (hooks.tick)((recipe.epochs - epoch) * rows.len());
                break;
            }
            let Some(mut line) = learner.epoch(epoch, rows, hooks)? else { return Ok(None) };
            if let Some(stopping) = recipe.early_stopping.as_ref().filter(|_| !validation.is_empty()) {
                if recipe.batch_norm == BatchNorm::Recomputed && !learner.recompute(rows, hooks)? {
                    return Ok(None);
                }
                let task = self.set.dataset.task();
                let metric = stopping.by.metric("train.early_stopping.by", &task)?;
                let both = [metric, Metric::primary(&task)];
                let (loss, [score, primary]) = learner.validate(validation, both)?;
                if !loss.is_finite() {
                    return Err(learner.diverged_at_the_end(loss as f32));
                }
                (line.validation_loss, line.validation_score) = (Some(loss), Some(primary));
                let stage = &mut session.state.stage;
                if stage.best.is_none_or(|b| stopping.by.prefers(metric, (loss, score), (b.loss, b.score))) {
                    stage.best = Some(Best { epoch, loss, score });
                    session.best = Some(learner.engine.weights());
                }
            }
            session.state.stage.epochs.push(line);
            if hooks.saver.save(session, Some(&learner.engine))? {
                return Ok(None);
            }
        }
        if let Some(best) = &session.best {
            learner.engine.set_weights(best)?;
            // Their statistics are those of their own epoch.
            learner.settled = true;
        }
        Ok(Some(learner))
    }
}
