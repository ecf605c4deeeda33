//! Every reader of files as a function of bytes. The fuzz targets and `tests/readers.rs` call the same ones.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use taxel::data::{Npz, ReadOptions, check_with, load, npy_bytes, recordings};
use taxel::judge::{Case, Judgement};
use taxel::learn::{RunOptions, Silent};
use taxel::ndarray::ArrayD;
use taxel::scenes::Settings;
use taxel::{
    Baseline, Candidate, Conv, Dataset, Encoding, Experiment, Layout, Length, Model, Network, Overrides,
    Registry, ResultsTable, RunFolder,
};

/// A kind of file and who reads it.
pub struct Reader {
    /// Name of the fuzz target.
    pub name: &'static str,
    /// Small whole files to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads the bytes as a file in a folder that no other reader uses. Answers whether they were accepted.
    pub read: fn(&Path, &[u8]) -> bool,
}

/// All of them.
pub const READERS: &[Reader] = &[
    Reader { name: "npz", seeds: npz, read: |folder, bytes| data_set(folder, "data.npz", bytes) },
    Reader { name: "npy", seeds: npy, read: |folder, bytes| class_folder(folder, "npy", bytes) },
    Reader { name: "mat", seeds: mat, read: |folder, bytes| data_set(folder, "data.mat", bytes) },
    Reader { name: "csv", seeds: csv, read: |folder, bytes| class_folder(folder, "csv", bytes) },
    Reader { name: "jsonl", seeds: jsonl, read: |folder, bytes| class_folder(folder, "jsonl", bytes) },
    Reader { name: "parquet", seeds: parquet, read: |folder, bytes| data_set(folder, "data.parquet", bytes) },
    Reader { name: "hdf5", seeds: hdf5, read: |folder, bytes| data_set(folder, "data.h5", bytes) },
    Reader { name: "mcap", seeds: mcap, read: |folder, bytes| class_folder(folder, "mcap", bytes) },
    Reader { name: "ts", seeds: ts, read: |folder, bytes| ucr(folder, "ts", bytes) },
    Reader { name: "tsv", seeds: tsv, read: |folder, bytes| ucr(folder, "tsv", bytes) },
    Reader { name: "png", seeds: png, read: |folder, bytes| class_folder(folder, "png", bytes) },
    Reader { name: "jpeg", seeds: jpeg, read: |folder, bytes| class_folder(folder, "jpg", bytes) },
    Reader { name: "labels", seeds: labels, read: names_beside },
    Reader { name: "obj", seeds: obj, read: |folder, bytes| mesh(folder, "obj", bytes) },
    Reader { name: "stl", seeds: stl, read: |folder, bytes| mesh(folder, "stl", bytes) },
    Reader { name: "off", seeds: off, read: |folder, bytes| mesh(folder, "off", bytes) },
    Reader {
        name: "safetensors",
        seeds: safetensors,
        read: |folder, bytes| checkpoint(folder, "safetensors", bytes),
    },
    Reader { name: "pth", seeds: pth, read: |folder, bytes| checkpoint(folder, "pth", bytes) },
    Reader { name: "model", seeds: model, read: read_model },
    Reader { name: "onnx", seeds: onnx, read: |folder, bytes| network(folder, "network.onnx", bytes) },
    Reader {
        name: "network",
        seeds: networks,
        read: |folder, bytes| network(folder, "network.safetensors", bytes),
    },
    Reader { name: "config", seeds: config, read: read_config },
    Reader { name: "results", seeds: results, read: |folder, bytes| run_file(folder, "results.json", bytes) },
    Reader { name: "fold", seeds: fold, read: |folder, bytes| run_file(folder, FOLD, bytes) },
    Reader {
        name: "environment",
        seeds: environment,
        read: |folder, bytes| run_file(folder, "environment.json", bytes),
    },
    Reader {
        name: "experiment",
        seeds: experiment,
        read: |folder, bytes| run_file(folder, "config.toml", bytes),
    },
];

