//! The binary as a user runs it.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/twin.rs"]
mod twin;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

use assert_cmd::Command;
use taxel_graph::{Graph, Weights};
use tempfile::TempDir;
use twin::Twin;

fn taxel(arguments: &[&str]) -> Output {
    Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap()
}

/// Runs and expects exit code 0; what was printed.
fn good(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs and expects exit code 2 with one line on standard error; that line.
fn refused(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.starts_with("error: "), "{error}");
    error.trim_end().trim_start_matches("error: ").to_string()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn write_npy(path: &Path, shape: &[usize], values: &[f32]) {
    use npyz::WriterBuilder;
    let file = fs::File::create(path).unwrap();
    let shape: Vec<u64> = shape.iter().map(|&size| size as u64).collect();
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd().unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
}

struct Case {
    folder: TempDir,
    twin: Twin,
    graph: Graph,
}

impl Case {
    fn new(twin: Twin) -> Case {
        let folder = tempfile::tempdir().unwrap();
        let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
        for (node, x) in graph.inputs().zip(twin.inputs(&graph, 500)) {
            let shape = [&[twin.batch], &node.shape[..]].concat();
            write_npy(&folder.path().join(format!("{}.npy", node.name)), &shape, &x);
        }
        let case = Case { folder, twin, graph };
        case.save(&case.twin.weights());
        case
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn save(&self, weights: &Weights) {
        taxel_checkpoint::write(&self.path("w.safetensors"), weights, "").unwrap();
    }

    fn arguments(&self, backend: &str) -> Vec<String> {
        let mut list = vec!["forward".to_string(), "--model".into(), self.twin.network.clone()];
        list.extend(["--weights".into(), text(&self.path("w.safetensors")).into()]);
        for node in self.graph.inputs() {
            list.extend(["--input".into(), text(&self.path(&format!("{}.npy", node.name))).into()]);
        }
        list.extend([
            "--output".into(),
            text(&self.path("y.npy")).into(),
            "--backend".into(),
            backend.into(),
        ]);
        for (key, value) in &self.twin.settings {
            list.extend(["--set".into(), format!("{key}={value}")]);
        }
        list
    }

    fn forward(&self, backend: &str) -> Output {
        let arguments = self.arguments(backend);
        taxel(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
    }
}

/// Backends of this build.
const BACKENDS: &[&str] = if cfg!(feature = "candle") { &["native", "candle"] } else { &["native"] };

#[cfg(not(feature = "candle"))]
#[test]
fn without_candle_its_backend_is_refused_with_the_way_out() {
    let case = Case::new(Twin::all().remove(0));
    let output = case.forward("candle");
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("'candle' for '--backend <BACKEND>'"), "{message}");
    assert!(message.contains("this build has no candle; build taxel with `--features candle`"), "{message}");
}

#[test]
fn forward_gives_pytorchs_logits_on_both_backends() {
    for twin in Twin::all() {
        let case = Case::new(twin);
        for backend in BACKENDS {
            let output = case.forward(backend);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            // Where members of a network have outputs of their own, the logits lie in a file of their name.
            let path =
                ["y.npy", "y.logits.npy"].map(|name| case.path(name)).into_iter().find(|path| path.exists());
            let path = path.expect("a file of logits");
            let logits = taxel_data::read_npy(&path).unwrap();
            assert_eq!(logits.shape()[0], case.twin.batch);
            case.twin.assert_values("eval_logits", logits.as_slice().unwrap(), 1e-4);
            fs::remove_file(path).unwrap();
        }
    }
}

#[test]
fn several_outputs_go_to_files_of_their_own() {
    for twin in Twin::several_outputs() {
        let case = Case::new(twin);
        for backend in BACKENDS {
            let output = case.forward(backend);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            for name in case.twin.outputs() {
                let path = case.path(&format!("y.{name}.npy"));
                let values = taxel_data::read_npy(&path).unwrap();
                assert_eq!(values.shape()[0], case.twin.batch);
                case.twin.assert_values(&name, values.as_slice().unwrap(), 1e-4);
                fs::remove_file(path).unwrap();
            }
            assert!(!case.path("y.npy").exists());
        }
    }
}

/// Features [N, channels, rows, columns] of a node, out of which the logits are made.
#[test]
fn forward_gives_the_features_of_a_node() {
    let case = Case::new(Twin::all().into_iter().find(|t| t.name == "resnet18-2-23-300-20").unwrap());
    for backend in BACKENDS {
        let at = |node: &str| {
            let mut arguments = case.arguments(backend);
            arguments.extend(["--at".into(), node.into()]);
            taxel(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
        };
        assert!(at("layer4").status.success());
        let features = taxel_data::read_npy(&case.path("y.npy")).unwrap();
        assert_eq!(features.shape(), [3, 512, 1, 10]);
        let weights = case.twin.weights();
        let (weight, bias) = (weights.get("fc.weight").unwrap(), weights.get("fc.bias").unwrap());
        let mut logits = vec![];
        for sample in features.outer_iter() {
            for (row, bias) in weight.data.chunks(512).zip(&bias.data) {
                let mean = sample.outer_iter().map(|channel| channel.sum() / 10.0);
                logits.push(mean.zip(row).map(|(x, w)| x * w).sum::<f32>() + bias);
            }
        }
        case.twin.assert_values("eval_logits", &logits, 1e-4);
        let refusal = String::from_utf8(at("layer5").stderr).unwrap();
        assert!(
            refusal.contains("has no node `layer5`; did you mean `layer1` or `layer2` or `layer3`?"),
            "{refusal}"
        );
    }
}

#[test]
fn two_trained_networks_are_stitched_into_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_string();
    let settings = ["height=64", "width=47", "classes=4"];
    let graph = |name: &str| {
        let pairs = settings.iter().map(|pair| pair.split_once('=').unwrap());
        let settings = pairs.map(|(k, v)| (k.to_string(), v.parse::<u64>().unwrap().into())).collect();
        taxel_zoo::find(name).unwrap().graph(&settings).unwrap()
    };
    let parent = graph("mobilenet-v2");
    let fresh = |seed| Weights::init(&parent, taxel_graph::Scheme::Pytorch, seed, "stitch");
    let (visual, mut tactile) = (fresh(1), fresh(2));
    let names = taxel_zoo::matlab::resolve(&parent, &["18:139".into()]).unwrap();
    let covered = parent.covered(&names).unwrap();
    let shared = parent.nodes().iter().zip(covered).filter(|(_, covered)| *covered);
    for param in shared.flat_map(|(node, _)| &node.params) {
        tactile.insert(&param.name, visual.get(&param.name).unwrap().clone());
    }
    for (name, weights) in [("v.safetensors", &visual), ("t.safetensors", &tactile)] {
        taxel_checkpoint::write(&folder.path().join(name), weights, "").unwrap();
    }
    let stitch = |tactile: &str, more: &[&str]| {
        let mut list = vec!["stitch".to_string(), "--visual".into(), at("v.safetensors")];
        list.extend(["--tactile".into(), at(tactile), "--output".into(), at("both.safetensors")]);
        settings.iter().for_each(|pair| list.extend(["--set".into(), pair.to_string()]));
        list.extend(more.iter().map(|word| word.to_string()));
        list
    };
    let call = |list: Vec<String>| good(&list.iter().map(String::as_str).collect::<Vec<_>>());
    let refuse = |list: Vec<String>| refused(&list.iter().map(String::as_str).collect::<Vec<_>>());
    let said = call(stitch("t.safetensors", &[]));
    assert!(said.ends_with("3,127,160 parameters in place of 4,457,992, 1.43 times fewer\n"), "{said}");
    let plane = 64 * 47;
    let image: Vec<f32> = (0..3 * plane).map(|i| (i % 101) as f32 / 50.0 - 1.0).collect();
    write_npy(&folder.path().join("x.npy"), &[1, 3, 64, 47], &image);
    let dark = vec![0.0; 3 * plane];
    write_npy(&folder.path().join("xx.npy"), &[1, 6, 64, 47], &[&dark[..], &image[..]].concat());
    let forward = |model: &str, weights: &str, x: &str| {
        let mut list = vec!["forward", "--model", model].into_iter().map(String::from).collect::<Vec<_>>();
        list.extend([
            "--weights".into(),
            at(weights),
            "--input".into(),
            at(x),
            "--output".into(),
            at("y.npy"),
        ]);
        settings.iter().for_each(|pair| list.extend(["--set".into(), pair.to_string()]));
        call(list)
    };
    forward("mobilenet-v2", "t.safetensors", "x.npy");
    forward("mobilenet-v2-split", "both.safetensors", "xx.npy");
    assert_eq!(fs::read(at("y.npy")).unwrap(), fs::read(at("y.tactile.npy")).unwrap());
    assert_ne!(fs::read(at("y.npy")).unwrap(), fs::read(at("y.visual.npy")).unwrap());
    fs::remove_file(at("both.safetensors")).unwrap();
    taxel_checkpoint::write(&folder.path().join("o.safetensors"), &fresh(2), "").unwrap();
    let refusal = refuse(stitch("o.safetensors", &[]));
    assert!(
        refusal.contains("shared tensor `features.3.conv.0.0.weight` is another in `visual`"),
        "{refusal}"
    );
    let refusal = refuse(stitch("t.safetensors", &["--std", "1,1,1"]));
    assert_eq!(refusal, "--std: expected 6 above 0 numbers, got [1.0, 1.0, 1.0]");
    assert!(!folder.path().join("both.safetensors").exists());
}

#[test]
fn forward_refuses_tensors_and_inputs_by_name() {
    let case = Case::new(Twin::all().into_iter().find(|t| t.name == "hybrid-resvgg").unwrap());
    let message = || {
        let output = case.forward("native");
        assert_eq!(output.status.code(), Some(2));
        assert!(!case.path("y.npy").exists(), "no half-written file");
        String::from_utf8(output.stderr).unwrap()
    };
    let mut weights = Weights::new();
    for (name, tensor) in case.twin.weights().iter().filter(|(n, _)| *n != "fuse.bias") {
        weights.insert(name, tensor.clone());
    }
    case.save(&weights);
    assert!(message().contains("tensor `fuse.bias` is missing; expected shape [48]"), "{}", message());
    weights = case.twin.weights();
    weights.insert("head.bias", weights.get("fc.bias").unwrap().clone());
    case.save(&weights);
    assert!(message().contains("tensor `head.bias` is not part of this network"), "{}", message());
    weights = case.twin.weights();
    weights.insert("fuse.bias", weights.get("fc.bias").unwrap().clone());
    case.save(&weights);
    assert!(message().contains("tensor `fuse.bias` has shape [3], expected [48]"), "{}", message());
    case.save(&case.twin.weights());
    write_npy(&case.path("signal.npy"), &[3, 5, 49], &vec![0.0; 3 * 5 * 49]);
    assert!(
        message().contains("shape [3, 5, 49] does not fit input `signal`; expected at least one sample of channels 5 × length 50"),
        "{}",
        message()
    );
    let whole = fs::read(case.path("w.safetensors")).unwrap();
    fs::write(case.path("w.safetensors"), &whole[..whole.len() / 2]).unwrap();
    assert!(message().contains("w.safetensors: not a whole safetensors file"), "{}", message());
}

#[test]
fn zoo_and_cost_count_alike() {
    let zoo: serde_json::Value = serde_json::from_str(&good(&["zoo", "--format", "json"])).unwrap();
    let list = zoo.as_array().unwrap();
    assert_eq!(list.len(), taxel_zoo::built_in().entries().count());
    for entry in list {
        let name = entry["name"].as_str().unwrap();
        let cost: serde_json::Value =
            serde_json::from_str(&good(&["cost", name, "--format", "json"])).unwrap();
        assert_eq!(cost["total"]["parameters"], entry["parameters"]);
        assert_eq!(cost["total"]["macs"], entry["macs"]);
        let layers = cost["layers"].as_array().unwrap();
        let sum: u64 = layers.iter().map(|l| l["cost"]["macs"].as_u64().unwrap()).sum();
        assert_eq!(sum, entry["macs"].as_u64().unwrap());
    }
    assert!(good(&["zoo"]).contains("hybrid-resvgg"));
    let meant = "did you mean `hybrid-resvgg` or `hybrid-resvgg-nofc`?";
    assert!(refused(&["cost", "resvgg"]).starts_with(&format!("no network is called `resvgg`; {meant}")));
    assert!(refused(&["cost", "mlp", "--set", "clases=3"]).contains("unknown field `clases`"));
}

#[test]
fn simulate_encode_and_check_go_together() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let simulate = |name: &str, seed: &str| {
        good(&["simulate", "fingertip", "--samples", "60", "--seed", seed, "--output", text(&at(name))]);
        fs::read(at(name)).unwrap()
    };
    assert_eq!(simulate("a.npz", "1"), simulate("b.npz", "1"), "same seed, same bytes");
    assert_ne!(simulate("a.npz", "1"), simulate("b.npz", "2"));
    let card: serde_json::Value =
        serde_json::from_str(&good(&["data", "check", text(&at("a.npz")), "--format", "json"])).unwrap();
    assert_eq!(card["shape"], serde_json::json!([60, 5, 50]));
    assert_eq!(card["classes"][1]["name"], "shore-10");
    let out = at("run");
    let (config, data) = (QUICKSTART, at("a.npz"));
    let json =
        good(&["run", config, "--quick", "--data", text(&data), "--output", text(&out), "--format", "json"]);
    let table: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        table["source"], "simulated: fingertip (a)",
        "what was saved and read again is still simulated"
    );
    assert!(good(&["simulate", "fingertip", "--explain"]).contains("source:"));
    assert!(
        refused(&["simulate", "fingertip", "--without", "gravity", "--output", "x.npz"]).contains("gravity")
    );
    let broken = |fault: &str, severity: &str| {
        let fault = ["--fault", fault, "--severity", severity, "--output"];
        let line = ["simulate", "fingertip", "--samples", "60"].iter().chain(&fault);
        line.map(|word| word.to_string()).chain([text(&at("broken.npz")).into()]).collect::<Vec<_>>()
    };
    good(&broken("dead-line", "2").iter().map(String::as_str).collect::<Vec<_>>());
    let names = fs::read_to_string(at("broken.classes.json")).unwrap();
    assert!(names.contains("simulated: fingertip with dead-line, 2 lines or fingers"), "{names}");
    let refusal = refused(&broken("rotation", "2").iter().map(String::as_str).collect::<Vec<_>>());
    assert!(refusal.contains("channels have no place"), "{refusal}");

    let out = at("squeezes.npz");
    good(&["simulate", "palpation", "--set", "paper=002", "--samples", "18", "--output", text(&out)]);
    let card: serde_json::Value =
        serde_json::from_str(&good(&["data", "check", text(&out), "--format", "json"])).unwrap();
    assert_eq!(card["shape"], serde_json::json!([18, 10, 28, 50]));
    assert_eq!(card["dtype"], "|u1");
    let out = at("grasps.npz");
    good(&["simulate", "gripper", "--samples", "30", "--output", text(&out)]);
    let grasps = taxel_data::load(&out, &taxel_data::ReadOptions::default()).unwrap();
    assert_eq!(grasps.x.shape(), [30, 2, 23, 450]);
    let columns = grasps.targets.columns().unwrap();
    assert_eq!(columns.of(&[6]), [8, 2]);
    assert_eq!(columns.attributes()[1].classes[2], "hardness-3");
    let nope = |set: &str| refused(&["simulate", "palpation", "--set", set, "--output", "x.npz"]);
    assert!(nope("frames=2").contains("frames = 2"));
    assert!(nope("objects=9").contains("unknown field `objects`"));

    let load = |name: &str| taxel_data::load(&at(name), &taxel_data::ReadOptions::default()).unwrap();
    let convert = |set: &str, kind: &str, shape: &[usize], settings: &[&str]| {
        let x = load(set).x;
        write_npy(&at("raw.npy"), x.shape(), x.as_slice().unwrap());
        let mut line = vec!["encode", kind, "--input"];
        let (input, output) = (at("raw.npy"), at("encoded.npy"));
        line.extend([text(&input), "--output", text(&output)]);
        settings.iter().for_each(|set| line.extend(["--set", set]));
        good(&line);
        assert_eq!(taxel_data::read_npy(&output).unwrap().shape(), shape, "{kind}");
    };
    convert("squeezes.npz", "tactile-tensor", &[18, 1, 28, 50, 21], &["frames=21"]);
    convert("squeezes.npz", "frame", &[18, 1, 28, 50], &["frame=3"]);
    convert("squeezes.npz", "frame", &[18, 1, 28, 50], &[]);
    convert("squeezes.npz", "all-frames", &[180, 1, 28, 50], &[]);
    convert("squeezes.npz", "resize", &[18, 10, 14, 25], &["height=14", "width=25", "filter=area"]);
    convert("grasps.npz", "numatac", &[30, 2, 23, 300], &[]);

    let ramp: Vec<f32> = (0..500).map(|i| (i % 250) as f32).collect();
    write_npy(&at("x.npy"), &[2, 5, 50], &ramp);
    let encode = |kind: &str, shape: &[usize]| {
        good(&["encode", kind, "--input", text(&at("x.npy")), "--output", text(&at("y.npy"))]);
        let images = taxel_data::read_npy(&at("y.npy")).unwrap();
        assert_eq!(images.shape(), shape);
        images
    };
    let field = encode("gadf", &[2, 50, 50]);
    assert!((field[[0, 3, 40]] + field[[0, 40, 3]]).abs() < 1e-6, "a difference field is antisymmetric");
    encode("hardness-image", &[2, 3, 50, 50]);
    let mut broken = ramp;
    broken[300] = f32::NAN;
    write_npy(&at("x.npy"), &[2, 5, 50], &broken);
    let error = refused(&["encode", "gadf", "--input", text(&at("x.npy")), "--output", text(&at("z.npy"))]);
    assert!(error.contains("sample 1") && error.contains("NaN"), "{error}");
    assert!(!at("z.npy").exists());
}

