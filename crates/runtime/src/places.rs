//! Where every value lies: in a buffer of its own, or among the channels of a concatenation that it becomes part of,
//! with the margins that its readers need. Buffers are used again once their last reader is through.

use std::collections::HashSet;

use taxel_kernels::frozen::ImagePlace;

use crate::step::{FrozenStep, StepId, StepOp};

/// Places of all values.
pub(crate) struct ValuePlaces {
    /// Of every step: its place and its buffer.
    pub values: Vec<(ImagePlace, usize)>,
    /// Of every step: the one whose memory it lies in.
    pub roots: Vec<StepId>,
    /// Every buffer.
    pub buffers: Vec<Room>,
}

/// The size and type of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Room {
    pub len: usize,
    /// The byte that means 0, which margins hold; none in a buffer of floats.
    pub zero: Option<u8>,
}

/// A place with margins, and the byte that they hold; none in a buffer of floats.
type Margins = (ImagePlace, Option<u8>);

/// Channels of a larger value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Spot {
    /// The value that has memory of its own.
    root: StepId,
    first: usize,
}

impl ValuePlaces {
    pub fn new(steps: &[FrozenStep], outputs: &[StepId]) -> Self {
        let spots = spots(steps);
        let mut margins = vec![[0; 2]; steps.len()];
        for step in steps {
            if let Some(&input) = step.inputs.first() {
                let margin = &mut margins[spots[input].root];
                let needed = step.work.margin();
                *margin = [margin[0].max(needed[0]), margin[1].max(needed[1])];
            }
        }
        let place = |id: StepId| {
            let Spot { root, first } = spots[id];
            let shape = steps[id].shape;
            ImagePlace::new(shape.size, shape.channels, margins[root], steps[root].shape.channels, first)
        };
        let places: Vec<ImagePlace> = (0..steps.len()).map(place).collect();
        let (buffer_of, buffers) = share(steps, outputs, &spots, &places);
        let values = places.iter().zip(&spots).map(|(place, spot)| (*place, buffer_of[spot.root])).collect();
        ValuePlaces { values, roots: spots.iter().map(|spot| spot.root).collect(), buffers }
    }
}

/// Puts what is joined where it will lie, unless a step would then write into the value that it reads.
fn spots(steps: &[FrozenStep]) -> Vec<Spot> {
    let mut separate = HashSet::new();
    loop {
        let spots = join(steps, &separate);
        let before = separate.len();
        for (id, step) in steps.iter().enumerate() {
            for (which, &input) in step.inputs.iter().enumerate() {
                let shared = spots[input].root == spots[id].root;
                match step.work {
                    StepOp::Slice(_) => {}
                    // Moved inside one value: it would have to be read and written at once.
                    StepOp::Concat if shared && spots[input] != part(steps, &spots, id, which) => {
                        separate.insert(owner(steps, input));
                    }
                    StepOp::Concat => {}
                    _ if shared => drop(separate.insert(id)),
                    _ => {}
                }
            }
        }
        if separate.len() == before {
            return spots;
        }
    }
}

/// Returns the step that computes what slices take.
fn owner(steps: &[FrozenStep], mut id: StepId) -> StepId {
    while let StepOp::Slice(_) = steps[id].work {
        id = steps[id].inputs[0];
    }
    id
}

/// Returns where input `which` of a concatenation belongs.
fn part(steps: &[FrozenStep], spots: &[Spot], concat: StepId, which: usize) -> Spot {
    let before: usize = steps[concat].inputs[..which].iter().map(|&input| steps[input].shape.channels).sum();
    Spot { first: spots[concat].first + before, ..spots[concat] }
}

fn join(steps: &[FrozenStep], separate: &HashSet<StepId>) -> Vec<Spot> {
    let mut spots: Vec<Spot> = (0..steps.len()).map(|root| Spot { root, first: 0 }).collect();
    let mut placed = vec![false; steps.len()];
    // Later concatenations hold earlier ones.
    for (id, step) in steps.iter().enumerate().rev() {
        let StepOp::Concat = step.work else { continue };
        if !placed[id] && !separate.contains(&id) {
            // All its parts may lie side by side in a later one.
            let first = spots[step.inputs[0]];
            let mut next = first;
            let in_order = step.inputs.iter().all(|&input| {
                let fits = placed[input] && spots[input] == next;
                next.first += steps[input].shape.channels;
                fits
            });
            if in_order {
                (spots[id], placed[id]) = (first, true);
            }
        }
        for (which, &input) in step.inputs.iter().enumerate() {
            let is_movable =
                !matches!(steps[input].work, StepOp::Slice(_)) && !steps[input].work.makes_dense();
            if is_movable && !placed[input] && !separate.contains(&input) {
                (spots[input], placed[input]) = (part(steps, &spots, id, which), true);
            }
        }
    }
    for (id, step) in steps.iter().enumerate() {
        if let StepOp::Slice(start) = step.work {
            let whole = spots[step.inputs[0]];
            spots[id] = Spot { first: whole.first + start, ..whole };
        }
    }
    spots
}

/// Returns the buffers of the roots, and their lengths.
fn share(
    steps: &[FrozenStep],
    outputs: &[StepId],
    spots: &[Spot],
    places: &[ImagePlace],
) -> (Vec<usize>, Vec<Room>) {
    let mut last: Vec<usize> = (0..steps.len()).collect();
    for (id, step) in steps.iter().enumerate() {
        for &input in &step.inputs {
            let root = spots[input].root;
            last[root] = last[root].max(id);
        }
        last[spots[id].root] = last[spots[id].root].max(id);
    }
    outputs.iter().for_each(|&output| last[spots[output].root] = usize::MAX);
    let (mut buffer_of, mut buffers): (_, Vec<Room>) = (vec![usize::MAX; steps.len()], vec![]);
    // Margins stay zero only where values with the same ones take a buffer over.
    let mut free: Vec<(Option<Margins>, usize)> = vec![];
    let zero = |root: StepId| steps[root].scale.map(|scale| scale.zero);
    let kind = |root: StepId| (places[root].margin != [0; 2]).then_some((places[root], zero(root)));
    for id in 0..steps.len() {
        let root = spots[id].root;
        let place = &places[root];
        if buffer_of[root] == usize::MAX {
            let fits = |(kept, buffer): &(_, usize)| {
                *kept == kind(root) && buffers[*buffer].zero.is_some() == zero(root).is_some()
            };
            let fitting = free.iter().rposition(fits);
            buffer_of[root] = fitting.map_or_else(
                || {
                    buffers.push(Room { len: 0, zero: zero(root) });
                    buffers.len() - 1
                },
                |at| free.remove(at).1,
            );
            let len = &mut buffers[buffer_of[root]].len;
            *len = place.buffer_len().max(*len);
        }
        for root in 0..=id {
            if last[root] == id && spots[root].root == root && buffer_of[root] != usize::MAX {
                free.push((kind(root), buffer_of[root]));
                last[root] = usize::MAX;
            }
        }
    }
    (buffer_of, buffers)
}
