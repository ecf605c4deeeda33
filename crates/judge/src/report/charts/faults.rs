//! Scores under faults: a small chart for each fault, and one map of all losses.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, short};
use taxel_report::chart::{Chart, HEADING};
use taxel_report::numbers::tick;
use taxel_report::palette::{Ink, Paint};

use super::look::{LineLook, legend, legend_height, look};
use crate::report::names::chart;
use crate::report::words::stress_basis;
use crate::values::{Judgement, MAJORITY, NetworkStress, Stress};

const WIDTH: f64 = 860.0;
const COLUMNS: usize = 3;
/// Size of a small chart with its titles.
const CELL: (f64, f64) = (282.0, 206.0);

/// Draws the scores by severity, one small chart per fault.
pub(super) fn curves(judgement: &Judgement) -> Option<Chart<'_>> {
    let stress = judgement.stress.as_ref().filter(|s| !s.faults.is_empty())?;
    let reading = format!(
        "{} at each severity, from clean at the left; ringed: half of the {} is gone. Dashed lines: baselines; \
         dotted: {}. {}.",
        stress.primary.axis_begins(),
        stress.primary.margin_of_chance(),
        stress.primary.chance(),
        stress_basis(stress)
    );
    let title = format!("{} under faults", stress.primary.heading());
    Some(Chart::new(chart::FAULT_CURVES, title, reading, move |paint| draw_curves(judgement, stress, paint)))
}

fn draw_curves(judgement: &Judgement, stress: &Stress, paint: Paint) -> Canvas {
    let names: Vec<(&str, LineLook)> =
        drawn(judgement, stress).map(|n| (n.network.as_str(), look(judgement, &n.network))).collect();
    let top = 12.0 + legend_height(WIDTH - 20.0, &names);
    let rows = stress.faults.len().div_ceil(COLUMNS);
    let columns = stress.faults.len().min(COLUMNS);
    let width = if columns == COLUMNS { WIDTH } else { (CELL.0 * columns as f64 + 20.0).max(WIDTH * 0.7) };
    let mut canvas = Canvas::new(width, top + rows as f64 * CELL.1 + 4.0, paint);
    legend(&mut canvas, (10.0, 14.0), WIDTH - 20.0, &names);
    for i in 0..stress.faults.len() {
        let at = (CELL.0 * (i % COLUMNS) as f64, top + CELL.1 * (i / COLUMNS) as f64);
        small(&mut canvas, (judgement, stress), i, at, &names);
    }
    canvas
}

/// Returns all networks but majority, which is the line of chance.
fn drawn<'a>(judgement: &'a Judgement, stress: &'a Stress) -> impl Iterator<Item = &'a NetworkStress> {
    let majority = judgement.networks.iter().find(|n| n.results.zoo == MAJORITY);
    stress.networks.iter().filter(move |n| majority.is_none_or(|m| m.results.network != n.network))
}

/// Returns the least and the highest score of all small charts: a percentage has its whole range.
fn heights(judgement: &Judgement, stress: &Stress) -> (f64, f64) {
    if stress.primary.is_percent() {
        return stress.primary.range();
    }
    let broken = |n: &NetworkStress| {
        n.curves
            .iter()
            .flat_map(|curve| curve.points.iter().map(|(_, score)| score.score))
            .collect::<Vec<_>>()
    };
    let all = drawn(judgement, stress).flat_map(|n| [broken(n), vec![n.clean.score]].concat());
    widened(&all.chain([stress.chance]).collect::<Vec<_>>(), stress.primary.range())
}

