//! Numbers that tell how the readings of a sample behave.

use taxel_base::exponential::ln;
use taxel_data::Layout;

/// The part of the range that is added to deviations before their logarithm is taken: a dead channel has none.
const FLOOR: f32 = 1e-3;
/// Sums that run beside each other, so that the processor adds several values at a time.
const LANES: usize = 8;

/// Where the channels and the steps of a sample lie in memory: of still images its rows and columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axes {
    /// Number of channels.
    pub channels: usize,
    /// Number of steps.
    pub steps: usize,
    /// Distance of two steps of a channel: 1, or the number of taxels of a frame.
    pub by_step: usize,
    /// Whether steps follow each other in time.
    pub has_time: bool,
}

impl Axes {
    /// Finds the axes of samples of this layout and shape.
    pub fn new(layout: Layout, shape: &[usize]) -> Self {
        let all: usize = shape.iter().product();
        let (steps, by_step) = match (layout, shape) {
            (Layout::Sequence, [time, ..]) => (*time, all / (*time).max(1)),
            (_, [.., last]) => (*last, 1),
            (_, []) => (0, 1),
        };
        Axes { channels: all / steps.max(1), steps, by_step, has_time: layout.has_time() }
    }
}

/// Summarises samples of one layout: the mean, the spread, the roughness and the ends of their readings.
///
/// Of samples with time there are twelve numbers: the mean, the logarithms of the spread of all readings, of the mean spread of a
/// channel, of its mean change from step to step and of the ratio of the two, the lowest and highest reading, the spread of the
/// channels' means, and the ends of the channels' spreads and means. Of a still image there are eight, its rows and columns in
/// place of channels and steps.
///
/// The mean of each channel follows, or each feature, where there are at most 24: else swapped channels would pass unseen.
#[derive(Debug, Clone)]
pub(crate) struct Summary {
    axes: Axes,
    /// Numbers that are each of a single channel or feature.
    single: usize,
    /// One channel whose steps do not lie side by side.
    row: Vec<f32>,
    numbers: [f32; Summary::MOST],
}

/// One channel.
#[derive(Clone, Copy)]
struct Channel {
    mean: f32,
    /// Standard deviation.
    spread: f32,
    /// Root mean square of the changes from step to step.
    change: f32,
    low: f32,
    high: f32,
}

impl Summary {
    /// Most numbers.
    pub(crate) const MOST: usize = Self::TIME + Self::SINGLE;
    /// Numbers of a sample with time, and of a still image, before those of single channels.
    const TIME: usize = 12;
    const STILL: usize = 8;
    /// Most channels that have a number of their own.
    const SINGLE: usize = 24;

    /// Prepares for samples of this layout and shape.
    pub(crate) fn new(layout: Layout, shape: &[usize]) -> Self {
        let axes = Axes::new(layout, shape);
        let row = if axes.by_step == 1 { vec![] } else { vec![0.0; axes.steps] };
        let single = match layout {
            Layout::Features => axes.steps,
            _ if axes.has_time => axes.channels,
            _ => 0,
        };
        let single = if single <= Self::SINGLE { single } else { 0 };
        Summary { axes, single, row, numbers: [0.0; Self::MOST] }
    }

    /// Returns how many numbers there are.
    pub(crate) fn count(&self) -> usize {
        self.shared() + self.single
    }

    /// Returns how many numbers are of all channels together.
    pub(crate) fn shared(&self) -> usize {
        if self.axes.has_time { Self::TIME } else { Self::STILL }
    }

    /// Checks whether number `k` is a logarithm.
    pub(crate) fn is_logarithm(&self, k: usize) -> bool {
        if self.axes.has_time { (1..=4).contains(&k) } else { (1..=5).contains(&k) }
    }

    /// Returns what is added to deviations of readings of that range before their logarithm is taken.
    pub(crate) fn floor(range: f32) -> f32 {
        FLOOR * range
    }

