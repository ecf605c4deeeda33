//! Named tensors that belong to a graph.

use std::collections::HashMap;

use rand::distr::{Distribution, Uniform};
use rand_distr::Normal;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::graph::{Graph, Init, Param};

/// One tensor: shape in PyTorch's axis order, values in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Axis sizes.
    pub shape: Vec<usize>,
    /// Values, last axis fastest.
    pub data: Vec<f32>,
}

/// How fresh weights are drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// PyTorch's default: weights and biases uniform in ±1/√fan_in, unless the network says otherwise.
    #[default]
    Pytorch,
    /// MATLAB's default: weights uniform in ±√(6 / (fan_in + fan_out)), biases zero.
    Glorot,
    /// He et al. 2015: weights normal with SD √(2 / fan_in), biases zero.
    He,
}

/// Tensors by name, in the order of the graph they were made for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Weights {
    names: Vec<String>,
    tensors: HashMap<String, Tensor>,
}

impl Weights {
    /// Makes weights without any tensors yet.
    pub fn new() -> Self {
        Weights::default()
    }

    /// Adds or replaces a tensor.
    pub fn insert(&mut self, name: &str, tensor: Tensor) {
        if self.tensors.insert(name.into(), tensor).is_none() {
            self.names.push(name.into());
        }
    }

    /// Returns the tensor of that name.
    pub fn get(&self, name: &str) -> Option<&Tensor> {
        self.tensors.get(name)
    }

    /// Returns names and tensors in order of insertion.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Tensor)> {
        #[expect(clippy::expect_used, reason = "names and tensors are inserted together")]
        let tensor = |name| self.tensors.get(name).expect("every name has its tensor");
        self.names.iter().map(move |name| (name.as_str(), tensor(name)))
    }

    /// Returns the number of tensors.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Checks whether there is no tensor.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Draws fresh weights. Every tensor has its own stream, keyed by `purpose` and its name, so adding a layer does
    /// not change the others.
    pub fn init(graph: &Graph, scheme: Scheme, seed: u64, purpose: &str) -> Self {
        let mut weights = Weights::new();
        for param in graph.params() {
            let data = draw(param, scheme, seed, purpose);
            weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
        }
        weights
    }

    /// Refuses missing, extra and misshaped tensors by name. PyTorch's `num_batches_tracked` is let pass.
    pub fn check(&self, graph: &Graph) -> Result<()> {
        self.check_params(graph.name(), graph.params())
    }

    /// Refuses the same for some tensors of a network `model` alone.
    ///
    /// # Errors
    /// As [`Weights::check`].
    pub fn check_params<'a>(&self, model: &str, params: impl Iterator<Item = &'a Param>) -> Result<()> {
        let model = model.to_string();
        let mut known = HashMap::new();
        for param in params {
            known.insert(param.name.as_str(), ());
            match self.get(&param.name) {
                None => {
                    return Err(Error::Missing {
                        model,
                        name: param.name.clone(),
                        shape: param.shape.clone(),
                        hint: self.hint(&param.name).into(),
                    });
                }
                Some(tensor) if tensor.shape != param.shape || tensor.data.len() != param.len() => {
                    return Err(Error::Misshaped {
                        model,
                        name: param.name.clone(),
                        got: tensor.shape.clone(),
                        expected: param.shape.clone(),
                    });
                }
                Some(_) => {}
            }
        }
        let extra = self
            .names
            .iter()
            .find(|n| !known.contains_key(n.as_str()) && !n.ends_with("num_batches_tracked"));
        match extra {
            Some(name) => Err(Error::Extra { model, name: name.clone() }),
            None => Ok(()),
        }
    }

    /// Says how to name a tensor that is there under a longer name, as wrappers of PyTorch's modules save it.
    fn hint(&self, name: &str) -> String {
        let prefix =
            self.names.iter().find_map(|held| held.strip_suffix(name).filter(|rest| rest.ends_with('.')));
        prefix.map_or(String::new(), |prefix| {
            format!(
                ". The file has it as `{prefix}{name}`, as DataParallel (`module.`) and torch.compile (`_orig_mod.`) name \
                 tensors: save {{k.removeprefix(\"{prefix}\"): v for k, v in model.state_dict().items()}}"
            )
        })
    }

    /// Refuses values that are not finite, and variances below 0, by tensor and place: a network with them predicts nothing.
    ///
    /// # Errors
    /// [`Error::Unsound`] of the first such tensor.
    pub fn refuse_unsound(&self) -> Result<()> {
        for (name, tensor) in self.iter() {
            let is_variance = name.ends_with("running_var");
            let is_odd = |value: &f32| !value.is_finite() || is_variance && *value < 0.0;
            if let Some(at) = tensor.data.iter().position(is_odd) {
                let (value, index) = (tensor.data[at], index(&tensor.shape, at));
                let kind = if value.is_finite() { ", a variance below 0" } else { "" };
                let reason =
                    format!("is {value} at {index:?}{kind}; the training diverged or the file is damaged");
                return Err(Error::Unsound { name: name.into(), reason });
            }
        }
        Ok(())
    }
}

/// Returns the index along each axis of the `flat`-th value.
fn index(shape: &[usize], mut flat: usize) -> Vec<usize> {
    let mut index = vec![0; shape.len()];
    for (place, size) in index.iter_mut().zip(shape).rev() {
        (*place, flat) = (flat % size.max(&1), flat / size.max(&1));
    }
    index
}

fn draw(param: &Param, scheme: Scheme, seed: u64, purpose: &str) -> Vec<f32> {
    let init = match (scheme, param.fan, param.init) {
        (_, _, Init::Constant(_)) | (Scheme::Pytorch, ..) => param.init,
        (Scheme::Glorot, Some((fan_in, fan_out)), _) => {
            Init::Uniform { bound: (6.0 / (fan_in + fan_out) as f32).sqrt() }
        }
        (Scheme::He, Some((fan_in, _)), _) => Init::Normal { sd: (2.0 / fan_in as f32).sqrt() },
        (_, None, _) => Init::Constant(0.0),
    };
    let mut rng = taxel_base::seed::rng(seed, &format!("{purpose}/{}", param.name));
    let count = param.len();
    match init {
        Init::Constant(value) => vec![value; count],
        Init::Uniform { bound } => {
            #[expect(clippy::expect_used, reason = "a graph's bounds are checked, and the schemes' are")]
            let uniform = Uniform::new_inclusive(-bound, bound).expect("a bound is finite and at least 0");
            uniform.sample_iter(&mut rng).take(count).collect()
        }
        Init::Normal { sd } => {
            #[expect(clippy::expect_used, reason = "a graph's deviations are checked, and the schemes' are")]
            let normal = Normal::new(0.0, sd).expect("a standard deviation is finite and at least 0");
            normal.sample_iter(&mut rng).take(count).collect()
        }
    }
}
