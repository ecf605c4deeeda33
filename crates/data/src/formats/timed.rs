//! Recordings as they were read: rows with time stamps, which are brought to equal steps.

use crate::formats::clock::Timing;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};

/// Most values of a recording that is transposed through a copy; larger ones are transposed in place.
const COPIED: usize = 1 << 18;

/// Rows of numbers, recording after recording, in one block of memory.
#[derive(Debug, Default)]
pub(crate) struct Timed {
    /// Number of values in a row.
    pub width: usize,
    /// Number of rows of each recording.
    pub rows: Vec<usize>,
    /// Time stamps in seconds, one for each row; empty without a clock.
    pub stamps: Vec<f64>,
    /// `[rows, width]`.
    pub values: Vec<f32>,
}

impl Timed {
    /// Returns the time stamps of each recording.
    pub fn stamps(&self) -> Vec<&[f64]> {
        let mut rest = self.stamps.as_slice();
        let next = |rows: &usize| {
            let (stamps, after) = rest.split_at(rest.len().min(*rows));
            rest = after;
            stamps
        };
        self.rows.iter().map(next).collect()
    }

    /// Brings each recording to the equal steps of its `timing`, as `[width, time]`, or as `[time, shape]` where a row has a
    /// shape; `at` names them in messages.
    pub fn into_recordings(
        self,
        timing: Option<Timing>,
        shape: &[usize],
        at: &str,
        options: &ReadOptions,
    ) -> Result<Ragged> {
        let uneven = timing.filter(|timing| !timing.is_regular);
        if let Some(timing) = &uneven {
            let stamps = self.stamps();
            if let Some(why) = timing.gaps(&stamps) {
                return Err(Error::file(at, why));
            }
            let readings: f64 = stamps.iter().map(|times| timing.readings(times)).sum();
            options.limits.refuse_values(at, (readings * self.width as f64) as usize)?;
        }
        let Self { rows, mut values, width, .. } = self.at_equal_steps(uneven);
        if !shape.is_empty() {
            return Ok(Ragged::of_lengths(values, [&[0], shape].concat(), 0, rows));
        }
        let mut rest = values.as_mut_slice();
        for rows in &rows {
            let (recording, after) = rest.split_at_mut(rows * width);
            transpose(recording, *rows, width);
            rest = after;
        }
        Ok(Ragged::of_lengths(values, vec![width, 0], 1, rows))
    }

    fn at_equal_steps(self, uneven: Option<Timing>) -> Self {
        let Some(timing) = uneven else { return self };
        let rows: Vec<usize> =
            self.stamps().into_iter().map(|stamps| timing.readings(stamps) as usize).collect();
        let mut values = Vec::with_capacity(rows.iter().sum::<usize>() * self.width);
        let mut rest = self.values.as_slice();
        for stamps in self.stamps() {
            let (recording, after) = rest.split_at(stamps.len() * self.width);
            timing.resample(stamps, recording, self.width, &mut values);
            rest = after;
        }
        Self { width: self.width, rows, stamps: vec![], values }
    }

    /// Sorts rows by recording, in place. They were read in `runs`: a recording, and the number of its rows that came
    /// together.
    pub fn sort(&mut self, runs: &[(usize, usize)]) {
        let mut next: Vec<usize> =
            self.rows.iter().scan(0, |at, rows| Some(std::mem::replace(at, *at + rows))).collect();
        let mut to = Vec::with_capacity(self.rows.iter().sum());
        for (recording, rows) in runs {
            to.extend(next[*recording]..next[*recording] + rows);
            next[*recording] += rows;
        }
        for row in 0..to.len() {
            while to[row] != row {
                let other = to[row];
                to.swap(row, other);
                if !self.stamps.is_empty() {
                    self.stamps.swap(row, other);
                }
                let (first, second) = self.values.split_at_mut(row.max(other) * self.width);
                first[row.min(other) * self.width..][..self.width].swap_with_slice(&mut second[..self.width]);
            }
        }
    }
}

/// Transposes `[rows, width]` to `[width, rows]`.
fn transpose(values: &mut [f32], rows: usize, width: usize) {
    if rows < 2 || width < 2 {
        return;
    }
    // In place, positions are products in 64 bits, which larger numbers would overflow.
    if values.len() <= COPIED || u32::try_from(values.len()).is_err() {
        let copy = values.to_vec();
        for (column, out) in values.chunks_exact_mut(rows).enumerate() {
            let from = copy.iter().skip(column).step_by(width);
            out.iter_mut().zip(from).for_each(|(out, value)| *out = *value);
        }
        return;
    }
    transpose_in_place(values, rows);
}

/// Transposes in place. The value at i goes to i · rows mod (len − 1), the value there goes on likewise until the circle
/// closes; the first and the last stay.
fn transpose_in_place(values: &mut [f32], rows: usize) {
    let last = values.len() - 1;
    let mut is_placed = vec![0u64; values.len().div_ceil(64)];
    for start in 1..last {
        if is_placed[start / 64] >> (start % 64) & 1 == 1 {
            continue;
        }
        let (mut at, mut value) = (start, values[start]);
        loop {
            at = (at as u64 * rows as u64 % last as u64) as usize;
            std::mem::swap(&mut value, &mut values[at]);
            is_placed[at / 64] |= 1 << (at % 64);
            if at == start {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns_with_a_copy_and_without() {
        for (rows, width) in [(2, 2), (3, 5), (7, 3), (1, 4), (4, 1), (12, 8)] {
            let values: Vec<f32> = (0..rows * width).map(|i| i as f32).collect();
            let want: Vec<f32> =
                (0..width).flat_map(|c| (0..rows).map(move |t| (t * width + c) as f32)).collect();
            let (mut copied, mut placed) = (values.clone(), values);
            transpose(&mut copied, rows, width);
            assert_eq!(copied, want);
            if rows > 1 && width > 1 {
                transpose_in_place(&mut placed, rows);
                assert_eq!(placed, want);
            }
        }
    }

    #[test]
    fn mixed_rows_are_sorted_by_recording() {
        let rows = [(1, 0), (0, 0), (2, 0), (0, 1), (0, 2), (1, 1)];
        let number = |(recording, row): &(usize, usize)| (10 * recording + row) as f32;
        let mut timed = Timed {
            width: 2,
            rows: vec![3, 2, 1],
            stamps: rows.iter().map(|row| f64::from(number(row))).collect(),
            values: rows.iter().flat_map(|row| [number(row), -number(row)]).collect(),
        };
        timed.sort(&[(1, 1), (0, 1), (2, 1), (0, 2), (1, 1)]);
        assert_eq!(timed.stamps, [0.0, 1.0, 2.0, 10.0, 11.0, 20.0]);
        assert_eq!(timed.values[2..6], [1.0, -1.0, 2.0, -2.0]);
        assert_eq!(timed.stamps()[1], [10.0, 11.0]);
    }
}
