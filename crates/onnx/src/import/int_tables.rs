//! Tables of integers: PyTorch's older exporter turns the paddings of `nn.ConstantPad1d` and the like in one.

use super::attributes::Call;
use super::values::{Dim, ImportedValue};
use super::work::Importer;
use crate::error::Cause;

/// Reads `Reshape` of a list to rows.
pub fn rows<'a>(work: &Importer<'a>, call: Call<'a>, values: Vec<Dim>) -> Result<ImportedValue, Cause> {
    let to = work.ints(call, "shape", 1)?.unwrap_or_default();
    let sizes: Vec<Option<usize>> =
        to.iter().map(|&size| usize::try_from(size).ok().filter(|size| *size > 0)).collect();
    let width = match sizes[..] {
        [rows, Some(width)] if rows.is_none_or(|rows| rows.checked_mul(width) == Some(values.len())) => width,
        [Some(rows), None] => values.len() / rows,
        _ => 0,
    };
    call.refuse_if(
        width == 0 || !values.len().is_multiple_of(width.max(1)),
        format!("makes a table {to:?} of a list"),
    )?;
    Ok(ImportedValue::IntTable(values.chunks_exact(width).map(<[Dim]>::to_vec).collect()))
}

/// Reads `Slice` that turns the order of the rows, `Transpose`, and `Reshape` to a list.
pub fn arithmetic<'a>(work: &Importer<'a>, call: Call<'a>) -> Result<ImportedValue, Cause> {
    let ImportedValue::IntTable(table) = work.value(call, 0)? else {
        return Err(call.refuse("reads no table of integers"));
    };
    let known = |name, at| work.ints(call, name, at);
    match call.op() {
        "Reshape" => match known("shape", 1)?.as_deref() {
            Some([-1]) => Ok(ImportedValue::Ints { values: table.concat(), scalar: false }),
            to => Err(call.refuse(format!("makes {to:?} of a table of integers; taxel makes a list, [-1]"))),
        },
        "Transpose" => {
            let width = table.first().map_or(0, Vec::len);
            let column = |at: usize| table.iter().filter_map(|row| row.get(at).copied()).collect();
            match call.ints("perm") {
                None | Some([1, 0]) => Ok(ImportedValue::IntTable((0..width).map(column).collect())),
                Some(_) => Ok(ImportedValue::IntTable(table.clone())),
            }
        }
        _ => {
            let (start, end) = (known("starts", 1)?, known("ends", 2)?);
            let (axes, steps) = (known("axes", 3)?, known("steps", 4)?);
            // Both ends are as far away as can be written.
            let is_whole = matches!(start.as_deref(), Some([-1]))
                && end.is_some_and(|end| matches!(end[..], [..=-0x7fff_ffff]));
            let is_turned = axes.is_none_or(|axes| axes == [0]) && matches!(steps.as_deref(), Some([-1]));
            call.refuse_if(!is_whole || !is_turned, "cuts a table of integers; taxel turns its rows alone")?;
            Ok(ImportedValue::IntTable(table.iter().rev().cloned().collect()))
        }
    }
}
