//! Options that say what the targets of a data set are.

use serde::{Deserialize, Serialize};
use std::convert::Infallible;
use std::str::FromStr;

/// The names of the arrays or columns that hold the targets, in their order.
///
/// One name is written as plain text, several as a list. As text, on a command line or in a config, commas part them.
///
/// ```
/// use taxel_data::TargetNames;
///
/// let names = TargetNames::from("force_N,depth_mm");
/// assert_eq!(names.each(), ["force_N", "depth_mm"]);
/// assert_eq!(serde_json::to_string(&names)?, r#"["force_N","depth_mm"]"#);
/// assert_eq!(serde_json::to_string(&TargetNames::from("force"))?, r#""force""#);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(from = "Written", into = "Written")]
pub struct TargetNames(Vec<String>);

/// Names as they stand in a file.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "expected a name, names parted by commas, or a list of names")]
enum Written {
    Text(String),
    List(Vec<String>),
}

impl From<Written> for TargetNames {
    fn from(written: Written) -> Self {
        match written {
            Written::Text(text) => Self::from(text.as_str()),
            Written::List(names) => Self(names),
        }
    }
}

impl From<TargetNames> for Written {
    fn from(TargetNames(mut names): TargetNames) -> Self {
        // A name with a comma would be read as two.
        match names.as_slice() {
            [one] if !one.contains(',') => Self::Text(names.remove(0)),
            _ => Self::List(names),
        }
    }
}

impl From<&str> for TargetNames {
    fn from(text: &str) -> Self {
        Self(text.split(',').map(|name| name.trim().to_string()).collect())
    }
}

impl From<String> for TargetNames {
    fn from(text: String) -> Self {
        Self::from(text.as_str())
    }
}

impl From<Vec<String>> for TargetNames {
    fn from(names: Vec<String>) -> Self {
        Self(names)
    }
}

impl FromStr for TargetNames {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self::from(text))
    }
}

impl TargetNames {
    /// Returns the names.
    pub fn each(&self) -> &[String] {
        &self.0
    }

    /// Says what is wrong with the names.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        let is_twice = |(at, name): (usize, &String)| self.0[..at].contains(name);
        if self.0.is_empty() || self.0.iter().any(String::is_empty) {
            Some("names nothing between two commas; write a name, or several such as force_N,depth_mm")
        } else if self.0.iter().enumerate().any(is_twice) {
            Some("names one array or column twice; name each once")
        } else {
            None
        }
    }
}

/// The kind of targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum TaskKind {
    /// Classes: whole numbers or texts.
    Classes,
    /// Measured values: numbers.
    Values,
}

/// The owner of a row of targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum TargetOf {
    /// A recording: a row of `y` `[N, k]` holds k quantities.
    Recording,
    /// A time step: a row of `y` `[N, T]` holds the target of each time step.
    Step,
}
