//! As much of Markdown as the checks of words need: prose and cells, sentences, links, code, headings.

use std::collections::{BTreeMap, BTreeSet};

/// A paragraph, a list item or a table cell, with the line at which it begins.
pub struct Block {
    pub line: usize,
    pub cell: bool,
    pub text: String,
}

/// Lines with their numbers, from 1, and whether each lies in a fenced code block or is its fence.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str, bool)> {
    let mut fence: Option<&str> = None;
    text.lines().enumerate().map(move |(at, line)| {
        let bare = unlisted(line.trim());
        let mark = ["```", "~~~"].into_iter().find(|mark| bare.starts_with(mark));
        let code = match (fence, mark) {
            (Some(open), Some(close)) if open == close => {
                fence = None;
                true
            }
            (Some(_), _) => true,
            (None, Some(open)) => {
                fence = Some(open);
                true
            }
            (None, None) => false,
        };
        (at + 1, line, code)
    })
}

/// A line without the mark of a list item or of a quotation.
fn unlisted(line: &str) -> &str {
    let digits = line.len() - line.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let rest = &line[digits..];
    let marks: &[&str] = if digits == 0 { &["- ", "* ", "+ ", "> "] } else { &[". ", ") "] };
    marks.iter().find_map(|mark| rest.strip_prefix(mark)).unwrap_or(line).trim_start()
}

/// The prose and the cells of a page: code, headings, comments and HTML are left out.
pub fn blocks(text: &str) -> Vec<Block> {
    let (mut found, mut open, mut comment) = (Vec::<Block>::new(), false, false);
    for (line, raw, code) in lines(text) {
        let bare = raw.trim();
        let hidden = comment || bare.starts_with("<!--");
        comment = hidden && !bare.contains("-->");
        let rule = bare.len() > 2 && bare.chars().all(|c| "-*_=".contains(c));
        let html = bare.starts_with('<') && !bare.starts_with("<http");
        if code || hidden || rule || html || bare.is_empty() || bare.starts_with('#') {
            open = false;
        } else if bare.starts_with('|') {
            open = false;
            found.extend(cells(bare).into_iter().map(|text| Block { line, cell: true, text }));
        } else if let (true, Some(last)) = (open && unlisted(bare) == bare, found.last_mut()) {
            last.text = format!("{} {bare}", last.text);
        } else {
            open = true;
            found.push(Block { line, cell: false, text: unlisted(bare).to_string() });
        }
    }
    found
}

/// The cells of a row of a table; none of the row that only draws the line below the head.
pub fn cells(row: &str) -> Vec<String> {
    let (mut found, mut code, mut last) = (vec![String::new()], false, ' ');
    for c in row.trim().trim_matches('|').chars() {
        code ^= c == '`';
        if c == '|' && !code && last != '\\' {
            found.push(String::new());
        } else if let Some(cell) = found.last_mut() {
            cell.push(c);
        }
        last = c;
    }
    let drawn = |cell: &String| !cell.is_empty() && cell.chars().all(|c| "-: ".contains(c));
    if found.iter().all(drawn) {
        Vec::new()
    } else {
        found.iter().map(|cell| cell.trim().to_string()).collect()
    }
}

/// The text between backticks, and the text around it with `code` in its place.
fn split_code(text: &str) -> (Vec<String>, String) {
    let (mut code, mut rest) = (Vec::new(), String::new());
    let mut left = text;
    while let Some(start) = left.find('`') {
        let ticks = left[start..].len() - left[start..].trim_start_matches('`').len();
        let (mark, inner) = left[start..].split_at(ticks);
        let Some(end) = inner.find(mark) else { break };
        code.push(inner[..end].to_string());
        rest = rest + &left[..start] + "code";
        left = &inner[end + ticks..];
    }
    (code, rest + left)
}

/// Returns the texts between backticks.
pub fn code_spans(text: &str) -> Vec<String> {
    split_code(text).0
}

