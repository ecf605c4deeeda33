//! The range of an image: a word or a table of two numbers.

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `"per-sample"`, or `{ low, high }` in the unit of the readings.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Range {
    /// Minimum and maximum of each sample: amplitude is lost.
    #[default]
    PerSample,
    /// The same two readings for every sample: amplitude is kept.
    Fixed {
        /// The reading that becomes -1.
        low: f64,
        /// The reading that becomes 1.
        high: f64,
    },
}

impl From<Range> for taxel_encodings::Range {
    fn from(range: Range) -> Self {
        match range {
            Range::PerSample => Self::PerSample,
            Range::Fixed { low, high } => Self::Fixed { low: low as f32, high: high as f32 },
        }
    }
}

impl Serialize for Range {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Range::PerSample => serializer.serialize_str("per-sample"),
            Range::Fixed { low, high } => serializer.collect_map([("low", low), ("high", high)]),
        }
    }
}

// Written out because an untagged enum forgets where in the file the mistake is.
impl<'de> Deserialize<'de> for Range {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RangeVisitor)
    }
}

struct RangeVisitor;

impl<'de> Visitor<'de> for RangeVisitor {
    type Value = Range;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("\"per-sample\" or { low = .., high = .. }")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Range, E> {
        match word {
            "per-sample" => Ok(Range::PerSample),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Range, A::Error> {
        use serde::de::Error;
        let (mut low, mut high) = (None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "low" => low = Some(map.next_value()?),
                "high" => high = Some(map.next_value()?),
                _ => return Err(A::Error::unknown_field(&key, &["low", "high"])),
            }
        }
        match (low, high) {
            (Some(low), Some(high)) => Ok(Range::Fixed { low, high }),
            (None, _) => Err(A::Error::missing_field("low")),
            (_, None) => Err(A::Error::missing_field("high")),
        }
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Range {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Range".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "const": "per-sample", "description": "Minimum and maximum of each sample: amplitude is lost." },
                {
                    "type": "object",
                    "description": "The same two readings for every sample: amplitude is kept.",
                    "properties": {
                        "low": { "type": "number", "description": "The reading that becomes -1." },
                        "high": { "type": "number", "description": "The reading that becomes 1." },
                    },
                    "required": ["low", "high"],
                    "additionalProperties": false,
                },
            ],
        })
    }
}
