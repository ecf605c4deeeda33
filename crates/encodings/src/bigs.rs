//! Electrode series of a hand as a colour image.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021 (Transfer of learning from vision to touch), section 3.4: the first 700 values of the 7 x 3
//! electrodes of BiGS recordings, 7 x 3 x 700, are reshaped to 70 x 70 x 3. The text does not say in
//! which order; its toolbox is MATLAB's, whose `reshape` runs down the first axis first.
//!
//! # What is lost
//!
//! Neighbouring pixels are neighbours in time or among electrodes by accident of the order alone: a
//! column holds ten moments of one third of the electrodes.

use crate::finite::{check_finite, place, values};
use crate::{Error, Result};
use ndarray::{Array3, Array4, ArrayView3, ArrayView4};
use serde::{Deserialize, Serialize};

/// Values of each electrode that go into the image.
const TIMES: usize = 700;
const SIDE: usize = 70;
const COLOURS: usize = 3;
/// Electrodes along the finger and across it.
const ROWS: usize = 7;
const COLUMNS: usize = 3;

/// In which order values are read from the series and written to the image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// The first axis runs fastest, as in MATLAB.
    #[default]
    Columns,
    /// The last axis runs fastest, as in NumPy.
    Rows,
}

/// `7 x 3 x 700` as `70 x 70 x 3`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ElectrodeImage {
    /// Order of the values.
    pub order: Order,
}

impl ElectrodeImage {
    /// Encodes one recording `[7, 3, at least 700 times]` as `[3 colours, 70, 70]`; values stay as
    /// they are.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for other electrodes or a shorter recording, [`Error::NonFinite`] for a bad
    /// reading.
    pub fn encode(&self, recording: ArrayView3<f32>) -> Result<Array3<f32>> {
        let (rows, columns, times) = recording.dim();
        check_finite(&values(&recording), |at| place([rows, columns, times], at))?;
        if (rows, columns) != (ROWS, COLUMNS) || times < TIMES {
            let expected = format!("[{ROWS}, {COLUMNS}, {TIMES} or more]");
            return Err(Error::Shape { what: "recording", expected, got: recording.shape().to_vec() });
        }
        Ok(Array3::from_shape_fn((COLOURS, SIDE, SIDE), |pixel| recording[self.value_of(pixel)]))
    }

    /// Encodes frames of the electrodes `[at least 700 times, 7, 3]`, row-major, into an image `[3 colours, 70, 70]`.
    ///
    /// # Errors
    ///
    /// Those of [`ElectrodeImage::encode`].
    pub fn encode_frames(&self, shape: [usize; 3], frames: &[f32], image: &mut [f32]) -> Result<()> {
        let [times, rows, columns] = shape;
        if (rows, columns) != (ROWS, COLUMNS) || times < TIMES || frames.len() != times * ROWS * COLUMNS {
            let expected = format!("[{TIMES} or more, {ROWS}, {COLUMNS}]");
            return Err(Error::Shape { what: "recording", expected, got: shape.to_vec() });
        }
        if image.len() != COLOURS * SIDE * SIDE {
            let expected = format!("{COLOURS} x {SIDE} x {SIDE} values");
            return Err(Error::Shape { what: "image", expected, got: vec![image.len()] });
        }
        check_finite(frames, |at| place(shape, at))?;
        for (at, value) in image.iter_mut().enumerate() {
            let (row, column, time) = self.value_of((at / SIDE / SIDE, at / SIDE % SIDE, at % SIDE));
            *value = frames[(time * ROWS + row) * COLUMNS + column];
        }
        Ok(())
    }

    /// Returns row and column of the electrode, and the time, that a pixel shows.
    fn value_of(&self, (colour, row, column): (usize, usize, usize)) -> (usize, usize, usize) {
        match self.order {
            Order::Columns => {
                let at = row + SIDE * (column + SIDE * colour);
                (at % ROWS, at / ROWS % COLUMNS, at / (ROWS * COLUMNS))
            }
            Order::Rows => {
                let at = colour + COLOURS * (column + SIDE * row);
                (at / TIMES / COLUMNS, at / TIMES % COLUMNS, at % TIMES)
            }
        }
    }

    /// Returns the shape of an image: 3 colours, 70, 70.
    pub fn shape(&self) -> [usize; 3] {
        [COLOURS, SIDE, SIDE]
    }

    /// Encodes `[N, 7, 3, times]` as `[N, 3, 70, 70]`.
    ///
    /// # Errors
    ///
    /// Those of [`ElectrodeImage::encode`], naming the sample.
    pub fn encode_batch(&self, recordings: ArrayView4<f32>) -> Result<Array4<f32>> {
        let mut images = Array4::zeros((recordings.dim().0, COLOURS, SIDE, SIDE));
        for (sample, (recording, mut image)) in
            recordings.outer_iter().zip(images.outer_iter_mut()).enumerate()
        {
            image.assign(&self.encode(recording).map_err(|e| e.in_sample(sample))?);
        }
        Ok(images)
    }
}
