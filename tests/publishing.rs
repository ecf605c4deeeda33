//! The page that a registry shows of each crate: addresses, licences, a page whose links lead somewhere from there.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use cargo_metadata::{MetadataCommand, Package};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn packages() -> Vec<Package> {
    let metadata = MetadataCommand::new().manifest_path(root().join("Cargo.toml")).no_deps().exec().unwrap();
    metadata.packages
}

fn folder(package: &Package) -> PathBuf {
    package.manifest_path.parent().unwrap().as_std_path().to_path_buf()
}

/// Lists targets of Markdown links.
fn links(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect()
}

#[test]
fn every_crate_says_where_it_is_at_home() {
    let packages = packages();
    let repository = packages[0].repository.clone().unwrap();
    assert!(repository.starts_with("https://"), "{repository}");
    for package in packages {
        let name = package.name.to_string();
        assert_eq!(package.repository.as_ref(), Some(&repository), "{name}");
        assert_eq!(package.homepage.as_ref(), Some(&repository), "{name}");
        let of_python = name == "taxel-python";
        let documentation = (!of_python).then(|| format!("https://docs.rs/{name}"));
        assert_eq!(package.documentation, documentation, "{name}");
        assert!(package.license.is_some() && package.description.is_some(), "{name}");
    }
    let python = std::fs::read_to_string(root().join("python/pyproject.toml")).unwrap();
    assert!(
        python.contains(&format!("Repository = \"{repository}\"")),
        "python/pyproject.toml has another address"
    );
}

#[test]
fn every_crate_carries_its_licences() {
    for package in packages() {
        for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let path = folder(&package).join(file);
            let same = std::fs::read(&path).unwrap_or_default() == std::fs::read(root().join(file)).unwrap();
            assert!(same, "{}: ln -s ../../{file} there", path.display());
        }
    }
}

/// A registry shows the page of a crate without the repository around it.
#[test]
fn pages_of_crates_work_on_their_registry() {
    for package in packages() {
        let path = folder(&package).join("README.md");
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let title = if package.name.as_str() == "taxel-python" { "taxel" } else { package.name.as_str() };
        assert!(text.to_lowercase().starts_with(&format!("# {title}")), "{}", path.display());
        assert_eq!(
            package.readme.as_ref().map(|readme| readme.as_str()),
            Some("README.md"),
            "{}",
            path.display()
        );
        for link in links(&text) {
            let leads = link.starts_with("https://") || link.starts_with('#');
            assert!(leads, "{}: {link} leads nowhere on a registry", path.display());
        }
    }
}

#[test]
fn the_oldest_rust_is_tried() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let line = manifest.lines().find(|line| line.starts_with("rust-version")).unwrap();
    let oldest = line.split('"').nth(1).unwrap();
    let workflow = std::fs::read_to_string(root().join(".github/workflows/check.yml")).unwrap();
    assert!(
        workflow.contains(&format!("rustup toolchain install {oldest} ")),
        "check.yml does not try {oldest}"
    );
}

#[test]
fn the_version_has_a_dated_section_in_the_changelog() {
    let version = packages()[0].version.to_string();
    let changelog = std::fs::read_to_string(root().join("CHANGELOG.md")).unwrap();
    let head =
        changelog.lines().find(|line| line.starts_with(&format!("## [{version}] - "))).unwrap_or_default();
    let date = head.rsplit(' ').next().unwrap_or_default();
    assert!(
        date.len() == 10 && date.split('-').count() == 3,
        "CHANGELOG.md has no `## [{version}] - YYYY-MM-DD`"
    );
}
