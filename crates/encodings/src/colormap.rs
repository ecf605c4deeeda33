//! Colour maps: a field of -1..1 as an image of one or three channels.
//!
//! # Reference
//!
//! Section 4.2 of Kaewrakmuk and Srinonchat 2026 turns the GADF into a colour image
//! "using a colormap" and does not name it. The default here is [`Colormap::Jet`], MATLAB's classic
//! one, with the breakpoints that matplotlib gives it; viridis is matplotlib's table (CC0).
//! Both have 256 levels, as in matplotlib, so three channels hold 8 bits of the field, not more.

use std::sync::LazyLock;

use crate::finite::values;
use crate::viridis::VIRIDIS;
use crate::{Error, Result};
use ndarray::{Array2, Array3};
use serde::{Deserialize, Serialize};

/// The levels of [`Colormap::Jet`] and [`Colormap::Viridis`].
const LEVELS: usize = 256;

/// A colour over the unit interval as (position, intensity) corners, linear in between.
type Ramp = &'static [(f64, f64)];

/// Jet's red, green and blue.
const JET: [Ramp; 3] = [
    &[(0.0, 0.0), (0.35, 0.0), (0.66, 1.0), (0.89, 1.0), (1.0, 0.5)],
    &[(0.0, 0.0), (0.125, 0.0), (0.375, 1.0), (0.64, 1.0), (0.91, 0.0), (1.0, 0.0)],
    &[(0.0, 0.5), (0.11, 1.0), (0.34, 1.0), (0.65, 0.0), (1.0, 0.0)],
];

/// How a field becomes an image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Colormap {
    /// One channel, `(v + 1) / 2`: nothing is lost.
    Grey,
    /// Three channels, dark blue over green to dark red. The default; the paper names none.
    #[default]
    Jet,
    /// Three channels, dark purple over green to yellow; lightness grows evenly.
    Viridis,
}

impl Colormap {
    /// Returns the channels of the image: 1 or 3.
    pub fn channels(self) -> usize {
        match self {
            Self::Grey => 1,
            Self::Jet | Self::Viridis => 3,
        }
    }

    /// Colours a field `[rows, columns]` with values -1..1 (clipped) as an image
    /// `[channels, rows, columns]` with values 0..1; the channels are red, green, blue.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`] naming the first pixel that is NaN or infinite.
    pub fn apply(self, field: &Array2<f32>) -> Result<Array3<f32>> {
        if let Some(((row, column), &value)) = field.indexed_iter().find(|(_, v)| !v.is_finite()) {
            return Err(Error::NonFinite { place: format!("pixel [{row}, {column}]"), value });
        }
        let (rows, columns) = field.dim();
        let mut image = vec![0.0; self.channels() * rows * columns];
        self.paint(&values(&field.view()), &mut image, 0);
        #[expect(clippy::expect_used, reason = "made with that many values")]
        Ok(Array3::from_shape_vec((self.channels(), rows, columns), image).expect("as many values"))
    }

    /// Colours some finite pixels of an image, from number `at` of every channel on.
    pub(crate) fn paint(self, field: &[f32], image: &mut [f32], at: usize) {
        let unit = |v: f32| ((f64::from(v) + 1.0) / 2.0).clamp(0.0, 1.0);
        let (plane, pixels) = (image.len() / self.channels(), at..at + field.len());
        let table = match self {
            Self::Grey => {
                return image[pixels].iter_mut().zip(field).for_each(|(to, v)| *to = unit(*v) as f32);
            }
            Self::Viridis => &VIRIDIS,
            Self::Jet => jet(),
        };
        let (red, rest) = image.split_at_mut(plane);
        let (green, blue) = rest.split_at_mut(plane);
        let colours = red[pixels.clone()].iter_mut().zip(&mut green[pixels.clone()]).zip(&mut blue[pixels]);
        for (((red, green), blue), &v) in colours.zip(field) {
            // At most 256, so that the narrower conversion, which is the faster one, loses nothing.
            let level = (unit(v) * LEVELS as f64) as i32 as usize;
            [*red, *green, *blue] = table[level.min(LEVELS - 1)];
        }
    }
}

/// Returns jet's levels.
fn jet() -> &'static [[f32; 3]; LEVELS] {
    static LEVELS_OF_JET: LazyLock<[[f32; 3]; LEVELS]> = LazyLock::new(|| {
        std::array::from_fn(|level| {
            let at = level as f64 / (LEVELS - 1) as f64;
            JET.map(|ramp| interpolate(ramp, at) as f32)
        })
    });
    &LEVELS_OF_JET
}

fn interpolate(ramp: Ramp, at: f64) -> f64 {
    for pair in ramp.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        if at <= x1 {
            return y0 + (at - x0) / (x1 - x0) * (y1 - y0);
        }
    }
    ramp[ramp.len() - 1].1
}
