//! Random changes of training samples.
//!
//! # Reference
//!
//! Images: Rouhafzay et al. 2021, section 5: random reflection, translation and scaling, amounts not given. TactNet's authors:
//! reflections, ±3 px, ±10° ([`Augment::tactnet`]). Readings: scaling, jitter and time warping of Um et al., ICMI 2017
//! (arXiv 1706.00527), and moves in time; the gain is one factor for all channels.

use crate::augment::readings::ReadingsChange;
use crate::augment::warp::Warp;
use crate::{Error, Layout, Result};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Random changes of a training sample; none by default. The first four keys change images, the others raw readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Augment {
    /// Every other image, at random, has its rows in reverse order.
    pub flip_rows: bool,
    /// Every other image, at random, has its columns in reverse order.
    pub flip_columns: bool,
    /// Largest move along rows and along columns, in taxels (pixels); each uniform on both sides.
    pub shift: f64,
    /// Smallest and largest magnification, uniform; above 0.
    pub scale: [f64; 2],
    /// Largest turn, in degrees; uniform on both sides.
    pub rotate: f64,
    /// Smallest and largest factor of all readings above rest, its logarithm uniform: a touch that is lighter or firmer, a
    /// sensor of another gain.
    #[serde(skip_serializing_if = "is_one")]
    pub gain: [f64; 2],
    /// SD of the white noise on each reading, as a share of the range of the training readings.
    #[serde(skip_serializing_if = "is_zero")]
    pub jitter: f64,
    /// Largest move in time, as a share of the recording; uniform on both sides. The first or last reading fills the gap.
    #[serde(skip_serializing_if = "is_zero")]
    pub time_shift: f64,
    /// Smallest and largest duration, about the middle of the recording, its logarithm uniform: a touch that is faster or slower.
    #[serde(skip_serializing_if = "is_one")]
    pub time_warp: [f64; 2],
}

fn is_one(range: &[f64; 2]) -> bool {
    *range == ONE
}

fn is_zero(amount: &f64) -> bool {
    *amount == 0.0
}

/// The range of a factor that changes nothing.
const ONE: [f64; 2] = [1.0, 1.0];

impl Default for Augment {
    fn default() -> Self {
        Self {
            flip_rows: false,
            flip_columns: false,
            shift: 0.0,
            scale: ONE,
            rotate: 0.0,
            gain: ONE,
            jitter: 0.0,
            time_shift: 0.0,
            time_warp: ONE,
        }
    }
}

/// The key of the random numbers of one image, which depend on nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key {
    /// Seed of the run.
    pub seed: u64,
    /// Repetition of the protocol.
    pub repetition: usize,
    /// Fold of the repetition.
    pub fold: usize,
    /// Epoch of the training.
    pub epoch: usize,
    /// Index of the sample in the data set.
    pub sample: usize,
}

impl Augment {
    /// Returns the changes that the authors of TactNet used on Tekscan images: reflections, ±3 px, ±10°.
    pub fn tactnet() -> Self {
        Self { flip_rows: true, flip_columns: true, shift: 3.0, rotate: 10.0, ..Self::default() }
    }

    /// Rejects amounts that make no sense.
    ///
    /// # Errors
    ///
    /// Names the key, its value and the values that work.
    pub fn check(&self) -> Result<()> {
        let refuse = |key, value: String, expected| Err(Error::Augment { key, value, expected });
        // Written as "not inside" so that NaN fails too.
        if !(0.0..=1e4).contains(&self.shift) {
            return refuse("shift", self.shift.to_string(), "must be in 0..=10000 taxels");
        }
        for (key, [low, high]) in [("scale", self.scale), ("gain", self.gain), ("time_warp", self.time_warp)]
        {
            if !(0.1 <= low && low <= high && high <= 10.0) {
                let expected = "must be [smallest, largest], both in 0.1..=10, as in [0.9, 1.1]";
                return refuse(key, format!("[{low}, {high}]"), expected);
            }
        }
        if !(0.0..=180.0).contains(&self.rotate) {
            return refuse("rotate", self.rotate.to_string(), "must be in 0..=180 degrees");
        }
        if !(0.0..=1.0).contains(&self.jitter) {
            return refuse("jitter", self.jitter.to_string(), "must be a share of the range, in 0..=1");
        }
        if !(0.0..=0.5).contains(&self.time_shift) {
            return refuse(
                "time_shift",
                self.time_shift.to_string(),
                "must be a share of the recording, in 0..=0.5",
            );
        }
        Ok(())
    }

    /// Checks whether images are changed.
    pub fn changes_images(&self) -> bool {
        let of_images = Augment { gain: ONE, jitter: 0.0, time_shift: 0.0, time_warp: ONE, ..*self };
        of_images != Self::default()
    }

    /// Checks whether raw readings are changed.
    pub fn changes_readings(&self) -> bool {
        let Augment { gain, jitter, time_shift, time_warp, .. } = *self;
        let of_readings = Augment { gain, jitter, time_shift, time_warp, ..Self::default() };
        of_readings != Self::default()
    }

    /// Refuses keys of time for a layout without time steps.
    ///
    /// # Errors
    ///
    /// Names the key, its value and the layouts that work.
    pub fn check_layout(&self, layout: Layout) -> Result<()> {
        let expected =
            "moves readings in time: it needs recordings over time, of layout \"series\" or \"fingers\"";
        let value = match (self.time_shift != 0.0, self.time_warp != ONE) {
            (true, _) => Some(("time_shift", self.time_shift.to_string())),
            (_, true) => Some(("time_warp", format!("{:?}", self.time_warp))),
            _ => None,
        };
        match value {
            Some((key, value)) if !matches!(layout, Layout::Series | Layout::Fingers) => {
                Err(Error::Augment { key, value, expected })
            }
            _ => Ok(()),
        }
    }

    /// Draws the changes of the readings of one sample. Switching one kind on does not change the draws of the others.
    pub fn draw_readings(&self, key: &Key) -> ReadingsChange {
        let mut rng = taxel_base::seed::rng(key.seed, &key.purpose("readings"));
        let mut factor = |[low, high]: [f64; 2]| low * (high / low).powf(rng.random::<f64>());
        let (gain, duration) = (factor(self.gain), factor(self.time_warp));
        let shift = self.time_shift * (2.0 * rng.random::<f64>() - 1.0);
        ReadingsChange { gain, duration, shift, jitter: self.jitter, rng }
    }

    /// Draws the changes of one image. Switching one kind on does not change the draws of the others.
    pub fn draw(&self, key: &Key) -> Warp {
        let mut rng = taxel_base::seed::rng(key.seed, &key.purpose("augment"));
        let [low, high] = self.scale;
        let flips: [bool; 2] = rng.random();
        let mut upto = |amount: f64| amount * (2.0 * rng.random::<f64>() - 1.0);
        let (shift, degrees) = ([upto(self.shift), upto(self.shift)], upto(self.rotate));
        Warp {
            flip_rows: self.flip_rows && flips[0],
            flip_columns: self.flip_columns && flips[1],
            shift,
            scale: low + (high - low) * rng.random::<f64>(),
            degrees,
        }
    }
}

impl Key {
    fn purpose(&self, of: &str) -> String {
        let Key { repetition, fold, epoch, sample, .. } = self;
        format!("{of}/{repetition}/{fold}/{epoch}/{sample}")
    }
}
