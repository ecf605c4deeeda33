//! Parts of a sample that a decision may rest on: sensors and parts of the window, masked one at a time.

use ndarray::{ArrayD, Axis, IxDyn};
use taxel_base::Layout;
use taxel_data::SampleSpec;

use crate::error::Result;
use crate::model::predictions::Predictions;
use crate::model::predictor::Predictor;

/// Parts that a window is divided into at most.
const WINDOW: usize = 10;
/// Rows and columns of blocks that an image is divided into at most, and those of the frames of a sequence.
const BLOCKS: usize = 8;
const FRAME_BLOCKS: usize = 4;
/// Sensors that are masked each by itself at most; more are masked with their neighbours.
const SENSORS: usize = 64;

/// The parts of samples of one shape: sensors (rows) by parts of the window (columns). An image has blocks of its rows and columns in
/// their place, a sequence blocks of taxels and parts of the window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaskGrid {
    /// Names of the sensors, or rows.
    pub rows: Vec<String>,
    /// Names of the parts of the window, or columns; one without a name where there is no second axis.
    pub columns: Vec<String>,
    /// Row and column of each value of a sample.
    places: Vec<(usize, usize)>,
}

/// A part of a sample that is replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Masked {
    /// The masked row; none masks all of them.
    pub row: Option<usize>,
    /// The masked column, likewise.
    pub column: Option<usize>,
}

/// Returns the part of an axis of `size` places that `at` belongs to, of at most `most` parts.
fn part(at: usize, size: usize, most: usize) -> usize {
    at * size.min(most) / size.max(1)
}

/// Returns names for the parts of an axis: `rows 0 to 3`, or `row 2` where each place is a part.
fn names(one: &str, size: usize, most: usize) -> Vec<String> {
    let count = size.min(most);
    let named = |number: usize| {
        let of_part: Vec<usize> = (0..size).filter(|at| part(*at, size, most) == number).collect();
        match of_part.as_slice() {
            [only] => format!("{one} {only}"),
            [first, .., last] => format!("{one}s {first} to {last}"),
            [] => one.into(),
        }
    };
    (0..count).map(named).collect()
}

/// Returns names for the parts of a window: `20 to 30 %`.
fn window(ticks: usize) -> Vec<String> {
    let count = ticks.min(WINDOW);
    let percent = |number: usize| 100 * number / count.max(1);
    (0..count).map(|number| format!("{} to {} %", percent(number), percent(number + 1))).collect()
}

impl MaskGrid {
    /// Divides samples of this shape.
    pub fn of(spec: &SampleSpec) -> Self {
        let values: usize = spec.shape.iter().product();
        let each = |place: &dyn Fn(usize) -> (usize, usize)| (0..values).map(place).collect();
        match (spec.layout, spec.shape.as_slice()) {
            (Layout::Series, &[channels, ticks]) => MaskGrid {
                rows: sensors(spec, "channel", channels),
                columns: window(ticks),
                places: each(&|at| (part(at / ticks, channels, SENSORS), part(at % ticks, ticks, WINDOW))),
            },
            (Layout::Fingers, &[fingers, channels, ticks]) => MaskGrid {
                rows: names("finger", fingers, SENSORS),
                columns: window(ticks),
                places: each(&|at| {
                    (part(at / (channels * ticks), fingers, SENSORS), part(at % ticks, ticks, WINDOW))
                }),
            },
            (Layout::Image | Layout::Colour, &[.., height, width]) => MaskGrid {
                rows: names("row", height, BLOCKS),
                columns: names("column", width, BLOCKS),
                places: each(&|at| {
                    (part(at / width % height, height, BLOCKS), part(at % width, width, BLOCKS))
                }),
            },
            (Layout::Sequence, &[ticks, height, width]) => {
                let across = width.min(FRAME_BLOCKS);
                let (down, along) =
                    (names("row", height, FRAME_BLOCKS), names("column", width, FRAME_BLOCKS));
                MaskGrid {
                    rows: down
                        .iter()
                        .flat_map(|row| along.iter().map(move |column| format!("{row}, {column}")))
                        .collect(),
                    columns: window(ticks),
                    places: each(&|at| {
                        let (row, column) = (at / width % height, at % width);
                        let block =
                            part(row, height, FRAME_BLOCKS) * across + part(column, width, FRAME_BLOCKS);
                        (block, part(at / (height * width), ticks, WINDOW))
                    }),
                }
            }
            (_, shape) => {
                let features = shape.first().copied().unwrap_or(1);
                let size = (values / features.max(1)).max(1);
                MaskGrid {
                    rows: sensors(spec, "feature", features),
                    columns: vec![String::new()],
                    places: each(&|at| (part(at / size, features, SENSORS), 0)),
                }
            }
        }
    }

    /// Lists every sensor, every part of the window, and every pair of both: where one of the two has a single part, the other
    /// says it all.
    pub fn masks(&self, with_pairs: bool) -> Vec<Masked> {
        let rows = (0..self.rows.len()).map(|row| Masked { row: Some(row), column: None });
        let columns = (0..self.columns.len()).map(|column| Masked { row: None, column: Some(column) });
        let columns = columns.filter(|_| self.columns.len() > 1);
        let pair =
            |row| (0..self.columns.len()).map(move |column| Masked { row: Some(row), column: Some(column) });
        let pairs = (0..self.rows.len()).flat_map(pair).filter(|_| with_pairs);
        rows.chain(columns).chain(pairs).collect()
    }

