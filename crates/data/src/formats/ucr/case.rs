//! One series of the UCR and UEA archives, as written.

use crate::{Error, Result};

/// The target of a case, and its channels.
pub(crate) struct Case {
    /// The class or the number; empty where the file has none.
    pub target: String,
    pub channels: Vec<Vec<f32>>,
}

/// The targets that the cases of a file have, as its head says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum CaseTargets {
    /// Classes, with their names where the head lists them.
    Classes(Vec<String>),
    /// Numbers of a quantity.
    Values,
    /// Nothing.
    Nothing,
    /// The head does not say.
    Unsaid,
}

impl CaseTargets {
    /// Returns the targets of a set of two files; none where they differ.
    pub fn both(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Unsaid, other) | (other, Self::Unsaid) => Some(other),
            (Self::Classes(mut names), Self::Classes(more)) => {
                let new: Vec<String> = more.into_iter().filter(|name| !names.contains(name)).collect();
                names.extend(new);
                Some(Self::Classes(names))
            }
            (one, other) => (one == other).then_some(one),
        }
    }

    /// Returns the name of the targets for messages.
    pub fn described(&self) -> &'static str {
        match self {
            Self::Classes(_) => "classes",
            Self::Values => "numbers",
            Self::Nothing => "no targets",
            Self::Unsaid => "targets",
        }
    }
}

/// A line of a file that is not blank; lines count from 1.
#[derive(Clone, Copy)]
pub(crate) struct CaseLine<'t> {
    pub file: &'t str,
    pub at: usize,
    pub text: &'t str,
}

impl CaseLine<'_> {
    /// Lists the lines of a text that are not blank, trimmed.
    pub fn of<'t>(text: &'t str, file: &'t str) -> impl Iterator<Item = CaseLine<'t>> {
        let lines =
            text.lines().enumerate().map(move |(i, text)| CaseLine { file, at: i + 1, text: text.trim() });
        lines.filter(|line| !line.text.is_empty())
    }

    /// Refuses the line.
    pub fn refuse(&self, why: impl std::fmt::Display) -> Error {
        Error::file(self.file, format!("line {}: {why}", self.at))
    }

    /// Refuses a line without values or without a class.
    pub fn no_class(&self) -> Error {
        Error::NoClass { file: self.file.into(), line: self.at as u64 }
    }

    /// Reads a number of the line; `column` counts from 1.
    pub fn number(&self, text: &str, column: usize) -> Result<f32> {
        text.trim().parse().map_err(|_| Error::CsvNumber {
            file: self.file.into(),
            line: self.at as u64,
            column,
            text: text.chars().take(40).collect(),
            hint: if text.trim() == "?" { "; series with missing values are not supported" } else { "" }
                .into(),
        })
    }

    /// Reads a number of the line, or NaN for a value that is missing (`?`).
    pub fn number_or_gap(&self, text: &str, column: usize) -> Result<f32> {
        if text.trim() == "?" { Ok(f32::NAN) } else { self.number(text, column) }
    }
}
