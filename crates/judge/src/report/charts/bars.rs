//! Rows of bars: where time goes, calibration clean and broken, what training changed.

use taxel_report::axes::{AxisScale, PlotFrame};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, short};
use taxel_report::chart::{Chart, HEADING};
use taxel_report::numbers::{digits, tenth, tick};
use taxel_report::palette::{Ink, Paint};

use super::look::shown;
use crate::report::names::chart;
use crate::values::{Judged, Judgement, NetworkStress};

const WIDTH: f64 = 860.0;
/// Width of the names at the left.
const NAMES: f64 = 190.0;
const ROW: f64 = 28.0;

/// Returns a frame of `rows` rows below `top`, x from 0 to `most`, with its axis drawn.
fn rows(canvas: &mut Canvas, top: f64, rows: usize, most: f64, title: &str) -> PlotFrame {
    let bottom = top + ROW * rows as f64;
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, 1.05 * most.max(1e-12)), (NAMES, WIDTH - 60.0)),
        y: AxisScale::linear((0.0, rows as f64), (top, bottom)),
    };
    let number = |value| if most < 1e-3 { format!("{value:.1e}").replace(".0e", "e") } else { tick(value) };
    frame.x.draw_grid(canvas, (top, bottom), title, number);
    frame
}

fn name(canvas: &mut Canvas, y: f64, name: &str) {
    canvas.text((NAMES - 10.0, y + 4.0), &short(name, 24), TextStyle { anchor: Anchor::Right, ..PLAIN });
}

/// Draws the times of encoding and network.
pub(super) fn times(judgement: &Judgement) -> Option<Chart<'_>> {
    let timed: Vec<&Judged> = shown(judgement).filter(|n| n.speed.is_some()).collect();
    let encoded = timed.iter().any(|n| n.speed.is_some_and(|s| s.encoding.p50_ms > 0.0));
    if timed.is_empty() || !encoded {
        return None;
    }
    let reading = "Median time of one sample on one thread: encoding of the reading, then the network.";
    let draw = move |paint| draw_times(&timed, paint);
    Some(Chart::new(chart::WHERE_TIME_GOES, "Where the time goes", reading, draw))
}

fn draw_times(timed: &[&Judged], paint: Paint) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, 92.0 + ROW * timed.len() as f64, paint);
    let parts = |n: &Judged| n.speed.map_or((0.0, 0.0), |s| (s.encoding.p50_ms, s.network.p50_ms));
    let most = timed.iter().map(|n| parts(n)).map(|(a, b)| a + b).fold(0.0, f64::max);
    let key = [("encoding", Ink::Heat), ("network", Ink::Accent)];
    for (i, (text, ink)) in key.into_iter().enumerate() {
        let x = NAMES + 110.0 * i as f64;
        canvas.block((x, 10.0, 14.0, 14.0), ink, 0.85);
        canvas.text((x + 20.0, 21.0), text, PLAIN);
    }
    let frame = rows(&mut canvas, 36.0, timed.len(), most, "median time of one sample (ms)");
    for (i, n) in timed.iter().enumerate() {
        let y = frame.y.at(i as f64 + 0.5);
        let (encoding, network) = parts(n);
        name(&mut canvas, y, &n.results.network);
        let about = format!(
            "{}: encoding {} ms, network {} ms",
            n.results.network,
            digits(encoding),
            digits(network)
        );
        canvas.hover(&about, |canvas| {
            let (from, middle, to) = (NAMES, frame.x.at(encoding), frame.x.at(encoding + network));
            canvas.block((from, y - 8.0, middle - from, 16.0), Ink::Heat, 0.85);
            canvas.block((middle, y - 8.0, to - middle, 16.0), Ink::Accent, 0.85);
            let look = TextStyle { ink: Ink::Muted, ..PLAIN };
            canvas.text((to + 6.0, y + 4.0), &digits(encoding + network), look);
        });
    }
    canvas
}

