//! `Reshape`: flattening, grouping channels for a shuffle, axes of one value.

use taxel_graph::Op;

use super::attributes::Call;
use super::ints::sizes;
use super::stored::MOST_AXES;
use super::values::{AxisRole, AxisView, Dim, ImportedValue};
use super::work::Importer;
use crate::error::Cause;

/// Reads `Reshape` of what a node computes.
pub fn reshape<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.flow(call, 0)?;
    let to = match call.ints("shape") {
        Some(values) => values.iter().map(|&v| Dim::Known(v)).collect::<Vec<_>>(),
        None => work.dims(call, 1)?.unwrap_or_default(),
    };
    let from = sizes(work, &view);
    let refuse = || {
        let text = |dims: &[Dim]| {
            let each = |dim: &Dim| match dim {
                Dim::Known(size) => size.to_string(),
                Dim::Batch => "samples".into(),
            };
            dims.iter().map(each).collect::<Vec<_>>().join(" × ")
        };
        call.refuse(format!(
            "makes {} of {}; taxel flattens all of a sample, and groups channels to shuffle them",
            text(&to),
            text(&from)
        ))
    };
    call.refuse_if(to.len() > MOST_AXES, format!("makes {} axes", to.len()))?;
    let to = resolved(work, call, &from, to.clone()).ok_or_else(refuse)?;
    let axes = matched(&view.axes, &from, &to).ok_or_else(refuse)?;
    settled(work, call, view, axes)?.ok_or_else(refuse)
}

/// Returns the new sizes with nothing left open.
fn resolved(work: &Importer, call: Call, from: &[Dim], mut to: Vec<Dim>) -> Option<Vec<Dim>> {
    let total = product(from)?;
    if call.int("allowzero", 0) == 0 {
        for (at, dim) in to.iter_mut().enumerate().filter(|(_, dim)| **dim == Dim::Known(0)) {
            *dim = *from.get(at)?;
        }
    }
    let open: Vec<usize> = (0..to.len()).filter(|&at| to[at] == Dim::Known(-1)).collect();
    let known =
        |to: &[Dim]| product(&to.iter().copied().filter(|dim| *dim != Dim::Known(-1)).collect::<Vec<_>>());
    // The samples: said, or left open, or the number that the file fixes.
    if !to.contains(&Dim::Batch) {
        match open[..] {
            [at] if known(&to) == Some(total) => to[at] = Dim::Batch,
            _ => {
                let fixed = |at: &usize| {
                    let rest = [&to[..*at], &to[*at + 1..]].concat();
                    let fills = if open.is_empty() {
                        known(&rest) == Some(total)
                    } else {
                        known(&rest).is_some_and(|known| known > 0 && total % known == 0)
                    };
                    work.batch.is_some_and(|batch| to[*at] == Dim::Known(batch)) && fills
                };
                let at = (0..to.len()).find(fixed)?;
                to[at] = Dim::Batch;
            }
        }
    }
    match (0..to.len()).filter(|&at| to[at] == Dim::Known(-1)).collect::<Vec<_>>()[..] {
        [] => {}
        [at] => {
            let known = known(&to).filter(|known| *known > 0 && total % known == 0)?;
            to[at] = Dim::Known(total / known);
        }
        _ => return None,
    }
    let samples = to.iter().filter(|dim| **dim == Dim::Batch).count();
    (samples == 1 && product(&to) == Some(total)).then_some(to)
}

/// Counts the values of one sample.
fn product(dims: &[Dim]) -> Option<i64> {
    let sizes = dims.iter().filter_map(|dim| match dim {
        Dim::Known(size) => Some(*size),
        Dim::Batch => None,
    });
    sizes.into_iter().try_fold(1i64, |all, size| if size > 0 { all.checked_mul(size) } else { None })
}

