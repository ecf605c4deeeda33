//! The last reading of each channel and its differences to earlier ones.

use super::sink::{Sink, int};

/// Writes the rows `[batch, channels × (1 + lags), 1]` of `value` `[batch, channels, length]`.
pub(super) fn history(
    sink: &mut Sink,
    name: &str,
    value: &str,
    [channels, length]: [usize; 2],
    lags: &[usize],
) -> String {
    let base = |part: &str| format!("{name}/history/{part}");
    let at = |lag: usize| (length - 1 - lag) as i64;
    let axis = |axis: i64| vec![int("axis", axis)];
    let last = sink.ints(&base("last_step"), &[at(0)]);
    let last = sink.step("Gather", &[value, &last], &base("last"), axis(2));
    let mut rows = last.clone();
    if !lags.is_empty() {
        let steps: Vec<i64> = lags.iter().map(|lag| at(*lag)).collect();
        let steps = sink.ints(&base("steps"), &steps);
        let before = sink.step("Gather", &[value, &steps], &base("before"), axis(2));
        let apart = sink.step("Sub", &[&last, &before], &base("differences"), vec![]);
        rows = sink.step("Concat", &[&last, &apart], &base("joined"), axis(2));
    }
    let shape = sink.ints(&base("shape"), &[0, (channels * (1 + lags.len())) as i64, 1]);
    sink.step("Reshape", &[&rows, &shape], &format!("{name}/history"), vec![])
}
