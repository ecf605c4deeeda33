//! Models out as ONNX, networks in from it, as a user does it.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use taxel::onnx;
use taxel::{Candidate, Conv, Encoding, Model, Network, Recipe};
use taxel_engine::{EngineOptions, Evaluator};
use taxel_graph::{Graph, Loss, Op, Scheme, Weights};

fn taxel(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap()
}

fn good(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// PyTorch's exports.
fn fixture(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../onnx/tests/data").join(file)
}

/// A network on 60 simulated grasps, trained for a moment.
fn model(build: impl FnOnce(&Network, taxel::Flow) -> taxel::Flow, encoding: &Encoding, loss: Loss) -> Model {
    let grasps = taxel::simulate("fingertip", 60, 0, &[]).unwrap();
    let net = Network::new("own");
    let features = build(&net, net.input("signal", grasps.sample_shape()));
    let graph = net.finish(&[("logits", features.linear("fc", grasps.output_names().len()))]).unwrap();
    let recipe = Recipe { epochs: 2, batch_size: 16, loss: Some(loss), ..Recipe::default() };
    taxel::fit(&Candidate::network(graph, recipe), &grasps, encoding).unwrap()
}

fn logits(graph: &Graph, weights: &Weights, x: &[f32], n: usize) -> Vec<f32> {
    let evaluator =
        Evaluator::new(graph, weights, EngineOptions { batch: n, ..EngineOptions::default() }).unwrap();
    let mut memory = evaluator.workspace();
    evaluator.predict(&mut memory, &[x], n).unwrap();
    memory.outputs().next().unwrap().1.to_vec()
}

#[test]
fn a_model_takes_its_z_score_along() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.onnx");
    let stem =
        |_: &Network, x: taxel::Flow| x.conv_bn_relu("stem", Conv::new(8, 5).same()).global_average_pool();
    let model = model(stem, &Encoding::default(), Loss::SoftmaxCrossEntropy);
    let exported = taxel::export(&model, &path).unwrap();
    assert_eq!(exported.outputs, ["logits", "probabilities"]);
    assert_eq!((&exported.inputs[0].shape[..], exported.inputs[0].encoded), (&[5, 50][..], None));
    // Raw readings through what was written, read back: its answers are the model's.
    let read = onnx::read(&path).unwrap();
    assert!(matches!(read.graph.nodes()[1].op, Op::Standardize { .. }));
    let fresh = taxel::simulate("fingertip", 12, 3, &[]).unwrap();
    let raw: Vec<f32> = fresh.x.iter().copied().collect();
    let mut got = logits(&read.graph, &read.weights, &raw, 12);
    for row in got.chunks_mut(3) {
        let sum: f32 = row.iter().map(|v| v.exp()).sum();
        row.iter_mut().for_each(|v| *v = v.exp() / sum);
    }
    let want = model.predict(&fresh.x).unwrap().outputs;
    let off = got.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off <= 1e-5, "{off:e}");
    // Equal models give equal files, and classes and unit stand in them.
    let bytes = fs::read(&path).unwrap();
    taxel::export(&model, &path).unwrap();
    assert!(bytes == fs::read(&path).unwrap());
    for word in ["taxel.classes", &fresh.output_names()[0], "softmax-cross-entropy", "raw readings"] {
        assert!(bytes.windows(word.len()).any(|window| window == word.as_bytes()), "{word}");
    }
}