#[test]
fn check_ends_with_1_where_a_data_set_cannot_be_used_and_2_where_it_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    for (class, line) in [("soft", "1,2\n3,4\n"), ("hard", "1,2\n3,NaN\n")] {
        fs::create_dir(folder.path().join(class)).unwrap();
        for take in 0..3 {
            fs::write(folder.path().join(class).join(format!("{take}.csv")), line).unwrap();
        }
    }
    let page = folder.path().join("card.html");
    let output = taxel(&["data", "check", text(folder.path()), "--html", text(&page)]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("NaN"));
    assert!(
        fs::read_to_string(&page).unwrap().contains("</html>"),
        "what cannot be used is drawn all the same"
    );
    let nowhere = folder.path().join("none/card.html");
    assert!(
        refused(&["data", "check", text(folder.path()), "--html", text(&nowhere)])
            .contains("card.html: cannot be written")
    );
    assert!(refused(&["data", "check", text(&folder.path().join("none.npz"))]).contains("no such file"));
}

#[test]
fn a_table_is_checked_and_converted() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let rows: String = (0..12)
        .map(|i| format!("g{},{},{},{}\n", i / 2, i % 2 * 10, i, ["soft", "hard"][i / 2 % 2]))
        .collect();
    fs::write(at("grasps.csv"), format!("grasp,stamp,force,kind\n{rows}")).unwrap();
    let columns = ["--y", "kind", "--table", "long,recording=grasp,time=stamp,clock=ms"];
    let card = |name: &str, more: &[&str]| -> serde_json::Value {
        let path = at(name);
        let arguments = [&["data", "check", text(&path), "--format", "json"], more].concat();
        serde_json::from_str(&good(&arguments)).unwrap()
    };
    let table = card("grasps.csv", &columns);
    assert_eq!((&table["shape"], &table["axes"]), (&serde_json::json!([6, 1, 2]), &"N×C×T".into()));
    assert_eq!(table["read_as"][1], "time stamps give 100 Hz");
    let (csv, npz) = (at("grasps.csv"), at("set.npz"));
    let convert = ["data", "convert", text(&csv), "--output", text(&npz)];
    let said = good(&[&convert[..], &columns].concat());
    assert!(said.contains("set.npz: x [6, 1, 2]\n") && said.contains("set.classes.json: "), "{said}");
    assert_eq!(card("set.npz", &[])["digest"], table["digest"]);
    let error = refused(&["data", "check", text(&npz), "--max-values", "3"]);
    assert!(error.ends_with("or on the command line --max-values 12"), "{error}");
    assert_eq!(card("set.npz", &["--max-values", "12"])["digest"], table["digest"]);
    let error = refused(&["data", "check", text(&csv), "--table", "tall"]);
    assert!(error.contains("\"tall\" is neither long nor wide"), "{error}");
    let error = refused(&["data", "check", text(&csv)]);
    assert!(
        error.contains("has a column \"stamp\" but none that says which recording a row belongs to"),
        "{error}"
    );
    let error = refused(&["data", "check", text(&csv), "--table", "recording=grasp"]);
    assert!(error.contains("has no column \"label\"; name one with y"), "{error}");
}

