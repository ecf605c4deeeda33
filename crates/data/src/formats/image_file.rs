//! Reads one PNG or JPEG recording.

use crate::formats::names::IMAGE;
use crate::options::{Limits, ReadOptions};
use crate::reader::{FileFormat, Format, Sample};
use crate::{Error, Result};
use image::metadata::Orientation;
use image::{
    DynamicImage, GenericImageView, ImageDecoder, ImageFormat, ImageReader, Luma, Pixel, Rgb, imageops,
};
#[cfg(feature = "mcap")]
use std::io::Cursor;
use std::io::{BufRead, Seek};
use std::marker::PhantomData;
use std::path::Path;
use taxel_base::Layout;

/// The type of values, before their bits.
const DTYPE: &str = "png/jpeg u";

/// Reads PNG and JPEG files of which each is one recording.
pub(crate) struct ImageFile;

impl FileFormat for ImageFile {
    fn name(&self) -> &'static str {
        "an image"
    }

    fn format(&self) -> &'static Format {
        &Format {
            name: "image",
            endings: IMAGE,
            holds: "one recording, grey or in colour",
            becomes: "[H, W] or [3, H, W], at the size of `data.resize`",
        }
    }

    fn layout(&self, rank: usize) -> Option<Layout> {
        Some(if rank == 3 { Layout::Colour } else { Layout::Image })
    }

    fn hint(&self) -> &'static str {
        ": set resize = [height, width], or use grey or colour throughout"
    }

    fn depth(&self, dtype: &str) -> Option<u8> {
        dtype.strip_prefix(DTYPE)?.parse().ok()
    }

    fn takes_option(&self, option: &str) -> bool {
        option == "resize"
    }

    /// Reads the head of the file; an image that is too large to decode is refused.
    fn shape(&self, path: &Path, options: &ReadOptions) -> Result<Option<Vec<usize>>> {
        let file = path.display().to_string();
        let mut decoder = open(path, &file, &options.limits)?;
        let stored = stored_shape(&mut decoder, &file, options)?;
        Ok(Some(resized(&stored, options.resize)))
    }

    /// Decodes one image: `[H, W]` or `[3, H, W]` in its stored range, 0..255 or 0..65535, resampled to the size where one
    /// is given.
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Sample> {
        let (file, resize) = (path.display().to_string(), options.resize);
        let mut decoder = open(path, &file, &options.limits)?;
        let stored = stored_shape(&mut decoder, &file, options)?;
        let upright = upright(decoder).map_err(|why| Error::file(&file, why))?;
        let (image, bits) = (upright.image, upright.bits);
        let values = match (stored.len(), bits) {
            (3, 8) => planes::<Rgb<f32>, u8>(&image.into_rgb8(), &stored, resize, 255.0),
            (3, _) => planes::<Rgb<f32>, u16>(&image.into_rgb16(), &stored, resize, 65535.0),
            (_, 8) => planes::<Luma<f32>, u8>(&image.into_luma8(), &stored, resize, 255.0),
            (_, _) => planes::<Luma<f32>, u16>(&image.into_luma16(), &stored, resize, 65535.0),
        };
        let (shape, dtype) = (resized(&stored, resize), format!("{DTYPE}{bits}"));
        Ok(Sample { shape, values, dtype, is_turned: upright.is_turned })
    }
}

fn broken(why: &str) -> String {
    format!("is not readable as PNG or JPEG ({})", why.to_lowercase())
}

/// Reads the head of the file.
fn open(path: &Path, file: &str, limits: &Limits) -> Result<impl ImageDecoder> {
    let io = Error::io(path);
    let reader = ImageReader::open(path).map_err(&io)?;
    let bytes = path.metadata().map_err(io)?.len();
    head(reader, bytes, limits.max_values).map_err(|why| Error::file(file, why))
}

