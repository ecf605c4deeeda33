//! The list of readers and the table in `docs/data.md` say the same.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use taxel_data::{Format, ReadOptions, formats};

/// A row as the page has it: a format without endings is a folder.
fn row(format: &Format) -> String {
    let endings: Vec<String> = format.endings.iter().map(|ending| format!("`.{ending}`")).collect();
    let endings = if endings.is_empty() { "–".into() } else { endings.join(", ") };
    format!("| {} | {endings} | {} | {} |", format.name, format.holds, format.becomes)
}

#[test]
fn the_page_has_a_row_for_every_format() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/data.md");
    let text = fs::read_to_string(page).unwrap();
    let head = "| what | files | how it lies | becomes |\n|---|---|---|---|\n";
    let table = text.split(head).nth(1).and_then(|rest| rest.split("\n\n").next()).unwrap();
    let wanted: Vec<String> = formats().map(row).collect();
    for format in formats() {
        let longest = format.holds.len().max(format.becomes.len());
        assert!(
            longest <= 200,
            "{}: a cell of {longest} characters; the rest goes below the table",
            format.name
        );
    }
    let found: Vec<&str> = table.trim_end().lines().collect();
    assert_eq!(found, wanted, "docs/data.md: the table should be\n{head}{}\n", wanted.join("\n"));
}

/// The options in the table of `docs/data.md` are read as they stand there.
#[test]
fn options_of_values_are_in_the_docs_as_they_are_written() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/data.md");
    let text = fs::read_to_string(page).unwrap();
    let (_, table) = text.split_once("| in `[data]` | flag | means |").unwrap();
    let rows: Vec<&str> = table.lines().skip(2).take_while(|line| line.starts_with('|')).collect();
    assert_eq!(rows.len(), 8);
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        let (key, value) = cells[1].split_once(" = ").unwrap();
        let options: ReadOptions = serde_json::from_str(&format!("{{\"{key}\": {value}}}")).unwrap();
        assert_ne!(options, ReadOptions::default(), "{row}");
        assert_eq!(cells[2], format!("--{key}"));
    }
}
