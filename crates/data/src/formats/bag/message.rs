//! Reads the measurement in a message: numbers, or an image.

use crate::formats::bag::cdr::{Broken, Cdr};
use crate::formats::bag::file::Topic;
use crate::formats::bag::ros_type::{FieldType, MessageType};
use crate::formats::image_file;
use crate::formats::json_numbers::JsonNumbers;
use serde::de::DeserializeSeed;
use std::borrow::Cow;

/// Types whose numbers are no values of a sensor.
const NO_SENSOR: [&str; 8] = [
    "rcl_interfaces/",
    "diagnostic_msgs/",
    "rosgraph_msgs/",
    "tf2_msgs/",
    "lifecycle_msgs/",
    "rosbag2_interfaces/",
    "statistics_msgs/",
    "sensor_msgs/msg/CameraInfo",
];
const IMAGE: &str = "sensor_msgs/msg/Image";

/// Reads the messages of a topic.
#[derive(Debug)]
pub(crate) enum Decoder {
    /// Of a type of numbers, and the fields below which they are read.
    Cdr {
        message: MessageType,
        fields: Vec<String>,
    },
    Json {
        fields: Vec<String>,
    },
    /// Grey, resampled to `[height, width]` where a size is given.
    Image {
        size: Option<[usize; 2]>,
    },
}

impl Decoder {
    /// Makes a decoder of the numbers below `fields` of a topic, or says why there is none.
    pub fn of(topic: &Topic, fields: &[&str], size: Option<[usize; 2]>) -> Result<Self, String> {
        let names: Vec<String> = fields.iter().map(ToString::to_string).collect();
        match (topic.encoding.as_str(), topic.language.as_str()) {
            ("json", _) => Ok(Self::Json { fields: names }),
            ("cdr", "ros2msg") if topic.kind == IMAGE && fields.is_empty() => Ok(Self::Image { size }),
            ("cdr", "ros2msg") => {
                let message = MessageType::parse(&topic.kind, &topic.definition)?;
                Ok(Self::Cdr { message, fields: names })
            }
            (encoding, language) => Err(format!(
                "has messages in {encoding:?} defined in {language:?}; those in cdr with ros2msg, and in json, are read"
            )),
        }
    }

    pub fn is_image(&self) -> bool {
        matches!(self, Self::Image { .. })
    }

    /// Adds the numbers of a message to `out`, or the rows of an image. Returns their shape.
    pub fn read(&self, data: &[u8], out: &mut Vec<f32>) -> Result<Vec<usize>, Cow<'static, str>> {
        let before = out.len();
        match self {
            Self::Cdr { message, fields } => {
                let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
                Cdr::new(data)?.numbers(message, &fields, out)?;
            }
            Self::Json { fields } => {
                let mut reader = serde_json::Deserializer::from_slice(data);
                let convert = |number: f64| number as f32;
                let seed = JsonNumbers { out, convert, wanted: Some(fields), most: usize::MAX };
                let read = seed.deserialize(&mut reader).and_then(|()| reader.end());
                read.map_err(|e| format!("is no JSON ({e})"))?;
            }
            Self::Image { size } => return image(data, *size, out),
        }
        Ok(vec![out.len() - before])
    }
}

/// Checks whether messages of this topic can hold values of a sensor.
pub(crate) fn is_measured(topic: &Topic) -> bool {
    if NO_SENSOR.iter().any(|name| topic.kind.starts_with(name)) {
        return false;
    }
    match Decoder::of(topic, &[], None) {
        Ok(Decoder::Cdr { message, .. }) => {
            let mut types = message.types.iter().filter(|ros_type| !ros_type.is_about);
            types.any(|ros_type| ros_type.fields.iter().any(|field| matches!(field.of, FieldType::Number(_))))
        }
        Ok(_) => true,
        Err(_) => false,
    }
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
    fn of(encoding: &str) -> Result<(Self, usize, usize), Cow<'static, str>> {
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

/// Reads a `sensor_msgs/Image`: header, height, width, encoding, order of bytes, bytes of a row, rows. Colours become grey
/// (luma of ITU-R BT.601).
fn image(data: &[u8], size: Option<[usize; 2]>, out: &mut Vec<f32>) -> Result<Vec<usize>, Cow<'static, str>> {
    let mut cdr = Cdr::new(data)?;
    cdr.word()?;
    cdr.word()?;
    cdr.text()?;
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
    let before = out.len();
    for row in rows.chunks_exact(step).take(height).map(|bytes| &bytes[..row]) {
        match (pixel, channels) {
            (Pixel::U8, 1) => out.extend(row.iter().copied().map(f32::from)),
            (Pixel::U8, _) => out.extend(row.chunks_exact(channels).map(|pixel| grey(pixel, red))),
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
    let Some(size) = size else { return Ok(vec![height, width]) };
    let white = match pixel {
        Pixel::U8 => 255.0,
        Pixel::U16 => 65535.0,
        Pixel::F32 => return Err("is an image of floats, which resize does not shrink; leave it out".into()),
    };
    let small = image_file::shrunk(&out[before..], [height, width], size, white);
    out.truncate(before);
    out.extend(small);
    Ok(size.to_vec())
}

const SMALL: Broken = "is an image of more pixels than it has bytes for";

/// Returns the grey of a pixel of red, green and blue, or of blue, green and red where `red` is 2.
fn grey(pixel: &[u8], red: usize) -> f32 {
    let [red, green, blue] = [red, 1, 2 - red].map(|at| f32::from(pixel[at]));
    0.299 * red + 0.587 * green + 0.114 * blue
}
