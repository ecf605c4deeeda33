//! What to read from a data set and what to leave out.

use serde::{Deserialize, Serialize};
use taxel_base::Layout;

use crate::formats::table::options::TableOptions;
use crate::length::length::Length;
use crate::{Error, Result};

/// Rows to leave out of a data set, decided on the full recorded sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drop {
    /// Every row of a set of exact copies that carries more than one label.
    Contradictory,
    /// The later copies of a row with the same label; the first stays.
    Duplicates,
}

/// Ceilings that stop a damaged or hostile file before memory is claimed for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Limits {
    /// Most values in one array, and in all samples together. Default 2^28 (1 GiB as f32).
    pub max_values: u64,
    /// Most samples, and most labels (samples times attributes). Default 2^22 (4 million).
    pub max_samples: u64,
    /// Most bytes in one sample file or labels file. Default 2^28 (256 MiB).
    pub max_file_bytes: u64,
    /// Most pixels in one image file that is not resized; with [`ReadOptions::resize`] it is `max_values`.
    /// Default 2^24 (4096 × 4096).
    pub max_pixels: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_values: 1 << 28, max_samples: 1 << 22, max_file_bytes: 1 << 28, max_pixels: 1 << 24 }
    }
}

/// How to read a data set; the default reads arrays `x`, `y` and, where present, `group`.
///
/// Unknown keys are refused when deserialized; keys are kebab-case (`group-block`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct ReadOptions {
    /// Name of the array of samples in the `.npz` or `.mat`. Default `x`; where there is none, `X`, `data`, or
    /// `X_train` with `X_test`. In a folder of `.mat` files it may be left out where each holds one array.
    pub x: String,
    /// Name of the array of labels, or of a table the column. Default `y`; where there is none, `Y`, `labels`, or `y_train` with `y_test`.
    pub y: String,
    /// Name of the array of groups (`block`, `session`, `trial`, ...). By default
    /// `group` where the file holds it, otherwise no groups.
    pub group: Option<String>,
    /// Turns consecutive group values into blocks: `(v - min) / group_block`, from 1 up. In a
    /// folder per class the value is the position of the file in its class folder.
    pub group_block: Option<u32>,
    /// Indices to keep along axis 1 of `x`, in this order, each once. Default all.
    pub channels: Option<Vec<usize>>,
    /// Rows to leave out, after their copies were sought over all channels.
    pub drop: Vec<Drop>,
    /// Refuse the data set if exact copies carry different labels and are not dropped.
    pub deny_contradictory: bool,
    /// Name of the array that marks samples for testing (not 0). Default none.
    pub test: Option<String>,
    /// Tests the samples with more than this in the `test` array, in place of those that are not 0.
    pub test_above: Option<i64>,
    /// For labels `[N, k]`: the column that becomes `y`, 0..k-1.
    pub attribute: Option<usize>,
    /// For labels `[N, k]`: learns every column under these names, as
    /// [`learn_attributes`](crate::Dataset::learn_attributes). Where neither this nor `attribute` nor
    /// `labels.json` speaks of attributes, such labels must be one-hot.
    pub attributes: Vec<String>,
    /// For image files: `[height, width]` in pixels to resample to (triangle filter).
    pub resize: Option<[usize; 2]>,
    /// What the axes of a sample are, whatever the file says of them.
    pub layout: Option<Layout>,
    /// Readings per second (Hz), whatever the file says of it; above 0.
    pub rate: Option<f64>,
    /// What becomes of recordings of unequal length; equal ones go through it too.
    pub length: Option<Length>,
    /// Of a CSV table: what its columns are.
    pub table: TableOptions,
    /// Topics of bags, joined as channels at the times of the first; `/joint_states.effort` is a field of one. Default
    /// the one topic that holds numbers or images.
    pub topics: Vec<String>,
    /// Of recordings with time stamps the readings per second (Hz) that they are brought to, before `length`: for a
    /// model that was trained so, [`Reading::recorded_rate`](crate::Reading::recorded_rate). No setting of a file. Default their
    /// own: as they are where they are regular, otherwise at the median step.
    #[serde(skip)]
    pub stamped: Option<f64>,
    /// Ceilings on sizes.
    pub limits: Limits,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            x: "x".into(),
            y: "y".into(),
            group: None,
            group_block: None,
            channels: None,
            drop: Vec::new(),
            deny_contradictory: false,
            test: None,
            test_above: None,
            attribute: None,
            attributes: Vec::new(),
            resize: None,
            layout: None,
            rate: None,
            length: None,
            table: TableOptions::default(),
            topics: Vec::new(),
            stamped: None,
            limits: Limits::default(),
        }
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
    fn keys_are_kebab_case_and_unknown_ones_are_refused() {
        let text = r#"{"group": "trial", "group-block": 12, "drop": ["contradictory"], "layout": "image", "rate": 100,
                       "limits": {"max-values": 9}}"#;
        let options: ReadOptions = serde_json::from_str(text).unwrap();
        assert_eq!(options.group_block, Some(12));
        assert_eq!(options.drop, [Drop::Contradictory]);
        assert_eq!(options.limits.max_values, 9);
        assert_eq!((options.layout, options.rate), (Some(Layout::Image), Some(100.0)));
        assert_eq!(options.x, "x");
        let back: ReadOptions = serde_json::from_str(&serde_json::to_string(&options).unwrap()).unwrap();
        assert_eq!(back, options);
        for bad in [
            r#"{"group_block": 12}"#,
            r#"{"drop": ["all"]}"#,
            r#"{"layout": "Image"}"#,
            r#"{"limits": {"values": 1}}"#,
        ] {
            let message = serde_json::from_str::<ReadOptions>(bad).unwrap_err().to_string();
            assert!(message.contains("expected"), "{message}");
        }
    }
}
