//! Numbers with a unit, a currency or separators of thousands are refused or said, and so are cells that a logger fills in.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{files, refused};
use std::fmt::Write;
use std::path::Path;
use taxel_data::{ReadOptions, TaskKind, check, load};
use tempfile::tempdir;

/// A table of a force, a second column and a label.
fn table(folder: &Path, header: &str, cell: impl Fn(usize) -> String) -> std::path::PathBuf {
    let text = (0..40).fold(format!("force,{header}\n"), |mut text, row| {
        writeln!(text, "{}.5,{}", row % 7, cell(row)).unwrap();
        text
    });
    files(folder, &[("t.csv", &text)]);
    folder.join("t.csv")
}

#[test]
fn a_column_of_decorated_numbers_beside_words_is_said() {
    for (number, hint) in [
        ("1.5 N", "a number with a unit"),
        ("45 %", "a number with a unit"),
        ("\"1,234.5\"", "separators of thousands"),
        ("$3.20", "a number with a currency"),
        ("<0.5", "a number with a sign beside it"),
    ] {
        let folder = tempdir().unwrap();
        let cell =
            |row: usize| format!("{},{}", if row.is_multiple_of(5) { "weak" } else { number }, row % 2);
        let path = table(folder.path(), "pull,label", cell);
        let said = check(&path).unwrap().warnings.join("\n");
        let plain = number.trim_matches('"');
        for part in [
            "t.csv: column \"pull\"",
            "32 of its 40 cells",
            &format!("{plain:?} (line 3)"),
            hint,
            "\"weak\" (line 2)",
        ] {
            assert!(said.contains(part), "{number}: {part}: {said}");
        }
        // A run reads the set with the same words.
        assert!(load(&path, &ReadOptions::default()).unwrap().warnings.join("\n").contains(hint));
        // Where all cells are such, the column is refused.
        let path = table(folder.path(), "pull,label", |row| format!("{number},{}", row % 2));
        assert!(refused(&path, &ReadOptions::default()).contains(hint), "{number}");
        // And a column that is no channel is not spoken of.
        let path = table(folder.path(), "pull,label", cell);
        let ignored = ReadOptions { table: "wide,ignore=pull".parse().unwrap(), ..ReadOptions::default() };
        assert_eq!(load(&path, &ignored).unwrap().warnings, [""; 0]);
    }
}

#[test]
fn labels_that_are_numbers_with_a_unit_are_said() {
    let folder = tempdir().unwrap();
    let path = table(folder.path(), "label", |row| format!("{}.5 N", row % 3));
    let said = check(&path).unwrap().warnings.join("\n");
    assert!(
        said.contains("40 labels in column \"label\" are numbers") && said.contains("measured values"),
        "{said}"
    );
    let values = ReadOptions { task: Some(TaskKind::Values), ..ReadOptions::default() };
    let message = refused(&path, &values);
    assert!(
        message.contains("is \"0.5 N\", which is no number")
            && message.contains("it is a number with a unit"),
        "{message}"
    );
    let path = table(folder.path(), "label", |row| ["cup", "can", "NaN", "-"][row % 4].into());
    let said = check(&path).unwrap().warnings.join("\n");
    assert!(said.contains("20 labels in column \"label\" say that there is none"), "{said}");
    assert!(said.contains("10 × \"-\", 10 × \"NaN\""), "{said}");
    let path = table(folder.path(), "label", |row| ["cup", "can", "none"][row % 3].into());
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().warnings, [""; 0], "no contact is a class");
}

#[test]
fn recordings_and_lines_of_json_say_it_too() {
    let folder = tempdir().unwrap();
    let row = |at: usize| format!("{}.25,{}\n", at * at % 5, if at == 2 { "weak" } else { "1.5 N" });
    let text = format!("force,pull\n{}", (0..6).map(row).collect::<String>());
    let all: Vec<(String, &str)> =
        ["a/1", "a/2", "b/1"].map(|name| (format!("{name}.csv"), text.as_str())).into();
    let named: Vec<(&str, &str)> = all.iter().map(|(name, text)| (name.as_str(), *text)).collect();
    files(folder.path(), &named);
    let said = load(folder.path(), &ReadOptions::default()).unwrap().warnings.join("\n");
    assert!(said.contains("a/1.csv: column \"pull\"") && said.contains("(and so in 2 more files)"), "{said}");
    let folder = tempdir().unwrap();
    let row = |at: usize| {
        format!(
            "{{\"force\": {}.25, \"pull\": \"{}\"}}\n",
            at * at % 5,
            if at == 2 { "weak" } else { "1.5 N" }
        )
    };
    let text = (0..6).map(row).collect::<String>();
    files(folder.path(), &[("a/1.jsonl", &text), ("b/1.jsonl", &text)]);
    let said = load(folder.path(), &ReadOptions::default()).unwrap().warnings.join("\n");
    assert!(said.contains("a/1.jsonl: key \"pull\"") && said.contains("(line 1)"), "{said}");
}

#[test]
fn cells_that_are_filled_in_are_counted() {
    let folder = tempdir().unwrap();
    let cell = |row: usize| match row {
        3 | 9 => "OL,1".into(),
        5 => ",0".into(),
        7 => "-,1".into(),
        row => format!("{row}.5,{}", row % 2),
    };
    let path = table(folder.path(), "pull,label", cell);
    let message = refused(&path, &ReadOptions::default());
    let want = "line 5, column pull: \"OL\" is not a number";
    assert!(message.starts_with(&format!("t.csv: {want}")), "{message}");
    let counted = "; 4 cells of this column are filled in: 2 × \"OL\", 1 empty, 1 × \"-\"";
    assert!(message.ends_with(counted), "{message}");
    // As numbers that are none, at the end of recordings and within.
    let folder = tempdir().unwrap();
    let text = "force,pull\n1,2\n3,4\nNaN,NaN\nnan,nan\n";
    files(folder.path(), &[("a/1.csv", text), ("b/1.csv", &text.replace('3', "5"))]);
    let length = ReadOptions { length: Some("crop:2".parse().unwrap()), ..ReadOptions::default() };
    let data = load(folder.path(), &length).unwrap();
    assert_eq!(data.x.shape(), [2, 2, 2]);
    let said = data.warnings.join("\n");
    assert!(
        said.contains("a/1.csv: 4 cells are NaN, the first in line 4") && said.contains("1 more file"),
        "{said}"
    );
}
