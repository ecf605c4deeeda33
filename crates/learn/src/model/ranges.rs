//! The values that a model has met in training, channel by channel, and samples far outside of them.

use serde::{Deserialize, Serialize};
use taxel_base::Layout;

/// The least and the largest value of each channel of the training samples, in the sensor's units.
///
/// Channels are those of a series, those of all fingers one after the other, the features, or the colours; taxels of an
/// array are one channel together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Ranges(Vec<[f32; 2]>);

/// Share of a constant channel's value that it may move without being far outside.
const STILL: f32 = 1e-3;
/// Most channels that a message names.
const NAMED: usize = 3;

/// A channel with values far outside the training's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideRange {
    /// Position of the channel, from 0.
    pub channel: usize,
    /// The value that is farthest outside.
    pub value: f32,
    /// The least and the largest value in training.
    pub trained: [f32; 2],
}

impl Ranges {
    /// Finds the ranges of `samples`, each row-major and of this shape.
    pub fn of<'s>(samples: impl Iterator<Item = &'s [f32]>, layout: Layout, shape: &[usize]) -> Self {
        let mut ranges = vec![[f32::INFINITY, f32::NEG_INFINITY]; channels(layout, shape)];
        for sample in samples {
            let each = (sample.len() / ranges.len().max(1)).max(1);
            for ([least, most], values) in ranges.iter_mut().zip(sample.chunks(each)) {
                for value in values {
                    *least = least.min(*value);
                    *most = most.max(*value);
                }
            }
        }
        ranges.retain(|[least, most]| least <= most);
        Ranges(ranges)
    }

    /// Returns the ranges of the values of both; those of one where the other knows none.
    pub(crate) fn with(&self, other: &Self) -> Self {
        if self.0.len() != other.0.len() {
            return if self.is_empty() { other.clone() } else { self.clone() };
        }
        let both = self.0.iter().zip(&other.0);
        Ranges(both.map(|([a, b], [least, most])| [a.min(*least), b.max(*most)]).collect())
    }

    /// Returns the least and the largest value of each channel.
    pub fn channels(&self) -> &[[f32; 2]] {
        &self.0
    }

    /// Checks whether none is known, as of a model of an older version.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Lists the channels of a raw sample that are far outside: farther than the whole range of training is wide.
    pub fn outside<'r>(&'r self, sample: &'r [f32]) -> impl Iterator<Item = OutsideRange> + 'r {
        let each = (sample.len() / self.0.len().max(1)).max(1);
        self.0.iter().zip(sample.chunks(each)).enumerate().filter_map(|(channel, (&trained, values))| {
            let [least, most] = trained;
            let beyond = |value: f32| (least - value).max(value - most);
            let value = values.iter().copied().max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)))?;
            let width = (most - least).max(STILL * least.abs().max(most.abs()));
            (beyond(value) > width).then_some(OutsideRange { channel, value, trained })
        })
    }

    /// Says which of many samples hold values far outside; none where none does. `names` are the channels', if they have any.
    pub fn warning<'s>(&self, samples: impl Iterator<Item = &'s [f32]>, names: &[String]) -> Option<String> {
        let (mut all, mut found) = (0, 0);
        let mut worst: Vec<Option<OutsideRange>> = vec![None; self.0.len()];
        for sample in samples {
            all += 1;
            let before = found;
            for outside in self.outside(sample) {
                found = before + 1;
                let known = &mut worst[outside.channel];
                if known.is_none_or(|known| outside.distance() > known.distance()) {
                    *known = Some(outside);
                }
            }
        }
        let worst: Vec<OutsideRange> = worst.into_iter().flatten().collect();
        let named: Vec<String> = worst.iter().take(NAMED).map(|outside| outside.words(names)).collect();
        let more = worst.len().saturating_sub(NAMED);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        (found > 0).then(|| {
            format!(
                "{found} of {all} samples hold values far outside those of the training: {}{more}; compare unit, full \
                 scale and sensor",
                named.join(", ")
            )
        })
    }
}

impl OutsideRange {
    /// Says the channel, its value and its range in training: `channel 2 (thumb) at 812, in training -3 to 98`.
    pub fn words(&self, names: &[String]) -> String {
        let OutsideRange { channel, value, trained: [least, most] } = self;
        let name = names.get(*channel).map_or(String::new(), |name| format!(" ({name})"));
        format!("channel {channel}{name} at {value}, in training {least} to {most}")
    }

    fn distance(&self) -> f32 {
        let [least, most] = self.trained;
        (least - self.value).max(self.value - most)
    }
}

/// Returns the number of channels that have a range of their own.
fn channels(layout: Layout, shape: &[usize]) -> usize {
    match layout {
        Layout::Features | Layout::Series | Layout::Colour => shape.first().copied().unwrap_or(0),
        Layout::Fingers => shape.iter().take(2).product(),
        Layout::Image | Layout::Sequence => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_far_outside_is_named_with_its_channel() {
        let training = [[0.0, 1.0, 5.0, 5.0], [0.5, 2.0, 5.0, 5.0]];
        let ranges = Ranges::of(training.iter().map(|sample| &sample[..]), Layout::Series, &[2, 2]);
        assert_eq!(ranges, Ranges(vec![[0.0, 2.0], [5.0, 5.0]]));
        // Within the width of the range, 2, and within a thousandth of a constant.
        assert_eq!(ranges.outside(&[-2.0, 4.0, 5.004, 4.996]).count(), 0);
        let [one, two] = ranges.outside(&[-2.1, 4.2, 5.0, 6.0]).collect::<Vec<_>>()[..] else { panic!() };
        assert_eq!((one.channel, one.value, two.channel, two.value), (0, 4.2, 1, 6.0));
        let samples: [&[f32]; 3] = [&[0.0; 4], &[0.0, 1.0, 5.0, 5.0], &[1000.0, 1.0, 5.0, 5.0]];
        let names = ["thumb".to_string(), "index".into()];
        let text = ranges.warning(samples.into_iter(), &names).unwrap_or_default();
        assert!(text.starts_with("2 of 3 samples"), "{text}");
        assert!(
            text.contains("channel 0 (thumb) at 1000, in training 0 to 2, channel 1 (index) at 0, in"),
            "{text}"
        );
        assert_eq!(ranges.warning(training.iter().map(|sample| &sample[..]), &[]), None);
    }

    #[test]
    fn each_layout_has_its_channels() {
        let counts = [
            (Layout::Features, &[7][..], 7),
            (Layout::Series, &[5, 50], 5),
            (Layout::Fingers, &[2, 3, 10], 6),
            (Layout::Colour, &[3, 4, 4], 3),
            (Layout::Image, &[4, 4], 1),
            (Layout::Sequence, &[9, 4, 4], 1),
        ];
        for (layout, shape, count) in counts {
            assert_eq!(channels(layout, shape), count, "{layout}");
        }
    }
}
