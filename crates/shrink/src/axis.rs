//! Quantities that shrinking can reduce.

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// A quantity that shrinking can reduce.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axis {
    /// Channels of a series, fingers, rows and columns of an array.
    Sensors,
    /// Readings per second.
    Rate,
    /// Readings from the start of a recording.
    Window,
    /// Bits of the converter.
    Bits,
    /// Taxels of an array, larger ones in their place.
    Resolution,
    /// Channels of the network's layers.
    Width,
    /// Blocks of the network.
    Depth,
}

impl Axis {
    /// Every axis, in the order in which they are tried.
    pub const ALL: [Self; 7] =
        [Self::Sensors, Self::Rate, Self::Window, Self::Bits, Self::Resolution, Self::Width, Self::Depth];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sensors => "sensors",
            Self::Rate => "rate",
            Self::Window => "window",
            Self::Bits => "bits",
            Self::Resolution => "resolution",
            Self::Width => "width",
            Self::Depth => "depth",
        }
    }

    /// Returns the name as a heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Sensors => "Sensors",
            Self::Rate => "Rate of reading",
            Self::Window => "Length of the window",
            Self::Bits => "Bits of the converter",
            Self::Resolution => "Resolution of the array",
            Self::Width => "Width of the network",
            Self::Depth => "Depth of the network",
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Axis {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let known = Self::ALL.into_iter().find(|axis| axis.name() == name);
        known.ok_or_else(|| {
            let hint = taxel_base::names::hint(name, Self::ALL.map(Self::name));
            Error::value("axes", name, format!("is nothing that can become less; {hint}"))
        })
    }
}
