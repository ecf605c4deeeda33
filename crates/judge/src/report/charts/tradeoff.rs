//! The primary metric against what it costs: latency, size, MACs.

use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, short, width_of};
use taxel_report::chart::Chart;
use taxel_report::labels::{self, place};
use taxel_report::numbers::{bytes, digits, in_brackets, si, tick};
use taxel_report::palette::{Ink, Paint};

use super::look::shown;
use crate::pareto;
use crate::report::names::chart;
use crate::report::words::runs;
use crate::values::{Choice, Judged, Judgement, MAJORITY, Primary};

const SIZE: (f64, f64) = (860.0, 506.0);
/// Left, top, right, bottom of the area of the marks.
const AREA: labels::Area = (64.0, 34.0, 836.0, 414.0);

/// A network in such a chart.
struct Point<'a> {
    name: &'a str,
    cost: f64,
    /// Up to which the cost goes at worst.
    worst: Option<f64>,
    score: f64,
    interval: Option<[f64; 2]>,
    baseline: bool,
    front: bool,
}

/// A published result: cost and accuracy with its SD.
struct Printed {
    cost: f64,
    /// Mean, and SD where one is printed.
    accuracy: (f64, Option<f64>),
    about: String,
}

/// The x axis.
struct CostAxis {
    /// Of the cost.
    name: &'static str,
    /// Of the chart, behind the name of the metric.
    title: &'static str,
    label: &'static str,
    unit: fn(f64) -> String,
    tick: fn(f64) -> String,
}

const LATENCY: CostAxis = CostAxis {
    name: chart::LATENCY,
    title: "against latency",
    label: "latency from raw reading to answer, one sample, one thread (ms, log)",
    unit: |v| format!("{} ms", digits(v)),
    tick,
};
const BYTES: CostAxis = CostAxis {
    name: chart::SIZE,
    title: "against size",
    label: "size of parameters and statistics in f32 (bytes, log)",
    unit: bytes,
    tick: bytes,
};
const MACS: CostAxis = CostAxis {
    name: chart::MACS,
    title: "against work",
    label: "multiply-accumulates per sample (log)",
    unit: |v| format!("{} MACs", si(v)),
    tick: si,
};

pub(super) fn charts<'a>(judgement: &'a Judgement, choice: Option<&'a Choice>) -> Vec<Chart<'a>> {
    // No printed point against MACs: no one convention explains the papers' GFLOPs (docs/costs.md).
    let primary = judgement.primary();
    let papers = shown(judgement).filter(|_| primary.is_accuracy());
    let sizes = papers.filter_map(printed_size).collect();
    let all = [
        (LATENCY, points(judgement, |n| n.speed.map(|s| (s.whole.p50_ms, Some(s.whole.p95_ms)))), vec![]),
        (BYTES, points(judgement, |n| Some((n.results.costs.bytes as f64, None))), sizes),
        (MACS, points(judgement, |n| Some((n.results.costs.macs as f64, None))), vec![]),
    ];
    let drawn = all.into_iter().filter(|(_, points, _)| !points.is_empty());
    drawn
        .map(|(axis, points, printed)| {
            let reading = reading(judgement, &axis, &points, &printed);
            let chosen = choice.and_then(|c| c.chosen.as_deref());
            let title = format!("{} {}", primary.heading(), axis.title);
            let name = chart::against(primary.name(), axis.name);
            Chart::new(name, title, reading, move |paint| {
                draw(judgement, &axis, &points, &printed, chosen, paint)
            })
        })
        .collect()
}

fn gflops(n: &Judged) -> Option<f64> {
    n.results.published.as_ref()?.gflops
}

/// Returns the published result, where a paper printed both size and accuracy; its MB are 2^20 bytes (docs/costs.md).
fn printed_size(n: &Judged) -> Option<Printed> {
    let paper = n.results.published.as_ref()?;
    let about = format!("{} ({})", n.results.network, paper.table);
    let accuracy = (*paper.accuracy.first()?, paper.accuracy.get(1).copied());
    Some(Printed { cost: paper.megabytes? * f64::from(1u32 << 20), accuracy, about })
}

