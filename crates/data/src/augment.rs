//! Reflects, moves, scales and turns training images at random.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021, section 5: random reflection, translation and scaling,
//! amounts not given. TactNet's authors: reflections, ±3 px, ±10° ([`Augment::tactnet`]). Bilinear
//! sampling as `scipy.ndimage.affine_transform` does it (`order=1, mode="grid-constant"`).

use crate::{Error, Result};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Random changes of a training image; none by default.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
}

impl Default for Augment {
    fn default() -> Self {
        Self { flip_rows: false, flip_columns: false, shift: 0.0, scale: [1.0, 1.0], rotate: 0.0 }
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

/// The changes of one image: reflect, scale, turn about the middle, then move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warp {
    /// Rows in reverse order.
    pub flip_rows: bool,
    /// Columns in reverse order.
    pub flip_columns: bool,
    /// Taxels down and to the right.
    pub shift: [f64; 2],
    /// Magnification.
    pub scale: f64,
    /// Turn in degrees, from the rows' axis towards the columns'.
    pub degrees: f64,
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
        let [low, high] = self.scale;
        if !(0.1 <= low && low <= high && high <= 10.0) {
            let expected = "must be [smallest, largest], both in 0.1..=10, as in [0.9, 1.1]";
            return refuse("scale", format!("[{low}, {high}]"), expected);
        }
        if !(0.0..=180.0).contains(&self.rotate) {
            return refuse("rotate", self.rotate.to_string(), "must be in 0..=180 degrees");
        }
        Ok(())
    }

    /// Draws the changes of one image. Switching one kind on does not change the draws of the others.
    pub fn draw(&self, key: &Key) -> Warp {
        let Key { seed, repetition, fold, epoch, sample } = key;
        let mut rng = taxel_base::seed::rng(*seed, &format!("augment/{repetition}/{fold}/{epoch}/{sample}"));
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

impl Warp {
    /// Warps an image `[channels, rows, columns, frames]` in C order in place; all channels and
    /// frames alike, 1 frame for a plain image. Outside of the image lies `outside`: the value of
    /// a taxel at rest, as the image holds it.
    ///
    /// # Panics
    ///
    /// If `image` does not have as many values as `shape` says.
    pub fn apply(&self, image: &mut [f32], shape: [usize; 4], outside: f32) {
        let [_, rows, columns, frames] = shape;
        assert_eq!(image.len(), shape.iter().product::<usize>(), "an image of shape {shape:?}");
        let clean = image.to_vec();
        let turn = self.degrees.to_radians().sin_cos();
        let plane = rows * columns * frames;
        for (at, pixel) in image.chunks_exact_mut(frames).enumerate() {
            let (channel, at) = (at / (rows * columns), at % (rows * columns));
            let source = &clean[channel * plane..][..plane];
            let from = self.source([at / columns, at % columns], [rows, columns], turn);
            pixel.fill(0.0);
            for ([row, column], weight) in corners(from) {
                // A weight of zero would make NaN of an infinity.
                if weight == 0.0 {
                    continue;
                }
                let inside = (0..rows as isize).contains(&row) && (0..columns as isize).contains(&column);
                if inside {
                    let start = (row as usize * columns + column as usize) * frames;
                    pixel.iter_mut().zip(&source[start..]).for_each(|(sum, v)| *sum += weight * v);
                } else {
                    pixel.iter_mut().for_each(|sum| *sum += weight * outside);
                }
            }
        }
    }

    /// Finds the place that the pixel at `row`, `column` comes from, with the sine and cosine of the turn.
    fn source(
        &self,
        [row, column]: [usize; 2],
        [rows, columns]: [usize; 2],
        (sin, cos): (f64, f64),
    ) -> [f64; 2] {
        let middle = [(rows as f64 - 1.0) / 2.0, (columns as f64 - 1.0) / 2.0];
        let down = row as f64 - middle[0] - self.shift[0];
        let right = column as f64 - middle[1] - self.shift[1];
        let sign = |flip: bool| if flip { -1.0 } else { 1.0 };
        [
            middle[0] + sign(self.flip_rows) * (cos * down + sin * right) / self.scale,
            middle[1] + sign(self.flip_columns) * (cos * right - sin * down) / self.scale,
        ]
    }
}

/// Returns the four pixels around a point with their bilinear weights.
fn corners([row, column]: [f64; 2]) -> [([isize; 2], f32); 4] {
    let (top, left) = (row.floor(), column.floor());
    let (below, beside) = (row - top, column - left);
    let (top, left) = (top as isize, left as isize);
    [
        ([top, left], ((1.0 - below) * (1.0 - beside)) as f32),
        ([top, left + 1], ((1.0 - below) * beside) as f32),
        ([top + 1, left], (below * (1.0 - beside)) as f32),
        ([top + 1, left + 1], (below * beside) as f32),
    ]
}
