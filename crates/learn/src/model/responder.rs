//! A trained network for prediction: frozen, for many samples on several threads.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use taxel_graph::{Graph, Loss, Weights};
use taxel_runtime::{Frozen, Workspace};

use super::ready::Ready;
use super::workspace::ModelMemory;
use crate::error::Result;
use crate::metrics::Levels;
use crate::training::label_objective::probabilities;
use crate::training::part::pool;

/// Samples that a thread takes at a time.
const SHARE: usize = 16;

/// A frozen network with the memory of several threads.
pub(crate) struct Responder {
    frozen: Frozen,
    batch: usize,
    /// None where the caller's thread is enough.
    pool: Option<rayon::ThreadPool>,
    /// Workspaces that nobody is using.
    idle: Mutex<Vec<Workspace>>,
    /// The loss that probabilities come from, and the labels; none of values and features, which stay as they are.
    labels: Option<(Loss, Levels)>,
}

impl Responder {
    /// Freezes `graph` with `weights` in floats.
    ///
    /// # Errors
    /// Weights that do not fit the graph, and as [`Responder::new`].
    pub fn floats(graph: &Graph, weights: &Weights, batch: usize, threads: usize) -> Result<Self> {
        Self::new(Frozen::new(graph, weights)?, batch, threads)
    }

    /// Takes a network to predict up to `batch` samples at a time on each of `threads` threads. Answers depend on neither.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn new(frozen: Frozen, batch: usize, threads: usize) -> Result<Self> {
        let pool = if threads > 1 { Some(pool(threads)?) } else { None };
        Ok(Responder { frozen, batch: batch.min(SHARE), pool, idle: Mutex::default(), labels: None })
    }

    /// Returns the same network, whose logits are those of labels and become probabilities as the loss says.
    pub fn of_labels(self, loss: Loss, levels: Levels) -> Self {
        Responder { labels: Some((loss, levels)), ..self }
    }

    fn borrow(&self) -> Workspace {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        idle.unwrap_or_else(|| self.frozen.workspace_for(self.batch))
    }
}

impl Ready for Responder {
    fn memory(&self) -> ModelMemory {
        ModelMemory::Network(Box::new(self.frozen.workspace()))
    }

    fn decide_one(&self, inputs: &[Vec<f32>], memory: &mut ModelMemory, logits: &mut [f32]) -> Result<bool> {
        let ModelMemory::Network(memory) = memory else { return Ok(false) };
        let mut few: [&[f32]; 2] = [&[]; 2];
        let many: Vec<&[f32]>;
        let slices = match few.get_mut(..inputs.len()) {
            Some(few) => {
                few.iter_mut().zip(inputs).for_each(|(to, input)| *to = input);
                &*few
            }
            None => {
                many = inputs.iter().map(Vec::as_slice).collect();
                &many
            }
        };
        logits.copy_from_slice(self.frozen.predict(memory, slices)?);
        Ok(true)
    }

    fn decide(&self, inputs: &[&[f32]], n: usize) -> Result<Vec<f32>> {
        if n == 0 {
            return Ok(vec![]);
        }
        let width = self.frozen.logits();
        let mut logits = vec![0.0; n * width];
        let share = |first: usize, logits: &mut [f32]| {
            let count = logits.len() / width;
            let rows = |x: &&[f32]| first * (x.len() / n)..(first + count) * (x.len() / n);
            let parts: Vec<&[f32]> = inputs.iter().map(|x| &x[rows(x)]).collect();
            let mut workspace = self.borrow();
            let predicted = self.frozen.predict_many(&mut workspace, &parts, logits);
            self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
            predicted
        };
        match &self.pool {
            Some(pool) if n > 1 => {
                // As many samples for each, but few at a time.
                let each = n.div_ceil(pool.current_num_threads()).min(SHARE);
                let shares = logits.par_chunks_mut(each * width).enumerate();
                pool.install(|| shares.try_for_each(|(at, logits)| share(at * each, logits)))?;
            }
            _ => share(0, &mut logits)?,
        }
        Ok(logits)
    }

    fn finish(&self, logits: &mut [f32]) {
        if let Some((loss, levels)) = &self.labels {
            probabilities(*loss, levels, logits);
        }
    }

    fn has_logits(&self) -> bool {
        true
    }
}
