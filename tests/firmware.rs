//! Models as C, as a user makes them: what is printed has the bits of `taxel predict`, and says what it takes.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

const CLASSES: &str = r#"
name = "presses"
baselines = ["mini-rocket", "k-nn"]
[data]
scene = "fingertip"
samples = 120
[encoding]
signal = { kind = "quantile-code" }
[protocol]
folds = 2
[train]
epochs = 3
batch_size = 16
[[networks]]
name = "resnet8-lite-1d"
"#;

const VALUES: &str = r#"
name = "shore"
baselines = ["ridge", "mini-rocket"]
[data]
scene = "fingertip"
samples = 80
y = "shore"
[encoding]
signal = { kind = "history" }
[protocol]
folds = 2
[train]
epochs = 3
batch_size = 16
loss = "gaussian-likelihood"
[[networks]]
name = "deep-mlp"
"#;

const IMAGES: &str = r#"
name = "imprints"
[data]
scene = "imprint"
samples = 60
set = { elements = 16 }
[encoding]
image = { kind = "raw", scale = "full-scale" }
[protocol]
folds = 2
[train]
epochs = 2
batch_size = 16
[[networks]]
name = "resnet8-lite-2d"
"#;

const FIELDS: &str = r#"
name = "fields"
[data]
scene = "fingertip"
samples = 60
[encoding]
image = { kind = "gadf", size = 16 }
[protocol]
folds = 2
[train]
epochs = 1
batch_size = 16
[[networks]]
name = "resnet8-lite-2d"
"#;

/// Two attributes of series; the loss is filled in.
const ATTRIBUTES: &str = r#"
name = "two"
[data]
path = "own.npz"
layout = "series"
attributes = ["shore", "size"]
[encoding]
signal = { scale = "z-score" }
[protocol]
folds = 2
[train]
epochs = 2
batch_size = 16
loss = "LOSS"
[[networks]]
name = "resnet8-lite-1d"
"#;

/// A run, and the commands on it.
struct Ran(TempDir);

impl Ran {
    fn new(config: &str) -> Self {
        Self::of(config, "fingertip")
    }

    /// Runs an experiment; `own.npz` are new samples of a scene.
    fn of(config: &str, scene: &str) -> Self {
        let ran = Ran(tempfile::tempdir().unwrap());
        ran.says(&format!("simulate {scene} --samples 60 --seed 7 --output own.npz"));
        ran.run(config);
        ran
    }

