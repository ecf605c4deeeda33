//! Tells the crate which compiler builds it, for `environment.json`.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    if let Ok(output) = version {
        println!("cargo::rustc-env=TAXEL_RUSTC={}", String::from_utf8_lossy(&output.stdout).trim());
    }
}
