//! Recordings of one shape, which every method reads.

use crate::{Error, Result};

/// Recordings `[n, channels, length]`, row-major, all finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series<'a> {
    pub(crate) values: &'a [f32],
    channels: usize,
    length: usize,
    /// How much each recording counts in training; none where all count alike.
    pub(crate) weights: Option<&'a [f32]>,
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
            None => Ok(Series { values, channels, length, weights: None }),
        }
    }

    /// Returns the same recordings with weights for training: one of weight 2 counts as much as two of weight 1.
    ///
    /// # Errors
    /// Another number of weights than recordings, or one that is not above 0 and finite.
    pub fn weighted(self, weights: &'a [f32]) -> Result<Self> {
        if weights.len() != self.len() {
            return Err(Error::Labels { labels: weights.len(), samples: self.len() });
        }
        match weights.iter().find(|weight| !(**weight > 0.0 && weight.is_finite())) {
            Some(weight) => Err(Error::setting("weight", weight, "must be above 0 and finite")),
            None => Ok(Series { weights: Some(weights), ..self }),
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
