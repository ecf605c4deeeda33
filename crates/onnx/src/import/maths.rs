//! Functions of values: activations, sums, and products and sums with constants.

use taxel_graph::{Activation, Op, Tensor};

use super::attributes::Call;
use super::values::{AxisRole, AxisView, Fragment, ImportedValue};
use super::work::Importer;
use crate::error::Cause;

/// Reads functions of one value.
pub fn activation<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.pointwise(call, 0)?;
    let op = match call.op() {
        "Relu" => Op::Relu,
        "Sigmoid" => Op::Activation(Activation::Sigmoid),
        "Tanh" => Op::Activation(Activation::Tanh),
        "HardSwish" => Op::Activation(Activation::HardSwish),
        "LeakyRelu" => Op::Activation(Activation::LeakyRelu { slope: call.float("alpha", 0.01) }),
        "HardSigmoid" => {
            let (alpha, beta) = (call.float("alpha", 0.2), call.float("beta", 0.5));
            if (alpha - 1.0 / 6.0).abs() > 1e-4 || beta != 0.5 {
                return Err(call.refuse(format!("max(0, min(1, {alpha}·x + {beta})) is not PyTorch's")));
            }
            return Ok(ImportedValue::Part(Fragment::HardSigmoid, view));
        }
        _ => return clip(work, call, view),
    };
    work.map(call, op, view)
}

/// Reads `Clip` between 0 and 6, or from 0 on; between 0 and 1 at the end.
fn clip<'a>(work: &mut Importer<'a>, call: Call<'a>, view: AxisView) -> Result<ImportedValue, Cause> {
    let low = work.number(call, 1)?.unwrap_or_else(|| call.float("min", f32::MIN));
    let high = work.number(call, 2)?.unwrap_or_else(|| call.float("max", f32::MAX));
    match (low, high) {
        (0.0, 6.0) => work.map(call, Op::Activation(Activation::Relu6), view),
        (0.0, 1.0) => Ok(ImportedValue::Part(Fragment::Probabilities, view)),
        (0.0, f32::MAX..) => work.map(call, Op::Relu, view),
        _ => Err(call.refuse(format!("cuts at {low} and {high}; taxel knows 0 and 6 (ReLU6), and ReLU"))),
    }
}

/// Reads `Softmax`, which is taxel's own at the end.
pub fn softmax<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.flow(call, 0)?;
    work.refuse_order(call, &view, view.units())?;
    let features = work.shape(view.node).len() == 1;
    match (features, call.int("axis", 1)) {
        (true, 1) => Ok(ImportedValue::Part(Fragment::Probabilities, view)),
        (true, -1) if view.units() == 0 => Ok(ImportedValue::Part(Fragment::Probabilities, view)),
        (_, axis) => {
            Err(call.refuse(format!("axis {axis}: taxel knows a softmax over classes, at the end, alone")))
        }
    }
}

