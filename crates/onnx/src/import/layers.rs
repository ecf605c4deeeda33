//! Operations with tensors: convolution, norm, linear layer; and dropout.

use taxel_graph::{Op, Tensor};

use super::attributes::Call;
use super::pools::window;
use super::values::{AxisView, ImportedValue};
use super::work::{Importer, swapped};
use crate::error::Cause;

/// Endings of weights' names.
const WEIGHT: [&str; 1] = [".weight"];

/// Reads `Conv`.
pub fn conv<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.padded(call, 0)?;
    let weight = work.floats(call, 1)?;
    let bias = if call.input(2).is_some() { Some(work.floats(call, 2)?) } else { None };
    let [filters, inputs, kernel @ ..] = &weight.shape[..] else {
        return Err(call.refuse(format!("its weight has the shape {:?}", weight.shape)));
    };
    let (filters, inputs, kernel) = (*filters, *inputs, kernel.to_vec());
    let shape = work.shape(view.node).to_vec();
    let groups = usize::try_from(call.int("group", 1)).unwrap_or(0);
    let name = work.name(call, 1, &WEIGHT, "conv");
    // On features behind a pool a kernel of one value is a linear layer.
    let ones = kernel.iter().all(|&size| size == 1);
    let (plain, _) = window(call, kernel.clone(), &vec![1; kernel.len()], &[])?;
    let multiplies_only =
        ones && groups == 1 && plain.padding.iter().all(|pad| *pad == (0, 0)) && view.pad.is_empty();
    if multiplies_only && shape.len() == 1 && view.is_plain(1, kernel.len()) {
        let weight = Tensor { shape: vec![filters, inputs], data: weight.data };
        let node = linear_node(work, call, name, view.node, (weight, bias))?;
        return Ok(ImportedValue::Flow(AxisView { node, ..view }));
    }
    work.refuse_order(call, &view, 0)?;
    if kernel.len() + 1 != shape.len() || groups == 0 || inputs.checked_mul(groups) != Some(shape[0]) {
        return Err(call.refuse(format!(
            "its weight {:?} in {groups} groups does not fit an input of {}",
            weight.shape,
            taxel_graph::describe(&shape)
        )));
    }
    let (window, dilation) = window(call, kernel, &shape[1..], &view.pad)?;
    let op = Op::Conv { filters, window, dilation, groups, bias: bias.is_some() };
    let tensors = with_bias(weight, bias);
    let node = work.draft.add(name, op, &[view.node], tensors).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, pad: vec![], ..view }))
}

fn with_bias(weight: Tensor, bias: Option<Tensor>) -> Vec<(&'static str, Tensor)> {
    let bias = bias.map(|bias| ("bias", bias));
    std::iter::once(("weight", weight)).chain(bias).collect()
}

/// Reads `BatchNormalization`.
pub fn batch_norm<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.flow(call, 0)?;
    work.refuse_order(call, &view, view.units())?;
    if call.int("training_mode", 0) != 0 {
        return Err(
            call.refuse("normalises by the batch: export the network in evaluation, after model.eval()")
        );
    }
    let name = work.name(call, 1, &WEIGHT, "batch_norm");
    let mut tensors = vec![];
    for (at, suffix) in ["weight", "bias", "running_mean", "running_var"].into_iter().enumerate() {
        tensors.push((suffix, work.floats(call, at + 1)?));
    }
    // ONNX weighs what was, PyTorch what is new; the difference is rounded as people write it.
    let momentum = 1.0 - f64::from(call.float("momentum", 0.9));
    let momentum = ((momentum * 1e6).round() / 1e6) as f32;
    let op = Op::BatchNorm { eps: call.float("epsilon", 1e-5), momentum };
    let node = work.draft.add(name, op, &[view.node], tensors).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, ..view }))
}

