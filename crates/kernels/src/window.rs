//! A sliding window over up to three spatial axes.

/// Kernel, stride and padding over (depth, rows, columns); missing axes have size 1.
///
/// One-dimensional data live on the last axis, two-dimensional data on the last two, so that the
/// innermost loop always runs along memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window3 {
    /// Input size.
    pub input: [usize; 3],
    /// Number of window positions.
    pub output: [usize; 3],
    /// Window size.
    pub kernel: [usize; 3],
    /// Step.
    pub stride: [usize; 3],
    /// Padding before the first value.
    pub before: [usize; 3],
}

impl Window3 {
    /// Makes a window over the last one to three axes, by axis.
    pub fn over(
        input: &[usize],
        output: &[usize],
        kernel: &[usize],
        stride: &[usize],
        before: &[usize],
    ) -> Self {
        Window3 {
            input: axes3(input, 1),
            output: axes3(output, 1),
            kernel: axes3(kernel, 1),
            stride: axes3(stride, 1),
            before: axes3(before, 0),
        }
    }

    /// Returns the number of input positions.
    pub fn input_len(&self) -> usize {
        self.input.iter().product()
    }

    /// Returns the number of window positions.
    pub fn output_len(&self) -> usize {
        self.output.iter().product()
    }

    /// Returns the number of values under one window.
    pub fn volume(&self) -> usize {
        self.kernel.iter().product()
    }

    /// Checks whether every window is one value and every value has its window.
    pub fn is_identity(&self) -> bool {
        self.kernel == [1; 3] && self.stride == [1; 3] && self.before == [0; 3] && self.input == self.output
    }

    /// Returns the (depth, row, column) of window position `at`.
    pub(crate) fn unravel(&self, at: usize) -> [usize; 3] {
        let [_, rows, columns] = self.output;
        [at / (rows * columns), at / columns % rows, at % columns]
    }

    /// Returns the kernel offsets along `axis` at output position `out` that fall inside the input, and the input
    /// position of the first of them.
    pub(crate) fn inside(&self, axis: usize, out: usize) -> (std::ops::Range<usize>, usize) {
        self.inside_dilated(axis, out, 1)
    }

    /// Returns the same as [`Window3::inside`] for a kernel whose values meet inputs `dilation` apart.
    pub(crate) fn inside_dilated(
        &self,
        axis: usize,
        out: usize,
        dilation: usize,
    ) -> (std::ops::Range<usize>, usize) {
        let Window3 { input, kernel, stride, before, .. } = self;
        let start = out * stride[axis];
        let values = |gap: usize| gap.div_ceil(dilation).min(kernel[axis]);
        let low = values(before[axis].saturating_sub(start));
        let high = values((input[axis] + before[axis]).saturating_sub(start)).max(low);
        (low..high, (start + low * dilation).saturating_sub(before[axis]))
    }

    /// Returns how many values along `axis`, under the window at output position `out`, lie inside the input or its
    /// `counted` padding (before, after); at least 1.
    pub(crate) fn counted(&self, axis: usize, out: usize, counted: (usize, usize)) -> usize {
        // In coordinates that start at the first padded position.
        let start = out * self.stride[axis];
        let low = start.max(self.before[axis] - counted.0);
        let high = (start + self.kernel[axis]).min(self.before[axis] + self.input[axis] + counted.1);
        high.saturating_sub(low).max(1)
    }
}

/// Returns values of one to three axes as those of three; the missing first ones are `rest`.
pub fn axes3<T: Copy>(values: &[T], rest: T) -> [T; 3] {
    let mut all = [rest; 3];
    all[3 - values.len()..].copy_from_slice(values);
    all
}
