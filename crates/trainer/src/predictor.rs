//! A saved network or baseline, ready for raw samples.

use ndarray::{ArrayD, Axis};
use taxel_baselines::{Fitted, Method, Saved, Series};
use taxel_engine::{Engine, Mode, Options};
use taxel_graph::{Graph, Loss, Weights};

use crate::baseline::Readings;
use crate::checkpoint::{Metadata, read_tensors};
use crate::encode::Transform;
use crate::error::{Error, Result};
use crate::experiment::Experiment;
use crate::folder::RunFolder;
use crate::labels::{Attribute, probabilities};
use crate::metrics::Levels;
use crate::results::FoldKey;

/// What a fold has learned: raw samples in, probabilities out, as in the fold's own test.
///
/// [`Predictor::encode`] and [`Predictor::answer`] are the two halves of [`Predictor::predict`].
pub struct Predictor {
    metadata: Metadata,
    levels: Levels,
    experiment: Experiment,
    machine: Machine,
}

enum Machine {
    Network { graph: Box<Graph>, engine: Box<Engine>, loss: Loss, batch: usize },
    Baselines { machines: Vec<Fitted>, shape: [usize; 2] },
}

impl Predictor {
    /// The model of a finished fold. `attributes` are those of the samples it was trained on; a network
    /// answers at most `batch` samples at a time, on `threads` threads (baselines on those of the caller).
    ///
    /// # Errors
    /// A model that is not there, is damaged or belongs to another network.
    pub fn open(
        folder: &RunFolder,
        experiment: &Experiment,
        attributes: &[Attribute],
        key: &FoldKey,
        (batch, threads): (usize, usize),
    ) -> Result<Self> {
        let path = folder.model_path(key);
        let (weights, metadata) = read_tensors(&path)?;
        let levels = Levels::new(&attributes.iter().map(|a| a.classes.len()).collect::<Vec<_>>());
        let config = experiment.config();
        let network = config.network(&key.network);
        let machine = match network {
            Some(network) => {
                let graph = metadata.graph()?;
                let refuse =
                    |source| Error::Weights { file: path.display().to_string(), source: Box::new(source) };
                weights.check(&graph).map_err(refuse)?;
                let batch = batch.max(1);
                let engine = Engine::new(&graph, &weights, Options { batch, threads, ..Options::default() })?;
                let loss = network.train(&config.train).loss;
                let (graph, engine) = (Box::new(graph), Box::new(engine));
                Machine::Network { graph, engine, loss, batch }
            }
            None => baselines(&weights, &metadata, attributes)
                .map_err(|reason| Error::damaged(&path, format!("holds no baseline: {reason}")))?,
        };
        Ok(Predictor { metadata, levels, experiment: experiment.clone(), machine })
    }

    /// What the model says about itself.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The network; none for a baseline.
    pub fn graph(&self) -> Option<&Graph> {
        match &self.machine {
            Machine::Network { graph, .. } => Some(graph),
            Machine::Baselines { .. } => None,
        }
    }

