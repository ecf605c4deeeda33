//! Which ONNX operation is read by whom.

use super::attributes::Call;
use super::values::{Dim, ImportedValue};
use super::work::Importer;
use super::{int_tables, ints, layers, maths, pools, recurrent, reshape, shapes};
use crate::error::Cause;

/// Operations that become part of a network, for messages.
const KNOWN: &str = "Add, AveragePool, BatchNormalization, Clip, Concat, Conv, Div, Dropout, Flatten, GRU, Gather, Gemm, \
                     GlobalAveragePool, GlobalMaxPool, HardSigmoid, HardSwish, Identity, LSTM, LeakyRelu, MatMul, \
                     MaxPool, Mul, Pad, Pow, ReduceMax, ReduceMean, Relu, Reshape, Sigmoid, Slice, Softmax, Split, Sqrt, \
                     Squeeze, Sub, Tanh, Transpose, Unsqueeze";

/// Reads a node; its outputs have values then.
pub fn node<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<(), Cause> {
    let domain = call.node.domain.as_deref().unwrap_or_default();
    if !["", "ai.onnx"].contains(&domain) {
        return Err(call.refuse(format!("is of the domain {domain:?}; taxel reads ONNX's own operations")));
    }
    let values = match call.op() {
        "LSTM" => recurrent::lstm(work, call)?,
        "GRU" => recurrent::gru(work, call)?,
        "Split" => shapes::split(work, call)?,
        _ => vec![value(work, call)?],
    };
    for (name, value) in call.node.outputs.iter().zip(values) {
        if !name.is_empty() && work.values.insert(name, value).is_some() {
            return Err(call.refuse(format!("gives `{name}`, which is there already")));
        }
    }
    Ok(())
}

fn value<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let first = call.input(0).and_then(|name| work.values.get(name));
    let second = call.input(1).and_then(|name| work.values.get(name));
    let of_shapes = matches!(first, Some(ImportedValue::Ints { .. }));
    let both = of_shapes && matches!(second, Some(ImportedValue::Ints { .. }));
    let of_tables = matches!(first, Some(ImportedValue::IntTable(_)));
    match call.op() {
        "Reshape" | "Slice" | "Transpose" if of_tables => int_tables::arithmetic(work, call),
        "Constant" => ints::constant(work, call),
        "ConstantOfShape" | "Expand" => ints::fill(work, call),
        "Shape" => ints::shape(work, call),
        "Gather" | "Concat" | "Unsqueeze" | "Squeeze" | "Reshape" | "Slice" if of_shapes => {
            ints::arithmetic(work, call)
        }
        "Add" | "Sub" | "Mul" | "Div" if both => ints::arithmetic(work, call),
        "Identity" => Ok(work.value(call, 0)?.clone()),
        "Cast" => cast(work, call),
        "Conv" => layers::conv(work, call),
        "BatchNormalization" => layers::batch_norm(work, call),
        "LayerNormalization" => layers::layer_norm(work, call),
        "Gemm" | "MatMul" => layers::linear(work, call),
        "Dropout" => layers::dropout(work, call),
        "Relu" | "Sigmoid" | "Tanh" | "HardSwish" | "LeakyRelu" | "HardSigmoid" | "Clip" => {
            maths::activation(work, call)
        }
        "Softmax" | "LogSoftmax" => maths::softmax(work, call),
        "Add" | "Sub" | "Mul" | "Div" => maths::arithmetic(work, call),
        "Pow" => maths::power(work, call),
        "Sqrt" => maths::root(work, call),
        "MaxPool" | "AveragePool" => pools::pool(work, call),
        "GlobalAveragePool" | "GlobalMaxPool" => pools::global(work, call),
        "ReduceMean" | "ReduceMax" => pools::reduce(work, call),
        "Pad" => pools::pad(work, call),
        "Flatten" => reshape::flatten(work, call),
        "Reshape" => reshape::reshape(work, call),
        "Transpose" => shapes::transpose(work, call),
        "Unsqueeze" => shapes::unsqueeze(work, call),
        "Squeeze" => shapes::squeeze(work, call),
        "Gather" => shapes::gather(work, call),
        "Slice" => shapes::slice(work, call),
        "Concat" => shapes::concat(work, call),
        op if op.contains("Quantize") || op.starts_with("QLinear") || op.ends_with("Integer") => {
            Err(call.refuse("is of a quantised network; export it before it is quantised"))
        }
        _ => Err(call.refuse(format!("taxel has no such operation; it reads {KNOWN}"))),
    }
}

/// Reads `Cast` between numbers of one kind.
fn cast<'a>(work: &Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    use crate::proto::dtype::{BFLOAT16, DOUBLE, FLOAT, FLOAT16, INT32, INT64};
    let (value, to) = (work.value(call, 0)?, call.int("to", 0));
    let to = i32::try_from(to).unwrap_or(0);
    let fits = match value {
        ImportedValue::Ints { values, .. } => {
            [INT32, INT64].contains(&to)
                || values.iter().all(|dim| matches!(dim, Dim::Known(_))) && to == INT64
        }
        _ => [FLOAT, FLOAT16, DOUBLE, BFLOAT16].contains(&to),
    };
    call.refuse_if(!fits, "makes whole numbers of others, or the other way round")?;
    Ok(value.clone())
}
