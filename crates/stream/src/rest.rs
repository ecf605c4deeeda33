//! The level at rest that is taken off the readings of a stream, as it was off the recordings of the training.

use taxel_data::{SampleSpec, Tare};

use crate::contact::FOLLOWED;

/// Readings whose mean is the level at rest, where the training had an array of resting values.
const STEPS: usize = 10;

/// Finds the level at rest of each value of a time step.
#[derive(Debug, Clone)]
pub(crate) struct RestLevel {
    steps: usize,
    seen: usize,
    /// Sums of the readings so far; from `steps` on, the level.
    level: Vec<f64>,
}

impl RestLevel {
    /// Looks for the rest in the first `steps` readings, or as many as the training took; none for a model that reads what the
    /// sensor gives, and for 0.
    pub fn new(spec: &SampleSpec, steps: Option<usize>) -> Option<Self> {
        let of_training = match spec.tare.as_ref()? {
            Tare::Recording { steps } => *steps,
            Tare::Array(_) => STEPS,
            Tare::Off => return None,
        };
        let (before, _, after) = spec.around_time();
        let steps = steps.unwrap_or(of_training);
        (steps > 0).then(|| RestLevel { steps, seen: 0, level: vec![0.0; before * after] })
    }

    /// Forgets the level: the next readings are at rest.
    pub fn begin(&mut self) {
        self.seen = 0;
        self.level.fill(0.0);
    }

    /// Checks whether so many readings have come.
    pub fn is_known(&self) -> bool {
        self.seen >= self.steps
    }

    /// Takes a reading; a known level follows it if nothing is touched. `is_touching` is not known without a contact judge.
    pub fn push(&mut self, reading: &[f32], is_touching: Option<bool>) {
        if !self.is_known() {
            self.level.iter_mut().zip(reading).for_each(|(sum, value)| *sum += f64::from(*value));
            self.seen += 1;
            if self.is_known() {
                let steps = self.steps as f64;
                self.level.iter_mut().for_each(|sum| *sum /= steps);
            }
        } else if is_touching == Some(false) {
            let step = |(level, value): (&mut f64, &f32)| *level += (f64::from(*value) - *level) / FOLLOWED;
            self.level.iter_mut().zip(reading).for_each(step);
        }
    }

    /// Takes the level off time steps of values `[before, ticks, after]`.
    pub fn take_off(&self, sample: &mut [f32], (before, ticks, after): (usize, usize, usize)) {
        let rows = sample.chunks_exact_mut((ticks * after).max(1)).take(before);
        for (values, level) in rows.zip(self.level.chunks_exact(after.max(1))) {
            for reading in values.chunks_exact_mut(after.max(1)) {
                reading.iter_mut().zip(level).for_each(|(value, level)| {
                    *value = (f64::from(*value) - level) as f32;
                });
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use taxel_data::Layout;

    use super::*;

    fn series(tare: Option<Tare>) -> SampleSpec {
        SampleSpec { tare, ..SampleSpec::new(Layout::Series, &[2, 3]) }
    }

    #[test]
    fn the_mean_of_the_first_readings_is_taken_off_each_channel() {
        let mut rest = RestLevel::new(&series(Some(Tare::Recording { steps: 2 })), None).unwrap();
        rest.push(&[1.0, 10.0], None);
        assert!(!rest.is_known());
        rest.push(&[3.0, 20.0], None);
        assert!(rest.is_known());
        let mut sample = [1.0, 3.0, 5.0, 10.0, 20.0, 30.0];
        rest.take_off(&mut sample, (2, 3, 1));
        assert_eq!(sample, [-1.0, 1.0, 3.0, -5.0, 5.0, 15.0]);
        rest.begin();
        rest.push(&[7.0, 0.0], None);
        rest.push(&[7.0, 0.0], None);
        rest.take_off(&mut sample, (2, 3, 1));
        assert_eq!(sample, [-8.0, -6.0, -4.0, -5.0, 5.0, 15.0]);
    }

    #[test]
    fn the_level_follows_drift_only_while_nothing_is_touched() {
        let mut rest = RestLevel::new(&series(Some(Tare::Array("tare".into()))), Some(1)).unwrap();
        rest.push(&[0.0, 0.0], Some(false));
        (0..5000).for_each(|_| rest.push(&[1.0, 1.0], Some(true)));
        (0..5000).for_each(|_| rest.push(&[5.0, 5.0], None));
        assert_eq!(rest.level, [0.0, 0.0]);
        (0..5000).for_each(|_| rest.push(&[1.0, 2.0], Some(false)));
        assert!((rest.level[0] - 1.0).abs() < 0.01 && (rest.level[1] - 2.0).abs() < 0.02, "{:?}", rest.level);
    }

    #[test]
    fn a_model_of_readings_as_they_are_has_none() {
        assert!(RestLevel::new(&series(None), Some(5)).is_none());
        assert!(RestLevel::new(&series(Some(Tare::Recording { steps: 2 })), Some(0)).is_none());
    }
}
