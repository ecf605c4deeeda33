//! The settings of each axis, from a little less to very little.

use taxel_data::{Layout, SampleSpec};
use taxel_learn::Reduction;
use taxel_trainer::Depth;
use taxel_zoo::{WIDTH_MULT, WITHOUT_BLOCKS};
use toml::Value;

use crate::axis::Axis;
use crate::sensors::{called, sensors};

/// Settings of one axis at most.
const MOST: usize = 8;
/// The same where it has to be quick.
const FEW: usize = 3;

/// The reduction of one setting.
#[derive(Debug, Clone, PartialEq)]
pub enum Cut {
    /// So many of the most important sensors are kept; which, each training part says.
    Keep(usize),
    /// The same for all training parts.
    Reduce(Reduction),
    /// So many bits over the range of the readings, which each training part says where nobody else does.
    Bits(u32),
    /// A value among the network's settings.
    Set(&'static str, Value),
}

/// One setting.
#[derive(Debug, Clone, PartialEq)]
pub struct LadderStep {
    /// `3 of 5 channels`.
    pub label: String,
    /// `3`.
    pub short: String,
    /// The reduction.
    pub cut: Cut,
}

/// The settings of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// The quantity that is reduced.
    pub axis: Axis,
    /// The unreduced quantity, in words.
    pub whole: String,
    /// The same for a chart.
    pub short: String,
    /// From the largest to the smallest.
    pub steps: Vec<LadderStep>,
}

/// Facts about samples and network that ladders are made from.
pub struct LadderInputs<'a> {
    /// The samples.
    pub spec: &'a SampleSpec,
    /// A number of the network's settings, where it has it.
    pub number: &'a dyn Fn(&str) -> Option<usize>,
    /// The multiplier of the network's channels, where it has one.
    pub width_mult: Option<f64>,
    /// Blocks or layers that the network could leave out, where there are some.
    pub depth: Option<Depth>,
    /// Whether it has to be quick.
    pub quick: bool,
}

/// Returns the settings of `axis`.
///
/// # Errors
/// Why there are none.
pub fn ladder(axis: Axis, facts: &LadderInputs) -> Result<Ladder, String> {
    let LadderInputs { spec, number, width_mult, depth, quick } = *facts;
    let (layout, shape) = (spec.layout, spec.shape.as_slice());
    let (_, readings, _) = spec.around_time();
    let in_time = || match layout.time_axis() {
        Some(_) if readings > 1 => Ok(()),
        _ => Err(format!("{} has no time axis", layout.describe())),
    };
    let (whole, short, mut steps) = match axis {
        Axis::Sensors => {
            let (all, name) = (sensors(layout, shape).len(), called(layout));
            (format!("{all} {name}"), all.to_string(), keep(all, name))
        }
        Axis::Rate => {
            in_time()?;
            let short = spec.rate.map_or(readings.to_string(), |rate| format!("{} Hz", plain(rate)));
            (of_rate(spec, 1, readings), short, rates(spec, readings))
        }
        Axis::Window => {
            in_time()?;
            (format!("{readings} readings"), readings.to_string(), windows(spec, readings))
        }
        Axis::Bits => {
            let step = |bits: u32| LadderStep {
                label: plural(bits, "bit"),
                short: bits.to_string(),
                cut: Cut::Bits(bits),
            };
            ("the converter as it is".into(), "as it is".into(), [8, 6, 5, 4, 3, 2, 1].map(step).to_vec())
        }
        Axis::Resolution => {
            let [rows, columns] = area(layout, shape).ok_or(format!("{} has no area", layout.describe()))?;
            (format!("{rows} × {columns} taxels"), format!("{rows} × {columns}"), pools(rows, columns))
        }
        Axis::Width => match (number("width"), width_mult) {
            (Some(all), _) => (format!("width {all}"), all.to_string(), widths(all)),
            (None, Some(all)) => ("all channels of the layers".into(), "all".into(), narrower(all)),
            (None, None) => return Err("it is no network that taxel can build narrower".into()),
        },
        Axis::Depth => match (number("blocks"), depth) {
            (Some(all), _) => (format!("{all} blocks"), all.to_string(), blocks(all)),
            (None, Some(depth)) => {
                let Depth { left, .. } = depth;
                (format!("all {left} {}", depth_name(depth)), left.to_string(), shallower(depth))
            }
            (None, None) => return Err("it has no block and no plain layer that could be left out".into()),
        },
    };
    if steps.is_empty() {
        return Err(format!("there is nothing less than {whole}"));
    }
    thinned(&mut steps, if quick { FEW } else { MOST });
    Ok(Ladder { axis, whole, short, steps })
}

/// Keeps at most `most` settings, spread evenly, the smallest among them.
fn thinned(steps: &mut Vec<LadderStep>, most: usize) {
    let all = steps.len();
    if all > most {
        let kept: Vec<LadderStep> =
            (1..=most).map(|at| steps[(at * all).div_ceil(most) - 1].clone()).collect();
        *steps = kept;
    }
}

