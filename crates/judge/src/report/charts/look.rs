//! How each network looks in all charts, and the legend that says so.

use taxel_report::canvas::{Canvas, PLAIN, Stroke, short, width_of};
use taxel_report::palette::{Ink, Paint, SERIES};

use crate::report::words::is_shown;
use crate::values::{Judged, Judgement};

/// How lines and marks of one network look in all charts: networks in solid lines, baselines dashed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LineLook {
    pub ink: Ink,
    dash: (f64, f64),
}

impl LineLook {
    pub fn stroke(self, width: f64) -> Stroke {
        Stroke::of(self.ink, width).dashed(self.dash)
    }
}

/// Returns the look of the network called `name`.
pub(super) fn look(judgement: &Judgement, name: &str) -> LineLook {
    let shown = judgement.networks.iter().filter(|n| is_shown(judgement, n));
    let (number, baseline) = shown
        .enumerate()
        .find(|(_, n)| n.results.network == name)
        .map_or((0, false), |(i, n)| (i, n.baseline));
    let dash = match (baseline, number >= SERIES) {
        (true, _) => (5.0, 3.0),
        (false, true) => (10.0, 3.0),
        (false, false) => (0.0, 0.0),
    };
    LineLook { ink: Ink::Series(number), dash }
}

/// Draws a line and a name for each of `names`, in rows of at most `width`. Returns the height of all.
pub(super) fn legend(canvas: &mut Canvas, at: (f64, f64), width: f64, names: &[(&str, LineLook)]) -> f64 {
    let (mut x, mut y) = (0.0, 0.0);
    for (name, look) in names {
        let name = short(name, 28);
        let width_of_entry = 40.0 + width_of(&name, 12);
        if x > 0.0 && x + width_of_entry > width {
            (x, y) = (0.0, y + 20.0);
        }
        let (left, middle) = (at.0 + x, at.1 + y);
        canvas.line((left, middle), (left + 22.0, middle), look.stroke(2.5));
        canvas.text((left + 28.0, middle + 4.0), &name, PLAIN);
        x += width_of_entry;
    }
    y + 20.0
}

/// Returns the height that [`legend`] takes.
pub(super) fn legend_height(width: f64, names: &[(&str, LineLook)]) -> f64 {
    legend(&mut Canvas::new(0.0, 0.0, Paint::Print), (0.0, 0.0), width, names)
}

/// Returns networks and baselines of the first table.
pub(super) fn shown(judgement: &Judgement) -> impl Iterator<Item = &Judged> {
    judgement.networks.iter().filter(move |n| is_shown(judgement, n))
}
