//! The axes of a raw sample: names, shapes, words.

#![allow(clippy::unwrap_used)]

use taxel_base::Layout;

/// Each layout with its name, a shape that it has, and its axes in words.
const TABLE: [(Layout, &str, &[usize], &str); 6] = [
    (Layout::Features, "features", &[7], "features"),
    (Layout::Series, "series", &[5, 50], "channels × time"),
    (Layout::Image, "image", &[28, 50], "rows × columns"),
    (Layout::Colour, "colour", &[3, 24, 32], "colours × rows × columns"),
    (Layout::Sequence, "sequence", &[10, 14, 25], "time × rows × columns"),
    (Layout::Fingers, "fingers", &[2, 23, 450], "fingers × channels × time"),
];

#[test]
fn names_are_the_same_in_words_and_in_json() {
    assert_eq!(Layout::ALL.to_vec(), TABLE.map(|row| row.0));
    for (layout, name, shape, axes) in TABLE {
        assert_eq!((layout.to_string().as_str(), layout.name(), layout.axes()), (name, name, axes));
        assert_eq!(name.parse::<Layout>().unwrap(), layout);
        let json = serde_json::to_string(&layout).unwrap();
        assert_eq!(json, format!("\"{name}\""));
        assert_eq!(serde_json::from_str::<Layout>(&json).unwrap(), layout);
        assert_eq!(layout.axes().split(" × ").count(), layout.rank());
        assert_eq!(shape.len(), layout.rank());
    }
    assert_eq!(
        "Series".parse::<Layout>().unwrap_err().to_string(),
        "there is no layout `Series`; did you mean `series`? known: features, series, image, colour, sequence, fingers"
    );
}

#[test]
fn a_shape_fits_by_its_axes_and_three_planes_of_colour() {
    for (layout, _, axes, _) in TABLE {
        for (other, _, shape, _) in TABLE {
            let planes = layout != Layout::Colour || shape[0] == 3;
            assert_eq!(
                layout.fits(shape),
                axes.len() == shape.len() && planes,
                "{layout}: {shape:?} of {other}"
            );
        }
    }
    assert!(!Layout::Colour.fits(&[4, 24, 32]), "three planes");
    assert!(Layout::Sequence.fits(&[3, 24, 32]) && !Layout::Features.fits(&[]));
}

#[test]
fn time_and_area_are_those_of_the_axes() {
    for (layout, _, shape, axes) in TABLE {
        let time = axes.split(" × ").position(|axis| axis == "time");
        assert_eq!(layout.time_axis(), time, "{layout}");
        assert_eq!(layout.has_time(), time.is_some() || layout == Layout::Features, "{layout}");
        assert_eq!(layout.has_area(), axes.contains("rows × columns"), "{layout}");
        let letters = layout.describe().split(['[', ']']).nth(1).unwrap();
        assert_eq!(letters.split(", ").count(), shape.len(), "{}", layout.describe());
    }
}
