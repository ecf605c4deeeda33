//! Reliability of answers, and what is right among the surest.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Canvas, Stroke};
use taxel_report::chart::Chart;
use taxel_report::numbers::{tenth, tick};
use taxel_report::palette::{Ink, Paint};

use super::look::{LineLook, legend, legend_height, look};
use crate::report::names::chart;
use crate::values::{Judgement, MAJORITY, RowCertainty};

const WIDTH: f64 = 860.0;
/// Left and right end of the shares.
const ENDS: (f64, f64) = (64.0, WIDTH - 24.0);

/// Returns the rows that are drawn: all but the one that always gives the same answer.
fn drawn(judgement: &Judgement) -> Vec<(&RowCertainty, LineLook)> {
    let is_majority =
        |row: &&RowCertainty| judgement.network(&row.network).is_some_and(|n| n.results.zoo == MAJORITY);
    let rows = judgement.certainty.iter().filter(|row| !is_majority(row));
    rows.map(|row| (row, look(judgement, &row.network))).collect()
}

/// Draws how often answers are right against how sure they are.
pub(super) fn reliability(judgement: &Judgement) -> Option<Chart<'_>> {
    let rows = drawn(judgement);
    if rows.is_empty() {
        return None;
    }
    let reading = "The share of answers that is right against their mean probability, in bins of equal width, each part at the \
                   temperature of the others. On the dotted line answers are right as often as they say; below it they are too \
                   sure. Dots are larger where there are more answers.";
    let draw = move |paint| {
        lines(
            &rows,
            paint,
            ("mean probability of the answers (%)", "right (%)"),
            |canvas, frame, row, look| {
                let all: usize = row.reliability.bins.iter().map(|bin| bin.answers).sum();
                let place = |sure: f64, right: f64| frame.at(100.0 * sure, 100.0 * right);
                canvas.path(
                    row.reliability.bins.iter().map(|bin| place(bin.sure, bin.right)).collect(),
                    look.stroke(1.5),
                );
                for bin in &row.reliability.bins {
                    let radius = 2.0 + 8.0 * (bin.answers as f64 / all.max(1) as f64).sqrt();
                    let (sure, right) = (tenth(100.0 * bin.sure), tenth(100.0 * bin.right));
                    let about =
                        format!("{}: {} answers, {sure} % sure, {right} % right", row.network, bin.answers);
                    let (x, y) = place(bin.sure, bin.right);
                    canvas.hover(&about, |canvas| canvas.circle((x, y), radius, look.ink, Ink::Paper));
                }
            },
            |canvas, frame| {
                canvas.line(
                    frame.at(0.0, 0.0),
                    frame.at(100.0, 100.0),
                    Stroke::of(Ink::Muted, 1.0).dashed((1.0, 3.0)),
                );
            },
            (0.0, 100.0),
        )
    };
    Some(Chart::new(chart::RELIABILITY, "Are answers right as often as they say?", reading, draw))
}

/// Draws what is right among the surest answers.
pub(super) fn surest(judgement: &Judgement) -> Option<Chart<'_>> {
    let rows: Vec<_> =
        drawn(judgement).into_iter().filter(|(row, _)| row.reliability.surest.len() == 10).collect();
    if rows.is_empty() {
        return None;
    }
    let shares = rows.iter().flat_map(|(row, _)| row.reliability.surest.iter().map(|right| 100.0 * right));
    let range = widened(&shares.collect::<Vec<_>>(), (0.0, 100.0));
    let reading = "The share that is right if only the surest answers are given: risk and coverage. A line that rises to the left \
                   knows which of its answers are wrong.";
    let draw = move |paint| {
        lines(
            &rows,
            paint,
            ("answers that are given, the surest first (%)", "right (%)"),
            |canvas, frame, row, look| {
                let place = |(at, right): (usize, &f64)| frame.at(10.0 * (at + 1) as f64, 100.0 * right);
                canvas.path(row.reliability.surest.iter().enumerate().map(place).collect(), look.stroke(2.0));
                for point in row.reliability.surest.iter().enumerate() {
                    let about = format!(
                        "{}, the surest {} %: {} % right",
                        row.network,
                        10 * (point.0 + 1),
                        tenth(100.0 * point.1)
                    );
                    canvas.hover(&about, |canvas| canvas.circle(place(point), 3.0, look.ink, Ink::Paper));
                }
            },
            |_, _| {},
            range,
        )
    };
    Some(Chart::new(chart::SUREST, "What is right among the surest answers", reading, draw))
}

/// Draws a line for each row over a share from 0 to 100 %, with values in `range`.
fn lines(
    rows: &[(&RowCertainty, LineLook)],
    paint: Paint,
    (x, y): (&str, &str),
    draw: impl Fn(&mut Canvas, &PlotFrame, &RowCertainty, LineLook),
    below: impl Fn(&mut Canvas, &PlotFrame),
    range: (f64, f64),
) -> Canvas {
    let names: Vec<(&str, LineLook)> = rows.iter().map(|(row, look)| (row.network.as_str(), *look)).collect();
    let top = 12.0 + legend_height(WIDTH - 80.0, &names);
    let mut canvas = Canvas::new(WIDTH, top + 400.0, paint);
    legend(&mut canvas, (64.0, 14.0), WIDTH - 80.0, &names);
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, 100.0), ENDS),
        y: AxisScale::linear(range, (top + 350.0, top + 30.0)),
    };
    frame.draw_y(&mut canvas, tick);
    let shares: Vec<f64> = (0..=10).map(|tenth| 10.0 * f64::from(tenth)).collect();
    frame.draw_x(&mut canvas, &shares, tick);
    frame.titles(&mut canvas, x, y);
    below(&mut canvas, &frame);
    for (row, look) in rows {
        draw(&mut canvas, &frame, row, *look);
    }
    canvas
}
