//! The primary metric against what is left of one thing: on test parts, on inner folds, and where the knee is.

use taxel_judge::Contrast;
use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, width_of};
use taxel_report::chart::Chart;
use taxel_report::files::slug;
use taxel_report::numbers::{between, tick};
use taxel_report::palette::{Ink, Paint};

use crate::shrunk::{Curve, CurveStep, Shrunk};

const WIDTH: f64 = 860.0;
/// Left and right end of the settings.
const ENDS: (f64, f64) = (64.0, WIDTH - 24.0);
/// Top and bottom of the accuracies.
const HEIGHTS: (f64, f64) = (64.0, 344.0);
/// Room between the ends and the first and the last setting.
const INSET: f64 = 30.0;

/// Draws one point per setting, the whole at the left.
pub(crate) fn curve_chart<'a>(curve: &'a Curve, shrunk: &'a Shrunk) -> Chart<'a> {
    let primary = &shrunk.primary;
    let reading = format!(
        "{} against what is left ({}). Full line: test parts, with 95 % intervals; dashed: inner folds of the training parts, \
         which are trained on less and find the knee. Dotted: {} {} the whole.",
        primary.heading(),
        curve.title.to_lowercase(),
        primary.margin(shrunk.margin),
        if primary.loss(1.0) < 0.0 { "below" } else { "above" }
    );
    let name = format!("curve-{}", slug(&curve.axis));
    Chart::new(name, curve.title.clone(), reading, move |paint| draw(curve, shrunk, paint))
}

fn draw(curve: &Curve, shrunk: &Shrunk, paint: Paint) -> Canvas {
    let (primary, whole) = (&shrunk.primary, shrunk.whole);
    // As much worse than the whole as still suffices.
    let limit = whole.0 - primary.merit(shrunk.margin);
    let mut canvas = Canvas::new(WIDTH, HEIGHTS.1 + 56.0, paint);
    let scores = |of: fn(&CurveStep) -> Option<Contrast>| {
        curve.steps.iter().map(|step| of(step).map(|contrast| contrast.score)).collect::<Vec<_>>()
    };
    let (outer, inner) = (scores(|step| step.outer), scores(|step| step.inner));
    let known = |values: &[Option<f64>]| values.iter().flatten().copied().collect::<Vec<_>>();
    // What the whole has on inner folds, from any setting beside it.
    let inner_whole =
        curve.steps.iter().find_map(|step| step.inner.map(|contrast| contrast.score - contrast.difference));
    let bars = curve.steps.iter().filter_map(|step| step.outer?.score_interval);
    let bars: Vec<f64> = bars.chain(whole.1).flatten().collect();
    let values = [known(&outer), known(&inner), bars, vec![whole.0, limit]].concat();
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, steps(curve)), (ENDS.0 + INSET, ENDS.1 - INSET)),
        y: AxisScale::linear(widened(&values, primary.range()), (HEIGHTS.1, HEIGHTS.0)),
    };
    draw_axes(&mut canvas, curve, &frame, &primary.axis());
    let limit = frame.y.at(limit);
    canvas.line((ENDS.0, limit), (ENDS.1, limit), Stroke::of(Ink::Muted, 1.0).dashed((1.0, 3.0)));
    draw_knee(&mut canvas, curve, &frame);
    let line = |first: Option<f64>, values: &[Option<f64>]| {
        let all = std::iter::once(first).chain(values.iter().copied()).enumerate();
        all.filter_map(|(at, value)| Some(frame.at(at as f64, value?))).collect::<Vec<_>>()
    };
    canvas.path(line(inner_whole, &inner), Stroke::of(Ink::Series(1), 1.6).dashed((6.0, 4.0)));
    canvas.path(line(Some(whole.0), &outer), Stroke::of(Ink::Series(0), 2.0));
    draw_points(&mut canvas, curve, shrunk, &frame);
    canvas
}

/// Returns the steps from the whole to the smallest setting.
fn steps(curve: &Curve) -> f64 {
    curve.steps.len().max(1) as f64
}

/// Draws both axes: scores, and the name of each setting below its place.
fn draw_axes(canvas: &mut Canvas, curve: &Curve, frame: &PlotFrame, scores: &str) {
    let wide = PlotFrame { x: AxisScale::linear((0.0, 1.0), ENDS), y: frame.y };
    wide.draw_y(canvas, tick);
    let names: Vec<&str> = std::iter::once(&curve.short)
        .chain(curve.steps.iter().map(|step| &step.short))
        .map(String::as_str)
        .collect();
    wide.draw_x(canvas, &[], tick);
    let step = (ENDS.1 - ENDS.0 - 2.0 * INSET) / steps(curve);
    let widest = names.iter().map(|name| width_of(name, PLAIN.size)).fold(0.0, f64::max);
    let size = if widest > step - 6.0 { 10 } else { PLAIN.size };
    for (at, name) in names.iter().enumerate() {
        let look = TextStyle { ink: Ink::Muted, anchor: Anchor::Middle, size, ..PLAIN };
        canvas.text((frame.x.at(at as f64), HEIGHTS.1 + 17.0), name, look);
    }
    wide.titles(canvas, &format!("what is left: {}", curve.title.to_lowercase()), scores);
}

fn draw_knee(canvas: &mut Canvas, curve: &Curve, frame: &PlotFrame) {
    let Some(knee) = curve.knee else { return };
    let x = frame.x.at(knee as f64 + 1.0);
    canvas.line((x, HEIGHTS.0 - 14.0), (x, HEIGHTS.1), Stroke::of(Ink::Accent, 1.2).dashed((4.0, 3.0)));
    let look = TextStyle { ink: Ink::Accent, anchor: Anchor::Middle, bold: true, ..PLAIN };
    canvas.text((x, HEIGHTS.0 - 20.0), &format!("knee: {}", curve.steps[knee].short), look);
}

/// Draws a dot with its interval for the whole and for each setting on the test parts.
fn draw_points(canvas: &mut Canvas, curve: &Curve, shrunk: &Shrunk, frame: &PlotFrame) {
    let (primary, whole) = (&shrunk.primary, shrunk.whole);
    let mut points = vec![(0, "whole".to_string(), whole.0, whole.1)];
    for (at, step) in curve.steps.iter().enumerate() {
        points.extend(
            step.outer.map(|contrast| (at + 1, step.label.clone(), contrast.score, contrast.score_interval)),
        );
    }
    for (at, label, score, interval) in points {
        let (x, y) = frame.at(at as f64, score);
        canvas.hover(
            &format!(
                "{label}: {}{}",
                primary.value(score),
                interval.map_or(String::new(), between(primary.show()))
            ),
            |canvas| {
                if let Some([low, high]) = interval {
                    let (low, high) = (frame.y.at(low), frame.y.at(high));
                    canvas.line((x, low), (x, high), Stroke::of(Ink::Soft, 2.0));
                }
                canvas.circle((x, y), 4.5, Ink::Series(0), Ink::Paper);
            },
        );
    }
}