/// A fold's record in the run that [`run_folder`] makes.
const FOLD: &str = "folds/k-nn.r0.f0.json";

/// Writes the bytes where the reader looks for them.
fn put(path: &Path, bytes: &[u8]) {
    fs::create_dir_all(path.parent().expect("a file in a folder")).expect("a folder for the file");
    fs::write(path, bytes).expect("room for the file");
}

/// Whether something was read; a refusal has to name what lies at `path`.
fn read_or_named<T>(path: &Path, read: taxel::data::Result<T>) -> bool {
    if let Err(error) = &read {
        let (text, name) = (error.to_string(), path.file_name().expect("a name").to_string_lossy());
        assert!(text.contains(&*name), "the message does not name {name}: {text}");
    }
    read.is_ok()
}

/// Checks and loads the data set at `path`.
fn load_set(path: &Path) -> bool {
    let options = ReadOptions::default();
    let read = check_with(path, &options).map(|card| card.to_string()).and_then(|_| load(path, &options));
    read_or_named(path, read)
}

/// Reads the file or folder at `path` without its labels, as a model does that is to answer. What the model takes
/// follows from the size of the file, so that a file is read once and a fuzzer still meets each kind.
fn unlabelled(path: &Path, bytes: &[u8]) -> bool {
    let (rank, windows) = (1 + bytes.len() % 3, bytes.len() % 2 == 1);
    let options = if windows {
        ReadOptions {
            layout: Some(Layout::Series),
            length: Some(Length::Window { to: 2, hop: None }),
            ..ReadOptions::default()
        }
    } else {
        ReadOptions::default()
    };
    read_or_named(path, recordings(path, &options, rank))
}

fn data_set(folder: &Path, file: &str, bytes: &[u8]) -> bool {
    let path = folder.join(file);
    put(&path, bytes);
    unlabelled(&path, bytes) | load_set(&path)
}

/// As a folder per class, and as a single recording.
fn class_folder(folder: &Path, ending: &str, bytes: &[u8]) -> bool {
    let set = folder.join("set");
    let file = |class: &str| set.join(class).join(format!("1.{ending}"));
    for class in ["soft", "hard"] {
        put(&file(class), bytes);
    }
    unlabelled(&file("soft"), bytes) | load_set(&set)
}

fn ucr(folder: &Path, ending: &str, bytes: &[u8]) -> bool {
    for part in ["TRAIN", "TEST"] {
        put(&folder.join(format!("Touch_{part}.{ending}")), bytes);
    }
    let stem = folder.join("Touch");
    unlabelled(&stem, bytes) | load_set(&stem)
}

fn names_beside(folder: &Path, bytes: &[u8]) -> bool {
    put(&folder.join("data.npz"), &npz()[0]);
    put(&folder.join("labels.json"), bytes);
    let path = folder.join("data.npz");
    // A damaged file of names is named itself.
    check_with(&path, &ReadOptions::default()).map(|card| card.to_string()).is_ok()
        && load(&path, &ReadOptions::default()).is_ok()
}

fn mesh(folder: &Path, ending: &str, bytes: &[u8]) -> bool {
    let meshes = folder.join("meshes");
    for class in ["ball", "box"] {
        put(&meshes.join(class).join(format!("1.{ending}")), bytes);
    }
    let settings = serde_json::json!({"elements": 8, "meshes": meshes});
    Settings::read("imprint", settings).and_then(|scene| scene.simulate(2, 0, &[])).is_ok()
}

fn checkpoint(folder: &Path, ending: &str, bytes: &[u8]) -> bool {
    let path = folder.join(format!("weights.{ending}"));
    put(&path, bytes);
    let read = taxel_checkpoint::read(&path);
    if let Ok((weights, _)) = &read {
        for (name, tensor) in weights.iter() {
            assert_eq!(tensor.shape.iter().product::<usize>(), tensor.data.len(), "{name}");
        }
    }
    read.is_ok()
}

