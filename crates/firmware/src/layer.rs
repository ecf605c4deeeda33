//! The layers that C computes, with their numbers and places.

use taxel_kernels::Window3;
use taxel_kernels::frozen::bytes::{ByteScale, Ending};

use crate::floats::layer::FloatWork;

/// A row of positions in memory, channels last; or the rows of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    /// Number of the memory.
    pub memory: usize,
    /// First value, and distance of neighbouring positions.
    pub start: usize,
    pub pitch: usize,
    /// Positions of each row.
    pub positions: usize,
    pub channels: usize,
    /// Rows, and the distance of neighbouring ones; a series is one row.
    pub rows: usize,
    pub row_pitch: usize,
    /// How values are written in bytes; none for floats.
    pub scale: Option<ByteScale>,
}

impl Row {
    /// Returns the positions of all rows.
    pub fn len(&self) -> usize {
        self.rows * self.positions
    }

    /// Returns the same positions as one row, where all neighbours are equally far from each other.
    pub fn line(&self) -> Option<Row> {
        let is_even = self.rows == 1 || self.row_pitch == self.positions * self.pitch;
        is_even.then(|| Row { rows: 1, positions: self.len(), ..*self })
    }
}

/// A memory of one value, or of several side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Memory {
    /// Values, margins included.
    pub len: usize,
    /// Values before and after the positions, which hold `zero`.
    pub margins: [usize; 2],
    /// Values between the rows of an image, which hold `zero` as well.
    pub gaps: Gaps,
    /// The byte that means 0; none in a memory of floats.
    pub zero: Option<u8>,
}

/// Stretches between the rows of an image: their length, the distance of neighbouring ones, and their number.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Gaps {
    pub len: usize,
    pub apart: usize,
    pub count: usize,
}

impl Memory {
    /// Makes a memory of floats without margins.
    pub fn of_floats(len: usize) -> Self {
        Memory { len, margins: [0; 2], gaps: Gaps::default(), zero: None }
    }

    /// Returns the bytes that it takes.
    pub fn bytes(&self) -> usize {
        if self.zero.is_some() { self.len } else { size_of::<f32>() * self.len }
    }
}

/// A layer with the name of its node.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    pub name: String,
    pub work: Work,
    pub from: Vec<Row>,
    pub to: Row,
}

impl Layer {
    /// Checks whether the layer uses a memory.
    pub fn uses(&self, memory: usize) -> bool {
        let has_work = matches!(&self.work, Work::Floats(FloatWork::Lstm(lstm)) if lstm.work == memory);
        has_work || self.rows().any(|row| row.memory == memory)
    }

    /// Returns the products of the layer.
    pub fn macs(&self) -> usize {
        match &self.work {
            Work::Conv(conv) => conv.macs,
            Work::Depthwise(conv) => conv.macs,
            Work::Floats(work) => work.macs(self.to.len(), self.to.channels),
            _ => 0,
        }
    }

    /// Returns all rows that the layer reads and writes.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        let more = match &self.work {
            Work::Conv(conv) => conv.statistics.as_slice(),
            _ => &[],
        };
        self.from.iter().chain([&self.to]).chain(more.iter().map(|statistic| &statistic.to))
    }
}

/// How much of a window lies inside: first input, one past the last.
pub(crate) type Span = [usize; 2];

/// The windows of a pooling: of each output those of its row and of its column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Windows {
    pub rows: Vec<Span>,
    pub columns: Vec<Span>,
}

impl Windows {
    /// Returns the number of values that all windows read of a channel.
    pub fn reads(&self) -> usize {
        let sum = |spans: &[Span]| spans.iter().map(|[from, to]| to - from).sum::<usize>();
        sum(&self.rows) * sum(&self.columns)
    }

    /// Checks whether the only window is the whole of a value.
    pub fn is_whole(&self, row: &Row) -> bool {
        self.rows[..] == [[0, row.rows]] && self.columns[..] == [[0, row.positions]]
    }
}

