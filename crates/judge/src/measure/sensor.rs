//! Axes, range and rest values of a data set's readings.

use taxel_data::{Dataset, Layout};
use taxel_scenes::faults::Sensor;

use crate::values::SensorRange;

/// What faults have to know about the readings, and where their range comes from.
pub(super) fn sensor(dataset: &Dataset) -> (Sensor, SensorRange) {
    let reading = &dataset.reading;
    let ends = |(low, high): (f32, f32), &v: &f32| (low.min(v), high.max(v));
    let (low, most) = dataset.x.iter().fold((0.0f32, f32::NEG_INFINITY), ends);
    let high = reading.full_scale.map_or(most, |full| full.max(most));
    // A range of nothing but zeros has no width; any will do.
    let high = if high > low { high } else { low + 1.0 };
    let range = SensorRange { low, high, from_samples: reading.full_scale.is_none() };
    let rest = reading.rest.clone().unwrap_or_else(|| resting(dataset));
    (Sensor { layout: reading.layout, low, high, rest }, range)
}

/// Readings without contact where nobody says what they are: of series the median of each channel's first
/// reading, since recordings begin before contact; 0 elsewhere.
fn resting(dataset: &Dataset) -> Vec<f32> {
    let (channels, ticks) = match (dataset.reading.layout, dataset.reading.shape.as_slice()) {
        (Layout::Features, [ticks]) => (1, *ticks),
        (Layout::Series, [channels, ticks]) => (*channels, *ticks),
        (Layout::Fingers, [fingers, channels, ticks]) => (fingers * channels, *ticks),
        _ => return vec![0.0],
    };
    let values = dataset.x.as_standard_layout();
    #[expect(clippy::expect_used, reason = "the standard layout is contiguous")]
    let values = values.as_slice().expect("a contiguous array");
    let median = |channel: usize| {
        let samples = values.chunks_exact(channels * ticks);
        let mut first: Vec<f32> = samples.map(|sample| sample[channel * ticks]).collect();
        first.sort_by(f32::total_cmp);
        first[first.len() / 2]
    };
    (0..channels).map(median).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{ArrayD, IxDyn};
    use taxel_data::{Dataset, Layout};

    use super::sensor;

    fn dataset(layout: Layout, shape: &[usize], values: Vec<f32>) -> Dataset {
        let x = ArrayD::from_shape_vec(IxDyn(shape), values).unwrap();
        let labels: Vec<usize> = (0..shape[0]).collect();
        Dataset::new("own", layout, x, &labels).unwrap()
    }

    #[test]
    fn facts_of_the_data_set_are_taken_as_they_are() {
        let own = dataset(Layout::Series, &[2, 2, 2], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let own = own.with_full_scale(100.0).unwrap().with_rest(vec![1.0, 2.0]);
        let (sensor, range) = sensor(&own);
        assert_eq!((sensor.layout, sensor.low, sensor.high), (Layout::Series, 0.0, 100.0));
        assert_eq!((sensor.rest, range.from_samples), (vec![1.0, 2.0], false));
    }

    #[test]
    fn what_nobody_says_is_taken_from_the_samples() {
        // The first readings of channel 0 are 5, 1, 9, of channel 1 they are -2, 0, -1.
        let values = vec![5.0, 8.0, -2.0, 0.0, 1.0, 7.0, 0.0, 3.0, 9.0, 9.0, -1.0, 2.0];
        let (own, range) = sensor(&dataset(Layout::Series, &[3, 2, 2], values.clone()));
        assert_eq!((own.rest, own.low, own.high), (vec![5.0, -1.0], -2.0, 9.0));
        assert!(range.from_samples);
        let (flat, _) = sensor(&dataset(Layout::Features, &[3, 4], values.clone()));
        assert_eq!((flat.layout, flat.rest), (Layout::Features, vec![5.0]));
        let (image, _) = sensor(&dataset(Layout::Image, &[3, 2, 2], values));
        assert_eq!(image.rest, [0.0]);
        let (none, _) = sensor(&dataset(Layout::Image, &[2, 1, 1], vec![0.0, 0.0]));
        assert_eq!((none.low, none.high), (0.0, 1.0));
    }
}
