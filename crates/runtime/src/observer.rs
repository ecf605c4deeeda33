//! Looks at the values that samples lead to.

use taxel_graph::{Graph, Weights};

use crate::error::Result;
use crate::frozen::{Frozen, Workspace};
use crate::memory::ProgramBuffer;
use crate::ranges::Ranges;

/// Answers samples and keeps the [`Ranges`] of all values that [`Frozen::quantized`] will write in bytes.
pub struct Observer {
    frozen: Frozen,
    workspace: Workspace,
    ranges: Ranges,
}

impl Observer {
    /// Makes an observer that has seen nothing.
    ///
    /// # Errors
    /// Weights that do not fit the graph.
    pub fn new(graph: &Graph, weights: &Weights) -> Result<Self> {
        let frozen = Frozen::observed(graph, weights)?;
        Ok(Observer { workspace: frozen.workspace(), frozen, ranges: Ranges::new() })
    }

    /// Looks at the values that one sample leads to; `inputs` are as those of [`Frozen::predict`]. Values that are not
    /// finite are passed over.
    ///
    /// # Errors
    /// Inputs of another number or length.
    pub fn see(&mut self, inputs: &[&[f32]]) -> Result<()> {
        let Observer { frozen, workspace, ranges } = self;
        frozen.show(workspace, inputs, |name, place, memory| {
            let ProgramBuffer::Floats(values) = memory else { return };
            if name.is_empty() {
                return;
            }
            let mut range = [f32::INFINITY, f32::NEG_INFINITY];
            let [depths, rows, columns] = place.size;
            for position in 0..depths * rows * columns {
                let at = [position / (rows * columns), position / columns % rows, position % columns];
                let values = &values[place.at(at)..][..place.channels];
                for value in values.iter().filter(|value| value.is_finite()) {
                    range = [range[0].min(*value), range[1].max(*value)];
                }
            }
            if range[0] <= range[1] {
                let seen = ranges.entry(name.to_string()).or_insert(range);
                *seen = [seen[0].min(range[0]), seen[1].max(range[1])];
            }
        })
    }

    /// Returns the ranges that were seen.
    pub fn ranges(self) -> Ranges {
        self.ranges
    }
}
