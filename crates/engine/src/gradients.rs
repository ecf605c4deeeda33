//! Memory of a backward pass.

use taxel_kernels::Buffer;

use crate::compiled::Compiled;
use crate::norm::NormGradient;
use crate::part_gradients::PartGradients;
use crate::workspace::Workspace;

/// All gradients of a pass; those of the parameters stay until the next one.
pub(crate) struct Gradients {
    /// Those of the parameters that learn.
    pub dparams: Buffer,
    /// One for every part of the workspace.
    pub parts: Vec<PartGradients>,
    /// The sums that the parameters' gradients are made of, all parts together.
    pub totals: Buffer,
    pub norms: Vec<NormGradient>,
    /// The forms of the parameters that layers prepare for their backward pass, by node.
    pub prepared: Vec<Vec<f32>>,
    /// Rows of the nodes that take the whole batch, by node.
    pub rows: Vec<GradientRows>,
    /// Gradient of the loss in every output, [batch, output].
    pub outputs: Vec<Vec<f32>>,
}

/// Gradients of a node's output and input, a row for every sample.
#[derive(Default)]
pub(crate) struct GradientRows {
    pub dy: Vec<f32>,
    pub dx: Vec<f32>,
}

impl Gradients {
    /// Makes memory for passes over `workspace`.
    pub fn new(compiled: &Compiled, workspace: &Workspace) -> Self {
        let rows = |len: usize| vec![0.0; compiled.batch * len];
        Gradients {
            dparams: Buffer::zeros(compiled.sizes.learned),
            parts: workspace.parts.iter().map(|_| PartGradients::new(compiled)).collect(),
            totals: Buffer::zeros(compiled.sizes.partials),
            norms: compiled.norms.iter().map(|norm| NormGradient::new(norm.channels)).collect(),
            prepared: vec![vec![]; compiled.nodes.len()],
            rows: (workspace.batches.iter())
                .map(|batch| match batch {
                    Some(batch) => GradientRows { dy: rows(batch.outputs), dx: rows(batch.inputs) },
                    None => GradientRows::default(),
                })
                .collect(),
            outputs: compiled.heads.iter().map(|head| rows(head.len())).collect(),
        }
    }
}