fn read_model(folder: &Path, bytes: &[u8]) -> bool {
    let path = folder.join("model.safetensors");
    put(&path, bytes);
    let Ok(model) = Model::open(&path) else { return false };
    let _ = model.card().to_string();
    model.predict(&presses().x).is_ok()
}

/// A network from a file, as a config names it.
fn network(folder: &Path, file: &str, bytes: &[u8]) -> bool {
    let path = folder.join(file);
    put(&path, bytes);
    match taxel::experiment::read_network(&path) {
        Ok((graph, weights)) => {
            weights.check(&graph).expect("weights of the graph");
            let _ = (graph.cost(), graph.with_classes(2));
            true
        }
        Err(error) => {
            assert!(error.to_string().contains(file), "the message does not name {file}: {error}");
            false
        }
    }
}

fn read_config(_: &Path, bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let read = |quick| {
        let overrides = Overrides { quick, ..Overrides::default() };
        Experiment::parse(&text, "config.toml", &overrides, &Registry::built_in())
    };
    let quick = read(true).is_ok();
    read(false).is_ok_and(|experiment| !experiment.to_toml().is_empty()) || quick
}

/// Puts `bytes` in the place of one file of a run, opens the run, and puts the file back.
fn run_file(folder: &Path, file: &str, bytes: &[u8]) -> bool {
    let run = folder.join("run");
    if !run.exists() {
        run_folder(folder);
    }
    let path = run.join(file);
    let whole = fs::read(&path).expect("a file of a whole run");
    put(&path, bytes);
    let opened = open_run(&run);
    put(&path, &whole);
    opened
}

fn open_run(run: &Path) -> bool {
    let Ok(folder) = RunFolder::open(run) else { return false };
    let shown =
        ResultsTable::of(&folder).map(|table| table.to_string()).is_ok() && folder.environment().is_ok();
    let Ok((_, dataset)) = taxel::experiment::open(&folder, &Registry::built_in()) else { return false };
    let Ok(case) = Case::new(folder, dataset) else { return false };
    shown && Judgement::read(&case).is_ok()
}

/// A small run with two baselines.
fn run_folder(folder: &Path) {
    put(&folder.join("data.npz"), &npz()[0]);
    let text = config_of(&folder.join("data.npz"));
    let experiment = Experiment::parse(&text, "config.toml", &Overrides::default(), &Registry::built_in())
        .expect("a sound config");
    let (options, stop) = (RunOptions { threads: Some(1), ..RunOptions::default() }, AtomicBool::new(false));
    taxel::experiment::run(
        &experiment,
        &Registry::built_in(),
        Some(&folder.join("run")),
        &options,
        &Silent,
        &stop,
    )
    .expect("a sound run");
}

fn config_of(data: &Path) -> String {
    format!(
        "name = \"small\"\ntitle = \"small\"\nseed = 0\n[data]\npath = {:?}\n[protocol]\nkind = \"k-fold\"\nfolds = 2\n\
         [train]\nepochs = 1\nbatch_size = 4\n[[networks]]\nname = \"mlp\"\n[[baselines]]\nname = \"k-nn\"\n",
        data.display().to_string()
    )
}

/// Twelve presses of two things [N, channels, time].
fn presses() -> Dataset {
    let x = ArrayD::from_shape_fn(vec![12, 2, 6], |at| ((at[0] % 2) * 5 + at[0] + at[1] * at[2]) as f32);
    let labels: Vec<&str> = (0..12).map(|i| ["soft", "hard"][i % 2]).collect();
    Dataset::new("presses", Layout::Series, x, &labels).expect("a sound data set")
}

fn npz() -> Vec<Vec<u8>> {
    let x: Vec<f32> = presses().x.iter().copied().collect();
    let y: Vec<i64> = (0..12).map(|i| i % 2).collect();
    let groups: Vec<i64> = (0..12).map(|i| i / 4).collect();
    let mut archive = Npz::default();
    archive.add("x", &[12, 2, 6], &x).expect("x");
    archive.add("y", &[12], &y).expect("y");
    archive.add("group", &[12], &groups).expect("group");
    vec![archive.finish().expect("an archive")]
}

