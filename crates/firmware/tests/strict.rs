//! Every kind of library, read by compilers and checkers that a strict project uses. None of them may say a word.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::attributes::attributes;
use common::images;
use common::linear::{convolutions, with_library};
use common::{Case, Own, SAMPLE, WARNINGS, classes, code, gated, readings_gate, values, z_score};
use taxel_firmware::{Answers, Features, Library, Shares, Spread, write_folder};

/// Networks of the zoo.
const NETWORKS: [&str; 5] =
    ["mlp", "vgg6-lite-1d", "resnet8-lite-1d", "densenet6-lite-1d", "dilated-resnet-1d"];

/// Networks in floats.
const FLOATS: [&str; 6] =
    ["resnet8-lite-1d", "mlp", "dilated-resnet-1d", "ds-cnn-1d", "layer-norm-mlp", "lstm"];

/// Compilers with the cores they compile for; C, and C++ where it says so.
const COMPILERS: [&str; 16] = [
    "gcc -std=c99 -O2",
    "gcc -std=c99 -O2 -DWHOLE_ENDINGS=1",
    "g++ -x c++ -std=c++17 -O2",
    "clang -std=c99 -O2",
    "clang++ -x c++ -std=c++17 -O2",
    "arm-none-eabi-gcc -std=c99 -O2 -mthumb -mcpu=cortex-m0 -DSOFT_FLOATS",
    "arm-none-eabi-gcc -std=c99 -O2 -mthumb -mcpu=cortex-m3 -DSOFT_FLOATS",
    "arm-none-eabi-gcc -std=c99 -O0 -mthumb -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16",
    "arm-none-eabi-gcc -std=c99 -O3 -mthumb -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16",
    "arm-none-eabi-gcc -std=c99 -O2 -mthumb -mcpu=cortex-m55 -mfloat-abi=hard",
    "arm-none-eabi-g++ -x c++ -std=c++17 -O2 -mthumb -mcpu=cortex-m0 -DSOFT_FLOATS",
    "arm-none-eabi-g++ -x c++ -std=c++17 -O2 -mthumb -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16",
    "arm-none-eabi-g++ -x c++ -std=c++17 -O2 -mthumb -mcpu=cortex-m55 -mfloat-abi=hard",
    "clang --target=arm-none-eabi -isystem /usr/lib/arm-none-eabi/include -std=c99 -O2 -mthumb -mcpu=cortex-m0 -DSOFT_FLOATS",
    "clang --target=arm-none-eabi -isystem /usr/lib/arm-none-eabi/include -std=c99 -O2 -mthumb -mcpu=cortex-m4 -mfloat-abi=hard",
    "clang --target=arm-none-eabi -isystem /usr/lib/arm-none-eabi/include -std=c99 -O2 -mthumb -mcpu=cortex-m55 -mfloat-abi=hard",
];

/// Those of a PC that read the test beside the library.
const HOST: [&str; 2] = ["gcc -std=c99 -O2", "clang -std=c99 -O2"];

/// Definitions that cppcheck is given: of a PC, an M4, an M0 and RISC-V without FPU. Helium's own types are unknown to it.
const CONFIGURATIONS: [&[&str]; 4] = [
    &["-D__GNUC__=12", "-D__SSE2__"],
    &["-D__GNUC__=12", "-D__arm__", "-D__ARM_FP=4", "-D__ARM_FEATURE_DSP=1", "-D__ARM_FEATURE_FMA=1"],
    &["-D__GNUC__=12", "-D__arm__", "-D__ARM_ARCH_6M__", "-DSOFT_FLOATS"],
    &["-D__GNUC__=12", "-D__riscv", "-DSOFT_FLOATS"],
];

/// Rules of MISRA C:2012 that are advisory.
const ADVISORY: [&str; 31] = [
    "2.3", "2.4", "2.5", "2.6", "2.7", "4.2", "5.9", "8.7", "8.9", "8.11", "8.13", "10.5", "11.4", "11.5",
    "12.1", "12.3", "12.4", "13.3", "13.4", "15.1", "15.4", "15.5", "17.5", "17.8", "18.4", "18.5", "19.2",
    "20.1", "20.5", "20.10", "21.12",
];

/// The page whose table lists required rules that the C breaks, with reasons.
const PAGE: &str = include_str!("../../../docs/firmware.md");

/// Writes a library of every kind into folders of `home`.
fn printed(home: &Path) -> Vec<PathBuf> {
    let mut folders = vec![];
    let mut write = |name: &str, library: &Library| {
        let folder = home.join(name);
        write_folder(&folder, &library.files().unwrap()).unwrap();
        folders.push(folder);
    };
    for name in FLOATS {
        let case = Case::floats(name, z_score(), classes(None));
        write(&case.name, &case.library());
    }
    // Bits of the gate of readings are those of models (`tests/firmware.rs`); here it meets compilers.
    let mut network = |name: &str, network: &str, encoding: Own, answers: Answers| {
        let mut case = Case::new(network, encoding, answers);
        case.name = name.into();
        let readings = match name {
            "unknown-gate" => Some(readings_gate(SAMPLE, true)),
            "values" => Some(readings_gate(SAMPLE, false)),
            _ => None,
        };
        write(name, &Library { readings, ..case.library() });
    };
    for name in NETWORKS {
        network(name, name, z_score(), classes(None));
    }
    network("unknown-gate", "resnet8-lite-1d", z_score(), gated());
    network("quantile-code", "resnet8-lite-1d", code(200, 12), classes(Some(1.4)));
    network("values", "resnet8-lite-1d", z_score(), values(Spread::LogVariance, Some(1.9)));
    network("quantiles", "mlp", z_score(), values(Spread::Quantiles, Some(1.2)));
    let Own::Scaled(scaling) = z_score() else { panic!("a scale") };
    let convolutions = convolutions();
    let rocket = |levels| Features::Rocket { convolutions: &convolutions, levels };
    with_library("minirocket", rocket(false), &scaling, &classes(Some(0.7)), |l| write("minirocket", l));
    let forces = values(Spread::Alike, Some(2.3));
    with_library("minirocket-values", rocket(true), &scaling, &forces, |l| write("minirocket-values", l));
    with_library("ridge", Features::Readings, &scaling, &forces, |l| write("ridge", l));
    let size = [3, 12, 18];
    for graph in [images::separables(size, 3), images::parts(size, 3)] {
        write(graph.name(), &images::case(&graph, size, images::z_score(3), classes(None)).library());
    }
    for (name, shares, temperature) in [
        ("sigmoid", Shares::Sigmoid, Some(1.6)),
        ("ordered", Shares::Ordered, None),
        ("cut", Shares::Cut, None),
    ] {
        let case = Case::new("mlp", z_score(), attributes(shares, temperature));
        write(name, &Library { name: name.into(), ..case.library() });
    }
    folders
}

