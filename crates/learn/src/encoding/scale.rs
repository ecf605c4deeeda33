//! How readings are scaled.

use serde::{Deserialize, Serialize};

use crate::problem::{Check, require};

/// How readings are scaled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// `(v - mean) / sd` per channel, fitted on the training part of each fold.
    #[default]
    ZScore,
    /// `v / full_scale`.
    FullScale,
    /// `(v / full_scale - mean) / sd` of ImageNet's red, green and blue, as torchvision's networks were
    /// trained.
    Imagenet,
    /// As they are.
    Raw,
}

/// Scaled readings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Scaled {
    /// Scale of the readings. Default `z-score`; Kaewrakmuk and Srinonchat 2026 name none.
    pub scale: Scale,
}

/// Refuses ImageNet's scale, which is of three colours.
pub(super) fn no_colours(key: &str, scale: Scale) -> Check {
    let reason = "belongs to encoding.image of three channels";
    require(scale != Scale::Imagenet, key, "\"imagenet\"", reason)
}
