//! The guard against NumPy (`scripts/fixtures/guard.py`): what it learns, what it finds, what becomes of samples.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use ndarray::ArrayD;
use npyz::npz::NpzArchive;
use serde_json::Value;
use taxel_guard::{BrokenKind, Guard, KnownRange, Layout, Watch};

fn array(case: &str, part: &str) -> ArrayD<f32> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/guard.npz");
    let mut archive = NpzArchive::open(path).unwrap();
    let file = archive.by_name(&format!("{case}_{part}")).unwrap().unwrap();
    let shape: Vec<usize> = file.shape().iter().map(|&n| n as usize).collect();
    ArrayD::from_shape_vec(shape, file.into_vec().unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn close(got: f64, want: f32, what: &str) {
    let want = f64::from(want);
    assert!((got - want).abs() <= 1e-4 * want.abs().max(1e-3), "{what}: {got} and {want}");
}

/// Values of each element: a list may hold one for all.
fn close_lists(got: &Value, want: &[f32], what: &str) {
    let got = numbers(got);
    for (i, want) in want.iter().enumerate() {
        close(got[if got.len() == 1 { 0 } else { i }], *want, &format!("{what} of {i}"));
    }
}

#[test]
fn agrees_with_numpy() {
    for layout in Layout::ALL {
        let case = layout.name();
        let [train, test, mended] = ["train", "test", "mended"].map(|part| array(case, part));
        let guard = Guard::fit(train.view(), layout, &KnownRange::default()).unwrap();
        let said = serde_json::to_value(&guard).unwrap();
        let constant: Vec<usize> = said["constant"]
            .as_array()
            .map_or(vec![], |all| all.iter().map(|number| number.as_u64().unwrap() as usize).collect());
        let [bounds, shares] = ["bounds", "shares"].map(|part| array(case, part));
        let count = guard.elements();
        for kind in 0..BrokenKind::ALL.len() {
            for (name, table) in [("bounds", &bounds), ("shares", &shares)] {
                let table = table.as_slice().unwrap();
                for element in (0..count).filter(|element| !constant.contains(element)) {
                    let list = numbers(&said[name][kind]);
                    let got = list[if list.len() == 1 { 0 } else { element }];
                    close(got, table[kind * count + element], &format!("{case}: {name} {kind} of {element}"));
                }
            }
        }
        if !layout.has_area() {
            let scale = array(case, "scale");
            let varying: Vec<f32> = scale
                .iter()
                .copied()
                .enumerate()
                .filter(|(i, _)| !constant.contains(i))
                .map(|(_, s)| s)
                .collect();
            let scale: Vec<f64> = numbers(&said["scale"]);
            let scale: Vec<Value> = scale
                .into_iter()
                .enumerate()
                .filter(|(i, _)| !constant.contains(i))
                .map(|(_, s)| s.into())
                .collect();
            close_lists(&scale.into(), &varying, &format!("{case}: scale"));
            let links: Vec<[f64; 4]> = said["links"]
                .as_array()
                .unwrap()
                .iter()
                .enumerate()
                .flat_map(|(i, links)| {
                    let link = move |link: &Value| {
                        [
                            i as f64,
                            link["from"].as_f64().unwrap(),
                            link["offset"].as_f64().unwrap(),
                            link["slope"].as_f64().unwrap(),
                        ]
                    };
                    links.as_array().unwrap().iter().map(link).collect::<Vec<_>>()
                })
                .collect();
            let want = array(case, "links");
            assert_eq!(links.len(), want.len() / 4, "{case}");
            for (got, want) in links.iter().flatten().zip(&want) {
                close(*got, *want, &format!("{case}: links"));
            }
        }
        let mut watch = Watch::new(Arc::new(guard));
        let mut found = vec![];
        for (at, (test, mended)) in test.outer_iter().zip(mended.outer_iter()).enumerate() {
            let mut sample: Vec<f32> = test.iter().copied().collect();
            let of = |replaced: &taxel_guard::ReplacedElement| {
                let kind = BrokenKind::ALL.iter().position(|kind| *kind == replaced.kind).unwrap();
                [at as f32, replaced.element as f32, kind as f32]
            };
            found.extend(watch.mend(&mut sample).iter().flat_map(of));
            for (got, want) in sample.iter().zip(&mended) {
                assert!((got - want).abs() <= 1e-3 * want.abs().max(1.0), "{case} {at}: {got} and {want}");
            }
        }
        assert_eq!(found, array(case, "found").into_raw_vec_and_offset().0, "{case}");
    }
}

#[test]
fn the_fit_comes_back_from_a_file_bit_for_bit_and_a_damaged_one_is_refused() {
    for layout in Layout::ALL {
        let train = array(layout.name(), "train");
        let guard = Guard::fit(train.view(), layout, &KnownRange::default()).unwrap();
        let text = serde_json::to_string(&guard).unwrap();
        assert_eq!(serde_json::from_str::<Guard>(&text).unwrap(), guard);
        guard.check(layout, &train.shape()[1..]).unwrap();
        let mut other = train.shape()[1..].to_vec();
        other[0] += 1;
        assert!(guard.check(layout, &other).unwrap_err().starts_with("the guard is of "));
        let value: Value = serde_json::from_str(&text).unwrap();
        let broken = |change: &dyn Fn(&mut Value)| {
            let mut value = value.clone();
            change(&mut value);
            let guard: Guard = serde_json::from_value(value).unwrap();
            guard.check(layout, &train.shape()[1..]).unwrap_err()
        };
        let why = "the numbers of the guard do not fit together";
        assert_eq!(broken(&|guard| guard["mean"] = serde_json::json!([1.0])), why);
        assert_eq!(broken(&|guard| guard["constant"] = serde_json::json!([9999])), why);
        assert_eq!(broken(&|guard| guard["scale"] = serde_json::json!([0.0])), why);
        assert_eq!(broken(&|guard| guard["bounds"][3] = serde_json::json!([])), why);
        if !layout.has_area() {
            assert_eq!(broken(&|guard| guard["links"][0][0]["from"] = 9999.into()), why);
            assert_eq!(broken(&|guard| guard["ends"][0] = serde_json::json!([2.0, 1.0])), why);
        }
    }
}
