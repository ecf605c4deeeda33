//! A trained network or baseline that predicts.

use std::ffi::CString;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::ndarray::ArrayView1;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn,
};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use taxel::judge::speed;
use taxel::{Card, Predictions, Predictor};

use crate::dataset::Dataset;
use crate::raise::{raised, refused};
use crate::work::short;

/// A trained network or baseline.
#[pyclass(frozen, module = "taxel._taxel")]
pub struct Model {
    pub inner: taxel::Model,
    /// The last predictor and its threads.
    ready: Mutex<Option<(usize, Arc<Predictor>)>>,
}

impl Model {
    pub fn new(inner: taxel::Model) -> Self {
        Model { inner, ready: Mutex::default() }
    }

    /// Returns a predictor on so many threads; made once.
    fn predictor(&self, threads: usize) -> PyResult<Arc<Predictor>> {
        let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, predictor)) = ready.as_ref().filter(|(made_for, _)| *made_for == threads) {
            return Ok(predictor.clone());
        }
        let predictor = self.inner.predictor(self.inner.card().batch(), threads).map_err(raised)?;
        let predictor = Arc::new(predictor);
        *ready = Some((threads, predictor.clone()));
        Ok(predictor)
    }

    /// Predicts samples; warns of values far outside those of the training.
    fn asked(
        &self,
        py: Python<'_>,
        x: &PyReadonlyArrayDyn<'_, f32>,
        threads: Option<usize>,
    ) -> PyResult<Predictions> {
        let x = x.as_array();
        let (said, far) = short(py, || {
            let predictor = self.predictor(taxel::learn::threads(threads))?;
            let said = predictor.predict(&x).map_err(raised)?;
            Ok((said, predictor.range_warning(&x).map_err(raised)?))
        })?;
        if let Some(words) = far.and_then(|words| CString::new(words).ok()) {
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &words, 2)?;
        }
        Ok(said)
    }
}

/// Refuses a share of samples for which a model has no intervals.
pub fn refuse_share(card: &Card, share: f64) -> PyResult<()> {
    let name = &card.name;
    if card.task.quantities().is_empty() {
        return Err(refused(format!("{name} answers classes, which have no intervals: use predict_set")));
    }
    let Some(intervals) = &card.intervals else {
        return Err(refused(format!(
            "{name} has no intervals, which are fitted to 30 held-out predictions or more: fit it from a run folder (taxel \
             fit RUN); ridge and MiniRocket have them wherever they are fitted"
        )));
    };
    if intervals.at(share).is_none() {
        let shares: Vec<String> = intervals.at.iter().map(|at| at.share.to_string()).collect();
        return Err(refused(format!("{name} has no intervals at {share}, but at {}", shares.join(", "))));
    }
    Ok(())
}

/// Numbers of the likeliest classes `[n · attributes]`, and probabilities `[n, outputs]`.
type PredictedArrays<'py> = (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray2<f32>>);

#[pymethods]
impl Model {
    /// Reads a model file.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        short(py, || taxel::Model::open(&path).map(Model::new).map_err(raised))
    }

    /// Reads the bytes of a model file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        short(py, || taxel::Model::from_bytes(bytes, "model").map(Model::new).map_err(raised))
    }

    /// Returns the bytes of the model file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = short(py, || self.inner.to_bytes().map_err(raised))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes the model file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        short(py, || self.inner.save(&path).map_err(raised))
    }

    /// Writes the model as ONNX.
    fn export(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        short(py, || taxel::export(&self.inner, &path).map(|_| ()).map_err(raised))
    }

    /// Predicts samples, which are read without a copy.
    #[pyo3(signature = (x, threads=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f32>,
        threads: Option<usize>,
    ) -> PyResult<PredictedArrays<'py>> {
        let said = self.asked(py, &x, threads)?;
        let outputs = said.width();
        let Predictions { labels, outputs: probabilities, .. } = said;
        let n = probabilities.len() / outputs.max(1);
        Ok((labels.into_pyarray(py), probabilities.into_pyarray(py).reshape([n, outputs])?))
    }

    /// Returns the intervals `[n, quantities, 2]` that hold the true values in `share` of samples.
    #[pyo3(signature = (x, share, threads=None))]
    fn intervals<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f32>,
        share: f64,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        refuse_share(self.inner.card(), share)?;
        let said = self.asked(py, &x, threads)?;
        let rows = (0..said.len()).filter_map(|i| said.intervals(i, share));
        let ends: Vec<f32> = rows.flatten().flatten().collect();
        ends.into_pyarray(py).reshape([said.len(), said.width(), 2])
    }

    /// Returns how familiar each sample is to the model, 0.01..1; none of a model that does not know.
    #[pyo3(signature = (x, threads=None))]
    fn familiarity<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f32>,
        threads: Option<usize>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f32>>>> {
        let x = x.as_array();
        let said = short(py, || {
            let predictor = self.predictor(taxel::learn::threads(threads))?;
            predictor.predict(&x).map_err(raised)
        })?;
        Ok(said.familiarity.map(|familiarity| familiarity.into_pyarray(py)))
    }

    /// Returns the numbers of the outputs in the set of each sample with these probabilities.
    fn sets(&self, probabilities: PyReadonlyArray2<'_, f32>, share: f64) -> PyResult<Vec<Vec<usize>>> {
        let card = self.inner.card();
        let sets = card.certainty.as_ref().and_then(|certainty| certainty.sets_at(share)).ok_or_else(|| {
            refused(format!(
                "{} has no sets at {share}: they are made for 0.8, 0.9, 0.95 and 0.99 when a model is calibrated",
                card.name
            ))
        })?;
        let levels = card.levels();
        let of_row = |row: ArrayView1<f32>| {
            let mut first = 0;
            let of_attribute = |(set, size): (Vec<usize>, &usize)| {
                let outputs: Vec<usize> = set.into_iter().map(|class| first + class).collect();
                first += size;
                outputs
            };
            sets.classes(&row.to_vec(), &levels)
                .into_iter()
                .zip(levels.sizes())
                .flat_map(of_attribute)
                .collect()
        };
        Ok(probabilities.as_array().outer_iter().map(of_row).collect())
    }

    /// Returns the same model, as sure of its answers as it is right on labelled samples that it has not learned from.
    fn calibrated(&self, py: Python<'_>, dataset: &Dataset) -> PyResult<Self> {
        let dataset = dataset.inner.clone();
        short(py, || self.inner.calibrated(&dataset.x, &dataset).map(Model::new).map_err(raised))
    }

    /// Measures the time of one prediction, as JSON.
    fn latency(&self, py: Python<'_>, x: PyReadonlyArrayDyn<'_, f32>, budget: f64) -> PyResult<String> {
        let x = x.as_array();
        short(py, || {
            let measured = speed(&self.inner, &x, budget).map_err(raised)?;
            serde_json::to_string(&measured).map_err(refused)
        })
    }

    /// Returns the card as JSON.
    fn card(&self) -> PyResult<String> {
        serde_json::to_string(self.inner.card()).map_err(refused)
    }

    /// Returns the card as people read it.
    fn __str__(&self) -> String {
        self.inner.card().to_string()
    }
}
