//! Axes added, dropped, turned, cut and joined.

use taxel_graph::Op;

use super::attributes::Call;
use super::ints::{range, sizes};
use super::stored::MOST_AXES;
use super::values::{AxisRole, AxisView, Dim, ImportedValue};
use super::work::{Importer, position};
use crate::error::Cause;

/// Reads `Transpose` of what a node computes, or of a stored matrix.
pub fn transpose<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let perm = call.ints("perm");
    if let ImportedValue::Stored { index, transposed } = *work.value(call, 0)? {
        return match perm {
            None | Some([1, 0]) => Ok(ImportedValue::Stored { index, transposed: !transposed }),
            Some(perm) => Err(call.refuse(format!("turns a stored tensor by {perm:?}"))),
        };
    }
    let view = work.flow(call, 0)?;
    let count = view.axes.len();
    let order: Vec<usize> = match perm {
        Some(perm) => perm.iter().map(|&axis| position(call, axis, count)).collect::<Result<_, _>>()?,
        None => (0..count).rev().collect(),
    };
    let mut sorted = order.clone();
    sorted.sort_unstable();
    call.refuse_if(!sorted.into_iter().eq(0..count), format!("{order:?} is no order of {count} axes"))?;
    let axes = order.iter().map(|&axis| view.axes[axis]).collect();
    Ok(ImportedValue::Flow(AxisView { axes, ..view }))
}

/// Reads `Unsqueeze`: axes of one value.
pub fn unsqueeze<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    if let ImportedValue::Fill(value) = *work.value(call, 0)? {
        return Ok(ImportedValue::Fill(value));
    }
    let mut view = work.flow(call, 0)?;
    let given = work.ints(call, "axes", 1)?.unwrap_or_default();
    let count = view.axes.len() + given.len();
    call.refuse_if(count > MOST_AXES, format!("makes {count} axes"))?;
    let mut axes: Vec<usize> =
        given.into_iter().map(|axis| position(call, axis, count)).collect::<Result<_, _>>()?;
    axes.sort_unstable();
    for axis in axes {
        call.refuse_if(axis > view.axes.len(), "names an axis twice")?;
        view.axes.insert(axis, AxisRole::Unit);
    }
    Ok(ImportedValue::Flow(view))
}

/// Reads `Squeeze`: axes of one value less.
pub fn squeeze<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    if let ImportedValue::Fill(value) = *work.value(call, 0)? {
        return Ok(ImportedValue::Fill(value));
    }
    let view = work.flow(call, 0)?;
    let sizes = sizes(work, &view);
    let axes = match work.axes(call, 1, view.axes.len())? {
        Some(axes) => axes,
        None => (0..sizes.len()).filter(|&at| sizes[at] == Dim::Known(1)).collect(),
    };
    let rank = work.shape(view.node).len();
    if axes.iter().any(|&at| sizes[at] != Dim::Known(1)) {
        return Err(call.refuse("drops an axis of more than one value"));
    }
    let real = axes.iter().filter(|&&at| view.axes[at] != AxisRole::Unit).count();
    let left: Vec<AxisRole> =
        view.axes.iter().enumerate().filter(|(at, _)| !axes.contains(at)).map(|(_, axis)| *axis).collect();
    if real == 0 {
        return Ok(ImportedValue::Flow(AxisView { axes: left, ..view }));
    }
    // Real axes may go if the channels are all that is left.
    let flat = left
        .iter()
        .copied()
        .filter(|axis| *axis != AxisRole::Unit)
        .eq([AxisRole::Batch, AxisRole::Sample(0)]);
    if !flat {
        // A recurrent layer may read them so; any other layer refuses axes that are not all there.
        return Ok(ImportedValue::Flow(AxisView { axes: left, ..view }));
    }
    call.refuse_if(rank == 1, "drops the axis of the features")?;
    let node = work.draft.then(Op::Flatten, &[view.node]).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, axes: left, pad: vec![] }))
}

/// Reads `Gather` of one place: the last step of a recurrent layer, or the only place of an axis of one value.
pub fn gather<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let mut view = work.flow(call, 0)?;
    let (index, scalar) = match work.value(call, 1)? {
        ImportedValue::Ints { values, scalar } => match values[..] {
            [Dim::Known(index)] => (index, *scalar),
            _ => return Err(call.refuse("picks several places")),
        },
        _ => return Err(call.refuse("picks places that depend on the samples")),
    };
    let axis = position(call, call.int("axis", 0), view.axes.len())?;
    let last = match view.axes[axis] {
        AxisRole::Step => work.steps(view.node) as i64 - 1,
        AxisRole::Unit => 0,
        _ => return Err(call.refuse("picks a place of channels or space; taxel slices channels alone")),
    };
    call.refuse_if(index != last && index != -1, "picks another step of a recurrent layer than the last")?;
    if scalar {
        view.axes.remove(axis);
    } else {
        view.axes[axis] = AxisRole::Unit;
    }
    Ok(ImportedValue::Flow(view))
}

