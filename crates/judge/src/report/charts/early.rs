//! Scores by the share of a sample that is there.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Canvas, Stroke};
use taxel_report::chart::Chart;
use taxel_report::numbers::tick;
use taxel_report::palette::{Ink, Paint};

use super::look::{LineLook, legend, legend_height, look};
use crate::report::names::chart;
use crate::report::words::early_basis;
use crate::values::{Early, EarlyNetwork, Judgement, MAJORITY};

const WIDTH: f64 = 860.0;
/// Left and right end of the shares.
const ENDS: (f64, f64) = (64.0, WIDTH - 24.0);

/// Draws one line per network, from the first tenth to the whole sample.
pub(super) fn shares(judgement: &Judgement) -> Option<Chart<'_>> {
    let early = judgement.early.as_ref().filter(|early| !early.networks.is_empty())?;
    let reading = format!(
        "{} against the share of a sample that is there: {}. Dashed lines: baselines; dotted: {}.",
        judgement.primary().heading(),
        early_basis(early),
        judgement.primary().chance()
    );
    let title = format!("{} of early decisions", judgement.primary().heading());
    Some(Chart::new(chart::EARLY, title, reading, move |paint| draw(judgement, early, paint)))
}

fn draw(judgement: &Judgement, early: &Early, paint: Paint) -> Canvas {
    // Always naming the commonest class is the line of chance.
    let majority = judgement.networks.iter().find(|n| n.results.zoo == MAJORITY);
    let drawn = early.networks.iter().filter(|n| majority.is_none_or(|m| m.results.network != n.network));
    let drawn: Vec<(&EarlyNetwork, LineLook)> = drawn.map(|n| (n, look(judgement, &n.network))).collect();
    let names: Vec<(&str, LineLook)> = drawn.iter().map(|(n, look)| (n.network.as_str(), *look)).collect();
    let top = 12.0 + legend_height(WIDTH - 80.0, &names);
    let mut canvas = Canvas::new(WIDTH, top + 400.0, paint);
    legend(&mut canvas, (64.0, 14.0), WIDTH - 80.0, &names);
    let values: Vec<f64> = drawn.iter().flat_map(|(n, _)| n.points.iter().map(|point| point.score)).collect();
    let values = [values, vec![judgement.chance]].concat();
    let primary = judgement.primary();
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, 100.0), ENDS),
        y: AxisScale::linear(widened(&values, primary.range()), (top + 350.0, top + 30.0)),
    };
    frame.draw_y(&mut canvas, tick);
    let shares: Vec<f64> = (0..=10).map(|tenth| 10.0 * f64::from(tenth)).collect();
    frame.draw_x(&mut canvas, &shares, tick);
    frame.titles(&mut canvas, "share of the sample that is there (%)", &primary.axis());
    let chance = frame.y.at(judgement.chance);
    canvas.line((ENDS.0, chance), (ENDS.1, chance), Stroke::of(Ink::Muted, 1.0).dashed((1.0, 3.0)));
    for (network, look) in drawn {
        let place = |seen: u8, score: f64| frame.at(f64::from(seen), score);
        canvas.path(network.points.iter().map(|p| place(p.seen, p.score)).collect(), look.stroke(2.0));
        for point in &network.points {
            let about = format!("{}, {} % seen: {}", network.network, point.seen, primary.value(point.score));
            canvas.hover(&about, |canvas| {
                canvas.circle(place(point.seen, point.score), 3.5, look.ink, Ink::Paper);
            });
        }
    }
    canvas
}
