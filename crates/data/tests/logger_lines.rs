//! Lines of data loggers that are no rows: the right table comes out with a word, or an error.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{files, refused};
use taxel_data::{ReadOptions, check, load};
use tempfile::tempdir;

const ROWS: [&str; 9] = [
    "force,travel,label",
    "1.5,0.2,a",
    "2.5,0.3,b",
    "3.5,0.4,c",
    "1.6,0.2,a",
    "2.6,0.3,b",
    "3.6,0.4,c",
    "1.7,0.2,a",
    "2.7,0.3,b",
];

/// A table with lines before some of its lines.
fn with(lines: &[(usize, &str)]) -> String {
    let mut all: Vec<&str> = vec![];
    for (at, row) in ROWS.iter().enumerate() {
        all.extend(lines.iter().filter(|(before, _)| *before == at).map(|(_, line)| *line));
        all.push(row);
    }
    all.extend(lines.iter().filter(|(before, _)| *before >= ROWS.len()).map(|(_, line)| *line));
    all.join("\n") + "\n"
}

#[test]
fn a_table_is_right_without_the_lines_of_its_logger() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("t.csv");
    files(folder.path(), &[("t.csv", &with(&[]))]);
    let want = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!(want.warnings, [""; 0]);
    for (lines, words) in [
        (
            &[(0, "Logger v2.1"), (0, "Serial number 17")][..],
            "line 1 \"Logger v2.1\" and 1 more (before the table)",
        ),
        (&[(0, "Serial:17")], "line 1 \"Serial:17\" (before the table)"),
        (&[(0, "% recorded by me; with care")], "(before the table)"),
        (&[(2, "! gain 2")], "line 3 \"! gain 2\" (a comment)"),
        (&[(4, "// sensor warm, at last")], "(a comment)"),
        (&[(4, "OVERFLOW")], "line 5 \"OVERFLOW\" (a message, where readings may be lost)"),
        (&[(4, "OVERFLOW,,")], "(a message"),
        (&[(4, "force,travel,label")], "line 5 \"force,travel,label\" (the header once more)"),
        (&[(9, "Mean,0.3,")], "line 10 \"Mean,0.3,\" (a summary)"),
        (&[(9, "2.4,0.3,mean"), (9, "0.8,0.1,std")], "line 10 \"2.4,0.3,mean\" and 1 more (a summary)"),
        (&[(0, "Logger"), (3, "force,travel,label"), (9, "END")], "3 lines are no rows"),
    ] {
        for ends in ["\n", "\r\n"] {
            files(folder.path(), &[("t.csv", &with(lines).replace('\n', ends))]);
            let got = load(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{lines:?}: {e}"));
            assert_eq!((&got.x, got.digest), (&want.x, want.digest.clone()), "{lines:?}");
            let said = check(&path).unwrap().warnings.join("\n");
            assert!(said.contains("t.csv: ") && said.contains(words), "{lines:?}: {said}");
        }
    }
}

#[test]
fn what_is_not_clear_is_refused_by_its_line() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("t.csv");
    for (lines, words) in [
        (&[(4, "2.5")][..], "line 5 has 1 columns"),
        (&[(4, "2.5,0.3")], "line 5 has 2 columns"),
        (&[(4, "x,0.3,a")], "line 5, column force: \"x\" is not a number"),
        (&[(1, "N,mm,-")], "line 2, column force: \"N\" is not a number"),
        (&[(2, "OL"), (3, "OL"), (4, "OL"), (5, "OL")], "line 3 has 1 columns"),
        (&[(0, "Device,A7,")], "label"),
    ] {
        files(folder.path(), &[("t.csv", &with(lines))]);
        let message = refused(&path, &ReadOptions::default());
        assert!(message.contains(words), "{lines:?}: {message}");
    }
}

#[test]
fn recordings_in_class_folders_are_read_alike() {
    let clean = "time,thumb,index\n0,1,2\n0.01,3,4\n0.02,5,7\n0.03,7,8\n";
    let logged =
        format!("Logger v2\n{}", clean.replace("0.02", "time,thumb,index\nBUFFER FULL\n0.02")) + "Mean,4,5\n";
    let set = |text: &str| {
        let folder = tempdir().unwrap();
        let other = text.replace(",7", ",9");
        files(
            folder.path(),
            &[("a/1.csv", text), ("a/2.csv", &other), ("b/1.csv", &text.replace(",8", ",6"))],
        );
        load(folder.path(), &ReadOptions::default()).unwrap()
    };
    let (want, got) = (set(clean), set(&logged));
    assert_eq!(
        (&want.x, want.spec.rate, &want.spec.channel_names),
        (&got.x, got.spec.rate, &got.spec.channel_names)
    );
    let said = got.warnings.join("\n");
    assert!(
        said.contains("a/1.csv: 4 lines are no rows") && said.contains("(and so in 2 more files)"),
        "{said}"
    );
    // A summary is no time step of a table whose first column numbers the rows.
    let folder = tempdir().unwrap();
    let text = "id,thumb\n1,5\n2,6\n3,9\nMean,6.7\n";
    let other = text.replace('9', "8").replace("Mean", "Mean of 3");
    files(folder.path(), &[("a/1.csv", text), ("b/1.csv", &other)]);
    assert_eq!(load(folder.path(), &ReadOptions::default()).unwrap().x.shape(), [2, 1, 3]);
    // The table of labels of a folder has such lines too.
    let folder = tempdir().unwrap();
    let labels = "# by me\nfile,label\n1.csv,soft\n2.csv,hard\n";
    files(folder.path(), &[("labels.csv", labels), ("1.csv", clean), ("2.csv", &clean.replace(",7", ",9"))]);
    assert_eq!(load(folder.path(), &ReadOptions::default()).unwrap().output_names(), ["hard", "soft"]);
}
