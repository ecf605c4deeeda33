//! Changes the strength, the speed and the noise of a recording.

use rand::RngExt;
use rand_distr::StandardNormal;
use taxel_base::seed::Rng;

/// The changes of the readings of one sample: a stretch and a move in time, then a gain, then noise.
#[derive(Debug, Clone)]
pub struct ReadingsChange {
    /// Factor of all readings above rest.
    pub gain: f64,
    /// Duration, as a share of what it was.
    pub duration: f64,
    /// Move towards the end, as a share of the recording.
    pub shift: f64,
    /// SD of the noise, as a share of the range.
    pub jitter: f64,
    /// Draws the noise.
    pub(super) rng: Rng,
}

impl ReadingsChange {
    /// Changes readings `[channels, steps]`, row-major, in place. `rest` holds the reading of each channel without contact, or those
    /// that channels have in turn, such as the taxels of each frame; `span` is the range of the readings.
    ///
    /// # Panics
    ///
    /// If there are no whole channels of `steps` readings, or no whole turns of rests.
    pub fn apply(&mut self, readings: &mut [f32], steps: usize, rest: &[f32], span: f32) {
        let channels = readings.len() / steps.max(1);
        assert_eq!(readings.len(), channels * steps, "whole channels");
        let is_whole = !rest.is_empty() && channels.is_multiple_of(rest.len());
        assert!(is_whole, "{} rests of {channels} channels", rest.len());
        if self.duration != 1.0 || self.shift != 0.0 {
            readings.chunks_exact_mut(steps).for_each(|channel| self.move_in_time(channel));
        }
        if self.gain != 1.0 {
            for (channel, rest) in readings.chunks_exact_mut(steps).zip(rest.iter().cycle()) {
                channel.iter_mut().for_each(|v| *v = rest + self.gain as f32 * (*v - rest));
            }
        }
        if self.jitter > 0.0 {
            let sd = self.jitter as f32 * span;
            readings.iter_mut().for_each(|v| *v += sd * self.rng.sample::<f32, _>(StandardNormal));
        }
    }

    /// Reads a channel at the moments that the stretch and the move ask for, between two readings by a straight line.
    fn move_in_time(&self, channel: &mut [f32]) {
        let (clean, last) = (channel.to_vec(), channel.len() as f64 - 1.0);
        for (step, value) in channel.iter_mut().enumerate() {
            let moved = step as f64 - last / 2.0 - self.shift * clean.len() as f64;
            let from = (last / 2.0 + moved / self.duration).clamp(0.0, last);
            let (before, share) = (from.floor() as usize, from.fract() as f32);
            let after = (before + 1).min(clean.len() - 1);
            // A share of zero would make NaN of an infinity.
            *value = clean[before];
            if share > 0.0 {
                *value += share * (clean[after] - clean[before]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ReadingsChange;

    const REST: [f32; 2] = [0.0, 10.0];

    fn change(gain: f64, duration: f64, shift: f64, jitter: f64) -> ReadingsChange {
        ReadingsChange { gain, duration, shift, jitter, rng: taxel_base::seed::rng(0, "test") }
    }

    fn applied(mut change: ReadingsChange) -> Vec<f32> {
        let mut readings = vec![0.0, 1.0, 2.0, 3.0, 4.0, 10.0, 12.0, 14.0, 16.0, 18.0];
        change.apply(&mut readings, 5, &REST, 20.0);
        readings
    }

    #[test]
    fn a_gain_multiplies_what_is_above_rest() {
        let doubled = applied(change(2.0, 1.0, 0.0, 0.0));
        assert_eq!(doubled, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 14.0, 18.0, 22.0, 26.0]);
    }

    #[test]
    fn taxels_have_their_own_rest_in_every_frame() {
        let mut frames = vec![1.0, 11.0, 3.0, 13.0, 5.0, 15.0];
        change(2.0, 1.0, 0.0, 0.0).apply(&mut frames, 1, &REST, 20.0);
        assert_eq!(frames, [2.0, 12.0, 6.0, 16.0, 10.0, 20.0]);
    }

    #[test]
    fn a_move_in_time_repeats_the_ends() {
        let later = applied(change(1.0, 1.0, 0.2, 0.0));
        assert_eq!(later, [0.0, 0.0, 1.0, 2.0, 3.0, 10.0, 10.0, 12.0, 14.0, 16.0]);
        let earlier = applied(change(1.0, 1.0, -0.4, 0.0));
        assert_eq!(earlier[..5], [2.0, 3.0, 4.0, 4.0, 4.0]);
    }

    #[test]
    fn a_stretch_keeps_the_middle() {
        let slower = applied(change(1.0, 2.0, 0.0, 0.0));
        assert_eq!(slower[..5], [1.0, 1.5, 2.0, 2.5, 3.0]);
        let faster = applied(change(1.0, 0.5, 0.0, 0.0));
        assert_eq!(faster[..5], [0.0, 0.0, 2.0, 4.0, 4.0]);
    }

    #[test]
    fn noise_has_the_deviation_that_is_asked_for() {
        let mut readings = vec![5.0; 20_000];
        change(1.0, 1.0, 0.0, 0.05).apply(&mut readings, 20_000, &[0.0], 20.0);
        let mean = readings.iter().sum::<f32>() / 20_000.0;
        let variance = readings.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / 20_000.0;
        assert!((mean - 5.0).abs() < 0.03 && (variance.sqrt() - 1.0).abs() < 0.02, "{mean} {variance}");
    }
}
