//! What one varied key of a sweep does: mean accuracy for each value, with its range.

use taxel_report::axes::Scale;
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, Type, ends};
use taxel_report::chart::Chart;
use taxel_report::files::slug;
use taxel_report::numbers::{tenth, tick};
use taxel_report::palette::{Ink, Paint, SERIES};

use crate::collected::Axis;

const WIDTH: f64 = 860.0;
/// Width of the names at the left.
const NAMES: f64 = 300.0;
const ROW: f64 = 24.0;
const TOP: f64 = 12.0;

/// One row per network and value: a dot at the mean, a line from the least to the most.
pub(crate) fn axis(axis: &Axis) -> Chart<'_> {
    let reading = format!(
        "Accuracy in % by {}: dots are means over the trials that have the value, lines go from the least to the most.",
        axis.key
    );
    let name = format!("axis-{}", slug(&axis.key));
    Chart::new(name, format!("Accuracy by {}", axis.key), reading, move |paint| draw(axis, paint))
}

fn draw(axis: &Axis, paint: Paint) -> Canvas {
    let bottom = TOP + ROW * axis.rows.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 46.0, paint);
    let least = axis.rows.iter().map(|(_, _, own)| own.least).fold(100.0, f64::min);
    let x = Scale::linear(((least - 2.0).max(0.0), 100.0), (NAMES, WIDTH - 60.0));
    for value in x.ticks() {
        let at = x.at(value);
        canvas.line((at, TOP), (at, bottom), Stroke::of(Ink::Grid, 1.0));
        let look = Type { ink: Ink::Muted, anchor: Anchor::Middle, ..PLAIN };
        canvas.text((at, bottom + 17.0), &tick(value), look);
    }
    let middle = (NAMES + WIDTH - 60.0) / 2.0;
    canvas.text((middle, bottom + 36.0), "accuracy, %", Type { anchor: Anchor::Middle, ..PLAIN });
    let mut networks: Vec<&str> = vec![];
    for (row, (network, value, own)) in axis.rows.iter().enumerate() {
        let series = networks.iter().position(|known| known == network).unwrap_or_else(|| {
            networks.push(network);
            networks.len() - 1
        });
        let ink = Ink::Series(series % SERIES);
        let y = TOP + ROW * (row as f64 + 0.5);
        let label = format!("{} · {}", ends(network, 22), ends(value, 22));
        canvas.text((NAMES - 10.0, y + 4.0), &label, Type { anchor: Anchor::Right, ..PLAIN });
        let hover = format!("{network}, {} = {value}: {} %, {} trials", axis.key, tenth(own.mean), own.count);
        canvas.hover(&hover, |canvas| {
            canvas.line((x.at(own.least), y), (x.at(own.most), y), Stroke::of(ink, 2.0));
            canvas.circle((x.at(own.mean), y), 5.0, ink, Ink::Paper);
        });
    }
    canvas
}
