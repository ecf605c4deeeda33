//! Heads of `.ts` and `.arff` files: obeyed or refused.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::files;
use taxel_data::{Dataset, ReadOptions, Result, Targets, load, recordings};
use tempfile::tempdir;

const HEAD: &str = "@problemName P\n@timeStamps false\n@missing false\n@univariate false\n@dimensions 2\n@equalLength true\n\
                    @seriesLength 3\n@classLabel true a b\n@data\n";
const CASES: &str = "1,2,3:4,5,6:a\n1,2,4:4,5,7:b\n";

fn pair(ending: &str, train: &str, test: &str) -> Result<Dataset> {
    let folder = tempdir().unwrap();
    files(folder.path(), &[(&format!("P_TRAIN.{ending}"), train), (&format!("P_TEST.{ending}"), test)]);
    load(&folder.path().join("P"), &ReadOptions::default())
}

fn ts(head: &str, cases: &str) -> Result<Dataset> {
    let text = format!("{head}{cases}");
    pair("ts", &text, &text)
}

fn refused(read: Result<Dataset>) -> String {
    read.unwrap_err().to_string()
}

#[test]
fn a_ts_head_is_obeyed_or_refused() {
    assert_eq!(ts(HEAD, CASES).unwrap().x.shape(), [4, 2, 3]);
    for (from, to, why) in [
        ("@timeStamps false", "@TIMESTAMPS True", "line 2: @timeStamps true: values with time stamps"),
        (
            "@univariate false",
            "@univariate true",
            "line 10: the case has 2 channels, and the head says @univariate true",
        ),
        (
            "@dimensions 2",
            "@dimensions 3",
            "line 10: the case has 2 channels, and the head says @dimensions 3",
        ),
        (
            "@seriesLength 3",
            "@seriesLength 4",
            "line 10: the case has 3 values, and the head says @seriesLength 4",
        ),
        ("true a b", "true a c", "line 11: the class is \"b\", and @classLabel lists a, c"),
        ("@missing false", "@missing perhaps", "line 3: @missing is \"perhaps\"; write true or false"),
        ("@dimensions 2", "@dimensions two", "line 5: @dimensions is \"two\"; write a number from 1"),
        (
            "@problemName",
            "@problem",
            "line 1: @problem is no key of a head; it may have @problemName, @timeStamps",
        ),
        ("@data\n", "", "line 9: a case stands before @data"),
        (
            "@classLabel true a b",
            "@classLabel true a b\n@targetLabel true",
            "@classLabel and @targetLabel are both true",
        ),
    ] {
        let message = refused(ts(&HEAD.replace(from, to), CASES));
        assert!(message.contains("P_TRAIN.ts") && message.contains(why), "{to}: {message}");
    }
    let message = refused(ts(HEAD, "1,2,3:4,5,6:a\n@missing true\n"));
    assert!(message.contains("line 11: a line of the head (@) stands among the cases"), "{message}");
    // Unequal lengths need no length in the head; a gap at the end fills up a series.
    let unequal =
        HEAD.replace("@equalLength true", "@equalLength false").replace("@missing false", "@missing true");
    let message = refused(ts(&unequal, "1,2,?:4,5,?:a\n1,2,4:4,5,7:b\n"));
    assert!(message.contains("recordings have 2 to 3 readings"), "{message}");
}

#[test]
fn a_ts_without_classes_is_refused_to_learn_from_and_read_to_predict() {
    let head = HEAD.replace("@classLabel true a b", "@classLabel false");
    let text = format!("{head}1,2,3:4,5,6\n1,2,4:4,5,7\n");
    let message = refused(pair("ts", &text, &text));
    assert!(
        message.contains("P_TRAIN.ts: its cases have no classes") && message.contains("@classLabel true"),
        "{message}"
    );
    let folder = tempdir().unwrap();
    files(folder.path(), &[("P_TRAIN.ts", &text), ("P_TEST.ts", &text)]);
    let read = recordings(&folder.path().join("P"), &ReadOptions::default(), 2).unwrap();
    assert_eq!(read.x.shape(), [4, 2, 3]);
    let mixed = pair("ts", &text, &format!("{HEAD}{CASES}"));
    assert!(refused(mixed).contains("P_TEST.ts: its cases have classes, and those of"));
}

#[test]
fn targets_of_a_ts_are_values() {
    let head = HEAD.replace("@classLabel true a b", "@targetlabel true");
    let data = ts(&head, "1,2,3:4,5,6:0.5\n1,2,4:4,5,7:2\n").unwrap();
    let Targets::Values(values) = &data.targets else { panic!("classes") };
    assert_eq!(
        (values.quantities()[0].name.as_str(), values.values()),
        ("target", &[0.5, 2.0, 0.5, 2.0][..])
    );
    assert_eq!(data.official, Some(vec![false, false, true, true]));
    assert!(
        refused(ts(&head, "1,2,3:4,5,6:soft\n1,2,3:4,5,6:1\n"))
            .contains("the target \"soft\" is not a number")
    );
    // Without a head, numbers with fractions are values too.
    assert!(pair("tsv", "0.53\t1\t2\n1.2\t3\t4\n", "2\t5\t6\n").unwrap().targets.values().is_some());
    assert_eq!(pair("tsv", "1.0\t1\t2\n2.0\t3\t4\n", "2\t5\t6\n").unwrap().output_names(), ["1", "2"]);
}

