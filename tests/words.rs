//! Keeps pages, help texts and keys plain. Each rule was measured once and has one test: doc lines, cells, sentences,
//! the words of the glossary, keys, links and paths, the length of the README.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "words/comments.rs"]
mod comments;
#[path = "words/files.rs"]
mod files;
#[path = "words/markdown.rs"]
mod markdown;

use std::path::{Component, Path, PathBuf};

use comments::{Prose, comments, doc_comments};
use files::{is_ignored, root, text, with_ending};
use markdown::{anchors, blocks, cells, code_spans, fenced, plain, sentences, targets};

/// How many findings a rule lets pass, below a path: a debt that only shrinks.
type Debt = &'static [(&'static str, usize)];

/// The characters of a table cell.
const CELL: usize = 200;
/// The words of a sentence.
const SENTENCE: usize = 40;
/// The lines of the README.
const README: usize = 150;

/// Pages of `taxel-reproduction shrink` list the rows and columns of an array that were kept; only the folder of the
/// shrinking writes them anew.
const CELLS: Debt = &[("docs/results/tekscan22-shrink.md", 5)];
const SENTENCES: Debt =
    &[("docs/results/tekscan22-shrink.md", 9), ("docs/results/fsr-glove28-block-shrink.md", 1)];

/// Fails with every finding below a path that has more of them than its debt. A finding is `path:line: words`.
fn report(rule: &str, findings: &[String], debt: Debt) {
    let place = |finding: &String| debt.iter().position(|(path, _)| finding.starts_with(path));
    let mut failed: Vec<&String> = findings.iter().filter(|finding| place(finding).is_none()).collect();
    for (at, (_, most)) in debt.iter().enumerate() {
        let here: Vec<&String> = findings.iter().filter(|finding| place(finding) == Some(at)).collect();
        failed.extend(here.iter().filter(|_| here.len() > *most));
    }
    let lines: Vec<&str> = failed.iter().map(|finding| finding.as_str()).collect();
    assert!(lines.is_empty(), "{rule} ({} places):\n{}", lines.len(), lines.join("\n"));
}

/// The first words of a text, for a message.
fn start(words: &str) -> String {
    let shown: Vec<&str> = words.split_whitespace().take(12).collect();
    shown.join(" ")
}

/// The pages of the repository.
fn pages() -> Vec<String> {
    with_ending(&["md"])
}

/// The pages as prose, without the glossary, which lists the words, and the changelog, which tells what was.
fn checked_pages() -> impl Iterator<Item = Prose> {
    let pages = pages().into_iter().filter(|path| path != "docs/glossary.md" && path != "CHANGELOG.md");
    pages.map(|path| Prose { line: 1, text: text(&path), path })
}

/// A doc line says what a thing does or is: it begins with a verb or a noun.
#[test]
fn doc_lines_do_not_begin_with_what() {
    let mut found = Vec::new();
    for Prose { path, line: first, text } in
        doc_comments().into_iter().filter(|prose| prose.path.contains("/src/"))
    {
        for (at, line) in text.lines().enumerate() {
            let line = line.trim_start();
            if line.strip_prefix("What").is_some_and(|rest| !rest.starts_with(char::is_alphanumeric)) {
                found.push(format!("{path}:{}: {}", first + at, start(line)));
            }
        }
    }
    report("a doc line begins with a verb or a noun, not with \"What\"", &found, &[]);
}

/// Words at the beginning of a doc line that end like a verb and are none.
const NO_VERBS: [&str; 9] =
    ["This", "Its", "Images", "Weights", "Samples", "Names", "Values", "Lines", "Numbers"];

