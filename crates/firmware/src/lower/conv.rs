//! Convolutions and linear layers of bytes.

use taxel_kernels::frozen::bytes::ByteScale;
use taxel_runtime::PlannedConv;

use super::{COUNT, output};
use crate::layer::{Addend, Conv, Depthwise, Row, Taps, Work};

/// How many times as many weights as there are may be stored, with zeros between them.
const SPARSE: usize = 4;

fn bytes(row: &Row) -> Result<ByteScale, String> {
    row.scale.ok_or_else(|| "it reads floats".to_string())
}

/// The stretches of inputs that a filter reads, one after the other.
struct Stretches {
    count: usize,
    /// Values of each, and the distance of neighbouring ones.
    run: usize,
    apart: usize,
    /// From one row of the kernel to the next: stretches, and values within one.
    by_line: [usize; 2],
    /// The same of columns.
    by_column: [usize; 2],
}

impl Stretches {
    /// Returns the stretches of a window over `channels` of `from`.
    fn new(taps: &Taps, from: &Row, channels: usize) -> Self {
        let Taps { kernel, lines, apart, line_apart, .. } = *taps;
        // Channels of neighbouring positions lie one after the other.
        let is_whole = apart == channels && from.pitch == channels;
        let row = kernel * channels;
        if is_whole && (lines == 1 || line_apart == row) {
            // So do those of neighbouring rows.
            return Stretches {
                count: 1,
                run: lines * row,
                apart,
                by_line: [0, row],
                by_column: [0, channels],
            };
        }
        if lines == 1 {
            return Stretches { count: kernel, run: channels, apart, by_line: [0; 2], by_column: [1, 0] };
        }
        // A row of the kernel is one stretch, in which other channels and skipped positions have weights of 0.
        let run = (kernel - 1) * apart + channels;
        Stretches { count: lines, run, apart: line_apart, by_line: [1, 0], by_column: [0, apart] }
    }

    /// Returns where a filter's weight of this row, column and channel stands.
    fn place(&self, line: usize, column: usize, channel: usize) -> usize {
        let [stretch, at] = [0, 1].map(|i| line * self.by_line[i] + column * self.by_column[i]);
        stretch * self.fours() * 4 + at + channel
    }

    fn fours(&self) -> usize {
        self.run.div_ceil(4)
    }
}

pub(super) fn convolution(conv: &PlannedConv, from: &[Row], to: &Row) -> Result<Work, String> {
    let input = bytes(&from[0])?;
    let taps = Taps::new(&conv.window, conv.dilation, &from[0]);
    let channels = from[0].channels / conv.groups;
    let stretches = Stretches::new(&taps, &from[0], channels);
    let Filters { weight, start, reach } =
        Filters::new(conv, &taps, &stretches, [channels, to.channels], input)?;
    let addend = match from.get(1) {
        None => None,
        Some(row) => {
            let scale = bytes(row)?;
            Some(Addend { zero: scale.zero, factor: output(to).factor(scale.step) })
        }
    };
    Ok(Work::Conv(Conv {
        weight,
        start,
        factor: conv.unit.iter().map(|unit| output(to).factor(*unit)).collect(),
        first: taps.first,
        step: taps.step,
        row_step: taps.row_step,
        segments: stretches.count,
        apart: stretches.apart,
        fours: stretches.fours(),
        groups: conv.groups,
        channels,
        addend,
        ending: output(to).ending(conv.rectifier),
        reach: whole(reach)?,
        macs: to.len() * to.channels * taps.lines * taps.kernel * channels,
        statistics: vec![],
        then: None,
    }))
}

/// The weights of all filters as stretches, where their sums start, and the largest sum.
struct Filters {
    weight: Vec<i8>,
    start: Vec<i32>,
    reach: i64,
}

