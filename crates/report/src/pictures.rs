//! Readings and encodings of examples as pictures.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde::{Deserialize, Serialize};

use crate::axes::{AxisScale, PlotFrame, widened};
use crate::canvas::{Canvas, Stroke};
use crate::error::{Error, Result};
use crate::numbers::tick;
use crate::palette::{Ink, Paint};

/// How [`ArrayPicture::values`] are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PictureKind {
    /// `[C, T]`: one line per channel.
    Lines,
    /// `[H, W]`: one grey or coloured image; scaled from its least to its largest value.
    Grey,
    /// `[3, H, W]`: red, green, blue.
    Colour,
    /// `[K, H, W]`: some frames of a sequence, from early to late.
    Frames,
}

/// An array to be drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArrayPicture {
    /// `reading`, or the name of an input.
    pub name: String,
    /// How it is drawn.
    pub kind: PictureKind,
    /// As `kind` says.
    pub shape: Vec<usize>,
    /// Row-major.
    pub values: Vec<f32>,
}

const SIZE: (f64, f64) = (380.0, 210.0);

/// A picture ready to be shown.
pub enum Shown {
    /// Lines: a drawing.
    Drawing(Box<Canvas>),
    /// Pixels: width, height, PNG.
    Pixels(usize, usize, Vec<u8>),
}

/// Draws `picture`.
///
/// # Errors
/// An array that is not what its kind says.
pub fn show(picture: &ArrayPicture, paint: Paint) -> Result<Shown> {
    let values = &picture.values;
    let refuse = |reason: String| Error::Picture { name: picture.name.clone(), reason };
    if values.is_empty() || values.len() != picture.shape.iter().product::<usize>() {
        return Err(refuse(format!("{} values of shape {:?}", values.len(), picture.shape)));
    }
    let pixels = |colours: &[[u8; 3]], h, w| pixels(colours, h, w).map_err(&refuse);
    match (picture.kind, picture.shape.as_slice()) {
        (PictureKind::Lines, [_, ticks]) => Ok(Shown::Drawing(Box::new(lines(values, *ticks, paint)))),
        (PictureKind::Grey, [h, w]) => pixels(&grey(values), *h, *w),
        (PictureKind::Colour, [3, h, w]) => pixels(&interleaved(values, h * w), *h, *w),
        (PictureKind::Frames, [k, h, w]) => pixels(&frames(values, *k, *h, *w), *h, k * (w + 1) - 1),
        (kind, shape) => Err(refuse(format!("shape {shape:?} is none of {kind:?}"))),
    }
}

/// Draws one line for each `ticks` values.
fn lines(values: &[f32], ticks: usize, paint: Paint) -> Canvas {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1, paint);
    let values: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
    let limits = (f64::NEG_INFINITY, f64::INFINITY);
    let last = ticks.saturating_sub(1).max(1) as f64;
    let frame = PlotFrame {
        x: AxisScale::linear((0.0, last), (54.0, SIZE.0 - 10.0)),
        y: AxisScale::linear(widened(&values, limits), (SIZE.1 - 26.0, 8.0)),
    };
    frame.draw_y(&mut canvas, tick);
    frame.draw_x(&mut canvas, &frame.x.ticks(), tick);
    for (channel, series) in values.chunks_exact(ticks).enumerate() {
        // What is not finite is no place; the line goes on behind it.
        let finite = series.iter().enumerate().filter(|(_, v)| v.is_finite());
        let line = finite.map(|(t, v)| frame.at(t as f64, *v)).collect();
        let stroke = Stroke::of(Ink::Series(channel), 1.5);
        canvas.hover(&format!("channel {channel}"), |canvas| canvas.path(line, stroke));
    }
    canvas
}

/// Scales values to 0..=255, from the least to the largest.
fn scaled(values: &[f32]) -> Vec<u8> {
    let ends = values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let width = if ends.1 > ends.0 { ends.1 - ends.0 } else { 1.0 };
    values.iter().map(|v| (255.0 * (v - ends.0) / width).round() as u8).collect()
}

fn grey(values: &[f32]) -> Vec<[u8; 3]> {
    scaled(values).into_iter().map(|v| [v; 3]).collect()
}

/// Turns `[3, H, W]` into one colour per pixel.
fn interleaved(values: &[f32], area: usize) -> Vec<[u8; 3]> {
    let all = scaled(values);
    (0..area).map(|i| [all[i], all[area + i], all[2 * area + i]]).collect()
}

/// Puts frames `[K, H, W]` side by side, one pixel apart.
fn frames(values: &[f32], k: usize, h: usize, w: usize) -> Vec<[u8; 3]> {
    let width = k * (w + 1) - 1;
    let mut sheet = vec![[128u8; 3]; h * width];
    for (frame, pixels) in scaled(values).chunks_exact(h * w).enumerate() {
        for (i, v) in pixels.iter().enumerate() {
            sheet[(i / w) * width + frame * (w + 1) + i % w] = [*v; 3];
        }
    }
    sheet
}

/// Encodes one colour per pixel as PNG.
fn pixels(colours: &[[u8; 3]], h: usize, w: usize) -> std::result::Result<Shown, String> {
    let side = |length: usize| u32::try_from(length).map_err(|e| e.to_string());
    let mut png = vec![];
    PngEncoder::new(&mut png)
        .write_image(colours.as_flattened(), side(w)?, side(h)?, ExtendedColorType::Rgb8)
        .map_err(|e| e.to_string())?;
    Ok(Shown::Pixels(w, h, png))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn pixels_keep_their_places() {
        let picture = |kind, shape: &[usize], values: &[f32]| ArrayPicture {
            name: "x".into(),
            kind,
            shape: shape.to_vec(),
            values: values.to_vec(),
        };
        let decode = |picture: &ArrayPicture| match show(picture, Paint::Print) {
            Ok(Shown::Pixels(_, _, png)) => image::load_from_memory(&png).unwrap().to_rgb8(),
            _ => panic!("no pixels"),
        };
        let grey = decode(&picture(PictureKind::Grey, &[1, 3], &[-1.0, 0.0, 1.0]));
        assert_eq!((grey.get_pixel(0, 0).0, grey.get_pixel(2, 0).0), ([0; 3], [255; 3]));
        let red = decode(&picture(PictureKind::Colour, &[3, 1, 2], &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]));
        assert_eq!((red.get_pixel(0, 0).0, red.get_pixel(1, 0).0), ([255, 0, 0], [0, 0, 255]));
        let strip = decode(&picture(PictureKind::Frames, &[2, 2, 1], &[0.0, 1.0, 2.0, 4.0]));
        assert_eq!(strip.dimensions(), (3, 2));
        assert_eq!((strip.get_pixel(0, 1).0[0], strip.get_pixel(2, 1).0[0]), (64, 255));
        for (kind, shape, values) in [
            (PictureKind::Grey, &[2, 2][..], &[0.0][..]),
            (PictureKind::Colour, &[2, 1, 1], &[0.0, 1.0]),
            (PictureKind::Lines, &[0, 2], &[]),
        ] {
            let error = show(&picture(kind, shape, values), Paint::Print).err().unwrap().to_string();
            assert!(error.starts_with("picture `x`: ") && error.contains("shape"), "{error}");
        }
    }
}
