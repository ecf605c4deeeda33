//! Model files: they come back as themselves, and broken ones are refused by name.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ndarray::Axis;
use serde_json::{Value, json};
use support::{bits, imprints, mlp, network, presses, recipe, squeezes, two_attributes};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_graph::{Tensor, Weights};
use taxel_learn::{Candidate, CrossValidation, Encoding, Model, fit};

fn encoding(value: Value) -> Encoding {
    serde_json::from_value(value).unwrap()
}

/// A model file taken apart.
struct Parts {
    card: Value,
    weights: Weights,
}

impl Parts {
    fn of(model: &Model, dir: &Path) -> Self {
        let path = dir.join("whole.safetensors");
        model.save(&path).unwrap();
        let (weights, text) = taxel_checkpoint::read(&path).unwrap();
        let mut card: Value = serde_json::from_str(&text.unwrap()).unwrap();
        card.as_object_mut().unwrap().remove("digest").unwrap();
        Parts { card, weights }
    }

    /// Writes them as a file whose card bears its digest, as after a mistake of taxel's own.
    fn write(&self, path: &Path) {
        let card = self.card.to_string();
        let digest = blake3::hash(card.as_bytes()).to_hex();
        let text = format!("{},\"digest\":\"{digest}\"}}", card.strip_suffix('}').unwrap());
        taxel_checkpoint::write(path, &self.weights, &text).unwrap();
    }

    /// Returns the message for the file with these parts, less its name, which comes first.
    fn refusal(&self, dir: &Path) -> String {
        let path = dir.join("broken.safetensors");
        self.write(&path);
        refusal(&path)
    }
}

/// Returns the message for the file at `path`, less its name, which comes first.
fn refusal(path: &Path) -> String {
    let error = Model::open(path).unwrap_err().to_string();
    let name = format!("{}: ", path.display());
    error.strip_prefix(&name).unwrap_or_else(|| panic!("names no file: {error}")).to_string()
}

/// Names, shapes and bits, in order of the names.
fn tensors(model: &Model) -> BTreeMap<String, (Vec<usize>, Vec<u32>)> {
    let tensors = model.weights().iter();
    tensors.map(|(name, tensor)| (name.into(), (tensor.shape.clone(), bits(&tensor.data)))).collect()
}

/// Models of the three kinds of samples, small enough to be written many times.
fn small_models() -> Vec<(Model, Dataset)> {
    let (series, images) = (presses(15, 12), imprints(15, 14));
    let small = json!({ "image": { "kind": "raw", "resize": [12, 12] } });
    let mut validation = CrossValidation::new(&images).encoding(encoding(small.clone()));
    let convolution =
        network("resnet8-lite-2d", json!({}), recipe(json!({ "epochs": 1 })), validation.encoder());
    let of_series =
        fit(&mlp(&series, recipe(json!({ "epochs": 1 }))), &series, &Encoding::default()).unwrap();
    let nearest = Candidate::baseline(Method::NearestNeighbours { k: 1 });
    vec![
        (of_series, series.clone()),
        (fit(&convolution, &images, &encoding(small)).unwrap(), images),
        (fit(&nearest, &series, &Encoding::default()).unwrap(), series),
    ]
}

