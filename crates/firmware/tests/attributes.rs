//! One class of each of several attributes: the same bits.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::attributes::attributes;
use common::{C99, Case, z_score};
use taxel_firmware::Shares;

#[test]
fn attributes_have_the_same_bits() {
    for shares in [Shares::Sigmoid, Shares::Ordered, Shares::Cut] {
        for temperature in [None, Some(1.6)] {
            Case::new("mlp", z_score(), attributes(shares, temperature)).has_the_same_bits("cc", &C99[1..]);
        }
    }
}

#[test]
fn probabilities_of_attributes_follow_each_other() {
    let case = Case::new("mlp", z_score(), attributes(Shares::Ordered, None));
    let files = case.library().files().unwrap();
    let text = |path: &str| &files.iter().find(|file| file.path == path).unwrap().text;
    let header = text("src/taxel_mlp.h");
    for wanted in ["_CLASSES 5u", "_ATTRIBUTES 2u", "_CLASSES_0 2u /* \"shore\" * / */", "_CLASSES_1 3u"] {
        assert!(header.contains(wanted), "{wanted}: {header}");
    }
    assert!(text("src/taxel_mlp.c").contains("attribute_classes[TAXEL_MLP_ATTRIBUTES] = {2u, 3u};"));
    assert!(text("README.md").contains("| attributes | 2: \"shore\" * / (5, 10); größe (s, m?, l) |"));
    // Each attribute's shares are its own.
    for row in case.expected.answers.chunks(5) {
        assert!(
            (row[..2].iter().sum::<f32>() - 1.0).abs() < 1e-5
                && (row[2..].iter().sum::<f32>() - 1.0).abs() < 1e-5
        );
    }
}
