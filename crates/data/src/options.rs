//! Options of reading: which arrays, channels and rows of a data set, and the limits on its size.

use serde::{Deserialize, Serialize};
use taxel_base::Layout;

use crate::formats::table::options::TableOptions;
use crate::length::length::Length;
use crate::tare::Tare;
use crate::targets::event::Event;
use crate::targets::options::{TargetNames, TargetOf, TaskKind};
use crate::{Error, Result};

/// Rows to leave out of a data set, decided on the recording with the channels that are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Drop {
    /// Every row of a set of exact copies that carries more than one label.
    Contradictory,
    /// The later copies of a row with the same label; the first stays.
    Duplicates,
    /// Rows whose target is NaN or, in a table, empty; of several targets one is enough.
    NoTarget,
}

/// Ceilings that stop a damaged or hostile file before memory is claimed for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Most values in one array, and in all samples together: a file that says more is refused before memory is taken for
    /// it [default: 268435456, which are 1 GiB].
    #[cfg_attr(feature = "clap", arg(long, value_name = "COUNT", default_value_t = Limits::DEFAULT.max_values, hide_default_value = true))]
    #[serde(alias = "max-values", skip_serializing_if = "is::<MAX_VALUES>")]
    pub max_values: u64,
    /// Most samples, and most labels (samples times attributes). Default 2^22 (4 million).
    #[cfg_attr(feature = "clap", arg(skip = Limits::DEFAULT.max_samples))]
    #[serde(alias = "max-samples", skip_serializing_if = "is::<MAX_SAMPLES>")]
    pub max_samples: u64,
    /// Most bytes in one sample file or labels file. Default 2^28 (256 MiB).
    #[cfg_attr(feature = "clap", arg(skip = Limits::DEFAULT.max_file_bytes))]
    #[serde(alias = "max-file-bytes", skip_serializing_if = "is::<MAX_FILE_BYTES>")]
    pub max_file_bytes: u64,
    /// Most pixels in one image file that is not resized; with [`ReadOptions::resize`] it is `max_values`.
    /// Default 2^24 (4096 × 4096).
    #[cfg_attr(feature = "clap", arg(skip = Limits::DEFAULT.max_pixels))]
    #[serde(alias = "max-pixels", skip_serializing_if = "is::<MAX_PIXELS>")]
    pub max_pixels: u64,
}

const MAX_VALUES: u64 = 1 << 28;
const MAX_SAMPLES: u64 = 1 << 22;
const MAX_FILE_BYTES: u64 = 1 << 28;
const MAX_PIXELS: u64 = 1 << 24;

impl Limits {
    /// The limits where nobody says others.
    const DEFAULT: Self = Self {
        max_values: MAX_VALUES,
        max_samples: MAX_SAMPLES,
        max_file_bytes: MAX_FILE_BYTES,
        max_pixels: MAX_PIXELS,
    };

    /// Says that an array or a set of this shape has too many values.
    pub(crate) fn too_large(&self, at: &str, shape: &[usize], hint: &'static str) -> Error {
        let shape = shape.iter().map(|axis| *axis as u64).collect();
        Error::TooLarge { at: at.into(), shape, limit: self.max_values, hint }
    }

    /// Refuses recordings that together have more values than allowed.
    pub(crate) fn refuse_values(&self, at: &str, values: usize) -> Result<()> {
        if values as u64 <= self.max_values {
            return Ok(());
        }
        Err(self.too_large(at, &[values], "take fewer recordings or raise limits.max_values"))
    }

