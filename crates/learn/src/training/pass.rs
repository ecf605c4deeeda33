//! One pass over the training samples.

use taxel_data::{Augment, Key};

/// Changes to the samples of a training pass.
#[derive(Clone, Copy)]
pub(crate) struct TrainingPass<'p> {
    /// Names the pass to the generator of faults.
    pub occasion: &'p str,
    /// Random changes of samples.
    pub augment: Option<(&'p Augment, Key)>,
}
