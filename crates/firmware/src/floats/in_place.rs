//! Convolutions that store their sums where their addend lay: one memory less.

use super::layer::FloatWork;
use crate::layer::{Layer, Memory, Row, Work};
use crate::lower::Network;

/// Puts sums in the place of addends that nobody reads afterwards.
pub(crate) fn in_place(mut network: Network) -> Network {
    for at in 0..network.layers.len() {
        let Some([gone, kept]) = joined(&network, at) else { continue };
        let rows = network.layers.iter_mut().flat_map(|layer| layer.from.iter_mut().chain([&mut layer.to]));
        for row in rows.chain([&mut network.logits]).filter(|row| row.memory == gone.memory) {
            (row.memory, row.start) = (kept.memory, kept.start);
        }
    }
    network
}

/// Returns which of the addend's row and the output's row of a layer gives way to the other.
fn joined(network: &Network, at: usize) -> Option<[Row; 2]> {
    let layer = &network.layers[at];
    let (Work::Floats(FloatWork::Conv(_)), [from, addend]) = (&layer.work, &layer.from[..]) else {
        return None;
    };
    let to = &layer.to;
    let shape = |row: &Row| (row.pitch, row.positions, row.channels);
    let fits = addend.memory != from.memory
        && addend.memory != to.memory
        && shape(addend) == shape(to)
        && network.logits.memory != addend.memory
        && !network.layers[at + 1..].iter().any(|layer| layer.uses(addend.memory))
        && !network.layers[..at].iter().any(|layer| layer.uses(to.memory))
        && [addend, to].iter().all(|row| is_alone(network, row));
    let [old, new] = [addend, to].map(|row| network.memories[row.memory]);
    if !fits {
        None
    } else if old == new || is_movable(network, to, &new) {
        Some([*to, *addend])
    } else if is_movable(network, addend, &old) {
        Some([*addend, *to])
    } else {
        None
    }
}

/// Checks whether a row is all that lies in its memory, for every layer.
fn is_alone(network: &Network, row: &Row) -> bool {
    let memory = &network.memories[row.memory];
    let mut rows = network.layers.iter().flat_map(Layer::rows).filter(|other| other.memory == row.memory);
    row.start == memory.margins[0] && row.pitch == row.channels && rows.all(|other| other == row)
}

/// Checks whether a row may begin elsewhere: it has no margins, and no window is counted from its start.
fn is_movable(network: &Network, row: &Row, memory: &Memory) -> bool {
    let has_window = |layer: &Layer| {
        matches!(layer.work, Work::Floats(FloatWork::Conv(_) | FloatWork::Depthwise(_)))
            && layer.from[0].memory == row.memory
    };
    memory.margins == [0; 2] && !network.layers.iter().any(has_window)
}