    /// Names of the inputs, in the order of [`Predictor::encode`].
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        self.metadata.inputs.iter().map(|(name, _)| name.as_str())
    }

    /// Raw samples `[n, ..]` to the model's inputs; `source` names them in messages.
    ///
    /// # Errors
    /// Samples of another shape, or readings that cannot be encoded.
    pub fn encode(&self, x: &ArrayD<f32>, source: &str) -> Result<Vec<ArrayD<f32>>> {
        let encode = |(_, transform): &(String, Transform)| match &self.machine {
            Machine::Network { .. } => transform.apply(x, source),
            Machine::Baselines { .. } => {
                let readings = Readings::of(x, self.experiment.config(), source)?;
                transform.apply(&readings.into_array(), source)
            }
        };
        self.metadata.inputs.iter().map(encode).collect()
    }

    /// Encoded samples to probabilities `[n, outputs]`, row-major.
    ///
    /// # Errors
    /// Inputs of another shape, or what the engine refuses.
    pub fn answer(&mut self, inputs: &[ArrayD<f32>]) -> Result<Vec<f32>> {
        let n = inputs.first().map_or(0, |x| x.len_of(Axis(0)));
        let standard: Vec<_> = inputs.iter().map(|x| x.as_standard_layout()).collect();
        let values: Vec<&[f32]> = standard.iter().filter_map(|x| x.as_slice()).collect();
        match &mut self.machine {
            Machine::Network { engine, loss, batch, .. } => {
                let mut outputs = vec![];
                for start in (0..n).step_by(*batch) {
                    let count = (*batch).min(n - start);
                    let part = |x: &&'_ [f32]| -> Vec<f32> {
                        let each = x.len() / n;
                        x[start * each..(start + count) * each].to_vec()
                    };
                    let parts: Vec<Vec<f32>> = values.iter().map(part).collect();
                    let parts: Vec<&[f32]> = parts.iter().map(Vec::as_slice).collect();
                    outputs.extend_from_slice(engine.forward(&parts, count, Mode::Eval)?);
                }
                probabilities(*loss, self.levels.outputs(), &mut outputs);
                Ok(outputs)
            }
            Machine::Baselines { machines, shape: [channels, length] } => {
                let baseline = self.metadata.network.as_str();
                let refuse = |source| Error::Baseline { baseline: baseline.into(), source };
                let series = Series::new(values.first().copied().unwrap_or_default(), *channels, *length)
                    .map_err(refuse)?;
                let own: Vec<Vec<f32>> = machines
                    .iter()
                    .map(|machine| machine.scores(&series).map_err(refuse))
                    .collect::<Result<_>>()?;
                Ok(side_by_side(&own, self.levels.sizes(), n))
            }
        }
    }

    /// Raw samples `[n, ..]` to probabilities `[n, outputs]`, row-major.
    ///
    /// # Errors
    /// As [`Predictor::encode`] and [`Predictor::answer`].
    pub fn predict(&mut self, x: &ArrayD<f32>, source: &str) -> Result<Vec<f32>> {
        let inputs = self.encode(x, source)?;
        self.answer(&inputs)
    }

    /// Probabilities `[n, outputs]` to classes or levels `[n, attributes]`.
    pub fn predicted(&self, probabilities: &[f32]) -> Vec<u32> {
        self.levels.predicted(probabilities)
    }
}

/// Scores of attributes, each `[n, its levels]`, as `[n, outputs]`.
pub(crate) fn side_by_side(own: &[Vec<f32>], sizes: &[usize], n: usize) -> Vec<f32> {
    let mut rows = vec![];
    for sample in 0..n {
        for (scores, &size) in own.iter().zip(sizes) {
            rows.extend_from_slice(&scores[sample * size..(sample + 1) * size]);
        }
    }
    rows
}

fn baselines(
    weights: &Weights,
    metadata: &Metadata,
    attributes: &[Attribute],
) -> std::result::Result<Machine, String> {
    let mut settings = metadata.settings.clone();
    settings.insert("name".into(), metadata.network.clone().into());
    let method: Method =
        serde_json::from_value(serde_json::Value::Object(settings)).map_err(|e| e.to_string())?;
    let Some(shape) = metadata.series else {
        return Err("it was saved by an older version; run the experiment again".into());
    };
    let machine = |attribute: &Attribute| {
        let prefix = if attributes.len() > 1 { format!("{}.", attribute.name) } else { String::new() };
        let mut saved = Saved::default();
        for (name, tensor) in weights.iter() {
            if let Some(name) = name.strip_prefix(&prefix) {
                saved.insert(name, &tensor.data);
            }
        }
        Fitted::read(&method, shape, attribute.classes.len(), &saved).map_err(|e| e.to_string())
    };
    let machines = attributes.iter().map(machine).collect::<std::result::Result<_, _>>()?;
    Ok(Machine::Baselines { machines, shape })
}
