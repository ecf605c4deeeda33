//! One PNG or JPEG recording.

use crate::options::Limits;
use crate::{Error, Result};
use image::{DynamicImage, GenericImageView, ImageBuffer, ImageDecoder, ImageReader, Luma, Rgb, imageops};
use std::path::Path;

/// A decoded image: `[H, W]` or `[3, H, W]`, before and after resampling.
pub(crate) struct Picture {
    /// Values as stored, for the hash.
    pub raw: Vec<f32>,
    pub shape: Vec<usize>,
    /// Resampled values; the raw ones where no size was asked for.
    pub values: Vec<f32>,
    /// Bits per value.
    pub bits: u8,
}

/// Decodes one image; values keep their stored range (0..255 or 0..65535).
pub(crate) fn read(path: &Path, file: &str, resize: Option<[usize; 2]>, limits: &Limits) -> Result<Picture> {
    let broken = |why: String| Error::Image { file: file.into(), why: why.to_lowercase() };
    let io = |e: std::io::Error| Error::Io { file: file.into(), kind: e.kind() };
    let mut reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(io)?;
    let mut ceiling = image::Limits::default();
    ceiling.max_alloc = Some(limits.max_values.saturating_mul(4));
    reader.limits(ceiling);
    let decoder = reader.into_decoder().map_err(|e| broken(e.to_string()))?;
    let (width, height) = decoder.dimensions();
    let colours = if decoder.color_type().has_color() { 3 } else { 1 };
    if u64::from(width) * u64::from(height) * colours > limits.max_values {
        return Err(Error::TooLarge {
            at: file.into(),
            shape: vec![colours, height.into(), width.into()],
            limit: limits.max_values,
            hint: "save it smaller or raise limits.max-values",
        });
    }
    let image = DynamicImage::from_decoder(decoder).map_err(|e| broken(e.to_string()))?;
    if image.color().has_alpha() && image.pixels().any(|(_, _, pixel)| pixel.0[3] != 255) {
        return Err(Error::Transparent { file: file.into() });
    }
    let bits = 8 * (image.color().bytes_per_pixel() / image.color().channel_count().max(1));
    let (width, height) = (width as usize, height as usize);
    let (raw, shape) = if image.color().has_color() {
        let values = match bits {
            8 => widen(image.into_rgb8().into_raw()),
            _ => widen(image.into_rgb16().into_raw()),
        };
        (values, vec![3, height, width])
    } else {
        let values = match bits {
            8 => widen(image.into_luma8().into_raw()),
            _ => widen(image.into_luma16().into_raw()),
        };
        (values, vec![height, width])
    };
    let rank = shape.len();
    let Some(size) = resize else {
        let raw = planes(&raw, rank);
        let values = raw.clone();
        return Ok(Picture { raw, shape, values, bits });
    };
    let resized = resample(&raw, [height, width], size, rank == 3, bits)
        .ok_or_else(|| broken("its size does not match its pixels".into()))?;
    let mut new_shape = shape;
    new_shape[rank - 2..].copy_from_slice(&size);
    Ok(Picture { raw: planes(&raw, rank), values: planes(&resized, rank), shape: new_shape, bits })
}

/// Pixels resampled from one `[height, width]` to another by a triangle filter; none where there are not
/// as many as `from` says.
fn resample(raw: &[f32], from: [usize; 2], to: [usize; 2], colour: bool, bits: u8) -> Option<Vec<f32>> {
    let [height, width] = from.map(|side| side as u32);
    let [new_height, new_width] = to.map(|side| side as u32);
    let filter = imageops::FilterType::Triangle;
    // The image crate clamps f32 pixels to 0..1.
    let white = if bits == 8 { 255.0 } else { 65535.0 };
    let unit: Vec<f32> = raw.iter().map(|value| value / white).collect();
    let mut resized = if colour {
        let buffer = ImageBuffer::<Rgb<f32>, _>::from_raw(width, height, unit)?;
        imageops::resize(&buffer, new_width, new_height, filter).into_raw()
    } else {
        let buffer = ImageBuffer::<Luma<f32>, _>::from_raw(width, height, unit)?;
        imageops::resize(&buffer, new_width, new_height, filter).into_raw()
    };
    resized.iter_mut().for_each(|value| *value *= white);
    Some(resized)
}

fn widen<T: Into<f32>>(values: Vec<T>) -> Vec<f32> {
    values.into_iter().map(Into::into).collect()
}

/// Pixel after pixel to one plane per colour.
fn planes(values: &[f32], rank: usize) -> Vec<f32> {
    if rank == 2 {
        return values.to_vec();
    }
    (0..3).flat_map(|colour| values.iter().skip(colour).step_by(3).copied()).collect()
}
