//! Tells the crate which compiler builds it from which commit, for `environment.json`.

use std::path::Path;
use std::process::Command;

/// Paths whose commits count: documents may change without making another program.
const SOURCES: [&str; 3] = ["..", "../../Cargo.toml", "../../Cargo.lock"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    if let Some(version) = said(Command::new(rustc).arg("--version")) {
        println!("cargo::rustc-env=TAXEL_RUSTC={version}");
    }
    let git = |args: &[&str]| said(Command::new("git").arg("--no-optional-locks").args(args));
    // Outside a repository nothing is known, and nothing to watch.
    let Some(commit) = git(&["rev-parse", "HEAD"]) else { return };
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", name]);
        if let Some(path) = path.filter(|path| Path::new(path).exists()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    SOURCES.iter().for_each(|path| println!("cargo::rerun-if-changed={path}"));
    let changed = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat());
    let dirty = if changed.is_some_and(|files| !files.is_empty()) { "-dirty" } else { "" };
    println!("cargo::rustc-env=TAXEL_COMMIT={commit}{dirty}");
}

/// Returns the output of a program, if it succeeds.
fn said(command: &mut Command) -> Option<String> {
    let output = command.output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}
