//! Shape arithmetic: numbers that describe shapes, and constants.

use super::attributes::Call;
use super::int_tables;
use super::stored::{MOST_AXES, StoredTensors};
use super::values::{AxisRole, AxisView, Dim, ImportedValue};
use super::work::{Importer, position};
use crate::error::Cause;
use crate::proto::{Tensor, dtype};

/// Reads `Constant`.
pub fn constant<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    if let Some(tensor) = call.tensor("value") {
        return Ok(stored(&mut work.stored, tensor.clone()));
    }
    if call.has("value_int") {
        return Ok(known(&[call.int("value_int", 0)], true));
    }
    if let Some(values) = call.ints("value_ints") {
        return if values.len() <= MOST_AXES {
            Ok(known(values, false))
        } else {
            Err(call.refuse("holds a long list of integers"))
        };
    }
    let (floats, dims) = match call.floats("value_floats") {
        Some(values) => (values.to_vec(), vec![values.len() as i64]),
        None if call.has("value_float") => (vec![call.float("value_float", 0.0)], vec![]),
        None => return Err(call.refuse("holds something else than numbers")),
    };
    let tensor = Tensor { dims, dtype: Some(dtype::FLOAT), floats, ..Tensor::default() };
    Ok(stored(&mut work.stored, tensor))
}

/// Makes a value of plain numbers.
pub fn known(values: &[i64], scalar: bool) -> ImportedValue {
    ImportedValue::Ints { values: values.iter().map(|&v| Dim::Known(v)).collect(), scalar }
}

/// Makes a value of a stored tensor.
pub fn stored(stored: &mut StoredTensors, tensor: Tensor) -> ImportedValue {
    let index = stored.add(tensor);
    match stored.ints(index) {
        Some((values, scalar)) => known(&values, scalar),
        None => ImportedValue::Stored { index, transposed: false },
    }
}

/// Reads `ConstantOfShape` and `Expand`: one number everywhere.
pub fn fill<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    if call.op() == "ConstantOfShape" {
        let value = match call.tensor("value") {
            None => 0.0,
            Some(tensor) => match stored(&mut work.stored, tensor.clone()) {
                ImportedValue::Stored { index, .. } => match work.stored.floats(index)?.data[..] {
                    [value] => value,
                    _ => return Err(call.refuse("its value has to be one number")),
                },
                ImportedValue::Ints { values, .. } => return repeated(work, call, &values),
                _ => return Err(call.refuse("its value has to be one number")),
            },
        };
        return Ok(ImportedValue::Fill(value));
    }
    match work.value(call, 0)? {
        ImportedValue::Fill(value) => Ok(ImportedValue::Fill(*value)),
        ImportedValue::Stored { .. } => match work.number(call, 0)? {
            Some(value) => Ok(ImportedValue::Fill(value)),
            None => Err(call.refuse("expands nothing")),
        },
        _ => Err(call.refuse("expands what samples become")),
    }
}

/// Makes a list of as many of the same integer as the input says.
fn repeated<'a>(work: &Importer<'a>, call: Call<'a>, value: &[Dim]) -> Result<ImportedValue, Cause> {
    let count = match work.dims(call, 0)?.as_deref() {
        Some([Dim::Known(count)]) => usize::try_from(*count).ok().filter(|count| *count <= MOST_AXES),
        _ => None,
    };
    match (count, value) {
        (Some(count), [one]) => Ok(ImportedValue::Ints { values: vec![*one; count], scalar: false }),
        _ => Err(call.refuse("makes integers that are no list of at most 64 of one number")),
    }
}

/// Reads `Shape` of what a node computes.
pub fn shape<'a>(work: &Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let sizes = match work.value(call, 0)? {
        ImportedValue::Flow(view) => sizes(work, view),
        _ => return Err(call.refuse("asks for the shape of a constant")),
    };
    let bound = |name, default: i64| {
        let at = call.int(name, default);
        let at = if at < 0 { at.saturating_add(sizes.len() as i64) } else { at };
        at.clamp(0, sizes.len() as i64) as usize
    };
    let (start, end) = (bound("start", 0), bound("end", i64::MAX));
    Ok(ImportedValue::Ints { values: sizes.get(start..end).unwrap_or_default().to_vec(), scalar: false })
}

