//! Sizes of a convolution, and the lengths of its tensors.

use std::ops::Range;

use crate::lengths::image;
use crate::window::Window3;

use super::band::Band;

/// Sizes of a convolution. That all lengths below fit a `usize` is asserted when they are made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    pub window: Window3,
    pub channels: usize,
    pub filters: usize,
    pub groups: usize,
}

impl Sizes {
    pub fn new(mut window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        assert!(
            groups > 0 && channels.is_multiple_of(groups) && filters.is_multiple_of(groups),
            "groups that divide {channels} channels and {filters} filters are needed, not {groups}"
        );
        let Window3 { input, output, kernel, stride, .. } = window;
        assert!(
            [output, kernel, stride].iter().flatten().all(|&size| size > 0),
            "outputs, kernels and strides of at least 1 are needed: {window:?}"
        );
        for (size, width) in [(input, channels), (output, filters), (kernel, channels / groups * filters)] {
            image(size, width);
        }
        if window.is_identity() {
            // One long row makes longer blocks than many short ones.
            let positions = window.input_len();
            window.input = [1, 1, positions];
            window.output = window.input;
        }
        let sizes = Sizes { window, channels, filters, groups };
        image(sizes.reach(), channels);
        sizes
    }

    /// The convolution that makes the input's gradient from the output's: the kernel turned round, channels
    /// in and out exchanged. There is one where windows move by single steps, and no output sees the halo
    /// alone.
    pub fn turned(&self) -> Option<Self> {
        let Window3 { input, output, kernel, stride, before } = self.window;
        (stride == [1; 3] && (0..3).all(|a| before[a] < kernel[a])).then(|| {
            let before = std::array::from_fn(|a| kernel[a] - 1 - before[a]);
            let window = Window3 { input: output, output: input, kernel, stride, before };
            Self::new(window, self.filters, self.channels, self.groups)
        })
    }

    /// Whether every channel is a group of its own.
    pub fn is_depthwise(&self) -> bool {
        self.groups > 1 && self.groups == self.channels && self.groups == self.filters
    }

    /// Size of the input with its halo, as far as windows reach.
    pub fn reach(&self) -> [usize; 3] {
        let Window3 { output, kernel, stride, .. } = self.window;
        std::array::from_fn(|a| {
            let last = (output[a] - 1).checked_mul(stride[a]).and_then(|last| last.checked_add(kernel[a]));
            #[expect(
                clippy::expect_used,
                reason = "sizes that overflow are a programming error of the caller"
            )]
            last.expect("no memory holds a padded input of this size")
        })
    }

    /// Values of one input image.
    pub fn x_len(&self) -> usize {
        self.window.input_len() * self.channels
    }

    /// Values of one output image.
    pub fn y_len(&self) -> usize {
        self.window.output_len() * self.filters
    }

    /// Kernel values that meet in one output value.
    pub fn depth(&self) -> usize {
        self.window.volume() * self.channels / self.groups
    }

    /// Number of weights.
    pub fn weight_len(&self) -> usize {
        self.depth() * self.filters
    }

    /// Channels and filters of one group.
    pub fn of_group(&self) -> [usize; 2] {
        [self.channels / self.groups, self.filters / self.groups]
    }

    /// Where the outputs of a band lie.
    pub fn outputs(&self, band: &Band) -> Range<usize> {
        let output = self.window.output;
        if band.rows == output[1] {
            return 0..self.y_len();
        }
        let row = output[2] * self.filters;
        band.from * row..(band.from + band.rows) * row
    }
}
