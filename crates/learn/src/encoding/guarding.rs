//! The guard on the samples of a data set.

use std::sync::Arc;

use ndarray::{ArrayD, ArrayRef, Axis, IxDyn};
use taxel_data::Dataset;
use taxel_guard::{Guard, KnownRange, ReplacedElement, Watch};

use crate::error::Result;
use crate::problem::Problem;

/// Fits a guard on some samples of a data set, of which it learns full scale and rest where they are known.
///
/// # Errors
/// Rest values in another number than there are channels.
///
/// # Panics
/// For a row that the data set has not.
pub fn fitted_guard(dataset: &Dataset, train: &[usize]) -> Result<Guard> {
    let spec = &dataset.spec;
    let facts = KnownRange { full_scale: spec.full_scale, rest: spec.rest.as_deref() };
    let x = dataset.x.select(Axis(0), train);
    let refuse = |e: taxel_guard::Error| Problem::new("encoding.guard", "true", e.to_string()).into();
    Guard::fit(x.view(), spec.layout, &facts).map_err(refuse)
}

/// Returns raw samples `[n, ..]` of the guard's shape as it hands them on, and the elements that it replaced in each.
pub fn mended(guard: &Arc<Guard>, x: &ArrayRef<f32, IxDyn>) -> (ArrayD<f32>, Vec<Vec<ReplacedElement>>) {
    let mut watch = Watch::new(guard.clone());
    let mut x = x.as_standard_layout().into_owned();
    let each = guard.shape().iter().product::<usize>().max(1);
    let mut found = vec![];
    if let Some(values) = x.as_slice_mut() {
        found = values.chunks_exact_mut(each).map(|sample| watch.mend(sample).to_vec()).collect();
    }
    (x, found)
}
