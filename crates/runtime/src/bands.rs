//! A pointwise convolution and the depthwise one that reads it, band of rows after band: what goes from one to the other
//! never leaves the cache.

use taxel_kernels::Window3;
use taxel_kernels::frozen::{self, ImagePlace, Route};

use crate::dense::DenseConv;
use crate::lower::Purpose;
use crate::step::{Conv, Pair};

/// Bytes that one band may take; a core's own cache holds them with weights and outputs.
const BAND: usize = 640 << 10;

/// Both convolutions of every band.
pub(crate) struct Bands {
    list: Vec<(DenseConv, frozen::Depthwise)>,
    /// Where the widest band lies in scratch.
    place: ImagePlace,
    /// Values of scratch behind it that the first convolutions need.
    rest: usize,
}

impl Bands {
    pub fn new(pair: &Pair, from: ImagePlace, to: ImagePlace, purpose: Purpose) -> Self {
        let Pair { first, second } = pair;
        let Window3 { input, output, kernel, stride, before } = second.window;
        let margin = frozen::margins(&second.window, second.dilation);
        let channels = to.channels;
        let band = |rows: usize| ImagePlace::new([1, rows, input[2]], channels, margin, channels, 0);
        let span = (kernel[1] - 1) * second.dilation[1] + 1;
        // Rows of inputs under so many rows of outputs.
        let under = |rows: usize| (rows - 1) * stride[1] + span;
        let fits = |rows: &usize| size_of::<f32>() * band(under(*rows)).buffer_len() <= BAND;
        let most = (1..=output[1]).take_while(fits).last().unwrap_or(1);
        let mut list = vec![];
        for start in (0..output[1]).step_by(most) {
            let rows = most.min(output[1] - start);
            let above = before[1].saturating_sub(start * stride[1]);
            let top = (start * stride[1]).saturating_sub(before[1]);
            let end = (start * stride[1] + under(rows)).saturating_sub(before[1]).min(input[1]);
            let (x, between, y) = (from.band(top, end - top), band(end - top), to.band(start, rows));
            let window = Window3 {
                input: between.size,
                output: y.size,
                before: [before[0], above, before[2]],
                ..second.window
            };
            let same = Window3 { input: x.size, output: between.size, ..first.window };
            list.push((
                DenseConv::new(first, &same, along(first, x, between), purpose),
                frozen::Depthwise::new(
                    &window,
                    second.dilation,
                    &second.weight,
                    &second.bias,
                    along(second, between, y),
                ),
            ));
        }
        let rest = list.iter().map(|(first, _)| first.work_len()).max().unwrap_or(0);
        Bands { list, place: band(under(most).min(input[1])), rest }
    }

    /// Returns the number of values of scratch that [`Bands::run`] needs.
    pub fn work_len(&self) -> usize {
        self.place.buffer_len() + self.rest
    }

    pub fn run(&self, x: &[f32], work: &mut [f32], y: &mut [f32]) {
        let ImagePlace { margin, channels, pitch, .. } = self.place;
        let (work, rest) = work.split_at_mut(self.place.buffer_len());
        for row in work.chunks_exact_mut(pitch[1]) {
            let (left, rest) = row.split_at_mut(margin[0] * channels);
            left.fill(0.0);
            let values = rest.len() - margin[1] * channels;
            rest[values..].fill(0.0);
        }
        for (first, second) in &self.list {
            first.run(x, None, rest, work);
            second.run(work, y);
        }
    }
}

fn along(conv: &Conv, from: ImagePlace, to: ImagePlace) -> Route {
    Route { rectifier: conv.rectifier, ..Route::new(from, to) }
}