/// Reads the head of so many bytes, of an image of so many `values` at most.
fn head<'r, R: BufRead + Seek + 'r>(
    reader: ImageReader<R>,
    bytes: u64,
    values: u64,
) -> Result<impl ImageDecoder + use<'r, R>, String> {
    let mut reader = reader.with_guessed_format().map_err(|e| broken(&e.to_string()))?;
    let mut ceiling = image::Limits::default();
    ceiling.max_alloc = Some(values.saturating_mul(4));
    reader.limits(ceiling);
    let format = reader.format();
    let decoder = reader.into_decoder().map_err(|e| broken(&e.to_string()))?;
    let ((width, height), most) = (decoder.dimensions(), most_pixels(&decoder, format, bytes));
    if u64::from(width) * u64::from(height) > most {
        return Err(format!(
            "is {height} × {width} pixels by its head, more than its {bytes} bytes can hold; it is damaged"
        ));
    }
    Ok(decoder)
}

/// An image the way up that its EXIF says.
struct Upright {
    image: DynamicImage,
    /// Bits of a value.
    bits: u8,
    is_turned: bool,
}

/// Decodes an image and turns it. What is no EXIF says nothing.
fn upright(mut decoder: impl ImageDecoder) -> Result<Upright, String> {
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(|e| broken(&e.to_string()))?;
    if image.color().has_alpha() && image.pixels().any(|(_, _, pixel)| pixel.0[3] != 255) {
        return Err("has transparent pixels; save it as grey or RGB".into());
    }
    image.apply_orientation(orientation);
    let bits = 8 * (image.color().bytes_per_pixel() / image.color().channel_count().max(1));
    Ok(Upright { image, bits, is_turned: orientation != Orientation::NoTransforms })
}

/// An image pixel after pixel.
#[cfg(feature = "mcap")]
pub(crate) struct DecodedImage {
    pub values: Vec<f32>,
    /// Height and width.
    pub size: [usize; 2],
    /// Values of a pixel: 1 or 3.
    pub colours: usize,
    /// The largest value that a pixel may have.
    pub white: f32,
}

/// Decodes the bytes of a PNG or JPEG file, or says why not.
#[cfg(feature = "mcap")]
pub(crate) fn decoded(bytes: &[u8], limits: &Limits) -> Result<DecodedImage, String> {
    let decoder = head(ImageReader::new(Cursor::new(bytes)), bytes.len() as u64, limits.max_values)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > limits.max_pixels {
        return Err(format!(
            "is {height} × {width} pixels, more than the {} that one image may have; raise limits.max_pixels",
            limits.max_pixels
        ));
    }
    let Upright { image, bits, .. } = upright(decoder)?;
    let size = [image.height() as usize, image.width() as usize];
    let (colours, white) =
        (if image.color().has_color() { 3 } else { 1 }, if bits == 8 { 255.0 } else { 65535.0 });
    fn floats<T: Copy + Into<f32>>(values: &[T]) -> Vec<f32> {
        values.iter().map(|value| (*value).into()).collect()
    }
    let values = match (colours, bits) {
        (3, 8) => floats(&image.into_rgb8()),
        (3, _) => floats(&image.into_rgb16()),
        (_, 8) => floats(&image.into_luma8()),
        (_, _) => floats(&image.into_luma16()),
    };
    Ok(DecodedImage { values, size, colours, white })
}

/// Returns the most pixels that so many bytes can hold: PNG packs 1032 bytes into one at best, and JPEG spends a bit at
/// least on a block of 8 × 8.
fn most_pixels(decoder: &impl ImageDecoder, format: Option<ImageFormat>, bytes: u64) -> u64 {
    match format {
        Some(ImageFormat::Png) => {
            bytes.saturating_mul(1032 * 8) / u64::from(decoder.original_color_type().bits_per_pixel())
        }
        _ => bytes.saturating_mul(8 * 64),
    }
}

/// Returns `[H, W]` or `[3, H, W]` as the head says, the way up that its EXIF says; refuses an image that is too large.
fn stored_shape(decoder: &mut impl ImageDecoder, file: &str, options: &ReadOptions) -> Result<Vec<usize>> {
    let limits = &options.limits;
    let (width, height) = turned_size(decoder);
    let pixels = u64::from(width) * u64::from(height);
    if options.resize.is_none() && pixels > limits.max_pixels {
        return Err(Error::file(
            file,
            format!(
                "is {height} × {width} pixels, more than the {} that one image may have; set resize = [height, \
                 width], or raise limits.max_pixels",
                limits.max_pixels
            ),
        ));
    }
    let colours = if decoder.color_type().has_color() { 3 } else { 1 };
    let size = [height as usize, width as usize];
    if pixels * colours as u64 > limits.max_values {
        let shape = [colours, size[0], size[1]];
        return Err(limits.too_large(file, &shape, "save it smaller or raise limits.max_values"));
    }
    Ok(if colours == 3 { [vec![3], size.to_vec()].concat() } else { size.to_vec() })
}