/// Returns falling numbers below `all` that are these shares of it, and 1.
fn falling(all: usize, shares: &[(usize, usize)]) -> Vec<usize> {
    let mut found: Vec<usize> = match all {
        0..=6 => (1..all).rev().collect(),
        _ => shares.iter().map(|(part, of)| (all * part).div_ceil(*of)).chain([1]).collect(),
    };
    found.retain(|number| (1..all).contains(number));
    found.sort_unstable_by(|a, b| b.cmp(a));
    found.dedup();
    found
}

const SHARES: [(usize, usize); 8] = [(3, 4), (1, 2), (1, 3), (1, 4), (1, 6), (1, 8), (1, 12), (1, 16)];

fn keep(all: usize, name: &str) -> Vec<LadderStep> {
    let step = |count: usize| LadderStep {
        label: format!("{count} of {all} {name}"),
        short: count.to_string(),
        cut: Cut::Keep(count),
    };
    // An array keeps a row and a column.
    let least = if name == called(Layout::Image) { 2 } else { 1 };
    falling(all, &SHARES).into_iter().filter(|count| *count >= least).map(step).collect()
}

fn plain(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

fn plural(count: u32, name: &str) -> String {
    if count == 1 { format!("1 {name}") } else { format!("{count} {name}s") }
}

/// Returns a rate in words: `13 of 50 readings, 25 Hz`.
fn of_rate(spec: &SampleSpec, every: usize, readings: usize) -> String {
    let left = readings.div_ceil(every);
    let rate = spec.rate.map_or(String::new(), |rate| format!(", {} Hz", plain(rate / every as f64)));
    let of =
        if every > 1 { format!("{left} of {readings} readings") } else { format!("{readings} readings") };
    format!("{of}{rate}")
}

fn rates(spec: &SampleSpec, readings: usize) -> Vec<LadderStep> {
    let step = |every: usize| LadderStep {
        label: of_rate(spec, every, readings),
        short: spec.rate.map_or(readings.div_ceil(every).to_string(), |rate| {
            format!("{} Hz", plain(rate / every as f64))
        }),
        cut: Cut::Reduce(Reduction { every: Some(every), ..Reduction::default() }),
    };
    let powers = (1..).map(|power| 1 << power);
    powers.take_while(|every| readings.div_ceil(*every) >= 2).take(MOST).map(step).collect()
}

fn windows(spec: &SampleSpec, readings: usize) -> Vec<LadderStep> {
    let step = |window: usize| {
        let time = spec.rate.map_or(String::new(), |rate| format!(", {} s", plain(window as f64 / rate)));
        LadderStep {
            label: format!("the first {window} of {readings} readings{time}"),
            short: window.to_string(),
            cut: Cut::Reduce(Reduction { window: Some(window), ..Reduction::default() }),
        }
    };
    falling(readings, &SHARES[..6]).into_iter().filter(|window| *window >= 2).map(step).collect()
}

fn area(layout: Layout, shape: &[usize]) -> Option<[usize; 2]> {
    match shape {
        [.., rows, columns] if layout.has_area() => Some([*rows, *columns]),
        _ => None,
    }
}

fn pools(rows: usize, columns: usize) -> Vec<LadderStep> {
    let step = |side: usize| {
        let left = [rows, columns].map(|all| all.div_ceil(side));
        LadderStep {
            label: format!("{} × {} of {rows} × {columns} taxels", left[0], left[1]),
            short: format!("{} × {}", left[0], left[1]),
            cut: Cut::Reduce(Reduction { pool: Some(side), ..Reduction::default() }),
        }
    };
    let fits = |side: &usize| rows.div_ceil(*side).min(columns.div_ceil(*side)) >= 2;
    [2, 3, 4, 6, 8, 12, 16].into_iter().filter(fits).map(step).collect()
}

/// Returns a setting of the network.
fn set(key: &'static str, value: Value, short: impl ToString, label: String) -> LadderStep {
    LadderStep { label, short: short.to_string(), cut: Cut::Set(key, value) }
}

fn widths(all: usize) -> Vec<LadderStep> {
    let halves = (1..).map(|power| all >> power).take_while(|width| *width >= 2).take(5);
    halves.map(|width| set("width", number_of(width), width, format!("width {width} of {all}"))).collect()
}

/// Returns the settings with a half to a sixteenth of the channels, for a network whose channels are multiplied by `width_mult`.
fn narrower(width_mult: f64) -> Vec<LadderStep> {
    let step = |part: u32| {
        let value = Value::Float(width_mult / f64::from(part));
        set(WIDTH_MULT, value, format!("1/{part}"), format!("1/{part} of the channels"))
    };
    [2, 4, 8, 16].map(step).to_vec()
}

fn blocks(all: usize) -> Vec<LadderStep> {
    let fewer = (1..all).rev();
    fewer.map(|count| set("blocks", number_of(count), count, format!("{count} of {all} blocks"))).collect()
}

/// Returns the settings without the last, the last two, … of the blocks or layers that may go.
fn shallower(depth: Depth) -> Vec<LadderStep> {
    let Depth { key, out, left: all } = depth;
    let step = |without: usize| {
        let left = all - without;
        let label = format!("{left} of {all} {}", depth_name(depth));
        set(key, number_of(out + without), left, label)
    };
    (1..=all).map(step).collect()
}

fn depth_name(depth: Depth) -> &'static str {
    if depth.key == WITHOUT_BLOCKS { "identity blocks" } else { "layers that can go" }
}

