//! The facts about samples that a training depends on besides their values.

use crate::dataset::dataset::Dataset;
use crate::dataset::targets::Task;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use taxel_base::Layout;

/// Facts about samples and targets that their [digest](Dataset::digest) does not cover. Models that were trained under
/// different facts cannot be compared, though the samples be equal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Meaning of the axes of a sample.
    pub layout: Layout,
    /// Names of the channels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub channel_names: Vec<String>,
    /// Unit of the values.
    pub unit: Option<String>,
    /// Time steps per second (Hz).
    pub rate: Option<f64>,
    /// The largest possible value, in `unit`.
    pub full_scale: Option<f32>,
    /// Values without contact, in `unit`.
    pub rest: Option<Vec<f32>>,
    /// Bits of a pixel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<u8>,
    /// The outputs of a model.
    pub task: Task,
}

impl Dataset {
    /// Returns the facts about the samples that a training depends on besides their values.
    pub fn facts(&self) -> Facts {
        let spec = &self.spec;
        Facts {
            layout: spec.layout,
            channel_names: spec.channel_names.clone(),
            unit: spec.unit.clone(),
            rate: spec.rate,
            full_scale: spec.full_scale,
            rest: spec.rest.clone(),
            depth: spec.depth,
            task: self.task(),
        }
    }
}

impl Facts {
    /// Returns their BLAKE3, in hexadecimal.
    pub fn digest(&self) -> String {
        blake3::hash(self.fields().to_string().as_bytes()).to_hex().to_string()
    }

    /// Lists each fact that is another one `now`, with both values: `full_scale was 1000.0, is now 1.0`.
    pub fn differences(&self, now: &Facts) -> Vec<String> {
        let (before, now) = (self.fields(), now.fields());
        let keys = ["layout", "channel_names", "unit", "rate", "full_scale", "rest", "depth", "task"];
        let changed = keys.into_iter().filter(|key| before[*key] != now[*key]);
        let shown = |value: &Value| if value.is_null() { "not known".into() } else { value.to_string() };
        changed.map(|key| format!("{key} was {}, is now {}", shown(&before[key]), shown(&now[key]))).collect()
    }

    #[expect(clippy::expect_used, reason = "text, numbers and lists are JSON")]
    fn fields(&self) -> Value {
        serde_json::to_value(self).expect("facts are JSON")
    }
}
