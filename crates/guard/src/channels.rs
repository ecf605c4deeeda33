//! Finds the channels that predict each other.

use crate::guard::Link;
use crate::limits::{ALL_PAIRS, NEAR, NEIGHBOURS, RELATED};
use crate::places::ElementPlaces;

/// Finds for each channel those that correlate with it most, the closest first, with a line for each by least squares over
/// all values of `samples`; none for one that never varies.
pub(crate) fn links(places: &ElementPlaces, samples: &[f32], mean: &[f64]) -> Vec<Vec<Link>> {
    let count = places.elements;
    let are_near = |a: usize, b: usize| count <= ALL_PAIRS || a.abs_diff(b) <= NEAR;
    let mut products = vec![0.0; count * count.min(ALL_PAIRS.max(2 * NEAR + 1))];
    // Row-major of all pairs, or of those within reach.
    let width = products.len() / count;
    let place = |a: usize, b: usize| a * width + if count <= ALL_PAIRS { b } else { NEAR + b - a };
    let mut centred = vec![0.0; count];
    for sample in samples.chunks_exact(places.len()) {
        for time in 0..places.times {
            for (element, value) in centred.iter_mut().enumerate() {
                *value = f64::from(sample[places.at(element, time)]) - mean[element];
            }
            for a in 0..count {
                let last = if count <= ALL_PAIRS { count } else { (a + NEAR + 1).min(count) };
                for b in a..last {
                    products[place(a, b)] += centred[a] * centred[b];
                }
            }
        }
    }
    let product = |a: usize, b: usize| products[place(a.min(b), a.max(b))];
    let of = |element: usize| {
        let varies = |other: usize| product(other, other) > 0.0;
        let others =
            (0..count).filter(|other| *other != element && are_near(element, *other) && varies(*other));
        let mut related: Vec<(f64, usize)> = others
            .filter(|_| varies(element))
            .map(|other| {
                let both = (product(element, element) * product(other, other)).sqrt();
                ((product(element, other) / both).abs(), other)
            })
            .filter(|(correlation, _)| *correlation >= RELATED)
            .collect();
        related.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let line = |&(_, from): &(f64, usize)| {
            let slope = product(element, from) / product(from, from);
            Link { from, offset: (mean[element] - slope * mean[from]) as f32, slope: slope as f32 }
        };
        let is_finite = |link: &Link| link.offset.is_finite() && link.slope.is_finite();
        related.iter().take(NEIGHBOURS).map(line).filter(is_finite).collect()
    };
    (0..count).map(of).collect()
}
