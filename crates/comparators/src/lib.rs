#![doc = include_str!("../README.md")]

mod lstm;
mod mlp;
mod tactnet;
mod tactresnet;

pub use lstm::LstmConfig;
pub use mlp::MlpConfig;
pub use tactnet::{TactNet, TactNetConfig, TactNetDepth};
pub use tactresnet::TactResNetConfig;

use taxel_graph::{Error, Result};

/// Refuses values below their least, and absurd ones (which would only fail later, when memory runs out).
fn in_range(values: &[(&str, usize, usize)]) -> Result<()> {
    for &(key, value, least) in values {
        if !(least..=65_536).contains(&value) {
            return Err(Error::config(key, value, &format!("must be in {least}..=65536")));
        }
    }
    Ok(())
}
