//! The channels of a card, each on a line, or where there are many the ones that stand out.

use crate::check::values::ChannelRange;

/// Channels that are listed one by one; of more, ranges and outliers are.
const EACH: usize = 12;
/// Outliers that are listed.
const OUTLIERS: usize = 6;
/// A range this many times as wide as the median one, or as many times narrower, stands out.
const WIDER: f32 = 10.0;
/// A share of values at the lowest or the highest, or of samples without a change, stands out where it is this much
/// above the median channel's.
const CLIPPED: f64 = 0.1;

/// Lines about the channels.
pub(crate) fn lines(channels: &[ChannelRange]) -> Vec<String> {
    if channels.len() <= EACH {
        return channels.iter().map(|own| format!("{:>4}  {}", own.channel, described(own))).collect();
    }
    let mut lines = vec![spread(channels)];
    let usual = Usual::of(channels);
    let outliers: Vec<&ChannelRange> = channels.iter().filter(|own| usual.is_left_by(own)).collect();
    let listed = outliers.iter().take(OUTLIERS);
    lines.extend(listed.map(|own| format!("{:>4}  {}", own.channel, described(own))));
    if outliers.len() > OUTLIERS {
        lines.push(format!("      and {} more that stand out, listed in JSON", outliers.len() - OUTLIERS));
    }
    lines
}

fn described(own: &ChannelRange) -> String {
    let (Some(min), Some(max)) = (own.min, own.max) else { return "no finite value".into() };
    let note = if min == max {
        "constant".into()
    } else {
        let [low, high, stuck] = [own.at_min, own.at_max, own.stuck].map(|share| share * 100.0);
        match stuck < 0.05 {
            true => format!("{low:5.1} % at lowest, {high:5.1} % at highest"),
            false => format!("{low:5.1}, {high:.1} % at ends; {stuck:.1} % still"),
        }
    };
    format!("{:<22}{note}", format!("{}..{}", short(min), short(max)))
}

/// How far the ranges of all channels reach.
fn spread(channels: &[ChannelRange]) -> String {
    let span = |of: fn(&ChannelRange) -> Option<f32>| {
        let values = channels.iter().filter_map(of);
        let (low, high) = values
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low == high { short(low) } else { format!("{} to {}", short(low), short(high)) }
    };
    let count = channels.len();
    match channels.iter().any(|own| own.min.is_some()) {
        false => format!("{count}, none with a finite value"),
        true => format!("{count}; lowest values {}, highest {}", span(|own| own.min), span(|own| own.max)),
    }
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
            at_min: median(channels.iter().map(|own| own.at_min).collect()),
            at_max: median(channels.iter().map(|own| own.at_max).collect()),
            stuck: median(channels.iter().map(|own| own.stuck).collect()),
        }
    }

    fn is_left_by(&self, own: &ChannelRange) -> bool {
        let Some(width) = width(own) else { return true };
        let is_other_width = width > WIDER * self.width || width * WIDER < self.width;
        width == 0.0
            || is_other_width
            || own.at_min > self.at_min + CLIPPED
            || own.at_max > self.at_max + CLIPPED
            || own.stuck > self.stuck + CLIPPED
    }
}

fn width(own: &ChannelRange) -> Option<f32> {
    Some(own.max? - own.min?)
}

/// Five significant digits.
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
