//! The report of a run folder.

use std::path::PathBuf;

use pyo3::prelude::*;
use taxel::judge::{Case, Criteria, StressOptions, choose};
use taxel::reporting;

use crate::dataset::Dataset;
use crate::progress::progress;
use crate::raise::{raised, refused};
use crate::train::opened;
use crate::work::long;

/// Judges a run and writes its page; returns its content, as JSON. Without `dataset` the samples are read or simulated again.
#[pyfunction]
#[pyo3(signature = (folder, dataset=None, stress=true, samples=1000, again=false, threads=None, verbose=None))]
#[expect(clippy::too_many_arguments, reason = "as many as report passes on")]
pub fn report(
    py: Python<'_>,
    folder: PathBuf,
    dataset: Option<&Dataset>,
    stress: bool,
    samples: usize,
    again: bool,
    threads: Option<usize>,
    verbose: Option<bool>,
) -> PyResult<String> {
    let dataset = dataset.map(|dataset| dataset.inner.clone());
    long(py, |_| {
        let case = match dataset {
            Some(dataset) => Case::new(opened(&folder)?, (*dataset).clone()).map_err(raised)?,
            None => reporting::open(&folder).map_err(raised)?,
        };
        let threads = taxel::learn::threads(threads);
        let options = StressOptions { threads, samples: samples.max(1), ..StressOptions::default() };
        let options = stress.then_some(options);
        let judge = if again { reporting::measure } else { reporting::judgement };
        let judgement = judge(&case, options, &*progress(verbose)).map_err(raised)?;
        let choice = choose(&case, &judgement, &Criteria::default()).map_err(raised)?;
        let (made, page) = reporting::write(&case, &judgement, &choice).map_err(raised)?;
        let said = serde_json::json!({
            "page": page, "chosen": choice.chosen, "words": choice.words, "networks": made.summary.json,
            "table": made.summary.grid.to_string(),
        });
        serde_json::to_string(&said).map_err(refused)
    })
}
