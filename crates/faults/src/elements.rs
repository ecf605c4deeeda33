//! Faults of taxels, channels and their wiring.
//!
//! # Reference
//!
//! None; the definitions are ours.

use crate::work::FaultySample;
use taxel_base::Layout;

/// Picks `share` of all elements, on average over samples, in random places.
fn some(work: &mut FaultySample, share: f64) -> Vec<usize> {
    let elements = work.elements();
    let count = work.round(share * elements as f64);
    let mut order = work.order(elements);
    order.truncate(count);
    order
}

/// Sets `share` of the channels or taxels to rest. A share of less than one channel hits as many
/// samples as make up for it: 2 % of 5 channels are one channel in every tenth sample.
pub(crate) fn dead(work: &mut FaultySample, share: f64) {
    for element in some(work, share) {
        work.kill(element);
    }
}

/// Sets `share` of the channels or taxels to full scale; shares count as for [`dead`].
pub(crate) fn stuck(work: &mut FaultySample, share: f64) {
    let high = work.sensor.high;
    for element in some(work, share) {
        work.x.row_mut(element).fill(high);
    }
}

/// Sets `count` rows or columns of an array, fingers, or channels to rest; all but one at most.
pub(crate) fn dead_line(work: &mut FaultySample, count: usize) {
    let lines: Vec<Vec<usize>> = match work.sensor.layout {
        Layout::Features | Layout::Series => (0..work.columns).map(|c| vec![c]).collect(),
        Layout::Fingers => (0..work.rows).map(|r| work.row(r)).collect(),
        Layout::Image | Layout::Colour | Layout::Sequence => {
            let rows = (0..work.rows).map(|r| work.row(r));
            rows.chain((0..work.columns).map(|c| work.column(c))).collect()
        }
    };
    let order = work.order(lines.len());
    for line in order.into_iter().take(count.min(lines.len() - 1)) {
        for &element in &lines[line] {
            work.kill(element);
        }
    }
}

/// Mixes the values above rest: `1 - share` of each and `share` of the mean of its neighbours, which are the taxels above,
/// below, left and right, or the channels before and after (of the same finger).
pub(crate) fn crosstalk(work: &mut FaultySample, share: f64) {
    let share = share as f32;
    let rest: Vec<f32> = (0..work.elements()).map(|element| work.rest(element)).collect();
    work.x.outer_iter_mut().zip(&rest).for_each(|(mut series, rest)| series -= *rest);
    let clean = work.x.clone();
    for element in 0..work.elements() {
        let (row, column) = (element / work.columns, element % work.columns);
        let mut neighbours = Vec::with_capacity(4);
        if column > 0 {
            neighbours.push(element - 1);
        }
        if column + 1 < work.columns {
            neighbours.push(element + 1);
        }
        if work.sensor.layout.has_area() {
            if row > 0 {
                neighbours.push(element - work.columns);
            }
            if row + 1 < work.rows {
                neighbours.push(element + work.columns);
            }
        }
        if neighbours.is_empty() {
            continue;
        }
        let each = share / neighbours.len() as f32;
        let mut series = work.x.row_mut(element);
        series *= 1.0 - share;
        for neighbour in neighbours {
            series.scaled_add(each, &clean.row(neighbour));
        }
    }
    work.x.outer_iter_mut().zip(&rest).for_each(|(mut series, rest)| series += *rest);
}

/// Makes `count` swaps of two channels, or of two rows or two columns of an array.
///
/// No swap undoes another: putting right takes `count` swaps as well. Pairs have no channel in
/// common as long as there are enough; n channels cannot be worse than n - 1 swaps.
pub(crate) fn swap(work: &mut FaultySample, count: usize) {
    let lines: Vec<Vec<usize>> = match (work.sensor.layout.has_area(), work.sign() > 0.0) {
        (false, _) => (0..work.elements()).map(|element| vec![element]).collect(),
        (true, true) => (0..work.rows).map(|r| work.row(r)).collect(),
        (true, false) => (0..work.columns).map(|c| work.column(c)).collect(),
    };
    let order = work.order(lines.len());
    // The edges of a path through all lines, every other one first: a tree, so each swap counts.
    let pairs =
        (0..lines.len().saturating_sub(1)).step_by(2).chain((1..lines.len().saturating_sub(1)).step_by(2));
    for at in pairs.take(count) {
        for (&a, &b) in lines[order[at]].iter().zip(&lines[order[at + 1]]) {
            for time in 0..work.times() {
                work.x.swap([a, time], [b, time]);
            }
        }
    }
}
