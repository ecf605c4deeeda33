//! Gramian angular fields of samples, and faults of sensors.

use numpy::{IntoPyArray, PyArray4, PyArrayDyn, PyReadonlyArray3};
use pyo3::prelude::*;
use taxel::encodings::Method;
use taxel::faults::Fault;
use taxel::learn::encoding::GramianSettings;
use taxel::learn::sensor;
use taxel::ndarray::Axis;

use crate::dataset::Dataset;
use crate::raise::refused;
use crate::work::short;

/// Returns coloured Gramian angular fields `[n, colours, size, size]` of series `[n, channels, time]`.
#[pyfunction]
pub fn gadf<'py>(
    py: Python<'py>,
    x: PyReadonlyArray3<'py, f32>,
    settings: &str,
    summation: bool,
) -> PyResult<Bound<'py, PyArray4<f32>>> {
    let x = x.as_array();
    let images = short(py, || {
        let field: GramianSettings = crate::config::settings(settings)?;
        let method = if summation { Method::Summation } else { Method::Difference };
        field.image(method).map_err(refused)?.encode_batch(x).map_err(refused)
    })?;
    Ok(images.into_pyarray(py))
}

/// Returns a copy of the samples of a data set, each corrupted by one fault.
#[pyfunction]
pub fn break_samples<'py>(
    py: Python<'py>,
    dataset: &Dataset,
    fault: &str,
    severity: u8,
    seed: u64,
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let dataset = dataset.inner.clone();
    let corrupted = short(py, || {
        let fault: Fault = fault.parse().map_err(refused)?;
        let rows: Vec<usize> = (0..dataset.len()).collect();
        let about = sensor(&dataset, &rows).sensor;
        let mut x = dataset.x.clone();
        for (i, sample) in x.axis_iter_mut(Axis(0)).enumerate() {
            fault.apply(sample, &about, severity, seed, i).map_err(refused)?;
        }
        Ok(x)
    })?;
    Ok(corrupted.into_pyarray(py))
}

/// Returns every fault, as JSON: name, what happens, its five severities and their unit.
#[pyfunction]
pub fn faults() -> String {
    let one = |fault: &Fault| {
        serde_json::json!({
            "name": fault.name(), "happens": fault.describe(), "severities": fault.severities(),
            "unit": fault.unit(),
        })
    };
    Fault::ALL.iter().map(one).collect::<serde_json::Value>().to_string()
}

/// Returns the names of the scenes.
#[pyfunction]
pub fn scenes() -> Vec<&'static str> {
    taxel::scenes::names().to_vec()
}

/// Returns every effect of a scene, as JSON.
#[pyfunction]
pub fn explain(scene: &str) -> PyResult<String> {
    serde_json::to_string(&taxel::scenes::explain(scene).map_err(refused)?).map_err(refused)
}
