//! Reads the images of `sensor_msgs/Image` and `sensor_msgs/CompressedImage`.

use crate::formats::bag::cdr::{Broken, Cdr};
use crate::formats::image_file;
use crate::options::{Limits, ReadOptions};
use std::borrow::Cow;
use taxel_base::Layout;

type Why = Cow<'static, str>;

/// How images of a topic are wanted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageReader {
    /// Height and width that they are resampled to, where one is given.
    size: Option<[usize; 2]>,
    /// Colours become grey.
    is_grey: bool,
    /// Data of a file of PNG or JPEG, not rows of pixels.
    is_compressed: bool,
    limits: Limits,
}

/// An image: its shape, `[H, W]` or `[3, H, W]`, its values, and the bits of each where they are whole numbers.
pub(crate) struct BagImage {
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
    pub depth: Option<u8>,
}

impl ImageReader {
    /// Reads images as the options say: in colour, but where a layout of grey ones is wanted.
    pub fn of(options: &ReadOptions, is_compressed: bool) -> Self {
        let is_grey = options.layout.is_some_and(|layout| layout != Layout::Colour);
        Self { size: options.resize, is_grey, is_compressed, limits: options.limits }
    }

    /// Reads a message: a header, and then what its type says.
    pub fn read(&self, data: &[u8]) -> Result<BagImage, Why> {
        let mut cdr = Cdr::new(data)?;
        cdr.word()?;
        cdr.word()?;
        cdr.text()?;
        let pixels = if self.is_compressed { self.compressed(cdr)? } else { raw(cdr)? };
        self.finished(pixels)
    }

    /// Reads format and data of a compressed image.
    fn compressed(&self, mut cdr: Cdr) -> Result<Pixels, Why> {
        let format = String::from_utf8_lossy(cdr.text()?).into_owned();
        let data = cdr.bytes()?;
        let decoded = image_file::decoded(data, &self.limits).map_err(|why| {
            let format: String = format.chars().take(40).collect();
            let depth = if format.contains("compressedDepth") {
                "; record the raw topic of this depth image"
            } else {
                ""
            };
            format!("{why}, format {format:?}{depth}")
        })?;
        let (size, channels, white) = (decoded.size, decoded.colours, decoded.white);
        Ok(Pixels { values: decoded.values, size, channels, white: Some(white) })
    }

    /// Brings pixels to grey and to the size where that is wanted, and into planes.
    fn finished(&self, mut pixels: Pixels) -> Result<BagImage, Why> {
        if self.is_grey && pixels.channels == 3 {
            pixels.values = pixels.values.as_chunks().0.iter().map(grey).collect();
            pixels.channels = 1;
        }
        let Pixels { values, size, channels, white } = pixels;
        let (values, size) = match (self.size, white) {
            (None, _) => (image_file::planes_of(&values, channels), size),
            (Some(_), None) => {
                return Err("is an image of floats, which resize does not shrink; leave it out".into());
            }
            (Some(to), Some(white)) => (image_file::shrunk(&values, size, to, white, channels), to),
        };
        let shape = if channels == 3 { [&[3], &size[..]].concat() } else { size.to_vec() };
        let depth = white.map(|white| if white > 255.0 { 16 } else { 8 });
        Ok(BagImage { shape, values, depth })
    }
}

/// Pixel after pixel.
struct Pixels {
    values: Vec<f32>,
    /// Height and width.
    size: [usize; 2],
    /// 3 of colours: red, green, blue.
    channels: usize,
    /// The largest value; none of floats.
    white: Option<f32>,
}

/// The numbers of a pixel.
#[derive(Clone, Copy)]
enum Pixel {
    U8,
    U16,
    F32,
}

impl Pixel {
    fn bytes(self) -> usize {
        match self {
            Pixel::U8 => 1,
            Pixel::U16 => 2,
            Pixel::F32 => 4,
        }
    }

    /// Returns the numbers of a pixel, how many channels it has, and which of them is red.
    fn of(encoding: &str) -> Result<(Self, usize, usize), Why> {
        Ok(match encoding {
            "mono8" | "8UC1" => (Pixel::U8, 1, 0),
            "mono16" | "16UC1" => (Pixel::U16, 1, 0),
            "32FC1" => (Pixel::F32, 1, 0),
            "rgb8" | "8UC3" => (Pixel::U8, 3, 0),
            "bgr8" => (Pixel::U8, 3, 2),
            "rgba8" => (Pixel::U8, 4, 0),
            "bgra8" => (Pixel::U8, 4, 2),
            other => {
                let other: String = other.chars().take(20).collect();
                return Err(format!(
                    "is an image in {other:?}; mono8, mono16, 32FC1, rgb8, bgr8 and those with alpha are read"
                )
                .into());
            }
        })
    }
}

/// Reads height, width, encoding, order of bytes, bytes of a row, and rows.
fn raw(mut cdr: Cdr) -> Result<Pixels, Why> {
    let [height, width] = [cdr.word()? as usize, cdr.word()? as usize];
    let encoding = String::from_utf8_lossy(cdr.text()?).into_owned();
    let is_big = cdr.byte()? != 0;
    let step = cdr.word()? as usize;
    let rows = cdr.bytes()?;
    let (pixel, channels, red) = Pixel::of(&encoding)?;
    let row = width.saturating_mul(channels * pixel.bytes());
    if height == 0 || width == 0 || row > step || step.saturating_mul(height) > rows.len() {
        return Err(Cow::Borrowed(SMALL));
    }
    let mut out = vec![];
    for row in rows.chunks_exact(step).take(height).map(|bytes| &bytes[..row]) {
        match (pixel, channels) {
            (Pixel::U8, 1) => out.extend(row.iter().copied().map(f32::from)),
            (Pixel::U8, _) => {
                let colours = |pixel: &[u8]| [red, 1, 2 - red].map(|at| f32::from(pixel[at]));
                out.extend(row.chunks_exact(channels).flat_map(colours));
            }
            (Pixel::U16, _) => out.extend(row.as_chunks().0.iter().map(|bytes| {
                f32::from(if is_big { u16::from_be_bytes(*bytes) } else { u16::from_le_bytes(*bytes) })
            })),
            (Pixel::F32, _) => {
                out.extend(row.as_chunks().0.iter().map(|bytes| {
                    if is_big { f32::from_be_bytes(*bytes) } else { f32::from_le_bytes(*bytes) }
                }))
            }
        }
    }
    let white = match pixel {
        Pixel::U8 => Some(255.0),
        Pixel::U16 => Some(65535.0),
        Pixel::F32 => None,
    };
    Ok(Pixels { values: out, size: [height, width], channels: if channels == 1 { 1 } else { 3 }, white })
}

const SMALL: Broken = "is an image of more pixels than it has bytes for";

/// Returns the grey of a pixel (luma of ITU-R BT.601).
fn grey([red, green, blue]: &[f32; 3]) -> f32 {
    0.299 * red + 0.587 * green + 0.114 * blue
}
