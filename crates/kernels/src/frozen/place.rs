//! Where an image lies in a buffer.

use crate::lengths::image;
use crate::view::Rectifier;

/// An image in a buffer, channels last, maybe between margins of zeros, maybe among other channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImagePlace {
    /// Depth, rows, columns.
    pub size: [usize; 3],
    /// Channels.
    pub channels: usize,
    /// Index of the first value.
    pub start: usize,
    /// Distance of neighbours along each axis.
    pub pitch: [usize; 3],
    /// Columns of zeros before and after every row.
    pub margin: [usize; 2],
}

/// Between which places a convolution works, and what happens to its outputs before they are stored.
#[derive(Debug, Clone, Copy)]
pub struct Route {
    /// The input.
    pub from: ImagePlace,
    /// The output.
    pub to: ImagePlace,
    /// The addend of the outputs, of the same shape.
    pub addend: Option<ImagePlace>,
    /// The rectifier of the sums.
    pub rectifier: Rectifier,
}

impl Route {
    /// Makes a route of plain outputs of what lies at `from` into `to`.
    pub fn new(from: ImagePlace, to: ImagePlace) -> Self {
        Route { from, to, addend: None, rectifier: Rectifier::None }
    }
}

impl ImagePlace {
    /// Makes the place of an image that fills its buffer.
    pub fn dense(size: [usize; 3], channels: usize) -> Self {
        Self::new(size, channels, [0; 2], channels, 0)
    }

    /// Makes the place of an image with margins, which takes `channels` of `width` from channel `first` on.
    pub fn new(size: [usize; 3], channels: usize, margin: [usize; 2], width: usize, first: usize) -> Self {
        assert!(first + channels <= width, "channels {first}..{} do not fit into {width}", first + channels);
        let row = margin[0] + size[2] + margin[1];
        image([size[0], size[1], row], width);
        let pitch = [size[1] * row * width, row * width, width];
        ImagePlace { size, channels, start: margin[0] * width + first, pitch, margin }
    }

    /// Returns the place of rows `first..first + count` of an image of depth 1.
    pub fn band(&self, first: usize, count: usize) -> Self {
        assert!(
            self.size[0] == 1 && first + count <= self.size[1],
            "rows {first}..{}: {self:?}",
            first + count
        );
        let pitch = [count * self.pitch[1], self.pitch[1], self.pitch[2]];
        ImagePlace { size: [1, count, self.size[2]], start: self.start + first * pitch[1], pitch, ..*self }
    }

    /// Returns the number of values of the whole buffer, margins and other channels included.
    pub fn buffer_len(&self) -> usize {
        self.size[0] * self.pitch[0]
    }

    /// Returns the number of positions.
    pub fn positions(&self) -> usize {
        self.size.iter().product()
    }

    /// Returns the number of values of the image.
    pub fn len(&self) -> usize {
        self.positions() * self.channels
    }

    /// Checks whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.channels == 0 || self.size.contains(&0)
    }

    /// Returns the index of the first channel at (depth, row, column).
    pub fn at(&self, position: [usize; 3]) -> usize {
        self.start + (0..3).map(|a| position[a] * self.pitch[a]).sum::<usize>()
    }

    /// Returns the index one past the last value; panics where no memory could hold it.
    pub fn end(&self) -> usize {
        if self.is_empty() {
            return self.start;
        }
        let further = |at: usize, axis: usize| {
            (self.size[axis] - 1).checked_mul(self.pitch[axis]).and_then(|far| far.checked_add(at))
        };
        let end = (0..3).try_fold(self.start, further).and_then(|last| last.checked_add(self.channels));
        #[expect(clippy::expect_used, reason = "sizes that overflow are a programming error of the caller")]
        end.expect("no memory holds values that lie so far apart")
    }

    /// Checks whether the values fill the buffer without a gap.
    pub fn is_dense(&self) -> bool {
        self.start == 0 && self.buffer_len() == self.len()
    }

    /// Returns the same positions as one row where all neighbours are equally far from each other, else `None`.
    pub fn line(&self) -> Option<Self> {
        let [_, rows, columns] = self.size;
        let even = self.pitch[1] == columns * self.pitch[2] && self.pitch[0] == rows * self.pitch[1];
        even.then(|| {
            let pitch = [self.positions() * self.pitch[2]; 2];
            ImagePlace { size: [1, 1, self.positions()], pitch: [pitch[0], pitch[1], self.pitch[2]], ..*self }
        })
    }

    /// Returns the starts of the rows.
    pub(crate) fn rows(&self) -> impl Iterator<Item = usize> + use<> {
        let place = *self;
        (0..place.size[0]).flat_map(move |d| (0..place.size[1]).map(move |r| place.at([d, r, 0])))
    }
}