    /// Refuses more samples than allowed.
    pub(crate) fn refuse_samples(&self, at: &str, samples: u64) -> Result<()> {
        if samples <= self.max_samples {
            return Ok(());
        }
        Err(Error::TooManySamples { at: at.into(), samples, limit: self.max_samples })
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

fn is<const LIMIT: u64>(value: &u64) -> bool {
    *value == LIMIT
}

/// How recordings are read, for the library, a config and a command line alike; by default arrays `x`, `y` and, where
/// there is one, `group`.
///
/// Unknown keys are refused when deserialized, and what is default is not serialized. Keys are snake_case; those with a
/// hyphen (`group-block`) are read too.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields, default)]
pub struct ReadOptions {
    /// The array that holds the samples, if it is not called `x`; where there is no `x` either, `X`, `data`, or `X_train` with
    /// `X_test`. In a folder of files of arrays it may be left out where each holds one.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<String>,
    /// The array that holds the labels or values, if it is not called `y`; of labels.csv or a table the column. Several
    /// values are parted by commas; a unit at the end of a name is taken: force_N,depth_mm.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,NAME"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<TargetNames>,
    /// Makes two classes of the values of an array or column, in place of y: rest, and the event that a number is above or
    /// below a threshold, such as "slip_speed_cm_s > 1".
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME > NUMBER"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event: Option<Event>,
    /// Names of the quantities that are learned, in the order of the columns of y, each with its unit at the end:
    /// x_mm,y_mm [default: the names of the arrays or columns].
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,NAME"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantities: Option<TargetNames>,
    /// The kind of the targets: classes or values [default: floats are values, whole numbers and texts are classes].
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "KIND"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<TaskKind>,
    /// Content of y [N, T] of arrays beside recordings of T readings: step, the target of each reading, or
    /// recording, T quantities of each recording [default: recording].
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "OF"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetOf>,
    /// The array or column that names the recording of each reading, where rows of x and y are readings: rows of one name are
    /// one recording, in their order.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// The resting values that are taken off the readings: recording, the first reading of each recording, recording:18, the
    /// mean of its first 18, array:NAME, an array with a row for each sample, or off [default: what labels.json says].
    #[cfg_attr(feature = "clap", arg(long, value_name = "REST"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
    /// The array that holds the groups, if it is not called `group`; of labels.csv or a table the column.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Turns consecutive group values into blocks: `(v - min) / group_block`, from 1 up. In a
    /// folder per class the value is the position of the file in its class folder.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(alias = "group-block", skip_serializing_if = "Option::is_none")]
    pub group_block: Option<u32>,
    /// Indices to keep along axis 1 of `x`, in this order, each once. Default all.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<usize>>,
    /// Names of the channels that a model expects, in its order: recordings whose channels have names are matched by them. No
    /// setting of a file.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip)]
    pub channel_names: Vec<String>,
    /// Rows to leave out: copies of others with another label (contradictory) or with the same one (duplicates), and rows
    /// without a target (no-target).
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "ROWS", value_delimiter = ','))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drop: Vec<Drop>,
    /// Refuse the data set if exact copies carry different labels and are not dropped.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(alias = "deny-contradictory", skip_serializing_if = "std::ops::Not::not")]
    pub deny_contradictory: bool,
    /// Name of the array that marks samples for testing with 1, all others with 0. Default none.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<String>,
    /// Tests the samples with more than this in the `test` array, in place of those marked with 1.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(alias = "test-above", skip_serializing_if = "Option::is_none")]
    pub test_above: Option<i64>,
    /// For labels `[N, k]`: the column that becomes `y`, 0..k-1.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attribute: Option<usize>,
    /// For labels `[N, k]`: learns every column under these names, as
    /// [`learn_attributes`](crate::Dataset::learn_attributes). Where neither this nor `attribute` nor
    /// `labels.json` speaks of attributes, such labels must be one-hot.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<String>,
    /// For image files: `[height, width]` in pixels to resample to (triangle filter).
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resize: Option<[usize; 2]>,
    /// Axes of a sample, whatever the file says of them.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<Layout>,
    /// Readings per second (Hz), whatever the file says of it; above 0.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// How recordings of unequal length become equal, in readings; as text `resample:300`, `pad:300,edge`, `crop:300` or
    /// `window:300,150`.
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "RULE",
            help = "How recordings of unequal length become equal, in readings: resample:300, \
                    pad:300[,edge][,crop], crop:300[,centre|,end] or window:300[,150]"
        )
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<Length>,
    /// Of a table: long or wide, and the columns whose names do not say what they are, such as
    /// long,recording=grasp,time=stamp,clock=ms,ignore=id. A clock is s, ms, us or ns; column=NAME names each channel where not
    /// all numbers are; shape=16x16 says that a row is an image of 16 × 16 taxels, or a frame.
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "COLUMNS", default_value = "", hide_default_value = true)
    )]
    #[serde(skip_serializing_if = "is_default")]
    pub table: TableOptions,
    /// A topic of ROS 2 bags, or a field of one (/joint_states.effort); several are joined as channels at the times of the
    /// first [default: the one that holds numbers or images].
    #[cfg_attr(feature = "clap", arg(long = "topic", value_name = "TOPIC"))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<String>,
    /// Of recordings with time stamps the readings per second (Hz) that they are brought to, before `length`: for a
    /// model that was trained so, [`SampleSpec::recorded_rate`](crate::SampleSpec::recorded_rate). No setting of a file. Default their
    /// own: as they are where they are regular, otherwise at the median step.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip)]
    pub stamped: Option<f64>,
    /// Ceilings on sizes.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(skip_serializing_if = "is_default")]
    pub limits: Limits,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl ReadOptions {
    /// Returns the name of the array of samples.
    pub(crate) fn x(&self) -> &str {
        self.x.as_deref().unwrap_or("x")
    }

    /// Returns the names of the arrays or columns of targets, where they are said.
    pub(crate) fn y_names(&self) -> &[String] {
        self.y.as_ref().map_or(&[], TargetNames::each)
    }

    /// Returns the names of the arrays or columns of targets, for messages.
    pub(crate) fn y(&self) -> String {
        if self.y.is_some() { self.y_names().join(", ") } else { "y".into() }
    }

    /// Returns the option that names the targets, for messages.
    pub(crate) fn y_option(&self) -> &'static str {
        if self.event.is_some() { "event" } else { "y" }
    }

    /// Checks whether values are asked for.
    pub(crate) fn wants_values(&self) -> bool {
        self.task == Some(TaskKind::Values)
    }

    /// Refuses names of targets and settings of the task that do not go together.
    pub(crate) fn refuse_targets(&self, file: &str) -> Result<()> {
        if let Some(why) = self.y.as_ref().and_then(TargetNames::problem) {
            return Err(Error::Option { file: file.into(), option: "y", why });
        }
        let attributes =
            [("attribute", self.attribute.is_some()), ("attributes", !self.attributes.is_empty())];
        let set = attributes.map(|(option, is_set)| (option, is_set && self.wants_values()));
        refuse_set(file, &set, "speaks of classes, and task = \"values\" of values; leave one of them out")
    }

    /// Checks whether another array than `x` is named.
    pub(crate) fn names_x(&self) -> bool {
        self.x() != "x"
    }

    /// Checks whether other labels than `y` are named.
    pub(crate) fn names_y(&self) -> bool {
        self.y.is_some() && self.y_names() != ["y"]
    }
}

