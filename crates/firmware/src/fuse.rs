//! Convolutions whose floats need not stand in memory: those that become bytes, and those of which one mean, largest value or
//! deviation per filter is all that is read.

use crate::layer::{Layer, Memory, Row, RowNumber, Statistic, Then, Work};
use crate::lower::Network;

/// Filters that a convolution computes together.
pub(crate) const TOGETHER: usize = 2;

/// Joins such convolutions with the layers that read them.
pub(crate) fn fuse(mut network: Network) -> Network {
    for at in 0..network.layers.len() {
        let Some((then, to)) = network.layers.get(at).and_then(|layer| then(&network, layer)) else {
            continue;
        };
        network.layers.remove(at + 1);
        network.layers[at].to = to;
        if let Work::Conv(conv) = &mut network.layers[at].work {
            conv.then = Some(then);
        }
    }
    for at in 0..network.layers.len() {
        let Some(statistics) = network.layers.get(at).and_then(|layer| statistics(&network, layer)) else {
            continue;
        };
        let to = network.layers[at].to;
        network.layers.retain(|layer| !layer.from.iter().any(|row| row.memory == to.memory));
        network.memories[to.memory] = Memory::of_floats(TOGETHER * to.len());
        // Filters of an image lie side by side, so that one row of it follows the other.
        let pitch = if to.rows == 1 { 1 } else { TOGETHER };
        network.layers[at].to = Row { start: 0, pitch, row_pitch: pitch * to.positions, ..to };
        if let Work::Conv(conv) = &mut network.layers[at].work {
            conv.statistics = statistics;
        }
    }
    network
}

/// Returns the layers besides `conv` that use the memory of its floats, where it alone writes there.
fn users<'a>(network: &'a Network, conv: &'a Layer) -> Option<Vec<&'a Layer>> {
    let to = &conv.to;
    let is_alone = to.scale.is_none() && to.pitch == to.channels;
    if !matches!(conv.work, Work::Conv(_)) || !is_alone || network.logits.memory == to.memory {
        return None;
    }
    let others = network.layers.iter().filter(|layer| !std::ptr::eq(*layer, conv));
    Some(others.filter(|layer| layer.rows().any(|row| row.memory == to.memory)).collect())
}

/// Returns how a convolution's floats become bytes, and where those lie, if the next layer alone reads them.
fn then(network: &Network, conv: &Layer) -> Option<(Then, Row)> {
    let users = users(network, conv)?;
    let [map] = users[..] else { return None };
    let at = network.layers.iter().position(|layer| std::ptr::eq(layer, conv))?;
    let is_next = network.layers.get(at + 1).is_some_and(|next| std::ptr::eq(next, map));
    let Work::Map { factors, shifts, ending } = &map.work else { return None };
    let (factor, shift) = (*factors.first()?, *shifts.first()?);
    let is_uniform = factors.iter().all(|f| *f == factor) && shifts.iter().all(|s| *s == shift);
    let fits = is_next && is_uniform && factor > 0.0 && map.to.scale.is_some() && map.from[..] == [conv.to];
    fits.then_some((Then { factor, shift, ending: *ending }, map.to))
}

/// Returns what becomes of a convolution's floats, if that is one number per filter alone.
fn statistics(network: &Network, conv: &Layer) -> Option<Vec<Statistic>> {
    let users = users(network, conv)?;
    let numbers: Option<Vec<Statistic>> = users.into_iter().map(|layer| statistic(layer, &conv.to)).collect();
    let is_plain = matches!(&conv.work, Work::Conv(work) if conv.to.rows == 1 || work.groups == 1);
    numbers.filter(|numbers| !numbers.is_empty() && conv.to.len() > 1 && is_plain)
}

fn statistic(layer: &Layer, row: &Row) -> Option<Statistic> {
    let number = match &layer.work {
        Work::MeanFloats { windows, shares } if windows.is_whole(row) => RowNumber::Mean { share: shares[0] },
        Work::Most(windows) if windows.is_whole(row) => RowNumber::Most,
        Work::Deviation { share, eps } => RowNumber::Deviation { share: *share, eps: *eps },
        _ => return None,
    };
    let fits = layer.from[..] == [*row] && layer.to.memory != row.memory;
    fits.then_some(Statistic { number, to: layer.to })
}
