//! Rows of few channels, several taken as one, so that they fill a vector.

use crate::lengths::exactly;

/// The widest folded row.
const WIDE: usize = 16;

/// How rows of so many channels are folded.
#[derive(Clone, Copy)]
pub(crate) struct Fold {
    channels: usize,
    rows: usize,
}

impl Fold {
    /// Makes a fold of rows of `channels`; `None` where one row fills a vector by more than half, or has no channel.
    pub fn new(channels: usize) -> Option<Self> {
        (channels > 0 && channels <= WIDE / 2).then(|| Fold { channels, rows: WIDE / channels })
    }

    /// Returns the number of channels of a folded row.
    pub fn channels(self) -> usize {
        self.channels * self.rows
    }

    /// Returns how many of `len` values lie in whole folded rows.
    pub fn whole(self, len: usize) -> usize {
        len / self.channels() * self.channels()
    }

    /// Repeats a coefficient per channel for every row taken together.
    pub fn repeat(self, values: &[f32]) -> Repeated {
        exactly("a coefficient per channel", values.len(), self.channels);
        let mut wide = [0.0; WIDE];
        for row in wide[..self.channels()].chunks_exact_mut(self.channels) {
            row.copy_from_slice(values);
        }
        Repeated { wide, len: self.channels() }
    }

    /// Returns zeros to which the sums per channel of a folded row are added, before [`Fold::add_up`].
    pub fn zeros(self) -> Repeated {
        Repeated { wide: [0.0; WIDE], len: self.channels() }
    }

    /// Adds the sums of all rows taken together to those per channel.
    pub fn add_up(self, wide: &Repeated, sums: &mut [f32]) {
        exactly("a sum per channel", sums.len(), self.channels);
        for row in wide.wide[..wide.len].chunks_exact(self.channels) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += value;
            }
        }
    }
}

/// One value per channel of a folded row.
pub(crate) struct Repeated {
    wide: [f32; WIDE],
    len: usize,
}

impl std::ops::Deref for Repeated {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.wide[..self.len]
    }
}

impl std::ops::DerefMut for Repeated {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.wide[..self.len]
    }
}
