//! Charts of a data set: lengths, ranges of channels, means in recording order, what carries a shortcut.

use taxel_data::{Carrier, ChannelRange};
use taxel_report::axes::{AxisScale, PlotFrame, widened};
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, short};
use taxel_report::chart::Chart;
use taxel_report::numbers::{digits, tick};
use taxel_report::palette::{Ink, Paint, SERIES};

use crate::report::names::chart;
use crate::values::Survey;

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 300.0;
/// Width of the names at the left.
const NAMES: f64 = 150.0;
const ROW: f64 = 18.0;
/// Bars of a distribution.
const BARS: usize = 30;
/// Channels that are drawn.
pub(in crate::report) const CHANNELS: usize = 64;
/// Samples that are drawn; of more, some spread evenly.
const MARKS: usize = 1500;
/// Classes that have a row of their own.
const ROWS: usize = 30;
const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Draws how many recordings have which length.
pub(in crate::report) fn lengths(survey: &Survey) -> Option<Chart<'_>> {
    let (least, most) = (*survey.lengths.iter().min()?, *survey.lengths.iter().max()?);
    let reading = "How many recordings have so many readings, before any rule for their length.";
    let draw = move |paint| draw_lengths(&survey.lengths, (least, most), paint);
    (least < most).then(|| Chart::new(chart::LENGTHS, "Lengths of the recordings", reading, draw))
}

fn draw_lengths(lengths: &[usize], (least, most): (usize, usize), paint: Paint) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, HEIGHT, paint);
    let wide = (most - least + 1).div_ceil(BARS);
    let mut counts = vec![0usize; (most - least) / wide + 1];
    lengths.iter().for_each(|length| counts[(length - least) / wide] += 1);
    let highest = counts.iter().max().copied().unwrap_or(1) as f64;
    let end = least + wide * counts.len();
    let frame = PlotFrame {
        x: AxisScale::linear((least as f64, end as f64), (60.0, WIDTH - 20.0)),
        y: AxisScale::linear((0.0, 1.05 * highest), (HEIGHT - 50.0, 30.0)),
    };
    frame.draw_y(&mut canvas, tick);
    frame.draw_x(&mut canvas, &frame.x.ticks(), tick);
    frame.titles(&mut canvas, "readings", "recordings");
    for (bar, count) in counts.iter().enumerate() {
        let from = least + bar * wide;
        let name = if wide == 1 { from.to_string() } else { format!("{from} to {}", from + wide - 1) };
        let (left, top) = frame.at(from as f64, *count as f64);
        let (right, bottom) = frame.at((from + wide) as f64, 0.0);
        canvas.hover(&format!("{name} readings: {count}"), |canvas| {
            canvas.block((left + 1.0, top, (right - left - 2.0).max(1.0), bottom - top), Ink::Accent, 0.85);
        });
    }
    canvas
}

/// Draws each channel from its lowest to its highest value.
pub(in crate::report) fn ranges(survey: &Survey) -> Option<Chart<'_>> {
    let drawn = &survey.card.channels[..survey.card.channels.len().min(CHANNELS)];
    if drawn.len() < 2 || drawn.iter().all(|channel| channel.min.is_none()) {
        return None;
    }
    let reading = "From the lowest to the highest value of each channel. Rings: 2 % or more of the values are exactly \
                   there, as where a sensor saturates; a dashed line: still in 2 % or more of the samples.";
    let unit = survey.unit.as_deref();
    let draw = move |paint| draw_ranges(drawn, unit, paint);
    Some(Chart::new(chart::RANGES, "Ranges of the channels", reading, draw))
}

fn draw_ranges(drawn: &[ChannelRange], unit: Option<&str>, paint: Paint) -> Canvas {
    let bottom = 12.0 + ROW * drawn.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 46.0, paint);
    let ends = drawn
        .iter()
        .flat_map(|channel| [channel.min, channel.max])
        .flatten()
        .map(f64::from)
        .collect::<Vec<_>>();
    let x = AxisScale::linear(widened(&ends, ANY), (NAMES, WIDTH - 20.0));
    let title = unit.map_or("value".into(), |unit| format!("value, {unit}"));
    x.draw_grid(&mut canvas, (12.0, bottom), &title, digits_of_tick);
    for (row, channel) in drawn.iter().enumerate() {
        let y = 12.0 + ROW * (row as f64 + 0.5);
        let name = format!("channel {}", channel.channel);
        canvas.text((NAMES - 10.0, y + 4.0), &name, TextStyle { anchor: Anchor::Right, ..PLAIN });
        let (Some(min), Some(max)) = (channel.min.map(f64::from), channel.max.map(f64::from)) else {
            continue;
        };
        let about = format!(
            "{name}: {} to {}; {} % at the lowest, {} % at the highest, still in {} % of the samples",
            digits(min),
            digits(max),
            digits(100.0 * channel.at_min),
            digits(100.0 * channel.at_max),
            digits(100.0 * channel.stuck)
        );
        canvas.hover(&about, |canvas| {
            let stroke = Stroke::of(Ink::Accent, 3.0);
            let stroke = if channel.stuck >= 0.02 { stroke.dashed((5.0, 3.0)) } else { stroke };
            canvas.line((x.at(min), y), (x.at(max), y), stroke);
            for (end, share) in [(min, channel.at_min), (max, channel.at_max)] {
                let fill = if share >= 0.02 { Ink::Paper } else { Ink::Accent };
                canvas.circle((x.at(end), y), 4.0, fill, Ink::Accent);
            }
        });
    }
    canvas
}