/// The words that a reader sees, with `code` for each piece of code, a link's words without its target, and no pictures.
pub fn plain(text: &str) -> String {
    let (_, text) = split_code(text);
    let (mut shown, mut left) = (String::new(), text.as_str());
    while let Some((before, picture, label, _, after)) = link(left) {
        shown += before;
        if !picture {
            shown += label;
        }
        left = after;
    }
    (shown + left).replace("**", "").replace("__", "")
}

/// The first link: the text before it, whether it is a picture, its label, its target and the text after it.
fn link(text: &str) -> Option<(&str, bool, &str, &str, &str)> {
    let middle = text.find("](")?;
    let end = middle + text[middle..].find(')')?;
    let start = text[..middle].rfind('[')?;
    let picture = text[..start].ends_with('!');
    let before = &text[..start - usize::from(picture)];
    Some((before, picture, &text[start + 1..middle], &text[middle + 2..end], &text[end + 1..]))
}

/// The targets of links and pictures outside of code.
pub fn targets(text: &str) -> Vec<String> {
    let (_, text) = split_code(text);
    let (mut found, mut left) = (Vec::new(), text.as_str());
    while let Some((_, _, _, target, after)) = link(left) {
        found.push(target.split_whitespace().next().unwrap_or_default().to_string());
        left = after;
    }
    found
}

/// Short forms whose point does not end a sentence.
const SHORT: [&str; 9] = ["e.g.", "i.e.", "fig.", "figs.", "al.", "vs.", "no.", "eq.", "eqs."];

/// The sentences of plain text, as their words: a point, a question mark or an exclamation mark ends one if a capital,
/// a number or code follows.
pub fn sentences(plain: &str) -> Vec<Vec<&str>> {
    let words: Vec<&str> = plain.split_whitespace().collect();
    let (mut found, mut open) = (Vec::new(), Vec::new());
    for (at, word) in words.iter().enumerate() {
        open.push(*word);
        if ends(word, words.get(at + 1)) {
            found.push(std::mem::take(&mut open));
        }
    }
    found.push(open);
    for sentence in &mut found {
        sentence.retain(|word| word.chars().any(char::is_alphanumeric));
    }
    found.retain(|sentence| !sentence.is_empty());
    found
}

fn ends(word: &str, next: Option<&&str>) -> bool {
    let core = word.trim_end_matches([')', '"', '\'', '*', '”']);
    let short = SHORT.contains(&core.trim_start_matches('(').to_lowercase().as_str());
    let initial = core.len() == 2 && core.starts_with(char::is_uppercase);
    let begins = |next: &&str| {
        let next = next.trim_start_matches(['(', '"', '\'', '*', '[', '“']);
        next.starts_with(|c: char| c.is_uppercase() || c.is_ascii_digit()) || next.starts_with("code")
    };
    core.ends_with(['.', '!', '?']) && !short && !initial && next.is_none_or(begins)
}

/// The anchors of a page's headings, as GitHub makes them.
pub fn anchors(text: &str) -> BTreeSet<String> {
    let (mut found, mut seen) = (BTreeSet::new(), BTreeMap::<String, usize>::new());
    let headings = lines(text).filter(|(_, line, code)| !code && line.starts_with('#'));
    for (_, heading, _) in headings {
        let heading = heading.trim_start_matches('#').trim().replace('`', "");
        let shown = plain(&heading).to_lowercase();
        let kept = shown.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let times = seen.entry(anchor.clone()).or_default();
        found.insert(if *times == 0 { anchor } else { format!("{anchor}-{times}") });
        *times += 1;
    }
    found
}

/// The lines of fenced code of one language, with their numbers.
pub fn fenced<'t>(text: &'t str, language: &str) -> Vec<(usize, &'t str)> {
    let (mut found, mut inside, mut before) = (Vec::new(), false, false);
    for (number, line, code) in lines(text) {
        if code && !before {
            inside = unlisted(line.trim()).trim_start_matches(['`', '~']) == language;
        } else if code && inside {
            found.push((number, line));
        }
        before = code && !(before && closes(line));
    }
    found
}

fn closes(line: &str) -> bool {
    matches!(line.trim(), "```" | "~~~")
}