/// A function does something: the doc of it begins with what that is.
#[test]
fn docs_of_functions_begin_with_a_verb() {
    let mut found = Vec::new();
    for path in with_ending(&["rs"]).into_iter().filter(|path| path.contains("/src/")) {
        let all = text(&path);
        let lines: Vec<&str> = all.lines().map(str::trim).collect();
        let begins =
            |at: usize| lines[at].starts_with("///") && (at == 0 || !lines[at - 1].starts_with("///"));
        for at in (0..lines.len()).filter(|at| begins(*at)) {
            let is_about = |line: &&&str| !line.starts_with("///") && !line.starts_with("#[");
            let item = lines[at..].iter().find(is_about).map_or("", |line| *line);
            let item = item
                .strip_prefix("pub")
                .map_or(item, |rest| rest.split_once(' ').map_or("", |(_, item)| item));
            let item =
                ["const ", "unsafe "].iter().fold(item, |item, word| item.strip_prefix(word).unwrap_or(item));
            let first = lines[at].trim_start_matches('/').split_whitespace().next().unwrap_or_default();
            let first = first.trim_end_matches(',');
            let is_verb = first.len() > 2
                && first.ends_with('s')
                && first.chars().all(|c| c.is_ascii_alphabetic())
                && first.starts_with(|c: char| c.is_ascii_uppercase())
                && !NO_VERBS.contains(&first);
            if item.starts_with("fn ") && !is_verb {
                found.push(format!("{path}:{}: {}", at + 1, start(lines[at])));
            }
        }
    }
    report("the doc of a function begins with a verb: Returns, Reads, Checks", &found, &[]);
}

/// A cell is read at one glance; longer remarks go below the table.
#[test]
fn cells_are_short() {
    let mut found = Vec::new();
    for path in pages() {
        for block in blocks(&text(&path)).into_iter().filter(|block| block.cell) {
            let length = block.text.chars().count();
            if length > CELL {
                found.push(format!("{path}:{}: {length} characters: {}", block.line, start(&block.text)));
            }
        }
    }
    report(&format!("a table cell has at most {CELL} characters"), &found, CELLS);
}

/// A sentence is understood in one reading.
#[test]
fn sentences_are_short() {
    let mut found = Vec::new();
    for path in pages() {
        for block in blocks(&text(&path)) {
            for words in sentences(&plain(&block.text)).iter().filter(|words| words.len() > SENTENCE) {
                let shown = start(&words.join(" "));
                found.push(format!("{path}:{}: {} words: {shown}", block.line, words.len()));
            }
        }
    }
    report(&format!("a sentence has at most {SENTENCE} words"), &found, SENTENCES);
}

/// The words of the glossary's second table. A row with a remark in parentheses is meant in one sense alone, which no
/// program finds; all others are looked for.
fn forbidden() -> Vec<String> {
    let page = text("docs/glossary.md");
    let (_, table) = page.split_once("| do not write | write |").unwrap();
    let rows = table.lines().filter(|line| line.starts_with('|')).map(cells);
    let listed: Vec<String> = rows.filter(|row| row.len() == 2).map(|row| row[0].to_lowercase()).collect();
    let words = listed.iter().filter(|row| !row.contains('(')).flat_map(|row| row.split(", "));
    words.map(String::from).collect()
}

/// Tells whether `text` has `words` as words of their own: `x.hardened` and `broken-line` are names.
fn holds(text: &str, words: &str) -> bool {
    let inside = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    text.match_indices(words).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let mut after = text[at + words.len()..].chars();
        let name = before.is_some_and(|c| inside(c) || c == '.' || c == '/');
        let ends =
            after.next().is_none_or(|c| !inside(c) && (c != '.' || after.next().is_none_or(|c| c == ' ')));
        !name && ends
    })
}

/// One thing has one name, in pages, help texts, docs and comments.
#[test]
fn words_are_the_glossarys() {
    let (forbidden, mut found) = (forbidden(), Vec::new());
    assert!(forbidden.len() > 10, "docs/glossary.md: the second table is not read: {forbidden:?}");
    for Prose { path, line: first, text } in checked_pages().chain(doc_comments()).chain(comments()) {
        for block in blocks(&text) {
            let shown = plain(&block.text).to_lowercase();
            for words in forbidden.iter().filter(|words| holds(&shown, words)) {
                found.push(format!("{path}:{}: \"{words}\" in: {}", first + block.line - 1, start(&shown)));
            }
        }
    }
    report("docs/glossary.md says what to write instead", &found, &[]);
}

