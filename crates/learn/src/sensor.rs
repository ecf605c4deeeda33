//! Axes, range and rest values of a data set's readings, as faults need them.

use ndarray::Axis;
use taxel_data::{Dataset, Layout};
use taxel_faults::Sensor;

/// Facts about the readings that faults need.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorFacts {
    /// Axes, range and rest values.
    pub sensor: Sensor,
    /// Whether the largest reading was taken from the samples, since nobody says what the sensor's is.
    pub from_samples: bool,
}

/// Returns the axes, range and rest values of the samples. Values that nobody says are taken from the samples in
/// `rows`. The range reaches from their smallest value, or 0, to the full scale, or to a larger value among them.
pub fn sensor(dataset: &Dataset, rows: &[usize]) -> SensorFacts {
    let spec = &dataset.spec;
    let (mut low, mut most) = (0.0f32, f32::NEG_INFINITY);
    for &row in rows {
        for &value in dataset.x.index_axis(Axis(0), row) {
            (low, most) = (low.min(value), most.max(value));
        }
    }
    let high = spec.full_scale.map_or(most, |full| full.max(most));
    // A range of nothing but zeros has no width; any will do.
    let high = if high > low { high } else { low + 1.0 };
    let rest = spec.rest.clone().unwrap_or_else(|| resting(dataset, rows));
    let sensor = Sensor { layout: spec.layout, low, high, rest };
    SensorFacts { sensor, from_samples: spec.full_scale.is_none() }
}

/// Readings without contact where nobody says what they are: of series the median of each channel's first
/// reading, since recordings begin before contact; 0 elsewhere.
fn resting(dataset: &Dataset, rows: &[usize]) -> Vec<f32> {
    let (channels, ticks) = match (dataset.spec.layout, dataset.spec.shape.as_slice()) {
        (Layout::Features, [ticks]) => (1, *ticks),
        (Layout::Series, [channels, ticks]) => (*channels, *ticks),
        (Layout::Fingers, [fingers, channels, ticks]) => (fingers * channels, *ticks),
        _ => return vec![0.0],
    };
    let mut firsts: Vec<Vec<f32>> = vec![vec![]; channels];
    for &row in rows {
        let sample = dataset.x.index_axis(Axis(0), row);
        for (first, value) in firsts.iter_mut().zip(sample.iter().step_by(ticks.max(1))) {
            first.push(*value);
        }
    }
    let median = |mut first: Vec<f32>| {
        first.sort_by(f32::total_cmp);
        first.get(first.len() / 2).copied().unwrap_or(0.0)
    };
    firsts.into_iter().map(median).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{ArrayD, IxDyn};
    use taxel_data::{Dataset, Layout};

    use super::{SensorFacts, sensor};

    fn dataset(layout: Layout, shape: &[usize], values: Vec<f32>) -> Dataset {
        let x = ArrayD::from_shape_vec(IxDyn(shape), values).unwrap();
        let labels: Vec<usize> = (0..shape[0]).collect();
        Dataset::new("own", layout, x, &labels).unwrap()
    }

    #[test]
    fn facts_of_the_data_set_are_taken_as_they_are() {
        let presses = dataset(Layout::Series, &[2, 2, 2], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let presses = presses.with_full_scale(100.0).unwrap().with_rest(vec![1.0, 2.0]);
        let SensorFacts { sensor, from_samples } = sensor(&presses, &[0, 1]);
        assert_eq!((sensor.layout, sensor.low, sensor.high), (Layout::Series, 0.0, 100.0));
        assert_eq!((sensor.rest, from_samples), (vec![1.0, 2.0], false));
    }

    #[test]
    fn what_nobody_says_is_taken_from_the_samples() {
        // The first readings of channel 0 are 5, 1, 9, of channel 1 they are -2, 0, -1.
        let values = vec![5.0, 8.0, -2.0, 0.0, 1.0, 7.0, 0.0, 3.0, 9.0, 9.0, -1.0, 2.0];
        let three = dataset(Layout::Series, &[3, 2, 2], values.clone());
        let facts = sensor(&three, &[0, 1, 2]);
        assert!(facts.from_samples);
        let facts = facts.sensor;
        assert_eq!((facts.rest, facts.low, facts.high), (vec![5.0, -1.0], -2.0, 9.0));
        let two = sensor(&three, &[0, 1]).sensor;
        assert_eq!((two.rest, two.high), (vec![5.0, 0.0], 8.0), "nothing is taken from other samples");
        let flat = sensor(&dataset(Layout::Features, &[3, 4], values.clone()), &[0, 1, 2]).sensor;
        assert_eq!((flat.layout, flat.rest), (Layout::Features, vec![5.0]));
        let image = sensor(&dataset(Layout::Image, &[3, 2, 2], values), &[0, 1, 2]).sensor;
        assert_eq!(image.rest, [0.0]);
        let none = sensor(&dataset(Layout::Image, &[2, 1, 1], vec![0.0, 0.0]), &[0, 1]).sensor;
        assert_eq!((none.low, none.high), (0.0, 1.0));
    }
}