#[test]
fn a_file_whose_card_and_tensors_disagree_is_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let series = presses(15, 12);
    let whole = |lr: f64| {
        let changes = json!({ "epochs": 1, "optimizer": { "name": "sgdm", "lr": lr } });
        let model = fit(&mlp(&series, recipe(changes)), &series, &Encoding::default()).unwrap();
        Parts::of(&model, dir)
    };
    let broken = |change: &dyn Fn(&mut Parts)| {
        let mut parts = whole(0.01);
        change(&mut parts);
        parts.refusal(dir)
    };
    let set = |key: &'static str, value: Value| {
        broken(&move |parts| *parts.card.pointer_mut(key).unwrap() = value.clone())
    };
    let version = env!("CARGO_PKG_VERSION");
    let newer = broken(&|parts| {
        parts.card["format"] = json!(5);
        parts.card["taxel"] = json!("9.0.0");
        parts.card["a key of the future"] = json!(1);
    });
    assert_eq!(
        newer,
        format!(
            "is a model of format 5, written by taxel 9.0.0; this version ({version}) reads formats up to 4: open it \
             with taxel 9.0.0 or newer"
        )
    );
    let older = broken(&|parts| {
        parts.card.as_object_mut().unwrap().remove("format");
    });
    assert!(older.starts_with("was written by a version without model files"), "{older}");
    let text = set("/task/classes", json!(["soft", "stiff"]));
    assert_eq!(text, "its network has outputs [3], its card needs 2");
    let text = set("/task", json!({ "classes": [] }));
    assert_eq!(text, "its card names no classes");
    let text = broken(&|parts| {
        let tensor = parts.weights.get("fc1.weight").unwrap().clone();
        let others = parts.weights.iter().filter(|(name, _)| *name != "fc1.weight");
        let mut renamed = Weights::new();
        others.for_each(|(name, tensor)| renamed.insert(name, tensor.clone()));
        renamed.insert("fc9.weight", tensor);
        parts.weights = renamed;
    });
    assert!(text.starts_with("its tensors are not those of its network: "), "{text}");
    assert!(text.contains("fc1.weight") || text.contains("fc9.weight"), "{text}");
    let text = broken(&|parts| parts.weights.insert("more", Tensor { shape: vec![1], data: vec![0.0] }));
    assert!(
        text.starts_with("its tensors are not those of its network: ") && text.contains("more"),
        "{text}"
    );
    let text = broken(&|parts| parts.weights = whole(0.1).weights);
    assert_eq!(
        text,
        "its tensors are not those that its card was written for (digests differ); fit the model again"
    );
    let text = broken(&|parts| {
        let mut tensor = parts.weights.get("fc2.bias").unwrap().clone();
        tensor.data[0] = -tensor.data[0];
        parts.weights.insert("fc2.bias", tensor);
    });
    assert!(text.contains("digests differ"), "{text}");
    // A graph whose stated shapes are not those that its operations have.
    let text = set("/estimator/graph/nodes/2/shape", json!([9]));
    assert!(text.starts_with("its model card cannot be read: ") && text.contains("fc1"), "{text}");
    // A graph that is sound, and has other tensors.
    let text = broken(&|parts| {
        let wide = network(
            "mlp",
            json!({ "hidden": 9 }),
            recipe(json!({ "epochs": 1 })),
            CrossValidation::new(&series).encoder(),
        );
        let wide = Parts::of(&fit(&wide, &series, &Encoding::default()).unwrap(), dir);
        parts.card["estimator"]["graph"] = wide.card["estimator"]["graph"].clone();
    });
    assert!(text.starts_with("its tensors are not those of its network: ") && text.contains("fc1"), "{text}");
    let text = set("/reading/shape", json!([2, 12, 1]));
    assert_eq!(text, "its card says that a series reading has shape [2, 12, 1], which none has");
    let text = set("/inputs/0/name", json!("image"));
    assert_eq!(text, "its network reads other inputs than its card makes");
    for batch in [0u64, 5_000_000_000] {
        let text = set("/estimator/batch", json!(batch));
        assert_eq!(text, format!("its card says batch = {batch}: must be in 1..=65536"));
    }
    let text = set("/tensors", json!("0"));
    assert!(text.contains("digests differ"), "{text}");
    let text = broken(&|parts| parts.card["colour"] = json!("red"));
    assert!(text.starts_with("its model card cannot be read: unknown field `colour`"), "{text}");
    // A card that somebody changed by hand.
    let path = dir.join("edited.safetensors");
    let parts = whole(0.01);
    parts.write(&path);
    let (_, text) = taxel_checkpoint::read(&path).unwrap();
    let names = &parts.card["task"]["classes"];
    let (first, second) = (names[0].to_string(), names[1].to_string());
    let swapped = format!("{second},{first}");
    let text = text.unwrap().replacen(&format!("{first},{second}"), &swapped, 1);
    assert!(text.contains(&swapped), "{text}");
    taxel_checkpoint::write(&path, &parts.weights, &text).unwrap();
    assert_eq!(
        refusal(&path),
        "its card is not the one that was written (digests differ); fit the model again"
    );
    let path = dir.join("plain.safetensors");
    taxel_checkpoint::write(&path, &whole(0.01).weights, "").unwrap();
    let text = refusal(&path);
    assert!(text.starts_with("holds no model card: it is a checkpoint"), "{text}");
    let text = refusal(&dir.join("none.safetensors"));
    assert!(text.contains("cannot be read") || text.contains("No such file"), "{text}");
}

