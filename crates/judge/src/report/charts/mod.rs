//! Charts, each drawn twice from one description: for the page in the colours of its theme, and for files.

mod bars;
mod confusion;
mod curves;
mod faults;
mod labels;
mod ranks;
mod tradeoff;

pub(super) use ranks::ranks;

use super::canvas::{Canvas, PLAIN, Stroke, Type, short, width_of};
use super::palette::{Ink, Paint, SERIES};
use super::words::is_shown;
use crate::choice::Choice;
use crate::judgement::{Judged, Judgement};

/// A chart with all that is said about it.
pub(super) struct Chart<'a> {
    /// Name of its files.
    pub name: String,
    /// Heading.
    pub title: String,
    /// How to read it; screen readers hear it in place of the drawing.
    pub reading: String,
    draw: Box<dyn Fn(Paint) -> Canvas + Sync + 'a>,
}

impl<'a> Chart<'a> {
    fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        reading: impl Into<String>,
        draw: impl Fn(Paint) -> Canvas + Sync + 'a,
    ) -> Self {
        Chart { name: name.into(), title: title.into(), reading: reading.into(), draw: Box::new(draw) }
    }

    /// The drawing.
    pub(super) fn canvas(&self, paint: Paint) -> Canvas {
        (self.draw)(paint)
    }
}

/// Every chart that there is something to draw for.
pub(super) fn charts<'a>(judgement: &'a Judgement, choice: Option<&'a Choice>) -> Vec<Chart<'a>> {
    let mut all = tradeoff::charts(judgement, choice);
    all.extend(bars::times(judgement));
    all.extend(faults::curves(judgement));
    all.extend(faults::heat(judgement));
    all.extend(bars::calibration(judgement));
    all.extend(curves::training(judgement));
    all.extend(curves::few_samples(judgement));
    all.extend(confusion::charts(judgement));
    all.extend(bars::weight_changes(judgement));
    all
}

/// How lines and marks of one network look in all charts: networks in solid lines, baselines dashed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Look {
    ink: Ink,
    dash: (f64, f64),
}

impl Look {
    fn stroke(self, width: f64) -> Stroke {
        Stroke::of(self.ink, width).dashed(self.dash)
    }
}

/// The look of the network called `name`.
fn look(judgement: &Judgement, name: &str) -> Look {
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
    Look { ink: Ink::Series(number), dash }
}

/// One line and name for each of `names`, in rows of at most `width`; the height that was taken.
fn legend(canvas: &mut Canvas, at: (f64, f64), width: f64, names: &[(&str, Look)]) -> f64 {
    let (mut x, mut y) = (0.0, 0.0);
    for (name, look) in names {
        let name = short(name, 28);
        let own = 40.0 + width_of(&name, 12);
        if x > 0.0 && x + own > width {
            (x, y) = (0.0, y + 20.0);
        }
        let (left, middle) = (at.0 + x, at.1 + y);
        canvas.line((left, middle), (left + 22.0, middle), look.stroke(2.5));
        canvas.text((left + 28.0, middle + 4.0), &name, PLAIN);
        x += own;
    }
    y + 20.0
}

/// Rows that [`legend`] takes.
fn legend_height(width: f64, names: &[(&str, Look)]) -> f64 {
    legend(&mut Canvas::new(0.0, 0.0, Paint::Print), (0.0, 0.0), width, names)
}

/// Contestants: networks and baselines of the first table.
fn shown(judgement: &Judgement) -> impl Iterator<Item = &Judged> {
    judgement.networks.iter().filter(move |n| is_shown(judgement, n))
}

/// A heading inside a chart.
const HEADING: Type = Type { size: 13, bold: true, ..PLAIN };
