//! The places of the elements of a sample in memory, and their neighbours.

use taxel_base::Layout;

/// Elements and times of a row-major sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ElementPlaces {
    pub elements: usize,
    /// Values of a window: in time, or the three planes of a colour image.
    pub times: usize,
    /// Distance in memory from one element to the next, and from one time to the next.
    steps: [usize; 2],
    /// Columns of an array.
    columns: Option<usize>,
}

impl ElementPlaces {
    /// Finds the places in samples of a shape; none where samples of this layout have no such shape, or no values.
    pub fn of(layout: Layout, shape: &[usize]) -> Option<Self> {
        let size = shape.iter().try_fold(1usize, |size, axis| size.checked_mul(*axis))?;
        if !layout.fits(shape) || size == 0 {
            return None;
        }
        let (times, columns) = match (layout, shape) {
            (Layout::Features, _) => (1, None),
            (Layout::Series | Layout::Fingers, [.., times]) => (*times, None),
            (Layout::Image, [_, columns]) => (1, Some(*columns)),
            (Layout::Colour | Layout::Sequence, [times, _, columns]) => (*times, Some(*columns)),
            _ => return None,
        };
        let elements = size / times;
        let steps = if columns.is_some() { [1, elements] } else { [times, 1] };
        Some(Self { elements, times, steps, columns })
    }

    /// Checks whether elements are taxels of an array.
    pub fn has_area(&self) -> bool {
        self.columns.is_some()
    }

    /// Returns the number of values of a sample.
    pub fn len(&self) -> usize {
        self.elements * self.times
    }

    /// Returns the position of a value in a sample.
    pub fn at(&self, element: usize, time: usize) -> usize {
        element * self.steps[0] + time * self.steps[1]
    }

    /// Lists the taxels above, below, left and right; none where elements are not on an array.
    pub fn around(&self, element: usize) -> impl Iterator<Item = usize> {
        let near = self.columns.map(|columns| {
            let column = element % columns;
            [
                element.checked_sub(columns),
                Some(element + columns).filter(|below| *below < self.elements),
                element.checked_sub(1).filter(|_| column > 0),
                Some(element + 1).filter(|_| column + 1 < columns),
            ]
        });
        near.into_iter().flatten().flatten()
    }

    /// Returns the name of an element.
    pub fn name(&self, layout: Layout, shape: &[usize], element: usize) -> String {
        match (layout, self.columns, shape) {
            (_, Some(columns), _) => format!("taxel ({}, {})", element / columns, element % columns),
            (Layout::Fingers, _, [_, channels, _]) => {
                format!("channel {} of finger {}", element % channels, element / channels)
            }
            (Layout::Features, _, _) => format!("feature {element}"),
            _ => format!("channel {element}"),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn every_layout_has_its_elements() {
        let series = ElementPlaces::of(Layout::Series, &[3, 5]).unwrap();
        assert_eq!((series.elements, series.times, series.at(2, 4), series.around(1).count()), (3, 5, 14, 0));
        let fingers = ElementPlaces::of(Layout::Fingers, &[2, 3, 5]).unwrap();
        assert_eq!((fingers.elements, fingers.at(4, 1)), (6, 21));
        assert_eq!(fingers.name(Layout::Fingers, &[2, 3, 5], 4), "channel 1 of finger 1");
        let squeeze = ElementPlaces::of(Layout::Sequence, &[7, 2, 3]).unwrap();
        assert_eq!((squeeze.elements, squeeze.times, squeeze.at(4, 1)), (6, 7, 10));
        assert_eq!(squeeze.around(4).collect::<Vec<_>>(), [1, 3, 5]);
        assert_eq!(squeeze.name(Layout::Sequence, &[7, 2, 3], 4), "taxel (1, 1)");
        let image = ElementPlaces::of(Layout::Image, &[3, 3]).unwrap();
        assert_eq!(image.around(4).collect::<Vec<_>>(), [1, 7, 3, 5]);
        assert_eq!(image.around(0).collect::<Vec<_>>(), [3, 1]);
        for (layout, shape) in
            [(Layout::Series, &[3][..]), (Layout::Image, &[0, 3]), (Layout::Colour, &[2, 3, 3])]
        {
            assert_eq!(ElementPlaces::of(layout, shape), None);
        }
    }
}
