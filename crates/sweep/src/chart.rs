//! Chart of one varied key: mean score for each value, with its range.

use taxel_judge::Primary;
use taxel_report::axes::{AxisScale, widened};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, ends};
use taxel_report::chart::Chart;
use taxel_report::files::slug;
use taxel_report::numbers::tick;
use taxel_report::palette::{Ink, Paint, SERIES};

use crate::collected::KeyEffect;

const WIDTH: f64 = 860.0;
/// Width of the names at the left.
const NAMES: f64 = 300.0;
const ROW: f64 = 24.0;
const TOP: f64 = 12.0;

/// Draws one row per network and value: a dot at the mean, a line from the least to the most.
pub(crate) fn axis(axis: &KeyEffect) -> Chart<'_> {
    let reading = format!(
        "{} by {}: dots are means over the trials that have the value, lines go from the least to the most.",
        in_unit(&axis.primary),
        axis.key
    );
    let title = format!("{} by {}", axis.primary.heading(), axis.key);
    Chart::new(name_of(axis), title, reading, move |paint| draw(axis, paint))
}

/// Returns the name of the files of an axis: a key that several metrics are shown for has files of each.
pub(crate) fn name_of(axis: &KeyEffect) -> String {
    let name = format!("axis-{}", slug(&axis.key));
    if axis.primary.is_accuracy() { name } else { format!("{name}-{}", slug(&axis.primary.head())) }
}

/// Returns the metric with its unit: `Accuracy in %`, `MAE in N`.
fn in_unit(primary: &Primary) -> String {
    let unit = if primary.unit().is_empty() { String::new() } else { format!(" in {}", primary.unit()) };
    primary.heading() + &unit
}

/// Returns the range of the axis, from a little below the least score; up to 100 of a percentage.
fn range(axis: &KeyEffect) -> (f64, f64) {
    let least = axis.rows.iter().map(|(_, _, score)| score.least);
    if axis.primary.is_percent() {
        return ((least.fold(100.0, f64::min) - 2.0).max(0.0), 100.0);
    }
    let most = axis.rows.iter().map(|(_, _, score)| score.most);
    widened(&least.chain(most).collect::<Vec<_>>(), axis.primary.range())
}

fn draw(axis: &KeyEffect, paint: Paint) -> Canvas {
    let bottom = TOP + ROW * axis.rows.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 46.0, paint);
    let primary = &axis.primary;
    let x = AxisScale::linear(range(axis), (NAMES, WIDTH - 60.0));
    let title = [primary.title(), primary.unit()].join(", ");
    x.draw_grid(&mut canvas, (TOP, bottom), title.trim_end_matches(", "), tick);
    let mut networks: Vec<&str> = vec![];
    for (row, (network, value, score)) in axis.rows.iter().enumerate() {
        let series = networks.iter().position(|known| known == network).unwrap_or_else(|| {
            networks.push(network);
            networks.len() - 1
        });
        let ink = Ink::Series(series % SERIES);
        let y = TOP + ROW * (row as f64 + 0.5);
        let label = format!("{} · {}", ends(network, 22), ends(value, 22));
        canvas.text((NAMES - 10.0, y + 4.0), &label, TextStyle { anchor: Anchor::Right, ..PLAIN });
        let hover = format!(
            "{network}, {} = {value}: {}, {} trials",
            axis.key,
            primary.value(score.mean),
            score.count
        );
        canvas.hover(&hover, |canvas| {
            canvas.line((x.at(score.least), y), (x.at(score.most), y), Stroke::of(ink, 2.0));
            canvas.circle((x.at(score.mean), y), 5.0, ink, Ink::Paper);
        });
    }
    canvas
}