    /// Summarises a sample of readings of that range. Nothing is allocated.
    pub(crate) fn of(&mut self, sample: &[f32], range: f32) -> &[f32] {
        let floor = Self::floor(range);
        let log = |value: f32| ln(value + floor);
        let n = self.axes.channels.max(1) as f32;
        let first = sample.first().copied().unwrap_or(0.0);
        let (mut means, mut spreads, mut changes) = ([0.0f32; 2], [0.0f32; 2], 0.0f32);
        let mut ends = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
        for number in 0..self.axes.channels {
            let channel = self.channel(sample, number);
            if self.single == self.axes.channels {
                self.numbers[self.shared() + number] = channel.mean;
            }
            // Around the first mean, so that the sum of squares keeps its digits far from zero.
            let off = channel.mean - first;
            means = [means[0] + off, means[1] + off * off];
            spreads = [spreads[0] + channel.spread, spreads[1] + channel.spread * channel.spread];
            changes += channel.change;
            let ranges =
                [[channel.low, channel.high], [channel.spread, channel.spread], [channel.mean, channel.mean]];
            for (end, [low, high]) in ends.iter_mut().zip(ranges) {
                *end = [end[0].min(low), end[1].max(high)];
            }
        }
        let [mean_off, square] = means.map(|sum| sum / n);
        let between = (square - mean_off * mean_off).max(0.0);
        let mean = first + mean_off;
        let spread = (spreads[1] / n + between).sqrt();
        let (within, change) = (spreads[0] / n, changes / n);
        let [low, high] = ends[0];
        if self.axes.has_time {
            let rough = log(change) - log(within);
            let [_, [least, most], [bottom, top]] = ends;
            let between = between.sqrt();
            let time = [
                mean,
                log(spread),
                log(within),
                log(change),
                rough,
                low,
                high,
                between,
                least,
                most,
                bottom,
                top,
            ];
            self.numbers[..Self::TIME].copy_from_slice(&time);
        } else {
            let across = self.across(sample);
            let rough = log(change + across) - log(spread);
            let still = [mean, log(spread), log(change), log(across), rough, log(within), low, high];
            self.numbers[..Self::STILL].copy_from_slice(&still);
        }
        self.add_features(sample);
        self.last()
    }

    /// Adds the features of a row; nothing of other samples.
    fn add_features(&mut self, sample: &[f32]) {
        if self.single != self.axes.channels {
            let shared = self.shared();
            self.numbers[shared..][..self.single].copy_from_slice(&sample[..self.single]);
        }
    }

    /// Returns the numbers of the last sample.
    pub(crate) fn last(&self) -> &[f32] {
        &self.numbers[..self.count()]
    }

    fn channel(&mut self, sample: &[f32], number: usize) -> Channel {
        let Axes { steps, by_step, .. } = self.axes;
        if by_step == 1 {
            return Channel::of(&sample[number * steps..][..steps]);
        }
        for (step, value) in self.row.iter_mut().enumerate() {
            *value = sample[step * by_step + number];
        }
        Channel::of(&self.row)
    }

    /// Returns the root mean square of the differences between neighbouring rows, 0 of one row.
    fn across(&self, sample: &[f32]) -> f32 {
        let next = &sample[self.axes.steps.min(sample.len())..];
        let squares = squared_differences(next, sample);
        (squares / next.len().max(1) as f32).sqrt()
    }
}

impl Channel {
    fn of(values: &[f32]) -> Self {
        let (count, first) = (values.len().max(1) as f32, values.first().copied().unwrap_or(0.0));
        let (whole, rest) = values.as_chunks::<LANES>();
        let (mut sums, mut low, mut high) = ([0.0; LANES], [first; LANES], [first; LANES]);
        for piece in whole {
            for lane in 0..LANES {
                sums[lane] += piece[lane] - first;
                low[lane] = least(low[lane], piece[lane]);
                high[lane] = most(high[lane], piece[lane]);
            }
        }
        let mean_off = total(sums, rest.iter().map(|value| value - first)) / count;
        let mut squares = [0.0; LANES];
        for piece in whole {
            for lane in 0..LANES {
                squares[lane] += square(piece[lane] - first - mean_off);
            }
        }
        let squares = total(squares, rest.iter().map(|value| square(value - first - mean_off)));
        let next = values.get(1..).unwrap_or_default();
        let changes = squared_differences(next, values);
        let ends = |lanes: [f32; LANES], end: fn(f32, f32) -> f32| {
            lanes.iter().chain(rest).copied().fold(first, end)
        };
        Channel {
            mean: first + mean_off,
            spread: (squares / count).sqrt(),
            change: (changes / next.len().max(1) as f32).sqrt(),
            low: ends(low, least),
            high: ends(high, most),
        }
    }
}

