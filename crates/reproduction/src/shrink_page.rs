//! A result page from what `taxel shrink` wrote: its sentences, its tables, the config of the smaller model.

use std::path::Path;

use taxel::shrink::Shrunk;

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
        parts.push("The smaller model's experiment:".into());
        parts.push(format!("```toml\n{}\n```", read(&config)?.trim()));
        return Ok(parts.join("\n\n") + "\n");
    }
    // The tables are followed by an empty line.
    Ok(parts.join("\n\n") + "\n\n")
}
