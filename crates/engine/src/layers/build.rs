//! Which layer a node of the graph becomes.

use taxel_graph::{Activation, Graph, Node, Op, Window};
use taxel_kernels::{self as kernels, Window3, adaptive_pool::AdaptivePool, axes3};

use super::batch_layer::{Batch, BatchLayer};
use super::layer::Layer;
use super::{
    activation, adaptive_pool, channels, conv, dropout, layer_norm, linear, pool, recurrent, scale, simple,
    streams,
};

/// Makes the layer of `node` over the whole of a batch of at most `batch`, with memory for the backward pass where it
/// `trains`, with products of bf16 where it is `half`; `None` for what runs sample by sample.
pub(crate) fn build_batch(
    graph: &Graph,
    node: &Node,
    batch: usize,
    trains: bool,
    half: bool,
) -> Option<Batch> {
    let input = |which: usize| &graph.nodes()[node.inputs[which]].shape;
    let layer: Box<dyn BatchLayer> = match node.op {
        Op::Linear { bias, .. } => {
            let inputs = input(0).iter().product();
            Box::new(linear::Linear::new(inputs, node.shape[0], bias, batch, half))
        }
        Op::Lstm { hidden, steps } => {
            let sizes = taxel_kernels::lstm::Lstm { channels: input(0)[0], steps, hidden };
            Box::new(recurrent::Recurrent::new(sizes, batch, trains, half))
        }
        Op::Gru { hidden, steps } => {
            let sizes = taxel_kernels::gru::Gru { channels: input(0)[0], steps, hidden };
            Box::new(recurrent::Recurrent::new(sizes, batch, trains, half))
        }
        _ => return None,
    };
    let (inputs, outputs) = (input(0).iter().product(), node.shape[0]);
    Some(Batch { layer, inputs, outputs, x: vec![0.0; batch * inputs], y: vec![0.0; batch * outputs] })
}

/// Makes the layer of `node`, with products of bf16 where it is `half`; `None` for inputs and for what takes the whole
/// batch.
pub(crate) fn build(graph: &Graph, node: &Node, half: bool) -> Option<Box<dyn Layer>> {
    let input = |which: usize| &graph.nodes()[node.inputs[which]];
    let (channels, len) = (node.shape[0], node.shape.iter().product());
    Some(match &node.op {
        Op::Input | Op::Linear { .. } | Op::Lstm { .. } | Op::Gru { .. } => return None,
        Op::Conv { filters, window, dilation, groups, bias } => {
            let plan = conv_plan(&input(0).shape, *filters, window, dilation, *groups, half);
            Box::new(conv::Conv::new(plan, *bias))
        }
        // Stored only where the engine cannot leave them to their readers.
        Op::BatchNorm { .. } | Op::Relu | Op::Activation(Activation::Relu6) => {
            Box::new(simple::Copy { channels })
        }
        &Op::LayerNorm { eps } => Box::new(layer_norm::LayerNorm { features: channels, eps }),
        &Op::Activation(function) => Box::new(activation::Activation { function, channels, len }),
        &Op::Dropout { probability } => {
            Box::new(dropout::Dropout { probability, channels, positions: len / channels })
        }
        Op::MaxPool(window) => {
            let window = window3(window, &[], &input(0).shape);
            Box::new(pool::MaxPool(taxel_kernels::pool::MaxPool::new(&window, node.shape[0])))
        }
        Op::AveragePool { window, counted } => {
            let (window, counted) = (window3(window, &[], &input(0).shape), axes3(counted, (0, 0)));
            Box::new(pool::AveragePool { window, counted, channels: node.shape[0] })
        }
        Op::GlobalAveragePool => {
            Box::new(pool::GlobalAveragePool { channels, len: input(0).shape.iter().product() })
        }
        &Op::GlobalStandardDeviation { eps } => {
            let len = input(0).shape.iter().product();
            Box::new(pool::GlobalStandardDeviation { channels: node.shape[0], eps, len })
        }
        Op::Flatten => {
            let shape = &input(0).shape;
            Box::new(simple::Flatten { channels: shape[0], positions: shape[1..].iter().product() })
        }
        Op::Add => Box::new(simple::Add { channels: node.shape[0], len: node.shape.iter().product() }),
        Op::Concat => {
            let widths = node.inputs.iter().map(|&i| graph.nodes()[i].shape[0]).collect();
            Box::new(simple::Concat::new(widths, node.shape[1..].iter().product()))
        }
        Op::AdaptiveAveragePool { output } => {
            let (input, output) = (axes3(&input(0).shape[1..], 1), axes3(output, 1));
            let pool = AdaptivePool { input, output, channels };
            Box::new(adaptive_pool::AdaptiveAveragePool { pool })
        }
        Op::Scale => Box::new(scale::ScaleLayer { channels, len }),
        Op::Standardize { .. } => Box::new(streams::Standardize { channels, len }),
        Op::SwitchScale => {
            let stream = &input(1).shape;
            Box::new(streams::SwitchScale { channels, len, stream: [stream[0], stream.iter().product()] })
        }
        &Op::ChannelShuffle { groups } => Box::new(channels::ChannelShuffle { channels, groups, len }),
        &Op::Slice { start, len: width } => {
            let channels = input(0).shape[0];
            Box::new(channels::Slice { channels, start, width, positions: len / width })
        }
    })
}

/// Plans the convolution of inputs of `shape`, channels first.
fn conv_plan(
    shape: &[usize],
    filters: usize,
    window: &Window,
    dilation: &[usize],
    groups: usize,
    half: bool,
) -> kernels::conv::Conv {
    let (window, dilation) = (window3(window, dilation, shape), axes3(dilation, 1));
    let make = if half { kernels::conv::Conv::half } else { kernels::conv::Conv::dilated };
    make(window, dilation, shape[0], filters, groups)
}

/// Makes a window over (depth, rows, columns), from a shape with channels first and 1 to 3 spatial axes; its outputs
/// are those of a kernel whose values meet inputs `dilation` apart (empty: neighbours).
fn window3(window: &Window, dilation: &[usize], input: &[usize]) -> Window3 {
    let before: Vec<usize> = window.padding.iter().map(|p| p.0).collect();
    let output = window.dilated(dilation).positions(&input[1..]);
    Window3::over(&input[1..], &output, &window.kernel, &window.stride, &before)
}
