//! Training, and scores with few samples.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Canvas, Stroke};
use taxel_report::chart::{Chart, HEADING};
use taxel_report::numbers::{digits, tick};
use taxel_report::palette::{Ink, Paint};

use super::look::{LineLook, legend, legend_height, look, shown};
use crate::report::names::chart;
use crate::report::words::few_samples_of;
use crate::values::{EpochPoint, Judged, Judgement, Primary};

const WIDTH: f64 = 860.0;

/// A value of an epoch, where it has one.
type EpochValue = fn(&EpochPoint) -> Option<f64>;

/// Heading, unit, on training and on validation samples.
type TrainingPanel = (String, String, EpochValue, EpochValue);

fn panels(primary: &Primary) -> [TrainingPanel; 2] {
    let unit = match primary.unit() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    [
        ("loss".into(), String::new(), |p| Some(p.train_loss), |p| p.validation_loss),
        (primary.axis(), unit, |p| Some(p.train_score), |p| p.validation_score),
    ]
}

/// Draws loss and primary metric by epoch.
pub(super) fn training(judgement: &Judgement) -> Option<Chart<'_>> {
    let trained: Vec<&Judged> = shown(judgement).filter(|n| n.training.len() > 1).collect();
    if trained.is_empty() {
        return None;
    }
    let validated = trained.iter().any(|n| n.training.iter().any(|p| p.validation_loss.is_some()));
    let mut reading = String::from("Mean over folds, on training samples.");
    if validated {
        reading += " Thin: on validation samples, which are not trained on.";
    }
    let draw = move |paint| draw_training(judgement, &trained, paint);
    Some(Chart::new(chart::TRAINING, "Training", reading, draw))
}

fn draw_training(judgement: &Judgement, trained: &[&Judged], paint: Paint) -> Canvas {
    let names: Vec<(&str, LineLook)> =
        trained.iter().map(|n| n.results.network.as_str()).map(|n| (n, look(judgement, n))).collect();
    let top = 12.0 + legend_height(WIDTH - 60.0, &names);
    let mut canvas = Canvas::new(WIDTH, top + 320.0, paint);
    legend(&mut canvas, (56.0, 14.0), WIDTH - 60.0, &names);
    let epochs = trained.iter().map(|n| n.training.len()).max().unwrap_or(1) as f64;
    for (panel, (title, unit, train, validation)) in panels(&judgement.primary()).into_iter().enumerate() {
        let left = 56.0 + 430.0 * panel as f64;
        let points = || trained.iter().flat_map(|n| &n.training);
        let values: Vec<f64> = points().flat_map(|p| [train(p), validation(p)]).flatten().collect();
        let frame = PlotFrame {
            x: AxisScale::linear((1.0, epochs), (left, left + 360.0)),
            y: AxisScale::linear(widened(&values, (0.0, f64::INFINITY)), (top + 264.0, top + 34.0)),
        };
        canvas.text((left, top + 20.0), &title, HEADING);
        frame.draw_y(&mut canvas, tick);
        let ticks: Vec<f64> = frame.x.ticks().into_iter().filter(|v| v.fract() == 0.0).collect();
        frame.draw_x(&mut canvas, &ticks, tick);
        frame.titles(&mut canvas, "epoch", "");
        for ((network, look), record) in names.iter().zip(trained) {
            for (value, width, of) in [(train, 2.0, "training"), (validation, 1.0, "validation")] {
                let known = |p: &EpochPoint| value(p).filter(|v| v.is_finite()).map(|v| (p.epoch + 1, v));
                let points: Vec<(usize, f64)> = record.training.iter().filter_map(known).collect();
                let Some((_, last)) = points.last().copied() else { continue };
                let about = format!("{network}, {of}: {}{unit} in the last epoch", digits(last));
                let line = points.iter().map(|(epoch, v)| frame.at(*epoch as f64, *v)).collect();
                canvas.hover(&about, |canvas| canvas.path(line, look.stroke(width)));
            }
        }
    }
    canvas
}

