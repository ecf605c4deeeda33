//! Methods that learned values instead of classes.

use crate::extra_trees::TreesMemory;
use crate::nearest::NearestMemory;
use crate::rocket_values::RocketValuesMemory;
use crate::{ALPHAS, Error, ExtraTrees, FeatureMatrix, Method, NearestValues, Result};
use crate::{Ridge, RocketValues, Saved, Series};

/// A method that has seen its training part and predicts values `[n, outputs]`, row-major, in the units of the targets.
#[derive(Debug, Clone, PartialEq)]
pub enum FittedValues {
    /// The mean of each value in the training part.
    Mean(Vec<f32>),
    /// Linear regression on the readings of series of this shape (channels, length).
    Ridge([usize; 2], Ridge),
    /// The training part itself.
    Nearest(NearestValues),
    /// Features and the linear regression on them.
    MiniRocket(Box<RocketValues>),
    /// Trees on features of the series.
    ExtraTrees(ExtraTrees),
}

/// Memory of one thread.
#[derive(Debug)]
pub(crate) enum ValuesMemory {
    Mean,
    /// Products with the weights of each value.
    Ridge(Vec<f64>),
    Nearest(NearestMemory),
    MiniRocket(Box<RocketValuesMemory>),
    ExtraTrees(TreesMemory),
}

