//! Batches of encoded samples for a network.

use taxel_data::Key;
use taxel_engine::{Engine, Mode};
use taxel_graph::Graph;

use crate::encoding::{Encoded, Input};
use crate::error::Result;
use crate::training::feature_cache::CachedFeatures;
use crate::training::pass::TrainingPass;
use crate::training::raw_changes::RawChanges;

/// Gathers the rows of a batch into one slice per input of the graph.
pub(crate) struct Feed<'a> {
    inputs: Vec<&'a Encoded>,
    /// Values beyond the edges of an input's images.
    outside: Vec<Option<&'a [f32]>>,
    batches: Vec<Vec<f32>>,
    /// Changes raw training samples, where that is asked for.
    changes: Option<RawChanges<'a>>,
    /// The frozen part of the network, where the engine has the rest alone.
    features: Option<CachedFeatures>,
}

/// Returns the inputs that a network reads, in its order.
pub(crate) fn read_by<'a>(graph: &Graph, inputs: &'a [Input]) -> Vec<&'a Input> {
    let find = |node: &taxel_graph::Node| inputs.iter().find(|input| input.name == node.name);
    graph.inputs().filter_map(find).collect()
}

impl<'a> Feed<'a> {
    /// Makes the feed of a network from its encoded inputs.
    ///
    /// # Errors
    /// An input of the network that is not encoded.
    pub fn new(graph: &Graph, inputs: &'a [Input]) -> Result<Self> {
        let found = read_by(graph, inputs);
        if found.len() != graph.inputs().len() {
            let model = graph.name().to_string();
            let reason = "an input of the network is not encoded".to_string();
            return Err(taxel_engine::Error::Batch { model, reason }.into());
        }
        let outside = found.iter().map(|input| input.outside.as_deref()).collect();
        let inputs: Vec<&Encoded> = found.iter().map(|input| &*input.encoded).collect();
        Ok(Feed { batches: vec![vec![]; inputs.len()], inputs, outside, changes: None, features: None })
    }

    /// Returns the same feed, with raw training samples changed by `changes`.
    pub fn under(self, changes: Option<RawChanges<'a>>) -> Self {
        Feed { changes, ..self }
    }

    /// Returns the same feed, for an engine that learns from `features` in place of samples.
    pub fn behind(self, features: Option<CachedFeatures>) -> Self {
        Feed { features, ..self }
    }

    fn gather(&mut self, rows: &[usize]) {
        for (input, batch) in self.inputs.iter().zip(&mut self.batches) {
            input.gather(rows, batch);
        }
    }

    /// Returns the values of `rows`, one slice per input of the whole network.
    pub fn rows(&mut self, rows: &[usize]) -> Vec<&[f32]> {
        self.gather(rows);
        self.batches.iter().map(Vec::as_slice).collect()
    }

    fn run<'e>(&self, engine: &'e mut Engine, n: usize, mode: Mode) -> Result<&'e [f32]> {
        let slices: Vec<&[f32]> = self.batches.iter().map(Vec::as_slice).collect();
        Ok(engine.forward(&slices, n, mode)?)
    }

    /// Runs a forward pass over `rows` and returns the outputs.
    pub fn forward<'e>(&mut self, engine: &'e mut Engine, rows: &[usize], mode: Mode) -> Result<&'e [f32]> {
        if let Some(features) = &mut self.features {
            return Ok(engine.forward(&[features.rows(rows)?], rows.len(), mode)?);
        }
        self.gather(rows);
        self.run(engine, rows.len(), mode)
    }

    /// Runs a forward pass in training over `rows`, or over what faults and augmentation make of them.
    pub fn train<'e>(
        &mut self,
        engine: &'e mut Engine,
        rows: &[usize],
        pass: TrainingPass,
    ) -> Result<&'e [f32]> {
        if self.features.is_some() {
            return self.forward(engine, rows, Mode::Train);
        }
        self.gather(rows);
        if let Some(changes) = &mut self.changes {
            changes.fill(rows, &pass, &mut self.batches)?;
        }
        for ((input, outside), batch) in self.inputs.iter().zip(&self.outside).zip(&mut self.batches) {
            let (Some((augment, key)), Some(outside)) = (pass.augment, outside) else { continue };
            let (&[channels, height, width, ref frames @ ..], len) = (input.shape(), input.len()) else {
                continue;
            };
            let frames: usize = frames.iter().product();
            for (&sample, values) in rows.iter().zip(batch.chunks_exact_mut(len)) {
                let warp = augment.draw(&Key { sample, ..key });
                for (plane, value) in values.chunks_exact_mut(len / channels).zip(*outside) {
                    warp.apply(plane, [1, height, width, frames], *value);
                }
            }
        }
        self.run(engine, rows.len(), Mode::Train)
    }
}
