//! One element in one sample: its value as its neighbours predict it, the residual, and the kinds that it could be.

use crate::guard::{BrokenKind, Guard, Link, of_element};
use crate::limits::{FEWEST, NEIGHBOURS, QUIET, TOLERANCE};
use crate::places::ElementPlaces;

/// Predicts the value of an element at one time as the median of its neighbours' predictions; none without a neighbour.
pub(crate) fn predicted(
    guard: &Guard,
    places: &ElementPlaces,
    links: &[Link],
    (element, time): (usize, usize),
    sample: &[f32],
    is_broken: &[bool],
) -> Option<f32> {
    let (mut values, mut count) = ([0.0; NEIGHBOURS], 0);
    for link in links.iter().filter(|link| !is_broken[link.from]).take(NEIGHBOURS) {
        let value = link.offset + link.slope * sample[places.at(link.from, time)];
        let value = match guard.ends.get(element) {
            Some([low, high]) => value.clamp(*low, *high),
            None => value,
        };
        // Sorted as they come.
        let mut at = count;
        while at > 0 && values[at - 1] > value {
            values[at] = values[at - 1];
            at -= 1;
        }
        values[at] = value;
        count += 1;
    }
    match (count, count % 2) {
        (0, _) => None,
        (_, 1) => Some(values[count / 2]),
        _ => Some(values[count / 2 - 1] * 0.5 + values[count / 2] * 0.5),
    }
}

/// Returns the root mean square over the window of an element's values less their prediction, or less its mean where it
/// never had neighbours; none where all of them are broken.
pub(crate) fn residual(
    guard: &Guard,
    places: &ElementPlaces,
    links: &[Link],
    element: usize,
    sample: &[f32],
    is_broken: &[bool],
) -> Option<f64> {
    let mut sum = 0.0;
    for time in 0..places.times {
        let expected = if links.is_empty() {
            guard.mean[element]
        } else {
            predicted(guard, places, links, (element, time), sample, is_broken)?
        };
        sum += (f64::from(sample[places.at(element, time)]) - f64::from(expected)).powi(2);
    }
    Some((sum / places.times as f64).sqrt())
}

/// Checks which kinds the window of an element is of, in the order of [`BrokenKind::ALL`].
pub(crate) fn kinds(
    guard: &Guard,
    places: &ElementPlaces,
    element: usize,
    sample: &[f32],
) -> [bool; BrokenKind::ALL.len()] {
    let [low, high] = guard.range.map(f64::from);
    let tolerance = TOLERANCE * (high - low);
    let rest = f64::from(of_element(&guard.rest, element));
    let (mut least, mut most, mut off_rest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for time in 0..places.times {
        let value = f64::from(sample[places.at(element, time)]);
        (least, most) = (least.min(value), most.max(value));
        off_rest = off_rest.max((value - rest).abs());
    }
    let is_still = most - least <= QUIET * f64::from(of_element(&guard.quiet, element));
    [least >= high - tolerance, off_rest <= tolerance, places.times >= FEWEST && is_still, true]
}
