//! The walls of the house: which crate may depend on which, who knows candle, who may be unsafe.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Every crate with the workspace crates that it may use; arrows never point back.
/// `docs/architecture.md` draws the same table.
const MAY_USE: &[(&str, &[&str])] = &[
    ("base", &[]),
    ("encodings", &["base"]),
    ("faults", &["base"]),
    ("scenes", &["base", "faults"]),
    ("guard", &["base"]),
    ("graph", &["base"]),
    ("kernels", &[]),
    ("baselines", &["base", "kernels"]),
    ("data", &["base"]),
    ("hybrid-cnn", &["graph"]),
    ("tactnet3d", &["graph"]),
    ("multiscale-cnn", &["graph"]),
    ("visuotactile", &["graph"]),
    ("reference-networks", &["graph"]),
    (
        "zoo",
        &["base", "graph", "hybrid-cnn", "multiscale-cnn", "reference-networks", "tactnet3d", "visuotactile"],
    ),
    ("engine", &["graph", "kernels"]),
    ("runtime", &["graph", "kernels"]),
    ("firmware", &["base", "encodings", "kernels", "runtime"]),
    ("checkpoint", &["base", "graph"]),
    ("onnx", &["base", "graph"]),
    ("devices", &["graph"]),
    (
        "learn",
        &[
            "base",
            "baselines",
            "checkpoint",
            "data",
            "encodings",
            "engine",
            "faults",
            "graph",
            "guard",
            "runtime",
        ],
    ),
    (
        "trainer",
        &["base", "baselines", "checkpoint", "data", "faults", "graph", "learn", "onnx", "scenes", "zoo"],
    ),
    ("report", &["base"]),
    ("judge", &["base", "data", "faults", "learn", "report"]),
    ("stream", &["base", "data", "encodings", "learn"]),
    ("shrink", &["base", "data", "judge", "learn", "report", "trainer", "zoo"]),
    ("sweep", &["base", "data", "judge", "learn", "report", "trainer", "zoo"]),
    (
        "taxel",
        &[
            "base",
            "baselines",
            "checkpoint",
            "data",
            "devices",
            "encodings",
            "engine",
            "faults",
            "firmware",
            "graph",
            "judge",
            "learn",
            "onnx",
            "report",
            "runtime",
            "scenes",
            "shrink",
            "stream",
            "sweep",
            "trainer",
            "zoo",
        ],
    ),
    ("reproduction", &["taxel"]),
    ("python", &["checkpoint", "taxel"]),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Where a crate is: the Python package lies beside the others.
fn folder(name: &str) -> PathBuf {
    if name == "python" { root().join(name) } else { root().join("crates").join(name) }
}

/// Folder name of each crate, with the names of its normal dependencies.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let metadata = MetadataCommand::new().manifest_path(root().join("Cargo.toml")).no_deps().exec().unwrap();
    let folder =
        |path: &str| Path::new(path).parent().unwrap().file_name().unwrap().to_str().unwrap().to_string();
    let normal = |package: &cargo_metadata::Package| {
        let normal = package.dependencies.iter().filter(|d| d.kind != DependencyKind::Development);
        normal.map(|d| d.name.clone()).collect()
    };
    metadata.packages.iter().map(|p| (folder(p.manifest_path.as_str()), normal(p))).collect()
}

#[test]
fn arrows_never_point_back() {
    let allowed: BTreeMap<&str, &[&str]> = MAY_USE.iter().copied().collect();
    let found = dependencies();
    let crates: Vec<&str> = found.keys().map(String::as_str).collect();
    assert_eq!(crates, allowed.keys().copied().collect::<Vec<_>>(), "every crate stands in the table");
    for (name, uses) in &found {
        let taxels =
            uses.iter().filter_map(|u| if u == "taxel" { Some("taxel") } else { u.strip_prefix("taxel-") });
        for used in taxels {
            assert!(allowed[name.as_str()].contains(&used), "crate {name} must not depend on {used}");
        }
    }
}

#[test]
fn only_devices_knows_candle_and_only_kernels_multiplies() {
    for (name, uses) in dependencies() {
        for used in uses {
            // PyTorch's pickles are read by candle, on demand.
            let knows = name == "devices" || name == "checkpoint" && used == "candle-core";
            assert!(!used.starts_with("candle") || knows, "{name} must not know {used}");
            assert!(used != "gemm" || name == "kernels", "{name} must not know {used}");
        }
    }
}

#[test]
fn candle_is_built_on_demand() {
    let metadata = MetadataCommand::new().manifest_path(root().join("Cargo.toml")).no_deps().exec().unwrap();
    for (package, used) in [("taxel-checkpoint", "candle-core"), ("taxel", "taxel-devices")] {
        let package = metadata.packages.iter().find(|p| p.name.as_str() == package).unwrap();
        let normal = package.dependencies.iter().filter(|d| d.kind == DependencyKind::Normal);
        let found: Vec<bool> = normal.filter(|d| d.name == used).map(|d| d.optional).collect();
        assert_eq!(found, [true], "{}: {used} is optional", package.name);
    }
}

