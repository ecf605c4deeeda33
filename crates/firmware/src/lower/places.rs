//! Where values lie in the memory of C: as in the runtime, but rows of an image share the margins between them, and rows of zeros
//! lie above and below what convolutions read there.

use taxel_kernels::frozen::ImagePlace;
use taxel_runtime::{Blueprint, PlannedConv, PlannedOp, PlannedStep};

use super::COUNT;
use crate::layer::{Gaps, Memory, Row};

/// The rows and memories of all steps.
pub(super) struct Places {
    pub rows: Vec<Row>,
    pub memories: Vec<Memory>,
}

impl Places {
    /// Places the values of a network.
    ///
    /// # Errors
    /// The reason, where a value has no place in C.
    pub fn new(blueprint: &Blueprint) -> Result<Self, String> {
        let steps = &blueprint.steps;
        let mut beyond = vec![[0; 2]; steps.len()];
        for step in steps {
            if let (PlannedOp::Conv(conv), Some(&input)) = (&step.op, step.inputs.first()) {
                let margin = &mut beyond[steps[input].memory];
                let needed = rows_beyond(conv);
                *margin = [margin[0].max(needed[0]), margin[1].max(needed[1])];
            }
        }
        let row = |step: &PlannedStep| -> Result<Row, String> {
            check(step, blueprint.in_floats)?;
            Ok(row(step, &Frame::new(&step.place, beyond[step.memory])))
        };
        let memory = |(id, step): (usize, &PlannedStep)| {
            if step.memory != id {
                return Memory::of_floats(0);
            }
            let zero = step.scale.map(|scale| scale.zero);
            Memory { zero, ..Frame::new(&step.place, beyond[id]).memory(&step.place) }
        };
        let rows = steps.iter().map(row).collect::<Result<Vec<Row>, String>>()?;
        Ok(Places { rows, memories: steps.iter().enumerate().map(memory).collect() })
    }
}

/// Returns the rows of zeros that a convolution reads above and below its input.
fn rows_beyond(conv: &PlannedConv) -> [usize; 2] {
    let window = &conv.window;
    let last =
        (window.output[1].max(1) - 1) * window.stride[1] + (window.kernel[1] - 1) * conv.dilation[1] + 1;
    [window.before[1], last.saturating_sub(window.before[1] + window.input[1])]
}

/// Refuses values that C does not compute.
fn check(step: &PlannedStep, in_floats: bool) -> Result<(), String> {
    let ImagePlace { size: [depth, rows, columns], channels, pitch, .. } = step.place;
    let (name, bytes) = (&step.name, step.place.len() * size_of::<f32>());
    if depth != 1 {
        return Err(format!(
            "layer `{name}` computes {channels}×{depth}×{rows}×{columns} values ({bytes} bytes in floats); only networks on series and \
             on images can be exported"
        ));
    }
    if rows != 1 && in_floats {
        return Err(format!(
            "layer `{name}` computes {channels}×{rows}×{columns} values in 32-bit floats ({bytes} bytes); networks on images are \
             exported in eight bits alone: `taxel quantize` makes one"
        ));
    }
    if rows * columns > COUNT || channels > COUNT || pitch[2] > COUNT {
        let size = if rows == 1 { columns.to_string() } else { format!("{rows}×{columns}") };
        return Err(format!(
            "layer `{name}` has {channels}×{size} values; {COUNT} channels and {COUNT} positions are the most"
        ));
    }
    Ok(())
}

/// The margins of a memory: rows above and below, columns before, between and after the rows.
struct Frame {
    above: usize,
    below: usize,
    before: usize,
    between: usize,
    after: usize,
}

impl Frame {
    fn new(place: &ImagePlace, [above, below]: [usize; 2]) -> Self {
        let [before, after] = place.margin;
        let between = if above + place.size[1] + below > 1 { before.max(after) } else { 0 };
        Frame { above, below, before, between, after }
    }

    /// Returns the values of a row with the columns behind it.
    fn row_pitch(&self, place: &ImagePlace) -> usize {
        (place.size[2] + self.between) * place.pitch[2]
    }

    /// Returns the memory of the values of a place.
    fn memory(&self, place: &ImagePlace) -> Memory {
        let ([_, rows, columns], width, row) = (place.size, place.pitch[2], self.row_pitch(place));
        let margins = [self.above * row + self.before * width, self.below * row + self.after * width];
        let gaps = Gaps { len: self.between * width, apart: row, count: rows - 1 };
        let gaps = if gaps.len * gaps.count == 0 { Gaps::default() } else { gaps };
        Memory {
            len: margins[0] + (rows - 1) * row + columns * width + margins[1],
            margins,
            gaps,
            zero: None,
        }
    }
}

fn row(step: &PlannedStep, frame: &Frame) -> Row {
    let ImagePlace { size: [_, rows, positions], channels, start, pitch, margin } = step.place;
    let row_pitch = frame.row_pitch(&step.place);
    // The first channel among those of other values.
    let first = start - margin[0] * pitch[2];
    let start = frame.above * row_pitch + frame.before * pitch[2] + first;
    Row {
        memory: step.memory,
        start,
        pitch: pitch[2],
        positions,
        channels,
        rows,
        row_pitch,
        scale: step.scale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_share_the_columns_between_them_and_hold_all_that_windows_read() {
        let place = ImagePlace::new([1, 3, 4], 2, [1, 2], 5, 3);
        let frame = Frame::new(&place, [1, 2]);
        let memory = frame.memory(&place);
        assert_eq!(frame.row_pitch(&place), 30);
        // One row and a column before the first value; two rows and two columns behind the last.
        assert_eq!(memory.margins, [35, 70]);
        assert_eq!(memory.len, 35 + 2 * 30 + 20 + 70);
        assert_eq!(memory.gaps, Gaps { len: 10, apart: 30, count: 2 });
        // A series has no more than its margins.
        let place = ImagePlace::new([1, 1, 4], 2, [1, 2], 5, 3);
        let memory = Frame::new(&place, [0, 0]).memory(&place);
        assert_eq!((memory.len, memory.margins), (35, [5, 10]));
        assert_eq!(memory.gaps, Gaps::default());
    }
}