fn square(value: f32) -> f32 {
    value * value
}

/// Returns the lesser of two numbers, in one instruction.
fn least(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// Returns the greater of two numbers, in one instruction.
fn most(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Sums the squared differences of as many values as `a` has.
fn squared_differences(a: &[f32], b: &[f32]) -> f32 {
    let b = &b[..a.len()];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += square(a[lane] - b[lane]);
        }
    }
    total(sums, rest_a.iter().zip(rest_b).map(|(a, b)| square(a - b)))
}

/// Adds up sums that ran beside each other, and the values of the rest.
fn total(sums: [f32; LANES], rest: impl Iterator<Item = f32>) -> f32 {
    sums.iter().sum::<f32>() + rest.sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(given: &[f32], wanted: &[f64]) {
        assert_eq!(given.len(), wanted.len());
        for (k, (given, wanted)) in given.iter().zip(wanted).enumerate() {
            let given = f64::from(*given);
            assert!(
                (given - wanted).abs() < 1e-5 * wanted.abs().max(1.0),
                "number {k}: {given}, not {wanted}"
            );
        }
    }

    #[test]
    fn numbers_of_two_channels_are_those_by_hand() {
        let mut summary = Summary::new(Layout::Series, &[2, 4]);
        let sample = [1.0, 3.0, 1.0, 3.0, 6.0, 6.0, 6.0, 6.0];
        let log = |value: f64| (value + 0.01).ln();
        let wanted = [
            4.0,
            log((0.5f64 + 4.0).sqrt()),
            log(0.5),
            log(1.0),
            log(1.0) - log(0.5),
            1.0,
            6.0,
            2.0,
            0.0,
            1.0,
            2.0,
            6.0,
            // Of each channel.
            2.0,
            6.0,
        ];
        near(summary.of(&sample, 10.0), &wanted);
        // The same readings as frames: the steps of a taxel lie apart.
        let frames = [1.0, 6.0, 3.0, 6.0, 1.0, 6.0, 3.0, 6.0];
        near(Summary::new(Layout::Sequence, &[4, 1, 2]).of(&frames, 10.0), &wanted);
    }

    #[test]
    fn numbers_of_an_image_know_rows_and_columns() {
        let log = |value: f64| (value + 0.01).ln();
        // Rows 0 4, 2 6: along a row the change is 4, across rows 2.
        let mut summary = Summary::new(Layout::Image, &[2, 2]);
        let given = summary.of(&[0.0, 4.0, 2.0, 6.0], 10.0);
        let spread = log(5f64.sqrt());
        let wanted = [3.0, spread, log(4.0), log(2.0), log(6.0) - spread, log(2.0), 0.0, 6.0];
        near(given, &wanted);
    }

    #[test]
    fn numbers_of_a_row_hold_its_features() {
        let mut summary = Summary::new(Layout::Features, &[3]);
        let wanted = [7.0, -2.0, 5.0];
        assert_eq!(summary.of(&wanted, 10.0)[12..], wanted);
        let counts = [24, 25].map(|channels| Summary::new(Layout::Series, &[channels, 9]).count());
        assert_eq!(counts, [36, 12], "more channels have no number each");
    }

    #[test]
    fn a_small_spread_far_from_zero_keeps_its_digits() {
        let mut summary = Summary::new(Layout::Series, &[1, 100]);
        let sample: Vec<f32> = (0..100).map(|step| 60_000.0 + (step % 2) as f32).collect();
        let numbers = summary.of(&sample, 1.0);
        assert!((numbers[1] - 0.501f32.ln()).abs() < 1e-3 && (numbers[3] - 1.001f32.ln()).abs() < 1e-3);
    }
}
