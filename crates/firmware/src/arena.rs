//! Where memories lie in one arena: those that are needed at the same time do not overlap.

use crate::layer::{Layer, Memory, Row};

/// Bytes that a convolution may read behind a value: it takes them by four.
const SPARE: usize = 3;
/// Every memory begins at a multiple of this.
const ALIGNMENT: usize = 4;

/// The arena.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Arena {
    /// First byte of every memory; none of memories that no layer uses.
    pub offsets: Vec<Option<usize>>,
    /// Bytes of the arena.
    pub len: usize,
}

/// A memory, and the layers between which it is needed.
#[derive(Debug, Clone, Copy)]
struct Lifetime {
    memory: usize,
    len: usize,
    first: usize,
    last: usize,
}

impl Arena {
    /// Plans the memories of layers; what holds the logits stays until the end.
    pub fn new(layers: &[Layer], memories: &[Memory], logits: &Row) -> Self {
        let mut lifetimes = vec![];
        for (memory, room) in memories.iter().enumerate() {
            let uses = |layer: &Layer| layer.uses(memory);
            let Some(first) = layers.iter().position(uses) else { continue };
            let last = if logits.memory == memory { None } else { layers.iter().rposition(uses) };
            let len = room.bytes().next_multiple_of(ALIGNMENT);
            lifetimes.push(Lifetime { memory, len, first, last: last.unwrap_or(layers.len()) });
        }
        let by_size = sorted(&lifetimes, |life| (usize::MAX - life.len, life.first));
        let by_length =
            sorted(&lifetimes, |life| (usize::MAX - (life.last - life.first), usize::MAX - life.len));
        let by_start = sorted(&lifetimes, |life| (life.first, usize::MAX - life.len));
        let plans = [by_size, by_length, by_start].map(|order| place(&order, memories.len()));
        let [first, second, third] = plans;
        let mut best = first;
        for plan in [second, third] {
            if plan.len < best.len {
                best = plan;
            }
        }
        best.len = (best.len + SPARE).next_multiple_of(ALIGNMENT);
        best
    }
}

/// Returns the bytes of one value.
pub(crate) fn element(row: &Row) -> usize {
    if row.scale.is_some() { 1 } else { size_of::<f32>() }
}

/// Returns the first byte of a row.
pub(crate) fn offset(row: &Row, arena: &Arena) -> usize {
    arena.offsets[row.memory].unwrap_or(0) + row.start * element(row)
}

fn sorted<K: Ord>(lifetimes: &[Lifetime], key: impl Fn(&Lifetime) -> K) -> Vec<Lifetime> {
    let mut order = lifetimes.to_vec();
    order.sort_by_key(key);
    order
}

/// Puts each memory at the lowest place that is free while it is needed.
fn place(order: &[Lifetime], memories: usize) -> Arena {
    let mut offsets = vec![None; memories];
    let mut placed: Vec<(Lifetime, usize)> = vec![];
    let mut len = 0;
    for life in order {
        let mut taken: Vec<(usize, usize)> = placed
            .iter()
            .filter(|(other, _)| other.first <= life.last && life.first <= other.last)
            .map(|(other, offset)| (*offset, offset + other.len))
            .collect();
        taken.sort_unstable();
        let mut offset = 0;
        for (from, to) in taken {
            if offset + life.len <= from {
                break;
            }
            offset = offset.max(to);
        }
        offsets[life.memory] = Some(offset);
        placed.push((*life, offset));
        len = len.max(offset + life.len);
    }
    Arena { offsets, len }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memories_that_live_together_lie_apart() {
        let life = |memory, len, first, last| Lifetime { memory, len, first, last };
        let order = [life(0, 100, 0, 1), life(1, 60, 1, 2), life(2, 40, 2, 3), life(3, 80, 3, 4)];
        let arena = place(&order, 5);
        assert_eq!(arena.offsets, [Some(0), Some(100), Some(0), Some(40), None]);
        assert_eq!(arena.len, 160);
    }
}