#[test]
fn an_export_says_what_has_to_be_taken_off_before() {
    let folder = tempfile::tempdir().unwrap();
    let (file, path) = (folder.path().join("model.safetensors"), folder.path().join("own.onnx"));
    let mut grasps = taxel::simulate("fingertip", 60, 0, &[]).unwrap();
    grasps.spec.tare = Some(taxel::data::Tare::Recording { steps: 18 });
    grasps.spec.channel_names = ["thumb", "index", "middle", "ring", "little"].map(String::from).to_vec();
    let net = Network::new("own");
    let features =
        net.input("signal", &[5, 50]).conv_bn_relu("stem", Conv::new(8, 5).same()).global_average_pool();
    let graph = net.finish(&[("logits", features.linear("fc", 3))]).unwrap();
    let recipe = Recipe { epochs: 1, batch_size: 16, ..Recipe::default() };
    let model = taxel::fit(&Candidate::network(graph, recipe), &grasps, &Encoding::default()).unwrap();
    model.save(&file).unwrap();
    let words = "the mean of the first 18 readings of its recording";
    let output = taxel(&["export", text(&file), "--output", text(&path)]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains(words) && said.contains("before it calls the model"), "{said}");
    let bytes = fs::read(&path).unwrap();
    for word in ["taxel.tare", "recording:18", "taxel.channels", "middle"] {
        assert!(bytes.windows(word.len()).any(|window| window == word.as_bytes()), "{word}");
    }
    let exported = taxel::export_c(&model, &folder.path().join("c"), None).unwrap();
    assert!(exported.remarks.iter().any(|remark| remark.contains(words)), "{:?}", exported.remarks);
    let readme = fs::read_to_string(folder.path().join("c/README.md")).unwrap();
    assert!(readme.contains(words), "{readme}");
    let card = good(&["inspect", text(&file)]);
    assert!(card.contains("channels     thumb, index, middle, ring, little"), "{card}");
    assert!(card.contains(&format!("less         {words} (tare)")), "{card}");
}

