//! Sets as they lie in folders: archives by their folder, tables of labels, sessions, junk; sound and broken.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::files;
use std::path::Path;
use taxel_data::{ReadOptions, check, load, recordings};
use tempfile::{TempDir, tempdir};

fn refused(root: &Path, options: &ReadOptions) -> String {
    let message = load(root, options).unwrap_err().to_string();
    message.replace(&format!("{}/", root.display()), "").replace(&root.display().to_string(), "FOLDER")
}

fn with(list: &[(&str, &str)]) -> TempDir {
    let folder = tempdir().unwrap();
    files(folder.path(), list);
    folder
}

/// Utterances of unequal length as the archive's JapaneseVowels has them.
const VOWELS: &str = "#Note\n@problemName Vowels\n@timestamps false\n@univariate false\n@dimensions 2\n\
                      @equalLength false\n@classLabel true 1 2\n@data\n1.5,2.5,3.5:4,5,6:1\n-1,0:2e-1,3:2\n";

#[test]
fn a_ts_pair_of_unequal_lengths_is_read_by_its_folder() {
    let root =
        with(&[("Vowels/Vowels_TRAIN.ts", VOWELS), ("Vowels/Vowels_TEST.ts", "@data\n1,2,3,4:5,6,7,8:2\n")]);
    let folder = root.path().join("Vowels");
    assert!(refused(&folder, &ReadOptions::default()).contains("recordings have 2 to 4 readings"));
    let options = ReadOptions { length: Some("crop:2,end".parse().unwrap()), ..ReadOptions::default() };
    let data = load(&folder, &options).unwrap();
    assert_eq!((data.name.as_str(), data.x.shape()), ("Vowels", &[3, 2, 2][..]));
    assert_eq!(data.x.as_slice().unwrap()[..4], [2.5, 3.5, 5.0, 6.0]);
    assert_eq!((data.strata().to_vec(), data.official), (vec![0, 1, 1], Some(vec![false, false, true])));
    // By the path without ending as well, and from a folder of another name.
    let same = load(&folder.join("Vowels"), &options).unwrap();
    assert_eq!(same.digest, data.digest);
    std::fs::rename(&folder, root.path().join("download")).unwrap();
    let moved = load(&root.path().join("download"), &options).unwrap();
    assert_eq!((moved.name, moved.digest), ("Vowels".into(), data.digest));
    // Two sets in one folder are none.
    files(root.path(), &[("download/Other_TRAIN.ts", VOWELS), ("download/Other_TEST.ts", VOWELS)]);
    assert!(refused(&root.path().join("download"), &options).starts_with("FOLDER: holds neither"));
}

#[test]
fn padded_tsv_is_of_unequal_length() {
    let root = with(&[("P/P_TRAIN.tsv", "1\t1\t2\tNaN\n2\t1\t2\t3\n"), ("P/P_TEST.tsv", "1\t5\tNaN\tNaN\n")]);
    let options = ReadOptions { length: Some("pad:3,edge".parse().unwrap()), ..ReadOptions::default() };
    let data = load(&root.path().join("P"), &options).unwrap();
    assert_eq!(data.x.as_slice().unwrap(), [1., 2., 2., 1., 2., 3., 5., 5., 5.]);
}

