//! Images at another size, and grey images for networks that read colours.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021 (Transfer of learning from vision to touch), sections 3 and 5: tactile images are resized
//! to the input of the network, grey goes into the red channel and green and blue are zero. Numbers are
//! those of PyTorch's `interpolate`, modes `bilinear` (`align_corners = False`, no antialiasing) and `area`.

use crate::finite::{check_finite, place, values};
use crate::{Error, Result};
use ndarray::{Array3, Array4, ArrayView3, ArrayView4, Axis};
use serde::{Deserialize, Serialize};

/// How pixels of the new size come from the old.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// Weighted mean of the four nearest pixels: smooth when enlarging; skips pixels when halving or more.
    #[default]
    Bilinear,
    /// Mean of all pixels under the new one: keeps the sum of pressures when shrinking; blocks when
    /// enlarging.
    Area,
}

/// A new size for images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resize {
    /// Rows of the new image, at least 1.
    pub height: usize,
    /// Columns of the new image, at least 1.
    pub width: usize,
    /// How pixels are mixed.
    #[serde(default)]
    pub filter: Filter,
}

/// Old pixels and their weights, for each new pixel along one axis.
type Mix = Vec<Vec<(usize, f32)>>;

impl Resize {
    /// Resizes one image `[channels, rows, columns]`.
    ///
    /// # Errors
    ///
    /// [`Error::Size`] for a size of 0, [`Error::Shape`] for an image without pixels,
    /// [`Error::NonFinite`] for a bad pixel.
    pub fn encode(&self, image: ArrayView3<f32>) -> Result<Array3<f32>> {
        let (channels, rows, columns) = image.dim();
        let image = values(&image);
        check_finite(&image, |at| place([channels, rows, columns], at))?;
        let mut resized = vec![0.0; channels * self.height * self.width];
        self.plan([channels, rows, columns])?.encode(&image, &mut resized)?;
        #[expect(clippy::expect_used, reason = "made with that many values")]
        Ok(Array3::from_shape_vec((channels, self.height, self.width), resized).expect("as many values"))
    }

    /// Plans the new size of images of `shape` channels × rows × columns, ready to be made again and again.
    ///
    /// # Errors
    ///
    /// [`Error::Size`] for a size of 0, [`Error::Shape`] for an image without pixels.
    pub fn plan(&self, shape: [usize; 3]) -> Result<ResizePlan> {
        let [channels, rows, columns] = shape;
        if rows == 0 || columns == 0 {
            let expected = "at least one pixel".into();
            return Err(Error::Shape { what: "image", expected, got: shape.to_vec() });
        }
        let (down, across) = (self.mix(rows, self.height)?, self.mix(columns, self.width)?);
        Ok(ResizePlan { channels, rows, columns, down, across })
    }

    /// Resizes images `[N, channels, rows, columns]`.
    ///
    /// # Errors
    ///
    /// Those of [`Resize::encode`], naming the sample.
    pub fn encode_batch(&self, images: ArrayView4<f32>) -> Result<Array4<f32>> {
        let mut resized = Array4::zeros((images.dim().0, images.dim().1, self.height, self.width));
        for (sample, (image, mut into)) in images.outer_iter().zip(resized.outer_iter_mut()).enumerate() {
            into.assign(&self.encode(image).map_err(|e| e.in_sample(sample))?);
        }
        Ok(resized)
    }

    fn mix(&self, old: usize, new: usize) -> Result<Mix> {
        if new == 0 {
            return Err(Error::Size { size: 0, least: 1, why: " row and column" });
        }
        Ok((0..new)
            .map(|i| match self.filter {
                Filter::Area => {
                    let (from, to) = (i * old / new, ((i + 1) * old).div_ceil(new));
                    (from..to).map(|at| (at, 1.0 / (to - from) as f32)).collect()
                }
                Filter::Bilinear => {
                    // Pixel centres lie at halves; outside the first and last, they hold.
                    let at = ((i as f32 + 0.5) * old as f32 / new as f32 - 0.5).max(0.0);
                    let before = (at as usize).min(old - 1);
                    let after = (before + 1).min(old - 1);
                    vec![(before, 1.0 - (at - before as f32)), (after, at - before as f32)]
                }
            })
            .collect())
    }
}

/// A [`Resize`] of images of one shape: nothing is planned or allocated for another one.
#[derive(Debug, Clone)]
pub struct ResizePlan {
    channels: usize,
    rows: usize,
    columns: usize,
    down: Mix,
    across: Mix,
}

impl ResizePlan {
    /// Resizes one image, row-major, into `resized`, bit for bit as [`Resize::encode`] does.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for other lengths, [`Error::NonFinite`] for a bad pixel.
    pub fn encode(&self, image: &[f32], resized: &mut [f32]) -> Result<()> {
        let ResizePlan { channels, rows, columns, down, across } = self;
        let pixels = down.len() * across.len();
        if image.len() != channels * rows * columns || resized.len() != channels * pixels {
            let expected =
                format!("{channels} x {rows} x {columns} pixels, and room for {pixels} of each channel");
            return Err(Error::Shape { what: "image", expected, got: vec![image.len(), resized.len()] });
        }
        check_finite(image, |at| place([*channels, *rows, *columns], at))?;
        let planes = image.chunks_exact(rows * columns).zip(resized.chunks_exact_mut(pixels));
        for (image, resized) in planes {
            for (ys, row) in down.iter().zip(resized.chunks_exact_mut(across.len())) {
                for (xs, value) in across.iter().zip(row) {
                    *value = 0.0;
                    for &(y, wy) in ys {
                        let pixels = &image[y * columns..(y + 1) * columns];
                        *value += wy * xs.iter().map(|&(x, wx)| wx * pixels[x]).sum::<f32>();
                    }
                }
            }
        }
        Ok(())
    }
}

/// Turns grey images `[N, rows, columns]` into `[N, 3, rows, columns]`: grey in red, zeros in green and blue.
pub fn red_channel(images: ArrayView3<f32>) -> Array4<f32> {
    let (samples, rows, columns) = images.dim();
    let mut coloured = Array4::zeros((samples, 3, rows, columns));
    coloured.index_axis_mut(Axis(1), 0).assign(&images);
    coloured
}
