//! One file per operation: its forward and backward pass over a batch.
//!
//! Values lie as batch × positions × channels. A layer keeps what its backward pass needs.

mod batch_norm;
mod conv;
mod linear;
mod pool;
mod simple;

use taxel_graph::{Graph, Node, Op, Window};
use taxel_kernels::Window3;

use crate::Mode;
use crate::threads::Threads;

/// What every layer sees of the running pass.
pub(crate) struct Pass<'a> {
    /// Samples in this batch.
    pub n: usize,
    pub mode: Mode,
    pub threads: &'a Threads,
}

/// Forward and backward pass of one node. All slices hold exactly `n` samples.
pub(crate) trait Layer: Send {
    /// `y` from the inputs. `params` are the node's parameters, `buffers` its running statistics.
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], params: &[f32], buffers: &mut [f32], y: &mut [f32]);

    /// Gradient of the parameters, overwriting `dparams`; called before [`Layer::backward_input`].
    fn backward_params(
        &mut self,
        _pass: &Pass,
        _xs: &[&[f32]],
        _dy: &[f32],
        _params: &[f32],
        _dparams: &mut [f32],
    ) {
    }

    /// Gradient of input `which`, written to `dx` or added to it.
    #[allow(clippy::too_many_arguments)]
    fn backward_input(
        &mut self,
        pass: &Pass,
        which: usize,
        xs: &[&[f32]],
        y: &[f32],
        dy: &[f32],
        params: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    );

    /// Population statistics, for the one layer that has them.
    fn batch_norm(&mut self) -> Option<&mut batch_norm::BatchNorm> {
        None
    }
}

pub(crate) use conv::{read_tensor, write_tensor};

/// The layer for `node` at batches of at most `batch` samples; inputs are none.
pub(crate) fn build(graph: &Graph, node: &Node, batch: usize) -> Option<Box<dyn Layer>> {
    let input = |which: usize| &graph.nodes()[node.inputs[which]];
    Some(match &node.op {
        Op::Input => return None,
        Op::Conv { window, groups, bias } => {
            Box::new(conv::Conv::new(window3(window, &input(0).shape), input(0), node, *groups, *bias, batch))
        }
        Op::BatchNorm { eps, momentum } => Box::new(batch_norm::BatchNorm::new(
            node.shape[0],
            *eps,
            *momentum,
            node.shape[1..].iter().product(),
        )),
        Op::Relu => Box::new(simple::Relu),
        Op::MaxPool(window) => {
            Box::new(pool::MaxPool::new(window3(window, &input(0).shape), node.shape[0], batch))
        }
        Op::AveragePool { window, counted } => {
            let mut all = [(0, 0); 3];
            all[3 - counted.len()..].copy_from_slice(counted);
            Box::new(pool::AveragePool {
                window: window3(window, &input(0).shape),
                counted: all,
                channels: node.shape[0],
            })
        }
        Op::GlobalAveragePool => Box::new(pool::GlobalAveragePool { channels: node.shape[0] }),
        Op::Flatten => {
            let shape = &input(0).shape;
            Box::new(simple::Flatten { channels: shape[0], positions: shape[1..].iter().product() })
        }
        Op::Linear { bias } => {
            Box::new(linear::Linear { inputs: input(0).shape[0], outputs: node.shape[0], bias: *bias })
        }
        Op::Add => Box::new(simple::Add),
        Op::Concat => {
            let widths = node.inputs.iter().map(|&i| graph.nodes()[i].shape[0]).collect();
            Box::new(simple::Concat::new(widths))
        }
        _ => Box::new(Missing),
    })
}

/// An operation that this version of the engine lacks: NaN, which no metric survives unseen.
struct Missing;

impl Layer for Missing {
    fn forward(&mut self, _: &Pass, _: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        y.fill(f32::NAN);
    }

    fn backward_input(
        &mut self,
        _: &Pass,
        _: usize,
        _: &[&[f32]],
        _: &[f32],
        _: &[f32],
        _: &[f32],
        dx: &mut [f32],
        _: bool,
    ) {
        dx.fill(f32::NAN);
    }
}

/// A window over (depth, rows, columns), from a shape with channels first and 1 to 3 spatial axes.
fn window3(window: &Window, input: &[usize]) -> Window3 {
    let spatial = &input[1..];
    let skip = 3 - spatial.len();
    let fill = |values: &[usize], rest: usize| {
        let mut all = [rest; 3];
        all[skip..].copy_from_slice(values);
        all
    };
    let before: Vec<usize> = window.padding.iter().map(|p| p.0).collect();
    Window3 {
        input: fill(spatial, 1),
        output: fill(&window.positions(spatial), 1),
        kernel: fill(&window.kernel, 1),
        stride: fill(&window.stride, 1),
        before: fill(&before, 0),
    }
}