/// Draws the chart of fault number `i`.
fn small(
    canvas: &mut Canvas,
    (judgement, stress): (&Judgement, &Stress),
    i: usize,
    (left, top): (f64, f64),
    names: &[(&str, LineLook)],
) {
    let info = &stress.faults[i];
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, 5.0), (left + 38.0, left + CELL.0 - 12.0)),
        y: AxisScale::linear(heights(judgement, stress), (top + 154.0, top + 30.0)),
    };
    canvas.text((left + 6.0, top + 18.0), info.fault.name(), HEADING);
    frame.draw_y(canvas, tick);
    frame.draw_x(canvas, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], |severity| match severity as usize {
        0 => "clean".into(),
        at => info.level(at as u8).to_string(),
    });
    let ((x, to), (y, _)) = (frame.x.ends(), frame.y.ends());
    let look = TextStyle { size: 11, ink: Ink::Muted, anchor: Anchor::Middle, ..PLAIN };
    canvas.text(((x + to) / 2.0, y + 33.0), &info.unit, look);
    let chance = frame.y.at(stress.chance);
    canvas.line((x, chance), (to, chance), Stroke::of(Ink::Muted, 1.0).dashed((1.0, 3.0)));
    for (network, (name, look)) in drawn(judgement, stress).zip(names) {
        let Some(curve) = network.curves.get(i) else { continue };
        let mut points = vec![(0u8, network.clean.score)];
        points.extend(curve.points.iter().map(|(severity, score)| (*severity, score.score)));
        let place = |(severity, score): &(u8, f64)| frame.at(f64::from(*severity), *score);
        canvas.path(points.iter().map(place).collect(), look.stroke(1.8));
        for point in &points {
            let what = match point.0 {
                0 => "clean".into(),
                severity => format!("{} {} {}", info.fault.name(), info.level(severity), info.unit),
            };
            let broken = curve.breaks_at == Some(point.0);
            let note = if broken { ", broken" } else { "" };
            canvas.hover(&format!("{name}, {what}: {}{note}", stress.primary.value(point.1)), |canvas| {
                canvas.circle(place(point), 2.6, look.ink, look.ink);
                if broken {
                    canvas.circle(place(point), 6.0, Ink::None, look.ink);
                }
            });
        }
    }
}

/// Draws the loss by network and fault.
pub(super) fn heat(judgement: &Judgement) -> Option<Chart<'_>> {
    let stress = judgement.stress.as_ref().filter(|s| !s.faults.is_empty())?;
    let reading = format!(
        "{} in {}, mean over severities; the stronger the colour, the more. ✕3: from severity 3 on half of the {} \
         is gone.",
        stress.primary.lost(true),
        stress.primary.in_points(),
        stress.primary.margin_of_chance()
    );
    Some(Chart::new(chart::FAULT_LOSSES, "What each fault costs", reading, move |paint| {
        draw_heat(stress, paint)
    }))
}

fn draw_heat(stress: &Stress, paint: Paint) -> Canvas {
    let (names, row, column) = (168.0, 30.0, 62.0);
    let height = 96.0 + row * stress.networks.len() as f64;
    let width = (names + column * stress.faults.len() as f64 + 52.0).max(420.0);
    let mut canvas = Canvas::new(width, height, paint);
    let primary = &stress.primary;
    let losses = stress.networks.iter().flat_map(|n| n.curves.iter().map(|c| c.loss(n.clean, primary)));
    let least = primary.share(1.0, stress.chance).max(f64::MIN_POSITIVE);
    let most = losses.fold(least, f64::max);
    for (i, info) in stress.faults.iter().enumerate() {
        heading(&mut canvas, (names + column * (i as f64 + 0.5), 78.0), info.fault.name());
    }
    for (k, network) in stress.networks.iter().enumerate() {
        let y = 84.0 + row * k as f64;
        let look = TextStyle { anchor: Anchor::Right, ..PLAIN };
        canvas.text((names - 8.0, y + row / 2.0 + 4.0), &short(&network.network, 22), look);
        for (i, curve) in network.curves.iter().enumerate() {
            let x = names + column * i as f64;
            let loss = curve.loss(network.clean, primary);
            let at = curve.breaks_at.map_or(String::new(), |at| format!(" ✕{at}"));
            let shown = primary.show()(loss);
            let unit = if primary.is_percent() { "pp" } else { primary.unit() };
            let about = format!("{}, {}: {shown} {unit} lost{at}", network.network, curve.fault.name());
            canvas.hover(&about, |canvas| {
                let share = (loss / most).clamp(0.0, 1.0);
                canvas.block((x + 1.0, y + 1.0, column - 2.0, row - 2.0), Ink::Heat, 0.04 + 0.86 * share);
                let look = TextStyle { anchor: Anchor::Middle, ..PLAIN };
                canvas.text((x + column / 2.0, y + row / 2.0 + 4.0), &(shown + &at), look);
            });
        }
    }
    canvas
}

/// Writes the name of a column, upright so that long ones fit.
fn heading(canvas: &mut Canvas, at: (f64, f64), text: &str) {
    canvas.upright((at.0 + 4.0, at.1), text, TextStyle { anchor: Anchor::Left, ..PLAIN });
}