/// Keys are snake_case, in configs and in the examples of the docs.
#[test]
fn keys_are_snake_case() {
    let mut found = Vec::new();
    for path in with_ending(&["toml"]).into_iter().filter(|path| path.starts_with("configs/")) {
        let whole = text(&path);
        found.extend(whole.lines().enumerate().filter_map(|(at, line)| kebab(line, &path, at + 1)));
    }
    for path in pages() {
        let whole = text(&path);
        found.extend(fenced(&whole, "toml").into_iter().filter_map(|(line, toml)| kebab(toml, &path, line)));
    }
    report("a key is snake_case", &found, &[]);
}

/// The finding of a line of TOML with a key that has a hyphen.
fn kebab(line: &str, path: &str, number: usize) -> Option<String> {
    // Values between quotes may hold anything, and what follows `#` is a comment.
    let quoted = line.split('"').step_by(2).collect::<Vec<_>>().join("\"\"");
    let code = quoted.split('#').next().unwrap_or_default();
    let table = code.trim().strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    let header = table.filter(|_| !code.contains('='));
    let keys = code.split('=').filter(|_| code.contains('='));
    let keys = keys.map(|part| part.trim_end().rsplit([' ', '{', ',', '[']).next().unwrap_or_default());
    let mut keys = keys.take(code.matches('=').count()).chain(header);
    keys.find(|key| key.contains('-')).map(|key| format!("{path}:{number}: {key}"))
}

/// Links lead to files and headings that are there.
#[test]
fn links_lead_somewhere() {
    let mut found = Vec::new();
    for path in pages() {
        for block in blocks(&text(&path)) {
            let broken = targets(&block.text).into_iter().filter(|target| !leads(&path, target));
            found.extend(broken.map(|target| format!("{path}:{}: {target}", block.line)));
        }
    }
    report("a link leads to a file and a heading that are there", &found, &[]);
}

/// Tells whether a link of the page at `path` leads to something; links to the web are not followed.
fn leads(path: &str, target: &str) -> bool {
    if target.contains("://") || target.starts_with("mailto:") {
        return true;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let page = root().join(path);
    let place = if file.is_empty() { page } else { normal(&page.parent().unwrap().join(file)) };
    let headings = || anchors(&std::fs::read_to_string(&place).unwrap_or_default());
    place.exists() && (anchor.is_empty() || headings().contains(anchor))
}

/// The path without `..`.
fn normal(path: &Path) -> PathBuf {
    let mut found = PathBuf::new();
    for part in path.components() {
        if part == Component::ParentDir {
            found.pop();
        } else {
            found.push(part)
        }
    }
    found
}

/// Paths of the repository between backticks are there.
#[test]
fn paths_are_there() {
    let mut found = Vec::new();
    for Prose { path, line: first, text } in checked_pages().chain(doc_comments()).chain(comments()) {
        for block in blocks(&text) {
            let missing =
                code_spans(&block.text).into_iter().filter(|code| is_path(code) && !is_there(&path, code));
            found.extend(missing.map(|code| format!("{path}:{}: {code}", first + block.line - 1)));
        }
    }
    report("a path between backticks is a file or folder of the repository", &found, &[]);
}

/// Tells whether code is a path below one of the folders of the repository, without placeholders.
fn is_path(code: &str) -> bool {
    let folders = ["configs/", "crates/", "docs/", "fuzz/", "python/", "scripts/", "tests/"];
    let plain = code.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c));
    plain && folders.iter().any(|folder| code.starts_with(folder))
}

/// Tells whether a path is in the repository, or in the crate of the file that names it.
fn is_there(file: &str, path: &str) -> bool {
    let path = path.trim_end_matches('/');
    let krate: PathBuf = file.split('/').take(2).collect();
    is_ignored(path) || root().join(path).exists() || root().join(krate).join(path).exists()
}

/// The first page is read to its end.
#[test]
fn the_readme_is_short() {
    let lines = text("README.md").lines().count();
    assert!(
        lines <= README,
        "README.md has {lines} lines, at most {README}: the rest belongs on a page under docs/"
    );
}