    /// Returns the name of a masked part.
    pub fn name(&self, masked: Masked) -> String {
        let row = masked.row.and_then(|row| self.rows.get(row));
        let column =
            masked.column.and_then(|column| self.columns.get(column)).filter(|name| !name.is_empty());
        [row, column].into_iter().flatten().cloned().collect::<Vec<_>>().join(", ")
    }

    /// Puts `reference` in place of the masked values of a sample.
    fn put(&self, masked: Masked, sample: &mut [f32], reference: &[f32]) {
        for ((value, reference), (row, column)) in sample.iter_mut().zip(reference).zip(&self.places) {
            if masked.row.is_none_or(|wanted| wanted == *row)
                && masked.column.is_none_or(|wanted| wanted == *column)
            {
                *value = *reference;
            }
        }
    }

    /// Predicts one raw sample as it is, and then with each of `masks` replaced by the values of `reference`.
    ///
    /// # Errors
    /// Samples that the model refuses.
    pub fn predict(
        &self,
        predictor: &Predictor,
        shape: &[usize],
        (sample, reference): (&[f32], &[f32]),
        masks: &[Masked],
    ) -> Result<Predictions> {
        let mut x = ArrayD::zeros(IxDyn(&[&[masks.len() + 1], shape].concat()));
        for (at, mut row) in x.axis_iter_mut(Axis(0)).enumerate() {
            let Some(values) = row.as_slice_mut() else { continue };
            values.copy_from_slice(sample);
            if let Some(masked) = at.checked_sub(1).and_then(|at| masks.get(at)) {
                self.put(*masked, values, reference);
            }
        }
        predictor.predict(&x)
    }
}

/// Returns names for the channels or features.
fn sensors(spec: &SampleSpec, one: &str, count: usize) -> Vec<String> {
    if spec.channel_names.len() == count && count <= SENSORS {
        spec.channel_names.clone()
    } else {
        names(one, count, SENSORS)
    }
}

/// Returns what a sample of a sensor at rest reads, as its spec says; else each channel of a series begins at rest, and elsewhere
/// the mean of the sample stands for it.
pub fn at_rest(spec: &SampleSpec, sample: &[f32]) -> Vec<f32> {
    let (before, ticks, after) = spec.around_time();
    let channels = before.max(1);
    let rest = |channel: usize| match spec.rest.as_deref() {
        Some([one]) => *one,
        Some(each) if each.len() == channels => each[channel],
        _ => match spec.layout {
            Layout::Series | Layout::Fingers => sample.get(channel * ticks * after).copied().unwrap_or(0.0),
            _ => sample.iter().sum::<f32>() / sample.len().max(1) as f32,
        },
    };
    let each = (sample.len() / channels).max(1);
    (0..sample.len()).map(|at| rest((at / each).min(channels - 1))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_every_value_once() {
        for (layout, shape) in [
            (Layout::Series, vec![3, 25]),
            (Layout::Series, vec![100, 4]),
            (Layout::Fingers, vec![2, 3, 12]),
            (Layout::Image, vec![5, 20]),
            (Layout::Colour, vec![3, 16, 9]),
            (Layout::Sequence, vec![7, 4, 25]),
            (Layout::Features, vec![9]),
        ] {
            let spec = SampleSpec::new(layout, &shape);
            let grid = MaskGrid::of(&spec);
            let values: usize = shape.iter().product();
            let sample = vec![1.0; values];
            let count = |masks: Vec<Masked>| -> usize {
                let masked = masks.into_iter().map(|masked| {
                    let mut sample = sample.clone();
                    grid.put(masked, &mut sample, &vec![0.0; values]);
                    sample.iter().filter(|value| **value == 0.0).count()
                });
                masked.sum()
            };
            let of = |is: fn(&Masked) -> bool| grid.masks(true).into_iter().filter(is).collect::<Vec<_>>();
            assert_eq!(count(of(|masked| masked.column.is_none())), values, "{layout}: rows");
            assert_eq!(
                count(of(|masked| masked.row.is_some() && masked.column.is_some())),
                values,
                "{layout}: pairs"
            );
            let columns = of(|masked| masked.row.is_none());
            assert!(columns.is_empty() || count(columns) == values, "{layout}: columns");
            assert!(grid.masks(true).iter().all(|masked| !grid.name(*masked).is_empty()));
        }
    }

    #[test]
    fn parts_have_names() {
        let mut spec = SampleSpec::new(Layout::Series, &[2, 20]);
        spec.channel_names = vec!["thumb".into(), "index".into()];
        let grid = MaskGrid::of(&spec);
        assert_eq!((grid.rows[1].as_str(), grid.columns[2].as_str()), ("index", "20 to 30 %"));
        assert_eq!(grid.name(Masked { row: Some(0), column: Some(9) }), "thumb, 90 to 100 %");
        let image = MaskGrid::of(&SampleSpec::new(Layout::Image, &[16, 3]));
        assert_eq!((image.rows[1].as_str(), image.columns[2].as_str()), ("rows 2 to 3", "column 2"));
    }

    #[test]
    fn a_sensor_at_rest_reads_what_its_spec_says() {
        let mut spec = SampleSpec::new(Layout::Series, &[2, 3]);
        let sample = [4.0, 5.0, 6.0, 1.0, 2.0, 3.0];
        assert_eq!(at_rest(&spec, &sample), [4.0, 4.0, 4.0, 1.0, 1.0, 1.0]);
        spec.rest = Some(vec![7.0]);
        assert_eq!(at_rest(&spec, &sample), [7.0; 6]);
    }
}