#[test]
fn an_average_that_does_not_hold_together_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let series = presses(15, 12);
    let rows = [
        mlp(&series, recipe(json!({ "epochs": 1 }))),
        Candidate::baseline(Method::MiniRocket { features: 84 }),
    ];
    let model = fit(&Candidate::average("both".into(), &rows), &series, &Encoding::default()).unwrap();
    let broken = |change: &dyn Fn(&mut Parts)| {
        let mut parts = Parts::of(&model, dir);
        change(&mut parts);
        parts.refusal(dir)
    };
    let text = broken(&|parts| parts.card["estimator"]["members"][0]["inputs"] = json!(5));
    assert_eq!(text, "its card makes fewer inputs than mlp reads");
    let text = broken(&|parts| parts.card["estimator"]["members"][1]["inputs"] = json!(0));
    assert_eq!(text, "its card says an average of 2 members with 1 inputs, and makes 2");
    let text = broken(&|parts| {
        parts.card["estimator"]["members"][1]["estimator"] = parts.card["estimator"].clone();
    });
    assert!(text.contains("mini-rocket, which it averages, is an average itself"), "{text}");
    let text = broken(&|parts| parts.weights.insert("7.more", Tensor { shape: vec![1], data: vec![0.0] }));
    assert_eq!(text, "it has tensors that none of the members of its average has");
    let text = broken(&|parts| parts.weights.insert("0.more", Tensor { shape: vec![1], data: vec![0.0] }));
    assert!(text.starts_with("of mlp, which it averages: its tensors are not those"), "{text}");
}

#[test]
fn a_baseline_with_other_tensors_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let series = presses(15, 12);
    for method in Method::all() {
        let model = fit(&Candidate::baseline(method), &series, &Encoding::default()).unwrap();
        let whole = Parts::of(&model, dir.path());
        let names: Vec<String> = whole.weights.iter().map(|(name, _)| name.to_string()).collect();
        assert!(!names.is_empty(), "{method:?}");
        for gone in &names {
            let mut parts = Parts { card: whole.card.clone(), weights: Weights::new() };
            let others = whole.weights.iter().filter(|(name, _)| name != gone);
            others.for_each(|(name, tensor)| parts.weights.insert(name, tensor.clone()));
            let text = parts.refusal(dir.path());
            assert!(text.starts_with("its tensors are not those"), "{method:?} without {gone}: {text}");
        }
        let mut parts = Parts { card: whole.card.clone(), weights: whole.weights.clone() };
        parts.card["task"]["classes"] = json!(["soft", "medium"]);
        let text = parts.refusal(dir.path());
        assert!(text.starts_with("its tensors are not those of its baseline: "), "{method:?}: {text}");
        parts.card["task"] = whole.card["task"].clone();
        parts.card["inputs"] = json!([]);
        assert_eq!(parts.refusal(dir.path()), "a baseline reads one input; its card makes another number");
    }
}

/// Samples that the card does not describe are refused by the model's name, and never by a panic.
#[test]
fn samples_that_are_not_what_the_model_reads_are_refused() {
    for (model, dataset) in small_models() {
        let refusal = |x: ndarray::ArrayD<f32>| model.predict(&x).unwrap_err().to_string();
        let name = model.card().name.clone();
        let short = dataset
            .x
            .slice_each_axis(|axis| ndarray::Slice::from(..axis.len - usize::from(axis.axis.0 == 2)));
        let error = refusal(short.to_owned());
        let spec = &model.card().spec;
        let want =
            format!("{name} reads samples of shape {:?} ({}); these have", spec.shape, spec.layout.axes());
        assert!(error.starts_with(&want), "{error}");
        let none: Vec<usize> = vec![];
        assert!(refusal(dataset.x.select(Axis(0), &none)).ends_with("there are none"));
        let mut bad = dataset.x.clone();
        bad.index_axis_mut(Axis(0), 3)[[1, 2]] = f32::INFINITY;
        assert!(refusal(bad).ends_with("sample 3 holds a reading that is not finite (NaN or infinity)"));
    }
}

