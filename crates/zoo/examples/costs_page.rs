//! Prints `docs/costs.md`:
//!
//! ```sh
//! cargo run -p taxel-zoo --example costs_page > docs/costs.md
//! ```

#![allow(clippy::unwrap_used, dead_code)]

#[path = "../tests/published/mod.rs"]
mod published;

fn main() {
    print!("{}", published::page());
}
