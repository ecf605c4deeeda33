//! The native half of the Python package `taxel`: arrays in, arrays out, everything else as JSON text.
//!
//! Nothing is learned here: each function hands its arguments to the library of the same name. What Python users see,
//! with its docstrings, is in `python/taxel`.

// What Python sees of these is in its stubs.
#![allow(missing_docs)]

mod config;
mod dataset;
mod graph;
mod model;
mod progress;
mod raise;
mod report;
mod sensing;
mod stream;
mod train;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _taxel {
    #[pymodule_export]
    use crate::dataset::Dataset;
    #[pymodule_export]
    use crate::graph::{Builder, Flow, Graph, zoo};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::report::report;
    #[pymodule_export]
    use crate::sensing::{break_samples, explain, faults, gadf, scenes};
    #[pymodule_export]
    use crate::stream::Stream;
    #[pymodule_export]
    use crate::train::{cross_validate, fit, run, table};

    #[pymodule_export]
    use crate::work::fail;

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
