//! The `signal` input: scaled readings, the quantile code of them, or the last one and its differences to earlier ones.

use serde::{Deserialize, Serialize};
use taxel_encodings::{History, QuantileCode};

use super::scale::{Scale, Scaled, no_colours};
use crate::problem::{Check, within};

/// The `signal` input, by what it is made of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "Keys", into = "Keys")]
pub enum Signal {
    /// The readings [N, C, T], scaled; what a config means that names no kind.
    Scaled(Scaled),
    /// Ramps between quantiles of the readings and their changes, `kind = "quantile-code"`: [N, rows, steps].
    QuantileCode(Code),
    /// The last reading of each channel and its differences to earlier ones, as z-scores, `kind = "history"`: [N, rows, 1].
    History(History),
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
        match self {
            Signal::Scaled(Scaled { scale }) => no_colours("scale", *scale),
            Signal::QuantileCode(Code { ramps, steps }) => {
                within("ramps", *ramps, 1, 100_000)?;
                within("steps", *steps, 1, 1_000_000)
            }
            Signal::History(History { lags }) => {
                lags.iter().try_for_each(|lag| within("lags", *lag, 1, 1_000_000))
            }
        }
    }
}

/// The keys in a file: readings that are scaled need no kind.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct Keys {
    /// The kind of the input. Default `scaled`.
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<SignalKind>,
    /// Of `scaled`: scale of the readings. Default `z-score`.
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<Scale>,
    /// Of `quantile-code`: ramps that all channels share, 1 to 100,000; each of a channel's four views gets 2 to 16. Default 768.
    #[serde(skip_serializing_if = "Option::is_none")]
    ramps: Option<usize>,
    /// Of `quantile-code`: most steps in time that come out, 1 to 1,000,000. Default 40.
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<usize>,
    /// Of `history`: readings back in time, each from 1, whose differences to the last one are inputs. Default
    /// `[1, 2, 4, 8, 16, 32]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    lags: Option<Vec<usize>>,
}

/// The kind of the `signal` input.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum SignalKind {
    /// The readings, scaled.
    Scaled,
    /// Ramps between quantiles of the readings and their changes.
    QuantileCode,
    /// The last reading of each channel and its differences to earlier ones, as z-scores.
    History,
}

impl TryFrom<Keys> for Signal {
    type Error = String;

    fn try_from(Keys { kind, scale, ramps, steps, lags }: Keys) -> Result<Self, String> {
        let kind = kind.unwrap_or(SignalKind::Scaled);
        let foreign = |key: &str, kind: &str, known: &str| {
            Err(format!("`{key}` is no key of a signal of kind \"{kind}\", which has {known}"))
        };
        if lags.is_some() && kind != SignalKind::History {
            let (kind, known) = match kind {
                SignalKind::Scaled => ("scaled", "scale"),
                _ => ("quantile-code", "ramps and steps"),
            };
            return foreign("lags", kind, known);
        }
        match (kind, scale, ramps, steps) {
            (SignalKind::History, None, None, None) => {
                Ok(Signal::History(lags.map_or_else(History::default, |lags| History { lags })))
            }
            (SignalKind::History, Some(_), ..) => foreign("scale", "history", "lags"),
            (SignalKind::History, None, Some(_), _) => foreign("ramps", "history", "lags"),
            (SignalKind::History, None, None, Some(_)) => foreign("steps", "history", "lags"),
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
        let none = Keys { kind: None, scale: None, ramps: None, steps: None, lags: None };
        match signal {
            Signal::Scaled(Scaled { scale }) => Keys { scale: Some(scale), ..none },
            Signal::QuantileCode(Code { ramps, steps }) => {
                let kind = Some(SignalKind::QuantileCode);
                Keys { kind, ramps: Some(ramps), steps: Some(steps), ..none }
            }
            Signal::History(History { lags }) => {
                Keys { kind: Some(SignalKind::History), lags: Some(lags), ..none }
            }
        }
    }
}
