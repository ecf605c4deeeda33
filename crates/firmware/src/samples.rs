//! Samples that C and taxel make alike, without a file: whole numbers that walk inside a channel's range, times a power
//! of two.

/// How samples are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Number of samples.
    pub count: usize,
    /// Time steps of a sample.
    pub(crate) steps: usize,
    /// The walk of each channel.
    pub(crate) walks: Vec<Walk>,
}

/// The whole numbers of one channel, and their unit as a power of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Walk {
    pub low: i32,
    pub high: i32,
    pub power: i32,
}

/// Bits of the largest whole number.
const BITS: i32 = 15;
/// The first state of the random numbers.
pub(crate) const SEED: u32 = 0x7a5e_1001;

impl Samples {
    /// Makes `count` samples of `ranges.len()` channels × `steps`, each channel inside its range.
    pub fn new(count: usize, ranges: &[[f32; 2]], steps: usize) -> Self {
        Samples { count, steps, walks: ranges.iter().map(Walk::inside).collect() }
    }

    /// Returns the values of all samples, one after the other, channels × time steps.
    pub fn values(&self) -> Vec<f32> {
        let mut random = Random(SEED);
        let mut values = Vec::with_capacity(self.count * self.walks.len() * self.steps);
        for _ in 0..self.count {
            for walk in &self.walks {
                walk.add(&mut random, self.steps, &mut values);
            }
        }
        values
    }
}

impl Walk {
    fn inside(&[low, high]: &[f32; 2]) -> Walk {
        let largest = f64::from(low.abs().max(high.abs()));
        if !(largest > 0.0 && largest.is_finite()) {
            return Walk { low: 0, high: 0, power: 0 };
        }
        let power = (largest.log2().floor() as i32 + 1 - BITS).clamp(-120, 100);
        let unit = f64::from(power).exp2();
        let (low, high) = ((f64::from(low) / unit).ceil() as i32, (f64::from(high) / unit).floor() as i32);
        Walk { low, high: high.max(low), power }
    }

    fn add(&self, random: &mut Random, steps: usize, values: &mut Vec<f32>) {
        let span = (self.high - self.low) as u32;
        let most = span / 8 + 1;
        let mut at = self.low + (random.next() % (span + 1)) as i32;
        let unit = f64::from(self.power).exp2() as f32;
        for _ in 0..steps {
            values.push(at as f32 * unit);
            at += (random.next() % (2 * most + 1)) as i32 - most as i32;
            at = at.clamp(self.low, self.high);
        }
    }
}

/// Marsaglia's xorshift of 32 bits, of which the upper ones are taken.
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 >> 8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_stay_inside_their_ranges_and_move() {
        let ranges = [[0.0, 1023.0], [-0.02, 0.5], [3.0, 3.0], [0.0, 0.0]];
        let samples = Samples::new(20, &ranges, 50);
        let values = samples.values();
        assert_eq!(values.len(), 20 * 4 * 50);
        for (at, series) in values.chunks(50).enumerate() {
            let [low, high] = ranges[at % 4];
            assert!(series.iter().all(|v| (low..=high).contains(v)), "{series:?}");
            assert_eq!(at % 4 < 2, series.iter().any(|v| *v != series[0]), "{series:?}");
        }
    }
}
