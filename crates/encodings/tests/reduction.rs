//! Less of a sample against NumPy (`scripts/fixtures/reduction.py`), hand values, and what is refused.

#![allow(clippy::unwrap_used)]

use npyz::npz::NpzArchive;
use taxel_base::Layout;
use taxel_encodings::{Converter, Error, Reduction};

fn array(name: &str) -> (Vec<usize>, Vec<f32>) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/reduction.npz");
    let mut archive = NpzArchive::open(path).unwrap();
    let file = archive.by_name(name).unwrap().unwrap();
    (file.shape().iter().map(|&n| n as usize).collect(), file.into_vec().unwrap())
}

fn converter(bits: u32, low: f32, high: f32) -> Option<Converter> {
    Some(Converter { bits, low, high })
}

fn all() -> Reduction {
    Reduction::default()
}

#[test]
fn agrees_with_numpy() {
    let cases = [
        ("series", Layout::Series, "channels", Reduction { channels: Some(vec![4, 0, 3]), ..all() }),
        ("series", Layout::Series, "time", Reduction { window: Some(17), every: Some(4), ..all() }),
        ("series", Layout::Series, "bits", Reduction { converter: converter(3, 0.0, 5.0), ..all() }),
        (
            "image",
            Layout::Image,
            "rows",
            Reduction { rows: Some(vec![0, 2, 5]), columns: Some(vec![9, 1]), ..all() },
        ),
        ("image", Layout::Image, "pool", Reduction { pool: Some(3), ..all() }),
        (
            "image",
            Layout::Image,
            "all",
            Reduction {
                rows: Some(vec![6, 5, 1, 0]),
                pool: Some(2),
                converter: converter(4, 0.0, 255.0),
                ..all()
            },
        ),
        ("colour", Layout::Colour, "pool", Reduction { pool: Some(4), ..all() }),
        (
            "sequence",
            Layout::Sequence,
            "all",
            Reduction { window: Some(7), every: Some(3), pool: Some(2), ..all() },
        ),
        (
            "fingers",
            Layout::Fingers,
            "all",
            Reduction { channels: Some(vec![2, 0]), window: Some(6), every: Some(2), ..all() },
        ),
    ];
    for (kind, layout, what, reduction) in cases {
        let name = format!("{kind}_{what}");
        let ((shape, x), (left_shape, want)) = (array(kind), array(&name));
        let plan = reduction.plan(layout, &shape[1..]).unwrap();
        assert_eq!(plan.shape(), &left_shape[1..], "{name}");
        let mut left = vec![0.0; plan.shape().iter().product()];
        let each = x.len() / shape[0];
        for (sample, want) in x.chunks_exact(each).zip(want.chunks_exact(left.len())) {
            plan.apply(sample, &mut left).unwrap();
            for (got, want) in left.iter().zip(want) {
                assert!((got - want).abs() <= 2e-5 * want.abs().max(1.0), "{name}: {got} and {want}");
            }
        }
    }
}

#[test]
fn a_converter_has_as_many_levels_as_its_bits_say() {
    let two = Converter { bits: 2, low: -1.0, high: 2.0 };
    assert_eq!([-9.0, -0.6, -0.4, 0.4, 1.6, 7.0].map(|v| two.convert(v)), [-1.0, -1.0, 0.0, 0.0, 2.0, 2.0]);
    let one = Converter { bits: 1, low: 0.0, high: 4.0 };
    assert_eq!([1.9, 2.1].map(|v| one.convert(v)), [0.0, 4.0]);
}

#[test]
fn the_whole_stays_as_it_is() {
    let plan = all().plan(Layout::Sequence, &[2, 2, 2]).unwrap();
    let sample = [0.1, -2.0, 3.0, 4.5, 5.0, 6.0, 7.0, 8.25];
    let mut left = [0.0; 8];
    plan.apply(&sample, &mut left).unwrap();
    assert_eq!(left, sample);
    assert!(all().is_whole() && all().words() == "everything");
}

#[test]
fn one_reduction_comes_on_top_of_another() {
    let first = Reduction { window: Some(8), every: Some(2), ..all() };
    let both = first.and(Reduction { window: Some(4), channels: Some(vec![1]), ..all() });
    let wanted = Reduction { window: Some(4), every: Some(2), channels: Some(vec![1]), ..all() };
    assert_eq!(both, wanted);
    assert_eq!(both.words(), "channels 1; the first 4 readings; one reading of 2");
}

#[test]
fn what_cannot_be_is_refused_by_key() {
    let series = |reduction: Reduction| reduction.plan(Layout::Series, &[3, 10]).unwrap_err();
    for (reduction, key) in [
        (Reduction { channels: Some(vec![3]), ..all() }, "channels"),
        (Reduction { channels: Some(vec![]), ..all() }, "channels"),
        (Reduction { channels: Some(vec![1, 1]), ..all() }, "channels"),
        (Reduction { window: Some(11), ..all() }, "window"),
        (Reduction { every: Some(0), ..all() }, "every"),
        (Reduction { rows: Some(vec![0]), ..all() }, "rows"),
        (Reduction { pool: Some(2), ..all() }, "pool"),
        (Reduction { converter: converter(0, 0.0, 1.0), ..all() }, "converter.bits"),
        (Reduction { converter: converter(4, 1.0, 1.0), ..all() }, "converter.low"),
    ] {
        match series(reduction.clone()) {
            Error::Reduction(found) => assert_eq!(found.key, key, "{reduction:?}"),
            other => unreachable!("{other}"),
        }
    }
    let image = Reduction { window: Some(1), ..all() }.plan(Layout::Image, &[3, 3]).unwrap_err();
    assert_eq!(image.to_string(), "window = ..: has no meaning for an image [H, W]; leave it out");
    assert!(matches!(all().plan(Layout::Image, &[3]), Err(Error::Shape { .. })));
}
