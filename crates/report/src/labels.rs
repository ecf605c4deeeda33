//! Names beside marks, so that none covers another.

use crate::canvas::{Anchor, width_of};

/// A rectangle: left, top, right, bottom.
pub type Area = (f64, f64, f64, f64);

/// Size of the font of labels.
pub const SIZE: u32 = 12;

/// Where a label goes: the base of its text, and where that begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabelPlace {
    /// Where the text is anchored.
    pub at: (f64, f64),
    /// Which of its points is there.
    pub anchor: Anchor,
    /// Whether it is so far off that a line should lead to it.
    pub far: bool,
}

fn overlap(a: Area, b: Area) -> f64 {
    let width = a.2.min(b.2) - a.0.max(b.0);
    let height = a.3.min(b.3) - a.1.max(b.1);
    if width > 0.0 && height > 0.0 { width * height } else { 0.0 }
}

/// Returns a place for each label next to its mark, inside `inside` and off `taken`; of all that were tried the one
/// that covers least.
pub fn place(marks: &[((f64, f64), &str)], inside: Area, taken: &[Area]) -> Vec<LabelPlace> {
    let mut taken = taken.to_vec();
    taken.extend(marks.iter().map(|((x, y), _)| (x - 7.0, y - 7.0, x + 7.0, y + 7.0)));
    let mut places = vec![];
    for ((x, y), name) in marks {
        let width = width_of(name, SIZE);
        let mut best: Option<(f64, LabelPlace, Area)> = None;
        for (number, (dx, dy, anchor)) in candidates().enumerate() {
            let at = (x + dx, y + dy + 4.0);
            let left = match anchor {
                Anchor::Left => at.0,
                Anchor::Middle => at.0 - width / 2.0,
                Anchor::Right => at.0 - width,
            };
            let area = (left, at.1 - 11.0, left + width, at.1 + 4.0);
            let outside = (inside.0 - area.0).max(0.0)
                + (area.2 - inside.2).max(0.0)
                + (inside.1 - area.1).max(0.0)
                + (area.3 - inside.3).max(0.0);
            let covered: f64 = taken.iter().map(|other| overlap(area, *other)).sum();
            // Of equally free places the nearest to the mark.
            let cost = 100.0 * outside + covered + 0.5 * number as f64;
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                let far = dx.hypot(dy) > 22.0;
                best = Some((cost, LabelPlace { at, anchor, far }, area));
            }
        }
        if let Some((_, place, area)) = best {
            taken.push(area);
            places.push(place);
        }
    }
    places
}

/// Returns the offsets from a mark, near ones first.
fn candidates() -> impl Iterator<Item = (f64, f64, Anchor)> {
    [0.0, 14.0, 28.0, 44.0, 62.0].into_iter().flat_map(|more| {
        [
            (11.0 + more, -10.0 - more / 2.0, Anchor::Left),
            (11.0 + more, 12.0 + more / 2.0, Anchor::Left),
            (-11.0 - more, -10.0 - more / 2.0, Anchor::Right),
            (-11.0 - more, 12.0 + more / 2.0, Anchor::Right),
            (0.0, -16.0 - more, Anchor::Middle),
            (0.0, 18.0 + more, Anchor::Middle),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_a_crowd_do_not_cover_each_other() {
        let marks: Vec<_> =
            (0..6).map(|i| ((200.0 + 4.0 * f64::from(i), 150.0), "resnet8-lite-1d")).collect();
        let places = place(&marks, (0.0, 0.0, 600.0, 300.0), &[]);
        let area = |p: &LabelPlace| {
            let width = width_of("resnet8-lite-1d", SIZE);
            let left = match p.anchor {
                Anchor::Left => p.at.0,
                Anchor::Middle => p.at.0 - width / 2.0,
                Anchor::Right => p.at.0 - width,
            };
            (left, p.at.1 - 11.0, left + width, p.at.1 + 4.0)
        };
        for (i, a) in places.iter().enumerate() {
            for b in &places[..i] {
                assert_eq!(overlap(area(a), area(b)), 0.0, "{a:?} {b:?}");
            }
        }
    }
}
