//! Everything between a command and the terminal: results, messages, tables, signals, panics.

mod boundary;
pub mod interrupt;
pub mod messages;
#[cfg(feature = "lab")]
pub mod progress;
#[cfg(feature = "lab")]
pub mod signals;
pub mod tables;

pub use boundary::guarded;

/// Makes a write beyond `ulimit -f` an error that names the file; the signal for it would end the process without a word.
///
/// # Errors
/// The system's refusal to set a handler.
#[cfg(unix)]
pub fn hear_file_limit() -> std::io::Result<()> {
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default()).map(|_| ())
}

#[cfg(not(unix))]
pub fn hear_file_limit() -> std::io::Result<()> {
    Ok(())
}