/// Returns the networks with a cost above 0, since the axis is logarithmic. Always naming the commonest class costs
/// nothing and is drawn as a line.
fn points(judgement: &Judgement, cost: impl Fn(&Judged) -> Option<(f64, Option<f64>)>) -> Vec<Point<'_>> {
    let all: Vec<Point> = shown(judgement)
        .filter_map(|n| {
            let (cost, worst) = cost(n)?;
            let (score, interval) = (n.results.primary()?, n.results.interval);
            let (name, baseline) = (n.results.network.as_str(), n.baseline);
            Some(Point { name, cost, worst, score, interval, baseline, front: false })
        })
        .collect();
    let primary = judgement.primary();
    let place = |point: &Point| (point.cost, primary.merit(point.score));
    let front = pareto::front(&all.iter().map(place).collect::<Vec<_>>());
    let majority = |point: &Point| judgement.network(point.name).is_some_and(|n| n.results.zoo == MAJORITY);
    let all = all.into_iter().zip(front).map(|(point, front)| Point { front, ..point });
    all.filter(|point| point.cost > 0.0 && !majority(point)).collect()
}

fn reading(judgement: &Judgement, axis: &CostAxis, points: &[Point], printed: &[Printed]) -> String {
    let primary = judgement.primary();
    let mut front: Vec<&Point> = points.iter().filter(|p| p.front).collect();
    front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let front: Vec<String> = front
        .into_iter()
        .map(|p| format!("{} ({}, {})", p.name, (axis.unit)(p.cost), primary.value(p.score)))
        .collect();
    let mut text = format!(
        "Coloured and joined: the Pareto front, {}. Grey: dominated, another is at least as accurate and costs \
         no more. Vertical whiskers: 95 % interval of the {}.",
        front.join(", "),
        primary.title()
    );
    if points.iter().any(|p| p.worst.is_some()) {
        let runs = runs(judgement);
        text += &format!(" Horizontal whiskers: from p50 to p95 of {runs} timed runs, encoding included.");
    }
    if !printed.is_empty() {
        text += " Hollow, dashed: printed by the papers for their own recordings, whiskers their SD; not \
                 measured here.";
    }
    if axis.name == MACS.name && judgement.networks.iter().any(|n| gflops(n).is_some()) {
        text += " The papers' GFLOPs stand in the table of published numbers: no one way of counting explains \
                 them, so they are no points here.";
    }
    let chance = primary.value(judgement.chance);
    text + &format!(" {}, {}: {chance}.", primary.chance_heading(), primary.knowing_nothing())
}

fn draw(
    judgement: &Judgement,
    axis: &CostAxis,
    points: &[Point],
    printed: &[Printed],
    chosen: Option<&str>,
    paint: Paint,
) -> Canvas {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1, paint);
    let primary = judgement.primary();
    let frame = frame(judgement, points, printed);
    frame.draw_y(&mut canvas, tick);
    frame.draw_x(&mut canvas, &frame.x.ticks(), axis.tick);
    frame.titles(&mut canvas, axis.label, &primary.axis());
    chance(&mut canvas, &frame, &primary, judgement.chance);
    let mut taken = front(&mut canvas, &frame, points);
    let ink = |point: &Point| if point.front { Ink::Accent } else { Ink::Muted };
    for printed in printed {
        hollow(&mut canvas, &frame, axis, printed);
    }
    for point in points {
        taken.extend(mark(
            &mut canvas,
            &frame,
            (&primary, axis),
            point,
            ink(point),
            chosen == Some(point.name),
        ));
    }
    let names: Vec<String> = points.iter().map(|p| short(p.name, 28)).collect();
    let marks: Vec<((f64, f64), &str)> =
        points.iter().zip(&names).map(|(p, name)| (frame.at(p.cost, p.score), name.as_str())).collect();
    taken.extend(printed.iter().map(|printed| {
        let (x, y) = frame.at(printed.cost, printed.accuracy.0);
        (x - 6.0, y - 6.0, x + 6.0, y + 6.0)
    }));
    let inside = (AREA.0 + 2.0, AREA.1, SIZE.0 - 4.0, AREA.3 - 4.0);
    for ((place, (at, name)), point) in place(&marks, inside, &taken).iter().zip(&marks).zip(points) {
        if place.far {
            let end = (place.at.0, place.at.1 - 4.0);
            canvas.line(*at, end, Stroke::of(Ink::Muted, 0.7));
        }
        let bold = chosen == Some(point.name);
        canvas.text(place.at, name, TextStyle { ink: ink(point), anchor: place.anchor, bold, ..PLAIN });
    }
    key(&mut canvas, points, printed, chosen);
    canvas
}

