//! Windows: convolution's and pools', and means and maxima over all of space.

use taxel_graph::{Op, Window};

use super::attributes::Call;
use super::values::{AxisRole, AxisView, Fragment, ImportedValue};
use super::work::Importer;
use crate::error::Cause;

/// Reads how a kernel slides over `size`, `pad` zeros around it counted, and its dilation (empty: none).
pub fn window(
    call: Call,
    kernel: Vec<usize>,
    size: &[usize],
    pad: &[(usize, usize)],
) -> Result<(Window, Vec<usize>), Cause> {
    let axes = size.len();
    let list = |name: &str, count: usize, default: usize| {
        let Some(values) = call.ints(name).filter(|values| !values.is_empty()) else {
            return Ok(vec![default; count]);
        };
        let values: Option<Vec<usize>> = values.iter().map(|&v| usize::try_from(v).ok()).collect();
        let fits = values.filter(|values| values.len() == count);
        fits.ok_or_else(|| call.refuse(format!("`{name}` has to be {count} numbers of at least 0")))
    };
    call.refuse_if(kernel.len() != axes, format!("its kernel {kernel:?} is not of {axes} spatial axes"))?;
    let (stride, dilation) = (list("strides", axes, 1)?, list("dilations", axes, 1)?);
    let pads = list("pads", 2 * axes, 0)?;
    let mut padding: Vec<(usize, usize)> = (0..axes).map(|axis| (pads[axis], pads[axes + axis])).collect();
    let upper = match call.text("auto_pad").unwrap_or("NOTSET") {
        "NOTSET" | "" => None,
        "VALID" => {
            padding.fill((0, 0));
            None
        }
        "SAME_UPPER" => Some(true),
        "SAME_LOWER" => Some(false),
        other => return Err(call.refuse(format!("auto_pad {other:?} is unknown"))),
    };
    if let Some(upper) = upper {
        for (axis, padding) in padding.iter_mut().enumerate() {
            let extent = kernel[axis].saturating_sub(1).saturating_mul(dilation[axis]).saturating_add(1);
            let steps = size[axis].div_ceil(stride[axis].max(1)).saturating_sub(1);
            let total = steps.saturating_mul(stride[axis]).saturating_add(extent).saturating_sub(size[axis]);
            let (less, more) = (total / 2, total - total / 2);
            *padding = if upper { (less, more) } else { (more, less) };
        }
    }
    for (padding, pad) in padding.iter_mut().zip(pad) {
        *padding = (padding.0.saturating_add(pad.0), padding.1.saturating_add(pad.1));
    }
    let dilation = if dilation.iter().all(|&step| step == 1) { vec![] } else { dilation };
    Ok((Window { kernel, stride, padding }, dilation))
}

/// Pads after the end where a last window hangs over it, but starts inside.
fn round_up(window: &mut Window, size: &[usize]) {
    for (axis, pad) in window.padding.iter_mut().enumerate() {
        let (kernel, stride) = (window.kernel[axis], window.stride[axis].max(1));
        let padded = size[axis].saturating_add(pad.0).saturating_add(pad.1);
        let Some(room) = padded.checked_sub(kernel) else { continue };
        let rest = room % stride;
        if rest > 0 && room - rest + stride < size[axis] + pad.0 {
            pad.1 += stride - rest;
        }
    }
}

