//! Training: one network on everything, or several on folds, into a run folder.

use std::path::{Path, PathBuf};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use taxel::experiment::Runner;
use taxel::{Experiment, Overrides, Registry, ResultsTable, RunFolder, RunOptions};

use crate::config::experiment_on;
use crate::dataset::Dataset;
use crate::model::Model;
use crate::progress::progress;
use crate::raise::{raised, refused};
use crate::work::{long, short};

/// Trains the network or baseline `name` of a config on all samples.
#[pyfunction]
#[pyo3(signature = (config, place, dataset, name, threads=None, verbose=None))]
pub fn fit(
    py: Python<'_>,
    config: &str,
    place: &str,
    dataset: &Dataset,
    name: &str,
    threads: Option<usize>,
    verbose: Option<bool>,
) -> PyResult<Model> {
    let dataset = dataset.inner.clone();
    long(py, |cancel| {
        let experiment = experiment_on(config, place, &dataset)?;
        let registry = Registry::built_in();
        let runner = Runner { experiment: &experiment, registry: &registry, dataset: &dataset };
        let options = RunOptions { threads, ..RunOptions::default() };
        let progress = progress(verbose);
        let model = runner.fit(name, &options, None, &*progress, cancel).map_err(raised)?;
        model.map(Model::new).ok_or_else(|| PyKeyboardInterrupt::new_err("the training was stopped"))
    })
}

/// Trains and tests everything of a config on folds.
#[pyfunction]
#[pyo3(signature = (config, dataset, out, resume=false, threads=None, verbose=None))]
pub fn cross_validate(
    py: Python<'_>,
    config: &str,
    dataset: &Dataset,
    out: PathBuf,
    resume: bool,
    threads: Option<usize>,
    verbose: Option<bool>,
) -> PyResult<()> {
    let dataset = dataset.inner.clone();
    long(py, |cancel| {
        let experiment = experiment_on(config, "taxel.cross_validate", &dataset)?;
        let registry = Registry::built_in();
        let runner = Runner { experiment: &experiment, registry: &registry, dataset: &dataset };
        let options = RunOptions { resume, threads, ..RunOptions::default() };
        let progress = progress(verbose);
        runner.run(Some(&out), &options, &*progress, cancel).map(|_| ()).map_err(raised)
    })
}

/// Runs a config file; returns the run folder.
#[pyfunction]
#[pyo3(signature = (path, set, quick=false, data=None, seed=None, out=None, resume=false, threads=None, verbose=None))]
#[expect(clippy::too_many_arguments, reason = "as many as run passes on")]
pub fn run(
    py: Python<'_>,
    path: PathBuf,
    set: Vec<String>,
    quick: bool,
    data: Option<PathBuf>,
    seed: Option<u64>,
    out: Option<PathBuf>,
    resume: bool,
    threads: Option<usize>,
    verbose: Option<bool>,
) -> PyResult<PathBuf> {
    long(py, |cancel| {
        let registry = Registry::built_in();
        let overrides = Overrides { quick, set, data, seed, place: Some("set".into()) };
        let experiment = Experiment::load(&path, &overrides, &registry).map_err(raised)?;
        let options = RunOptions { resume, threads, ..RunOptions::default() };
        let progress = progress(verbose);
        let folder =
            taxel::experiment::run(&experiment, &registry, out.as_deref(), &options, &*progress, cancel);
        folder.map(|folder| folder.path().to_path_buf()).map_err(raised)
    })
}

/// Returns the table of a run folder: Markdown, JSON, and as a terminal shows it.
#[pyfunction]
pub fn table(py: Python<'_>, folder: PathBuf) -> PyResult<(String, String, String)> {
    short(py, || {
        let table = ResultsTable::of(&opened(&folder)?).map_err(raised)?;
        let json = serde_json::to_string(table.json()).map_err(refused)?;
        Ok((table.markdown(), json, table.to_string()))
    })
}

/// Opens the run folder at `path`.
pub fn opened(path: &Path) -> PyResult<RunFolder> {
    RunFolder::open(path).map_err(raised)
}