fn frame(judgement: &Judgement, points: &[Point], printed: &[Printed]) -> PlotFrame {
    let costs = points.iter().flat_map(|p| [p.cost, p.worst.unwrap_or(p.cost)]);
    let costs: Vec<f64> = costs.chain(printed.iter().map(|printed| printed.cost)).collect();
    let (low, high) = costs.iter().fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(*v), h.max(*v)));
    let mut scores: Vec<f64> = points.iter().flat_map(|p| p.interval.unwrap_or([p.score; 2])).collect();
    let ends = |printed: &Printed| {
        [-1.0, 1.0].map(|sign| printed.accuracy.0 + sign * printed.accuracy.1.unwrap_or(0.0))
    };
    scores.extend(printed.iter().flat_map(ends));
    let (primary, chance) = (judgement.primary(), judgement.chance);
    let (mut least, mut most) = widened(&scores, primary.range());
    // Chance is in the picture where that does not press the marks together.
    let is_near = |away: f64| away < 0.4 * (most - least);
    if is_near(least - chance) && (primary.is_percent() || is_near(chance - most)) {
        let air = primary.share(2.0, chance);
        least = least.min(chance - air).max(primary.range().0);
        most = if primary.is_percent() { most } else { most.max(chance + air) };
    }
    PlotFrame {
        x: AxisScale::log((low, high), (AREA.0, AREA.2)),
        y: AxisScale::linear((least, most), (AREA.3, AREA.1)),
    }
}

fn chance(canvas: &mut Canvas, frame: &PlotFrame, primary: &Primary, chance: f64) {
    let (y, (bottom, top)) = (frame.y.at(chance), frame.y.ends());
    if y < bottom - 1.0 && (primary.is_percent() || y > top) {
        canvas.line((AREA.0, y), (AREA.2, y), Stroke::of(Ink::Muted, 1.0).dashed((2.0, 4.0)));
        let look = TextStyle { ink: Ink::Muted, anchor: Anchor::Right, ..PLAIN };
        canvas.text((AREA.2, y - 5.0), &format!("{} {}", primary.chance(), primary.value(chance)), look);
    }
}

/// Draws steps from one network of the front to the next. Returns the areas that they take.
fn front(canvas: &mut Canvas, frame: &PlotFrame, points: &[Point]) -> Vec<labels::Area> {
    let mut front: Vec<&Point> = points.iter().filter(|p| p.front).collect();
    front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut steps: Vec<(f64, f64)> = vec![];
    for point in front {
        let (x, y) = frame.at(point.cost, point.score);
        if let Some(&(_, before)) = steps.last() {
            steps.push((x, before));
        }
        steps.push((x, y));
    }
    if let Some(&(_, last)) = steps.last() {
        steps.push((AREA.2, last));
    }
    let line = |ends: &[(f64, f64)]| {
        let ((a, b), (c, d)) = (ends[0], ends[1]);
        (a.min(c) - 2.0, b.min(d) - 2.0, a.max(c) + 2.0, b.max(d) + 2.0)
    };
    let taken = steps.windows(2).map(line).collect();
    canvas.path(steps, Stroke::of(Ink::Soft, 3.0));
    taken
}

