//! The choice of labels to learn.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{files, i64s, npz, samples};
use taxel_data::{Card, Dataset, Error, Layout, ReadOptions, Task, load};
use tempfile::tempdir;

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(ToString::to_string).collect()
}

/// Four samples with levels of two attributes each.
fn two_columns() -> Dataset {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("labels.json", r#"{"classes": [["soft", "stiff"], ["low", "mid", "high"]]}"#)]);
    let y = i64s(&[4, 2], &[0, 2, 1, 0, 1, 1, 0, 2]);
    load(&npz(folder.path(), &[("x", samples(4)), ("y", y)]), &ReadOptions::default()).unwrap()
}

fn fruit() -> Dataset {
    let x = ndarray::ArrayD::from_shape_fn(ndarray::IxDyn(&[6, 2]), |at| (2 * at[0] + at[1]) as f32);
    let data = Dataset::new("fruit", Layout::Features, x, &["pear", "fig", "apple", "pear", "fig", "apple"]);
    data.unwrap().with_groups(&[1, 2, 3, 4, 5, 6]).unwrap()
}

#[test]
fn every_column_is_learned_under_its_name() {
    let mut data = two_columns();
    let before = data.clone();
    data.learn_attributes(&[]).unwrap();
    assert_eq!(data, before, "without names the class alone");
    data.learn_attributes(&names(&["elasticity", "hardness"])).unwrap();
    assert_eq!(
        data.output_names(),
        ["elasticity:soft", "elasticity:stiff", "hardness:low", "hardness:mid", "hardness:high"]
    );
    assert_eq!(data.strata().to_vec(), [0, 1, 2, 0], "combinations (0, 2), (1, 0), (1, 1)");
    assert_eq!(data.targets.labels().unwrap().values(), [0, 2, 1, 0, 1, 1, 0, 2]);
    assert_eq!(
        (data.targets.labels().unwrap().sizes(), data.targets.labels().unwrap().of(&[2, 0])),
        (vec![2, 3], vec![1, 1, 0, 2])
    );
    assert_eq!(data.targets.columns().as_ref(), Some(&data.targets.labels().unwrap()));
    assert_eq!((data.class_counts(), data.digest.as_str()), (vec![2, 2, 1, 1, 2], before.digest.as_str()));
    let part = data.select(&[2, 3]);
    assert_eq!(
        (part.targets.labels().unwrap().values(), part.strata().to_vec().as_slice()),
        ([1, 1, 0, 2].as_slice(), [1, 0].as_slice()),
        "combinations are numbered among the samples at hand"
    );
    let card = Card::new(&data);
    assert_eq!(card.classes.iter().map(|class| class.samples).collect::<Vec<_>>(), [2, 2, 1, 1, 2]);
}

#[test]
fn names_that_do_not_fit_the_columns_are_refused() {
    let mut one = fruit();
    let reason = |error: Error| match error {
        Error::LearnAttributes { reason } => reason,
        other => panic!("{other:?}"),
    };
    let message = one.learn_attributes(&names(&["kind", "size"])).map_err(reason).unwrap_err();
    assert_eq!(message, "real: fruit has one label per sample; one name makes levels of it");
    assert_eq!(one, fruit(), "unchanged");
    let mut two = two_columns();
    for list in [&["elasticity"][..], &["a", "b", "c"]] {
        let message = two.learn_attributes(&names(list)).map_err(reason).unwrap_err();
        assert_eq!(message, "real: grasps has 2 columns of labels; name each of them");
    }
    assert_eq!(two, two_columns(), "unchanged");
}

#[test]
fn one_name_makes_levels_of_classes() {
    let (mut levels, classes) = (fruit(), fruit());
    levels.learn_attributes(&names(&["ripeness"])).unwrap();
    let Task::Levels(attributes) = levels.task() else { panic!("{:?}", levels.task()) };
    assert_eq!((attributes.len(), attributes[0].name.as_str()), (1, "ripeness"));
    assert_eq!(attributes[0].classes, classes.output_names());
    assert_eq!(levels.targets.labels().unwrap().values(), classes.targets.labels().unwrap().values());
}

#[test]
fn classes_are_kept_in_the_order_asked_for() {
    let mut data = fruit();
    let before = data.clone();
    data.keep_classes(&names(&["pear", "apple"])).unwrap();
    assert_eq!(
        (data.output_names().as_slice(), data.strata().to_vec().as_slice()),
        (&names(&["pear", "apple"])[..], &[0, 1, 0, 1][..])
    );
    assert_eq!(data.targets.labels().unwrap().attributes()[0].classes, ["pear", "apple"]);
    assert_eq!(data.targets.labels().unwrap().values(), data.strata().to_vec());
    assert_eq!(data.origins, ["x[0]", "x[2]", "x[3]", "x[5]"]);
    assert_eq!(
        (data.groups.as_deref(), data.units.as_deref()),
        (Some(&[1, 3, 4, 6][..]), Some(&[0, 2, 3, 5][..]))
    );
    assert_eq!(data.x.as_slice().unwrap(), [0., 1., 4., 5., 6., 7., 10., 11.]);
    assert_eq!((data.class_counts(), data.digest), (vec![2, 2], before.digest));
}

#[test]
fn class_names_that_do_not_fit_are_refused() {
    let refuse = |data: &Dataset, list: &[&str]| match data.clone().keep_classes(&names(list)).unwrap_err() {
        Error::KeepClasses { value, reason } => (value, reason),
        other => panic!("{other:?}"),
    };
    let pair = |value: &str, reason: &str| (value.to_string(), reason.to_string());
    let data = fruit();
    assert_eq!(
        refuse(&data, &["pear", "plum"]),
        pair("\"plum\"", "no class has this name; known: apple, fig, pear")
    );
    assert_eq!(refuse(&data, &["pear", "pear"]), pair("\"pear\"", "is there twice"));
    assert_eq!(refuse(&data, &["pear"]), pair("[\"pear\"]", "needs two classes at least"));
    assert_eq!(refuse(&data, &[]), pair("[]", "needs two classes at least"));
    let mut two = two_columns();
    two.learn_attributes(&names(&["elasticity", "hardness"])).unwrap();
    let reason = "works with one class per sample; leave data.attributes out";
    assert_eq!(refuse(&two, &["elasticity:soft"]), pair("..", reason));
    assert_eq!(
        data.clone().keep_classes(&names(&["pear"])).unwrap_err().to_string(),
        "[\"pear\"]: needs two classes at least"
    );
}

#[test]
fn classes_of_one_column_of_several_are_kept_with_all_columns() {
    let mut data = two_columns();
    data.keep_classes(&names(&["stiff", "soft"])).unwrap();
    assert_eq!(
        (data.strata().to_vec().as_slice(), data.targets.columns().unwrap().values()),
        (&[1, 0, 0, 1][..], &[0, 2, 1, 0, 1, 1, 0, 2][..])
    );
}