#[test]
fn arff_is_flat_or_relational() {
    let flat = "% note\n@relation Flat\n@attribute a1 numeric\n@attribute a2 numeric\n@attribute target {1,2}\n\n@DATA\n\
                1.5,2.5,1\n-3,4e1,2\n";
    let root = with(&[("Flat/Flat_TRAIN.arff", flat), ("Flat/Flat_TEST.arff", "@data\n5,6,'2'\n")]);
    let data = load(&root.path().join("Flat"), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.strata().to_vec().as_slice()), (&[3, 1, 2][..], &[0, 1, 1][..]));
    assert_eq!(data.x.as_slice().unwrap(), [1.5, 2.5, -3.0, 40.0, 5.0, 6.0]);

    let relational = "@relation R\n@attribute R relational\n@attribute att0 numeric\n@attribute att1 numeric\n@attribute att2 numeric\n@end R\n\
                      @attribute class {run,walk}\n@data\n'1,2,3\\n4,5,6',run\n\"7,8,?\\n9,10,?\",walk\n";
    let root = with(&[("R_TRAIN.arff", relational), ("R_TEST.arff", "@data\n'1,1,1\\n2,2,2',walk\n")]);
    assert!(refused(root.path(), &ReadOptions::default()).contains("recordings have 2 to 3 readings"));
    let options = ReadOptions { length: Some("crop:2".parse().unwrap()), ..ReadOptions::default() };
    let data = load(root.path(), &options).unwrap();
    assert_eq!(data.x.as_slice().unwrap(), [1., 2., 4., 5., 7., 8., 9., 10., 1., 1., 2., 2.]);
    assert_eq!(
        (data.output_names(), data.strata().to_vec()),
        (vec!["run".into(), "walk".into()], vec![0, 1, 1])
    );

    let message = |train: &str| {
        let root = with(&[("B_TRAIN.arff", train), ("B_TEST.arff", "@data\n1,2,a\n")]);
        refused(root.path(), &ReadOptions::default())
    };
    assert!(message("1,2,a\n").contains("B_TRAIN.arff: holds no samples"), "no @data");
    assert!(message("@data\n1,x,a\n").contains("B_TRAIN.arff: line 2, column 2: \"x\" is not a number"));
    for line in ["1.5", "'1,2", "'1,2'", "'1,2'a", "1,2,", "'1,2',"] {
        let message = message(&format!("@data\n{line}\n"));
        assert!(message.contains("B_TRAIN.arff: line 2 holds no values with a class"), "{line}: {message}");
    }
    assert!(message("@data\n{0 1, 1 2},a\n").contains("is not a number"), "sparse");
    assert!(message("@data\n1,?,a\n?,2,a\n").contains("value at [0, 0] is NaN"), "a gap");
    assert!(message("@data\n'1,2\\n3',a\n").contains("its channels have [2, 1] values"));
}

