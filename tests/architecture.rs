//! The walls of the house: which crate may depend on which, who knows candle, who may be unsafe.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Every crate with the workspace crates that it may use; arrows never point back.
/// `docs/architecture.md` draws the same table.
const MAY_USE: &[(&str, &[&str])] = &[
    ("seed", &[]),
    ("files", &[]),
    ("encodings", &[]),
    ("scenes", &["encodings", "seed"]),
    ("graph", &["seed"]),
    ("kernels", &[]),
    ("baselines", &["seed"]),
    ("data", &["encodings", "files", "seed"]),
    ("hybrid-cnn", &["graph"]),
    ("tactnet3d", &["graph"]),
    ("multiscale-cnn", &["graph"]),
    ("visuotactile", &["graph"]),
    ("comparators", &["graph"]),
    ("zoo", &["graph", "hybrid-cnn", "tactnet3d", "multiscale-cnn", "visuotactile", "comparators"]),
    ("engine", &["graph", "kernels"]),
    ("checkpoint", &["files", "graph"]),
    ("devices", &["graph"]),
    ("learn", &["baselines", "checkpoint", "data", "encodings", "engine", "files", "graph", "seed"]),
    ("trainer", &["baselines", "checkpoint", "data", "graph", "learn", "scenes", "zoo"]),
    ("judge", &["data", "encodings", "learn", "scenes", "seed"]),
    (
        "taxel",
        &[
            "baselines",
            "checkpoint",
            "data",
            "devices",
            "encodings",
            "engine",
            "graph",
            "judge",
            "learn",
            "scenes",
            "trainer",
            "zoo",
        ],
    ),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
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
        for used in uses.iter().filter_map(|u| u.strip_prefix("taxel-")) {
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
        let manifest = std::fs::read_to_string(root().join("crates").join(&name).join("Cargo.toml")).unwrap();
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

/// Each network file says where its network is published and where it departs from that.
#[test]
fn network_files_name_their_reference() {
    for family in ["hybrid-cnn", "tactnet3d", "multiscale-cnn", "visuotactile", "comparators"] {
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