#[test]
fn an_encoding_that_onnx_cannot_say_is_named_and_baselines_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (file, path) = (folder.path().join("model.safetensors"), folder.path().join("own.onnx"));
    let encoding: Encoding = serde_json::from_str(r#"{"image": {"kind": "gadf", "size": 8}}"#).unwrap();
    let grasps = taxel::simulate("fingertip", 60, 0, &[]).unwrap();
    let mut encoder = taxel::Encoder::new(&encoding, &grasps);
    encoder.prepare(&["image"]).unwrap();
    let net = Network::new("field");
    let image = net.input("image", &encoder.shape("image").unwrap());
    let graph = net.finish(&[("logits", image.global_average_pool().linear("fc", 3))]).unwrap();
    let recipe = Recipe { epochs: 1, batch_size: 16, ..Recipe::default() };
    taxel::fit(&Candidate::network(graph, recipe), &grasps, &encoding).unwrap().save(&file).unwrap();
    let said = good(&["export", text(&file), "--output", text(&path)]);
    assert!(
        said.contains("input `image`") && said.contains("NOT raw readings, but the coloured Gramian"),
        "{said}"
    );
    fs::remove_file(&path).unwrap();
    let baseline =
        taxel::fit(&Candidate::baseline(taxel::Baseline::NearestNeighbours { k: 1 }), &grasps, &encoding);
    baseline.unwrap().save(&file).unwrap();
    let error = refused(&["export", text(&file), "--output", text(&path)]);
    assert!(error.contains("k-nn: is a baseline that ONNX cannot say"), "{error}");
    assert!(!path.exists());
    let settings = ["--set", "classes=3", "--set", "length=20"];
    let graph = taxel_zoo::find("resnet8-lite-1d").unwrap();
    let graph =
        graph.graph(serde_json::from_str(r#"{"classes": 3, "length": 20}"#).as_ref().unwrap()).unwrap();
    taxel_checkpoint::write(&file, &Weights::init(&graph, Scheme::Pytorch, 0, "x"), "").unwrap();
    let call = ["export", "resnet8-lite-1d", "--output", text(&path), "--weights", text(&file)];
    let said = good(&[&call[..], &settings].concat());
    assert!(said.contains("opset 17") && said.contains("NOT raw readings"), "{said}");
    assert_eq!(onnx::read(&path).unwrap().graph.nodes(), graph.nodes());
    assert!(refused(&["export", "resnet8-lite-1d", "--output", text(&path)]).contains("give its --weights"));
}

/// The operations that a file holds, by the names of their nodes' operations.
fn holds(path: &Path, words: &[&str]) {
    let bytes = fs::read(path).unwrap();
    for word in words {
        assert!(
            bytes.windows(word.len()).any(|window| window == word.as_bytes()),
            "{}: {word}",
            path.display()
        );
    }
}

#[test]
fn ridge_is_a_network_that_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ridge.onnx");
    let grasps = taxel::simulate("fingertip", 60, 0, &[]).unwrap();
    let forces = grasps.x.outer_iter().map(|x| x.sum() / 100.0).collect();
    let force = taxel::data::Quantity { name: "force".into(), unit: Some("N".into()) };
    let grasps = grasps.with_values(vec![force], forces).unwrap();
    let model =
        taxel::fit(&Candidate::baseline(taxel::Baseline::Ridge), &grasps, &Encoding::default()).unwrap();
    let exported = taxel::export(&model, &path).unwrap();
    assert_eq!(exported.outputs, ["logits", "values", "readings_distance"]);
    assert_eq!((&exported.inputs[0].shape[..], exported.inputs[0].encoded), (&[5, 50][..], None));
    let read = onnx::read(&path).unwrap();
    let raw: Vec<f32> = grasps.x.iter().copied().collect();
    let (got, want) =
        (logits(&read.graph, &read.weights, &raw, 60), model.predict(&grasps.x).unwrap().outputs);
    let off = got.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let largest = want.iter().fold(0.0f32, |most, v| most.max(v.abs()));
    assert!(off <= 1e-4 * largest, "{off:e} of {largest}");
}

#[test]
fn codes_histories_and_mini_rocket_take_raw_readings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.onnx");
    let grasps = taxel::simulate("fingertip", 60, 0, &[]).unwrap();
    for (signal, words) in [
        (r#"{"signal": {"kind": "quantile-code"}}"#, &["signal/code/ramp/clipped", "MatMul"][..]),
        (r#"{"signal": {"kind": "history"}}"#, &["signal/history/differences", "Gather"]),
    ] {
        let encoding: Encoding = serde_json::from_str(signal).unwrap();
        let mut encoder = taxel::Encoder::new(&encoding, &grasps);
        encoder.prepare(&["signal"]).unwrap();
        let net = Network::new("coded");
        let features = net.input("signal", &encoder.shape("signal").unwrap()).flatten();
        let graph = net.finish(&[("logits", features.linear("fc", 3))]).unwrap();
        let recipe = Recipe { epochs: 1, batch_size: 16, ..Recipe::default() };
        let model = taxel::fit(&Candidate::network(graph, recipe), &grasps, &encoding).unwrap();
        let exported = taxel::export(&model, &path).unwrap();
        assert_eq!((&exported.inputs[0].shape[..], exported.inputs[0].encoded), (&[5, 50][..], None));
        holds(&path, words);
    }
    let rocket = Candidate::baseline(taxel::Baseline::MiniRocket { features: 420 });
    let model = taxel::fit(&rocket, &grasps, &Encoding::default()).unwrap();
    let exported = taxel::export(&model, &path).unwrap();
    assert_eq!(exported.outputs, ["logits", "probabilities", "distance", "readings_distance"]);
    holds(&path, &["Greater", "ReduceSum", "ridge.weight", "taxel.classes", "raw readings"]);
    assert!(onnx::read(&path).is_err(), "comparisons are no network of taxel's");
}

#[test]
fn pytorchs_network_is_imported_counted_and_asked() {
    let folder = tempfile::tempdir().unwrap();
    let imported = folder.path().join("mine.safetensors");
    let said = good(&["import", text(&fixture("cnn1d.script.onnx")), "--output", text(&imported)]);
    assert!(said.contains("input `signal`: channels 5 × length 30"), "{said}");
    let cost = good(&["cost", text(&imported)]);
    assert_eq!(cost, good(&["cost", text(&fixture("cnn1d.script.onnx"))]));
    assert!(cost.contains("features.0"), "{cost}");
    let x = folder.path().join("x.npy");
    fs::write(&x, taxel::data::npy_bytes(&[2, 5, 30], &vec![0.5f32; 300]).unwrap()).unwrap();
    let mut answers = vec![];
    for model in [text(&imported), text(&fixture("cnn1d.script.onnx"))] {
        let y = folder.path().join("y.npy");
        good(&["forward", "--model", model, "--input", text(&x), "--output", text(&y)]);
        answers.push(fs::read(&y).unwrap());
    }
    assert!(answers[0] == answers[1]);
    let error = refused(&["inspect", text(&imported)]);
    assert!(error.contains("mine.safetensors: holds a network with its weights, but no model"), "{error}");
    let error = refused(&["import", text(&x), "--output", text(&imported)]);
    assert!(error.contains("x.npy: is no ONNX model"), "{error}");
    assert!(
        refused(&["cost", text(&imported), "--set", "classes=2"])
            .contains("settings are for networks of the zoo")
    );
}

/// A config on simulated grasps of 5 × 30, three classes; PyTorch's network has four.
fn config(folder: &Path, networks: &str) -> PathBuf {
    let (path, grasps) = (folder.join("mine.toml"), folder.join("grasps.npz"));
    if !grasps.exists() {
        good(&["simulate", "fingertip", "--samples", "60", "--output", text(&grasps)]);
    }
    let head = "name = \"mine\"\nbaselines = []\n[data]\npath = \"grasps.npz\"\n\
                length = { kind = \"resample\", to = 30 }\n[protocol]\nkind = \"k-fold\"\nfolds = 2\n\
                [train]\nepochs = 2\nbatch_size = 16\n";
    fs::write(&path, format!("{head}{networks}")).unwrap();
    path
}

#[test]
fn an_imported_network_trains_is_judged_and_shipped() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::copy(fixture("cnn1d.script.onnx"), here.join("mine.onnx")).unwrap();
    good(&["import", text(&here.join("mine.onnx")), "--output", text(&here.join("imported.safetensors"))]);
    let networks = "[[networks]]\nonnx = \"mine.onnx\"\n[[networks]]\nfile = \"imported.safetensors\"\n\
                    [[networks]]\nonnx = \"mine.onnx\"\nlabel = \"fresh\"\nfresh = true\n[[networks]]\nname = \"mlp\"\n";
    let (run, shipped) = (here.join("run"), here.join("model.safetensors"));
    let table = good(&["run", text(&config(here, networks)), "--output", text(&run)]);
    for label in ["mine", "imported", "fresh", "mlp"] {
        assert!(table.contains(label), "{table}");
    }
    let fold = |label: &str| Model::open(&run.join(format!("models/{label}.r0.f0.safetensors"))).unwrap();
    let [mine, imported, fresh] = ["mine", "imported", "fresh"].map(fold);
    let weight = |model: &Model| model.weights().get("features.0.weight").unwrap().clone();
    // One start, one recipe: the same network; drawn anew it is another.
    assert_eq!(weight(&mine), weight(&imported));
    assert_ne!(weight(&mine), weight(&fresh));
    assert_eq!(mine.weights().get("head.3.weight").unwrap().shape, [3, 6]);
    good(&["fit", text(&run), "--network", "mine", "--output", text(&shipped)]);
    good(&["export", text(&shipped), "-o", text(&here.join("shipped.onnx"))]);
    // A trained model is a start of another.
    let again = config(here, "[[networks]]\nfile = \"model.safetensors\"\nlabel = \"again\"\n");
    good(&["run", text(&again), "--output", text(&here.join("again"))]);
}

#[test]
fn a_network_that_does_not_fit_says_so_where_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::copy(fixture("resnet8.dynamo.onnx"), here.join("image.onnx")).unwrap();
    fs::copy(fixture("lstm.script.onnx"), here.join("three.onnx")).unwrap();
    fs::write(here.join("broken.onnx"), "no model").unwrap();
    let error = |networks: &str| {
        let out = here.join("run");
        refused(&["run", text(&config(here, networks)), "--output", text(&out)])
    };
    let cases = [
        (
            "onnx = \"image.onnx\"",
            "reads `image` of channels 1 × rows 14 × columns 11, and the experiment encodes no such",
        ),
        (
            "onnx = \"three.onnx\"",
            "reads `signal` of channels 3 × length 12, the samples become channels 5 × length 30",
        ),
        ("onnx = \"broken.onnx\"", "is no ONNX model"),
        ("onnx = \"gone.onnx\"", "No such file"),
        ("onnx = \"x.safetensors\"", "must be an .onnx file"),
        ("file = \"x.onnx\"", "write onnx in place of file"),
        ("onnx = \"three.onnx\"\nset = { hidden = 3 }", "has no settings"),
        ("name = \"mlp\"\nfresh = true", "starts fresh without `weights`"),
        ("label = \"x\"", "needs `name`, a network of the zoo, or `onnx` or `file`"),
    ];
    for (network, reason) in cases {
        let text = error(&format!("[[networks]]\n{network}\n"));
        assert!(text.contains(reason) && text.contains("mine.toml:"), "{network}: {text}");
    }
}