#[test]
fn a_truncated_file_is_refused_wherever_it_ends() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    for (model, _) in small_models() {
        model.save(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let step = bytes.len() / 60;
        for end in (0..bytes.len()).step_by(step.max(1)).chain([bytes.len() - 1]) {
            std::fs::write(&path, &bytes[..end]).unwrap();
            let text = refusal(&path);
            assert!(!text.is_empty(), "{end} of {} bytes", bytes.len());
        }
    }
}

/// Flipped bits are refused, or fall where nothing is read.
#[test]
fn flipped_bits_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    for (model, _) in small_models() {
        model.save(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let header = 8 + u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        let (mut state, mut refused) = (1u64, 0);
        let mut next = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for round in 0..400 {
            let mut broken = bytes.clone();
            // Most of them where the card is.
            let end = if round % 4 == 0 { bytes.len() } else { header };
            for _ in 0..=round % 3 {
                broken[next(end)] ^= 1 << next(8);
            }
            std::fs::write(&path, &broken).unwrap();
            match Model::open(&path) {
                Ok(other) => assert!(other == model, "round {round}"),
                Err(_) => refused += 1,
            }
        }
        assert!(refused > 300, "{refused}");
    }
}

/// Sizes that no encoding has are refused before memory is allocated.
#[test]
fn a_card_with_impossible_numbers_never_panics() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("model.safetensors");
    let (series, images, touches) = (presses(15, 12), imprints(15, 14), squeezes(15, [8, 28, 28]));
    let made = |dataset: &Dataset, name: &str, settings: Value| {
        let mut validation = CrossValidation::new(dataset).encoding(encoding(settings.clone()));
        let candidate = network(name, json!({}), recipe(json!({ "epochs": 1 })), validation.encoder());
        Parts::of(&fit(&candidate, dataset, &encoding(settings)).unwrap(), dir.path())
    };
    let resized = json!({ "image": { "kind": "raw", "resize": [12, 12] } });
    let field = json!({ "image": { "kind": "gadf", "size": 24 } });
    let models = [
        (made(&images, "resnet8-lite-2d", resized), &images),
        (made(&series, "resnet8-lite-2d", field), &series),
        (made(&touches, "tactnet3d-4-8", json!({ "tensor": { "frames": 8 } })), &touches),
        (made(&series, "mlp", json!({ "baseline": 3 })), &series),
    ];
    for (mut whole, dataset) in models {
        let transform = whole.card["inputs"][0]["transform"].clone();
        let mut tried = 0;
        for place in numbers(&transform, "") {
            for number in
                [json!(0), json!(1), json!(-1), json!(5_000_000_000u64), json!(u64::MAX), json!(1e300)]
            {
                *whole.card["inputs"][0]["transform"].pointer_mut(&place).unwrap() = number.clone();
                whole.write(&path);
                whole.card["inputs"][0]["transform"] = transform.clone();
                if let Ok(model) = Model::open(&path) {
                    let _ = model.predict(&dataset.x);
                }
                tried += 1;
            }
        }
        assert!(tried >= 6, "{transform}");
    }
}

/// Where numbers are in a text, as JSON pointers.
fn numbers(value: &Value, at: &str) -> Vec<String> {
    match value {
        Value::Number(_) => vec![at.into()],
        Value::Array(items) => {
            items.iter().enumerate().flat_map(|(i, item)| numbers(item, &format!("{at}/{i}"))).collect()
        }
        Value::Object(map) => {
            map.iter().flat_map(|(key, item)| numbers(item, &format!("{at}/{key}"))).collect()
        }
        _ => vec![],
    }
}

#[test]
fn equal_models_are_equal_files_and_a_file_comes_back_as_itself() {
    let dir = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> =
        ["a", "b"].map(|name| dir.path().join(name).with_extension("safetensors")).into();
    for (model, dataset) in small_models() {
        model.save(&paths[0]).unwrap();
        let again = Model::open(&paths[0]).unwrap();
        assert!(again.card() == model.card() && tensors(&again) == tensors(&model));
        again.save(&paths[1]).unwrap();
        assert!(std::fs::read(&paths[0]).unwrap() == std::fs::read(&paths[1]).unwrap());
        let card = again.card();
        assert_eq!((&card.spec, &card.trained_on.source), (&dataset.spec, &dataset.source));
        assert_eq!((&card.trained_on.digest, card.trained_on.samples), (&dataset.digest, 15));
        assert_eq!(card.task.attributes(), dataset.targets.labels().unwrap().attributes());
        let words = card.to_string();
        assert!(words.contains(&card.name) && words.contains("not measured"), "{words}");
    }
}

