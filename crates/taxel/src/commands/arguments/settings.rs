//! `--set` of networks, encodings and scenes.

use taxel_zoo::Settings;

/// Reads `key=value` pairs; a value that is not JSON is taken as text.
///
/// # Errors
/// A pair without `=`.
pub fn settings(pairs: &[String]) -> Result<Settings, String> {
    let mut settings = Settings::new();
    for pair in pairs {
        let (key, value) = pair
            .split_once('=')
            .ok_or_else(|| format!("--set {pair}: expected key=value, such as classes=5"))?;
        let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
        settings.insert(key.trim().into(), value);
    }
    Ok(settings)
}
