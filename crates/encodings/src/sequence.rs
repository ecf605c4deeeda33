//! Sequences of pressure frames: 3D tactile tensors, and the single frames that 2D methods read.
//!
//! # Reference
//!
//! Pastor et al. 2019 (Robotic palpation), section 3.3: the frames of a squeeze are stacked along a third axis
//! of force or time. Section 4.2: 2D methods get the single frames of the same grasps.

use crate::finite::{check_finite, place, values};
use crate::{Error, Result};
use ndarray::{Array4, ArrayView3, ArrayView4, Axis};
use serde::{Deserialize, Serialize};

/// `[frames, rows, columns]` as `[1, rows, columns, frames]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TactileTensor {
    /// Frames of the tensor: the recording's own are interpolated linearly, first on first and last
    /// on last. Default: as recorded.
    pub frames: Option<usize>,
}

impl TactileTensor {
    /// Encodes one recording `[frames, rows, columns]` as `[1, rows, columns, frames]`, the papers'
    /// order of axes after the channel.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for no frames, or one frame to be resampled to more; [`Error::Size`] for zero
    /// frames asked for; [`Error::NonFinite`] for a bad reading.
    pub fn encode(&self, recording: ArrayView3<f32>) -> Result<Array4<f32>> {
        let (recorded, rows, columns) = recording.dim();
        let frames = self.frames.unwrap_or(recorded);
        let mut tensor = vec![0.0; rows * columns * frames];
        self.encode_into([recorded, rows, columns], &values(&recording), &mut tensor)?;
        #[expect(clippy::expect_used, reason = "made with that many values")]
        Ok(Array4::from_shape_vec((1, rows, columns, frames), tensor).expect("as many values"))
    }

    /// Does [`TactileTensor::encode`] for the values of one recording of `shape` frames × rows × columns into `tensor`;
    /// nothing is allocated.
    ///
    /// # Errors
    ///
    /// Those of [`TactileTensor::encode`], and [`Error::Shape`] for values or a tensor of another length.
    pub fn encode_into(&self, shape: [usize; 3], recording: &[f32], tensor: &mut [f32]) -> Result<()> {
        let [recorded, rows, columns] = shape;
        let (pixels, frames) = (rows * columns, self.frames.unwrap_or(recorded));
        let refuse = |expected: String, got: &[usize]| {
            Err(Error::Shape { what: "recording", expected, got: got.to_vec() })
        };
        if recording.len() != recorded * pixels || tensor.len() != pixels * frames {
            let expected = format!("{shape:?} readings, and room for {frames} frames of them");
            return refuse(expected, &[recording.len(), tensor.len()]);
        }
        check_finite(recording, |at| place(shape, at))?;
        if frames == 0 {
            return Err(Error::Size { size: 0, least: 1, why: " frame" });
        }
        if recorded == 0 || (recorded == 1 && frames > 1) {
            let least = if frames > 1 { 2 } else { 1 };
            return refuse(format!("at least {least} frames to make {frames} of"), &shape);
        }
        for t in 0..frames {
            let (before, after, share) = neighbours(t, frames, recorded);
            let frame = |t: usize| &recording[t * pixels..(t + 1) * pixels];
            let pairs = frame(before).iter().zip(frame(after));
            for (value, (&a, &b)) in tensor[t..].iter_mut().step_by(frames).zip(pairs) {
                *value = (f64::from(a) + share * f64::from(b - a)) as f32;
            }
        }
        Ok(())
    }
}

/// Returns the recorded frames around frame `t` of `frames`, and how far it is from the first to the second.
fn neighbours(t: usize, frames: usize, recorded: usize) -> (usize, usize, f64) {
    if frames == recorded {
        return (t, t, 0.0);
    }
    let at = match frames {
        1 => 0.0,
        _ => t as f64 * (recorded - 1) as f64 / (frames - 1) as f64,
    };
    let before = (at.floor() as usize).min(recorded - 1);
    (before, (before + 1).min(recorded - 1), at - before as f64)
}

/// Which frame of a recording a 2D method reads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OneFrame {
    /// The first of those with the largest sum: full force.
    #[default]
    Peak,
    /// The frame of this index, from 0.
    At(usize),
}

impl OneFrame {
    /// Picks one frame of `[frames, rows, columns]`, as index.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for a recording without that frame, [`Error::NonFinite`] for a bad reading.
    pub fn pick(self, recording: ArrayView3<f32>) -> Result<usize> {
        self.pick_of(recording.dim().into(), &values(&recording))
    }

    /// Does [`OneFrame::pick`] for the values of one recording of `shape` frames × rows × columns;
    /// nothing is allocated.
    ///
    /// # Errors
    ///
    /// Those of [`OneFrame::pick`].
    pub fn pick_of(self, shape: [usize; 3], recording: &[f32]) -> Result<usize> {
        check_finite(recording, |at| place(shape, at))?;
        let [frames, rows, columns] = shape;
        let sums = recording.chunks_exact((rows * columns).max(1));
        let sums = sums.map(|frame| frame.iter().map(|&v| f64::from(v)).sum::<f64>());
        let picked = match self {
            Self::At(index) => (index < frames).then_some(index),
            Self::Peak => sums
                .enumerate()
                .fold(None, |best: Option<(usize, f64)>, (t, sum)| match best {
                    Some((_, highest)) if highest >= sum => best,
                    _ => Some((t, sum)),
                })
                .map(|(t, _)| t),
        };
        picked.ok_or_else(|| {
            let expected = match self {
                Self::At(index) => format!("at least {} frames", index + 1),
                Self::Peak => "at least one frame".into(),
            };
            Error::Shape { what: "recording", expected, got: shape.to_vec() }
        })
    }

    /// Takes one frame of each recording: `[N, frames, rows, columns]` as `[N, 1, rows, columns]`.
    ///
    /// # Errors
    ///
    /// Those of [`OneFrame::pick`], naming the sample.
    pub fn encode_batch(self, recordings: ArrayView4<f32>) -> Result<Array4<f32>> {
        let (samples, _, rows, columns) = recordings.dim();
        let mut images = Array4::zeros((samples, 1, rows, columns));
        for (sample, (recording, mut image)) in
            recordings.outer_iter().zip(images.outer_iter_mut()).enumerate()
        {
            let frame = self.pick(recording).map_err(|e| e.in_sample(sample))?;
            image.index_axis_mut(Axis(0), 0).assign(&recording.index_axis(Axis(0), frame));
        }
        Ok(images)
    }
}

/// Makes every frame an image of its own: `[N, frames, rows, columns]` as `[N * frames, 1, rows, columns]`, sample
/// after sample. Image i belongs to sample `i / frames`: all of a sample must stay on one side of a split.
pub fn all_frames(recordings: ArrayView4<f32>) -> Array4<f32> {
    let (samples, frames, rows, columns) = recordings.dim();
    let values: Vec<f32> = recordings.iter().copied().collect();
    #[expect(clippy::expect_used, reason = "the number of values is that of the recordings")]
    let images = Array4::from_shape_vec((samples * frames, 1, rows, columns), values)
        .expect("as many values as the recordings have");
    images
}
