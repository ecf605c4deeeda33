//! Sizes of a convolution, and the lengths of its tensors.

use std::ops::Range;

use crate::lengths::image;
use crate::window::Window3;

use super::band::Band;

/// Sizes of a convolution. That all lengths below fit a `usize` is asserted when they are made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ConvSizes {
    pub window: Window3,
    /// Steps between the inputs that neighbouring kernel values meet.
    pub dilation: [usize; 3],
    pub channels: usize,
    pub filters: usize,
    pub groups: usize,
}

impl ConvSizes {
    pub fn new(
        mut window: Window3,
        dilation: [usize; 3],
        channels: usize,
        filters: usize,
        groups: usize,
    ) -> Self {
        assert!(
            groups > 0 && channels.is_multiple_of(groups) && filters.is_multiple_of(groups),
            "groups that divide {channels} channels and {filters} filters are needed, not {groups}"
        );
        let Window3 { input, output, kernel, stride, .. } = window;
        assert!(
            [output, kernel, stride, dilation].iter().flatten().all(|&size| size > 0),
            "outputs, kernels, strides and dilations of at least 1 are needed: {window:?}, {dilation:?}"
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
        let sizes = ConvSizes { window, dilation, channels, filters, groups };
        image(sizes.reach(), channels);
        sizes
    }

    /// Returns the convolution that makes the input's gradient from the output's: the kernel turned round, channels
    /// in and out exchanged. There is one where windows move by single steps, and no output sees the halo alone.
    pub fn turned(&self) -> Option<Self> {
        let Window3 { input, output, kernel, stride, before } = self.window;
        let extent = self.extent();
        (stride == [1; 3] && (0..3).all(|a| before[a] < extent[a])).then(|| {
            let before = std::array::from_fn(|a| extent[a] - 1 - before[a]);
            let window = Window3 { input: output, output: input, kernel, stride, before };
            Self::new(window, self.dilation, self.filters, self.channels, self.groups)
        })
    }

    /// Returns the number of input positions from the first under a window to the last.
    pub fn extent(&self) -> [usize; 3] {
        std::array::from_fn(|a| {
            let gaps = (self.window.kernel[a] - 1).checked_mul(self.dilation[a]);
            fits(gaps.and_then(|gaps| gaps.checked_add(1)))
        })
    }

    /// Returns the kernel values of the window at output `out` along `axis` that meet inputs, and the input that the
    /// first of them meets.
    pub fn inside(&self, axis: usize, out: usize) -> (Range<usize>, usize) {
        self.window.inside_dilated(axis, out, self.dilation[axis])
    }

    /// Returns a function that gives the offset of each kernel value's input from that of the first, in an image of
    /// size `padded`.
    pub fn offsets(&self, padded: [usize; 3]) -> impl Fn([usize; 3]) -> usize + use<> {
        let [depth, row, column] = self.dilation;
        move |[d, r, c]| (d * depth * padded[1] + r * row) * padded[2] + c * column
    }

    /// Checks whether every channel is a group of its own.
    pub fn is_depthwise(&self) -> bool {
        self.groups > 1 && self.groups == self.channels && self.groups == self.filters
    }

    /// Returns the size of the input with its halo, as far as windows reach.
    pub fn reach(&self) -> [usize; 3] {
        let (Window3 { output, stride, .. }, extent) = (self.window, self.extent());
        std::array::from_fn(|a| {
            fits((output[a] - 1).checked_mul(stride[a]).and_then(|last| last.checked_add(extent[a])))
        })
    }

    /// Returns the number of values of one input image.
    pub fn x_len(&self) -> usize {
        self.window.input_len() * self.channels
    }

    /// Returns the number of values of one output image.
    pub fn y_len(&self) -> usize {
        self.window.output_len() * self.filters
    }

    /// Returns the number of kernel values that meet in one output value.
    pub fn depth(&self) -> usize {
        self.window.volume() * self.channels / self.groups
    }

    /// Returns the number of weights.
    pub fn weight_len(&self) -> usize {
        self.depth() * self.filters
    }

    /// Returns the number of channels and of filters of one group.
    pub fn of_group(&self) -> [usize; 2] {
        [self.channels / self.groups, self.filters / self.groups]
    }

    /// Returns where the outputs of a band lie.
    pub fn outputs(&self, band: &Band) -> Range<usize> {
        let output = self.window.output;
        if band.rows == output[1] {
            return 0..self.y_len();
        }
        let row = output[2] * self.filters;
        band.from * row..(band.from + band.rows) * row
    }
}

/// Returns a size along an axis of the padded input; panics where it overflows.
#[expect(clippy::expect_used, reason = "sizes that overflow are a programming error of the caller")]
fn fits(size: Option<usize>) -> usize {
    size.expect("no memory holds a padded input of this size")
}
