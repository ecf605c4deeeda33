//! `LSTM` and `GRU`: one layer, one direction, from zero states.

use taxel_graph::{Op, Tensor};

use super::attributes::Call;
use super::values::{AxisRole, AxisView, ImportedValue};
use super::work::Importer;
use crate::error::Cause;

/// A recurrent operation of ONNX.
struct Kind {
    /// Where PyTorch's gates stand among ONNX's.
    order: &'static [usize],
    /// The only functions that taxel has.
    functions: &'static [&'static str],
    /// Endings of the names of stored input weights, before which the name of the layer stands.
    endings: [&'static str; 2],
}

/// PyTorch has i, f, g, o, ONNX i, o, f, g.
const LSTM: Kind = Kind {
    order: &[0, 2, 3, 1],
    functions: &["Sigmoid", "Tanh", "Tanh"],
    endings: [".weight_ih_l0", ".weight_ih_l0/iofg"],
};

/// PyTorch has r, z, n, ONNX z, r, n.
const GRU: Kind = Kind {
    order: &[1, 0, 2],
    functions: &["Sigmoid", "Tanh"],
    endings: [".weight_ih_l0", ".weight_ih_l0/zrn"],
};

/// Reads `LSTM`: the hidden states of all steps, of which only the last is there, and the last.
pub fn lstm<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<Vec<ImportedValue>, Cause> {
    call.refuse_if(call.int("input_forget", 0) != 0, "couples gates; taxel's LSTM does not")?;
    call.refuse_if(call.input(7).is_some(), "has peepholes; taxel's LSTM has none")?;
    layer(work, call, &LSTM, |hidden, steps| Op::Lstm { hidden, steps })
}

/// Reads `GRU`, in the same way.
pub fn gru<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<Vec<ImportedValue>, Cause> {
    call.refuse_if(
        call.int("linear_before_reset", 0) == 0,
        "resets the hidden state before its product (linear_before_reset = 0); taxel's GRU is PyTorch's, which does \
         so after it",
    )?;
    layer(work, call, &GRU, |hidden, steps| Op::Gru { hidden, steps })
}

fn layer<'a>(
    work: &mut Importer<'a>,
    call: Call<'a>,
    kind: &Kind,
    op: impl Fn(usize, usize) -> Op,
) -> Result<Vec<ImportedValue>, Cause> {
    let name = call.op();
    let view = work.flow(call, 0)?;
    if view.axes.contains(&AxisRole::Step) {
        return Err(call.refuse(format!(
            "reads every step of a recurrent layer; taxel's {name} answers its last step alone"
        )));
    }
    let across = call.int("layout", 0) != 0;
    let (channels, steps) = sequence(work, call, &view, across)?;
    check(work, call, kind)?;
    let node_name = work.name(call, 1, &kind.endings, &name.to_lowercase());
    let (input, state) = (work.floats(call, 1)?, work.floats(call, 2)?);
    let gates = kind.order.len();
    let hidden = hidden_units(call, &input.shape, &state.shape, [gates, channels])?;
    let biases = match call.input(3) {
        None => vec![0.0; 2 * gates * hidden],
        Some(_) => work.floats(call, 3)?.data,
    };
    if biases.len() != 2 * gates * hidden {
        return Err(call.refuse(format!("has {} biases for {hidden} hidden units", biases.len())));
    }
    let matrix = |tensor: Tensor| {
        let width = tensor.shape[2];
        Tensor { shape: vec![gates * hidden, width], data: ordered(&tensor.data, kind.order, hidden * width) }
    };
    let bias = |half: &[f32]| Tensor { shape: vec![gates * hidden], data: ordered(half, kind.order, hidden) };
    let tensors = vec![
        ("weight_ih_l0", matrix(input)),
        ("weight_hh_l0", matrix(state)),
        ("bias_ih_l0", bias(&biases[..gates * hidden])),
        ("bias_hh_l0", bias(&biases[gates * hidden..])),
    ];
    let op = op(hidden, steps);
    let node = work.draft.add(node_name, op, &[view.node], tensors).map_err(|e| call.refuse(e))?;
    let hidden = AxisRole::Sample(0);
    let (all, last) = if across {
        (
            vec![AxisRole::Batch, AxisRole::Step, AxisRole::Unit, hidden],
            vec![AxisRole::Batch, AxisRole::Unit, hidden],
        )
    } else {
        (
            vec![AxisRole::Step, AxisRole::Unit, AxisRole::Batch, hidden],
            vec![AxisRole::Unit, AxisRole::Batch, hidden],
        )
    };
    Ok([all, last].map(|axes| ImportedValue::Flow(AxisView { node, axes, pad: vec![] })).into())
}