/// Reads `Add`, `Sub`, `Mul` and `Div`.
pub fn arithmetic<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let pair = [work.value(call, 0)?.clone(), work.value(call, 1)?.clone()];
    match (call.op(), pair) {
        ("Add", [ImportedValue::Part(Fragment::Variance { eps, kept }, view), _]) => {
            let more = constant(work, call, 1)?;
            Ok(ImportedValue::Part(Fragment::Variance { eps: eps + more, kept }, view))
        }
        ("Add", [_, ImportedValue::Part(Fragment::Variance { eps, kept }, view)]) => {
            let more = constant(work, call, 0)?;
            Ok(ImportedValue::Part(Fragment::Variance { eps: eps + more, kept }, view))
        }
        ("Add", [ImportedValue::Flow(_), ImportedValue::Flow(_)]) => sum(work, call),
        ("Sub", [ImportedValue::Flow(x), ImportedValue::Flow(mean)]) => centred(work, call, x, &mean),
        ("Mul", [ImportedValue::Part(Fragment::Centred, a), ImportedValue::Part(Fragment::Centred, b)]) if a == b => {
            Ok(ImportedValue::Part(Fragment::Squared, a))
        }
        ("Mul", [ImportedValue::Part(Fragment::HardSigmoid, gate), ImportedValue::Flow(x)])
        | ("Mul", [ImportedValue::Flow(x), ImportedValue::Part(Fragment::HardSigmoid, gate)])
            if gate == x =>
        {
            work.map(call, Op::Activation(Activation::HardSwish), x)
        }
        (_, [ImportedValue::Flow(_), ImportedValue::Stored { .. } | ImportedValue::Ints { .. } | ImportedValue::Fill(_)]) => with_constant(work, call, 0),
        ("Add" | "Mul", [ImportedValue::Stored { .. } | ImportedValue::Ints { .. } | ImportedValue::Fill(_), ImportedValue::Flow(_)]) => {
            with_constant(work, call, 1)
        }
        (op, [ImportedValue::Flow(_), ImportedValue::Flow(_)]) => Err(call.refuse(format!(
            "{} two values that both depend on the samples; taxel adds them (residual blocks), and does nothing else",
            match op {
                "Mul" => "multiplies",
                "Div" => "divides",
                _ => "subtracts",
            }
        ))),
        _ => Err(call.refuse("calculates with constants, or with a value that taxel has no operation for")),
    }
}

/// Reads input `at` as one number.
fn constant<'a>(work: &mut Importer<'a>, call: Call<'a>, at: usize) -> Result<f32, Cause> {
    work.number(call, at)?.ok_or_else(|| call.refuse("has nothing to add"))
}

fn sum<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let (a, b) = (work.pointwise(call, 0)?, work.pointwise(call, 1)?);
    call.refuse_if(a.axes != b.axes, "adds values whose axes lie in another order")?;
    let node = work.draft.then(Op::Add, &[a.node, b.node]).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, ..a }))
}

/// Reads the difference from a mean over space, on the way to a standard deviation.
fn centred<'a>(
    work: &Importer<'a>,
    call: Call<'a>,
    x: AxisView,
    mean: &AxisView,
) -> Result<ImportedValue, Cause> {
    let (rank, from) = (work.shape(x.node).len(), work.draft.node(mean.node));
    let is_mean_of_x = from.op == Op::GlobalAveragePool && from.inputs == [x.node] && x.pad.is_empty();
    let is_centred = is_mean_of_x && x.is_plain(rank, 0) && mean.is_plain(1, rank - 1);
    let reason = "subtracts two values that both depend on the samples; taxel knows it in a standard deviation over space alone";
    call.refuse_if(!is_centred, reason)?;
    Ok(ImportedValue::Part(Fragment::Centred, x))
}

/// Reads `Pow` of a difference from a mean.
pub fn power<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let value = work.value(call, 0)?.clone();
    let exponent = match work.dims(call, 1) {
        Ok(Some(dims)) => (dims == [super::values::Dim::Known(2)]).then_some(2.0),
        _ => work.number(call, 1)?,
    };
    match (value, exponent) {
        (ImportedValue::Part(Fragment::Centred, view), Some(2.0)) => {
            Ok(ImportedValue::Part(Fragment::Squared, view))
        }
        _ => Err(call.refuse("taxel knows the square of a difference from a mean alone")),
    }
}

/// Reads `Sqrt` of a variance.
pub fn root<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let ImportedValue::Part(Fragment::Variance { eps, kept }, view) = work.value(call, 0)?.clone() else {
        return Err(call.refuse("taxel knows the root of a variance over space alone"));
    };
    let units = if kept { work.shape(view.node).len() - 1 } else { 0 };
    let op = Op::GlobalStandardDeviation { eps };
    let node = work.draft.then(op, &[view.node]).map_err(|e| call.refuse(e))?;
    let mut root = AxisView::plain(node, 1);
    root.axes.extend(vec![AxisRole::Unit; units]);
    Ok(ImportedValue::Flow(root))
}