fn npy() -> Vec<Vec<u8>> {
    let values: Vec<f32> = (0..12u8).map(f32::from).collect();
    vec![
        npy_bytes(&[2, 6], &values).expect("an array"),
        npy_bytes(&[3, 2, 2], &[7i16; 12]).expect("an array"),
    ]
}

fn mat() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/data/tests/data/grasps-v4.mat").to_vec(),
        include_bytes!("../crates/data/tests/data/grasps-v6.mat").to_vec(),
        include_bytes!("../crates/data/tests/data/grasps-v7.mat").to_vec(),
        include_bytes!("../crates/data/tests/data/grasps-v73.mat").to_vec(),
    ]
}

fn parquet() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/data/tests/data/long.parquet").to_vec(),
        include_bytes!("../crates/data/tests/data/wide.parquet").to_vec(),
    ]
}

fn hdf5() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/data/tests/data/plain.h5").to_vec(),
        include_bytes!("../crates/data/tests/data/packed.h5").to_vec(),
        include_bytes!("../crates/data/tests/data/grasps-v73.mat").to_vec(),
    ]
}

fn mcap() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/data/tests/data/plain.mcap").to_vec(),
        include_bytes!("../crates/data/tests/data/lz4.mcap").to_vec(),
        include_bytes!("../crates/data/tests/data/text.mcap").to_vec(),
        include_bytes!("../crates/data/tests/data/press.mcap").to_vec(),
    ]
}

fn csv() -> Vec<Vec<u8>> {
    ["1,2,3\n4,5,6\n7,8,9\n", "time;left;right\n0.0;1e3;-2\n0.1;4;5\n", "1 2\n3 nan\n"]
        .map(|s| s.into())
        .into()
}

fn jsonl() -> Vec<Vec<u8>> {
    [
        "{\"t_ms\": 0, \"taxels\": [1, 2], \"on\": true}\n{\"t_ms\": 9, \"taxels\": [3, 4], \"on\": false}\n",
        "[1, 2.5]\n[3, -4e1]\n[5, 6]\n",
    ]
    .map(|s| s.into())
    .into()
}

fn ts() -> Vec<Vec<u8>> {
    let head = "# touch\n@problemName Touch\n@univariate false\n@dimensions 2\n@equalLength true\n\
                @classLabel true soft hard\n@data\n";
    vec![format!("{head}1,2,3:4,5,6:soft\n2,3,4:1,1,9:hard\n3,3,1:0,2,2:soft\n").into_bytes()]
}

fn tsv() -> Vec<Vec<u8>> {
    vec!["1\t0.5\t1.5\t-2\n2\t3\t2e1\t4\n1\t5\t6\t7\n".into()]
}

fn png() -> Vec<Vec<u8>> {
    let grey = image::GrayImage::from_fn(4, 3, |x, y| image::Luma([(40 * x + 9 * y) as u8]));
    let colour = image::RgbImage::from_fn(3, 3, |x, y| image::Rgb([(90 * x) as u8, (70 * y) as u8, 3]));
    vec![encoded(&grey.into(), image::ImageFormat::Png), encoded(&colour.into(), image::ImageFormat::Png)]
}

fn jpeg() -> Vec<Vec<u8>> {
    let grey = image::GrayImage::from_fn(8, 8, |x, y| image::Luma([(20 * x + 9 * y) as u8]));
    vec![encoded(&grey.into(), image::ImageFormat::Jpeg)]
}

fn encoded(picture: &image::DynamicImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(vec![]);
    picture.write_to(&mut bytes, format).expect("an encoder");
    bytes.into_inner()
}

fn labels() -> Vec<Vec<u8>> {
    vec![
        br#"["soft", "hard"]"#.to_vec(),
        br#"{"classes": ["soft", "hard"], "unit": "N", "rate_hz": 100.0, "full_scale": 40}"#.to_vec(),
        br#"{"classes": [["soft", "hard"]]}"#.to_vec(),
    ]
}

