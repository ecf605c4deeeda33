//! The prose of sources: doc comments of Rust, comments of configs, docstrings and comments of scripts.

use crate::files::{text, with_ending};

/// Prose as it lies in a file: lines without their marks, of which the first has this number.
pub struct Prose {
    pub path: String,
    pub line: usize,
    pub text: String,
}

/// Doc comments of the crates and of the tests.
pub fn doc_comments() -> Vec<Prose> {
    runs(with_ending(&["rs"]), |_, line| {
        line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(String::from)
    })
}

/// Comments of the configs, docstrings and comments of the scripts.
pub fn comments() -> Vec<Prose> {
    let configs = with_ending(&["toml"]).into_iter().filter(|path| path.starts_with("configs/")).collect();
    let scripts = with_ending(&["py"]).into_iter().filter(|path| path.starts_with("scripts/")).collect();
    let mut found = runs(configs, |_, line| comment(line));
    found.extend(runs(scripts, |docstring, line| {
        let quotes = line.matches("\"\"\"").count();
        let inside = *docstring || quotes > 0;
        *docstring ^= quotes == 1;
        if inside { Some(line.replace("\"\"\"", "")) } else { comment(line) }
    }));
    found
}

/// A line that is a comment.
fn comment(line: &str) -> Option<String> {
    line.strip_prefix('#').map(String::from)
}

/// Runs of lines of which `prose` makes something; it may keep one mark from line to line of a file.
fn runs(paths: Vec<String>, prose: impl Fn(&mut bool, &str) -> Option<String>) -> Vec<Prose> {
    let mut found: Vec<Prose> = Vec::new();
    for path in paths {
        let (mut mark, mut open) = (false, false);
        for (at, line) in text(&path).lines().enumerate() {
            let words = prose(&mut mark, line.trim_start());
            match (&words, found.last_mut()) {
                (Some(words), Some(last)) if open => last.text = format!("{}\n{words}", last.text),
                (Some(words), _) => {
                    found.push(Prose { path: path.clone(), line: at + 1, text: words.clone() })
                }
                (None, _) => {}
            }
            open = words.is_some();
        }
    }
    found
}