/// Reads an operation that adds, takes off, multiplies or divides by a value per channel, or one for all.
fn with_constant<'a>(work: &mut Importer<'a>, call: Call<'a>, at: usize) -> Result<ImportedValue, Cause> {
    let view = work.pointwise(call, at)?;
    let given = match work.value(call, 1 - at)? {
        ImportedValue::Fill(value) => Tensor { shape: vec![], data: vec![*value] },
        _ => work.floats(call, 1 - at)?,
    };
    let channels = work.shape(view.node)[0];
    let values = per_channel(call, &view, &given, channels)?;
    let (sole, op) = (work.is_only_reader(call, at), call.op());
    let (node, before) = (view.node, work.draft.node(view.node).op.clone());
    let vector = |data: Vec<f32>| Tensor { shape: vec![channels], data };
    match (op, before) {
        // A bias that stands for itself.
        ("Add", Op::Linear { outputs, bias: false }) if sole => {
            work.draft.amend(node, Op::Linear { outputs, bias: true }, "bias", vector(values));
            return Ok(ImportedValue::Flow(view));
        }
        ("Add", Op::Conv { filters, window, dilation, groups, bias: false }) if sole => {
            let op = Op::Conv { filters, window, dilation, groups, bias: true };
            work.draft.amend(node, op, "bias", vector(values));
            return Ok(ImportedValue::Flow(view));
        }
        // The second half of a z-score.
        ("Div", op @ Op::Standardize { .. }) if sole && work.draft.divides_by_one(node) => {
            work.draft.amend(node, op, "std", vector(values));
            return Ok(ImportedValue::Flow(view));
        }
        ("Mul", _) if given.data.len() == 1 && work.is_named(call, 1 - at) => {
            let name = work.name(call, 1 - at, &[""], "scale");
            let tensors = vec![("", Tensor { shape: vec![1], data: given.data })];
            let node = work.draft.add(name, Op::Scale, &[node], tensors).map_err(|e| call.refuse(e))?;
            return Ok(ImportedValue::Flow(AxisView { node, ..view }));
        }
        _ => {}
    }
    let each = |of: fn(f32) -> f32| values.iter().map(|&v| of(v)).collect::<Vec<f32>>();
    let (mean, std) = match op {
        "Add" => (each(|v| -v), each(|_| 1.0)),
        "Sub" => (each(|v| v), each(|_| 1.0)),
        "Mul" => (each(|_| 0.0), each(|v| 1.0 / v)),
        _ => (each(|_| 0.0), each(|v| v)),
    };
    if mean.iter().chain(&std).any(|v| !v.is_finite()) || std.contains(&0.0) {
        return Err(call.refuse("its constant is zero or not finite"));
    }
    let base = format!("{}/standardize", work.draft.node(node).name);
    let name = work.draft.name(&base);
    let op = Op::Standardize { mean: format!("{name}.mean"), std: format!("{name}.std") };
    let tensors = vec![("mean", vector(mean)), ("std", vector(std))];
    let node = work.draft.add(name, op, &[node], tensors).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, ..view }))
}

/// Returns a constant as one value per channel.
fn per_channel(call: Call, view: &AxisView, given: &Tensor, channels: usize) -> Result<Vec<f32>, Cause> {
    if let [one] = given.data[..] {
        return Ok(vec![one; channels]);
    }
    // ONNX aligns axes at their ends.
    let at = view.axes.iter().position(|axis| *axis == AxisRole::Sample(0)).unwrap_or(0);
    let from_end = view.axes.len() - at;
    let meets = given.shape.len().checked_sub(from_end).and_then(|at| given.shape.get(at)) == Some(&channels);
    if meets && given.data.len() == channels {
        Ok(given.data.clone())
    } else {
        Err(call.refuse(format!(
            "calculates with a constant of shape {:?}, which is not one number per channel",
            given.shape
        )))
    }
}
