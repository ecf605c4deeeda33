//! The `signal` input: scaled readings, or the quantile code of them.

use serde::{Deserialize, Serialize};
use taxel_encodings::QuantileCode;

use super::scale::{Scale, Scaled, no_colours};
use crate::problem::{Check, within};

/// The `signal` input, by what it is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub enum Signal {
    /// The readings [N, C, T], scaled; what a config means that names no kind.
    Scaled(Scaled),
    /// Ramps between quantiles of the readings and their changes, `kind = "quantile-code"`: [N, rows, steps].
    QuantileCode(Code),
}

/// The quantile code, fitted on the training part of each fold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// Ramps that all channels share, 1 to 100,000; each of a channel's four views gets 2 to 16. Default 768.
    pub ramps: usize,
    /// Most steps in time that come out, 1 to 1,000,000. Default 40.
    pub steps: usize,
}

impl Default for Signal {
    fn default() -> Self {
        Signal::Scaled(Scaled::default())
    }
}

impl Default for Code {
    fn default() -> Self {
        let QuantileCode { ramps, steps, .. } = QuantileCode::default();
        Code { ramps, steps }
    }
}

impl Signal {
    pub(super) fn check(&self) -> Check {
        match *self {
            Signal::Scaled(Scaled { scale }) => no_colours("scale", scale),
            Signal::QuantileCode(Code { ramps, steps }) => {
                within("ramps", ramps, 1, 100_000)?;
                within("steps", steps, 1, 1_000_000)
            }
        }
    }
}

/// The keys in a file: readings that are scaled need no kind.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<SignalKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<Scale>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ramps: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SignalKind {
    Scaled,
    QuantileCode,
}

impl TryFrom<Keys> for Signal {
    type Error = String;

    fn try_from(Keys { kind, scale, ramps, steps }: Keys) -> Result<Self, String> {
        let foreign = |key: &str, kind: &str, known: &str| {
            Err(format!("`{key}` is no key of a signal of kind \"{kind}\", which has {known}"))
        };
        match (kind.unwrap_or(SignalKind::Scaled), scale, ramps, steps) {
            (SignalKind::Scaled, scale, None, None) => {
                Ok(Signal::Scaled(Scaled { scale: scale.unwrap_or_default() }))
            }
            (SignalKind::Scaled, _, Some(_), _) => foreign("ramps", "scaled", "scale"),
            (SignalKind::Scaled, _, None, Some(_)) => foreign("steps", "scaled", "scale"),
            (SignalKind::QuantileCode, Some(_), _, _) => foreign("scale", "quantile-code", "ramps and steps"),
            (SignalKind::QuantileCode, None, ramps, steps) => {
                let default = Code::default();
                let (ramps, steps) = (ramps.unwrap_or(default.ramps), steps.unwrap_or(default.steps));
                Ok(Signal::QuantileCode(Code { ramps, steps }))
            }
        }
    }
}

impl From<Signal> for Keys {
    fn from(signal: Signal) -> Self {
        match signal {
            Signal::Scaled(Scaled { scale }) => {
                Keys { kind: None, scale: Some(scale), ramps: None, steps: None }
            }
            Signal::QuantileCode(Code { ramps, steps }) => Keys {
                kind: Some(SignalKind::QuantileCode),
                scale: None,
                ramps: Some(ramps),
                steps: Some(steps),
            },
        }
    }
}
