//! A data set looked at before anything is trained on it.

use ndarray::{ArrayD, Axis};
use taxel_data::{Dataset, Drift, Layout, Shortcut, Survey as Surveyed};
use taxel_report::pictures::{ArrayPicture, PictureKind};

use super::pictures::{picture, reading};
use crate::values::{ClassPictures, Survey};

/// Recordings shown of a class.
const EACH: usize = 3;
/// Classes of which recordings are shown.
const CLASSES: usize = 6;

/// Looks at a data set: some of its recordings, its lengths, how its means wander, what its plainest numbers tell.
pub fn survey(surveyed: Surveyed) -> Survey {
    let Surveyed { card, dataset, readings } = surveyed;
    let (groups, copies) = (dataset.groups.as_deref(), dataset.units.as_deref());
    Survey {
        unit: dataset.spec.unit.clone(),
        rate: dataset.spec.rate,
        classes: classes(&dataset),
        activity: activity(&dataset),
        lengths: readings.unwrap_or_default(),
        drift: Drift::of(&dataset),
        carriers: Shortcut::carriers(&dataset.x, &dataset.strata(), groups, copies),
        order: dataset.strata().into_owned(),
        card,
    }
}

/// Returns the first, the middle and the last recording of each class.
fn classes(data: &Dataset) -> Vec<ClassPictures> {
    let strata = data.strata();
    let of_class = |(class, name): (usize, &String)| {
        let rows: Vec<usize> = (0..data.len()).filter(|row| strata[*row] as usize == class).collect();
        let count = rows.len().min(EACH);
        let shown = (0..count).map(|i| rows[if count > 1 { i * (rows.len() - 1) / (count - 1) } else { 0 }]);
        let drawn = |row: usize| {
            (data.origins[row].clone(), reading(data.x.index_axis(Axis(0), row), data.spec.layout))
        };
        ClassPictures { name: name.clone(), recordings: shown.map(drawn).collect() }
    };
    // The names of one attribute; levels of several are no classes.
    let names = data.task().attributes();
    let names = names.first().filter(|_| names.len() == 1).map_or(&[][..], |names| names.classes.as_slice());
    names.iter().enumerate().take(CLASSES).map(of_class).collect()
}

/// Returns the standard deviation of each taxel.
fn activity(data: &Dataset) -> Option<ArrayPicture> {
    let area: usize = match data.spec.layout {
        Layout::Image | Layout::Sequence => data.sample_shape().iter().rev().take(2).product(),
        _ => return None,
    };
    let (mut sums, mut squares, mut counts) = (vec![0.0; area], vec![0.0; area], vec![0.0; area]);
    let offset = data.x.iter().find(|v| v.is_finite()).map_or(0.0, |v| f64::from(*v));
    for (i, value) in data.x.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let (taxel, value) = (i % area, f64::from(*value) - offset);
        sums[taxel] += value;
        squares[taxel] += value * value;
        counts[taxel] += 1.0;
    }
    let sd = |taxel: usize| {
        let n: f64 = f64::max(counts[taxel], 1.0);
        (squares[taxel] / n - (sums[taxel] / n).powi(2)).max(0.0).sqrt() as f32
    };
    let shape = &data.sample_shape()[data.sample_shape().len() - 2..];
    let values = ArrayD::from_shape_vec(shape, (0..area).map(sd).collect()).ok()?;
    Some(picture("standard deviation of each taxel", PictureKind::Grey, values))
}