fn obj() -> Vec<Vec<u8>> {
    vec!["v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n".into()]
}

fn off() -> Vec<Vec<u8>> {
    vec!["OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n".into()]
}

fn stl() -> Vec<Vec<u8>> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0f32]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2usize]];
    let mut binary = vec![0; 80];
    binary.extend((faces.len() as u32).to_le_bytes());
    let mut text = String::from("solid four\n");
    for face in faces {
        binary.extend([0; 12]);
        text += "facet normal 0 0 1\nouter loop\n";
        for corner in face.map(|corner| corners[corner]) {
            binary.extend(corner.iter().flat_map(|v| v.to_le_bytes()));
            text += &format!("vertex {} {} {}\n", corner[0], corner[1], corner[2]);
        }
        binary.extend([0; 2]);
        text += "endloop\nendfacet\n";
    }
    vec![binary, (text + "endsolid four\n").into_bytes()]
}

fn safetensors() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/checkpoint/tests/data/float64.safetensors").to_vec(),
        include_bytes!("../crates/checkpoint/tests/data/float16.safetensors").to_vec(),
        include_bytes!("../crates/checkpoint/tests/data/tracked.safetensors").to_vec(),
    ]
}

fn pth() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/checkpoint/tests/data/state_dict.pth").to_vec(),
        include_bytes!("../crates/checkpoint/tests/data/legacy.pth").to_vec(),
    ]
}

fn model() -> Vec<Vec<u8>> {
    let presses = presses();
    let saved = |baseline| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("model.safetensors");
        let candidate = Candidate::baseline(baseline);
        let model = taxel::fit(&candidate, &presses, &Encoding::default()).expect("a fitted baseline");
        model.save(&path).expect("a file");
        fs::read(&path).expect("the file")
    };
    vec![saved(Baseline::Majority), saved(Baseline::NearestNeighbours { k: 1 })]
}

fn onnx() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../crates/onnx/tests/data/cnn1d.script.onnx").to_vec(),
        include_bytes!("../crates/onnx/tests/data/lstm.dynamo.onnx").to_vec(),
        include_bytes!("../crates/onnx/tests/data/shuffle.script.onnx").to_vec(),
        include_bytes!("../crates/onnx/tests/data/cnn3d.dynamo.onnx").to_vec(),
        include_bytes!("../crates/onnx/tests/data/mlp.dynamo.onnx").to_vec(),
    ]
}

fn networks() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("network.safetensors");
    let net = Network::new("small");
    let signal = net.input("signal", &[2, 6]).conv_bn_relu("stem", Conv::new(3, 3).pad(1));
    let graph = net.finish(&[("logits", signal.global_average_pool().linear("fc", 2))]).expect("a graph");
    let weights = taxel::graph::Weights::init(&graph, taxel::graph::Scheme::Pytorch, 0, "seed");
    taxel_checkpoint::write_network(&path, &graph, &weights).expect("a file");
    vec![fs::read(&path).expect("the file")]
}

fn config() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../configs/quickstart.toml").to_vec(),
        include_bytes!("../configs/real/ucr-coffee.toml").to_vec(),
        config_of(Path::new("data.npz")).into_bytes(),
    ]
}

/// Files of a sound run, made once.
fn of_run(file: &str) -> Vec<Vec<u8>> {
    static RUN: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = RUN.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        run_folder(folder.path());
        folder
    });
    vec![fs::read(folder.path().join("run").join(file)).expect("a file of the run")]
}

fn results() -> Vec<Vec<u8>> {
    of_run("results.json")
}

fn fold() -> Vec<Vec<u8>> {
    of_run(FOLD)
}

fn environment() -> Vec<Vec<u8>> {
    of_run("environment.json")
}

fn experiment() -> Vec<Vec<u8>> {
    of_run("config.toml")
}