/// Returns the sizes of a value's axes.
pub fn sizes(work: &Importer, view: &AxisView) -> Vec<Dim> {
    let shape = work.shape(view.node);
    let size = |axis: &AxisRole| match *axis {
        AxisRole::Batch => Dim::Batch,
        AxisRole::Sample(at) => {
            let pad = at.checked_sub(1).and_then(|at| view.pad.get(at)).map_or(0, |pad| pad.0 + pad.1);
            Dim::Known((shape[at] + pad) as i64)
        }
        AxisRole::Unit => Dim::Known(1),
        AxisRole::Step => Dim::Known(work.steps(view.node) as i64),
        AxisRole::Group(size) | AxisRole::Member(size) => Dim::Known(size as i64),
    };
    view.axes.iter().map(size).collect()
}

/// Reads an operation on numbers of shapes.
pub fn arithmetic<'a>(work: &Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let (values, scalar) = operand(work, call, 0)?;
    let known = |values: Vec<Dim>, scalar| {
        call.refuse_if(values.len() > MOST_AXES, "makes a long list of integers")?;
        Ok(ImportedValue::Ints { values, scalar })
    };
    match call.op() {
        "Gather" => {
            let (indices, one) = operand(work, call, 1)?;
            let pick = |index: &Dim| match index {
                Dim::Known(index) => position(call, *index, values.len()).map(|at| values[at]),
                Dim::Batch => Err(call.refuse("picks by the number of samples")),
            };
            known(indices.iter().map(pick).collect::<Result<_, _>>()?, one)
        }
        "Concat" => {
            let mut all = vec![];
            for at in 0..call.node.inputs.len() {
                all.extend(operand(work, call, at)?.0);
                known(all.clone(), false)?;
            }
            known(all, false)
        }
        "Unsqueeze" => known(values, false),
        "Reshape" if work.dims(call, 1)?.is_some_and(|to| to.len() == 2) => {
            int_tables::rows(work, call, values)
        }
        "Squeeze" | "Reshape" => {
            let one = values.len() == 1
                && (call.op() == "Squeeze" || work.dims(call, 1)?.is_some_and(|to| to.is_empty()));
            known(values, one)
        }
        "Slice" => {
            let bounds = |name, at| work.ints(call, name, at);
            let (start, end, step) = (bounds("starts", 1)?, bounds("ends", 2)?, bounds("steps", 4)?);
            let one = |list: Option<Vec<i64>>| list.and_then(|list| list.first().copied());
            let (start, end) = (one(start).unwrap_or(0), one(end).unwrap_or(i64::MAX));
            call.refuse_if(one(step).unwrap_or(1) != 1, "takes every second value, or backwards")?;
            let range = range(start, end, values.len());
            known(values[range].to_vec(), false)
        }
        "Cast" | "Identity" => known(values, scalar),
        _ => {
            let (others, is_scalar) = operand(work, call, 1)?;
            let count = values.len().max(others.len());
            if [values.len(), others.len()].iter().any(|len| *len != count && *len != 1) {
                return Err(call.refuse(format!("{} and {} numbers", values.len(), others.len())));
            }
            let pair = |at: usize| (values[at % values.len()], others[at % others.len()]);
            let each = (0..count).map(|at| calculated(call, pair(at))).collect::<Result<_, _>>()?;
            known(each, scalar && is_scalar)
        }
    }
}

/// Returns which part of `len` values a slice takes.
pub fn range(start: i64, end: i64, len: usize) -> std::ops::Range<usize> {
    let at = |bound: i64| {
        let bound = if bound < 0 { bound.saturating_add(len as i64) } else { bound };
        bound.clamp(0, len as i64) as usize
    };
    let start = at(start);
    start..at(end).max(start)
}

fn operand<'a>(work: &Importer<'a>, call: Call<'a>, at: usize) -> Result<(Vec<Dim>, bool), Cause> {
    match work.value(call, at)? {
        ImportedValue::Ints { values, scalar } => Ok((values.clone(), *scalar)),
        _ => Err(call.refuse("mixes numbers of shapes with other values")),
    }
}

fn calculated(call: Call, pair: (Dim, Dim)) -> Result<Dim, Cause> {
    let found = match (call.op(), pair) {
        (op, (Dim::Known(a), Dim::Known(b))) => match op {
            "Add" => a.checked_add(b),
            "Sub" => a.checked_sub(b),
            "Mul" => a.checked_mul(b),
            "Div" => a.checked_div(b),
            _ => None,
        }
        .map(Dim::Known),
        ("Mul", (Dim::Batch, Dim::Known(1)) | (Dim::Known(1), Dim::Batch))
        | ("Div", (Dim::Batch, Dim::Known(1)))
        | ("Add" | "Sub", (Dim::Batch, Dim::Known(0))) => Some(Dim::Batch),
        _ => None,
    };
    found.ok_or_else(|| call.refuse("calculates a shape out of the number of samples"))
}
