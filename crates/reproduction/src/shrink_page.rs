//! A result page from what `taxel shrink` wrote: its sentences, its tables, the smaller model's settings.

use std::path::Path;

use sha2::{Digest, Sha256};
use taxel::shrink::Shrunk;
use toml::{Table, Value};

use crate::error::{Error, Result};
use crate::pages::read;

/// Returns the page of a folder that `taxel shrink` wrote, below `title`; `command` says how it was made.
///
/// # Errors
/// A file that is missing or damaged.
pub fn shrink_page(folder: &Path, title: &str, command: Option<&str>) -> Result<String> {
    let path = folder.join("shrink.json");
    let shrunk: Shrunk = serde_json::from_str(&read(&path)?).map_err(|e| Error::file(&path, e))?;
    let mut parts = vec![
        format!("# {title}"),
        format!(
            "`{}` of `{}`: {}, {} samples, {}; {} test parts, {} inner folds of each training part, margin {} points.",
            shrunk.network,
            shrunk.run,
            shrunk.source,
            shrunk.samples,
            shrunk.protocol,
            shrunk.parts,
            shrunk.inner,
            shrunk.margin
        ),
    ];
    parts.extend(command.map(|command| format!("```sh\n{command}\n```")));
    parts.extend(shrunk.notes.iter().cloned());
    let left_out = shrunk.left_out.iter().map(|(axis, reason)| format!("- {axis}: left out: {reason}"));
    let lines: Vec<String> = shrunk.words.iter().map(|words| format!("- {words}")).chain(left_out).collect();
    parts.push(lines.join("\n"));
    let mut names: Vec<String> = shrunk.curves.iter().map(|curve| format!("curve-{}", curve.axis)).collect();
    names.extend((!shrunk.models.is_empty()).then(|| "models".into()));
    for name in names {
        parts.push(read(&folder.join("tables").join(format!("{name}.md")))?.trim().to_string());
    }
    let config = folder.join("shrunk.toml");
    if !shrunk.models.is_empty() && config.is_file() {
        let text = read(&config)?;
        let settings = shrunk_settings(&text).map_err(|e| Error::file(&config, e))?;
        parts.push(format!(
            "The smaller model's experiment, `shrunk.toml` (SHA-256 `{:x}`), is the run's with these settings:",
            Sha256::digest(&text)
        ));
        parts.push(format!("```toml\n{}\n```", settings.trim()));
        return Ok(parts.join("\n\n") + "\n");
    }
    // The tables are followed by an empty line.
    Ok(parts.join("\n\n") + "\n\n")
}

/// Returns the part of a config that shrinking decides: how a sample is reduced, and the settings of the network.
fn shrunk_settings(config: &str) -> std::result::Result<String, toml::de::Error> {
    let mut config: Table = config.parse()?;
    config.retain(|key, _| key == "encoding" || key == "networks");
    if let Some(encoding) = config.get_mut("encoding").and_then(Value::as_table_mut) {
        encoding.retain(|key, _| key == "reduce");
    }
    let networks = config.get_mut("networks").and_then(Value::as_array_mut).into_iter().flatten();
    for network in networks.filter_map(Value::as_table_mut) {
        network.retain(|key, _| key != "train" && key != "published");
    }
    Ok(config.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_of_the_smaller_model_are_those_that_shrinking_decides() {
        let config = r#"
name = "t-shrunk"
[encoding.image]
kind = "raw"
[encoding.reduce]
pool = 2
[encoding.reduce.converter]
bits = 4
[[networks]]
label = "mlp"
name = "mlp"
[networks.set]
hidden = 16
[networks.train]
epochs = 20
[train]
epochs = 20
"#;
        let settings = "[encoding.reduce]\npool = 2\n\n[encoding.reduce.converter]\nbits = 4\n\n\
                        [[networks]]\nlabel = \"mlp\"\nname = \"mlp\"\n\n[networks.set]\nhidden = 16\n";
        assert_eq!(shrunk_settings(config).unwrap(), settings);
    }
}
