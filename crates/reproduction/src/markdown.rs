//! Tables of a Markdown page.

/// A table below a heading.
#[derive(Debug, PartialEq)]
pub(crate) struct MarkdownTable {
    /// The heading of second order above it.
    pub heading: String,
    /// Names of the columns.
    pub heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl MarkdownTable {
    /// Returns the last row whose first cell is `name`, as code or plain.
    pub fn row(&self, name: &str) -> Option<&[String]> {
        let named = |row: &&Vec<String>| row.first().is_some_and(|first| first.trim_matches('`') == name);
        self.rows.iter().rev().find(named).map(Vec::as_slice)
    }
}

/// Reads the tables of a page.
pub(crate) fn tables(page: &str) -> Vec<MarkdownTable> {
    let (mut found, mut heading, mut inside): (Vec<MarkdownTable>, _, _) = (vec![], String::new(), false);
    for line in page.lines() {
        if let Some(text) = line.strip_prefix("## ") {
            heading = text.into();
        }
        if !line.starts_with("| ") && !line.starts_with("|-") {
            inside = false;
            continue;
        }
        let cells: Vec<String> =
            line.trim().trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect();
        match found.last_mut().filter(|_| inside) {
            None => found.push(MarkdownTable { heading: heading.clone(), heads: cells, rows: vec![] }),
            Some(_) if line.chars().all(|c| "|-: ".contains(c)) => {}
            Some(table) => table.rows.push(cells),
        }
        inside = true;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_told_apart_by_lines_between_them() {
        let page = "## Scores\n\n| name | a |\n| --- | ---: |\n| `x` | 1 |\n\n| name | b |\n| --- | --- |\n| x | 2 |\n";
        let found = tables(page);
        let heads: Vec<&str> = found.iter().map(|table| table.heads[1].as_str()).collect();
        assert_eq!(heads, ["a", "b"]);
        assert_eq!(found[0].row("x").unwrap(), ["`x`", "1"]);
        assert_eq!((found[1].heading.as_str(), found[1].row("y")), ("Scores", None));
    }
}
