//! Cloths: which yarn lies on top, and how high.
//!
//! # Reference
//!
//! F. T. Peirce, "The geometry of cloth structure", Journal of the Textile Institute 28, 1937: yarns of round section
//! that bend around each other. The weaves are those of any textbook on weaving.
//!
//! # Departures
//!
//! Bent yarns follow a cosine between crossings, not arcs and straight pieces; knits are their outer face alone.

use std::f64::consts::{PI, TAU};

use super::parameters::{CRIMP, YARN};

/// Height of the outer face over its deepest place, in pitches, at a place in pitches.
type Face = fn(f64, f64) -> f64;

/// Twelve cloths, as many as Rouhafzay et al. 2021 takes from ViTac, which it does not name.
pub(super) const CLOTHS: [(&str, Face); 12] = [
    ("plain", |x, y| woven(&["10", "01"], x, y)),
    ("basket", |x, y| woven(&["1100", "1100", "0011", "0011"], x, y)),
    ("rib", |x, y| woven(&["10", "10", "01", "01"], x, y)),
    ("twill-2-1", |x, y| woven(&["110", "011", "101"], x, y)),
    ("twill-2-2", |x, y| woven(&["1100", "0110", "0011", "1001"], x, y)),
    ("twill-3-1", |x, y| woven(&["1110", "0111", "1011", "1101"], x, y)),
    ("herringbone", |x, y| woven(&["11001001", "01101100", "00110110", "10010011"], x, y)),
    ("satin-5", |x, y| woven(&["11110", "11011", "01111", "11101", "10111"], x, y)),
    ("satin-8", |x, y| {
        woven(
            &["11111110", "11110111", "10111111", "11111101", "11101111", "01111111", "11111011", "11011111"],
            x,
            y,
        )
    }),
    ("corduroy", corduroy),
    ("jersey", jersey),
    ("rib-knit", rib_knit),
];

/// Returns the height of a weave. `draft` has a row per weft yarn, from below; 1 where the warp yarn, which runs along
/// y, lies on top.
fn woven(draft: &[&str], x: f64, y: f64) -> f64 {
    let (wefts, warps) = (draft.len() as i64, draft[0].len() as i64);
    // +1 where the warp is on top, -1 where the weft is.
    let on_top = |warp: f64, weft: f64| {
        let (row, column) = ((weft as i64).rem_euclid(wefts), (warp as i64).rem_euclid(warps));
        if draft[row as usize].as_bytes()[column as usize] == b'1' { 1.0 } else { -1.0 }
    };
    let (warp, weft) = (x.floor(), y.floor());
    // Half a pitch behind a crossing the yarn is on its way to the next.
    let along = |from: f64, crossing: &dyn Fn(f64) -> f64| {
        let before = (from - 0.5).floor();
        let share = (1.0 - (PI * (from - 0.5 - before)).cos()) / 2.0;
        crossing(before) * (1.0 - share) + crossing(before + 1.0) * share
    };
    let rise = CRIMP.get() * YARN.get();
    let of_warp = section(x - warp - 0.5) + rise * along(y, &|weft| on_top(warp, weft));
    let of_weft = section(y - weft - 0.5) - rise * along(x, &|warp| on_top(warp, weft));
    rise + of_warp.max(of_weft)
}

/// Returns the height of a round yarn beside its middle; 0 beside the yarn.
fn section(beside: f64) -> f64 {
    let radius = YARN.get() / 2.0;
    (radius * radius - beside * beside).max(0.0).sqrt()
}

/// Returns the height of corduroy: cords of pile along y, each over two yarns.
fn corduroy(x: f64, _: f64) -> f64 {
    (PI * x / 2.0).sin().abs()
}

/// Returns the height of jersey, loops of a knit: in every wale two legs lean towards each other.
fn jersey(x: f64, y: f64) -> f64 {
    let beside = x - x.floor() - 0.5;
    let lean = 0.14 + 0.12 * (y - y.floor());
    let leg = (beside.abs() - lean).abs();
    0.8 * (0.04 - leg * leg).max(0.0).sqrt() / 0.2 * (1.0 - 0.4 * (TAU * y).cos().max(0.0))
}

/// Returns the height of a rib knit: two wales up and two down, in turn.
fn rib_knit(x: f64, y: f64) -> f64 {
    let up = (0.5 + 0.9 * (PI * x / 2.0).sin()).clamp(0.0, 1.0);
    up + 0.5 * jersey(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heights(face: Face) -> Vec<f64> {
        (0..160).flat_map(|r| (0..160).map(move |c| face(f64::from(c) / 10.0, f64::from(r) / 10.0))).collect()
    }

    #[test]
    fn every_cloth_has_a_face_of_its_own_and_no_hole() {
        let all = CLOTHS.map(|(name, face)| (name, heights(face)));
        for (at, (name, heights)) in all.iter().enumerate() {
            let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
            assert!(low >= 0.0 && high > 0.4 && high < 2.0, "{name}: {low} to {high}");
            for (other, faces) in &all[..at] {
                let apart =
                    heights.iter().zip(faces).map(|(a, b)| (a - b).abs()).sum::<f64>() / heights.len() as f64;
                assert!(apart > 0.02, "{name} and {other}: {apart}");
            }
        }
    }

    #[test]
    fn the_draft_says_which_yarn_is_on_top() {
        let crown = YARN.get() / 2.0 + 2.0 * CRIMP.get() * YARN.get();
        let plain = CLOTHS[0].1;
        // Every crossing of a plain weave has a yarn at its crown.
        for (x, y) in [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (3.5, 2.5)] {
            assert!((plain(x, y) - crown).abs() < 1e-9, "{x} {y}: {}", plain(x, y));
        }
        // The warp is on top at (0, 0): it falls off to its sides, and hardly along.
        assert!(plain(0.2, 0.5) < plain(0.5, 0.2));
        assert!(plain(1.5, 0.2) < plain(1.2, 0.5));
    }
}
