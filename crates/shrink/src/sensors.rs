//! The sensors of a sample that may go: channels, fingers, rows and columns.

use taxel_data::Layout;
use taxel_learn::Reduction;

/// One of them, by its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// Along the first axis: a channel, a finger, a feature.
    Channel(usize),
    /// A row of an array.
    Row(usize),
    /// A column of an array.
    Column(usize),
}

/// Returns all sensors of samples of a shape.
pub fn sensors(layout: Layout, shape: &[usize]) -> Vec<Sensor> {
    let area = |rows: usize, columns: usize| {
        (0..rows).map(Sensor::Row).chain((0..columns).map(Sensor::Column)).collect()
    };
    match (layout, shape) {
        (Layout::Image, &[rows, columns]) | (Layout::Colour | Layout::Sequence, &[_, rows, columns]) => {
            area(rows, columns)
        }
        (_, &[channels, ..]) => (0..channels).map(Sensor::Channel).collect(),
        _ => vec![],
    }
}

/// Returns the plural name of the sensors.
pub fn called(layout: Layout) -> &'static str {
    match layout {
        Layout::Features => "features",
        Layout::Series => "channels",
        Layout::Fingers => "fingers",
        Layout::Image | Layout::Colour | Layout::Sequence => "rows and columns",
    }
}

/// Returns the positions of a sensor's readings in a sample, row-major.
pub fn places(layout: Layout, shape: &[usize], sensor: Sensor) -> Vec<usize> {
    let all: usize = shape.iter().product();
    let (rows, columns) = match shape {
        [.., rows, columns] => (*rows, *columns),
        _ => (1, all),
    };
    let belongs = |at: usize| match sensor {
        Sensor::Channel(channel) => at / (all / shape[0].max(1)).max(1) == channel,
        Sensor::Row(row) => at / columns % rows == row,
        Sensor::Column(column) => at % columns == column,
    };
    debug_assert!(layout.fits(shape), "samples of the layout");
    (0..all).filter(|at| belongs(*at)).collect()
}

/// Returns the reduction that keeps the first `count` of `ranking`, positions in `sensors` with the most important
/// first. Of an array it keeps a row and a column at least: where the first `count` are all rows or all columns, one
/// more than `count`.
pub fn kept(sensors: &[Sensor], ranking: &[usize], count: usize) -> Reduction {
    let mut kept: Vec<Sensor> = ranking.iter().take(count).map(|&at| sensors[at]).collect();
    let rest = ranking.iter().skip(count).map(|&at| sensors[at]);
    let needed: [fn(&Sensor) -> bool; 2] =
        [|sensor| matches!(sensor, Sensor::Row(_)), |sensor| matches!(sensor, Sensor::Column(_))];
    for is in needed {
        if sensors.iter().any(is) && !kept.iter().any(is) {
            kept.extend(rest.clone().find(is));
        }
    }
    let positions = |get: fn(&Sensor) -> Option<usize>| {
        let mut found: Vec<usize> = kept.iter().filter_map(get).collect();
        found.sort_unstable();
        (!found.is_empty()).then_some(found)
    };
    Reduction {
        channels: positions(|sensor| if let Sensor::Channel(at) = sensor { Some(*at) } else { None }),
        rows: positions(|sensor| if let Sensor::Row(at) = sensor { Some(*at) } else { None }),
        columns: positions(|sensor| if let Sensor::Column(at) = sensor { Some(*at) } else { None }),
        ..Reduction::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_have_their_readings() {
        assert_eq!(places(Layout::Series, &[3, 2], Sensor::Channel(1)), [2, 3]);
        assert_eq!(places(Layout::Fingers, &[2, 2, 2], Sensor::Channel(1)), [4, 5, 6, 7]);
        assert_eq!(places(Layout::Features, &[4], Sensor::Channel(2)), [2]);
        assert_eq!(places(Layout::Image, &[2, 3], Sensor::Row(1)), [3, 4, 5]);
        assert_eq!(places(Layout::Sequence, &[2, 2, 3], Sensor::Column(2)), [2, 5, 8, 11]);
        assert_eq!(sensors(Layout::Colour, &[3, 2, 1]), [Sensor::Row(0), Sensor::Row(1), Sensor::Column(0)]);
        assert_eq!(sensors(Layout::Fingers, &[2, 9, 9]).len(), 2);
    }

    #[test]
    fn the_best_are_kept_and_an_array_keeps_both_axes() {
        let series = sensors(Layout::Series, &[4, 9]);
        assert_eq!(kept(&series, &[3, 0, 2, 1], 2).channels, Some(vec![0, 3]));
        let image = sensors(Layout::Image, &[3, 2]);
        let one = kept(&image, &[1, 0, 2, 4, 3], 2);
        assert_eq!((one.rows, one.columns), (Some(vec![0, 1]), Some(vec![1])));
    }
}