#[test]
fn only_kernels_may_be_unsafe() {
    for (name, _) in dependencies() {
        let manifest = std::fs::read_to_string(folder(&name).join("Cargo.toml")).unwrap();
        let inherits = manifest.contains("[lints]\nworkspace = true");
        assert_eq!(inherits, name != "kernels", "{name}: the workspace's lints forbid unsafe code");
    }
    let workspace = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    assert!(workspace.contains("unsafe_code = \"forbid\""));
}

#[test]
fn the_page_draws_the_same_table() {
    let page = std::fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    for (name, uses) in MAY_USE {
        let row = page.lines().find(|l| l.starts_with(&format!("| `{name}` |")));
        let row = row.unwrap_or_else(|| panic!("docs/architecture.md has no row for {name}"));
        let last = row.trim_end_matches('|').rsplit('|').next().unwrap().trim();
        let listed: BTreeSet<&str> = last.split(", ").filter(|w| *w != "–").collect();
        assert_eq!(listed, uses.iter().copied().collect(), "docs/architecture.md, row {name}");
    }
}

/// Every function that a row of the page links is defined in the file of the link, in an `impl` of its type.
#[test]
fn the_page_names_functions_that_are_there() {
    let page = std::fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let table = page.split("| function | job |\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let mut count = 0;
    for (names, rest) in table.split("[`").skip(1).map(|link| link.split_once("`](").unwrap()) {
        let path = root().join("docs").join(rest.split_once(')').unwrap().0);
        let text = std::fs::read_to_string(&path).unwrap();
        let defined: BTreeSet<String> = functions(&text).into_iter().map(|(name, _)| name).collect();
        let is_type = |name: &str| {
            let heads = text.lines().filter(|line| line.starts_with("impl"));
            heads.into_iter().any(|line| line.split(|c: char| !c.is_alphanumeric()).any(|word| word == name))
        };
        for name in names.split("`, `") {
            let (of, function) = name.rsplit_once("::").unwrap_or(("", name));
            let is_there = defined.contains(function) && (of.is_empty() || is_type(of));
            assert!(is_there, "docs/architecture.md: no `{name}` in {}", path.display());
            count += 1;
        }
    }
    assert!(count > 25, "only {count} functions in the table of docs/architecture.md");
}

#[test]
fn the_readme_maps_every_crate() {
    let page = std::fs::read_to_string(root().join("README.md")).unwrap();
    let map = page.split("## Map").nth(1).unwrap().split("\n## ").next().unwrap();
    for (name, _) in MAY_USE {
        assert!(map.contains(&format!("[`{name}`](")), "README.md, Map: no {name}");
    }
}

/// Each network file says where its network is published and where it departs from that.
#[test]
fn network_files_name_their_reference() {
    for family in ["hybrid-cnn", "tactnet3d", "multiscale-cnn", "visuotactile", "reference-networks"] {
        for file in std::fs::read_dir(root().join("crates").join(family).join("src")).unwrap() {
            let path = file.unwrap().path();
            if path.file_name().unwrap() == "lib.rs" {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            for section in ["//! # Reference", "//! # Departures"] {
                assert!(text.contains(section), "{}: no `{section}`", path.display());
            }
        }
    }
}

/// Functions of the product over [`LONG`] lines; each that is cut into parts lowers the number.
const LONG_FUNCTIONS: usize = 9;
/// Lines of a function that a reader takes in at once.
const LONG: usize = 60;

/// Rust files below `folder`.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut open) = (vec![], vec![folder.to_path_buf()]);
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(&at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Name and lines of each function, from `fn` to the brace that rustfmt puts below it.
fn functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = vec![];
    for (start, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let plain = match code.strip_prefix("pub(") {
            Some(rest) => rest.split_once(") ").map_or(code, |(_, rest)| rest),
            None => code,
        };
        let head = plain.split(['(', '<']).next().unwrap_or_default();
        let Some((before, name)) = head.split_once("fn ") else { continue };
        let keywords = ["pub", "const", "unsafe", "async", "extern", "\"C\""];
        let open = !line.trim_end().ends_with(['}', ';']);
        if !before.split_whitespace().all(|word| keywords.contains(&word)) || !open {
            continue;
        }
        let indent = &line[..line.len() - code.len()];
        let end = lines[start + 1..].iter().position(|below| {
            // A declaration of a trait ends with a semicolon and has no body.
            *below == format!("{indent}}}")
                || below.starts_with(&format!("{indent})")) && below.ends_with(';')
        });
        found.extend(end.map(|end| (name.to_string(), end + 2)));
    }
    found
}

#[test]
fn lines_of_functions_are_counted() {
    let text = "impl A {\n    pub(crate) fn a<T>(\n        x: T,\n    ) -> T {\n        x\n    }\n\n    fn b();\n}\n\nfn c() {}\n";
    assert_eq!(functions(text), [("a".to_string(), 5)]);
}

#[test]
fn few_functions_are_long() {
    let mut long = vec![];
    for (name, _) in dependencies() {
        for path in sources(&folder(&name).join("src")) {
            let text = std::fs::read_to_string(&path).unwrap();
            let found = functions(&text).into_iter().filter(|(_, lines)| *lines > LONG);
            long.extend(found.map(|(name, lines)| format!("{}: {name}, {lines} lines", path.display())));
        }
    }
    assert!(long.len() <= LONG_FUNCTIONS, "{} functions over {LONG} lines:\n{}", long.len(), long.join("\n"));
}
