//! A fold in training, as it is saved: killed at any moment, it goes on to the same bytes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};
use taxel_base::files::remove_parts;
use taxel_checkpoint as checkpoint;
use taxel_engine::{Engine, OptimizerState};
use taxel_graph::Weights;

use crate::error::{Error, Result};
use crate::estimator::search::Trial;
use crate::run::options::RunOptions;
use crate::training::epoch::Epoch;

/// The best epoch of a training so far, by its validation part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Best {
    pub epoch: usize,
    pub loss: f64,
    #[serde(alias = "accuracy")]
    pub score: f64,
}

/// Where one training stands, less its tensors.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stage {
    /// Finished epochs.
    pub epochs: Vec<Epoch>,
    /// The best of them, with early stopping.
    pub best: Option<Best>,
    /// Steps of Adam so far.
    step: u64,
}

/// Where a fold stands.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SessionState {
    /// Digest of the training that it belongs to.
    of: String,
    /// Combinations of settings that were tried.
    pub trials: Vec<Trial>,
    /// The training that is under way.
    pub stage: Stage,
    /// Seconds so far.
    pub seconds: f64,
}

/// A fold in training: its state, and the weights of the best epoch.
#[derive(Debug, Default)]
pub(crate) struct Session {
    pub state: SessionState,
    pub best: Option<Weights>,
    /// Tensors of the stage under way, until an engine takes them.
    tensors: Option<(Weights, OptimizerState)>,
}

const GROUPS: [&str; 5] = ["weights", "momentum_buffer", "exp_avg", "exp_avg_sq", "best"];

impl Session {
    /// Puts the saved weights and optimiser of the stage under way into a fresh engine.
    pub fn restore(&mut self, engine: &mut Engine) -> Result<()> {
        if let Some((weights, optimizer)) = self.tensors.take() {
            engine.set_weights(&weights)?;
            engine.set_optimizer_state(&optimizer)?;
        }
        Ok(())
    }

    /// Begins the next stage.
    pub fn next_stage(&mut self) {
        self.state.stage = Stage::default();
        self.best = None;
        self.tensors = None;
    }
}

/// Saves a session from time to time.
#[derive(Debug)]
pub struct Saver {
    path: Option<PathBuf>,
    options: RunOptions,
    last: Instant,
    /// Seconds that the last time took.
    cost: f64,
    begin: Instant,
    /// Seconds of the session before this process.
    before: f64,
}

impl Saver {
    /// Saves to `path` as often as the options say, and never for more than a twentieth of the time.
    pub fn new(path: PathBuf, options: &RunOptions) -> Self {
        let now = Instant::now();
        Saver { path: Some(path), options: options.clone(), last: now, cost: 0.0, begin: now, before: 0.0 }
    }

    /// Saves nothing.
    pub fn none() -> Self {
        Saver { path: None, ..Saver::new(PathBuf::new(), &RunOptions::default()) }
    }

    /// Seconds of training, those of an earlier process included.
    pub fn seconds(&self) -> f64 {
        self.before + self.begin.elapsed().as_secs_f64()
    }

    /// Reads the saved session of the training `of`; makes a fresh one where nothing was saved.
    ///
    /// # Errors
    /// A file that cannot be read, or that another training has saved.
    pub(crate) fn load(&mut self, of: impl FnOnce() -> String) -> Result<Session> {
        let Some(path) = &self.path else { return Ok(Session::default()) };
        let of = of();
        if !path.is_file() {
            return Ok(Session {
                state: SessionState { of, ..SessionState::default() },
                ..Session::default()
            });
        }
        let damaged = |why: String| {
            Error::damaged(
                path,
                format!("{why}; delete it and go on: the training starts from the beginning"),
            )
        };
        let (tensors, text) = checkpoint::read(path).map_err(|e| damaged(e.to_string()))?;
        let state: SessionState =
            serde_json::from_str(&text.unwrap_or_default()).map_err(|e| damaged(e.to_string()))?;
        if state.of != of {
            return Err(damaged(
                "was saved by another training: other samples, network, recipe or seed".into(),
            ));
        }
        let mut groups: [Weights; 5] = Default::default();
        for (name, tensor) in tensors.iter() {
            let found = GROUPS
                .iter()
                .position(|group| name.strip_prefix(group).is_some_and(|rest| rest.starts_with('/')));
            let group = found.ok_or_else(|| damaged(format!("does not know `{name}`")))?;
            groups[group].insert(&name[GROUPS[group].len() + 1..], tensor.clone());
        }
        let [weights, momentum_buffer, exp_avg, exp_avg_sq, best] = groups;
        let optimizer = OptimizerState { step: state.stage.step, momentum_buffer, exp_avg, exp_avg_sq };
        self.before = state.seconds;
        let is_under_way = !state.stage.epochs.is_empty();
        Ok(Session {
            tensors: is_under_way.then_some((weights, optimizer)),
            best: state.stage.best.is_some().then_some(best),
            state,
        })
    }

    /// Saves the session if it is time, or the last time: says whether the training is to end now that it is saved.
    /// `engine` is that of the stage under way, if there is one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn save(&mut self, session: &mut Session, engine: Option<&Engine>) -> Result<bool> {
        let Some(path) = &self.path else { return Ok(false) };
        // Asked once: it may change meanwhile.
        let is_last = self.options.is_stopping();
        let wait = self.options.save_every().max(20.0 * self.cost);
        if self.last.elapsed().as_secs_f64() < wait && !is_last {
            return Ok(false);
        }
        let start = Instant::now();
        let mut tensors = Weights::new();
        let mut add = |group: &str, weights: &Weights| {
            weights
                .iter()
                .for_each(|(name, tensor)| tensors.insert(&format!("{group}/{name}"), tensor.clone()));
        };
        if let Some(engine) = engine {
            let optimizer = engine.optimizer_state();
            session.state.stage.step = optimizer.step;
            add("weights", &engine.weights());
            add("momentum_buffer", &optimizer.momentum_buffer);
            add("exp_avg", &optimizer.exp_avg);
            add("exp_avg_sq", &optimizer.exp_avg_sq);
        }
        if let Some(best) = &session.best {
            add("best", best);
        }
        session.state.seconds = self.before + self.begin.elapsed().as_secs_f64();
        let text = serde_json::to_string(&session.state)
            .map_err(|e| Error::damaged(path, format!("cannot be encoded: {e}")))?;
        checkpoint::write(path, &tensors, &text)?;
        (self.last, self.cost) = (Instant::now(), start.elapsed().as_secs_f64());
        Ok(is_last)
    }

    /// Removes what was saved of a finished fold, and what a killed process was about to save.
    pub fn remove(path: &Path) -> Result<()> {
        match std::fs::remove_file(path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io(path, "removed", e)),
            _ => remove_parts(path).map_err(|e| Error::io(path, "removed", e)),
        }
    }
}

/// Removes a saved training that nobody will go on with.
///
/// # Errors
/// A file that cannot be removed.
pub fn forget(session: &Path) -> Result<()> {
    Saver::remove(session)
}
