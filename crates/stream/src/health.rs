//! Which channels are dead, stuck or saturated.

use taxel_data::SampleSpec;

/// Fewest time steps in which a value does not change before it counts as still.
const LEAST: u64 = 20;
/// Distance from a known level at rest that still counts as rest, as a share of full scale, or of the level.
const OFF: f32 = 0.02;

/// Faults of a value that does not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// It lies at rest and has never moved since the stream began: dead, or never touched so far.
    Dead,
    /// It lies at full scale or elsewhere off its rest, or at rest where it has always flickered before.
    Stuck,
}

/// History of one value of the time steps.
#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    last: f32,
    /// Time steps that it has been the same in, up to the last.
    run: u64,
    /// The longest such run that has ended.
    longest: u64,
    /// Time steps since it was at full scale, that one included; 0 for never.
    saturated: u64,
}

/// Watches each value of the time steps of a stream, in a fixed time per value.
///
/// A value is still when it is the same, to the last bit, in as many time steps as a window has (at least 20).
#[derive(Debug, Clone)]
pub struct Health {
    channels: Vec<Channel>,
    readings: u64,
    /// Time steps that make a value still.
    span: u64,
    full_scale: Option<f32>,
    /// Known levels at rest, and the distance that still counts as rest; without any, the first time step is at rest.
    known_rest: Option<(Vec<f32>, f32)>,
    rest: Vec<f32>,
}

impl Health {
    /// Watches time steps of this kind; `full_scale` is the largest possible value.
    pub fn new(spec: &SampleSpec, full_scale: Option<f32>) -> Self {
        let (before, ticks, after) = spec.around_time();
        let each = before * after;
        let known_rest = spec.rest.as_ref().and_then(|rest| match rest.as_slice() {
            [one] => Some(vec![*one; each]),
            several if several.len() == each => Some(several.to_vec()),
            _ => None,
        });
        let known_rest = known_rest.map(|rest| {
            let most = rest.iter().fold(0.0f32, |most, level| most.max(level.abs()));
            (rest, OFF * full_scale.unwrap_or(most))
        });
        Health {
            channels: vec![Channel::default(); each],
            readings: 0,
            span: (ticks as u64).max(LEAST),
            full_scale,
            known_rest,
            rest: vec![0.0; each],
        }
    }

    /// Forgets everything: another recording begins.
    pub fn begin(&mut self) {
        self.channels.fill(Channel::default());
        self.readings = 0;
    }

    /// Takes a time step; one of another length is ignored.
    pub fn push(&mut self, reading: &[f32]) {
        if reading.len() != self.channels.len() {
            return;
        }
        if self.readings == 0 {
            self.rest.copy_from_slice(reading);
        }
        self.readings += 1;
        for (channel, value) in self.channels.iter_mut().zip(reading) {
            if self.readings > 1 && channel.last == *value {
                channel.run += 1;
            } else {
                (channel.longest, channel.run) = (channel.longest.max(channel.run), 1);
            }
            channel.last = *value;
            let full = self.full_scale.is_some_and(|full| *value >= full);
            channel.saturated = if full { 1 } else { channel.saturated + u64::from(channel.saturated > 0) };
        }
    }

    /// Returns the fault of value `at` of the time steps, as of the last one.
    pub fn condition(&self, at: usize) -> Option<Condition> {
        let channel = self.channels.get(at)?;
        if channel.run < self.span {
            return None;
        }
        let (rest, off) = match &self.known_rest {
            Some((rest, off)) => (rest[at], *off),
            None => (self.rest[at], 0.0),
        };
        let full = self.full_scale.is_some_and(|full| channel.last >= full);
        let flickered = channel.longest < self.span / 4 && self.readings - channel.run >= 2 * self.span;
        if full || (channel.last - rest).abs() > off || flickered {
            return Some(Condition::Stuck);
        }
        (channel.run == self.readings).then_some(Condition::Dead)
    }

