//! A model on a stream of readings.

use std::sync::{Mutex, PoisonError};

use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel::stream::{Condition, Decider, StreamOptions};

use crate::model::{Model, refuse_share};
use crate::raise::{raised, refused};
use crate::work::short;

/// A model that predicts on the readings of one sensor as they come.
#[pyclass(frozen, module = "taxel._taxel")]
pub struct Stream {
    decider: Mutex<Decider>,
}

#[pymethods]
impl Stream {
    #[new]
    #[pyo3(signature = (model, hop=None, contact=false, before=None, early=None, least=None, full_scale=None, unknown=0.0, interval=None, tare=None))]
    #[expect(clippy::too_many_arguments, reason = "as many as a stream has options")]
    fn new(
        py: Python<'_>,
        model: &Model,
        hop: Option<usize>,
        contact: bool,
        before: Option<usize>,
        early: Option<f32>,
        least: Option<usize>,
        full_scale: Option<f32>,
        unknown: f32,
        interval: Option<f64>,
        tare: Option<usize>,
    ) -> PyResult<Self> {
        interval.map_or(Ok(()), |share| refuse_share(model.inner.card(), share))?;
        let options = StreamOptions {
            hop,
            contact,
            before,
            early,
            least,
            full_scale,
            unknown,
            interval,
            tare,
            ..StreamOptions::default()
        };
        short(py, || {
            let predictor = model.inner.predictor(1, 1).map_err(raised)?;
            let decider = Decider::new(predictor, &options).map_err(raised)?;
            Ok(Stream { decider: Mutex::new(decider) })
        })
    }

    /// Takes one reading; returns the decision that it leads to, if any.
    fn push<'py>(
        &self,
        py: Python<'py>,
        reading: PyReadonlyArray1<'py, f32>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let mut decider = self.decider.lock().unwrap_or_else(PoisonError::into_inner);
        let values: Vec<f32> = reading.as_array().iter().copied().collect();
        if values.len() != decider.each() {
            let (each, given) = (decider.each(), values.len());
            return Err(refused(format!("a reading has {each} values; this one has {given}")));
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return Err(refused(format!("value {at} of the reading is {}, which is not finite", values[at])));
        }
        let decided =
            taxel::panics::caught(|| decider.push(&values)).map_err(|p| crate::raise::defect(&p))?;
        let Some(decision) = decided else { return Ok(None) };
        let said = PyDict::new(py);
        said.set_item("reading", decision.reading)?;
        said.set_item("known", decision.known)?;
        said.set_item("ticks", decision.ticks)?;
        said.set_item("familiarity", decision.familiarity)?;
        said.set_item("unknown", decision.is_unknown)?;
        match decision.probabilities() {
            Ok(values) => said.set_item("probabilities", values.to_vec().into_pyarray(py))?,
            Err(error) => said.set_item("refused", error.to_string())?,
        }
        said.set_item("intervals", decision.intervals.to_vec())?;
        let health = decision.health;
        said.set_item("dead", health.in_condition(Condition::Dead).collect::<Vec<_>>())?;
        said.set_item("stuck", health.in_condition(Condition::Stuck).collect::<Vec<_>>())?;
        said.set_item("saturated", health.saturated(decision.known).collect::<Vec<_>>())?;
        Ok(Some(said))
    }

    /// Begins another recording.
    fn begin(&self) {
        self.decider.lock().unwrap_or_else(PoisonError::into_inner).begin();
    }

    /// Begins the window anew: readings are missing.
    fn anew(&self) {
        self.decider.lock().unwrap_or_else(PoisonError::into_inner).anew();
    }

    /// Takes the level at rest anew, from the next readings; false for a model that reads what the sensor gives.
    fn tare(&self) -> bool {
        self.decider.lock().unwrap_or_else(PoisonError::into_inner).tare()
    }

    /// Returns the values of one reading, readings of a window, readings from one window to the next.
    #[getter]
    fn sizes(&self) -> (usize, usize, usize) {
        let decider = self.decider.lock().unwrap_or_else(PoisonError::into_inner);
        (decider.each(), decider.ticks(), decider.hop())
    }

    /// Counts how often contact began.
    #[getter]
    fn contacts(&self) -> u64 {
        self.decider.lock().unwrap_or_else(PoisonError::into_inner).contacts()
    }
}
