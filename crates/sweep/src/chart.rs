//! What one varied key of a sweep does: mean score for each value, with its range.

use taxel_judge::Primary;
use taxel_report::axes::{Scale, widened};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, Type, ends};
use taxel_report::chart::Chart;
use taxel_report::files::slug;
use taxel_report::numbers::tick;
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
        "{} by {}: dots are means over the trials that have the value, lines go from the least to the most.",
        in_unit(&axis.primary),
        axis.key
    );
    let title = format!("{} by {}", axis.primary.heading(), axis.key);
    Chart::new(name_of(axis), title, reading, move |paint| draw(axis, paint))
}

/// Name of the files of an axis: a key that several metrics are shown for has files of each.
pub(crate) fn name_of(axis: &Axis) -> String {
    let name = format!("axis-{}", slug(&axis.key));
    if axis.primary.is_accuracy() { name } else { format!("{name}-{}", slug(&axis.primary.head())) }
}

/// `Accuracy in %`, `MAE in N`.
fn in_unit(primary: &Primary) -> String {
    let unit = if primary.unit().is_empty() { String::new() } else { format!(" in {}", primary.unit()) };
    primary.heading() + &unit
}

/// From a little below the least; up to 100 of a percentage.
fn range(axis: &Axis) -> (f64, f64) {
    let least = axis.rows.iter().map(|(_, _, own)| own.least);
    if axis.primary.is_percent() {
        return ((least.fold(100.0, f64::min) - 2.0).max(0.0), 100.0);
    }
    let most = axis.rows.iter().map(|(_, _, own)| own.most);
    widened(&least.chain(most).collect::<Vec<_>>(), axis.primary.range())
}

fn draw(axis: &Axis, paint: Paint) -> Canvas {
    let bottom = TOP + ROW * axis.rows.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 46.0, paint);
    let primary = &axis.primary;
    let x = Scale::linear(range(axis), (NAMES, WIDTH - 60.0));
    for value in x.ticks() {
        let at = x.at(value);
        canvas.line((at, TOP), (at, bottom), Stroke::of(Ink::Grid, 1.0));
        let look = Type { ink: Ink::Muted, anchor: Anchor::Middle, ..PLAIN };
        canvas.text((at, bottom + 17.0), &tick(value), look);
    }
    let middle = (NAMES + WIDTH - 60.0) / 2.0;
    let title = [primary.title(), primary.unit()].join(", ");
    let title = title.trim_end_matches(", ").to_string();
    canvas.text((middle, bottom + 36.0), &title, Type { anchor: Anchor::Middle, ..PLAIN });
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
        let hover =
            format!("{network}, {} = {value}: {}, {} trials", axis.key, primary.value(own.mean), own.count);
        canvas.hover(&hover, |canvas| {
            canvas.line((x.at(own.least), y), (x.at(own.most), y), Stroke::of(ink, 2.0));
            canvas.circle((x.at(own.mean), y), 5.0, ink, Ink::Paper);
        });
    }
    canvas
}
