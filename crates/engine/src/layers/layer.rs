//! The inputs and the duties of an operation on one sample.

use taxel_graph::DropoutMask;
use taxel_kernels::{AffineView, Buffer};

use crate::lifetimes::GradientPlace;
use crate::norm::Norm;
use crate::plan::{NodePlan, StoredView};

/// The inputs of one node for one sample.
#[derive(Clone, Copy)]
pub(crate) struct Inputs<'a> {
    pub plan: &'a NodePlan,
    /// Stored values of all nodes before it.
    pub values: &'a [Buffer],
    pub norms: &'a [Norm],
    /// Number of the sample in its part.
    pub sample: usize,
    /// Number of the sample in the batch.
    pub number: usize,
    /// The dropout mask of this node; none in evaluation.
    pub mask: Option<DropoutMask>,
    /// Values per sample of every node.
    pub lens: &'a [usize],
    /// The parameters as [`Layer::pack`] arranged them.
    pub packed: &'a [f32],
}

impl<'a> Inputs<'a> {
    /// Returns the stored values of input `which`, and how this node sees them.
    pub fn get(&self, which: usize) -> (&'a [f32], AffineView<'a>) {
        let seen = &self.plan.inputs[which];
        let len = self.lens[seen.stored];
        (&self.values[seen.stored][self.sample * len..][..len], view(seen, self.norms))
    }

    pub fn count(&self) -> usize {
        self.plan.inputs.len()
    }
}

/// Returns the view that `seen` stands for.
pub(crate) fn view<'a>(seen: &StoredView, norms: &'a [Norm]) -> AffineView<'a> {
    let affine = seen.norm.map(|n| (norms[n].scale.as_slice(), norms[n].shift.as_slice()));
    AffineView { affine, rectifier: seen.rectifier }
}

/// Where the gradients of one node's inputs go, for one sample.
pub(crate) struct Outputs<'a> {
    pub plan: &'a NodePlan,
    /// Memory of the slots, and where each lies.
    pub slots: &'a mut [Buffer],
    pub places: &'a [GradientPlace],
    pub sample: usize,
    pub lens: &'a [usize],
}

impl Outputs<'_> {
    /// Returns the gradient of input `which`, and whether to add to it; `None` where nobody needs it.
    pub fn get(&mut self, which: usize) -> Option<(&mut [f32], bool)> {
        let (slot, add) = self.plan.slots[which]?;
        let len = self.lens[self.plan.inputs[which].stored];
        let GradientPlace { buffer, stride } = self.places[slot];
        Some((&mut self.slots[buffer][self.sample * stride..][..len], add))
    }
}

/// Memory of one worker that no sample keeps.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// An input with its halo, or seen through its view.
    pub x: Buffer,
    /// Memory in which a convolution works, or a gradient with its halo.
    pub work: Buffer,
}

/// Forward and backward pass of a node on one sample.
pub(crate) trait Layer: Send + Sync {
    /// Computes `y` from the inputs; `saved` is kept for the backward pass.
    fn forward(
        &self,
        inputs: Inputs,
        params: &[f32],
        y: &mut [f32],
        saved: &mut [f32],
        scratch: &mut Scratch,
    );

    /// Takes the gradient `dy` of the output: adds to `partials`, which are empty where nothing is learned, and writes
    /// or adds to the inputs' gradients.
    fn backward(
        &self,
        pass: Backward,
        dy: &[f32],
        partials: &mut [f32],
        outputs: Outputs,
        scratch: &mut Scratch,
    );

    /// Returns the number of values that a sample keeps between the passes.
    fn saved_len(&self) -> usize {
        0
    }

    /// Returns the number of values of [`Scratch::x`] that it needs.
    fn scratch_len(&self) -> usize;

    /// Returns the number of values of [`Scratch::work`] that the forward pass needs, and the backward pass too where
    /// one follows.
    fn work_len(&self, _trains: bool) -> usize {
        0
    }

    /// Arranges the parameters for the forward passes of all samples.
    fn pack(&self, _params: &[f32], _packed: &mut Vec<f32>) {}

    /// Keeps beside the packed parameters the values that both passes need and nobody learns.
    fn keep(&self, _buffers: &[f32], _packed: &mut Vec<f32>) {}

    /// Arranges the parameters for the input gradients of all samples; not called where no input has one.
    fn prepare(&self, _params: &[f32], _prepared: &mut Vec<f32>) {}

    /// Returns the number of values that a layer with `params` parameters adds up over samples.
    fn partials_len(&self, params: usize) -> usize {
        params
    }

    /// Computes the parameters' gradient from those of all samples.
    fn finish(&self, totals: &[f32], dparams: &mut [f32]) {
        dparams.copy_from_slice(totals);
    }
}

/// The values that a backward pass reads.
#[derive(Clone, Copy)]
pub(crate) struct Backward<'a> {
    pub inputs: Inputs<'a>,
    pub params: &'a [f32],
    pub prepared: &'a [f32],
    /// The output.
    pub y: &'a [f32],
    pub saved: &'a [f32],
}
