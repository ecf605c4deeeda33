//! Writes the channels of a card: each on a line, or where there are many the ones that stand out.

use crate::check::values::ChannelRange;

/// Most channels that are listed one by one; of more, ranges and outliers are.
const EACH: usize = 12;
/// Most outliers that are listed.
const OUTLIERS: usize = 6;
/// A range stands out that is this many times as wide as the median one, or as many times narrower.
const WIDER: f32 = 10.0;
/// A share of values at the lowest or the highest, or of samples without a change, stands out if it is this much above that
/// of the median channel.
const CLIPPED: f64 = 0.1;

/// Returns the lines about the channels.
pub(crate) fn lines(channels: &[ChannelRange]) -> Vec<String> {
    if channels.len() <= EACH {
        return channels.iter().map(line).collect();
    }
    let mut lines = vec![spread(channels)];
    let usual = Usual::of(channels);
    let outliers: Vec<&ChannelRange> = channels.iter().filter(|range| usual.is_left_by(range)).collect();
    lines.extend(outliers.iter().take(OUTLIERS).map(|range| line(range)));
    if outliers.len() > OUTLIERS {
        lines.push(format!("      and {} more that stand out, listed in JSON", outliers.len() - OUTLIERS));
    }
    lines
}

fn line(range: &ChannelRange) -> String {
    format!("{:>4}  {}", range.channel, described(range))
}

fn described(range: &ChannelRange) -> String {
    let (Some(min), Some(max)) = (range.min, range.max) else { return "no finite value".into() };
    let [low, high, stuck] = [range.at_min, range.at_max, range.stuck].map(|share| share * 100.0);
    let note = if min == max {
        "constant".into()
    } else if stuck < 0.05 {
        format!("{low:5.1} % at lowest, {high:5.1} % at highest")
    } else {
        format!("{low:5.1}, {high:.1} % at ends; {stuck:.1} % still")
    };
    format!("{:<22}{note}", format!("{}..{}", short(min), short(max)))
}

/// Says how far the ranges of all channels reach.
fn spread(channels: &[ChannelRange]) -> String {
    let span = |of: fn(&ChannelRange) -> Option<f32>| {
        let values = channels.iter().filter_map(of);
        let (low, high) = values
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low == high { short(low) } else { format!("{} to {}", short(low), short(high)) }
    };
    let count = channels.len();
    if channels.iter().all(|range| range.min.is_none()) {
        return format!("{count}, none with a finite value");
    }
    format!("{count}; lowest values {}, highest {}", span(|range| range.min), span(|range| range.max))
}

/// The median channel.
struct Usual {
    width: f32,
    at_min: f64,
    at_max: f64,
    stuck: f64,
}

impl Usual {
    fn of(channels: &[ChannelRange]) -> Self {
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.0)
        };
        Self {
            width: median(channels.iter().filter_map(width).map(f64::from).collect()) as f32,
            at_min: median(channels.iter().map(|range| range.at_min).collect()),
            at_max: median(channels.iter().map(|range| range.at_max).collect()),
            stuck: median(channels.iter().map(|range| range.stuck).collect()),
        }
    }

    fn is_left_by(&self, range: &ChannelRange) -> bool {
        let Some(width) = width(range) else { return true };
        let is_other_width = width > WIDER * self.width || width * WIDER < self.width;
        width == 0.0
            || is_other_width
            || range.at_min > self.at_min + CLIPPED
            || range.at_max > self.at_max + CLIPPED
            || range.stuck > self.stuck + CLIPPED
    }
}

fn width(range: &ChannelRange) -> Option<f32> {
    Some(range.max? - range.min?)
}

/// Writes a value in five significant digits.
fn short(value: f32) -> String {
    let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if !(-4..7).contains(&digits) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.*}", (4 - digits).max(0) as usize);
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').into();
    }
    text
}
