//! The outermost boundary: a panic below a command, taxel's own or a library's, becomes one line and an exit code.

use std::sync::Once;

use taxel::panics::{Panic, caught};

use crate::Outcome;

/// What a command ends with, a panic included. The reader of a pipe that has gone (`taxel zoo | head`) ends it
/// quietly. `RUST_BACKTRACE` shows panics as Rust does.
pub fn guarded(command: impl FnOnce() -> Outcome) -> Outcome {
    let ended = caught(|| {
        leave_with_the_reader();
        command()
    });
    ended.unwrap_or_else(|panic| Err(words(&panic).into()))
}

/// From now on a broken pipe ends the process.
fn leave_with_the_reader() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(|| {
        let report = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if panic.payload_as_str().is_some_and(|text| text.contains("Broken pipe")) {
                std::process::exit(0);
            }
            report(panic);
        }));
    });
}

/// A panic in one line, with what was being done.
fn words(panic: &Panic) -> String {
    // `print!` can do nothing else about a full device.
    if let Some(reason) = panic.text.strip_prefix("failed printing to stdout: ") {
        return format!("standard output: cannot be written: {reason}");
    }
    let command: Vec<String> = std::env::args_os().skip(1).map(|arg| arg.to_string_lossy().into()).collect();
    format!("taxel {}: {panic}", command.join(" "))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]

    use std::process::ExitCode;

    use super::*;

    #[test]
    fn a_panic_is_one_line_that_says_where() {
        let error = guarded(|| panic!("index 7\nout of {}", 3)).unwrap_err().to_string();
        assert!(error.contains("failed inside: index 7 out of 3 (crates/taxel/src/boundary.rs:"), "{error}");
        assert!(error.starts_with("taxel ") && error.lines().count() == 1, "{error}");
        // Also one of another thread that is waited for.
        let joined = || match std::thread::spawn(|| panic!("deep")).join() {
            Ok(()) => Ok(ExitCode::SUCCESS),
            Err(payload) => std::panic::resume_unwind(payload),
        };
        let error = guarded(joined).unwrap_err().to_string();
        assert!(error.contains("failed inside: deep (crates/taxel/src/boundary.rs:"), "{error}");
    }

    #[test]
    fn a_full_standard_output_is_named() {
        let error = guarded(|| panic!("failed printing to stdout: No space left on device (os error 28)"));
        let want = "standard output: cannot be written: No space left on device (os error 28)";
        assert_eq!(error.unwrap_err().to_string(), want);
        assert!(guarded(|| Ok(ExitCode::SUCCESS)).is_ok());
    }
}
