//! The outermost boundary: a panic below a command, taxel's or a library's, becomes one line and an exit code.

use taxel::panics::{Panic, caught};

use crate::CommandResult;

/// Runs a command, and makes an error of a panic. `RUST_BACKTRACE` shows panics as Rust does.
pub fn guarded(command: impl FnOnce() -> CommandResult) -> CommandResult {
    caught(command).unwrap_or_else(|panic| Err(in_one_line(&panic).into()))
}

/// Returns a panic in one line, with the command that was running.
fn in_one_line(panic: &Panic) -> String {
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
        assert!(
            error.contains("failed inside: index 7 out of 3 (crates/taxel/src/terminal/boundary.rs:"),
            "{error}"
        );
        assert!(error.starts_with("taxel ") && error.lines().count() == 1, "{error}");
        // Also one of another thread that is waited for.
        let joined = || match std::thread::spawn(|| panic!("deep")).join() {
            Ok(()) => Ok(ExitCode::SUCCESS),
            Err(payload) => std::panic::resume_unwind(payload),
        };
        let error = guarded(joined).unwrap_err().to_string();
        assert!(error.contains("failed inside: deep (crates/taxel/src/terminal/boundary.rs:"), "{error}");
        assert!(guarded(|| Ok(ExitCode::SUCCESS)).is_ok());
    }
}