/// Reads `Slice`: some channels, the last step of a recurrent layer, or everything.
pub fn slice<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    if let ImportedValue::Fill(value) = *work.value(call, 0)? {
        return Ok(ImportedValue::Fill(value));
    }
    let mut view = work.flow(call, 0)?;
    let starts = work.ints(call, "starts", 1)?.unwrap_or_default();
    let ends = work.ints(call, "ends", 2)?.unwrap_or_default();
    let axes = match work.axes(call, 3, view.axes.len())? {
        Some(axes) => axes,
        None => (0..starts.len()).collect(),
    };
    let steps = work.ints(call, "steps", 4)?.unwrap_or_default();
    let known = axes.len() <= MOST_AXES && steps.iter().all(|&step| step == 1);
    if !known || starts.len() != axes.len() || ends.len() != axes.len() {
        return Err(
            call.refuse("takes every second value or backwards, or has not one start and end per axis")
        );
    }
    for (at, &axis) in axes.iter().enumerate() {
        let size = sizes(work, &view).get(axis).copied();
        let size = match size {
            Some(Dim::Known(size)) => usize::try_from(size).unwrap_or(0),
            Some(Dim::Batch) if starts[at] == 0 && ends[at] >= i64::from(i32::MAX) => continue,
            _ => return Err(call.refuse("cuts samples, or an axis that is not there")),
        };
        let part = range(starts[at], ends[at], size);
        match view.axes[axis] {
            _ if part == (0..size) => {}
            AxisRole::Step if part == (size - 1..size) => view.axes[axis] = AxisRole::Unit,
            AxisRole::Sample(0) => {
                let op = Op::Slice { start: part.start, len: part.len() };
                view.node = work.draft.then(op, &[view.node]).map_err(|e| call.refuse(e))?;
            }
            _ => {
                return Err(call.refuse(
                    "cuts space; taxel cuts channels, and takes the last step of a recurrent layer",
                ));
            }
        }
    }
    Ok(ImportedValue::Flow(view))
}

/// Reads `Split` along channels.
pub fn split<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<Vec<ImportedValue>, Cause> {
    let view = work.pointwise(call, 0)?;
    let axis = position(call, call.int("axis", 0), view.axes.len())?;
    call.refuse_if(view.axes[axis] != AxisRole::Sample(0), "splits another axis than channels")?;
    let (channels, parts) = (work.shape(view.node)[0], call.node.outputs.len());
    let lengths = match work.ints(call, "split", 1)? {
        Some(given) => given.into_iter().map(|len| usize::try_from(len).unwrap_or(0)).collect(),
        None => {
            let each = channels.div_ceil(parts.max(1));
            (0..parts).map(|at| each.min(channels.saturating_sub(at * each))).collect::<Vec<_>>()
        }
    };
    call.refuse_if(lengths.len() != parts, format!("{} lengths for {parts} parts", lengths.len()))?;
    let (mut start, mut values) = (0usize, vec![]);
    for len in lengths {
        let node = work.draft.then(Op::Slice { start, len }, &[view.node]).map_err(|e| call.refuse(e))?;
        values.push(ImportedValue::Flow(AxisView { node, ..view.clone() }));
        start = start.saturating_add(len);
    }
    call.refuse_if(start != channels, format!("its parts have {start} of {channels} channels"))?;
    Ok(values)
}

/// Reads `Concat` along channels.
pub fn concat<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let first = work.pointwise(call, 0)?;
    let axis = position(call, call.int("axis", 0), first.axes.len())?;
    call.refuse_if(first.axes[axis] != AxisRole::Sample(0), "joins another axis than channels")?;
    let mut nodes = vec![];
    for at in 0..call.node.inputs.len() {
        let view = work.pointwise(call, at)?;
        call.refuse_if(view.axes != first.axes, "joins values whose axes lie in another order")?;
        nodes.push(view.node);
    }
    let name = work.name(call, usize::MAX, &[], "concat");
    let node = work.draft.add(name, Op::Concat, &nodes, vec![]).map_err(|e| call.refuse(e))?;
    Ok(ImportedValue::Flow(AxisView { node, ..first }))
}