/// The computation of a layer.
#[derive(Debug, Clone)]
pub(crate) enum Work {
    /// Takes the sample.
    Stage(Stage),
    Conv(Conv),
    Depthwise(Depthwise),
    /// `factor · x + shift` per channel.
    Map {
        factors: Vec<f32>,
        shifts: Vec<f32>,
        ending: Ending,
    },
    /// Bytes or floats that stay as they are.
    Copy,
    /// `factor · a + factor · b + shift` of bytes.
    Add {
        factors: [f32; 2],
        shift: f32,
        ending: Ending,
    },
    /// `a + b` of floats.
    AddFloats(Ending),
    /// The largest value of each window.
    Most(Windows),
    /// The mean of bytes: a factor and a shift of each window's sum.
    Mean {
        windows: Windows,
        scales: Vec<(f32, f32)>,
        ending: Ending,
    },
    /// The mean of floats: a share of each window's sum.
    MeanFloats {
        windows: Windows,
        shares: Vec<f32>,
    },
    /// The standard deviation of floats: a share of the sums, and what is added to the variance.
    Deviation {
        share: f32,
        eps: f32,
    },
    /// Bytes of so many groups of channels, shuffled.
    Shuffle(usize),
    /// Floats, channels first.
    Flatten,
    /// Floats of floats, with fused products and sums.
    Floats(FloatWork),
}

/// How the sample comes in.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    /// Distances of neighbouring channels and time steps of the sample in memory.
    pub by_channel: usize,
    pub by_step: usize,
    /// Steps of a row of an image with gaps between its rows, and the distance of neighbouring rows.
    pub by_row: Option<[usize; 2]>,
    /// Factors and shifts of the channels, where bytes are stored.
    pub scales: Option<(Vec<f32>, Vec<f32>)>,
    pub ending: Ending,
}

/// A convolution of bytes. Weights lie filter by filter, each as segments × run, the run filled up to fours.
#[derive(Debug, Clone)]
pub(crate) struct Conv {
    pub weight: Vec<i8>,
    /// Where sums start, as if bytes were numbers from -128 on.
    pub start: Vec<i32>,
    pub factor: Vec<f32>,
    /// Where the first window begins, in the input's memory.
    pub first: usize,
    /// Distance of the inputs of neighbouring outputs, and of the first inputs of neighbouring rows.
    pub step: usize,
    pub row_step: usize,
    /// Stretches of inputs, their distance, and fours of bytes in each.
    pub segments: usize,
    pub apart: usize,
    pub fours: usize,
    pub groups: usize,
    /// Channels of a group.
    pub channels: usize,
    pub addend: Option<Addend>,
    pub ending: Ending,
    /// Largest sum, whatever the bytes.
    pub reach: i32,
    pub macs: usize,
    /// Numbers that remain of each filter's row of floats; empty where all floats are stored.
    pub statistics: Vec<Statistic>,
    /// How floats become bytes at once.
    pub then: Option<Then>,
}

/// A factor and a shift of floats, and how they are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Then {
    pub factor: f32,
    pub shift: f32,
    pub ending: Ending,
}

/// A number of a filter's row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Statistic {
    pub number: RowNumber,
    pub to: Row,
}

/// Which number of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RowNumber {
    Mean { share: f32 },
    Most,
    Deviation { share: f32, eps: f32 },
}

/// How an addend comes in: `(byte − zero) · factor`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Addend {
    pub zero: u8,
    pub factor: f32,
}

/// A depthwise convolution of bytes; weights lie as kernel × channels.
#[derive(Debug, Clone)]
pub(crate) struct Depthwise {
    pub weight: Vec<i8>,
    pub start: Vec<i32>,
    pub factor: Vec<f32>,
    pub first: usize,
    pub step: usize,
    pub row_step: usize,
    /// Values of a row of the kernel, and their distance; rows, and their distance.
    pub taps: usize,
    pub apart: usize,
    pub lines: usize,
    pub line_apart: usize,
    pub ending: Ending,
    pub reach: i32,
    pub macs: usize,
}

/// The window of a convolution along a series, or over an image.
pub(crate) struct Taps {
    /// Values of a row of the kernel, and its rows.
    pub kernel: usize,
    pub lines: usize,
    /// Where the first window begins, in the input's memory; margins hold what lies before the first position.
    pub first: usize,
    /// Distance of the inputs of neighbouring outputs, and of those that neighbouring kernel values meet.
    pub step: usize,
    pub apart: usize,
    /// The same of rows.
    pub row_step: usize,
    pub line_apart: usize,
}

impl Taps {
    pub fn new(window: &Window3, dilation: [usize; 3], from: &Row) -> Self {
        Taps {
            kernel: window.kernel[2],
            lines: window.kernel[1],
            first: from.start - window.before[1] * from.row_pitch - window.before[2] * from.pitch,
            step: window.stride[2] * from.pitch,
            apart: dilation[2] * from.pitch,
            row_step: window.stride[1] * from.row_pitch,
            line_apart: dilation[1] * from.row_pitch,
        }
    }
}