/// Reads `LayerNormalization` of features.
pub fn layer_norm<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.ordered(call, 0, 0)?;
    let shape = work.shape(view.node).to_vec();
    let last = i64::try_from(shape.len()).unwrap_or_default();
    let is_last = [-1, last].contains(&call.int("axis", -1));
    if shape.len() != 1 || !is_last {
        return Err(call.refuse(format!(
            "normalises {} over axis {}; taxel's layer norms read features and normalise all of them",
            taxel_graph::describe(&shape),
            call.int("axis", -1)
        )));
    }
    let (weight, name) = (work.floats(call, 1)?, work.name(call, 1, &WEIGHT, "layer_norm"));
    let zeros = Tensor { shape: shape.clone(), data: vec![0.0; shape[0]] };
    let bias = if call.input(2).is_some() { work.floats(call, 2)? } else { zeros };
    let op = Op::LayerNorm { eps: call.float("epsilon", 1e-5) };
    let tensors = vec![("weight", weight), ("bias", bias)];
    let node = work.draft.add(name, op, &[view.node], tensors).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, ..view }))
}

/// Reads `Gemm` and `MatMul` of features with a stored matrix.
pub fn linear<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    if work.is_stored(call, 0) || !work.is_stored(call, 1) {
        return Err(call.refuse("multiplies something else than features by a stored matrix"));
    }
    let view = work.ordered(call, 0, 0)?;
    if work.shape(view.node).len() != 1 {
        let shape = taxel_graph::describe(work.shape(view.node));
        return Err(
            call.refuse(format!("reads {shape}; taxel's linear layers read features, flatten them first"))
        );
    }
    let is_gemm = call.op() == "Gemm";
    call.refuse_if(is_gemm && call.int("transA", 0) != 0, "turns its input (transA)")?;
    let mut weight = work.floats(call, 1)?;
    call.refuse_if(weight.shape.len() != 2, format!("its weight has the shape {:?}", weight.shape))?;
    if !is_gemm || call.int("transB", 0) == 0 {
        weight = swapped(weight);
    }
    let mut bias = None;
    if is_gemm {
        scale(&mut weight, call.float("alpha", 1.0));
        if call.input(2).is_some() {
            let mut values = work.floats(call, 2)?;
            scale(&mut values, call.float("beta", 1.0));
            bias = Some(spread(call, values, weight.shape[0])?);
        }
    }
    let name = work.name(call, 1, &WEIGHT, "linear");
    let node = linear_node(work, call, name, view.node, (weight, bias))?;
    Ok(ImportedValue::Flow(AxisView { node, ..view }))
}

fn linear_node<'a>(
    work: &mut Importer<'a>,
    call: Call<'a>,
    name: String,
    input: usize,
    (weight, bias): (Tensor, Option<Tensor>),
) -> Result<usize, Cause> {
    let features = work.shape(input).to_vec();
    if weight.shape[1..] != features {
        return Err(
            call.refuse(format!("its weight {:?} does not fit {} features", weight.shape, features[0]))
        );
    }
    let op = Op::Linear { outputs: weight.shape[0], bias: bias.is_some() };
    work.draft.add(name, op, &[input], with_bias(weight, bias)).map_err(|e| call.refuse(e))
}

fn scale(tensor: &mut Tensor, factor: f32) {
    if factor != 1.0 {
        tensor.data.iter_mut().for_each(|v| *v *= factor);
    }
}

/// Returns one value per output, of a tensor that may hold one for all.
fn spread(call: Call, tensor: Tensor, outputs: usize) -> Result<Tensor, Cause> {
    let data = match tensor.data[..] {
        [one] => vec![one; outputs],
        _ => tensor.data,
    };
    call.refuse_if(data.len() != outputs, format!("adds {:?} to {outputs} outputs", tensor.shape))?;
    Ok(Tensor { shape: vec![outputs], data })
}

/// Reads `Dropout`, which training keeps.
pub fn dropout<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.pointwise(call, 0)?;
    if call.input(2).is_some() && work.flag(call, 2)? != Some(false) {
        return Err(call.refuse(
            "drops values in use too (training_mode): export the network in evaluation, after model.eval()",
        ));
    }
    let probability = work.number(call, 1)?.unwrap_or_else(|| call.float("ratio", 0.5));
    match probability {
        0.0 => Ok(ImportedValue::Flow(view)),
        probability => work.map(call, Op::Dropout { probability }, view),
    }
}
