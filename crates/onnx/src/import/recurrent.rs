//! `LSTM`: one layer, one direction, from zero states.

use taxel_graph::{Op, Tensor};

use super::attributes::Call;
use super::values::{AxisRole, AxisView, ImportedValue};
use super::work::Importer;
use crate::error::Cause;

/// Reads `LSTM`: the hidden states of all steps, of which only the last is there, and the last.
pub fn lstm<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<Vec<ImportedValue>, Cause> {
    let view = work.flow(call, 0)?;
    if view.axes.contains(&AxisRole::Step) {
        return Err(call.refuse("reads every step of another LSTM; taxel's LSTM answers its last step alone"));
    }
    let across = call.int("layout", 0) != 0;
    let wanted = if across {
        [AxisRole::Batch, AxisRole::Sample(1), AxisRole::Sample(0)]
    } else {
        [AxisRole::Sample(1), AxisRole::Batch, AxisRole::Sample(0)]
    };
    let shape = work.shape(view.node).to_vec();
    let &[channels, steps] = &shape[..] else {
        return Err(call.refuse(format!("reads {}, not channels × length", taxel_graph::describe(&shape))));
    };
    if view.axes != wanted {
        return Err(call.refuse(
            "reads the first axis of the samples as time; taxel's recordings are channels × length: let the network \
             turn them itself (x.transpose(1, 2) before the LSTM)",
        ));
    }
    check(work, call)?;
    let name = work.name(call, 1, &[".weight_ih_l0", ".weight_ih_l0/iofg"], "lstm");
    let (input, state) = (work.floats(call, 1)?, work.floats(call, 2)?);
    let hidden = hidden_units(call, &input.shape, &state.shape, channels)?;
    let biases = match call.input(3) {
        None => vec![0.0; 8 * hidden],
        Some(_) => work.floats(call, 3)?.data,
    };
    if biases.len() != 8 * hidden {
        return Err(call.refuse(format!("has {} biases for {hidden} hidden units", biases.len())));
    }
    let matrix = |tensor: Tensor| {
        let width = tensor.shape[2];
        Tensor { shape: vec![4 * hidden, width], data: gates(&tensor.data, hidden * width) }
    };
    let bias = |half: &[f32]| Tensor { shape: vec![4 * hidden], data: gates(half, hidden) };
    let tensors = vec![
        ("weight_ih_l0", matrix(input)),
        ("weight_hh_l0", matrix(state)),
        ("bias_ih_l0", bias(&biases[..4 * hidden])),
        ("bias_hh_l0", bias(&biases[4 * hidden..])),
    ];
    let op = Op::Lstm { hidden, steps };
    let node = work.draft.add(name, op, &[view.node], tensors).map_err(|e| call.refuse(e))?;
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

/// Returns the number of hidden units, from the shapes of the weights of inputs and of states.
fn hidden_units(call: Call, input: &[usize], state: &[usize], channels: usize) -> Result<usize, Cause> {
    let hidden = state.get(2).copied().unwrap_or(0);
    let fits = hidden > 0
        && hidden
            .checked_mul(4)
            .is_some_and(|gates| *input == [1, gates, channels] && *state == [1, gates, hidden]);
    if !fits {
        return Err(
            call.refuse(format!("its weights {input:?} and {state:?} do not fit {channels} channels"))
        );
    }
    Ok(hidden)
}

/// Refuses variants that taxel's LSTM is not.
fn check<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<(), Cause> {
    let direction = call.text("direction").unwrap_or("forward");
    call.refuse_if(direction != "forward", format!("goes {direction}; taxel's LSTM goes forward"))?;
    let functions = call.texts("activations");
    if !functions.is_empty() && functions != ["Sigmoid", "Tanh", "Tanh"] {
        return Err(
            call.refuse(format!("has the functions {functions:?}; taxel's LSTM has Sigmoid, Tanh, Tanh"))
        );
    }
    if call.has("clip") || call.int("input_forget", 0) != 0 {
        return Err(call.refuse("clips values or couples gates; taxel's LSTM does neither"));
    }
    for (at, what) in [(4, "lengths of sequences"), (7, "peepholes")] {
        call.refuse_if(call.input(at).is_some(), format!("has {what}; taxel's LSTM has none"))?;
    }
    for at in [5, 6].into_iter().filter(|&at| call.input(at).is_some()) {
        let zero = match work.value(call, at)? {
            ImportedValue::Fill(value) => *value == 0.0,
            _ => work.floats(call, at)?.data.iter().all(|v| *v == 0.0),
        };
        call.refuse_if(!zero, "starts from other states than zeros")?;
    }
    Ok(())
}

/// Brings four gates of `each` values from ONNX's order i, o, f, g into PyTorch's i, f, g, o.
fn gates(data: &[f32], each: usize) -> Vec<f32> {
    [0, 2, 3, 1].iter().flat_map(|gate| &data[gate * each..(gate + 1) * each]).copied().collect()
}