/// Every file of a run folder that equal runs share, by name.
fn shared_files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![];
    for name in ["config.toml", "results.json", "metrics.jsonl", "predictions.npz"] {
        files.push((name.to_string(), fs::read(folder.join(name)).unwrap()));
    }
    let mut models: Vec<PathBuf> =
        fs::read_dir(folder.join("models")).unwrap().map(|e| e.unwrap().path()).collect();
    models.sort();
    assert!(!models.is_empty());
    files.extend(
        models
            .into_iter()
            .map(|p| (p.display().to_string(), p))
            .map(|(n, p)| (n.rsplit('/').next().unwrap().to_string(), fs::read(p).unwrap())),
    );
    files
}

const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/quickstart.toml");

#[test]
fn equal_runs_write_equal_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, threads: &str, seed: &str| {
        let out = folder.path().join(name);
        good(&["run", QUICKSTART, "--quick", "--threads", threads, "--seed", seed, "--output", text(&out)]);
        shared_files(&out)
    };
    let first = run("first", "1", "3");
    assert_eq!(first, run("second", "2", "3"));
    assert_ne!(first, run("other", "1", "4"));
}

#[test]
fn a_printed_config_is_the_one_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let (out, saved) = (folder.path().join("run"), folder.path().join("whole.toml"));
    let quick_run = ["run", QUICKSTART, "--quick", "--set", "train.epochs=1"];
    let printed = good(&[&quick_run[..], &["--print-config"]].concat());
    fs::write(&saved, &printed).unwrap();
    assert_eq!(printed, good(&["run", text(&saved), "--print-config"]));
    good(&[&quick_run[..], &["--output", text(&out)]].concat());
    assert_eq!(printed, fs::read_to_string(out.join("config.toml")).unwrap());
}