/// Refuses the first of these options that is set.
pub(crate) fn refuse_set(file: &str, options: &[(&'static str, bool)], why: &'static str) -> Result<()> {
    match options.iter().find(|(_, set)| *set) {
        None => Ok(()),
        Some((option, _)) => Err(Error::Option { file: file.into(), option, why }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_snake_case_and_unknown_ones_are_refused() {
        let text = r#"{"group":"trial","group_block":12,"drop":["contradictory"],"layout":"image","rate":100.0,"limits":{"max_values":9}}"#;
        let options: ReadOptions = serde_json::from_str(text).unwrap();
        assert_eq!(options.group_block, Some(12));
        assert_eq!(options.drop, [Drop::Contradictory]);
        assert_eq!(options.limits.max_values, 9);
        assert_eq!((options.layout, options.rate), (Some(Layout::Image), Some(100.0)));
        assert_eq!(options.x(), "x");
        // Nothing is written that nobody has said.
        assert_eq!(serde_json::to_string(&options).unwrap(), text);
        let old = text.replace("group_block", "group-block").replace("max_values", "max-values");
        assert_eq!(serde_json::from_str::<ReadOptions>(&old).unwrap(), options);
        for bad in [
            r#"{"group_blocks": 12}"#,
            r#"{"drop": ["all"]}"#,
            r#"{"layout": "Image"}"#,
            r#"{"limits": {"values": 1}}"#,
        ] {
            let message = serde_json::from_str::<ReadOptions>(bad).unwrap_err().to_string();
            assert!(message.contains("expected"), "{message}");
        }
    }
}
