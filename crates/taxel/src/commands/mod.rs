//! One file per command: its arguments and what it does.

pub mod choose;
pub mod completions;
pub mod cost;
pub mod data;
pub mod encode;
pub mod export;
pub mod fit;
pub mod forward;
mod guarding;
pub mod import;
pub mod inspect;
mod interrupt;
mod judging;
mod network;
pub mod predict;
mod reading;
pub mod report;
pub mod run;
pub mod simulate;
pub mod stitch;
pub mod stream;
mod stream_text;
pub mod stress;
pub mod sweep;
pub mod zoo;

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