impl Filters {
    fn new(
        conv: &PlannedConv,
        taps: &Taps,
        stretches: &Stretches,
        [channels, count]: [usize; 2],
        input: ByteScale,
    ) -> Result<Self, String> {
        let (columns, of_each) = (taps.kernel, taps.lines * taps.kernel * channels);
        let length = stretches.count * stretches.fours() * 4;
        let numbers = [taps.step, stretches.apart, stretches.fours(), stretches.count, of_each];
        if numbers.iter().any(|number| *number > COUNT) {
            return Err(format!(
                "its filters have {of_each} weights, and stretches of values {} apart; {COUNT} are the most",
                stretches.apart
            ));
        }
        if taps.lines > 1 && stretches.run > SPARSE * columns * channels {
            return Err(format!(
                "its filters read {channels} channels of more, or skip positions: {length} weights of each would be stored for \
                 {of_each}"
            ));
        }
        let mut filters = Filters { weight: vec![0; count * length], start: vec![], reach: 0 };
        let in_group = count / conv.groups;
        for (filter, row) in filters.weight.chunks_exact_mut(length).enumerate() {
            let (group, inside) = (filter / in_group, filter % in_group);
            let of_group = &conv.weight[group * of_each * in_group..][..of_each * in_group];
            let of_filter = of_group.iter().skip(inside).step_by(in_group);
            for (at, w) in of_filter.clone().enumerate() {
                let position = at / channels;
                row[stretches.place(position / columns, position % columns, at % channels)] = *w;
            }
            let (begin, most) = sums(conv.bias[filter], input, of_filter);
            filters.reach = filters.reach.max(most);
            filters.start.push(begin);
        }
        Ok(filters)
    }
}

/// Returns where the sums of a filter start, as if bytes were numbers from -128 on, and the largest one whatever the bytes.
fn sums<'w>(bias: i32, input: ByteScale, weights: impl Iterator<Item = &'w i8>) -> (i32, i64) {
    let (mut sum, mut most) = (0i64, 0i64);
    for w in weights {
        sum += i64::from(*w);
        most += 128 * i64::from(w.unsigned_abs());
    }
    let begin = i64::from(bias) - (i64::from(input.zero) - 128) * sum;
    (begin as i32, begin.abs() + most)
}

/// Returns the largest sum, which has to fit 31 bits.
fn whole(reach: i64) -> Result<i32, String> {
    if reach < 1 << 30 {
        Ok(reach as i32)
    } else {
        Err(format!("its sums reach {reach}; 2³⁰ is the most"))
    }
}

pub(super) fn depthwise(conv: &PlannedConv, from: &[Row], to: &Row) -> Result<Work, String> {
    let input = bytes(&from[0])?;
    let Taps { kernel, lines, first, step, apart, row_step, line_apart } =
        Taps::new(&conv.window, conv.dilation, &from[0]);
    if [step, apart, kernel, lines].iter().any(|number| *number > COUNT) {
        return Err(format!("its values lie {apart} apart; {COUNT} is the most"));
    }
    let (mut start, mut reach) = (vec![], 0i64);
    for channel in 0..to.channels {
        let of_channel = conv.weight.iter().skip(channel).step_by(to.channels);
        let (begin, most) = sums(conv.bias[channel], input, of_channel);
        reach = reach.max(most);
        start.push(begin);
    }
    Ok(Work::Depthwise(Depthwise {
        weight: conv.weight.clone(),
        start,
        factor: conv.unit.iter().map(|unit| output(to).factor(*unit)).collect(),
        first,
        step,
        row_step,
        taps: kernel,
        apart,
        lines,
        line_apart,
        ending: output(to).ending(conv.rectifier),
        reach: whole(reach)?,
        macs: to.len() * to.channels * kernel * lines,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(taps: &Taps, pitch: usize, channels: usize) -> (Vec<usize>, usize, usize) {
        let from = Row {
            memory: 0,
            start: 0,
            pitch,
            positions: 5,
            channels,
            rows: 5,
            row_pitch: 5 * pitch,
            scale: None,
        };
        let stretches = Stretches::new(taps, &from, channels);
        let all = (0..taps.lines).flat_map(|line| (0..taps.kernel).map(move |column| (line, column)));
        let places = all.map(|(line, column)| stretches.place(line, column, 0)).collect();
        (places, stretches.count, stretches.run)
    }

    #[test]
    fn rows_of_a_kernel_are_stretches() {
        let taps = |kernel, lines, apart, line_apart| Taps {
            kernel,
            lines,
            first: 0,
            step: 1,
            apart,
            row_step: 0,
            line_apart,
        };
        // Two rows of three positions with two channels each: rows of six values, filled up to eight.
        assert_eq!(places(&taps(3, 2, 2, 10), 2, 2), (vec![0, 2, 4, 8, 10, 12], 2, 6));
        // The whole image, as a linear layer reads it.
        assert_eq!(places(&taps(5, 2, 2, 10), 2, 2), ((0..10).map(|at| 2 * at).collect(), 1, 20));
        // Positions of a series whose channels are part of others.
        assert_eq!(places(&taps(3, 1, 7, 0), 7, 2), (vec![0, 4, 8], 3, 2));
        // The same of an image: between them are weights of 0.
        assert_eq!(places(&taps(2, 2, 7, 35), 7, 2), (vec![0, 7, 12, 19], 2, 9));
    }
}
