//! Which gradients share memory.
//!
//! A slot lives from the first phase of the backward pass that writes it to the last that reads it. Within
//! a phase a sample runs through many nodes and then the next sample does, so slots that live in the same
//! phase never share. A slot that lives in a single phase of samples needs room for one sample only.

use std::ops::RangeInclusive;

use crate::plan::{BackwardStep, ExecutionPlan, Phase};

/// Where the gradients of a slot lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct GradientPlace {
    pub buffer: usize,
    /// From one sample to the next; 0 where a sample's gradient is used up before the next sample runs.
    pub stride: usize,
}

/// A place for every slot, and the length of every buffer.
#[derive(Debug)]
pub(crate) struct GradientPlaces {
    pub places: Vec<GradientPlace>,
    pub buffers: Vec<usize>,
}

impl GradientPlaces {
    /// Finds places for parts of up to `capacity` samples.
    pub fn new(plan: &ExecutionPlan, capacity: usize) -> Self {
        let lives = lives(plan);
        let stride = |slot: usize| if lives[slot].1 { 0 } else { plan.slots[slot].len };
        let size = |slot: usize| plan.slots[slot].len.max(capacity * stride(slot));
        // Large ones first: smaller ones then fit into what is there.
        let mut order: Vec<usize> = (0..plan.slots.len()).collect();
        order.sort_by_key(|&slot| std::cmp::Reverse(size(slot)));
        let mut places = vec![GradientPlace { buffer: 0, stride: 0 }; order.len()];
        let mut buffers: Vec<(usize, Vec<usize>)> = vec![];
        for slot in order {
            let life = &lives[slot].0;
            let free = |others: &[usize]| others.iter().all(|&other| !meet(life, &lives[other].0));
            // Sizes fall, so the last that is free is the smallest.
            let found = buffers.iter().rposition(|(_, others)| free(others)).unwrap_or_else(|| {
                buffers.push((size(slot), vec![]));
                buffers.len() - 1
            });
            buffers[found].1.push(slot);
            places[slot] = GradientPlace { buffer: found, stride: stride(slot) };
        }
        GradientPlaces { places, buffers: buffers.into_iter().map(|(len, _)| len).collect() }
    }
}

fn meet(a: &RangeInclusive<usize>, b: &RangeInclusive<usize>) -> bool {
    a.start() <= b.end() && b.start() <= a.end()
}

/// Finds the phases in which each slot lives, and whether it is one phase of samples.
#[expect(clippy::expect_used, reason = "the plan makes slots for what it runs, and for nothing else")]
fn lives(plan: &ExecutionPlan) -> Vec<(RangeInclusive<usize>, bool)> {
    let mut lives: Vec<Option<(usize, usize)>> = vec![None; plan.slots.len()];
    // The loss writes the outputs' before the first phase.
    plan.outputs.iter().for_each(|&(_, slot)| lives[slot] = Some((0, 0)));
    let mut touch = |slot: usize, time: usize| {
        let (first, _) = lives[slot].unwrap_or((time, time));
        lives[slot] = Some((first, time));
    };
    for (time, phase) in plan.backward.iter().enumerate() {
        let node = |id: usize| {
            let node = &plan.nodes[id];
            node.slots.iter().flatten().map(|&(slot, _)| slot).chain(node.gradients.iter().copied())
        };
        match phase {
            Phase::Samples(steps) => steps.iter().for_each(|step| match *step {
                BackwardStep::Node(id) => node(id).for_each(|slot| touch(slot, time)),
                BackwardStep::Sums(slot) => touch(slot, time),
            }),
            &Phase::Batch(id) => node(id).for_each(|slot| touch(slot, time)),
            Phase::Norms(_) => {}
        }
    }
    let life = |(slot, life): (usize, Option<(usize, usize)>)| {
        let (first, last) = life.expect("a slot is an output's or that of a node that the pass runs");
        (first..=last, first == last && plan.outputs.iter().all(|&(_, output)| slot != output))
    };
    lives.into_iter().enumerate().map(life).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::options::FrozenStatistics;

    fn plan(name: &str) -> ExecutionPlan {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        ExecutionPlan::new(&graph, &vec![false; graph.nodes().len()], FrozenStatistics::Kept)
    }

    #[test]
    fn buffers_are_smaller_than_the_sum_of_their_slots() {
        for (name, share) in [("hybrid-resvgg", 0.65), ("densenet6-lite-2d", 0.5), ("tactresnet", 0.4)] {
            let (plan, capacity) = (plan(name), 8);
            let places = GradientPlaces::new(&plan, capacity);
            let (shared, sum) = (
                places.buffers.iter().sum::<usize>(),
                capacity * plan.slots.iter().map(|slot| slot.len).sum::<usize>(),
            );
            assert!((shared as f64) < share * sum as f64, "{name}: {shared} of {sum} values");
        }
    }

    /// Runs the order of the pass: whoever reads a gradient finds what was written for it.
    #[test]
    fn no_gradient_is_overwritten_before_it_is_read() {
        let (capacity, count) = (3, 3);
        for name in ["mlp", "lstm", "vgg6-lite-2d", "hybrid-resvgg", "densenet6-lite-2d", "tactresnet"] {
            let plan = plan(name);
            let GradientPlaces { places, buffers } = GradientPlaces::new(&plan, capacity);
            let mut memory: Vec<Vec<Option<(usize, usize)>>> =
                buffers.iter().map(|&len| vec![None; len]).collect();
            let put = |memory: &mut Vec<Vec<_>>, slot: usize, sample: usize| {
                let GradientPlace { buffer, stride } = places[slot];
                memory[buffer][sample * stride..][..plan.slots[slot].len].fill(Some((slot, sample)));
            };
            let read = |memory: &Vec<Vec<_>>, slot: usize, sample: usize| {
                let GradientPlace { buffer, stride } = places[slot];
                let found = &memory[buffer][sample * stride..][..plan.slots[slot].len];
                assert!(found.iter().all(|v| *v == Some((slot, sample))), "{name}: slot {slot}");
            };
            for &(_, slot) in &plan.outputs {
                (0..count).for_each(|sample| put(&mut memory, slot, sample));
            }
            let node = |memory: &mut Vec<Vec<_>>, id: usize, sample: usize| {
                plan.nodes[id].gradients.iter().for_each(|&slot| read(memory, slot, sample));
                for &(slot, add) in plan.nodes[id].slots.iter().flatten() {
                    if add {
                        read(memory, slot, sample);
                    }
                    put(memory, slot, sample);
                }
            };
            for phase in &plan.backward {
                for sample in 0..count {
                    match phase {
                        Phase::Samples(steps) => steps.iter().for_each(|step| match *step {
                            BackwardStep::Node(id) => node(&mut memory, id, sample),
                            BackwardStep::Sums(slot) => read(&memory, slot, sample),
                        }),
                        &Phase::Batch(id) => node(&mut memory, id, sample),
                        Phase::Norms(_) => {}
                    }
                }
            }
        }
    }
}
