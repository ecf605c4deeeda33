//! Predicted values against the true ones.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Canvas, Stroke};
use taxel_report::chart::Chart;
use taxel_report::numbers::tick;
use taxel_report::palette::{Ink, Paint};

use super::look::{LineLook, legend, legend_height, look};
use crate::report::names::chart;
use crate::values::{Judgement, QuantityErrors, RowErrors};

const SIDE: f64 = 560.0;

/// Draws for each quantity what the best method says against what is true.
pub(super) fn scatters(judgement: &Judgement) -> Vec<Chart<'_>> {
    let primary = judgement.primary();
    let score = |row: &&RowErrors| judgement.network(&row.network).and_then(|network| network.score());
    let scored = judgement.errors.iter().filter(|row| score(row).is_some());
    let best =
        scored.max_by(|a, b| primary.order(score(a).unwrap_or(f64::NAN), score(b).unwrap_or(f64::NAN)));
    let Some(best) = best else { return vec![] };
    let look = look(judgement, &best.network);
    best.quantities.iter().map(|quantity| scatter(&best.network, quantity, look)).collect()
}

fn scatter<'a>(network: &'a str, quantity: &'a QuantityErrors, look: LineLook) -> Chart<'a> {
    let QuantityErrors { name, unit, points, interval, .. } = quantity;
    let with_unit = unit.as_ref().map_or(name.clone(), |unit| format!("{name} ({unit})"));
    let reading = format!(
        "What {network}, the best method, says of {name} against the true value, for test samples. On the dotted line both are \
         equal; the dashed lines are as far from it as the mean interval of 90 % reaches."
    );
    let half = interval.map(|interval| interval.width / 2.0);
    let (file, title) = (format!("{}{name}", chart::VALUES), format!("{with_unit}: predicted against true"));
    Chart::new(file, title, reading, move |paint| draw(network, &with_unit, points, (half, look), paint))
}

fn draw(
    network: &str,
    quantity: &str,
    points: &[[f32; 2]],
    (half, look): (Option<f64>, LineLook),
    paint: Paint,
) -> Canvas {
    let names = [(network, look)];
    let top = 12.0 + legend_height(SIDE - 80.0, &names);
    let mut canvas = Canvas::new(SIDE + 60.0, top + SIDE - 10.0, paint);
    legend(&mut canvas, (64.0, 14.0), SIDE - 80.0, &names);
    let all: Vec<f64> = points.iter().flatten().map(|value| f64::from(*value)).collect();
    let range = widened(&all, (f64::NEG_INFINITY, f64::INFINITY));
    let frame = PlotFrame {
        x: AxisScale::linear(range, (64.0, SIDE + 36.0)),
        y: AxisScale::linear(range, (top + SIDE - 60.0, top + 30.0)),
    };
    frame.draw_y(&mut canvas, tick);
    frame.draw_x(&mut canvas, &frame.x.ticks(), tick);
    frame.titles(&mut canvas, &format!("true {quantity}"), &format!("predicted {quantity}"));
    let (low, high) = range;
    let mut line = |offset: f64, dash: (f64, f64)| {
        let from = (low.max(low - offset), high.min(high - offset));
        let ends = [from.0, from.1].map(|x| frame.at(x, x + offset));
        canvas.line(ends[0], ends[1], Stroke::of(Ink::Muted, 1.0).dashed(dash));
    };
    line(0.0, (1.0, 3.0));
    if let Some(half) = half.filter(|half| *half < high - low) {
        line(half, (6.0, 4.0));
        line(-half, (6.0, 4.0));
    }
    for &[truth, predicted] in points {
        let place = frame.at(f64::from(truth), f64::from(predicted));
        let about = format!("true {truth:.3}, predicted {predicted:.3}");
        canvas.hover(&about, |canvas| canvas.circle(place, 2.5, look.ink, Ink::Paper));
    }
    canvas
}
