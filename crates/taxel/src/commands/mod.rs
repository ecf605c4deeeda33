//! One file per command: its arguments and what it does.

mod asked;
#[cfg(feature = "lab")]
pub mod choose;
#[cfg(feature = "lab")]
pub mod completions;
#[cfg(feature = "lab")]
pub mod cost;
#[cfg(feature = "lab")]
pub mod data;
#[cfg(feature = "lab")]
pub mod encode;
#[cfg(feature = "lab")]
pub mod export;
#[cfg(feature = "lab")]
pub mod fit;
#[cfg(feature = "lab")]
pub mod forward;
mod guarding;
#[cfg(feature = "lab")]
pub mod import;
pub mod inspect;
mod interrupt;
#[cfg(feature = "lab")]
mod judging;
#[cfg(feature = "lab")]
mod network;
pub mod predict;
#[cfg(feature = "lab")]
pub mod quantize;
mod reading;
#[cfg(feature = "lab")]
pub mod report;
#[cfg(feature = "lab")]
pub mod run;
#[cfg(feature = "lab")]
pub mod shrink;
#[cfg(feature = "lab")]
mod signals;
#[cfg(feature = "lab")]
pub mod simulate;
#[cfg(feature = "lab")]
pub mod stitch;
pub mod stream;
mod stream_text;
#[cfg(feature = "lab")]
pub mod stress;
#[cfg(feature = "lab")]
pub mod sweep;
#[cfg(feature = "lab")]
pub mod zoo;

#[cfg(feature = "lab")]
use taxel_zoo::Settings;

/// The value of --threads; more than there are cores are capped, and said.
pub fn threads(asked: Option<usize>) -> usize {
    let threads = taxel::learn::threads(asked);
    if let Some(asked) = asked.filter(|asked| *asked > threads) {
        eprintln!("--threads {asked}: this machine has {threads} cores, so {threads} threads run");
    }
    threads
}

/// `key=value` pairs of `--set`; a value that is not JSON is taken as text.
#[cfg(feature = "lab")]
pub fn settings(pairs: &[String]) -> Result<Settings, String> {
    let mut settings = Settings::new();
    for pair in pairs {
        let (key, value) = pair
            .split_once('=')
            .ok_or_else(|| format!("--set {pair}: expected key=value, as in classes=5"))?;
        let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
        settings.insert(key.trim().into(), value);
    }
    Ok(settings)
}