impl FittedValues {
    pub(crate) fn fit(
        method: &Method,
        train: &Series,
        values: &[f32],
        outputs: usize,
        key: (u64, &str),
    ) -> Result<Self> {
        if outputs == 0 || values.len() != train.len() * outputs {
            return Err(Error::Labels { labels: values.len() / outputs.max(1), samples: train.len() });
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::Target { sample: at / outputs, value: values[at] });
        }
        method.refuse_weights(train)?;
        Ok(match *method {
            Method::Mean => FittedValues::Mean(mean(values, outputs, train.weights)),
            Method::Ridge => {
                let ridge = Ridge::fit_values(&readings(train), values, outputs, &ALPHAS)?;
                FittedValues::Ridge(train.shape(), ridge)
            }
            Method::NearestNeighbours { k } => {
                FittedValues::Nearest(NearestValues::fit(train, values, outputs, k)?)
            }
            Method::MiniRocket { features } => {
                FittedValues::MiniRocket(Box::new(RocketValues::fit(train, values, outputs, features, key)?))
            }
            Method::ExtraTrees { trees, min_samples_leaf } => {
                let sizes = [trees, min_samples_leaf];
                FittedValues::ExtraTrees(ExtraTrees::fit(train, values, outputs, sizes, key)?)
            }
            Method::Majority | Method::SvmLinear { .. } | Method::SvmRbf { .. } => {
                return Err(refusal(method));
            }
        })
    }

    pub(crate) fn read(method: &Method, shape: [usize; 2], outputs: usize, saved: &Saved) -> Result<Self> {
        Ok(match *method {
            Method::Mean => FittedValues::Mean(saved.sized("mean", outputs)?.to_vec()),
            Method::Ridge => FittedValues::Ridge(shape, Ridge::read(shape[0] * shape[1], outputs, saved)?),
            Method::NearestNeighbours { k } => {
                FittedValues::Nearest(NearestValues::read(k, shape, outputs, saved)?)
            }
            Method::MiniRocket { .. } => {
                FittedValues::MiniRocket(Box::new(RocketValues::read(shape, outputs, saved)?))
            }
            Method::ExtraTrees { trees, .. } => {
                FittedValues::ExtraTrees(ExtraTrees::read(shape, outputs, trees, saved)?)
            }
            Method::Majority | Method::SvmLinear { .. } | Method::SvmRbf { .. } => {
                return Err(refusal(method));
            }
        })
    }

    pub(crate) fn predict(&self, x: &Series) -> Result<Vec<f32>> {
        match self {
            FittedValues::Mean(means) => Ok(means.repeat(x.len())),
            FittedValues::Ridge(shape, ridge) => {
                x.expect(*shape)?;
                Ok(ridge.decide(&readings(x)))
            }
            FittedValues::Nearest(nearest) => nearest.predict(x),
            FittedValues::MiniRocket(rocket) => rocket.predict(x),
            FittedValues::ExtraTrees(trees) => trees.predict(x),
        }
    }

    pub(crate) fn memory(&self) -> ValuesMemory {
        match self {
            FittedValues::Mean(_) => ValuesMemory::Mean,
            FittedValues::Ridge(_, ridge) => ValuesMemory::Ridge(vec![0.0; ridge.classes()]),
            FittedValues::Nearest(nearest) => ValuesMemory::Nearest(nearest.neighbours().memory()),
            FittedValues::MiniRocket(rocket) => ValuesMemory::MiniRocket(Box::new(rocket.memory())),
            FittedValues::ExtraTrees(trees) => ValuesMemory::ExtraTrees(trees.memory()),
        }
    }

    /// Writes the values of one recording of its shape.
    pub(crate) fn predict_one(
        &self,
        recording: &[f32],
        memory: &mut ValuesMemory,
        values: &mut [f32],
    ) -> Result<()> {
        match (self, memory) {
            (FittedValues::Mean(means), ValuesMemory::Mean) => values.copy_from_slice(means),
            (FittedValues::Ridge(_, ridge), ValuesMemory::Ridge(products))
                if products.len() == ridge.classes() =>
            {
                ridge.decide_one(recording, products, values);
            }
            (FittedValues::Nearest(nearest), ValuesMemory::Nearest(memory))
                if memory.fits(nearest.neighbours().len()) =>
            {
                nearest.predict_one(recording, memory, values);
            }
            (FittedValues::MiniRocket(rocket), ValuesMemory::MiniRocket(memory)) if rocket.fits(memory) => {
                rocket.predict_one(recording, memory, values);
            }
            (FittedValues::ExtraTrees(trees), ValuesMemory::ExtraTrees(memory)) if trees.fits(memory) => {
                trees.predict_one(recording, memory, values);
            }
            _ => return Err(Error::foreign_workspace()),
        }
        Ok(())
    }

    pub(crate) fn left_out(&self, train: &Series, values: &[f32], units: &[u32]) -> Result<Option<Vec<f32>>> {
        match self {
            FittedValues::Ridge(shape, ridge) => {
                train.expect(*shape)?;
                ridge.left_out_values(&readings(train), values, units).map(Some)
            }
            FittedValues::MiniRocket(rocket) => rocket.left_out(train, values, units).map(Some),
            FittedValues::Mean(_) | FittedValues::Nearest(_) | FittedValues::ExtraTrees(_) => Ok(None),
        }
    }

    pub(crate) fn shape(&self) -> Option<[usize; 2]> {
        match self {
            FittedValues::Mean(_) => None,
            FittedValues::Ridge(shape, _) => Some(*shape),
            FittedValues::Nearest(nearest) => Some(nearest.neighbours().shape()),
            FittedValues::MiniRocket(rocket) => Some(rocket.shape()),
            FittedValues::ExtraTrees(trees) => Some(trees.shape()),
        }
    }

    pub(crate) fn outputs(&self) -> usize {
        match self {
            FittedValues::Mean(means) => means.len(),
            FittedValues::Ridge(_, ridge) => ridge.classes(),
            FittedValues::Nearest(nearest) => nearest.outputs(),
            FittedValues::MiniRocket(rocket) => rocket.outputs(),
            FittedValues::ExtraTrees(trees) => trees.outputs(),
        }
    }

    pub(crate) fn macs(&self) -> u64 {
        match self {
            FittedValues::Mean(_) => 0,
            FittedValues::Ridge(_, ridge) => ridge.macs(),
            FittedValues::Nearest(nearest) => nearest.neighbours().macs(),
            FittedValues::MiniRocket(rocket) => rocket.macs(),
            FittedValues::ExtraTrees(trees) => trees.macs(),
        }
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        match self {
            FittedValues::Mean(means) => vec![("mean", vec![means.len()], means.clone())],
            FittedValues::Ridge(_, ridge) => ridge.tensors(),
            FittedValues::Nearest(nearest) => nearest.tensors(),
            FittedValues::MiniRocket(rocket) => rocket.tensors(),
            FittedValues::ExtraTrees(trees) => trees.tensors(),
        }
    }
}

fn refusal(method: &Method) -> Error {
    Error::setting("method", method.name(), "learns classes, and the targets are values")
}

/// Returns the readings of each recording as its features.
fn readings(x: &Series) -> FeatureMatrix {
    let [channels, length] = x.shape();
    FeatureMatrix::new(x.values.to_vec(), channels * length).weighted(x.weights)
}

fn mean(values: &[f32], outputs: usize, weights: Option<&[f32]>) -> Vec<f32> {
    let weight = |row: usize| weights.map_or(1.0, |weights| f64::from(weights[row]));
    let whole: f64 = (0..values.len() / outputs).map(weight).sum();
    let column = |output: usize| values.iter().skip(output).step_by(outputs).enumerate();
    let sum = |output: usize| column(output).map(|(row, value)| weight(row) * f64::from(*value)).sum::<f64>();
    (0..outputs).map(|output| (sum(output) / whole) as f32).collect()
}
