//! Lines that commands print: results on standard output, messages on standard error.
//!
//! Names out of foreign files cannot steer a terminal: what is printed passes `taxel_base::printable`.
//!
//! `--quiet` leaves errors and results, `--verbose` adds details. Colours need a terminal; `NO_COLOR` turns them
//! off everywhere, and `CLICOLOR_FORCE` on where there is no terminal.

use std::fmt::{Arguments, Display};
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicU8, Ordering};

use taxel_base::printable;

/// Exit code of a command that could not run.
pub const FAILED: u8 = 2;

/// How much is said on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Verbosity {
    /// Errors only.
    Quiet,
    /// Warnings, notes and progress as well.
    Normal,
    /// Details as well.
    Verbose,
}

static VERBOSITY: AtomicU8 = AtomicU8::new(Verbosity::Normal as u8);

/// Sets how much is said from now on.
pub fn set_verbosity(verbosity: Verbosity) {
    VERBOSITY.store(verbosity as u8, Ordering::Relaxed);
}

/// Checks whether messages of this kind are printed.
pub fn says(kind: Verbosity) -> bool {
    VERBOSITY.load(Ordering::Relaxed) >= kind as u8
}

/// Prints an error; `--quiet` does not hide it.
pub fn error(text: impl Display) {
    message(Verbosity::Quiet, "error: ", "1;31", &text);
}

/// Prints a warning.
pub fn warn(text: impl Display) {
    message(Verbosity::Normal, "warning: ", "1;33", &text);
}

/// Prints a note, such as where a stopped command goes on.
pub fn note(text: impl Display) {
    message(Verbosity::Normal, "", "", &text);
}

/// Prints a detail, for `--verbose`.
pub fn detail(text: impl Display) {
    message(Verbosity::Verbose, "", "", &text);
}

/// Prints a line on standard error; nobody may be there to read it.
fn message(kind: Verbosity, label: &str, colour: &str, text: &dyn Display) {
    if !says(kind) {
        return;
    }
    let text = text.to_string();
    let text = printable(&text);
    let mut stderr = std::io::stderr().lock();
    let is_coloured = !label.is_empty() && wants_colour(stderr.is_terminal(), variable);
    let _ = if is_coloured {
        writeln!(stderr, "\x1b[{colour}m{label}\x1b[0m{text}")
    } else {
        writeln!(stderr, "{label}{text}")
    };
}

/// Checks whether messages have colours, by the usual variables: `NO_COLOR` (no-color.org) says no, `CLICOLOR_FORCE`
/// (bixense.com/clicolors) other than 0 says yes, `CLICOLOR=0` says no; otherwise a terminal has them.
fn wants_colour(is_terminal: bool, variable: impl Fn(&str) -> Option<String>) -> bool {
    let is = |name: &str, holds: fn(&str) -> bool| variable(name).is_some_and(|value| holds(&value));
    if is("NO_COLOR", |value| !value.is_empty()) {
        return false;
    }
    is("CLICOLOR_FORCE", |value| !value.is_empty() && value != "0")
        || is_terminal && !is("CLICOLOR", |value| value == "0")
}

/// Returns the value of an environment variable.
fn variable(name: &str) -> Option<String> {
    std::env::var_os(name).map(|value| value.to_string_lossy().into_owned())
}

/// Writes to standard output. A reader that has gone (`taxel zoo | head`) ends the process quietly; an output that
/// cannot be written ends it with an error.
pub fn write(text: Arguments) {
    let text = text.to_string();
    if let Err(problem) = std::io::stdout().lock().write_all(printable(&text).as_bytes()) {
        if problem.kind() == ErrorKind::BrokenPipe {
            std::process::exit(0);
        }
        error(unwritable(&problem));
        std::process::exit(i32::from(FAILED));
    }
}

/// Says that standard output cannot be written.
pub fn unwritable(problem: &std::io::Error) -> String {
    format!("standard output: cannot be written: {problem}")
}

/// Prints a part of the result on standard output.
#[macro_export]
macro_rules! out {
    ($($text:tt)*) => { $crate::terminal::messages::write(format_args!($($text)*)) };
}

/// Prints a line of the result on standard output.
#[macro_export]
macro_rules! outln {
    () => { $crate::terminal::messages::write(format_args!("\n")) };
    ($($text:tt)*) => { $crate::terminal::messages::write(format_args!("{}\n", format_args!($($text)*))) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verbosity_decides_what_is_said() {
        assert!(says(Verbosity::Quiet) && says(Verbosity::Normal) && !says(Verbosity::Verbose));
        assert!(Verbosity::Quiet < Verbosity::Normal && Verbosity::Normal < Verbosity::Verbose);
    }

    #[test]
    fn colours_follow_the_usual_variables() {
        let wants = |is_terminal, set: &[(&str, &str)]| {
            let found =
                |name: &str| set.iter().find(|(key, _)| *key == name).map(|(_, value)| value.to_string());
            wants_colour(is_terminal, found)
        };
        assert!(wants(true, &[]) && !wants(false, &[]));
        assert!(!wants(true, &[("NO_COLOR", "1")]) && wants(true, &[("NO_COLOR", "")]));
        assert!(wants(false, &[("CLICOLOR_FORCE", "1")]) && !wants(false, &[("CLICOLOR_FORCE", "0")]));
        assert!(!wants(true, &[("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")]));
        assert!(!wants(true, &[("CLICOLOR", "0")]) && wants(true, &[("CLICOLOR", "1")]));
    }

    #[test]
    fn a_full_standard_output_is_named() {
        let full = std::io::Error::from_raw_os_error(28);
        let want = "standard output: cannot be written: No space left on device (os error 28)";
        assert_eq!(unwritable(&full), want);
    }
}
