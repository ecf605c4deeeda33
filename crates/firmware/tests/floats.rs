//! Networks in 32-bit floats: the C has the bits of the runtime, with fused products in hardware and without.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Case, classes, values, z_score};
use taxel_firmware::Spread;
use taxel_runtime::has_fused_products;

/// Ways to compile C on this computer: products fused by doubles, by the processor, and with an optimiser that likes to reorder.
const C99: [&[&str]; 3] =
    [&["-std=c99", "-Os"], &["-std=gnu99", "-O3", "-march=native"], &["-std=c99", "-O2", "-ffast-math"]];

#[test]
fn networks_in_floats_have_the_same_bits() {
    if !has_fused_products() {
        return;
    }
    for name in ["resnet8-lite-1d", "mlp", "ds-cnn-1d", "layer-norm-mlp"] {
        Case::floats(name, z_score(), classes(None)).has_the_same_bits("cc", &C99);
    }
    for name in ["densenet6-lite-1d", "vgg6-lite-1d", "dilated-resnet-1d"] {
        Case::floats(name, z_score(), classes(None)).has_the_same_bits("cc", &C99[1..2]);
    }
    let mut forces = Case::floats("resnet8-lite-1d", z_score(), values(Spread::Alike, None));
    forces.name = "values-f32".into();
    forces.has_the_same_bits("cc", &C99[1..2]);
}

#[test]
fn bytes_and_floats_go_together() {
    if has_fused_products() {
        for name in ["lstm", "layer-norm-mlp"] {
            let mut case = Case::new(name, z_score(), classes(None));
            case.name = format!("{name}-int8");
            case.has_the_same_bits("cc", &C99[1..2]);
        }
    }
}

#[test]
fn an_lstm_has_the_same_bits() {
    if has_fused_products() {
        Case::floats("lstm", z_score(), classes(None)).has_the_same_bits("cc", &C99[1..]);
    }
}
