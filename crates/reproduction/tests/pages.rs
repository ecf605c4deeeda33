//! The pages of docs/results are those that the program writes from what is kept there.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use taxel_reproduction::{Pages, claims_page, papers_page};

fn results() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/results")
}

/// A copy of the result pages and of what they are made from.
fn copied() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("reference")).unwrap();
    for part in ["", "reference"] {
        for entry in fs::read_dir(results().join(part)).unwrap() {
            let entry = entry.unwrap();
            if entry.path().is_file() {
                fs::copy(entry.path(), folder.path().join(part).join(entry.file_name())).unwrap();
            }
        }
    }
    folder
}

fn same(folder: &Path, name: &str) {
    let [found, committed] =
        [folder.join(name), results().join(name)].map(|path| fs::read_to_string(path).unwrap());
    for (line, (found, committed)) in found.lines().zip(committed.lines()).enumerate() {
        assert_eq!(found, committed, "{name}, line {}", line + 1);
    }
    assert_eq!(found, committed, "{name}");
}

#[test]
fn claims_are_drawn_as_they_are_committed() {
    let folder = copied();
    fs::remove_file(folder.path().join("claims.md")).unwrap();
    claims_page(&Pages::at(folder.path()).unwrap(), &[]).unwrap();
    same(folder.path(), "claims.md");
    same(folder.path(), "reference/claims.csv");
}

#[test]
fn tables_of_the_papers_are_drawn_as_they_are_committed() {
    let folder = copied();
    fs::remove_file(folder.path().join("papers.md")).unwrap();
    papers_page(&Pages::at(folder.path()).unwrap()).unwrap();
    same(folder.path(), "papers.md");
}

#[test]
fn a_score_that_stands_alone_on_another_page_has_to_be_there() {
    let folder = copied();
    let papers = fs::read_to_string(results().join("papers.md")).unwrap();
    // The printed network was trained on two grasps of every object, and with other numbers on deformable objects alone.
    let rows: Vec<&str> = papers.lines().filter(|line| line.starts_with("| TactNet3D |")).collect();
    let alone =
        |row: &str| row.starts_with("| TactNet3D | – | ") && !row.starts_with("| TactNet3D | – | – |");
    assert_eq!((rows.len(), rows.iter().filter(|row| alone(row)).count()), (4, 3), "{rows:?}");
    let page = folder.path().join("palpation-003-fig-7-8.md");
    let text = fs::read_to_string(&page).unwrap().replace("| TactNet3D |", "| TactNet |");
    fs::write(&page, text).unwrap();
    let error = papers_page(&Pages::at(folder.path()).unwrap()).unwrap_err().to_string();
    assert!(error.contains("palpation-003-fig-7-8.md") && error.contains("of TactNet3D"), "{error}");
}

#[test]
fn a_page_of_another_kind_of_data_is_refused() {
    let folder = copied();
    let page = folder.path().join("hardness.md");
    let text = fs::read_to_string(&page).unwrap().replace("[simulated: ", "[real: ");
    fs::write(&page, text).unwrap();
    let error = papers_page(&Pages::at(folder.path()).unwrap()).unwrap_err().to_string();
    assert!(error.contains("hardness.md: is not simulated, as papers.toml has it"), "{error}");
}
