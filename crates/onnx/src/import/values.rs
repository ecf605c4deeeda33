//! The meaning of a name of an ONNX graph while it is read.

/// Index of a node of the draft.
pub type Id = usize;

/// A value of an ONNX graph.
#[derive(Debug, Clone)]
pub enum ImportedValue {
    /// The value of a node of the network.
    Flow(AxisView),
    /// A stored tensor.
    Stored {
        /// Which one.
        index: usize,
        /// Whether its two axes are swapped.
        transposed: bool,
    },
    /// Numbers that describe shapes.
    Ints {
        /// The numbers.
        values: Vec<Dim>,
        /// One number without an axis.
        scalar: bool,
    },
    /// Rows of such numbers, on the way to the paddings of PyTorch's older exporter.
    IntTable(Vec<Vec<Dim>>),
    /// The same number everywhere, in whatever shape: initial states.
    Fill(f32),
    /// A value on the way to an operation of several ONNX nodes.
    Part(Fragment, AxisView),
}

/// Values that are no operation of their own; the view is that of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fragment {
    /// The input less its mean over space.
    Centred,
    /// The square of that.
    Squared,
    /// The mean of that over space, and what has been added to it; `kept` axes of one value stand for space.
    Variance {
        /// Added so far.
        eps: f32,
        /// Whether space is kept as axes of one value.
        kept: bool,
    },
    /// `max(0, min(1, x / 6 + 0.5))` of the input.
    HardSigmoid,
    /// The probabilities that taxel makes of the logits by itself: their softmax, or the logits clamped to 0..1.
    Probabilities,
}

/// A number of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dim {
    /// A plain number.
    Known(i64),
    /// The number of samples.
    Batch,
}

/// How the axes of a value lie on those of a node's output.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisView {
    /// The node.
    pub node: Id,
    /// The value's axes.
    pub axes: Vec<AxisRole>,
    /// Zeros around each spatial axis that no operation has counted yet.
    pub pad: Vec<(usize, usize)>,
}

/// The role of an axis of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisRole {
    /// The samples.
    Batch,
    /// That axis of the node's output, batch axis left out.
    Sample(usize),
    /// One value, which the node's output has no axis for.
    Unit,
    /// The steps of a recurrent layer, of which only the last is there.
    Step,
    /// Groups of channels.
    Group(usize),
    /// Channels of a group.
    Member(usize),
}

impl AxisView {
    /// Returns a node's output as it is.
    pub fn plain(node: Id, rank: usize) -> AxisView {
        let axes = std::iter::once(AxisRole::Batch).chain((0..rank).map(AxisRole::Sample)).collect();
        AxisView { node, axes, pad: vec![] }
    }

    /// Checks whether the axes are samples, then those of the node in their order, then `units` axes of one value.
    pub fn is_plain(&self, rank: usize, units: usize) -> bool {
        let mut plain = AxisView::plain(self.node, rank).axes;
        plain.extend(vec![AxisRole::Unit; units]);
        self.axes == plain
    }

    /// Counts the axes of one value at the end.
    pub fn units(&self) -> usize {
        self.axes.iter().rev().take_while(|axis| **axis == AxisRole::Unit).count()
    }
}