#[test]
fn the_cells_of_plain_text_are_not_closed_up() {
    let message = refused(pair("tsv", "a\t1\t\t3\nb\t1\t2\t3\n", "a\t1\t2\t3\n"));
    assert!(message.contains("P_TRAIN.tsv: line 1, column 3: \"\" is not a number"), "{message}");
    assert_eq!(pair("txt", "a,1, 2,\nb,3,4,\n", "  a  5   6\n").unwrap().x.shape(), [3, 1, 2]);
}

fn arff(attributes: &str, cases: &str) -> Result<Dataset> {
    let text = format!("@relation P\n{attributes}@data\n{cases}");
    pair("arff", &text, &text)
}

#[test]
fn the_class_of_an_arff_is_found_wherever_it_stands() {
    let values = "@attribute t0 numeric\n@ATTRIBUTE 't 1' real\n";
    for (attributes, cases) in [
        (format!("@attribute target {{0,1}}\n{values}"), "0,1.5,2.5\n1,3,4\n"),
        (format!("{values}@attribute kind {{0, '1'}}\n"), "1.5,2.5,0\n3,4,'1'\n"),
        (
            "@attribute t0 numeric\n@attribute Label numeric\n@attribute t1 integer\n".to_owned(),
            "1.5,0,2.5\n3,1,4\n",
        ),
        (format!("@attribute class string\n{values}"), "'0',1.5,2.5\n1,3,4\n"),
    ] {
        let data = arff(&attributes, cases).unwrap();
        assert_eq!(
            (data.output_names(), data.strata().to_vec()),
            (vec!["0".into(), "1".into()], vec![0, 1, 0, 1]),
            "{attributes}"
        );
        assert_eq!(data.x.as_slice().unwrap()[..4], [1.5, 2.5, 3.0, 4.0], "{attributes}");
    }
    let relational = "@attribute activity {run,'slow walk'}\n@attribute R relational\n@attribute a numeric\n@attribute b numeric\n@end R\n";
    let data = arff(relational, "run,'1,2\\n3,4'\n'slow walk',\"5,6\\n7,8\"\n").unwrap();
    assert_eq!(
        (data.output_names(), data.x.shape()),
        (vec!["run".into(), "slow walk".into()], &[4, 2, 2][..])
    );
    // Numbers with fractions are values.
    let data = arff("@attribute target numeric\n@attribute t0 numeric\n", "0.5,1\n2,2\n").unwrap();
    assert_eq!(data.targets.values().unwrap().values(), [0.5, 2.0, 0.5, 2.0]);
}

#[test]
fn an_arff_without_one_class_is_refused_by_its_attributes() {
    let number = "@attribute t0 numeric\n";
    for (attributes, cases, why) in [
        (format!("{number}@attribute t1 numeric\n"), "1,2\n", "no attribute is the class"),
        (
            format!("@attribute a {{x}}\n@attribute b {{y}}\n{number}"),
            "x,y,1\n",
            "a, b could each be the class",
        ),
        (
            format!("@attribute object {{x}}\n@attribute class {{y}}\n{number}"),
            "x,y,1\n",
            "the class is class, and object hold no numbers",
        ),
        (
            format!("@attribute day date\n@attribute class {{y}}\n{number}"),
            "1,y,1\n",
            "the class is class, and day hold no numbers",
        ),
        (
            format!("@attribute class {{y,z}}\n{number}"),
            "y,1\nw,2\n",
            "line 6: class is \"w\", and its attribute lists y, z",
        ),
        (
            format!("@attribute class {{y,z}}\n{number}"),
            "y,1,2\n",
            "line 5: has 3 values, and there are 2 attributes",
        ),
        (format!("@attribute class {{y,z}}\n{number}"), "?,1\n", "line 5 holds no values with a class"),
        (
            format!("@attribute class {{y,z}}\n{number}@attribute odd complex\n"),
            "y,1,2\n",
            "line 4: is no attribute",
        ),
        (
            format!("@attribute class {{y,z}}\n{number}@option sparse\n"),
            "y,1\n",
            "line 4: \"@option\" is no key of a head",
        ),
        ("@attribute class {y,z}\n".into(), "y\n", "has no attribute beside the class"),
    ] {
        let message = refused(arff(&attributes, cases));
        assert!(message.contains("P_TRAIN.arff") && message.contains(why), "{message}");
    }
    let relation = "@attribute R relational\n@attribute a numeric\n@attribute b numeric\n@end R\n@attribute class {x,y}\n";
    assert!(
        refused(arff(relation, "'1,2,3',x\n"))
            .contains("a channel has 3 values, and its relation has 2 attributes")
    );
    let beside = format!("{relation}{number}");
    assert!(refused(arff(&beside, "'1,2',x,3\n")).contains("a relational attribute beside others (R, t0)"));
}

#[test]
fn a_file_without_its_partner_is_refused_by_the_missing_name() {
    let folder = tempdir().unwrap();
    let text = format!("{HEAD}{CASES}");
    files(folder.path(), &[("one/P.ts", &text), ("two/P_TRAIN.ts", &text)]);
    for (path, missing) in [
        ("one/P.ts", "P_TRAIN.ts and P_TEST.ts"),
        ("one", "P_TRAIN.ts and P_TEST.ts"),
        ("two/P_TRAIN.ts", "P_TEST.ts"),
        ("two", "P_TEST.ts"),
    ] {
        let message = refused(load(&folder.path().join(path), &ReadOptions::default()));
        assert!(message.contains(&format!("alone is no data set, and there is no {missing};")), "{message}");
    }
}