/// Reads `MaxPool` and `AveragePool`.
pub fn pool<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.padded(call, 0)?;
    let shape = work.shape(view.node).to_vec();
    // PyTorch's newer exporter pools series as images of one row: it puts an axis of one value among those of space.
    let roles: Vec<AxisRole> = view.axes.iter().skip(2).copied().collect();
    let is_unit: Vec<bool> =
        roles.iter().map(|role| view.pad.is_empty() && *role == AxisRole::Unit).collect();
    let mut bare = view.clone();
    let mut place = 0;
    bare.axes.retain(|_| {
        place += 1;
        place <= 2 || !is_unit[place - 3]
    });
    work.refuse_order(call, &bare, 0)?;
    let is_max = call.op() == "MaxPool";
    if is_max && !view.pad.is_empty() {
        return Err(call.refuse("a maximum over zeros put around its input; give the pool its own padding"));
    }
    let kernel: Option<Vec<usize>> = call
        .ints("kernel_shape")
        .unwrap_or_default()
        .iter()
        .map(|&size| usize::try_from(size).ok())
        .collect();
    let Some(kernel) = kernel else { return Err(call.refuse("`kernel_shape` has to be sizes")) };
    let mut sizes = shape[1..].iter().copied();
    let whole: Vec<usize> =
        is_unit.iter().map(|unit| if *unit { 1 } else { sizes.next().unwrap_or(1) }).collect();
    let (window, dilation) = window(call, kernel, &whole, &view.pad)?;
    let (mut window, dilation) = without_units(call, window, dilation, &is_unit)?;
    let size = &shape[1..];
    if size.is_empty() {
        return Ok(ImportedValue::Flow(view));
    }
    call.refuse_if(!dilation.is_empty(), format!("dilation {dilation:?}: taxel's pools take neighbours"))?;
    let counted = match call.int("count_include_pad", 0) {
        0 if view.pad.is_empty() => vec![(0, 0); size.len()],
        0 => view.pad.clone(),
        _ => window.padding.clone(),
    };
    if call.int("ceil_mode", 0) != 0 {
        round_up(&mut window, size);
    }
    let op = if is_max { Op::MaxPool(window) } else { Op::AveragePool { window, counted } };
    work.map(call, op, AxisView { pad: vec![], ..view })
}

/// Leaves out the axes of one value, over which a kernel of one value does nothing.
fn without_units(
    call: Call,
    window: Window,
    dilation: Vec<usize>,
    is_unit: &[bool],
) -> Result<(Window, Vec<usize>), Cause> {
    let does_something = |at: usize| window.kernel[at] != 1 || window.padding[at] != (0, 0);
    let wrong = (0..is_unit.len()).any(|at| is_unit[at] && does_something(at));
    call.refuse_if(wrong, "pools over an axis of one value with a kernel of more, or pads it")?;
    let kept = |at: &usize| !is_unit[*at];
    let part = |all: &[usize]| (0..all.len()).filter(kept).map(|at| all[at]).collect::<Vec<usize>>();
    let padding = (0..is_unit.len()).filter(kept).map(|at| window.padding[at]).collect();
    let dilation = part(&dilation);
    let dilation = if dilation.iter().all(|&step| step == 1) { vec![] } else { dilation };
    Ok((Window { kernel: part(&window.kernel), stride: part(&window.stride), padding }, dilation))
}

/// Reads `GlobalAveragePool` and `GlobalMaxPool`.
pub fn global<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.pointwise(call, 0)?;
    let rank = work.shape(view.node).len();
    if rank == 1 && view.is_plain(1, view.units()) {
        return Ok(ImportedValue::Flow(view));
    }
    work.refuse_order(call, &view, 0)?;
    let node = over_space(work, call, &view, call.op() == "GlobalAveragePool")?;
    let mut pooled = AxisView::plain(node, 1);
    pooled.axes.extend(vec![AxisRole::Unit; rank - 1]);
    Ok(ImportedValue::Flow(pooled))
}

fn over_space<'a>(
    work: &mut Importer<'a>,
    call: Call<'a>,
    view: &AxisView,
    mean: bool,
) -> Result<usize, Cause> {
    if mean {
        return work.draft.then(Op::GlobalAveragePool, &[view.node]).map_err(|e| call.refuse(e));
    }
    let size = work.shape(view.node).get(1..).unwrap_or_default().to_vec();
    let window = Window { stride: vec![1; size.len()], padding: vec![(0, 0); size.len()], kernel: size };
    let pool = work.draft.then(Op::MaxPool(window), &[view.node]).map_err(|e| call.refuse(e))?;
    work.draft.then(Op::Flatten, &[pool]).map_err(|e| call.refuse(e))
}

