//! Checks that no files of a crate import each other in a circle.
//!
//! A file that declares others (`lib.rs`, `mod.rs`, `gel.rs` beside `gel/`) passes their names on and may hold what they
//! share. Of such a file each item counts by itself, so that a shared constant makes no circle and a function that
//! calls the files below it does.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::Visit;
use syn::{Attribute, Item, UseTree};

/// A path from the crate's root, segment by segment.
type Segments = Vec<String>;

/// A source file: the names that it uses, passes on and defines.
#[derive(Default)]
struct File {
    /// It declares files below it.
    is_parent: bool,
    /// Paths that are named by each item; by the whole file, under no name, unless it is a parent.
    uses: BTreeMap<String, BTreeSet<Segments>>,
    /// Names of `pub use`, with the paths behind them.
    passes_on: BTreeMap<String, Segments>,
    /// Paths of `pub use …::*`.
    passes_on_all: Vec<Segments>,
}

type Files = BTreeMap<Segments, File>;

/// Collects the paths of one file.
struct Paths<'a> {
    module: &'a Segments,
    children: BTreeSet<String>,
    imported: BTreeMap<String, Segments>,
    found: BTreeSet<Segments>,
}

impl Paths<'_> {
    /// Returns `path` from the crate's root; none of a path into another crate, or of a local name.
    fn absolute(&self, path: &[String]) -> Option<Segments> {
        let rest = |from: &[String], path: &[String]| Some([from, path].concat());
        match path.first()?.as_str() {
            "crate" => Some(path[1..].to_vec()),
            "self" => rest(self.module, &path[1..]),
            "super" => {
                let up = path.iter().take_while(|segment| *segment == "super").count();
                rest(&self.module[..self.module.len().saturating_sub(up)], &path[up..])
            }
            first if self.children.contains(first) => rest(self.module, path),
            first => rest(self.imported.get(first)?, &path[1..]),
        }
    }
}

impl<'ast> Visit<'ast> for Paths<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes(item)) {
            syn::visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let mut names = vec![];
        leaves(&item.tree, &[], &mut names);
        self.found.extend(names.iter().filter_map(|(_, path)| self.absolute(path)).collect::<Vec<_>>());
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Segments = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.found.extend(self.absolute(&segments));
        syn::visit::visit_path(self, path);
    }

    // What macros are given is tokens: the names in front of `::` are all that is looked for.
    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        let text = mac.tokens.to_string().replace(" :: ", "::");
        for word in text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')) {
            let segments: Segments = word.split("::").map(String::from).collect();
            if segments.len() > 1 {
                self.found.extend(self.absolute(&segments));
            }
        }
        syn::visit::visit_macro(self, mac);
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    let is_cfg_test = |list: &syn::MetaList| list.path.is_ident("cfg") && list.tokens.to_string() == "test";
    attributes.iter().any(|attribute| attribute.meta.require_list().is_ok_and(is_cfg_test))
}

/// Returns the name of what an item defines or adds to.
fn name_of(item: &Item) -> String {
    match item {
        Item::Const(item) => item.ident.to_string(),
        Item::Enum(item) => item.ident.to_string(),
        Item::Fn(item) => item.sig.ident.to_string(),
        Item::Static(item) => item.ident.to_string(),
        Item::Struct(item) => item.ident.to_string(),
        Item::Trait(item) => item.ident.to_string(),
        Item::Type(item) => item.ident.to_string(),
        Item::Macro(item) => item.ident.as_ref().map(ToString::to_string).unwrap_or_default(),
        Item::Impl(item) => match &*item.self_ty {
            syn::Type::Path(path) => path.path.segments.last().map(|last| last.ident.to_string()),
            _ => None,
        }
        .unwrap_or_default(),
        _ => String::new(),
    }
}

/// Lists each name of an import with its path; `*` is a name.
fn leaves(tree: &UseTree, before: &[String], found: &mut Vec<(String, Segments)>) {
    let longer = |name: &syn::Ident| [before, &[name.to_string()]].concat();
    match tree {
        UseTree::Path(path) => leaves(&path.tree, &longer(&path.ident), found),
        UseTree::Name(name) if name.ident == "self" => {
            found.push((before.last().cloned().unwrap_or_default(), before.to_vec()));
        }
        UseTree::Name(name) => found.push((name.ident.to_string(), longer(&name.ident))),
        UseTree::Rename(rename) => found.push((rename.rename.to_string(), longer(&rename.ident))),
        UseTree::Glob(_) => found.push(("*".into(), before.to_vec())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves(tree, before, found)),
    }
}

fn read(text: &str, module: &Segments) -> File {
    let parsed = syn::parse_file(text).unwrap();
    let items: Vec<&Item> = parsed.items.iter().filter(|item| !is_test(attributes(item))).collect();
    let children = items.iter().filter_map(|item| match item {
        Item::Mod(item) if item.content.is_none() => Some(item.ident.to_string()),
        _ => None,
    });
    let mut paths =
        Paths { module, children: children.collect(), imported: BTreeMap::new(), found: BTreeSet::new() };
    let mut file = File { is_parent: !paths.children.is_empty(), ..File::default() };
    for item in &items {
        let Item::Use(item) = item else { continue };
        let mut names = vec![];
        leaves(&item.tree, &[], &mut names);
        for (name, path) in names {
            let Some(path) = paths.absolute(&path) else { continue };
            let is_private = matches!(item.vis, syn::Visibility::Inherited);
            match (is_private, name.as_str()) {
                (true, _) if !file.is_parent => drop(paths.found.insert(path.clone())),
                (true, _) => (),
                (false, "*") => file.passes_on_all.push(path.clone()),
                (false, _) => drop(file.passes_on.insert(name.clone(), path.clone())),
            }
            paths.imported.insert(name, path);
        }
    }
    for item in items
        .iter()
        .filter(|item| !matches!(item, Item::Use(_) | Item::Mod(syn::ItemMod { content: None, .. })))
    {
        paths.visit_item(item);
        let name = if file.is_parent { name_of(item) } else { String::new() };
        file.uses.entry(name).or_default().append(&mut paths.found);
    }
    if !file.is_parent {
        file.uses.entry(String::new()).or_default().append(&mut paths.found);
    }
    file
}

