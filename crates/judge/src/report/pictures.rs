//! Readings and encodings of examples as pictures.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use super::axes::{Frame, Scale, widened};
use super::canvas::{Canvas, Stroke};
use super::numbers::tick;
use super::palette::{Ink, Paint};
use crate::judgement::{Picture, PictureKind};

const SIZE: (f64, f64) = (380.0, 210.0);

/// A picture ready to be shown.
pub(super) enum Shown {
    /// Lines: a drawing.
    Drawing(Box<Canvas>),
    /// Pixels: width, height, PNG.
    Pixels(usize, usize, Vec<u8>),
}

/// Draws `picture`; none for an array that is not what its kind says.
pub(super) fn show(picture: &Picture, paint: Paint) -> Option<Shown> {
    match (picture.kind, picture.shape.as_slice()) {
        (PictureKind::Lines, [channels, ticks]) => {
            lines(picture, *channels, *ticks, paint).map(|drawn| Shown::Drawing(Box::new(drawn)))
        }
        (PictureKind::Grey, [h, w]) => pixels(&grey(&picture.values), *h, *w),
        (PictureKind::Colour, [3, h, w]) => pixels(&interleaved(&picture.values, h * w), *h, *w),
        (PictureKind::Frames, [k, h, w]) => frames(&picture.values, *k, *h, *w),
        _ => None,
    }
}

fn lines(picture: &Picture, channels: usize, ticks: usize, paint: Paint) -> Option<Canvas> {
    if ticks == 0 || picture.values.len() != channels * ticks {
        return None;
    }
    let mut canvas = Canvas::new(SIZE.0, SIZE.1, paint);
    let values: Vec<f64> = picture.values.iter().map(|v| f64::from(*v)).collect();
    let limits = (f64::NEG_INFINITY, f64::INFINITY);
    let last = ticks.saturating_sub(1).max(1) as f64;
    let frame = Frame {
        x: Scale::linear((0.0, last), (54.0, SIZE.0 - 10.0)),
        y: Scale::linear(widened(&values, limits), (SIZE.1 - 26.0, 8.0)),
    };
    frame.draw_y(&mut canvas, tick);
    frame.draw_x(&mut canvas, &frame.x.ticks(), tick);
    for (channel, own) in values.chunks_exact(ticks).enumerate() {
        let line = own.iter().enumerate().map(|(t, v)| frame.at(t as f64, *v)).collect();
        let stroke = Stroke::of(Ink::Series(channel), 1.5);
        canvas.hover(&format!("channel {channel}"), |canvas| canvas.path(line, stroke));
    }
    Some(canvas)
}

/// To 0..=255, from the least to the largest value.
fn scaled(values: &[f32]) -> Vec<u8> {
    let ends = values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let width = if ends.1 > ends.0 { ends.1 - ends.0 } else { 1.0 };
    values.iter().map(|v| (255.0 * (v - ends.0) / width).round() as u8).collect()
}

fn grey(values: &[f32]) -> Vec<[u8; 3]> {
    scaled(values).into_iter().map(|v| [v; 3]).collect()
}

/// `[3, H, W]` to one colour per pixel.
fn interleaved(values: &[f32], area: usize) -> Vec<[u8; 3]> {
    let all = scaled(values);
    let at = |channel: usize, i: usize| all.get(channel * area + i).copied().unwrap_or(0);
    (0..area).map(|i| [at(0, i), at(1, i), at(2, i)]).collect()
}

/// Frames side by side, one pixel apart.
fn frames(values: &[f32], k: usize, h: usize, w: usize) -> Option<Shown> {
    if values.len() != k * h * w {
        return None;
    }
    let all = scaled(values);
    let width = k * (w + 1) - usize::from(k > 0);
    let mut sheet = vec![[128u8; 3]; h * width];
    for (frame, own) in all.chunks_exact((h * w).max(1)).enumerate() {
        for (i, v) in own.iter().enumerate() {
            sheet[(i / w) * width + frame * (w + 1) + i % w] = [*v; 3];
        }
    }
    pixels(&sheet, h, width)
}

fn pixels(colours: &[[u8; 3]], h: usize, w: usize) -> Option<Shown> {
    if h == 0 || w == 0 || colours.len() != h * w {
        return None;
    }
    let mut png = vec![];
    let (width, height) = (u32::try_from(w).ok()?, u32::try_from(h).ok()?);
    let written =
        PngEncoder::new(&mut png).write_image(colours.as_flattened(), width, height, ExtendedColorType::Rgb8);
    written.is_ok().then_some(Shown::Pixels(w, h, png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_keep_their_places() {
        let picture = |kind, shape: &[usize], values: &[f32]| Picture {
            name: "x".into(),
            kind,
            shape: shape.to_vec(),
            values: values.to_vec(),
        };
        let decode = |picture: &Picture| match show(picture, Paint::Print) {
            Some(Shown::Pixels(_, _, png)) => image::load_from_memory(&png).unwrap().to_rgb8(),
            _ => panic!("no pixels"),
        };
        let grey = decode(&picture(PictureKind::Grey, &[1, 3], &[-1.0, 0.0, 1.0]));
        assert_eq!((grey.get_pixel(0, 0).0, grey.get_pixel(2, 0).0), ([0; 3], [255; 3]));
        let red = decode(&picture(PictureKind::Colour, &[3, 1, 2], &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]));
        assert_eq!((red.get_pixel(0, 0).0, red.get_pixel(1, 0).0), ([255, 0, 0], [0, 0, 255]));
        let strip = decode(&picture(PictureKind::Frames, &[2, 2, 1], &[0.0, 1.0, 2.0, 4.0]));
        assert_eq!(strip.dimensions(), (3, 2));
        assert_eq!((strip.get_pixel(0, 1).0[0], strip.get_pixel(2, 1).0[0]), (64, 255));
        assert!(show(&picture(PictureKind::Grey, &[2, 2], &[0.0]), Paint::Print).is_none());
    }
}