    /// Checks whether value `at` was at full scale in one of the last `readings`.
    pub fn is_saturated(&self, at: usize, readings: usize) -> bool {
        self.channels.get(at).is_some_and(|channel| (1..=readings as u64).contains(&channel.saturated))
    }

    /// Returns the values of a time step that are in this condition, by their position.
    pub fn in_condition(&self, condition: Condition) -> impl Iterator<Item = usize> + Clone {
        (0..self.channels.len()).filter(move |at| self.condition(*at) == Some(condition))
    }

    /// Returns the values of a time step that were at full scale in one of the last `readings`, by their position.
    pub fn saturated(&self, readings: usize) -> impl Iterator<Item = usize> + Clone {
        (0..self.channels.len()).filter(move |at| self.is_saturated(*at, readings))
    }
}

#[cfg(test)]
mod tests {
    use taxel_data::Layout;

    use super::*;

    fn health(channels: usize, rest: Option<Vec<f32>>, full: Option<f32>) -> Health {
        Health::new(&SampleSpec { rest, ..SampleSpec::new(Layout::Series, &[channels, 24]) }, full)
    }

    /// Returns the conditions after `readings` of what `value` says of time and channel.
    fn after(
        health: &mut Health,
        readings: usize,
        value: impl Fn(usize, usize) -> f32,
    ) -> Vec<Option<Condition>> {
        let channels = health.channels.len();
        for t in 0..readings {
            let reading: Vec<f32> = (0..channels).map(|c| value(t, c)).collect();
            health.push(&reading);
        }
        (0..channels).map(|c| health.condition(c)).collect()
    }

    #[test]
    fn what_never_moves_is_dead_and_what_stands_off_its_rest_is_stuck() {
        let (dead, stuck) = (Some(Condition::Dead), Some(Condition::Stuck));
        let value = |t: usize, channel: usize| match channel {
            0 => 7.0,
            // Pressed once, and untouched since: nothing is wrong.
            1 => {
                if (10..20).contains(&t) {
                    t as f32
                } else {
                    3.0
                }
            }
            2 => t.min(30) as f32,
            3 => t as f32,
            // Noise at rest that ends.
            4 => {
                if t < 60 {
                    5.0 + (t % 2) as f32
                } else {
                    5.0
                }
            }
            _ => 100.0,
        };
        let mut watched = health(6, None, Some(100.0));
        assert_eq!(after(&mut watched, 23, value), [None; 6], "a window has 24 readings");
        watched.begin();
        assert_eq!(after(&mut watched, 90, value), [dead, None, stuck, None, stuck, stuck]);
        assert_eq!(watched.in_condition(Condition::Stuck).collect::<Vec<_>>(), [2, 4, 5]);
    }

    #[test]
    fn a_rest_that_is_told_may_be_missed_a_little() {
        let value = |_: usize, channel: usize| [101.0, 120.0][channel];
        let mut watched = health(2, Some(vec![100.0]), Some(1000.0));
        assert_eq!(after(&mut watched, 24, value)[0], Some(Condition::Dead));
        assert_eq!(watched.condition(1), Some(Condition::Dead), "20 of 1000 is no more than 2 %");
        let mut watched = health(2, Some(vec![100.0, 99.0]), None);
        assert_eq!(after(&mut watched, 24, value), [Some(Condition::Dead), Some(Condition::Stuck)]);
    }

    #[test]
    fn saturation_is_of_the_window() {
        let mut watched = health(1, None, Some(10.0));
        for (value, saturated) in
            [(9.0, false), (10.0, true), (1.0, true), (2.0, true), (3.0, false), (11.0, true)]
        {
            watched.push(&[value]);
            assert_eq!(watched.is_saturated(0, 3), saturated, "{value}");
        }
        let mut unknown = health(1, None, None);
        unknown.push(&[1e9]);
        assert_eq!(unknown.saturated(3).count(), 0);
    }
}