/// Finds the axes of the new shape; `AxisRole::Sample(usize::MAX)` where all of a sample has become one.
fn matched(axes: &[AxisRole], from: &[Dim], to: &[Dim]) -> Option<Vec<AxisRole>> {
    const ALL: AxisRole = AxisRole::Sample(usize::MAX);
    let (mut out, mut i, mut j) = (vec![], 0, 0);
    while i < axes.len() || j < to.len() {
        match (axes.get(i).zip(from.get(i)), to.get(j)) {
            (Some((AxisRole::Batch, _)), Some(Dim::Batch)) => {
                out.push(AxisRole::Batch);
                (i, j) = (i + 1, j + 1);
            }
            (Some((axis, Dim::Known(a))), Some(Dim::Known(b))) if a == b => {
                out.push(*axis);
                (i, j) = (i + 1, j + 1);
            }
            (Some((AxisRole::Unit, _)), _) => i += 1,
            (_, Some(Dim::Known(1))) => {
                out.push(AxisRole::Unit);
                j += 1;
            }
            // What is left of the sample has one value per axis.
            (Some((AxisRole::Sample(_), Dim::Known(1))), None) => {
                i += 1;
                let flat = out.iter_mut().find(|axis| matches!(axis, AxisRole::Sample(_)))?;
                *flat = ALL;
            }
            (Some((_, Dim::Known(a))), Some(Dim::Known(b))) if a < b => {
                let (mut size, first) = (*a, i);
                while size < *b {
                    i += 1;
                    let Some(Dim::Known(more)) = from.get(i) else { return None };
                    size = size.checked_mul(*more)?;
                }
                i += 1;
                if size != *b {
                    return None;
                }
                out.push(merged(&axes[first..i])?);
                j += 1;
            }
            (Some((AxisRole::Sample(0), Dim::Known(a))), Some(Dim::Known(groups))) => {
                let Some(Dim::Known(members)) = to.get(j + 1) else { return None };
                if groups.checked_mul(*members) != Some(*a) {
                    return None;
                }
                out.push(AxisRole::Group(usize::try_from(*groups).ok()?));
                out.push(AxisRole::Member(usize::try_from(*members).ok()?));
                (i, j) = (i + 1, j + 2);
            }
            _ => return None,
        }
    }
    Some(out)
}

/// Merges several axes into one.
fn merged(axes: &[AxisRole]) -> Option<AxisRole> {
    let real: Vec<AxisRole> = axes.iter().copied().filter(|axis| *axis != AxisRole::Unit).collect();
    match real[..] {
        [one] => Some(one),
        [AxisRole::Group(_), AxisRole::Member(_)] => Some(AxisRole::Sample(0)),
        // A shuffle, which `settled` finishes.
        [AxisRole::Member(_), AxisRole::Group(groups)] => Some(AxisRole::Group(groups)),
        _ => {
            let in_order = real.iter().enumerate().all(|(at, axis)| *axis == AxisRole::Sample(at));
            in_order.then_some(AxisRole::Sample(usize::MAX))
        }
    }
}

/// Returns the value with the new axes, and adds the node that they ask for.
fn settled<'a>(
    work: &mut Importer<'a>,
    call: Call<'a>,
    view: AxisView,
    mut axes: Vec<AxisRole>,
) -> Result<Option<ImportedValue>, Cause> {
    let mut node = view.node;
    let rank = work.shape(node).len();
    let members = axes.iter().any(|axis| matches!(axis, AxisRole::Member(_)));
    let shuffled = axes.iter().position(|axis| matches!(axis, AxisRole::Group(_))).filter(|_| !members);
    if let Some(at) = shuffled {
        let AxisRole::Group(groups) = axes[at] else { return Ok(None) };
        node = work.draft.then(Op::ChannelShuffle { groups }, &[node]).map_err(|e| call.refuse(e))?;
        axes[at] = AxisRole::Sample(0);
    }
    let real = |axes: &[AxisRole]| axes.iter().filter(|axis| matches!(axis, AxisRole::Sample(_))).count();
    if let Some(at) = axes.iter().position(|axis| *axis == AxisRole::Sample(usize::MAX)) {
        // All of the sample has to be in it, and in order.
        if shuffled.is_some() || real(&axes) != 1 || !ordered(&view.axes, rank) {
            return Ok(None);
        }
        if rank > 1 {
            node = work.draft.then(Op::Flatten, &[node]).map_err(|e| call.refuse(e))?;
        }
        axes[at] = AxisRole::Sample(0);
    } else if !members && real(&axes) != rank {
        return Ok(None);
    }
    Ok(Some(ImportedValue::Flow(AxisView { node, axes, pad: vec![] })))
}

/// Checks whether the samples come first and the node's axes in their order.
fn ordered(axes: &[AxisRole], rank: usize) -> bool {
    let real = axes.iter().copied().filter(|axis| *axis != AxisRole::Unit);
    real.eq(AxisView::plain(0, rank).axes)
}

/// Reads `Flatten`: all but the samples.
pub fn flatten<'a>(work: &mut Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let view = work.pointwise(call, 0)?;
    let rank = work.shape(view.node).len();
    let axis = super::work::position(call, call.int("axis", 1), view.axes.len() + 1)?;
    if axis != 1 || !ordered(&view.axes, rank) {
        return Err(
            call.refuse("flattens something else than channels and space, in this order, of each sample")
        );
    }
    let node = match rank {
        1 => view.node,
        _ => work.draft.then(Op::Flatten, &[view.node]).map_err(|e| call.refuse(e))?,
    };
    Ok(ImportedValue::Flow(AxisView::plain(node, 1)))
}
