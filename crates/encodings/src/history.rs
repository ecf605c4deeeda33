//! The last reading of each channel, and how far it is from earlier ones.
//!
//! # Reference
//! Differences of a signal to its past (lag features), of which the last reading alone knows nothing: a soft sensor answers to what
//! came before.

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// The last reading of each channel and its differences to readings so many steps before.
///
/// ```
/// use taxel_encodings::History;
///
/// let history = History { lags: vec![1, 2] };
/// let mut rows = [0.0; 3];
/// history.encode([1, 4], &[5.0, 1.0, 2.0, 4.0], &mut rows)?;
/// assert_eq!(rows, [4.0, 2.0, 3.0]);
/// # Ok::<(), taxel_encodings::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// Time steps before the last one, each at least 1.
    pub lags: Vec<usize>,
}

impl Default for History {
    fn default() -> Self {
        History { lags: vec![1, 2, 4, 8, 16, 32] }
    }
}

impl History {
    /// Returns the shape of what becomes of `channels` × time: a row of one value for each channel's last reading and differences.
    pub fn shape(&self, channels: usize) -> [usize; 2] {
        [channels * (1 + self.lags.len()), 1]
    }

    /// Checks that recordings of `length` time steps reach back far enough.
    ///
    /// # Errors
    /// A lag of 0, or one that a recording does not reach back to.
    pub fn check(&self, length: usize) -> Result<()> {
        match self.lags.iter().find(|lag| **lag == 0 || **lag >= length) {
            None => Ok(()),
            Some(lag) => Err(Error::Lag { lag: *lag, length }),
        }
    }

    /// Encodes one recording of `[channels, length]`, row-major.
    ///
    /// # Errors
    /// As [`History::check`].
    ///
    /// # Panics
    /// Slices of another length.
    pub fn encode(&self, [channels, length]: [usize; 2], recording: &[f32], rows: &mut [f32]) -> Result<()> {
        self.check(length)?;
        assert_eq!(recording.len(), channels * length, "a recording of that shape");
        assert_eq!(rows.len(), channels * (1 + self.lags.len()), "a row for each reading and difference");
        let each = recording.chunks_exact(length).zip(rows.chunks_exact_mut(1 + self.lags.len()));
        for (series, rows) in each {
            let last = series[length - 1];
            rows[0] = last;
            for (row, lag) in rows[1..].iter_mut().zip(&self.lags) {
                *row = last - series[length - 1 - lag];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_channel_has_its_last_reading_and_its_differences() {
        let history = History { lags: vec![1, 3] };
        let mut rows = [0.0; 6];
        let recording = [1.0, 2.0, 4.0, 8.0, -1.0, 0.0, 0.5, 0.25];
        assert_eq!(history.encode([2, 4], &recording, &mut rows), Ok(()));
        assert_eq!(rows, [8.0, 4.0, 7.0, 0.25, -0.25, 1.25]);
        assert_eq!(history.shape(2), [6, 1]);
    }

    #[test]
    fn a_lag_beyond_the_recording_is_refused() {
        assert_eq!(History { lags: vec![1, 4] }.check(4), Err(Error::Lag { lag: 4, length: 4 }));
        assert_eq!(History { lags: vec![0] }.check(4), Err(Error::Lag { lag: 0, length: 4 }));
        assert_eq!(History { lags: vec![] }.check(1), Ok(()));
    }
}
