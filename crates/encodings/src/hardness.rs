//! The image of a grasp: readings of all fingers in one series, its field, its colours.
//!
//! # Reference
//!
//! Paper 000 (Hybrid-CNN hardness recognition), section 4.2 and figure 5: 5 x 50 readings are
//! flattened row by row to 250, rescaled to `[-1, 1]`, encoded as a 50 x 50 GADF and coloured.
//!
//! # What is lost
//!
//! Flattening puts the end of one finger beside the start of the next: the step between them is a
//! property of the order of the rows. See [`Gaf`] for what rescaling loses.

use crate::{Colormap, Error, Gaf, Result};
use ndarray::{Array1, Array3, Array4, ArrayView2, ArrayView3, Axis};
use serde::{Deserialize, Serialize};

/// Settings of the image; the default is the paper's `[3, 50, 50]`, in Jet.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HardnessImage {
    /// The field.
    #[serde(default)]
    pub gaf: Gaf,
    /// Its colours.
    #[serde(default)]
    pub colormap: Colormap,
}

impl HardnessImage {
    /// The shape of one image: `[channels, rows, columns]`.
    pub fn shape(&self) -> [usize; 3] {
        [self.colormap.channels(), self.gaf.size, self.gaf.size]
    }

    /// Encodes one recording `[channels, time]` of any size as an image
    /// `[colour channels, size, size]` with values 0..1.
    ///
    /// # Errors
    ///
    /// Those of [`Gaf::encode`]; a bad reading is named by channel and time.
    pub fn encode(&self, recording: ArrayView2<f32>) -> Result<Array3<f32>> {
        let bad = recording.indexed_iter().find(|(_, v)| !v.is_finite());
        if let Some(((channel, time), &value)) = bad {
            return Err(Error::NonFinite { place: format!("reading {time} of channel {channel}"), value });
        }
        // `iter` walks the rows in logical order, whatever the layout in memory.
        let series: Array1<f32> = recording.iter().copied().collect();
        self.colormap.apply(&self.gaf.encode(series.view())?)
    }

    /// Encodes a batch `[samples, channels, time]` as `[samples, colour channels, size, size]`.
    /// An empty batch gives an empty batch.
    ///
    /// # Errors
    ///
    /// Those of [`HardnessImage::encode`], naming the first sample that fails.
    pub fn encode_batch(&self, recordings: ArrayView3<f32>) -> Result<Array4<f32>> {
        self.gaf.check()?;
        let [channels, rows, columns] = self.shape();
        let samples = recordings.len_of(Axis(0));
        let mut images = Array4::zeros((samples, channels, rows, columns));
        for (sample, (recording, mut image)) in
            recordings.outer_iter().zip(images.outer_iter_mut()).enumerate()
        {
            image.assign(&self.encode(recording).map_err(|e| e.in_sample(sample))?);
        }
        Ok(images)
    }
}
