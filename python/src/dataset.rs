//! Labelled samples, as the library holds them.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use taxel::data::Quantity;
use taxel::experiment::simulated;
use taxel::{Experiment, Layout, Source, scenes};

use crate::config::experiment;
use crate::raise::{raised, refused};
use crate::work::short;

/// Labelled samples.
#[pyclass(frozen, module = "taxel._taxel")]
pub struct Dataset {
    pub inner: Arc<taxel::Dataset>,
}

/// Facts about samples in memory besides their values.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct ArrayFacts {
    name: String,
    layout: String,
    /// One of each sample; none of values.
    labels: Vec<String>,
    /// Name of each value, and unit where it does not stand in the name.
    quantities: Vec<(String, Option<String>)>,
    groups: Option<Vec<String>>,
    official: Option<Vec<bool>>,
    channels: Option<Vec<String>>,
    unit: Option<String>,
    rate: Option<f64>,
    full_scale: Option<f32>,
    rest: Option<Vec<f32>>,
    source: Option<String>,
}

#[pymethods]
impl Dataset {
    /// Makes a data set of samples in memory, which are copied once; `values` `[n, quantities]` are their targets in place of
    /// the labels.
    #[staticmethod]
    #[pyo3(signature = (x, facts, values=None))]
    fn of_arrays(
        py: Python<'_>,
        x: PyReadonlyArrayDyn<'_, f32>,
        facts: ArrayFacts,
        values: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<Self> {
        let x = x.as_array();
        let values: Option<Vec<f32>> = values.map(|values| values.as_array().iter().copied().collect());
        short(py, || {
            let layout: Layout = facts.layout.parse().map_err(refused)?;
            let samples = x.shape().first().copied().unwrap_or(0);
            // What becomes values begins as one class.
            let labels = if values.is_some() { vec!["0".to_string(); samples] } else { facts.labels };
            let mut dataset =
                taxel::Dataset::new(&facts.name, layout, x.to_owned(), &labels).map_err(raised)?;
            if let Some(values) = values {
                let names: Vec<&String> = facts.quantities.iter().map(|(name, _)| name).collect();
                // A name that stands without a unit may end in it.
                let mut quantities = Quantity::named(&names);
                for (quantity, (name, unit)) in quantities.iter_mut().zip(facts.quantities) {
                    if unit.is_some() {
                        *quantity = Quantity { name, unit };
                    }
                }
                dataset = dataset.with_values(quantities, values).map_err(raised)?;
            }
            if let Some(groups) = &facts.groups {
                dataset = dataset.with_groups(groups).map_err(raised)?;
            }
            if let Some(official) = facts.official {
                dataset = dataset.with_official(official).map_err(raised)?;
            }
            if let Some(channels) = &facts.channels {
                dataset = dataset.with_channel_names(channels).map_err(raised)?;
            }
            if let Some(unit) = &facts.unit {
                dataset = dataset.with_unit(unit);
            }
            if let Some(rate) = facts.rate {
                dataset = dataset.with_rate(rate).map_err(raised)?;
            }
            if let Some(full_scale) = facts.full_scale {
                dataset = dataset.with_full_scale(full_scale).map_err(raised)?;
            }
            if let Some(rest) = facts.rest {
                dataset = dataset.with_rest(rest);
            }
            if let Some(source) = facts.source {
                dataset.source = source.parse::<Source>().map_err(raised)?;
            }
            Ok(Dataset { inner: Arc::new(dataset) })
        })
    }

    /// Reads the samples that the `[data]` table of a config names.
    #[staticmethod]
    fn read(py: Python<'_>, config: &str) -> PyResult<Self> {
        short(py, || {
            let loaded: Experiment = experiment(config, "taxel.read")?;
            Ok(Dataset { inner: Arc::new(loaded.dataset().map_err(raised)?) })
        })
    }

    /// Simulates samples of a scene, and returns its true physical values by name.
    #[staticmethod]
    fn simulate<'py>(
        py: Python<'py>,
        scene: &str,
        samples: usize,
        seed: u64,
        without: Vec<String>,
        settings: &str,
    ) -> PyResult<(Self, Bound<'py, PyDict>)> {
        let (dataset, truth) = short(py, || {
            let settings: serde_json::Value = serde_json::from_str(settings).map_err(refused)?;
            let settings = scenes::Settings::read(scene, settings).map_err(refused)?;
            let made = settings.simulate(samples, seed, &without).map_err(refused)?;
            let truth = made.truth.clone();
            Ok((simulated(scene, &without, made), truth))
        })?;
        let values = PyDict::new(py);
        for (name, truth) in truth {
            values.set_item(name, truth.into_pyarray(py))?;
        }
        Ok((Dataset { inner: Arc::new(dataset) }, values))
    }

    /// Writes an `.npz` with its names beside it.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        short(py, || {
            self.inner.save(&path).map_err(|e| {
                raised(std::io::Error::new(e.kind(), format!("{}: cannot be written: {e}", path.display())))
            })
        })
    }

    /// Returns the same samples with a weight for each in training; those of weight 0 are left out.
    fn with_weights(&self, py: Python<'_>, weights: Vec<f32>) -> PyResult<Self> {
        short(py, || {
            let dataset = taxel::Dataset::clone(&self.inner).with_weights(&weights).map_err(raised)?;
            Ok(Dataset { inner: Arc::new(dataset) })
        })
    }

    /// Returns the samples of these rows, in this order.
    fn select(&self, py: Python<'_>, rows: Vec<usize>) -> PyResult<Self> {
        let n = self.inner.len();
        if let Some(row) = rows.iter().find(|row| **row >= n) {
            return Err(pyo3::exceptions::PyIndexError::new_err(format!("there is no sample {row} of {n}")));
        }
        short(py, || Ok(Dataset { inner: Arc::new(self.inner.select(&rows)) }))
    }

    /// Returns the samples, copied.
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyArrayDyn<f32>> {
        self.inner.x.clone().into_pyarray(py)
    }

    /// Returns the number of each sample's class; of values the part of the range that it lies in.
    fn y<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.inner.strata().into_owned().into_pyarray(py)
    }

    /// Returns the values of each sample `[n, quantities]`, if the targets are values.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let Some(values) = self.inner.targets.values() else { return Ok(None) };
        let shape = [self.inner.len(), values.quantities().len()];
        Ok(Some(values.values().to_vec().into_pyarray(py).reshape(shape)?))
    }

    /// Returns the number of each sample's group, if there are groups.
    fn groups<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<u32>>> {
        self.inner.groups.clone().map(|groups| groups.into_pyarray(py))
    }

    /// Returns the facts about the samples, as JSON.
    fn facts(&self) -> String {
        let dataset = &*self.inner;
        let classes = if dataset.targets.values().is_some() { vec![] } else { dataset.output_names() };
        serde_json::json!({
            "name": dataset.name, "source": dataset.source, "digest": dataset.digest, "classes": classes,
            "quantities": dataset.task().quantities(), "reading": dataset.spec, "official": dataset.official.is_some(),
        })
        .to_string()
    }

    /// Returns the origin of each sample.
    fn origins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, &self.inner.origins)
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }
}
