//! Networks on images: the same bits, with rows of zeros around what convolutions read.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::images::{Size, case, graph, parts, separables, z_score};
use common::{C99, Case, Own, SAMPLE, classes, samples, values, weights};
use taxel_encodings::Scaling;
use taxel_firmware::{Encoding, Expected, Library, Method, Samples, Spread};
use taxel_graph::Graph;
use taxel_runtime::{Blueprint, Ranges};

/// Grey images, images of three colours, and such whose rows and columns differ.
const GREY: Size = [1, 16, 16];
const COLOUR: Size = [3, 12, 18];
const TALL: Size = [1, 21, 10];

/// Ways to compile C; whole numbers are compared with floats at every threshold, not at every sum.
const WAYS: [&[&str]; 4] = [
    &["-std=c99", "-Os"],
    &["-std=gnu99", "-O3", "-march=native"],
    &["-std=c99", "-O2", "-ffast-math"],
    &["-std=c99", "-O2", "-DWHOLE_ENDINGS=1"],
];

#[test]
fn light_networks_on_images_have_the_same_bits() {
    let full = Own::Scaled(Scaling::FullScale { full_scale: 255.0 });
    for (name, size, encoding) in [
        ("resnet8-lite-2d", GREY, z_score(1)),
        ("vgg6-lite-2d", COLOUR, z_score(3)),
        ("densenet6-lite-2d", TALL, full),
    ] {
        case(&graph(name, size, 3), size, encoding, classes(Some(1.3))).has_the_same_bits("cc", &WAYS);
    }
}

#[test]
fn every_operation_has_the_same_bits_on_images() {
    let raw = Own::Scaled(Scaling::Raw);
    for (of, size, encoding) in [
        (separables as fn(Size, usize) -> Graph, GREY, z_score(1)),
        (separables, COLOUR, z_score(3)),
        (parts, TALL, raw.clone()),
        (parts, COLOUR, z_score(3)),
    ] {
        case(&of(size, 3), size, encoding, classes(None)).has_the_same_bits("cc", &WAYS);
    }
    let small = case(&separables(TALL, 3), TALL, z_score(1), classes(None));
    small.has_the_same_bits("cc", &C99[4..]);
    let forces = values(Spread::LogVariance, Some(1.7));
    case(&separables(TALL, 2), TALL, raw, forces).has_the_same_bits("cc", &WAYS[..2]);
}

#[test]
fn images_have_no_push_and_say_their_size() {
    let case = case(&separables(COLOUR, 3), COLOUR, z_score(3), classes(None));
    let library = case.library();
    let files = library.files().unwrap();
    let text = |path: &str| &files.iter().find(|file| file.path == path).unwrap().text;
    let header = text("src/taxel_separables.h");
    for wanted in
        ["_CHANNELS 3u", "_ROWS 12u", "_COLUMNS 18u", "_VALUES 648u", "_RAM_BYTES ", "_FLASH_BYTES "]
    {
        assert!(header.contains(wanted), "{wanted}: {header}");
    }
    for file in &files {
        for gone in ["_push", "_ready", "_latest", "RING", "time step", "@"] {
            assert!(!file.text.contains(gone), "{}: {gone}", file.path);
        }
    }
    assert_eq!(library.size().unwrap().ring, 0);
    assert!(text("examples/SensorLoop/SensorLoop.ino").contains("taxel_separables_predict(sample, "));
}

#[test]
fn a_series_is_read_as_an_image_of_its_rows() {
    let size = [1, SAMPLE[0], SAMPLE[1]];
    let network = graph("resnet8-lite-2d", size, 3);
    let case = Case::of(&network, (samples(), SAMPLE), common::z_score(), classes(None));
    case.has_the_same_bits("cc", &WAYS[1..3]);
    let ring = case.library().size().unwrap().ring;
    assert_eq!(ring, SAMPLE[0] * SAMPLE[1], "a byte of each value");
}

#[test]
fn means_of_the_last_convolution_need_no_memory_for_its_floats() {
    let case = case(&graph("resnet8-lite-2d", GREY, 3), GREY, z_score(1), classes(None));
    let files = case.library().files().unwrap();
    let source = &files.iter().find(|file| file.path.ends_with("2d.c")).unwrap().text;
    assert!(
        source.contains("    conv_numbers(&layer_") && !source.contains("    mean_floats(&layer_"),
        "{source}"
    );
}

#[test]
fn what_has_no_c_is_refused_with_the_layer_and_a_number() {
    let refused = |name: &str, in_floats: bool| {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        let weights = weights(&graph);
        let blueprint = if in_floats {
            Blueprint::floats(&graph, &weights)
        } else {
            Blueprint::new(&graph, &weights, &Ranges::new())
        };
        let blueprint = blueprint.unwrap();
        let samples = Samples::new(1, &[[0.0, 1.0]; 5], 50);
        let encoding = (Encoding::Scaled(&Scaling::Raw), SAMPLE);
        let library = Library::new(
            name,
            Method::Network(&blueprint),
            encoding,
            classes(None),
            samples,
            Expected::default(),
        );
        library.files().unwrap_err().to_string()
    };
    let floats = refused("resnet8-lite-2d", true);
    assert!(floats.contains("in eight bits alone") && floats.contains(" bytes)"), "{floats}");
    let volume = refused("tactnet3d-4-8", false);
    assert!(
        volume.contains("only networks on series and on images") && volume.contains(" bytes in floats)"),
        "{volume}"
    );
}