/// A network with its rows of a learning curve, by the number of training samples of each class.
type Curve<'a> = (&'a str, Vec<(usize, &'a Judged)>);

/// Draws the scores by the number of training samples of each class.
pub(super) fn few_samples(judgement: &Judgement) -> Option<Chart<'_>> {
    let mut curves: Vec<Curve> = vec![];
    for n in &judgement.networks {
        let Some(count) = n.results.per_class else { continue };
        let name = few_samples_of(&n.results);
        match curves.iter_mut().find(|(known, _)| *known == name) {
            Some((_, points)) => points.push((count, n)),
            None => curves.push((name, vec![(count, n)])),
        }
    }
    if curves.iter().all(|(_, points)| points.len() < 2) {
        return None;
    }
    let (heading, stratum) = (judgement.primary().heading(), judgement.primary().stratum());
    let reading = format!(
        "{heading} against the number of training samples of each {stratum}; whiskers: 95 % interval. Dashed: baselines."
    );
    let draw = move |paint| draw_few(judgement, &curves, paint);
    Some(Chart::new(chart::FEW_SAMPLES, format!("{heading} with few samples"), reading, draw))
}

fn draw_few(judgement: &Judgement, curves: &[Curve], paint: Paint) -> Canvas {
    let look_of = |points: &[(usize, &Judged)]| {
        let most = points.iter().max_by_key(|(count, _)| *count);
        most.map_or(look(judgement, ""), |(_, n)| look(judgement, &n.results.network))
    };
    let names: Vec<(&str, LineLook)> = curves.iter().map(|(name, points)| (*name, look_of(points))).collect();
    let top = 12.0 + legend_height(WIDTH - 80.0, &names);
    let mut canvas = Canvas::new(WIDTH, top + 400.0, paint);
    legend(&mut canvas, (64.0, 14.0), WIDTH - 80.0, &names);
    let mut counts: Vec<usize> = curves.iter().flat_map(|(_, points)| points.iter().map(|p| p.0)).collect();
    counts.sort_unstable();
    counts.dedup();
    let ends = (counts.first().copied().unwrap_or(1) as f64, counts.last().copied().unwrap_or(1) as f64);
    let ends_of = |n: &Judged| n.results.interval.or(n.results.primary().map(|score| [score; 2]));
    let all = curves.iter().flat_map(|(_, points)| points.iter().filter_map(|(_, n)| ends_of(n)).flatten());
    let values: Vec<f64> = all.chain([judgement.chance]).collect();
    let primary = judgement.primary();
    let frame = PlotFrame {
        x: AxisScale::log(ends, (64.0, WIDTH - 24.0)),
        y: AxisScale::linear(widened(&values, primary.range()), (top + 350.0, top + 30.0)),
    };
    frame.draw_y(&mut canvas, tick);
    let counts: Vec<f64> = counts.into_iter().map(|count| count as f64).collect();
    frame.draw_x(&mut canvas, &counts, tick);
    let stratum = primary.stratum();
    frame.titles(&mut canvas, &format!("training samples of each {stratum} (log)"), &primary.axis());
    let y = frame.y.at(judgement.chance);
    canvas.line((64.0, y), (WIDTH - 24.0, y), Stroke::of(Ink::Muted, 1.0).dashed((2.0, 4.0)));
    for ((name, points), (_, look)) in curves.iter().zip(&names) {
        let known: Vec<(usize, f64, &Judged)> =
            points.iter().filter_map(|(count, n)| Some((*count, n.results.primary()?, *n))).collect();
        canvas.path(known.iter().map(|(c, a, _)| frame.at(*c as f64, *a)).collect(), look.stroke(2.0));
        for (count, score, n) in known {
            let (x, y) = frame.at(count as f64, score);
            let about = format!("{name}, {count} of each {stratum}: {}", primary.value(score));
            canvas.hover(&about, |canvas| {
                if let Some([low, high]) = n.results.interval {
                    canvas.line((x, frame.y.at(low)), (x, frame.y.at(high)), Stroke::of(look.ink, 1.0));
                }
                canvas.circle((x, y), 4.0, look.ink, Ink::Paper);
            });
        }
    }
    canvas
}
