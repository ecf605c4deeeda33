//! Scores by the number of training recordings, with the fitted law.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Canvas, Stroke};
use taxel_report::chart::Chart;
use taxel_report::numbers::{digits, tick};
use taxel_report::palette::{Ink, Paint};

use super::look::look;
use crate::report::names::chart;
use crate::values::{CurveLaw, Judgement, LearningCurve};

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 330.0;
/// Places of the drawn law.
const STEPS: usize = 60;

/// Draws the scores of each number of training recordings, and the law beyond them.
pub(super) fn curve(judgement: &Judgement) -> Option<Chart<'_>> {
    let curve = judgement.learning_curve.as_ref().filter(|curve| curve.points.len() > 1)?;
    let heading = judgement.primary().heading();
    let reading = format!(
        "{heading} of {} against the number of training recordings, tested on inner folds of the training parts. Small dots: folds. \
         Line: fitted power law, dashed beyond them. Ring: the run itself, on its test parts, which the law has not seen.",
        curve.network
    );
    let title = format!("{heading} with fewer and more recordings");
    Some(Chart::new(chart::LEARNING_CURVE, title, reading, move |paint| draw(judgement, curve, paint)))
}

fn draw(judgement: &Judgement, curve: &LearningCurve, paint: Paint) -> Canvas {
    let primary = judgement.primary();
    let mut canvas = Canvas::new(WIDTH, HEIGHT, paint);
    let counts: Vec<f64> = curve.points.iter().map(|point| point.count).collect();
    let (first, last) = (counts[0], counts[counts.len() - 1]);
    let from = curve.whole.as_ref().map_or(last, |whole| whole.count);
    let most = curve
        .law
        .as_ref()
        .map_or(from, |law| from + law.gains.iter().map(|gain| gain.more).fold(0.0, f64::max));
    let score_at = |law: &CurveLaw, count: f64| {
        let error = law.floor + law.scale * count.powf(-law.rate);
        if primary.is_percent() { 100.0 - error } else { error }
    };
    let mut values: Vec<f64> = curve.points.iter().flat_map(|point| point.scores.iter().copied()).collect();
    values.extend(curve.whole.iter().map(|whole| whole.score));
    values.extend(curve.law.iter().map(|law| score_at(law, most)));
    let frame = PlotFrame {
        x: AxisScale::log((first, most), (64.0, WIDTH - 24.0)),
        y: AxisScale::linear(widened(&values, primary.range()), (HEIGHT - 50.0, 20.0)),
    };
    frame.draw_y(&mut canvas, tick);
    let mut ticks = counts;
    ticks.extend(curve.whole.iter().map(|whole| whole.count));
    if most > from {
        ticks.push(most);
    }
    frame.draw_x(&mut canvas, &ticks, digits);
    let of_each = if curve.per.is_empty() { String::new() } else { format!(" of each {}", curve.per) };
    frame.titles(&mut canvas, &format!("training recordings{of_each} (log)"), &primary.axis());
    let look = look(judgement, &curve.network);
    if let Some(law) = &curve.law {
        let line = |from: f64, to: f64| -> Vec<(f64, f64)> {
            let place = |step: usize| from * (to / from).powf(step as f64 / STEPS as f64);
            (0..=STEPS).map(place).map(|count| frame.at(count, score_at(law, count))).collect()
        };
        canvas.path(line(first, last), Stroke::of(look.ink, 2.0));
        canvas.path(line(last, most), Stroke::of(look.ink, 2.0).dashed((4.0, 4.0)));
    }
    for point in &curve.points {
        for score in &point.scores {
            canvas.circle(frame.at(point.count, *score), 1.5, Ink::Muted, Ink::Muted);
        }
        let about = format!("{} recordings{of_each}: {}", digits(point.count), primary.value(point.score));
        canvas.hover(&about, |canvas| {
            canvas.circle(frame.at(point.count, point.score), 4.0, look.ink, Ink::Paper)
        });
    }
    if let Some(whole) = &curve.whole {
        let about = format!(
            "{} recordings{of_each}, test parts of the run: {}",
            digits(whole.count),
            primary.value(whole.score)
        );
        canvas.hover(&about, |canvas| {
            canvas.circle(frame.at(whole.count, whole.score), 5.0, Ink::Paper, look.ink);
        });
    }
    canvas
}
