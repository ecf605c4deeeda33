//! Finds dead, stuck and clipped channels of a recording.

/// Readings in a row at one end of a channel that are a plateau, and the least share of a recording.
const PLATEAU: (usize, f64) = (5, 0.05);
/// Share of the range of a recording that the rest before it may have on the channel that moved the most.
const TOUCHED: f32 = 0.25;

/// Channels of a recording with a fault, by position.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChannelFaults {
    /// They have kept one value since the program began.
    pub dead: Vec<usize>,
    /// They moved before, and have kept one value for the recording, or for its second half off where they began.
    pub stuck: Vec<usize>,
    /// They were at full scale; where that is not known, they rose steeply to a plateau.
    pub clipped: Vec<usize>,
    /// The level that counts as rest was moving, so that the sensor was touched.
    pub touched_at_rest: bool,
}

/// Watches the channels from recording to recording.
pub struct ChannelWatch {
    full_scale: Option<f32>,
    /// Whether each has moved.
    moved: Vec<bool>,
}

impl ChannelWatch {
    pub fn new(channels: usize, full_scale: Option<f32>) -> Self {
        ChannelWatch { full_scale, moved: vec![false; channels] }
    }

    /// Looks at a recording, time step after time step, of which the first `rest` are at rest.
    pub fn look(&mut self, values: &[f32], rest: usize) -> ChannelFaults {
        let channels = self.moved.len().max(1);
        let mut found = ChannelFaults::default();
        let mut most = (0.0, 0.0);
        for at in 0..self.moved.len() {
            let channel: Vec<f32> = values.iter().skip(at).step_by(channels).copied().collect();
            let moves = range(&channel) > 0.0;
            let stops = holds(&channel);
            match (moves, self.moved[at]) {
                (false, false) => found.dead.push(at),
                (false, true) => found.stuck.push(at),
                (true, _) if stops => found.stuck.push(at),
                (true, _) => {}
            }
            if !found.stuck.contains(&at) && self.is_clipped(&channel) {
                found.clipped.push(at);
            }
            self.moved[at] |= moves;
            if range(&channel) > most.0 {
                most = (range(&channel), range(&channel[..rest.min(channel.len())]));
            }
        }
        // Of a sensor that nobody touched the noise at rest is all there is.
        let was_felt = values.len() / channels > 4 * rest;
        found.touched_at_rest = rest > 1 && was_felt && most.1 > TOUCHED * most.0 && self.rises(values, rest);
        found
    }

    /// Checks whether some channel changes within the rest from its beginning to its end, by more than it flickers.
    fn rises(&self, values: &[f32], rest: usize) -> bool {
        let channels = self.moved.len().max(1);
        (0..self.moved.len()).any(|at| {
            let channel: Vec<f32> = values.iter().skip(at).step_by(channels).take(rest).copied().collect();
            let (first, last) = channel.split_at(rest / 2);
            let mean = |part: &[f32]| part.iter().sum::<f32>() / part.len().max(1) as f32;
            (mean(last) - mean(first)).abs() > range(first).max(range(last)) / 2.0 && range(&channel) > 0.0
        })
    }

    fn is_clipped(&self, channel: &[f32]) -> bool {
        match self.full_scale {
            Some(full) => channel.iter().any(|value| value.abs() >= full),
            None => plateaus(channel),
        }
    }
}

fn range(values: &[f32]) -> f32 {
    let low = values.iter().copied().fold(f32::INFINITY, f32::min);
    let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    if values.is_empty() { 0.0 } else { high - low }
}

/// Checks whether a channel keeps one value for its second half that is not its first.
fn holds(channel: &[f32]) -> bool {
    let half = &channel[channel.len() / 2..];
    half.len() > 1 && range(half) == 0.0 && half.first() != channel.first()
}

/// Checks for a plateau at the highest value whose edge is steeper than the finest step of the channel: a press that is cut off.
fn plateaus(channel: &[f32]) -> bool {
    let high = channel.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let steps = channel.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
    let finest = steps.fold(f32::INFINITY, f32::min);
    let least = PLATEAU.0.max((PLATEAU.1 * channel.len() as f64) as usize);
    let mut begin = 0;
    while begin < channel.len() {
        let run = channel[begin..].iter().take_while(|value| **value == channel[begin]).count();
        let edges = [begin.checked_sub(1), Some(begin + run)];
        let steep =
            edges.iter().flatten().filter_map(|at| channel.get(*at)).any(|edge| high - edge >= 2.0 * finest);
        if channel[begin] == high && run >= least && steep && run < channel.len() {
            return true;
        }
        begin += run;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a value of a press of 100 readings, 20 of them at rest.
    fn press(t: usize) -> f32 {
        (0.03 * t as f32).sin() * if t < 20 { 0.0 } else { 100.0 } + 0.01 * ((t * 7) % 5) as f32
    }

    fn recording(channels: usize, value: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        (0..100 * channels).map(|i| value(i / channels, i % channels)).collect()
    }

    #[test]
    fn dead_stuck_and_clipped_channels_are_told_apart() {
        let value = |t: usize, channel: usize| match channel {
            0 => press(t),
            1 => 3.0,
            2 => press(t.min(40)),
            3 => press(t).min(70.0),
            // Coarse, and not cut off: it comes to its top by single steps.
            _ => (press(t) / 10.0).round(),
        };
        let mut watch = ChannelWatch::new(5, None);
        let found = watch.look(&recording(5, value), 20);
        assert_eq!((found.dead, found.stuck, found.clipped), (vec![1], vec![2], vec![3]));
        assert!(!found.touched_at_rest);
        // One that has moved is stuck when it moves no more.
        let found = watch.look(&recording(5, |t, channel| if channel == 0 { 5.0 } else { press(t) }), 20);
        assert_eq!((found.dead, found.stuck), (vec![], vec![0]));
    }

    #[test]
    fn a_known_full_scale_is_what_counts() {
        let mut watch = ChannelWatch::new(1, Some(1023.0));
        assert_eq!(watch.look(&recording(1, |t, _| press(t).min(70.0)), 0).clipped, [0; 0]);
        let peak = |t: usize, _: usize| if t == 50 { 1023.0 } else { press(t) };
        assert_eq!(watch.look(&recording(1, peak), 0).clipped, [0]);
    }

    #[test]
    fn a_rest_that_rises_was_touched() {
        let mut watch = ChannelWatch::new(1, None);
        assert!(watch.look(&recording(1, |t, _| t.min(30) as f32 + press(t) / 1e3), 20).touched_at_rest);
        let noise = |t: usize, _: usize| ((t * 31) % 7) as f32;
        assert!(!watch.look(&recording(1, noise), 20).touched_at_rest, "nobody touched it at all");
    }
}
