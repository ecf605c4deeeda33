//! Doc comments as texts for people who write configs.

/// Returns a doc comment as one line without links of rustdoc: `[Loss::Huber]` in backticks is `Huber`.
pub(super) fn plain(text: &str) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut rest = text.as_str();
    let mut found = String::new();
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((name, tail)) = after.split_once("`]") else { break };
        let name = name.strip_prefix("field@").unwrap_or(name);
        found.push_str(before);
        found.push_str(&format!("`{}`", name.rsplit("::").next().unwrap_or(name)));
        let target = tail.strip_prefix('(').and_then(|tail| tail.split_once(')'));
        rest = target.map_or(tail, |(_, after)| after);
    }
    found + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_become_names() {
        assert_eq!(plain("as\n[`a::B`](x::y) and [`C`], `[N, C]` stay"), "as `B` and `C`, `[N, C]` stay");
    }
}
