//! The output that says how unlike a sample is what a model has learned.

use super::sink::{Sink, int, ints};
use super::value::info;
use crate::proto::ValueInfo;

/// Name of the output: the relative Mahalanobis distance of the logits `[batch]` (Ren et al. 2021, equation 3).
pub const DISTANCE: &str = "distance";
/// Key of the fact that lists distances of held-out samples, descending: the i-th, from 0, is reached by the share
/// (i + 1)/100 of them.
pub const DISTANCES: &str = "taxel.distances";

/// Where the logits of the classes of one attribute lie.
#[derive(Debug, Clone, PartialEq)]
pub struct GatePlace {
    /// Mean logits `[classes]`.
    pub center: Vec<f32>,
    /// Lower triangle of the matrix that brings deviations from a class to variance 1, row by row.
    pub within: Vec<f32>,
    /// The same for deviations from the center.
    pub around: Vec<f32>,
    /// Means of the classes, less the center, times `within`: `[classes with samples, classes]`.
    pub means: Vec<f32>,
}

impl GatePlace {
    /// Adds the distance of `logits` `[batch, classes]` and returns the name of its value `[batch]`.
    fn emit(&self, sink: &mut Sink, logits: &str) -> String {
        let size = self.center.len();
        let name = |part: &str| format!("{DISTANCE}/{part}");
        let center = sink.floats(&name("center"), &[size], &self.center);
        let off = sink.step("Sub", &[logits, &center], &name("off"), vec![]);
        let [within, around] =
            [("within", &self.within), ("around", &self.around)].map(|(part, triangle)| {
                let matrix = sink.floats(&name(part), &[size, size], &transposed(triangle, size));
                sink.step("MatMul", &[&off, &matrix], &name("whitened"), vec![])
            });
        let over = |axis: i64| vec![ints("axes", vec![axis]), int("keepdims", 0)];
        let to_all = sink.step("ReduceSumSquare", &[&around], &name("to_all"), over(1));
        let axis = sink.ints(&name("axis"), &[1]);
        let apart = sink.step("Unsqueeze", &[&within, &axis], &name("apart"), vec![]);
        let means = sink.floats(&name("means"), &[1, self.means.len() / size.max(1), size], &self.means);
        let from_means = sink.step("Sub", &[&apart, &means], &name("from_means"), vec![]);
        let squares = sink.step("ReduceSumSquare", &[&from_means], &name("to_means"), over(2));
        let nearest = sink.step("ReduceMin", &[&squares], &name("nearest"), over(1));
        sink.step("Sub", &[&nearest, &to_all], &name("relative"), vec![])
    }
}

/// Adds the output of a gate behind `logits`, summed over the attributes; none where the name is taken.
pub(super) fn distance(places: &[GatePlace], logits: &str, sink: &mut Sink) -> Option<ValueInfo> {
    if places.is_empty() || !sink.take(DISTANCE) {
        return None;
    }
    let name = |part: &str| format!("{DISTANCE}/{part}");
    let (mut start, mut sum): (i64, Option<String>) = (0, None);
    for place in places {
        let size = place.center.len() as i64;
        let own = match places {
            [_] => logits.to_string(),
            _ => {
                let ends = [start, start + size].map(|end| sink.ints(&name("end"), &[end]));
                let axis = sink.ints(&name("axis"), &[1]);
                sink.step("Slice", &[logits, &ends[0], &ends[1], &axis], &name("part"), vec![])
            }
        };
        start += size;
        let distance = place.emit(sink, &own);
        sum = Some(match sum {
            None => distance,
            Some(before) => sink.step("Add", &[&before, &distance], &name("sum"), vec![]),
        });
    }
    sink.put("Identity", &[&sum?], DISTANCE, vec![]);
    Some(info(DISTANCE, &[], None))
}

/// Returns a lower triangle as the transposed matrix, row by row.
pub(super) fn transposed(triangle: &[f32], size: usize) -> Vec<f32> {
    let at =
        |row: usize, column: usize| if column > row { 0.0 } else { triangle[row * (row + 1) / 2 + column] };
    (0..size).flat_map(|column| (0..size).map(move |row| at(row, column))).collect()
}
