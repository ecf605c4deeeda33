//! Compiles exported networks on this computer and compares bits: of 200 samples, and of every threshold of every layer.
//! The tests of the workspace need a C compiler anyway (zstd is C).
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{C99, Case, Own, classes, z_score};
use taxel_encodings::Scaling;

fn same_bits(compiler: &str, cases: &[(&str, Own, Option<f64>)], flags: &[&[&str]]) {
    for (name, encoding, temperature) in cases {
        Case::new(name, encoding.clone(), classes(*temperature)).has_the_same_bits(compiler, flags);
    }
}

#[test]
fn small_networks_have_the_same_bits() {
    let full = Own::Scaled(Scaling::FullScale { full_scale: 1023.0 });
    same_bits(
        "cc",
        &[
            ("mlp", z_score(), None),
            ("mlp", full.clone(), Some(0.6)),
            ("resnet8-lite-1d", z_score(), Some(1.7)),
            ("resnet8-lite-1d", Own::Scaled(Scaling::Raw), None),
            ("ds-cnn-1d", full, None),
        ],
        &C99,
    );
}

#[test]
fn wide_networks_have_the_same_bits() {
    same_bits(
        "cc",
        &[
            ("vgg6-lite-1d", z_score(), None),
            ("densenet6-lite-1d", z_score(), None),
            ("dilated-resnet-1d", z_score(), Some(2.1)),
            ("fcn-1d", z_score(), None),
        ],
        &C99,
    );
}

#[test]
#[ignore = "needs a C++ compiler"]
fn the_code_is_cpp_as_well() {
    let flags: [&[&str]; 1] = [&["-x", "c++", "-std=c++17", "-O2"]];
    same_bits(
        "c++",
        &[("resnet8-lite-1d", z_score(), Some(1.7)), ("densenet6-lite-1d", z_score(), None)],
        &flags,
    );
}