fn number_of(count: usize) -> Value {
    Value::Integer(i64::try_from(count).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use taxel_zoo::WITHOUT_LAYERS;

    use super::*;

    fn of(axis: Axis, layout: Layout, shape: &[usize], quick: bool) -> Result<Vec<String>, String> {
        let spec = SampleSpec { rate: Some(100.0), ..SampleSpec::new(layout, shape) };
        let number = |key: &str| (key == "width").then_some(64);
        let facts = LadderInputs { spec: &spec, number: &number, width_mult: None, depth: None, quick };
        ladder(axis, &facts).map(|ladder| ladder.steps.into_iter().map(|step| step.short).collect())
    }

    #[test]
    fn settings_fall_from_a_little_less_to_very_little() {
        let series = |axis| of(axis, Layout::Series, &[5, 50], false).unwrap_or_default();
        assert_eq!(series(Axis::Sensors), ["4", "3", "2", "1"]);
        assert_eq!(series(Axis::Rate), ["50 Hz", "25 Hz", "12.5 Hz", "6.25 Hz", "3.12 Hz"]);
        assert_eq!(series(Axis::Window), ["38", "25", "17", "13", "9", "7"]);
        assert_eq!(series(Axis::Bits), ["8", "6", "5", "4", "3", "2", "1"]);
        assert_eq!(series(Axis::Width), ["32", "16", "8", "4", "2"]);
        let image = |axis| of(axis, Layout::Image, &[28, 50], false).unwrap_or_default();
        assert_eq!(image(Axis::Resolution)[..2], ["14 × 25", "10 × 17"]);
        assert_eq!(image(Axis::Sensors).first().map(String::as_str), Some("59"));
        let many = of(Axis::Sensors, Layout::Series, &[28, 9], false).unwrap_or_default();
        assert_eq!(many, ["14", "10", "7", "5", "4", "3", "2", "1"]);
        let quick = of(Axis::Bits, Layout::Series, &[5, 50], true).unwrap_or_default();
        assert_eq!(quick, ["5", "3", "1"]);
    }

    #[test]
    fn a_network_without_a_width_of_its_own_has_shares_of_what_multiplies_it() {
        let spec = SampleSpec::new(Layout::Image, &[28, 50]);
        let of = |width_mult| {
            let facts = LadderInputs {
                spec: &spec,
                number: &|_| None,
                width_mult,
                depth: Some(Depth { key: WITHOUT_BLOCKS, out: 1, left: 2 }),
                quick: false,
            };
            let depth = ladder(Axis::Depth, &facts).map(|ladder| ladder.steps);
            let cuts: Vec<Cut> = depth.unwrap_or_default().into_iter().map(|step| step.cut).collect();
            assert_eq!(cuts, [2, 3].map(|without| Cut::Set("without_blocks", Value::Integer(without))));
            let plain = Depth { key: WITHOUT_LAYERS, out: 0, left: 2 };
            let depth =
                ladder(Axis::Depth, &LadderInputs { depth: Some(plain), ..facts }).map(|ladder| ladder.steps);
            let labels: Vec<String> = depth.unwrap_or_default().into_iter().map(|step| step.label).collect();
            assert_eq!(labels, ["1 of 2 layers that can go", "0 of 2 layers that can go"]);
            ladder(Axis::Width, &facts).map(|ladder| ladder.steps)
        };
        let steps = of(Some(0.5)).unwrap_or_default();
        let cuts: Vec<Cut> = steps.iter().map(|step| step.cut.clone()).collect();
        let want = [0.25, 0.125, 0.0625, 0.03125].map(|width| Cut::Set("width_mult", Value::Float(width)));
        assert_eq!(cuts, want);
        assert_eq!(steps.first().map(|step| step.label.as_str()), Some("1/2 of the channels"));
        assert!(of(None).is_err_and(|why| why.contains("narrower")));
    }

    #[test]
    fn what_has_no_such_axis_is_left_out_with_the_reason() {
        assert!(of(Axis::Rate, Layout::Image, &[4, 4], false).is_err_and(|why| why.contains("no time axis")));
        assert!(
            of(Axis::Resolution, Layout::Series, &[4, 4], false).is_err_and(|why| why.contains("no area"))
        );
        assert!(
            of(Axis::Depth, Layout::Series, &[4, 4], false).is_err_and(|why| why.contains("no plain layer"))
        );
        assert!(
            of(Axis::Sensors, Layout::Series, &[1, 9], false).is_err_and(|why| why.contains("nothing less"))
        );
    }
}