/// Reads the files below `source`; the modules are their paths.
fn read_all(source: &Path) -> Files {
    let mut files = Files::new();
    for path in sources(source) {
        let inside = path.strip_prefix(source).unwrap().with_extension("");
        let mut module: Segments = inside.iter().map(|part| part.to_str().unwrap().to_string()).collect();
        if ["lib", "main", "mod"].contains(&module.last().unwrap().as_str()) {
            module.pop();
        }
        // A library and its binary are two roots with one name; the library stands for both.
        if path.file_name().unwrap() != "main.rs" || !source.join("lib.rs").is_file() {
            files.insert(module.clone(), read(&std::fs::read_to_string(&path).unwrap(), &module));
        }
    }
    files
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found = vec![];
    for path in entries {
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found
}

/// A file, or an item of a file that declares others.
type Node = (Segments, String);

/// Returns what defines the thing that `path` names, behind every re-export.
fn definer(files: &Files, path: &[String], depth: usize) -> Option<Node> {
    let length = (0..=path.len()).rev().find(|length| files.contains_key(&path[..*length]))?;
    let (module, rest) = path.split_at(length);
    let file = &files[module];
    if !file.is_parent {
        return Some((module.to_vec(), String::new()));
    }
    let name = rest.first().filter(|_| depth > 0)?;
    if let Some(behind) = file.passes_on.get(name) {
        return definer(files, &[behind, &rest[1..]].concat(), depth - 1);
    }
    if file.uses.contains_key(name) {
        return Some((module.to_vec(), name.clone()));
    }
    file.passes_on_all.iter().find_map(|all| definer(files, &[all, rest].concat(), depth - 1))
}

/// Returns the arrows of a circle and of what lies between two circles; none where there is no circle.
fn circle(files: &Files) -> Vec<String> {
    let mut left: BTreeMap<Node, BTreeSet<Node>> = BTreeMap::new();
    for (module, file) in files {
        for (name, paths) in &file.uses {
            let node = (module.clone(), name.clone());
            let used = paths.iter().filter_map(|path| definer(files, path, 8)).filter(|used| *used != node);
            left.insert(node.clone(), used.collect());
        }
    }
    loop {
        let before = left.len();
        let nodes: BTreeSet<Node> = left.keys().cloned().collect();
        left.values_mut().for_each(|used| used.retain(|used| nodes.contains(used)));
        let wanted: BTreeSet<Node> = left.values().flatten().cloned().collect();
        left.retain(|node, used| !used.is_empty() && wanted.contains(node));
        if left.len() == before {
            let name = |(module, item): &Node| format!("{} {item}", module.join("::"));
            let arrows = left.iter().map(|(node, used)| {
                format!("{} uses {}", name(node), used.iter().map(name).collect::<Vec<_>>().join(", "))
            });
            return arrows.collect();
        }
    }
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let crates = std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path());
    for folder in crates.chain([root.join("python")]) {
        let found = circle(&read_all(&folder.join("src")));
        assert!(found.is_empty(), "{}: a circle of files:\n{}", folder.display(), found.join("\n"));
    }
}

fn files(texts: &[(&str, &str)]) -> Files {
    let read = |(at, text): &(&str, &str)| {
        let mut module: Segments = at.split("::").map(String::from).collect();
        if module.last().unwrap() == "mod" {
            module.pop();
        }
        (module.clone(), read(text, &module))
    };
    texts.iter().map(read).collect()
}

#[test]
fn a_circle_is_seen_through_what_a_facade_defines_and_passes_on() {
    let facade =
        |text| files(&[("mod", "mod a; mod b;"), ("a::mod", text), ("a::c", "use super::list;"), ("b", "")]);
    assert_eq!(circle(&facade("mod c; pub fn list() { c::read() }")).len(), 2);
    assert!(circle(&facade("mod c; pub fn list() {} pub fn read() { c::read() }")).is_empty());
    let passed = |a, b| files(&[("mod", "mod a; mod b; pub use a::A; pub use b::B;"), ("a", a), ("b", b)]);
    assert_eq!(
        circle(&passed("use crate::B; pub struct A(B);", "pub struct B; fn f() { crate::A::new() }")).len(),
        2
    );
    assert!(circle(&passed("use crate::B; pub struct A(B);", "pub struct B;")).is_empty());
    let tests = "pub struct B; #[cfg(test)] mod tests { use crate::A; }";
    assert!(circle(&passed("use crate::B; pub struct A(B);", tests)).is_empty());
    let in_macro = "pub struct B; fn f() { assert!(crate::a::ok()) }";
    assert_eq!(circle(&passed("use super::b::B; pub struct A(B);", in_macro)).len(), 2);
}