#[test]
fn a_table_says_label_and_group_of_each_file() {
    let table = "\u{feff}file, label, group, note\nraw/t10.csv, soft, day1,\nt2.csv, stiff, day2, twice\n./t3.csv,soft,day1,\n";
    let root = with(&[
        ("labels.csv", table),
        ("raw/t10.csv", "1,2\n3,4\n"),
        ("t2.csv", "5,6\n7,8\n"),
        ("t3.csv", "9,8\n7,6\n"),
        ("t4.csv", "not listed"),
        (".DS_Store", "x"),
    ]);
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.output_names().as_slice(), data.strata().to_vec().as_slice()),
        (&["soft", "stiff"].map(String::from)[..], &[0, 1, 0][..])
    );
    assert_eq!((data.groups.as_deref(), data.group_name.as_deref()), (Some(&[0, 1, 0][..]), Some("group")));
    assert_eq!(data.origins, ["raw/t10.csv", "t2.csv", "t3.csv"]);
    let card = check(root.path()).unwrap();
    assert_eq!(card.ignored, [".DS_Store", "t4.csv"]);
    assert!(card.to_string().contains("ignored     .DS_Store, t4.csv"), "{card}");
    // The order of the classes, and facts; the table's order of recordings stays.
    files(root.path(), &[("labels.json", r#"{"classes": ["stiff", "soft"], "rate": 50}"#)]);
    let ordered = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(
        (ordered.output_names().join(" "), ordered.strata().to_vec()),
        ("stiff soft".to_string(), vec![1, 0, 1])
    );
    assert_eq!((ordered.spec.rate, ordered.origins), (Some(50.0), data.origins));
    assert_eq!(check(root.path()).unwrap().ignored, [".DS_Store", "t4.csv"], "it is read");
    std::fs::remove_file(root.path().join("labels.json")).unwrap();
    // Other columns by name.
    let options =
        ReadOptions { y: Some("note".into()), group: Some("label".into()), ..ReadOptions::default() };
    assert!(refused(root.path(), &options).contains("labels.csv: line 2: note is empty"));
    let read = recordings(root.path(), &ReadOptions::default(), 2).unwrap();
    assert_eq!(read.truth.unwrap(), [["soft"], ["stiff"], ["soft"]]);
    for (table, why) in [
        ("", "labels.csv: is empty (0 bytes)"),
        ("file,label\n", "labels.csv: has no rows; write a first line file,label or"),
        ("t2.csv,soft\n", "labels.csv: has no column file: its first line is [\"t2.csv\", \"soft\"]"),
        ("file,class\nt2.csv,soft\n", "has no column label: its first line is [\"file\", \"class\"]"),
        ("file,label\nt9.csv,soft\n", "line 2: there is no file \"t9.csv\" in the folder"),
        ("file,label\n../t2.csv,soft\n", "line 2: file is \"../t2.csv\"; give a path below the folder"),
        ("file,label\n/etc/hosts,soft\n", "line 2: file is \"/etc/hosts\"; give a path below"),
        ("file,label\n,soft\n", "line 2: file is \"\"; give a path below the folder"),
        ("file,label\nraw,soft\n", "line 2: there is no file \"raw\""),
        ("file,label\nt2.csv,soft\n./t2.csv,stiff\n", "lines 2 and 3 are both \"./t2.csv\""),
        ("file,label\nt2.csv,\n", "line 2: label is empty"),
        ("file,label,group\nt2.csv,a,\n", "line 2: group is empty"),
        ("file,label\nt2.csv\n", "labels.csv: is not readable as CSV"),
        ("file,label\nt2.csv,a\nt4.csv,b\n", "t4.csv: holds a header but no rows"),
    ] {
        files(root.path(), &[("labels.csv", table)]);
        let message = refused(root.path(), &ReadOptions::default());
        assert!(message.contains(why), "{table:?}: {message}");
    }
    std::fs::write(root.path().join("labels.csv"), [b'f', 0xFF]).unwrap();
    assert!(refused(root.path(), &ReadOptions::default()).contains("labels.csv: line 1 holds the byte"));
}

#[test]
fn folders_in_class_folders_are_sessions() {
    let root = with(&[
        ("soft/day1/take2.csv", "1\n2\n"),
        ("soft/day1/take10.csv", "3\n4\n"),
        ("soft/day2/take1.csv", "5\n6\n"),
        ("stiff/day2/take1.csv", "7\n8\n"),
        ("stiff/day2/Thumbs.db", "x"),
        ("stiff/.hidden", "x"),
        ("__MACOSX/soft/x.csv", "x"),
        ("README.md", "x"),
        ("soft/take~", "x"),
    ]);
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    let origins =
        ["soft/day1/take2.csv", "soft/day1/take10.csv", "soft/day2/take1.csv", "stiff/day2/take1.csv"];
    assert_eq!(data.origins, origins);
    // The second day of one class is that of the other.
    assert_eq!(
        (data.groups.as_deref(), data.group_name.as_deref()),
        (Some(&[0, 0, 1, 1][..]), Some("session"))
    );
    assert_eq!(data.output_names(), ["soft", "stiff"]);
    let mut ignored = check(root.path()).unwrap().ignored;
    ignored.sort();
    assert_eq!(ignored, ["README.md", "__MACOSX", "soft/take~", "stiff/.hidden", "stiff/day2/Thumbs.db"]);
    let blocks = ReadOptions { group_block: Some(2), ..ReadOptions::default() };
    assert!(refused(root.path(), &blocks).contains("group_block: divides the positions"));
    files(root.path(), &[("other/take1.csv", "1\n2\n")]);
    assert_eq!(
        refused(root.path(), &ReadOptions::default()),
        "other/take1.csv: lies right in its class folder while others lie in a session; use one of the two"
    );
    files(root.path(), &[("other/day1/take1.csv", "1\n2\n")]);
    assert!(
        refused(root.path(), &ReadOptions::default()).starts_with("other/day1: a folder where recordings")
    );
    std::fs::remove_file(root.path().join("other/take1.csv")).unwrap();
    std::fs::remove_file(root.path().join("other/day1/take1.csv")).unwrap();
    assert_eq!(
        refused(root.path(), &ReadOptions::default()),
        "other/day1: class folder holds no files; fill or remove it"
    );
}
