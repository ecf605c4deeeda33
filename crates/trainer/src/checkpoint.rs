//! Trained networks as safetensors files.

use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel_checkpoint as checkpoint;
use taxel_graph::{Graph, Weights};

use crate::encode::Transform;
use crate::error::{Error, Result};

/// What a checkpoint says about itself: enough to build the network and to encode its inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metadata {
    /// Name in the zoo.
    pub network: String,
    /// Its sizes and settings; what is left out has the default of the zoo.
    pub settings: taxel_zoo::Settings,
    /// Class names by label.
    pub classes: Vec<String>,
    /// Input name and how raw samples become it, in the order of the network's inputs.
    pub inputs: Vec<(String, Transform)>,
    /// Channels and length of the series that a baseline reads; none for networks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<[usize; 2]>,
    /// What it was trained on: `simulated: ..` or `real: ..`.
    pub source: String,
    /// Seed of the experiment.
    pub seed: u64,
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold that it has not seen, from 0.
    pub fold: usize,
}

impl Metadata {
    /// The network that the weights belong to.
    ///
    /// # Errors
    /// A network that this version does not know, or settings it refuses.
    pub fn graph(&self) -> Result<Graph> {
        Ok(taxel_zoo::find(&self.network)?.graph(&self.settings)?)
    }
}

/// Writes the weights of `graph` to `path`, first under another name: the file is whole or not there.
///
/// # Errors
/// Weights that do not belong to `graph`, or a file that cannot be written.
pub fn write_checkpoint(path: &Path, graph: &Graph, weights: &Weights, metadata: &Metadata) -> Result<()> {
    let refuse = |source| Error::Weights { file: path.display().to_string(), source: Box::new(source) };
    weights.check(graph).map_err(refuse)?;
    write_tensors(path, weights, metadata)
}

/// Writes the tensors of what is no graph: a baseline.
pub(crate) fn write_tensors(path: &Path, weights: &Weights, metadata: &Metadata) -> Result<()> {
    let text = serde_json::to_string(metadata)
        .map_err(|e| Error::damaged(path, format!("cannot be encoded: {e}")))?;
    Ok(checkpoint::write(path, weights, &text)?)
}

/// Reads weights and what they say about themselves; the tensors fit the network they name.
///
/// # Errors
/// A file that cannot be read, is no checkpoint of taxel, or holds other tensors than its network.
pub fn read_checkpoint(path: &Path) -> Result<(Weights, Metadata)> {
    let (weights, metadata) = read_tensors(path)?;
    let refuse = |source| Error::Weights { file: path.display().to_string(), source: Box::new(source) };
    weights.check(&metadata.graph()?).map_err(refuse)?;
    Ok((weights, metadata))
}

/// Reads what [`write_tensors`] wrote.
pub(crate) fn read_tensors(path: &Path) -> Result<(Weights, Metadata)> {
    let (weights, text) = checkpoint::read(path)?;
    let text = text.ok_or_else(|| {
        Error::damaged(path, "holds no metadata of taxel; give a checkpoint from a run folder")
    })?;
    let metadata = serde_json::from_str(&text)
        .map_err(|e| Error::damaged(path, format!("its metadata cannot be read: {e}")))?;
    Ok((weights, metadata))
}