#[test]
fn a_model_comes_back_from_its_bytes() {
    let dir = tempfile::tempdir().unwrap();
    for (model, dataset) in small_models() {
        let path = dir.path().join("own.safetensors");
        model.save(&path).unwrap();
        let bytes = model.to_bytes().unwrap();
        assert_eq!(bytes, std::fs::read(&path).unwrap());
        let back = Model::from_bytes(&bytes, "a pickle").unwrap();
        assert_eq!(back.card(), model.card());
        assert_eq!(tensors(&back), tensors(&model));
        let [a, b] = [&back, &model].map(|model| model.predict(&dataset.x).unwrap().outputs);
        assert_eq!(bits(&a), bits(&b));
        let error = Model::from_bytes(&bytes[..bytes.len() - 4], "a pickle").unwrap_err().to_string();
        assert!(error.starts_with("a pickle: "), "{error}");
    }
}

#[test]
fn cards_of_formats_1_and_2_are_read_and_written_anew() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("old.safetensors");
    let several = two_attributes();
    let of_two = fit(&mlp(&several, recipe(json!({ "epochs": 1 }))), &several, &Encoding::default()).unwrap();
    for (model, dataset) in small_models().into_iter().chain([(of_two, several)]) {
        for format in [1, 2] {
            let mut old = Parts::of(&model, dir.path());
            let card = old.card.as_object_mut().unwrap();
            let task = card.shift_remove("task").unwrap();
            let attributes = match task.get("attributes") {
                Some(attributes) => attributes.clone(),
                None => json!([{ "name": "class", "classes": task["classes"] }]),
            };
            let kind = card.shift_remove("estimator").unwrap();
            card.extend([("attributes".into(), attributes), ("anatomy".into(), kind)]);
            card.insert("format".into(), json!(format));
            old.write(&path);
            let read = Model::open(&path).unwrap();
            assert_eq!(read.card(), model.card());
            let [a, b] = [&read, &model].map(|model| model.predict(&dataset.x).unwrap().outputs);
            assert_eq!(bits(&a), bits(&b));
            // A version that knows no newer format must not take it for one of its own.
            assert_eq!(read.to_bytes().unwrap(), model.to_bytes().unwrap());
        }
    }
}

/// More samples than stand encoded at a time: the same predictions, whoever owns them, and messages that count from the
/// first.
#[test]
fn many_samples_are_answered_piece_by_piece() {
    for (model, dataset) in small_models() {
        let expected = model.predict(&dataset.x).unwrap().outputs;
        let times = 1500usize.div_ceil(dataset.len());
        let all: Vec<usize> = (0..times).flat_map(|_| 0..dataset.len()).collect();
        let mut many = dataset.x.select(Axis(0), &all);
        let predictions = model.predict(&many.view()).unwrap().outputs;
        assert_eq!(bits(&predictions), bits(&expected.repeat(times)), "{}", model.card().name);
        let mut backwards = many.view();
        backwards.invert_axis(Axis(0));
        let turned = model.predict(&backwards).unwrap().outputs;
        let outputs = expected.len() / dataset.len();
        let again: Vec<f32> = predictions.chunks(outputs).rev().flatten().copied().collect();
        assert_eq!(bits(&turned), bits(&again));
        many.index_axis_mut(Axis(0), 1234).fill(f32::NAN);
        let error = model.predict(&many).unwrap_err().to_string();
        assert!(
            error.ends_with("sample 1234 holds a reading that is not finite (NaN or infinity)"),
            "{error}"
        );
    }
}

#[test]
fn mini_rocket_has_as_many_features_as_memory_holds() {
    let dataset = presses(12, 20);
    for features in [0, 1_000_001, usize::MAX] {
        let candidate = Candidate::baseline(Method::MiniRocket { features });
        let error = fit(&candidate, &dataset, &Encoding::default()).unwrap_err().to_string();
        assert_eq!(error, format!("features = {features}: must be in 1..=1000000"));
    }
}
