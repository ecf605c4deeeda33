//! Recordings of one shape, which every method reads.

use crate::{Error, Result};

/// Recordings `[n, channels, length]`, row-major, all finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series<'a> {
    pub(crate) values: &'a [f32],
    channels: usize,
    length: usize,
}

impl<'a> Series<'a> {
    /// Views `values` as recordings of `channels` × `length`.
    ///
    /// # Errors
    /// No recordings, a rest that is no whole recording, or a value that is not finite.
    pub fn new(values: &'a [f32], channels: usize, length: usize) -> Result<Self> {
        let each = channels * length;
        if each == 0 || values.is_empty() || !values.len().is_multiple_of(each) {
            return Err(Error::Shape { values: values.len(), channels, length });
        }
        match values.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(Error::NotFinite { sample: at / each, value: values[at] }),
            None => Ok(Series { values, channels, length }),
        }
    }

    /// Returns the number of recordings.
    pub fn len(&self) -> usize {
        self.values.len() / (self.channels * self.length)
    }

    /// Checks whether there is no recording. There is always at least one.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns channels and length of a recording.
    pub fn shape(&self) -> [usize; 2] {
        [self.channels, self.length]
    }

    /// Returns the values of recording `i`, channel after channel.
    pub fn sample(&self, i: usize) -> &'a [f32] {
        let each = self.channels * self.length;
        &self.values[i * each..(i + 1) * each]
    }

    /// Returns one channel of recording `i`.
    pub fn channel(&self, i: usize, channel: usize) -> &'a [f32] {
        &self.sample(i)[channel * self.length..(channel + 1) * self.length]
    }

    /// Refuses series of another shape than a method was fitted to.
    pub(crate) fn expect(&self, fitted: [usize; 2]) -> Result<()> {
        if self.shape() == fitted { Ok(()) } else { Err(Error::OtherShape { fitted, given: self.shape() }) }
    }
}
