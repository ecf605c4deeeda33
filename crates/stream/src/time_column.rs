//! Where the time stamps of lines stand.

use std::str::FromStr;

use crate::error::Error;

/// Where time stamps stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Time {
    /// In the column of this number, from 0.
    At(usize),
    /// In the column, or under the key, of this name.
    Named(String),
}

impl FromStr for Time {
    type Err = Error;

    /// Reads a column: a number counts from 1; anything else is a name.
    fn from_str(text: &str) -> Result<Self, Error> {
        match text.trim().parse::<usize>() {
            Ok(0) => {
                let why = "is the number of a column, from 1, or its name".into();
                Err(Error::Option { option: "time", value: text.into(), why })
            }
            Ok(number) => Ok(Time::At(number - 1)),
            Err(_) => Ok(Time::Named(text.trim().into())),
        }
    }
}