/// Reads `ReduceMean` and `ReduceMax` over all of space.
pub fn reduce<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let kept = call.int("keepdims", 1) != 0;
    let squared = match work.value(call, 0)? {
        ImportedValue::Part(Fragment::Squared, view) => Some(view.clone()),
        _ => None,
    };
    let view = match &squared {
        Some(view) => view.clone(),
        None => work.pointwise(call, 0)?,
    };
    let Some(axes) = work.axes(call, 1, view.axes.len())? else {
        return Err(call.refuse("reduces all axes, samples among them"));
    };
    let rank = work.shape(view.node).len();
    let reduced = |at: &usize| axes.contains(at);
    let over =
        |axis: AxisRole| view.axes.iter().position(|other| *other == axis).is_some_and(|at| reduced(&at));
    let space: Vec<bool> = (1..rank).map(|axis| over(AxisRole::Sample(axis))).collect();
    if over(AxisRole::Batch) || over(AxisRole::Sample(0)) || space.contains(&false) {
        return Err(call.refuse(format!(
            "reduces the axes {axes:?}; taxel reduces all of space (every axis after samples and channels) or nothing"
        )));
    }
    if let Some(view) = squared {
        return Ok(ImportedValue::Part(Fragment::Variance { eps: 0.0, kept }, view));
    }
    let node = match rank {
        1 => view.node,
        _ => over_space(work, call, &view, call.op() == "ReduceMean")?,
    };
    // What is left of an axis is one value, or nothing.
    let left = |(at, axis): (usize, &AxisRole)| match (reduced(&at), kept) {
        (false, _) => Some(*axis),
        (true, true) => Some(AxisRole::Unit),
        (true, false) => None,
    };
    let axes = view.axes.iter().enumerate().filter_map(left).collect();
    Ok(ImportedValue::Flow(AxisView { node, axes, pad: vec![] }))
}

/// Reads `Pad` with zeros around space, which the next operation counts.
pub fn pad<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.padded(call, 0)?;
    work.refuse_order(call, &view, 0)?;
    let value = work.number(call, 2)?.unwrap_or_else(|| call.float("value", 0.0));
    let mode = call.text("mode").unwrap_or("constant");
    if mode != "constant" || value != 0.0 {
        return Err(call.refuse(format!("mode {mode:?} with {value}: taxel pads with zeros alone")));
    }
    let rank = view.axes.len();
    let pads = work.ints(call, "pads", 1)?.unwrap_or_default();
    let axes = match work.axes(call, 3, rank)? {
        Some(axes) => axes,
        None => (0..rank).collect(),
    };
    call.refuse_if(pads.len() != 2 * axes.len(), format!("{} paddings for {} axes", pads.len(), axes.len()))?;
    let mut all = view.pad.clone();
    all.resize(rank.saturating_sub(2), (0, 0));
    for (at, &axis) in axes.iter().enumerate() {
        let ends = [pads[at], pads[axes.len() + at]].map(usize::try_from);
        match (ends, axis.checked_sub(2)) {
            ([Ok(0), Ok(0)], _) => {}
            ([Ok(before), Ok(after)], Some(space)) => {
                let pad = &mut all[space];
                *pad = (pad.0.saturating_add(before), pad.1.saturating_add(after));
            }
            _ => return Err(call.refuse("cuts values off, or pads samples or channels")),
        }
    }
    if all.iter().all(|pad| *pad == (0, 0)) {
        all.clear();
    }
    if all.iter().any(|pad| pad.0 > 1 << 24 || pad.1 > 1 << 24) {
        return Err(call.refuse("pads with more zeros than any network needs"));
    }
    Ok(ImportedValue::Flow(AxisView { pad: all, ..view }))
}
