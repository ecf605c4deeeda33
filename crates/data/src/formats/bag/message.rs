//! Reads the measurement in a message: numbers, or an image.

use crate::dataset::precision::Precision;
use crate::formats::bag::cdr::{Broken, Cdr};
use crate::formats::bag::file::Topic;
use crate::formats::bag::image::ImageReader;
use crate::formats::bag::json;
use crate::formats::bag::numbers::{Numbers, Template};
use crate::formats::bag::ros_type::{FieldType, MessageType};
use crate::options::ReadOptions;
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
const COMPRESSED: &str = "sensor_msgs/msg/CompressedImage";

/// Reads the messages of a topic.
#[derive(Debug)]
pub(crate) struct Decoder {
    of: Measurement,
    /// The fields below which numbers are read.
    fields: Vec<String>,
    numbers: Numbers,
    /// Of the first message: the names of its numbers, and its joints.
    first: Option<(Template, Vec<String>)>,
    /// Bits of a pixel.
    pub depth: Option<u8>,
}

/// Content of the messages of a topic.
#[derive(Debug)]
enum Measurement {
    /// Numbers, by their type.
    Cdr(MessageType),
    Json,
    Image(ImageReader),
}

impl Decoder {
    /// Makes a decoder of the numbers below `fields` of a topic, or says why there is none.
    pub fn of(topic: &Topic, fields: &[&str], options: &ReadOptions) -> Result<Self, String> {
        let of = match (topic.encoding.as_str(), topic.language.as_str()) {
            ("json", _) => Measurement::Json,
            ("cdr", "ros2msg") if [IMAGE, COMPRESSED].contains(&topic.kind.as_str()) => {
                if let [field, ..] = fields {
                    return Err(format!(
                        "names the field {field} of images, whose pixels are read whole; name the topic {} alone",
                        topic.name
                    ));
                }
                Measurement::Image(ImageReader::of(options, topic.kind == COMPRESSED))
            }
            ("cdr", "ros2msg") => Measurement::Cdr(MessageType::parse(&topic.kind, &topic.definition)?),
            ("ros1", _) => {
                return Err(
                    "has messages of ROS 1; convert the recording with rosbags-convert (pip install rosbags)"
                        .into(),
                );
            }
            (encoding, language) => {
                return Err(format!(
                    "has messages in {encoding:?} defined in {language:?}; those in cdr with ros2msg, and in json, are read"
                ));
            }
        };
        let fields = fields.iter().map(ToString::to_string).collect();
        Ok(Self { of, fields, numbers: Numbers::default(), first: None, depth: None })
    }

    pub fn is_image(&self) -> bool {
        matches!(self.of, Measurement::Image(_))
    }

    /// Returns the names of the numbers of a message; none of images.
    pub fn names(&self) -> &[String] {
        self.first.as_ref().map_or(&[], |(template, _)| &template.names)
    }

    /// Adds the numbers of a message to `out`, in the order of the first message, or the planes of an image. Returns their
    /// shape.
    pub fn read(
        &mut self,
        data: &[u8],
        out: &mut Vec<f32>,
        precision: &mut Precision,
    ) -> Result<Vec<usize>, Cow<'static, str>> {
        match &self.of {
            Measurement::Image(reader) => {
                let image = reader.read(data)?;
                let first = *self.depth.get_or_insert(image.depth.unwrap_or_default());
                if first != image.depth.unwrap_or_default() {
                    return Err("is an image of other pixels than message 0: of 8 bits, 16 bits or floats; record one kind".into());
                }
                out.extend(image.values);
                return Ok(image.shape);
            }
            Measurement::Json => {
                self.numbers.begin(true);
                let read = json::read(data, &self.fields, &mut self.numbers);
                read.map_err(|e| format!("is no JSON ({e})"))?;
                self.matched()?;
            }
            Measurement::Cdr(_) => {
                self.cdr(data, self.first.is_none())?;
                // Fields are in one order by their type, joints are not.
                if self.first.as_ref().is_some_and(|(_, joints)| *joints != self.numbers.labels) {
                    self.cdr(data, true)?;
                }
                if self.numbers.has_names {
                    self.matched()?;
                }
            }
        }
        let values = self.numbers.values.iter().enumerate();
        out.extend(values.map(|(channel, value)| precision.rounded(channel, *value)));
        Ok(vec![self.numbers.values.len()])
    }

    /// Reads the numbers of a message of a type, with their names or without.
    fn cdr(&mut self, data: &[u8], has_names: bool) -> Result<(), Broken> {
        let Measurement::Cdr(message) = &self.of else { return Ok(()) };
        let fields: Vec<&str> = self.fields.iter().map(String::as_str).collect();
        self.numbers.begin(has_names);
        Cdr::new(data)?.numbers(message, &fields, &mut self.numbers)
    }

    /// Brings the numbers into the order of the first message, which this may be.
    fn matched(&mut self) -> Result<(), String> {
        self.numbers.name_joints();
        match &self.first {
            Some((template, _)) => template.arrange(&mut self.numbers),
            None => {
                self.first = Some((Template::of(&self.numbers.names)?, self.numbers.labels.clone()));
                Ok(())
            }
        }
    }
}

/// Checks whether messages of this topic can hold values of a sensor.
pub(crate) fn is_measured(topic: &Topic) -> bool {
    if NO_SENSOR.iter().any(|name| topic.kind.starts_with(name)) {
        return false;
    }
    match Decoder::of(topic, &[], &ReadOptions::default()).map(|decoder| decoder.of) {
        Ok(Measurement::Cdr(message)) => {
            let mut types = message.types.iter().filter(|ros_type| !ros_type.is_about);
            types.any(|ros_type| ros_type.fields.iter().any(|field| matches!(field.of, FieldType::Number(_))))
        }
        Ok(_) => true,
        Err(_) => false,
    }
}
