//! Where lines of readings come from, and when they were read.

use clap::Args;
use taxel::data::Clock;
use taxel::stream::Time;

/// A serial port, in place of `--input`.
#[cfg(feature = "serial")]
#[derive(Args)]
pub struct PortOptions {
    /// The serial port to read lines from.
    #[arg(long, value_name = "PORT", conflicts_with = "input")]
    pub serial: Option<String>,
    /// Bits per second of the serial port.
    #[arg(long, default_value_t = 115_200, requires = "serial")]
    pub baud: u32,
}

/// The time stamps of lines.
#[derive(Args)]
pub struct StampOptions {
    /// The column of time stamps: its number, from 1, or its name.
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<Time>,
    /// Unit of the time stamps: s, ms, us or ns [default: the end of the column's name, else s].
    #[arg(long, value_name = "UNIT", value_parser = clock)]
    pub clock: Option<Clock>,
}

fn clock(name: &str) -> Result<Clock, String> {
    Clock::named(name).ok_or_else(|| "a unit of time is s, ms, us or ns".into())
}