/// Draws the mean of each sample, in order.
pub(in crate::report) fn drift(survey: &Survey) -> Option<Chart<'_>> {
    let finite = survey.drift.means.iter().filter(|mean| mean.is_finite()).count();
    let reading = "The mean of each sample in the order in which samples are stored, classes in colours. A slope or a \
                   step within a class is a sensor that wanders, or a session that differs.";
    let draw = move |paint| draw_drift(survey, paint);
    (finite > 1).then(|| Chart::new(chart::DRIFT, "Means in recording order", reading, draw))
}

fn draw_drift(survey: &Survey, paint: Paint) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, HEIGHT, paint);
    let means = &survey.drift.means;
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, (means.len() - 1) as f64), (70.0, WIDTH - 20.0)),
        y: AxisScale::linear(widened(means, ANY), (HEIGHT - 50.0, 30.0)),
    };
    frame.draw_y(&mut canvas, digits_of_tick);
    frame.draw_x(&mut canvas, &frame.x.ticks(), tick);
    frame.titles(&mut canvas, "sample, as stored", "mean");
    let every = means.len().div_ceil(MARKS);
    for (i, mean) in means.iter().enumerate().step_by(every).filter(|(_, mean)| mean.is_finite()) {
        let class = survey.order.get(i).map_or(0, |class| *class as usize);
        let (x, y) = frame.at(i as f64, *mean);
        canvas.hover(&format!("sample {i}, {}: {}", class_name(survey, class), digits(*mean)), |canvas| {
            canvas.circle((x, y), 2.2, Ink::Series(class % SERIES), Ink::None);
        });
    }
    canvas
}

/// Draws the statistic that tells most, class by class.
pub(in crate::report) fn carrier(survey: &Survey) -> Option<Chart<'_>> {
    let first = survey.carriers.first()?;
    let reading = format!(
        "The {} of each sample, a row per class. Rows that do not overlap are told apart by this number alone.",
        first.statistic
    );
    let draw = move |paint| draw_carrier(survey, first, paint);
    Some(Chart::new(chart::CARRIER, format!("What the {} alone tells", first.statistic), reading, draw))
}

fn draw_carrier(survey: &Survey, carrier: &Carrier, paint: Paint) -> Canvas {
    let classes = survey.card.classes.len().min(ROWS);
    let bottom = 12.0 + ROW * classes as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 46.0, paint);
    let values: Vec<f64> = carrier.values.iter().map(|(value, _)| *value).collect();
    let x = AxisScale::linear(widened(&values, ANY), (NAMES, WIDTH - 20.0));
    x.draw_grid(&mut canvas, (12.0, bottom), &carrier.statistic, digits_of_tick);
    for class in 0..classes {
        let y = 12.0 + ROW * (class as f64 + 0.5);
        let name = class_name(survey, class);
        canvas.text((NAMES - 10.0, y + 4.0), &short(name, 18), TextStyle { anchor: Anchor::Right, ..PLAIN });
        let of_class = || carrier.values.iter().filter(move |(_, of)| *of as usize == class);
        let every = of_class().count().div_ceil(MARKS / classes).max(1);
        canvas.hover(name, |canvas| {
            of_class().step_by(every).for_each(|(value, _)| {
                canvas.circle((x.at(*value), y), 3.0, Ink::Series(class % SERIES), Ink::None);
            });
        });
    }
    canvas
}

fn class_name(survey: &Survey, class: usize) -> &str {
    survey.card.classes.get(class).map_or("no class", |class| class.name.as_str())
}

/// Returns the number of a tick; small and large values in powers of ten.
fn digits_of_tick(value: f64) -> String {
    match value.abs() {
        size if size != 0.0 && !(1e-4..1e6).contains(&size) => format!("{value:.1e}").replace(".0e", "e"),
        _ => tick(value),
    }
}
