//! Images: which kernel a layer calls, for one row after the other or for several rows at once.

use crate::arena::element;
use crate::kernel::Kernel;
use crate::layer::{Layer, Row, Windows, Work};
use crate::lower::Network;
use crate::row_text::has_numbers_of_rows;

/// Makes one row of rows without gaps wherever a layer may take them as such.
pub(crate) fn lined(mut network: Network) -> Network {
    for layer in &mut network.layers {
        let rows: Vec<Option<Row>> = layer.from.iter().chain([&layer.to]).map(Row::line).collect();
        let Some(&Some(to)) = rows.last() else { continue };
        match &mut layer.work {
            Work::Map { .. }
            | Work::Copy
            | Work::Add { .. }
            | Work::AddFloats(_)
            | Work::Shuffle(_)
            | Work::Deviation { .. }
            | Work::Flatten => {
                let from: Option<Vec<Row>> = rows[..layer.from.len()].iter().copied().collect();
                let Some(from) = from else { continue };
                (layer.from, layer.to) = (from, to);
            }
            Work::Conv(conv) if conv.row_step == layer.to.positions * conv.step => {
                if let Some(addend) = layer.from.get_mut(1) {
                    let Some(line) = addend.line() else { continue };
                    *addend = line;
                }
                layer.to = to;
            }
            Work::Depthwise(conv) if conv.row_step == layer.to.positions * conv.step => layer.to = to,
            Work::Most(windows) | Work::Mean { windows, .. } | Work::MeanFloats { windows, .. } => {
                let Some(from) = rows[0].filter(|_| windows.is_whole(&layer.from[0])) else { continue };
                *windows = Windows { rows: vec![[0, 1]], columns: vec![[0, from.positions]] };
                layer.from = vec![from];
            }
            _ => {}
        }
    }
    network
}

/// Returns the numbers of windows that have to be stored: those of one row of outputs where all rows have the same.
pub(crate) fn tables<'n, T: PartialEq>(numbers: &'n [T], to: &Row) -> &'n [T] {
    let (first, rest) = numbers.split_at(to.positions);
    let is_same = rest.chunks_exact(to.positions).all(|row| row == first);
    if is_same { first } else { numbers }
}

/// Returns the distances of neighbouring rows that a kernel takes: what they belong to, and bytes.
fn distances(layer: &Layer) -> Vec<(&'static str, usize)> {
    let bytes = |row: &Row| row.row_pitch * element(row);
    let to = ("to", bytes(&layer.to));
    match &layer.work {
        Work::Conv(conv) => {
            let addend = layer.from.get(1).map_or(0, bytes);
            vec![("from", conv.row_step), to, ("addend", addend)]
        }
        Work::Depthwise(conv) => vec![("from", conv.row_step), to],
        Work::Add { .. } | Work::AddFloats(_) => {
            vec![("a", bytes(&layer.from[0])), ("b", bytes(&layer.from[1])), to]
        }
        _ => vec![("from", bytes(&layer.from[0])), to],
    }
}

/// Returns the call of a kernel, and the kernel that runs it row by row where there are several rows.
pub(crate) fn call(name: &str, layer: &Layer, kernel: Kernel, described: &str) -> (String, Option<Kernel>) {
    let rows = layer.to.rows;
    if has_numbers_of_rows(layer) {
        let distances = distances(layer);
        let (from, addend) = (distances[0].1, distances[2].1);
        let text = format!("conv_numbers({described}, arena, {rows}u, {from}u, {addend}u)");
        return (text, Some(Kernel::ConvNumbers));
    }
    let by_rows = match kernel {
        _ if rows == 1 => None,
        Kernel::Most | Kernel::MostFloats | Kernel::Mean | Kernel::MeanFloats => {
            return (format!("pool_rows({described}, arena, {name})"), Some(Kernel::PoolRows));
        }
        Kernel::Conv => Some(Kernel::ConvRows),
        Kernel::Depthwise => Some(Kernel::DepthwiseRows),
        Kernel::Map => Some(Kernel::MapRows),
        Kernel::Add => Some(Kernel::AddRows),
        Kernel::AddFloats => Some(Kernel::AddFloatsRows),
        _ => None,
    };
    if by_rows.is_none() {
        return (format!("{name}({described}, arena)"), None);
    }
    let distances: String = distances(layer).into_iter().map(|(_, bytes)| format!(", {bytes}u")).collect();
    (format!("{name}_rows({described}, arena, {rows}u{distances})"), by_rows)
}