    fn run(&self, config: &str) {
        fs::write(self.path("c.toml"), config).unwrap();
        self.says("run c.toml --output run");
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn runs(&self, command: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_taxel"))
            .current_dir(self.0.path())
            .args(command.split(' '))
            .env("TAXEL_THREADS", "2")
            .env_remove("RUST_BACKTRACE")
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    /// Runs a command that ends with this code, and returns what it said.
    fn ends(&self, command: &str, code: i32) -> String {
        let Output { status, stdout, stderr } = self.runs(command);
        let said = [stdout, stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        assert_eq!(status.code(), Some(code), "{command}: {said}");
        said
    }

    fn says(&self, command: &str) -> String {
        self.ends(command, 0)
    }

    /// Fits a method, puts a network in eight bits, and returns the model.
    fn model(&self, name: &str, is_network: bool) -> String {
        let file = format!("{name}.safetensors");
        self.says(&format!("fit run --network {name} --output {file}"));
        if is_network {
            self.says(&format!("quantize {file} --calibrate own.npz --output small.safetensors"));
            return "small.safetensors".into();
        }
        file
    }

    /// Exports a model, compiles its test and runs it; returns the header.
    fn has_the_same_bits(&self, model: &str, name: &str) -> String {
        self.says(&format!("export {model} --format c --name {name} --output {name}"));
        let (source, program) = (self.path(name).join("test/check.c"), self.path("check"));
        for flags in [["-std=c99", "-O2"], ["-std=c99", "-ffast-math"]] {
            let warnings = ["-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Werror", "-O1"];
            let compiled =
                Command::new("cc").args(warnings).args(flags).arg(&source).arg("-o").arg(&program).output();
            let compiled = compiled.unwrap();
            assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
            let ran = Command::new(&program).output().unwrap();
            let said = String::from_utf8_lossy(&ran.stdout).into_owned();
            assert!(
                ran.status.success() && said.starts_with("equal: 200 samples"),
                "{name} {flags:?}: {said}"
            );
        }
        header(&self.path(name), name)
    }
}

fn header(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(format!("src/taxel_{name}.h"))).unwrap()
}

#[test]
fn classes_leave_with_their_code_their_gate_and_what_they_take() {
    let ran = Ran::new(CLASSES);
    let rocket = ran.model("mini-rocket", false);
    let with = ran.has_the_same_bits(&rocket, "rocket");
    assert!(with.contains("taxel_rocket_is_unknown") && with.contains("taxel_rocket_distance"), "{with}");
    assert!(with.contains("taxel_rocket_readings_are_unknown"), "{with}");
    let small = ran.model("resnet8-lite-1d", true);
    let with = ran.has_the_same_bits(&small, "glove");
    assert!(with.contains("#define TAXEL_GLOVE_RING_BYTES 1000u"), "{with}");
    let said = ran.says(&format!("cost {small} --target m4f"));
    assert!(said.contains("instructions, not cycles") && said.contains("RAM "), "{said}");
    let counted: Value =
        serde_json::from_str(&ran.says(&format!("cost {small} --target m0 --format json"))).unwrap();
    let m4: Value =
        serde_json::from_str(&ran.says(&format!("cost {small} --target m4f --format json"))).unwrap();
    assert!(counted["instructions"].as_u64() > m4["instructions"].as_u64(), "{counted} {m4}");
    assert!(with.contains(&format!("_RAM_BYTES {}u", m4["ram_bytes"])), "{m4}");
    let with = ran.has_the_same_bits("resnet8-lite-1d.safetensors", "floats");
    assert!(with.contains("#define TAXEL_FLOATS_NEEDS_FPU 1u"), "{with}");
    let said = ran.says("cost resnet8-lite-1d.safetensors --target m4f");
    assert!(said.contains("instructions, not cycles"), "{said}");
    let said = ran.says(&format!("cost {rocket} --target m4f"));
    assert!(said.contains("not counted for this kind of model"), "{said}");
    ran.says("fit run --network k-nn --output k-nn.safetensors");
    for (command, reason) in [
        ("export k-nn.safetensors --format c --output x", "is a baseline without C"),
        ("export k-nn.safetensors --format c --output x", "taxel fit RUN --network mini-rocket"),
        ("cost k-nn.safetensors --target m4f", "is a baseline without C"),
        ("cost resnet8-lite-1d.safetensors --target m3", "instructions a product would be needed"),
        ("cost mlp --target m4f", "--target counts a model file"),
        ("cost small.safetensors --target m5", "[possible values: m0, m3, m4f"),
        ("choose run --max-flash 64q", "is no size of memory"),
        ("choose run --max-ram 0", "must be above 0"),
    ] {
        let said = ran.ends(command, 2);
        assert!(said.contains(reason), "{command}: {said}");
    }
    assert!(!ran.path("x").exists());
    ran.says("quantize run");
    let said = ran.says("choose run --max-flash 2M --max-ram 64k --margin 100 --alpha 0.000001 --by size");
    for wanted in ["has no C: is a baseline without C", "As C it takes about"] {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
    let said = ran.ends("choose run --max-flash 1k", 1);
    assert!(
        said.contains("Nothing suffices") && said.contains("bytes of flash, and 1,024 are there"),
        "{said}"
    );
    let found: Value = serde_json::from_str(&ran.ends("choose run --max-ram 100 --format json", 1)).unwrap();
    let room = &found["choices"][0]["choice"]["criteria"]["room"];
    assert!(room["needs"]["mini-rocket"]["ram"].as_u64() > Some(100), "{room}");
}

#[test]
fn values_leave_with_their_intervals_and_a_short_ring() {
    let ran = Ran::new(VALUES);
    for (name, is_network) in [("ridge", false), ("mini-rocket", false), ("deep-mlp", true)] {
        let model = ran.model(name, is_network);
        let library = name.replace('-', "_");
        let with = ran.has_the_same_bits(&model, &library);
        assert!(with.contains(&format!("taxel_{library}_intervals")), "{with}");
        assert!(with.contains("_QUANTITIES 1u") && !with.contains("_CLASSES"), "{with}");
        assert!(with.contains(&format!("taxel_{library}_readings_are_unknown")), "{with}");
    }
    let with = header(&ran.path("deep_mlp"), "deep_mlp");
    assert!(with.contains("#define TAXEL_DEEP_MLP_RING_STEPS 33u"), "{with}");
    let readme = fs::read_to_string(ran.path("deep_mlp/README.md")).unwrap();
    assert!(readme.contains("| values | 1: shore in Shore A, each with its 90 % interval |"), "{readme}");
}

#[test]
fn images_leave_whole_and_what_is_no_image_of_the_sensor_is_refused() {
    let ran = Ran::of(IMAGES, "imprint --set elements=16");
    let small = ran.model("resnet8-lite-2d", true);
    let with = ran.has_the_same_bits(&small, "skin");
    for wanted in ["_CHANNELS 1u", "_ROWS 16u", "_COLUMNS 16u", "taxel_skin_readings_are_unknown"] {
        assert!(with.contains(wanted), "{wanted}: {with}");
    }
    assert!(!with.contains("push"), "{with}");
    let m4: Value =
        serde_json::from_str(&ran.says(&format!("cost {small} --target m4f --format json"))).unwrap();
    assert!(with.contains(&format!("_RAM_BYTES {}u", m4["ram_bytes"])), "{m4}");
    assert!(m4["ring_bytes"] == 0 && m4["fits"] == true && m4["part"]["name"] == "STM32L4R9", "{m4}");
    let said = ran.says(&format!("cost {small} --target m4f"));
    assert!(said.contains("fits          yes: a large part with this core"), "{said}");
    let said = ran.ends("export resnet8-lite-2d.safetensors --format c --output x", 2);
    assert!(said.contains("in 32-bit floats (") && said.contains("in eight bits alone"), "{said}");
    let ran = Ran::new(FIELDS);
    let small = ran.model("resnet8-lite-2d", true);
    let said = ran.ends(&format!("export {small} --format c --output x"), 2);
    assert!(said.contains("Gramian angular field") && said.contains("768 values made of the 250"), "{said}");
    assert!(!ran.path("x").exists());
}

#[test]
fn several_attributes_leave_one_after_the_other() {
    let ran = Ran(tempfile::tempdir().unwrap());
    let value = |i: usize| (((i * 2_654_435_761) >> 7) % 1000) as f32 / 1000.0 + (i / 250 % 3) as f32;
    let x: Vec<f32> = (0..60 * 250).map(value).collect();
    let y: Vec<f32> = (0..60).flat_map(|i| [(i % 3) as f32, (i % 2) as f32]).collect();
    let mut npz = taxel::data::Npz::default();
    npz.add("x", &[60, 5, 50], &x).unwrap();
    npz.add("y", &[60, 2], &y).unwrap();
    fs::write(ran.path("own.npz"), npz.finish().unwrap()).unwrap();
    for loss in ["multi-label-soft-margin", "cumulative-logits", "mean-squared-error"] {
        ran.run(&ATTRIBUTES.replace("LOSS", loss));
        let small = ran.model("resnet8-lite-1d", true);
        let with = ran.has_the_same_bits(&small, "two");
        for wanted in
            ["_CLASSES 5u", "_ATTRIBUTES 2u", "_CLASSES_0 3u /* shore */", "_CLASSES_1 2u /* size */"]
        {
            assert!(with.contains(wanted), "{wanted}: {with}");
        }
        fs::remove_dir_all(ran.path("run")).unwrap();
    }
}

#[test]
fn what_needs_more_than_there_is_is_refused_before_anything_is_written() {
    let ran = Ran::new(CLASSES);
    let small = ran.model("resnet8-lite-1d", true);
    let header = ran.has_the_same_bits(&small, "glove");
    let number = |name: &str| -> u64 {
        let line = header.lines().find(|line| line.contains(&format!("TAXEL_GLOVE_{name} "))).unwrap();
        line.rsplit(' ').next().unwrap().trim_end_matches('u').parse().unwrap()
    };
    let (flash, ram) = (number("FLASH_BYTES"), number("RAM_BYTES") + number("RING_BYTES"));
    let export = |limits: &str| format!("export {small} --format c {limits} --output x");
    let thousands = taxel::base::thousands;
    let said = ran.ends(&export(&format!("--max-flash {} --max-ram {}", flash - 1, ram - 1)), 2);
    for (what, taken) in [("flash", flash), ("RAM", ram)] {
        let words = format!("{} bytes of {what}, and {} are there", thousands(taken), thousands(taken - 1));
        assert!(said.contains(&words), "{words}: {said}");
    }
    assert!(said.contains("nothing was written"), "{said}");
    assert!(!ran.path("x").exists(), "{said}");
    for (limits, reason) in [("--max-flash 64q", "is no size of memory"), ("--max-ram 0", "must be above 0")]
    {
        let said = ran.ends(&export(limits), 2);
        assert!(said.contains(reason), "{said}");
    }
    let said = ran.ends("export resnet8-lite-1d.safetensors --max-ram 16k --output x.onnx", 2);
    assert!(said.contains("belong to --format c"), "{said}");
    ran.says(&export(&format!("--max-flash {flash} --max-ram {ram}")));
    assert!(ran.path("x/README.md").exists());
}