/// Draws the expected calibration error, clean and broken.
pub(super) fn calibration(judgement: &Judgement) -> Option<Chart<'_>> {
    let stress = judgement.stress.as_ref().filter(|s| !s.networks.is_empty())?;
    // Values have no probability.
    stress.networks.iter().find_map(|network| network.calibration_error)?;
    let reading = "Expected calibration error: how far stated probabilities are from the share that is right. \
                   Dot: clean; ring: mean over faults and severities. To the left is better.";
    let draw = move |paint| draw_calibration(&stress.networks, paint);
    Some(Chart::new(chart::CALIBRATION, "Calibration, clean and broken", reading, draw))
}

fn draw_calibration(networks: &[NetworkStress], paint: Paint) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, 92.0 + ROW * networks.len() as f64, paint);
    let percent = |share: Option<f64>| 100.0 * share.unwrap_or(0.0);
    let both = |n: &NetworkStress| (percent(n.clean.calibration_error), percent(n.calibration_error));
    let most = networks.iter().map(both).map(|(a, b)| a.max(b)).fold(0.0, f64::max);
    canvas.circle((NAMES + 6.0, 17.0), 5.0, Ink::Accent, Ink::Accent);
    canvas.text((NAMES + 20.0, 21.0), "clean", PLAIN);
    canvas.circle((NAMES + 90.0, 17.0), 5.0, Ink::Paper, Ink::Heat);
    canvas.text((NAMES + 104.0, 21.0), "broken", PLAIN);
    let frame = rows(&mut canvas, 36.0, networks.len(), most, "expected calibration error (%)");
    for (i, n) in networks.iter().enumerate() {
        let y = frame.y.at(i as f64 + 0.5);
        let (clean, broken) = both(n);
        name(&mut canvas, y, &n.network);
        canvas.hover(
            &format!("{}: clean {} %, broken {} %", n.network, tenth(clean), tenth(broken)),
            |canvas| {
                canvas.line((frame.x.at(clean), y), (frame.x.at(broken), y), Stroke::of(Ink::Muted, 1.5));
                canvas.circle((frame.x.at(broken), y), 5.0, Ink::Paper, Ink::Heat);
                canvas.circle((frame.x.at(clean), y), 5.0, Ink::Accent, Ink::Accent);
            },
        );
    }
    canvas
}

/// Draws how much training changed each layer.
pub(super) fn weight_changes(judgement: &Judgement) -> Option<Chart<'_>> {
    let changed: Vec<&Judged> = shown(judgement).filter(|n| !n.results.changes.is_empty()).collect();
    if changed.is_empty() {
        return None;
    }
    let reading = "Mean squared change of each convolution's kernels in training, scaled to 0 to 1, mean over \
                   folds (Rouhafzay et al. 2021, Figs. 3 and 4).";
    let draw = move |paint| draw_changes(&changed, paint);
    Some(Chart::new(chart::WEIGHT_CHANGES, "What training changed", reading, draw))
}

fn draw_changes(changed: &[&Judged], paint: Paint) -> Canvas {
    let height = |n: &Judged| 88.0 + ROW * n.results.changes.len() as f64;
    let mut canvas = Canvas::new(WIDTH, changed.iter().map(|n| height(n)).sum(), paint);
    let mut top = 0.0;
    for n in changed {
        canvas.text((NAMES, top + 20.0), &n.results.network, HEADING);
        let most = n.results.changes.iter().map(|c| c.change).fold(0.0, f64::max);
        let title = "mean squared change";
        let frame = rows(&mut canvas, top + 32.0, n.results.changes.len(), most, title);
        for (i, layer) in n.results.changes.iter().enumerate() {
            let y = frame.y.at(i as f64 + 0.5);
            name(&mut canvas, y, &layer.layer);
            canvas.hover(
                &format!("{}, {}: {:.3e}", n.results.network, layer.layer, layer.change),
                |canvas| {
                    let to = frame.x.at(layer.change);
                    canvas.block((NAMES, y - 8.0, to - NAMES, 16.0), Ink::Accent, 0.85);
                },
            );
        }
        top += height(n);
    }
    canvas
}