/// Returns width and height after the image is turned.
fn turned_size(decoder: &mut impl ImageDecoder) -> (u32, u32) {
    let (width, height) = decoder.dimensions();
    match decoder.orientation() {
        Ok(
            Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH,
        ) => (height, width),
        _ => (width, height),
    }
}

/// Replaces the last two axes of a shape by the size, where one is given.
fn resized(shape: &[usize], resize: Option<[usize; 2]>) -> Vec<usize> {
    match resize {
        None => shape.to_vec(),
        Some(size) => [&shape[..shape.len() - 2], &size].concat(),
    }
}

/// Makes one plane per colour, resampled where a size is given; `white` is the largest value.
fn planes<P: Pixel<Subpixel = f32> + 'static, T: Copy + Into<f32>>(
    stored: &[T],
    shape: &[usize],
    resize: Option<[usize; 2]>,
    white: f32,
) -> Vec<f32> {
    let colours = usize::from(P::CHANNEL_COUNT);
    let Some(size) = resize else {
        return by_plane(stored, colours).map(Into::into).collect();
    };
    let from = [shape[shape.len() - 2], shape[shape.len() - 1]];
    resampled::<P, T>(stored, from, size, white)
}

/// Resamples pixels of `from` rows and columns to `size` by a triangle filter, one plane per colour.
fn resampled<P: Pixel<Subpixel = f32> + 'static, T: Copy + Into<f32>>(
    stored: &[T],
    from: [usize; 2],
    [height, width]: [usize; 2],
    white: f32,
) -> Vec<f32> {
    let image = ScaledImage::<P, T> { stored, size: from, white, pixel: PhantomData };
    let small =
        imageops::resize(&image, width as u32, height as u32, imageops::FilterType::Triangle).into_raw();
    by_plane(&small, usize::from(P::CHANNEL_COUNT)).map(|value| value * white).collect()
}

/// Resamples pixels of `colours` values from 0 to `white` as image files are, one plane per colour.
#[cfg(feature = "mcap")]
pub(crate) fn shrunk(
    values: &[f32],
    stored: [usize; 2],
    size: [usize; 2],
    white: f32,
    colours: usize,
) -> Vec<f32> {
    if colours == 3 {
        resampled::<Rgb<f32>, f32>(values, stored, size, white)
    } else {
        resampled::<Luma<f32>, f32>(values, stored, size, white)
    }
}

/// Makes one plane per colour of pixel after pixel.
#[cfg(feature = "mcap")]
pub(crate) fn planes_of(values: &[f32], colours: usize) -> Vec<f32> {
    by_plane(values, colours).collect()
}

/// Iterates over the values of pixel after pixel as one plane per colour.
fn by_plane<T: Copy>(values: &[T], colours: usize) -> impl Iterator<Item = T> {
    (0..colours).flat_map(move |colour| values.iter().skip(colour).step_by(colours).copied())
}

/// A decoded image whose pixels are scaled to 0..1 when they are read: the image crate clamps to that range, and a copy
/// of a large image would take four times its memory.
struct ScaledImage<'a, P, T> {
    /// Pixel after pixel.
    stored: &'a [T],
    /// Height, width.
    size: [usize; 2],
    white: f32,
    pixel: PhantomData<P>,
}

impl<P: Pixel<Subpixel = f32>, T: Copy + Into<f32>> GenericImageView for ScaledImage<'_, P, T> {
    type Pixel = P;

    fn dimensions(&self) -> (u32, u32) {
        let [height, width] = self.size;
        (width as u32, height as u32)
    }

    fn get_pixel(&self, x: u32, y: u32) -> P {
        let colours = usize::from(P::CHANNEL_COUNT);
        let at = (y as usize * self.size[1] + x as usize) * colours;
        let mut unit = [0.0; 4];
        for (unit, stored) in unit.iter_mut().zip(&self.stored[at..at + colours]) {
            *unit = (*stored).into() / self.white;
        }
        *P::from_slice(&unit[..colours])
    }
}
