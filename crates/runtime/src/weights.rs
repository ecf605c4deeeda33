//! Tensors of a graph in the order in which the kernels read them, and batch norms as scale and shift.

use taxel_graph::{Node, Weights};
use taxel_kernels::layout;

/// Returns the values of parameter `which` of `node`; the weights have been checked against the graph.
pub(crate) fn values<'a>(weights: &'a Weights, node: &Node, which: usize) -> &'a [f32] {
    #[expect(clippy::expect_used, reason = "the weights are checked before they are read")]
    let tensor = weights.get(&node.params[which].name).expect("checked weights have every tensor");
    &tensor.data
}

/// Returns a convolution's weights: group × kernel × channels in × channels out, depthwise kernel × channels.
pub(crate) fn conv(weights: &Weights, node: &Node, groups: usize) -> Vec<f32> {
    let shape = &node.params[0].shape;
    let outer = values(weights, node, 0);
    let mut inner = vec![0.0; outer.len()];
    layout::weights_in(shape[0], shape[1], shape[2..].iter().product(), groups, outer, &mut inner);
    inner
}

/// Returns the bias of `node`, zeros where it has none.
pub(crate) fn bias(weights: &Weights, node: &Node, has: bool, outputs: usize) -> Vec<f32> {
    if has { values(weights, node, 1).to_vec() } else { vec![0.0; outputs] }
}

/// Returns a linear layer's weights, inputs × outputs. Inputs are `positions` × channels, where PyTorch has them
/// channels first.
pub(crate) fn linear(weights: &Weights, node: &Node, positions: usize) -> Vec<f32> {
    let (outputs, inputs) = (node.params[0].shape[0], node.params[0].shape[1]);
    let channels = inputs / positions;
    let outer = values(weights, node, 0);
    let mut inner = vec![0.0; outer.len()];
    for (output, row) in outer.chunks_exact(inputs).enumerate() {
        for (channel, row) in row.chunks_exact(positions).enumerate() {
            for (position, weight) in row.iter().enumerate() {
                inner[(position * channels + channel) * outputs + output] = *weight;
            }
        }
    }
    inner
}

/// Returns a batch norm by its running statistics: scale and shift per channel, in double precision.
pub(crate) fn norm(weights: &Weights, node: &Node, eps: f32) -> Vec<(f64, f64)> {
    let [weight, bias, mean, variance] = [0, 1, 2, 3].map(|which| values(weights, node, which));
    let one = |c: usize| {
        let scale = f64::from(weight[c]) / (f64::from(variance[c]) + f64::from(eps)).sqrt();
        (scale, f64::from(bias[c]) - f64::from(mean[c]) * scale)
    };
    (0..weight.len()).map(one).collect()
}

/// Scales every output's weights, where outputs are the last axis of each group's, and moves its bias.
pub(crate) fn fold(weight: &mut [f32], bias: &mut [f32], groups: usize, norm: &[(f64, f64)]) {
    let outputs = bias.len() / groups;
    let of_group = weight.len() / groups;
    for (group, weight) in weight.chunks_exact_mut(of_group.max(1)).enumerate() {
        for row in weight.chunks_exact_mut(outputs) {
            for (w, (scale, _)) in row.iter_mut().zip(&norm[group * outputs..]) {
                *w = (f64::from(*w) * scale) as f32;
            }
        }
    }
    for (bias, (scale, shift)) in bias.iter_mut().zip(norm) {
        *bias = (f64::from(*bias) * scale + shift) as f32;
    }
}
