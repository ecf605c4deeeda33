//! Measures all values for a card in one pass: ranges, saturation, constant taxels.

use crate::dataset::dataset::Dataset;
use ndarray::Axis;
use serde::Serialize;
use taxel_base::Layout;

/// Range of one channel over all samples and times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelRange {
    /// Index along the channel axis.
    pub channel: usize,
    /// Lowest finite value; none if there is no finite value.
    pub min: Option<f32>,
    /// Highest finite value.
    pub max: Option<f32>,
    /// Share of finite values equal to the lowest, 0..1.
    pub at_min: f64,
    /// Share of finite values equal to the highest, 0..1: near 0 unless the sensor saturates.
    pub at_max: f64,
    /// Share of samples with time in which it keeps one value, 0..1: near 0 unless it sticks or has no contact.
    pub stuck: f64,
}

/// Lowest and highest finite value, and the number of values at each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    min: f32,
    max: f32,
    at_min: usize,
    at_max: usize,
    count: usize,
}

impl Extent {
    const EMPTY: Self = Self { min: f32::INFINITY, max: f32::NEG_INFINITY, at_min: 0, at_max: 0, count: 0 };

    fn add(&mut self, value: f32) {
        self.count += 1;
        if value < self.min {
            (self.min, self.at_min) = (value, 0);
        }
        if value > self.max {
            (self.max, self.at_max) = (value, 0);
        }
        self.at_min += usize::from(value == self.min);
        self.at_max += usize::from(value == self.max);
    }

    pub(crate) fn range(&self) -> Option<[f32; 2]> {
        (self.count > 0).then_some([self.min, self.max])
    }

    pub(crate) fn shares(&self) -> [f64; 2] {
        [self.at_min, self.at_max].map(|n| n as f64 / self.count.max(1) as f64)
    }

    fn is_constant(&self) -> bool {
        self.count > 0 && self.min == self.max
    }
}

/// Statistics of all values.
pub(crate) struct ValueStatistics {
    pub all: Extent,
    pub taxels: Vec<Extent>,
    channels: Vec<Extent>,
    /// Number of samples in which each channel keeps one value over time.
    stuck: Vec<usize>,
    samples: usize,
    pub nan: usize,
    pub infinite: usize,
    pub constant_samples: Vec<usize>,
}

impl ValueStatistics {
    pub(crate) fn of(data: &Dataset) -> Self {
        let shape = data.sample_shape();
        let size: usize = shape.iter().product();
        let layout = data.spec.layout;
        let last: usize = shape.iter().rev().take(1).product();
        let last_two: usize = shape.iter().rev().take(2).product();
        // Taxel and channel of the j-th value of a sample.
        let taxel = |j: usize| match layout {
            Layout::Series | Layout::Fingers => j / last,
            Layout::Features => j,
            Layout::Image | Layout::Colour | Layout::Sequence => j % last_two,
        };
        let channel = |j: usize| match layout {
            Layout::Colour => Some(j / last_two),
            Layout::Series | Layout::Fingers | Layout::Features => Some(taxel(j)),
            Layout::Image | Layout::Sequence => None,
        };
        // In four bytes each, since for few long recordings these are as large as the recordings.
        let taxel_of: Vec<u32> = (0..size).map(|j| taxel(j) as u32).collect();
        let channel_of: Vec<u32> = (0..size).map_while(channel).map(|channel| channel as u32).collect();
        let length = |of: &[u32]| of.iter().max().map_or(0, |last| *last as usize + 1);
        let channels = length(&channel_of);
        let has_time = matches!(layout, Layout::Series | Layout::Fingers) && last > 1;
        let mut values = Self {
            all: Extent::EMPTY,
            taxels: vec![Extent::EMPTY; length(&taxel_of)],
            channels: vec![Extent::EMPTY; channels],
            stuck: vec![0; channels],
            samples: data.x.len_of(Axis(0)),
            nan: 0,
            infinite: 0,
            constant_samples: Vec::new(),
        };
        for (row, sample) in data.x.outer_iter().enumerate() {
            let mut extent = Extent::EMPTY;
            for (j, value) in sample.iter().enumerate() {
                values.nan += usize::from(value.is_nan());
                values.infinite += usize::from(value.is_infinite());
                if !value.is_finite() {
                    continue;
                }
                extent.add(*value);
                values.all.add(*value);
                values.taxels[taxel_of[j] as usize].add(*value);
                if let Some(channel) = channel_of.get(j) {
                    values.channels[*channel as usize].add(*value);
                }
            }
            if extent.is_constant() {
                values.constant_samples.push(row);
            }
            if let (true, Some(sample)) = (has_time, sample.as_slice()) {
                let stuck = sample.chunks_exact(last).map(|channel| channel.iter().all(|v| *v == channel[0]));
                values.stuck.iter_mut().zip(stuck).for_each(|(count, is)| *count += usize::from(is));
            }
        }
        values
    }

    pub(crate) fn channels(&self) -> Vec<ChannelRange> {
        let range = |(channel, extent): (usize, &Extent)| ChannelRange {
            channel,
            min: extent.range().map(|[min, _]| min),
            max: extent.range().map(|[_, max]| max),
            at_min: extent.shares()[0],
            at_max: extent.shares()[1],
            stuck: self.stuck[channel] as f64 / self.samples.max(1) as f64,
        };
        self.channels.iter().enumerate().map(range).collect()
    }

    pub(crate) fn constant_taxels(&self, data: &Dataset) -> Vec<Vec<usize>> {
        // Channels of a finger, or taxels of a row.
        let width = match (data.spec.layout, data.sample_shape()) {
            (Layout::Features | Layout::Series, _) => None,
            (Layout::Fingers, shape) => shape.get(1),
            (Layout::Image | Layout::Colour | Layout::Sequence, shape) => shape.last(),
        };
        let place = |taxel: usize| width.map_or(vec![taxel], |width| vec![taxel / width, taxel % width]);
        let constant = self.taxels.iter().enumerate().filter(|(_, extent)| extent.is_constant());
        constant.map(|(taxel, _)| place(taxel)).collect()
    }
}
