//! The source of samples: a simulated world or a sensor.

use crate::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// Whether samples were simulated or recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SourceKind {
    /// Computed by a model of a sensor.
    Simulated,
    /// Recorded by a sensor.
    Real,
}

/// The source of samples, which stands beside every score; prints and serialises as `simulated: fingertip` or
/// `real: glove`.
///
/// ```
/// use taxel_data::Source;
///
/// let source: Source = "simulated: fingertip".parse()?;
/// assert_eq!(source, Source::simulated("fingertip"));
/// assert_eq!(Source::real("glove").to_string(), "real: glove");
/// # Ok::<(), taxel_data::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Source {
    /// Whether samples were simulated or recorded.
    pub kind: SourceKind,
    /// The scene, or the data set.
    pub name: String,
}

impl Source {
    /// Makes the source of a recorded data set.
    pub fn real(name: impl Into<String>) -> Self {
        Self { kind: SourceKind::Real, name: name.into() }
    }

    /// Makes the source of a simulated world.
    pub fn simulated(name: impl Into<String>) -> Self {
        Self { kind: SourceKind::Simulated, name: name.into() }
    }

    /// Checks whether samples were simulated.
    pub fn is_simulated(&self) -> bool {
        self.kind == SourceKind::Simulated
    }
}

impl SourceKind {
    /// Returns the words that a source of this kind begins with.
    fn prefix(self) -> &'static str {
        match self {
            Self::Simulated => "simulated: ",
            Self::Real => "real: ",
        }
    }
}

impl Display for Source {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}{}", self.kind.prefix(), self.name))
    }
}

impl FromStr for Source {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let named =
            |kind: SourceKind| text.strip_prefix(kind.prefix()).map(|name| Self { kind, name: name.into() });
        let source = named(SourceKind::Simulated).or_else(|| named(SourceKind::Real));
        source.ok_or_else(|| Error::Source { text: text.into() })
    }
}

impl Serialize for Source {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Source {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}
