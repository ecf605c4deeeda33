//! MobileNetV2 with ImageNet weights on drawn pictures: PyTorch's logits, and what the pictures show.
//!
//! The weights are the user's (`TAXEL_WEIGHTS`); `scripts/fixtures/imagenet.py` wrote the fixture with the same.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};

use serde_json::Value;
use taxel_checkpoint as checkpoint;
use taxel_devices::{Device, Model};
use taxel_engine::{Engine, EngineOptions, Mode};
use taxel_graph::{Graph, Weights};

const SIDE: i64 = 224;
/// torchvision's, for RGB in 0..1.
const MEAN: [f32; 3] = [0.485, 0.456, 0.406];
const STD: [f32; 3] = [0.229, 0.224, 0.225];

/// [3, 224, 224]: rectangles and discs in whole pixels, each over the ones before.
fn draw(shapes: &Value) -> Vec<f32> {
    let numbers = |v: &Value| v.as_array().unwrap().iter().map(|v| v.as_i64().unwrap()).collect::<Vec<_>>();
    let plane = (SIDE * SIDE) as usize;
    let mut image = vec![0.0; 3 * plane];
    for shape in shapes.as_array().unwrap() {
        let (shape, colour) = (numbers(&shape[0]), numbers(&shape[1]));
        for at in 0..plane {
            let (x, y) = (at as i64 % SIDE, at as i64 / SIDE);
            let inside = match shape[..] {
                [cx, cy, radius] => (x - cx).pow(2) + (y - cy).pow(2) <= radius * radius,
                [x0, y0, x1, y1] => (x0..x1).contains(&x) && (y0..y1).contains(&y),
                _ => panic!("{shape:?}"),
            };
            for channel in 0..if inside { 3 } else { 0 } {
                let value = colour[channel] as f32 / 255.0;
                image[channel * plane + at] = (value - MEAN[channel]) / STD[channel];
            }
        }
    }
    image
}

fn compare(what: &str, case: &Value, logits: &[f32]) {
    let want: Vec<f64> = case["logits"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert_eq!(logits.len(), want.len());
    let scale = want.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    for (class, (got, want)) in logits.iter().zip(&want).enumerate() {
        let gap = (f64::from(*got) - want).abs();
        assert!(gap <= 1e-4 * scale, "{}, {what}: class {class}: got {got}, want {want}", case["name"]);
    }
    let best = (0..logits.len()).max_by(|&a, &b| logits[a].total_cmp(&logits[b])).unwrap();
    assert_eq!(best as u64, case["label"].as_u64().unwrap(), "{}, {what}", case["name"]);
}

fn graph(classes: u64) -> Graph {
    let settings = [("classes".to_string(), classes.into())].into_iter().collect();
    taxel_zoo::find("mobilenet-v2").unwrap().graph(&settings).unwrap()
}

fn read() -> Weights {
    let folder = PathBuf::from(std::env::var("TAXEL_WEIGHTS").expect("TAXEL_WEIGHTS names a folder"));
    checkpoint::read(&folder.join("mobilenet_v2_imagenet_bnstats.safetensors")).unwrap().0
}

mod needs_weights {
    use super::*;

    #[test]
    #[ignore = "needs TAXEL_WEIGHTS"]
    fn drawn_pictures_are_seen_for_what_they_show() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/imagenet.json");
        let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        assert_eq!(cases.len(), 4);
        let (graph, weights) = (graph(1000), read());
        let mut engine = Engine::new(&graph, &weights, EngineOptions::default()).unwrap();
        let model = Model::new(&graph, &weights, &Device::Cpu).unwrap();
        for case in &cases {
            let image = draw(&case["shapes"]);
            compare("engine", case, engine.forward(&[&image], 1, Mode::Eval).unwrap());
            compare("candle", case, &model.forward(&[&image], 1, false).unwrap().remove(0).1);
        }
    }

    /// A start for six classes of touch: every tensor but the classifier's.
    #[test]
    #[ignore = "needs TAXEL_WEIGHTS"]
    fn the_checkpoint_starts_a_network_of_another_number_of_classes() {
        let (graph, checkpoint) = (graph(6), read());
        let fresh = Weights::init(&graph, taxel_graph::Scheme::Pytorch, 0, "imagenet");
        let mut weights = fresh.clone();
        let replaced = weights.start_from(&graph, &checkpoint, false).unwrap();
        assert_eq!(replaced, ["classifier.1.weight", "classifier.1.bias"]);
        for (name, tensor) in weights.iter() {
            let from = if replaced.iter().any(|r| r == name) { &fresh } else { &checkpoint };
            assert_eq!(from.get(name), Some(tensor), "{name}");
        }
    }
}
