//! Memory of one thread that predicts sample by sample.

use taxel_guard::{ReplacedElement, Watch};
use taxel_runtime as runtime;

use crate::certainty::Summary;
use crate::encoding::Compiled;

/// Memory of one thread that predicts with a [`Predictor`](super::Predictor), which makes it: all inputs and values,
/// allocated once.
pub struct Workspace {
    pub(super) guard: Option<Mended>,
    pub(super) encoders: Vec<Compiled>,
    /// Of the last reading.
    pub(super) inputs: Vec<Vec<f32>>,
    pub(super) memory: ModelMemory,
    /// Of the last prediction.
    pub(super) logits: Vec<f32>,
    /// Of the last prediction.
    pub(super) probabilities: Vec<f32>,
    /// Of the gate.
    pub(super) scratch: Vec<f64>,
    /// Of the readings of the last sample, and their range; none without a gate of them.
    pub(super) summary: Option<(Summary, f32)>,
}

/// A guard, and the last reading as it hands it on.
pub(super) struct Mended {
    watch: Watch,
    reading: Vec<f32>,
}

impl Mended {
    /// Replaces the broken channels of a sample of the guard's shape.
    pub fn mend(&mut self, reading: &[f32]) -> &[f32] {
        self.reading.copy_from_slice(reading);
        self.watch.mend(&mut self.reading);
        &self.reading
    }
}

/// Memory of a kind of model.
pub(crate) enum ModelMemory {
    Network(Box<runtime::Workspace>),
    /// One of each attribute.
    Baseline(Vec<taxel_baselines::Workspace>),
    /// Of each member, and the values that it computes for one sample.
    Average(Vec<(ModelMemory, Vec<f32>)>),
}

impl Workspace {
    pub(super) fn new(
        watch: Option<Watch>,
        encoders: Vec<Compiled>,
        memory: ModelMemory,
        [width, outputs]: [usize; 2],
        summary: Option<(Summary, f32)>,
    ) -> Self {
        let input = |encoder: &Compiled| vec![0.0; encoder.shape().iter().product()];
        let inputs = encoders.iter().map(input).collect();
        let guard = watch.map(|watch| {
            let reading = vec![0.0; watch.guard().shape().iter().product()];
            Mended { reading, watch }
        });
        let (logits, probabilities) = (vec![0.0; width], vec![0.0; outputs]);
        Workspace {
            guard,
            encoders,
            inputs,
            memory,
            logits,
            probabilities,
            scratch: Vec::with_capacity(2 * outputs),
            summary,
        }
    }

    /// Returns the findings of the guard in the last sample; nothing without a guard.
    pub fn found(&self) -> &[ReplacedElement] {
        self.guard.as_ref().map_or(&[], |guard| guard.watch.found())
    }
}
