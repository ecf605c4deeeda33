//! The image of a grasp: readings of all fingers in one series, its field, its colours.
//!
//! # Reference
//!
//! Kaewrakmuk and Srinonchat 2026, section 4.2 and figure 5: 5 x 50 readings are
//! flattened row by row to 250, rescaled to `[-1, 1]`, encoded as a 50 x 50 GADF and coloured.
//!
//! # What is lost
//!
//! Flattening puts the end of one finger beside the start of the next: the step between them is a
//! property of the order of the rows. See [`Gaf`] for what rescaling loses.

use crate::finite::{check_finite, values};
use crate::gaf::Fields;
use crate::{Colormap, Error, Gaf, Result};
use ndarray::{Array3, Array4, ArrayView2, ArrayView3, ArrayViewMut3};
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
    /// Returns the shape of one image: `[channels, rows, columns]`.
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
        let mut image = Array3::zeros(self.shape());
        let mut into = image.view_mut();
        self.encode_into(recording, &mut self.plan(recording.len())?, &mut into)?;
        Ok(image)
    }

    fn encode_into(
        &self,
        recording: ArrayView2<f32>,
        plan: &mut ImagePlan,
        image: &mut ArrayViewMut3<f32>,
    ) -> Result<()> {
        let time = recording.ncols();
        // Channel after channel, whatever the layout in memory.
        let series = values(&recording);
        check_finite(&series, |at| format!("reading {} of channel {}", at % time, at / time))?;
        #[expect(clippy::expect_used, reason = "one image of a new array is one slice")]
        plan.encode(&series, image.as_slice_mut().expect("standard layout"))
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
        let (samples, sources, time) = recordings.dim();
        let mut images = Array4::zeros((samples, channels, rows, columns));
        if samples == 0 {
            return Ok(images);
        }
        let mut plan = self.plan(sources * time).map_err(|e| e.in_sample(0))?;
        for (sample, (recording, mut image)) in
            recordings.outer_iter().zip(images.outer_iter_mut()).enumerate()
        {
            self.encode_into(recording, &mut plan, &mut image).map_err(|e| e.in_sample(sample))?;
        }
        Ok(images)
    }

    /// Plans the image of recordings with so many `readings` over all channels, ready to be made again and again.
    ///
    /// # Errors
    ///
    /// Those of [`Gaf::check`]; [`Error::TooShort`] for fewer readings than the image has rows.
    pub fn plan(&self, readings: usize) -> Result<ImagePlan> {
        let fields = Fields::new(&self.gaf, readings)?;
        Ok(ImagePlan {
            fields,
            readings,
            colormap: self.colormap,
            size: self.gaf.size,
            row: vec![0.0; self.gaf.size],
        })
    }
}

/// A [`HardnessImage`] of recordings of one size: nothing is planned or allocated for another one.
#[derive(Debug, Clone)]
pub struct ImagePlan {
    fields: Fields,
    readings: usize,
    colormap: Colormap,
    size: usize,
    row: Vec<f32>,
}

impl ImagePlan {
    /// Encodes one recording, channel after channel, into `image` `[colour channels, size, size]`, bit for bit as
    /// [`HardnessImage::encode`] does.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for another number of readings or pixels, [`Error::NonFinite`], and [`Error::Constant`] as
    /// [`Gaf::encode`] has it.
    pub fn encode(&mut self, recording: &[f32], image: &mut [f32]) -> Result<()> {
        let pixels = self.colormap.channels() * self.size * self.size;
        if recording.len() != self.readings || image.len() != pixels {
            let expected = format!("{} readings and {pixels} pixels", self.readings);
            return Err(Error::Shape {
                what: "recording",
                expected,
                got: vec![recording.len(), image.len()],
            });
        }
        check_finite(recording, |at| format!("reading {at}"))?;
        self.fields.look(recording)?;
        for i in 0..self.size {
            self.fields.row(i, &mut self.row);
            self.colormap.paint(&self.row, image, i * self.size);
        }
        Ok(())
    }
}