#[test]
fn a_part_of_a_run_and_the_rest_later_make_the_bytes_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let quick = ["run", QUICKSTART, "--quick", "--set", "train.epochs=1", "--output"];
    good(&[&quick[..], &[text(&whole)]].concat());
    let part = [&quick[..], &[text(&parts)]].concat();
    let error = refused(&[&part[..], &["--only", "mpl"]].concat());
    assert!(error.contains("only = \"mpl\"") && error.contains("did you mean `mlp`?"), "{error}");
    assert!(!parts.exists());
    let table = good(&[&part[..], &["--only", "mlp,mini-rocket.r0.f1"]].concat());
    assert!(table.contains("11 folds are missing"), "{table}");
    let mut finished: Vec<String> = fs::read_dir(parts.join("models"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    finished.sort();
    let names = ["mini-rocket.r0.f1", "mlp.r0.f0", "mlp.r0.f1"].map(|name| format!("{name}.safetensors"));
    assert_eq!(finished, names);
    good(&[&part[..], &["--resume"]].concat());
    assert_eq!(shared_files(&whole), shared_files(&parts));
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_readable_folder_and_resume_ends_with_the_same_bytes() {
    use std::process::{Command as Process, Stdio};
    use std::time::{Duration, Instant};
    let folder = tempfile::tempdir().unwrap();
    let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
    let arguments = |out: &Path| {
        ["run", QUICKSTART, "--quick", "--set", "train.epochs=12", "--format", "json", "--output", text(out)]
            .map(String::from)
    };
    let wait = |child: &mut std::process::Child| {
        let start = Instant::now();
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                return status;
            }
            assert!(start.elapsed() < Duration::from_secs(120), "still running");
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let start = |out: &Path| {
        let binary = assert_cmd::cargo::cargo_bin!("taxel");
        Process::new(binary)
            .args(arguments(out))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    assert!(wait(&mut start(&whole)).success());
    let mut child = start(&cut);
    let begun = Instant::now();
    while !cut.join("folds").exists() || fs::read_dir(cut.join("folds")).unwrap().count() == 0 {
        assert!(begun.elapsed() < Duration::from_secs(60), "no fold finished");
        std::thread::sleep(Duration::from_millis(1));
    }
    Process::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let status = wait(&mut child);
    assert_eq!(status.code(), Some(130));
    let results: serde_json::Value =
        serde_json::from_slice(&fs::read(cut.join("results.json")).unwrap()).unwrap();
    assert_eq!(results["complete"], false);
    let mut resumed = arguments(&cut).to_vec();
    assert!(refused(&resumed.iter().map(String::as_str).collect::<Vec<_>>()).contains("--resume"));
    resumed.push("--resume".into());
    good(&resumed.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(shared_files(&whole), shared_files(&cut));
}

#[test]
fn choose_names_the_smallest_that_suffices() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let quick = ["run", QUICKSTART, "--quick", "--set", "train.epochs=1", "--set", "data.samples=60"];
    let baselines = ["--set", "baselines=[\"majority\", \"k-nn\"]", "--output", text(&run)];
    good(&[&quick[..], &baselines].concat());
    let shown = good(&["choose", text(&run), "--by", "size"]);
    assert!(shown.contains("95 % interval") && shown.contains("chosen"), "{shown}");
    assert!(shown.contains("majority") && shown.contains("worse"), "{shown}");
    assert!(shown.contains("Not tested under faults: run taxel stress"), "{shown}");
    let json: serde_json::Value =
        serde_json::from_str(&good(&["choose", text(&run), text(&run), "--format", "json"])).unwrap();
    let choices = json["choices"].as_array().unwrap();
    assert_eq!((choices.len(), &json["across"]), (2, &serde_json::Value::Null));
    let choice = &choices[0]["choice"];
    assert_eq!(choice["evidence"].as_array().unwrap().len(), 4);
    // Each but the best names the test that gave its p.
    let tested = choice["evidence"].as_array().unwrap().iter().filter(|row| row["test"].is_string()).count();
    assert_eq!((tested, &choice["criteria"]["clean_only"]), (3, &serde_json::json!(false)));
    // Nobody loses less than nothing to faults; majority does, and is never chosen.
    let none = taxel(&["choose", text(&run), "--max-loss", "0"]);
    let shown = String::from_utf8(none.stdout).unwrap();
    assert_eq!(none.status.code(), Some(1), "{shown}");
    assert!(shown.contains("Nothing suffices") && shown.contains("lost to faults"), "{shown}");
    assert!(refused(&["choose", text(&run), "--alpha", "2"]).starts_with("alpha = 2: must be in (0, 1)"));
    assert!(refused(&["choose", text(folder.path())]).contains("no run folder"));
}

#[test]
fn report_makes_pages_of_runs_and_one_of_them_all() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (first, second, out) = (at("first run"), at("second"), at("side by side"));
    for run in [&first, &second] {
        let few = ["--set", "train.epochs=1", "--set", "data.samples=40", "--output", text(run)];
        good(&[&["run", QUICKSTART, "--quick"], &few[..]].concat());
    }
    let said = good(&["report", text(&first), "--max-samples", "10", "--format", "json"]);
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        (said["kind"].as_str(), said["networks"][0]["network"].as_str()),
        (Some("simulated"), Some("mlp"))
    );
    assert!(said["networks"][0]["latency_p50_ms"].as_f64().unwrap() > 0.0);
    let page = fs::read(first.join("report.html")).unwrap();
    // Measured once: the same judgement makes the same bytes, now beside another run.
    let judgement = fs::read(first.join("judgement.json")).unwrap();
    let said = good(&["report", text(&first), text(&second), "--no-stress", "--output", text(&out)]);
    assert!(said.contains("resnet8-lite-1d") && said.contains("report.html"), "{said}");
    assert_eq!(fs::read(first.join("judgement.json")).unwrap(), judgement);
    assert_eq!(fs::read(first.join("report.html")).unwrap(), page);
    assert!(fs::read_to_string(second.join("report.html")).unwrap().contains("Not tested."));
    let index = fs::read_to_string(out.join("index.html")).unwrap();
    assert!(index.contains(r#"href="../first%20run/report.html""#), "{index}");
    assert!(
        out.join("tables/overview-simulated.csv").is_file() && !out.join("tables/overview-real.csv").exists()
    );
    let error = refused(&["report", text(&at("nothing"))]);
    assert!(error.contains("nothing") && error.contains("no such file or folder"), "{error}");
}

#[test]
fn from_recordings_to_a_shipped_model() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    good(&["simulate", "fingertip", "--samples", "60", "--output", text(&at("grasps.npz"))]);
    let quick = ["--quick", "--set", "baselines=[\"majority\", \"k-nn\", \"svm-linear\"]"];
    let (data, run) = (at("grasps.npz"), at("run"));
    good(&[&["run", QUICKSTART, "--data", text(&data), "--output", text(&run)], &quick[..]].concat());

    // The run's own model gives the run's own probabilities, bit for bit, in a folder with nothing else.
    let apart = at("alone");
    fs::create_dir(&apart).unwrap();
    let record: serde_json::Value =
        serde_json::from_slice(&fs::read(run.join("folds/mlp.r0.f0.json")).unwrap()).unwrap();
    fs::copy(run.join("models/mlp.r0.f0.safetensors"), apart.join("m.safetensors")).unwrap();
    let rows: Vec<usize> =
        record["index"].as_array().unwrap().iter().map(|i| i.as_u64().unwrap() as usize).collect();
    let set = taxel_data::load(&data, &taxel_data::ReadOptions::default()).unwrap().select(&rows);
    let mut npz = taxel_data::Npz::default();
    npz.add("x", set.x.shape(), set.x.as_slice().unwrap()).unwrap();
    fs::write(apart.join("tested.npz"), npz.finish().unwrap()).unwrap();
    let [model, tested, out] = ["m.safetensors", "tested.npz", "p.npz"].map(|name| apart.join(name));
    good(&["predict", text(&model), text(&tested), "--format", "npz", "--output", text(&out)]);
    let mut answers = npyz::npz::NpzArchive::open(&out).unwrap();
    let got: Vec<f32> = answers.by_name("probabilities").unwrap().unwrap().into_vec().unwrap();
    let want: Vec<f32> =
        record["probabilities"].as_array().unwrap().iter().map(|p| p.as_f64().unwrap() as f32).collect();
    assert_eq!(got, want);

    // The one that suffices, on all recordings, with the run's score; and one by name.
    let [chosen, named] = ["chosen.safetensors", "named.safetensors"].map(at);
    let card = good(&["fit", text(&run), "--output", text(&chosen)]);
    assert!(card.contains("(all of them)") && card.contains("± "), "{card}");
    good(&["fit", text(&run), "--network", "resnet8-lite-1d", "--output", text(&named), "--format", "json"]);
    assert!(good(&["inspect", text(&named)]).contains("reads        series, channels × time: 5 × 50"));
    let json: serde_json::Value =
        serde_json::from_str(&good(&["inspect", text(&named), "--format", "json"])).unwrap();
    assert_eq!(json["trained_on"]["samples"], 60);
    assert!(json["score"]["mean"]["accuracy"].is_f64());
    let again = at("again.safetensors");
    good(&["fit", text(&run), "--network", "resnet8-lite-1d", "--output", text(&again), "--threads", "1"]);
    assert!(fs::read(&named).unwrap() == fs::read(&again).unwrap(), "equal fits give equal bytes");

    // Labels only score; without them there is nothing to say.
    let scored = taxel(&["predict", text(&named), text(&data), "--format", "csv"]);
    assert_eq!(String::from_utf8(scored.stdout).unwrap().lines().count(), 61);
    assert!(String::from_utf8(scored.stderr).unwrap().contains("of 60 right"));
    let unscored = taxel(&["predict", text(&named), text(&tested)]);
    assert!(unscored.status.success() && unscored.stderr.is_empty(), "{unscored:?}");
    let one = at("press.csv");
    let row = |t: usize| (0..5).map(|c| set.x[[0, c, t]].to_string()).collect::<Vec<_>>().join(",");
    fs::write(&one, (0..50).map(row).collect::<Vec<_>>().join("\n")).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&good(&["predict", text(&named), text(&one), "--format", "json"])).unwrap();
    assert_eq!(json["answers"].as_array().unwrap().len(), 1);

    // What cannot be is said.
    let error = refused(&["predict", text(&run.join("config.toml")), text(&data)]);
    assert!(error.contains("config.toml"), "{error}");
    let error = refused(&["fit", text(&run), "--network", "nobody", "--output", text(&at("x.safetensors"))]);
    assert!(error.contains("nobody") && error.contains("resnet8-lite-1d"), "{error}");
    let error = refused(&["fit", QUICKSTART, "--output", text(&at("x.safetensors"))]);
    assert!(error.contains("--network"), "{error}");
    fs::write(&one, "1,2\n3,4\n").unwrap();
    let error = refused(&["predict", text(&named), text(&one)]);
    assert!(error.contains("press.csv") && error.contains("[5, 50]"), "{error}");
}

#[test]
fn a_run_on_own_data_bears_its_name_and_opens_from_anywhere() {
    let folder = TempDir::new().unwrap();
    good(&[
        "simulate",
        "fingertip",
        "--samples",
        "40",
        "--output",
        text(&folder.path().join("my glove.npz")),
    ]);
    let run = |arguments: &[&str], here: &str| {
        let mut command = Command::cargo_bin("taxel").unwrap();
        let output = command.current_dir(folder.path().join(here)).args(arguments).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let few = ["--quick", "--set", "train.epochs=1", "--set", "baselines=[\"majority\"]"];
    let shown = run(&[&["run", QUICKSTART, "--data", "my glove.npz"], &few[..]].concat(), "");
    assert!(shown.starts_with("my-glove\n") && shown.contains("simulated: fingertip (my glove)"), "{shown}");
    assert!(!shown.contains("published") && !shown.contains("five fingertips"), "{shown}");
    run(&["report", "../runs/my-glove-quick", "--no-stress"], "runs");
}

#[test]
fn help_teaches() {
    for command in [
        "run",
        "report",
        "stress",
        "choose",
        "fit",
        "predict",
        "inspect",
        "export",
        "import",
        "zoo",
        "cost",
        "forward",
        "stitch",
        "encode",
        "simulate",
        "data",
        "completions",
    ] {
        let help =
            if command == "data" { good(&["data", "check", "--help"]) } else { good(&[command, "--help"]) };
        assert!(help.contains("Example"), "{command} --help has no example");
    }
    assert!(good(&["data", "convert", "--help"]).contains("Example"));
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(["cost", "densenet201"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}
