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

/// A run, and the commands on it.
struct Ran(TempDir);

impl Ran {
    fn new(config: &str) -> Self {
        let ran = Ran(tempfile::tempdir().unwrap());
        fs::write(ran.path("c.toml"), config).unwrap();
        ran.says("run c.toml --output run");
        ran.says("simulate fingertip --samples 60 --seed 7 --output own.npz");
        ran
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