/// Runs a command; returns what it says.
fn said(program: &str, arguments: &[&str], file: &Path) -> String {
    let done = Command::new(program).args(arguments).arg(file).output();
    let done = done.unwrap_or_else(|error| panic!("{program}: {error}"));
    let said = [done.stdout, done.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    if said.is_empty() && !done.status.success() { format!("{:?}", done.status) } else { said }
}

/// Returns the C files of a folder's library.
fn library_of(folder: &Path) -> PathBuf {
    let files = std::fs::read_dir(folder.join("src")).unwrap();
    let mut files = files.map(|file| file.unwrap().path());
    files.find(|file| file.extension().is_some_and(|extension| extension == "c")).unwrap()
}

/// Prints all kinds into a folder and checks them.
fn with_folders(home: &Path, check: impl Fn(&Path) -> Vec<String>) {
    let words: Vec<String> = printed(home).iter().flat_map(|folder| check(folder)).collect();
    assert!(words.is_empty(), "{}", words.join("\n"));
}

#[test]
#[ignore = "needs clang, arm-none-eabi-gcc and g++"]
fn needs_compilers_that_have_nothing_to_say() {
    let temporary = tempfile::tempdir().unwrap();
    // A folder that is named keeps what is printed.
    let home = std::env::var("TAXEL_FIRMWARE").map_or(temporary.path().to_path_buf(), PathBuf::from);
    with_folders(&home, |folder| {
        let (library, check) = (library_of(folder), folder.join("test/check.c"));
        let one = |line: &&str| {
            // Samples and thresholds take compilers long, and differ in numbers alone.
            let is_host = HOST.contains(line);
            let files = [Some(&library), Some(&check).filter(|_| is_host)].into_iter().flatten();
            let mut words = line.split(' ');
            let program = words.next().unwrap();
            let arguments: Vec<&str> = words.chain(WARNINGS).chain(["-c", "-o", "/dev/null"]).collect();
            files.map(|file| said(program, &arguments, file)).collect::<String>()
        };
        COMPILERS.iter().map(|line| format!("{line}: {}", one(line))).filter(|w| !w.ends_with(": ")).collect()
    });
}

/// How tables of weights begin.
const TABLES: [&str; 3] =
    ["static const int8_t weight_", "static const float weight_", "static const float hidden_"];

/// Leaves one line of each table of weights: cppcheck takes minutes for all of them.
fn shortened(text: &str) -> String {
    let (mut lines, mut in_table) = (vec![], 0);
    for line in text.lines() {
        let table = TABLES.iter().find_map(|start| Some((start, line.strip_prefix(start)?)));
        match (table, line) {
            (Some((start, rest)), _) => {
                let number = rest.split('[').next().unwrap();
                lines.push(format!("{start}{number}[] = {{"));
                in_table = 1;
                continue;
            }
            (None, "};") => in_table = 0,
            _ => {}
        }
        if in_table < 2 {
            lines.push(line.to_string());
        }
        in_table += usize::from(in_table > 0);
    }
    lines.join("\n") + "\n"
}

#[test]
#[ignore = "needs cppcheck"]
fn needs_cppcheck_that_has_nothing_new_to_say() {
    let home = tempfile::tempdir().unwrap();
    with_folders(home.path(), |folder| {
        let mut words = vec![];
        let file = library_of(folder);
        std::fs::write(&file, shortened(&std::fs::read_to_string(&file).unwrap())).unwrap();
        for configuration in CONFIGURATIONS {
            let mut arguments = configuration.to_vec();
            arguments.extend(["--quiet", "--std=c99", "--enable=warning,style,performance,portability"]);
            // It takes the counter of a loop for its value behind the loop, and says that the last pass is empty.
            arguments.push("--suppress=knownConditionTrueFalse");
            // Layers of a kind share a description; one network need not use all of it.
            arguments.extend([
                "--suppress=unusedStructMember",
                "--addon=misra",
                "--template={id} {file}:{line} {message}",
            ]);
            let report = said("cppcheck", &arguments, &file);
            words.extend(report.lines().filter(|line| !is_known(line)).map(String::from));
        }
        words
    });
}

/// Checks whether a line names a rule that is advisory, or one that the page lists.
fn is_known(line: &str) -> bool {
    let Some(rule) = line.strip_prefix("misra-c2012-").and_then(|rest| rest.split(' ').next()) else {
        return line.trim().is_empty();
    };
    ADVISORY.contains(&rule) || PAGE.contains(&format!("| {rule} |"))
}
