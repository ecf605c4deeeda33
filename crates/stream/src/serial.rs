//! A serial port.

use std::io::Read;
use std::time::Duration;

use crate::error::{Error, Result};

/// How long a port is waited for at a time; it is asked again.
const QUIET: Duration = Duration::from_millis(200);

/// Opens the port at `path`, 8 bits, no parity, one stop bit.
///
/// # Errors
/// A port that is not there, is used by another program or may not be opened.
pub(crate) fn open(path: &str, baud: u32) -> Result<Box<dyn Read + Send>> {
    let open = || serialport::new(path, baud).timeout(QUIET).open();
    let port = open().map_err(|e| {
        let why = format!(
            "the serial port cannot be opened: {e}; look whether it is there, whether another program has it, and \
             whether you may read it (on Linux: the group dialout)"
        );
        Error::Source { source_label: path.into(), why }
    })?;
    Ok(Box::new(Port(port)))
}

struct Port(Box<dyn serialport::SerialPort>);

impl Read for Port {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        match self.0.read(into) {
            // A port has no end: what looks like one is a port that has gone.
            Ok(0) => Err(std::io::Error::other("the port has gone")),
            other => other,
        }
    }
}