/// Draws one network; the areas that its whiskers take.
fn mark(
    canvas: &mut Canvas,
    frame: &PlotFrame,
    (primary, axis): (&Primary, &CostAxis),
    point: &Point,
    ink: Ink,
    chosen: bool,
) -> Vec<labels::Area> {
    let (x, y) = frame.at(point.cost, point.score);
    let mut about = format!("{}: {}", point.name, primary.value(point.score));
    about += &point.interval.map_or(String::new(), in_brackets(primary.show()));
    about += &format!(", {}", (axis.unit)(point.cost));
    if let Some(worst) = point.worst {
        about += &format!(" (p95 {})", (axis.unit)(worst));
    }
    let mut taken = vec![];
    canvas.hover(&about, |canvas| {
        let stroke = Stroke::of(ink, 1.3);
        if let Some([low, high]) = point.interval {
            let (low, high) = (frame.y.at(low), frame.y.at(high));
            canvas.line((x, low), (x, high), stroke);
            [low, high].into_iter().for_each(|y| canvas.line((x - 4.0, y), (x + 4.0, y), stroke));
            taken.push((x - 3.0, high, x + 3.0, low));
        }
        if let Some(worst) = point.worst {
            let worst = frame.x.at(worst);
            canvas.line((x, y), (worst, y), stroke);
            canvas.line((worst, y - 4.0), (worst, y + 4.0), stroke);
            taken.push((x, y - 3.0, worst, y + 3.0));
        }
        if chosen {
            taken.push((x - 13.0, y - 13.0, x + 13.0, y + 13.0));
            canvas.circle((x, y), 11.0, Ink::None, ink);
        }
        if point.baseline {
            canvas.diamond((x, y), 6.5, ink, Ink::Paper)
        } else {
            canvas.circle((x, y), 6.0, ink, Ink::Paper)
        }
    });
    taken
}

fn hollow(canvas: &mut Canvas, frame: &PlotFrame, axis: &CostAxis, printed: &Printed) {
    let (mean, sd) = printed.accuracy;
    let spread = sd.map_or(String::new(), |sd| format!(" ± {sd}"));
    let sd = sd.unwrap_or(0.0);
    let (x, y) = frame.at(printed.cost, mean);
    let about = format!(
        "published, own recordings: {}: {mean}{spread} %, {}",
        printed.about,
        (axis.unit)(printed.cost)
    );
    canvas.hover(&about, |canvas| {
        let stroke = Stroke::of(Ink::Muted, 1.0).dashed((3.0, 3.0));
        canvas.line((x, frame.y.at(mean - sd)), (x, frame.y.at(mean + sd)), stroke);
        canvas.circle((x, y), 5.0, Ink::Paper, Ink::Muted);
    });
}

/// Draws the legend.
fn key(canvas: &mut Canvas, points: &[Point], printed: &[Printed], chosen: Option<&str>) {
    let (mut x, y) = (AREA.0, SIZE.1 - 22.0);
    let mut entry = |canvas: &mut Canvas, text: &str, draw: &dyn Fn(&mut Canvas, (f64, f64))| {
        draw(canvas, (x, y));
        canvas.text((x + 14.0, y + 4.0), text, PLAIN);
        x += 30.0 + width_of(text, PLAIN.size);
    };
    if points.iter().any(|p| !p.baseline) {
        entry(canvas, "network", &|c, at| c.circle(at, 6.0, Ink::Text, Ink::Paper));
    }
    if points.iter().any(|p| p.baseline) {
        entry(canvas, "baseline", &|c, at| c.diamond(at, 6.5, Ink::Text, Ink::Paper));
    }
    entry(canvas, "on the front", &|c, at| c.circle(at, 6.0, Ink::Accent, Ink::Paper));
    if points.iter().any(|p| !p.front) {
        entry(canvas, "dominated", &|c, at| c.circle(at, 6.0, Ink::Muted, Ink::Paper));
    }
    if chosen.is_some() {
        entry(canvas, "recommended", &|c, at| c.circle(at, 8.0, Ink::None, Ink::Accent));
    }
    if !printed.is_empty() {
        let text = "printed by the paper, its own data";
        entry(canvas, text, &|c, at| c.circle(at, 5.0, Ink::Paper, Ink::Muted));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture::judgement;

    #[test]
    fn the_front_holds_no_dominated_network() {
        let judgement = judgement();
        let points = points(&judgement, |n| n.speed.map(|s| (s.whole.p50_ms, None)));
        assert!(points.iter().all(|p| p.name != "majority"), "it is the line of chance");
        for point in &points {
            let network = judgement.network(point.name).unwrap();
            assert_eq!(point.front, network.on_front, "{}", point.name);
            let better = points.iter().any(|o| o.cost < point.cost && o.score > point.score);
            assert!(!(point.front && better), "{} is dominated", point.name);
        }
        let fronts = points.iter().filter(|p| p.front).count();
        assert!(fronts > 0 && fronts < points.len(), "a front and something behind it");
    }
}
