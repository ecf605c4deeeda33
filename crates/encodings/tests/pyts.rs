//! Twins: pyts makes the same fields, matplotlib the same colours (`scripts/fixtures/gadf.py`).

use ndarray::{Array1, Array2, Array3, Axis};
use npyz::npz::NpzArchive;
use taxel_encodings::{Colormap, Gaf, HardnessImage, Method, Range};

/// Largest difference between float32 and another order of summation.
const TOLERANCE: f32 = 1e-5;

const FIXED: Range = Range::Fixed { low: 0.0, high: 1023.0 };

fn array<T: npyz::Deserialize>(name: &str) -> std::io::Result<Vec<T>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gadf.npz");
    let mut archive = NpzArchive::open(path)?;
    let file = archive.by_name(name)?;
    file.ok_or_else(|| std::io::Error::other(format!("no {name} in {path}")))?.into_vec()
}

fn assert_close(what: &str, got: impl IntoIterator<Item = f32>, want: &[f32], bound: f32) {
    let got: Vec<f32> = got.into_iter().collect();
    assert_eq!(got.len(), want.len(), "{what}: length");
    for (at, (got, want)) in got.iter().zip(want).enumerate() {
        // Written as "within" so that NaN fails.
        assert!((got - want).abs() <= bound, "{what}[{at}]: got {got}, want {want}");
    }
}

#[test]
fn fields_are_those_of_pyts() {
    for (length, size) in [(250, 50), (173, 50), (64, 64), (50, 7), (58, 50)] {
        let series = Array1::from_vec(array::<f32>(&format!("series_{length}")).unwrap());
        for (method, method_name) in [(Method::Difference, "difference"), (Method::Summation, "summation")] {
            for (range, range_name) in [(Range::PerSample, "per-sample"), (FIXED, "fixed")] {
                let name = format!("{length}_{size}_{method_name}_{range_name}");
                let gaf = Gaf { size, method, range, ..Gaf::default() };
                let field = gaf.encode(series.view()).unwrap();
                let rows: Vec<usize> =
                    array::<i64>(&format!("rows_{name}")).unwrap().iter().map(|&r| r as usize).collect();
                let got = field.select(Axis(0), &rows);
                assert_close(&name, got, &array(&format!("field_{name}")).unwrap(), TOLERANCE);
            }
        }
    }
}

#[test]
fn colours_are_those_of_matplotlib() {
    let values = array::<f32>("values").unwrap();
    let field = Array2::from_shape_vec((1, values.len()), values).unwrap();
    for (colormap, name) in [(Colormap::Jet, "jet"), (Colormap::Viridis, "viridis")] {
        let image = colormap.apply(&field).unwrap();
        let got = image.index_axis(Axis(1), 0).t().iter().copied().collect::<Vec<_>>();
        assert_close(name, got, &array(name).unwrap(), 1e-6);
    }
}

#[test]
fn the_image_of_a_grasp_is_the_coloured_field_of_its_flattened_rows() {
    let grasp = Array2::from_shape_vec((5, 50), array::<f32>("series_250").unwrap()).unwrap();
    let field = array::<f32>("field_250_50_difference_per-sample").unwrap();
    let grey = HardnessImage { colormap: Colormap::Grey, ..HardnessImage::default() };
    let want: Vec<f32> = field.iter().map(|v| (v + 1.0) / 2.0).collect();

    assert_close("grey", grey.encode(grasp.view()).unwrap(), &want, TOLERANCE);
    // Column-major memory must not change what a row is.
    let columns = grasp.t().as_standard_layout().into_owned();
    assert_close("other layout", grey.encode(columns.t()).unwrap(), &want, TOLERANCE);

    let jet = HardnessImage::default();
    let field = jet.gaf.encode(grasp.flatten().view()).unwrap();
    let image: Array3<f32> = jet.encode(grasp.view()).unwrap();
    assert_eq!(image.shape(), jet.shape());
    assert_eq!(image, Colormap::Jet.apply(&field).unwrap());
}