/// Returns channels and steps of a sequence, whose axes have to lie as the operation reads them; axes of one value
/// between them may have been dropped.
fn sequence(work: &Importer, call: Call, view: &AxisView, across: bool) -> Result<(usize, usize), Cause> {
    let shape = work.shape(view.node);
    let &[channels, ref between @ .., steps] = shape else {
        return Err(call.refuse(format!("reads {}, not channels × length", taxel_graph::describe(shape))));
    };
    if between.iter().any(|&size| size != 1) {
        return Err(call.refuse(format!("reads {}, not channels × length", taxel_graph::describe(shape))));
    }
    let time = AxisRole::Sample(shape.len() - 1);
    let wanted = if across {
        [AxisRole::Batch, time, AxisRole::Sample(0)]
    } else {
        [time, AxisRole::Batch, AxisRole::Sample(0)]
    };
    if view.axes != wanted {
        return Err(call.refuse(format!(
            "reads the first axis of the samples as time; taxel's recordings are channels × length: let the network \
             turn them itself (x.transpose(1, 2) before the {})",
            call.op()
        )));
    }
    Ok((channels, steps))
}

/// Returns the number of hidden units, from the shapes of the weights of inputs and of states.
fn hidden_units(
    call: Call,
    input: &[usize],
    state: &[usize],
    [gates, channels]: [usize; 2],
) -> Result<usize, Cause> {
    let hidden = state.get(2).copied().unwrap_or(0);
    let fits = hidden > 0
        && hidden
            .checked_mul(gates)
            .is_some_and(|gates| *input == [1, gates, channels] && *state == [1, gates, hidden]);
    if !fits {
        return Err(
            call.refuse(format!("its weights {input:?} and {state:?} do not fit {channels} channels"))
        );
    }
    Ok(hidden)
}

/// Refuses variants that taxel's layer is not.
fn check<'a>(work: &mut Importer<'a>, call: Call<'a>, kind: &Kind) -> Result<(), Cause> {
    let name = call.op();
    let direction = call.text("direction").unwrap_or("forward");
    call.refuse_if(direction != "forward", format!("goes {direction}; taxel's {name} goes forward"))?;
    let functions = call.texts("activations");
    if !functions.is_empty() && functions != kind.functions {
        let known = kind.functions.join(", ");
        return Err(call.refuse(format!("has the functions {functions:?}; taxel's {name} has {known}")));
    }
    call.refuse_if(call.has("clip"), format!("clips values; taxel's {name} does not"))?;
    call.refuse_if(call.input(4).is_some(), format!("has lengths of sequences; taxel's {name} has none"))?;
    for at in [5, 6].into_iter().filter(|&at| call.input(at).is_some()) {
        let zero = match work.value(call, at)? {
            ImportedValue::Fill(value) => *value == 0.0,
            _ => work.floats(call, at)?.data.iter().all(|v| *v == 0.0),
        };
        call.refuse_if(!zero, "starts from other states than zeros")?;
    }
    Ok(())
}

/// Brings gates of `each` values into this order.
fn ordered(data: &[f32], order: &[usize], each: usize) -> Vec<f32> {
    order.iter().flat_map(|gate| &data[gate * each..(gate + 1) * each]).copied().collect()
}
