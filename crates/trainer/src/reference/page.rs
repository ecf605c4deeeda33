//! The page of all keys of a config, written from its schema.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Map, Value};
use taxel_zoo::Registry;

use super::schema::schema;

/// Text above the keys.
const HEAD: &str = "# Keys of a config

Every key that a config may have, with its type and its default. The page is written from the code by `taxel schema --page`, and a
test compares the two. `taxel run CONFIG --print-config` prints a config with its defaults filled in.

`taxel schema` prints the same as a JSON schema, which an editor of TOML completes and checks keys by. Write it beside your config
with `taxel schema > taxel.schema.json`, and let the config begin with the line `#:schema taxel.schema.json`. Configs of this
repository need no such line: `.taplo.toml` names their schema, [config.schema.json](config.schema.json).

A dotted key is a key of a table: `train.epochs` is `epochs` below `[train]`. `--set train.epochs=20` changes one on the command
line. Old spellings with a hyphen, such as `group-block`, are still read.
";

/// A table that gets a section of its own.
struct Section<'s> {
    /// Dotted keys from the top: `networks.train`.
    path: String,
    table: &'s Value,
}

/// Writes the page.
struct Writer<'s> {
    root: &'s Value,
    page: String,
    /// Sections by the definition that they show, so that each is shown once.
    shown: BTreeMap<String, String>,
    waiting: Vec<Section<'s>>,
}

/// Returns `docs/config.md`: every key of a config whose networks are those of `registry`.
pub fn page(registry: &Registry) -> String {
    let schema = schema(registry);
    let mut writer = Writer { root: &schema, page: HEAD.into(), shown: BTreeMap::new(), waiting: vec![] };
    writer.page.push_str("\n## Top level\n\n");
    writer.table(&schema, "");
    while !writer.waiting.is_empty() {
        let Section { path, table } = writer.waiting.remove(0);
        writer.section(&path, table);
    }
    writer.networks();
    writer.page
}

impl<'s> Writer<'s> {
    /// Follows references to what a schema is, with the name of its definition.
    fn resolved(&self, schema: &'s Value) -> (&'s Value, Option<&'s str>) {
        let single = match schema["allOf"].as_array().map(Vec::as_slice) {
            Some([one]) if one.get("$ref").is_some() => one,
            _ => schema,
        };
        match single["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
            Some(name) => (&self.root["definitions"][name], Some(name)),
            None => (schema, None),
        }
    }

    /// Writes the section of a table.
    fn section(&mut self, path: &str, table: &'s Value) {
        let list = if ["networks", "averages", "tables"].contains(&path) { ("[[", "]]") } else { ("[", "]") };
        let _ = writeln!(self.page, "\n## `{}{path}{}`\n", list.0, list.1);
        if let Some(text) = table["description"].as_str() {
            let _ = writeln!(self.page, "{text}\n");
        }
        self.table(table, path);
    }

    /// Writes the keys of a table, kind by kind where it has kinds.
    fn table(&mut self, table: &'s Value, path: &str) {
        if let Some(kinds) = kinds(table) {
            for (at, kind) in kinds.iter().enumerate() {
                if at > 0 {
                    self.page.push('\n');
                }
                self.kind(kind, path);
            }
            return;
        }
        let required = names(&table["required"]);
        for (key, value) in table["properties"].as_object().into_iter().flatten() {
            self.key(key, value, path, required.contains(&key.as_str()));
        }
        if path == "data" {
            self.scenes(table);
        }
    }

    /// Writes one kind of a table: `kind = "k-fold"`.
    fn kind(&mut self, kind: &'s Value, path: &str) {
        let (kind, _) = self.resolved(kind);
        let tag = tag(kind);
        let text = kind["description"].as_str().unwrap_or_default();
        let mut keys: Vec<(&String, &Value)> = vec![];
        keys.extend(kind["properties"].as_object().into_iter().flatten());
        keys.retain(|(key, _)| tag.as_ref().is_none_or(|(name, _)| name != *key));
        let end = if keys.is_empty() { "" } else { "\n" };
        match &tag {
            Some((name, value)) => {
                let _ = writeln!(self.page, "**`{name} = \"{value}\"`** {text}{end}");
            }
            None => {
                let _ = writeln!(self.page, "{text}{end}");
            }
        }
        let required = names(&kind["required"]);
        for (key, value) in keys {
            self.key(key, value, path, required.contains(&key.as_str()));
        }
    }

    /// Writes one key, and puts a table that it holds on the list of sections.
    fn key(&mut self, key: &str, schema: &'s Value, path: &str, is_required: bool) {
        let below = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
        let own = schema["description"].as_str().unwrap_or_default().to_string();
        let mut text = own.clone();
        let kind = self.type_of(schema, &below, &mut text);
        let needed = if is_required { ", needed" } else { "" };
        let default = match schema.get("default") {
            Some(value) if is_plain(value) && !own.contains("efault") => {
                format!(" Default `{}`.", toml_of(value))
            }
            _ => String::new(),
        };
        let _ = writeln!(self.page, "- `{key}`: {kind}{needed}. {}{default}", sentence(&text));
        for (value, text) in self.choices(schema) {
            let _ = writeln!(self.page, "  - `\"{value}\"`: {}", sentence(text));
        }
    }

    /// Returns the type of a key in words; a table gets a section, and `text` that of its definition where the key has none.
    fn type_of(&mut self, schema: &'s Value, path: &str, text: &mut String) -> String {
        let (found, name) = self.resolved(schema);
        if text.is_empty() {
            *text = found["description"].as_str().unwrap_or_default().into();
        }
        if is_table(found) {
            return self.link(found, name, path);
        }
        if let Some(any) = found["anyOf"].as_array() {
            let all: Vec<String> =
                any.iter().map(|one| self.type_of(one, path, &mut String::from("-"))).collect();
            return all.join(" or ");
        }
        if let Some(value) = found.get("const") {
            return format!("`{}`", toml_of(value));
        }
        let choices = names(&found["enum"]);
        if !choices.is_empty() {
            let all: Vec<String> = choices.iter().map(|value| format!("`\"{value}\"`")).collect();
            return all.join(", ");
        }
        match found["type"].as_str() {
            Some("integer") => "whole number".into(),
            Some("number") => "number".into(),
            Some("boolean") => "true or false".into(),
            Some("string") => "text".into(),
            Some("array") if found["items"].is_null() => "list".into(),
            Some("array") => {
                format!("list, each: {}", self.type_of(&found["items"], path, &mut String::from("-")))
            }
            Some("object") => "table".into(),
            _ if found["oneOf"].is_array() => "one of".into(),
            _ => "any value".into(),
        }
    }

    /// Returns a link to the section of a table, which is shown once.
    fn link(&mut self, table: &'s Value, name: Option<&str>, path: &str) -> String {
        let id = name.map_or_else(|| path.to_string(), str::to_string);
        let shown = self.shown.get(&id).cloned().unwrap_or_else(|| {
            self.waiting.push(Section { path: path.into(), table });
            self.shown.insert(id, path.into());
            path.into()
        });
        format!("table [`{shown}`](#{})", shown.replace('.', ""))
    }

    /// Lists the values of a key that has some, each with what it means.
    fn choices(&self, schema: &'s Value) -> Vec<(&'s str, &'s str)> {
        let (found, _) = self.resolved(schema);
        let item = found.get("items").map_or(found, |items| self.resolved(items).0);
        let mut all = vec![];
        for one in item["oneOf"].as_array().into_iter().flatten() {
            if let Some(value) = one["const"].as_str() {
                all.push((value, one["description"].as_str().unwrap_or_default()));
            }
        }
        all
    }

    /// Writes the settings of each scene.
    fn scenes(&mut self, data: &'s Value) {
        for scene in data["allOf"].as_array().into_iter().flatten() {
            let name = scene["if"]["properties"]["scene"]["const"].as_str().unwrap_or_default();
            let (table, _) = self.resolved(&scene["then"]["properties"]["set"]);
            let _ = writeln!(self.page, "\n`data.set` of `scene = \"{name}\"`:\n");
            for (key, value) in table["properties"].as_object().into_iter().flatten() {
                self.key(key, value, "data.set", false);
            }
        }
    }

    /// Writes the settings of each network, those with equal ones together.
    fn networks(&mut self) {
        let mut groups: Vec<(String, Vec<&str>)> = vec![];
        for network in self.root["definitions"]["Network"]["allOf"].as_array().into_iter().flatten() {
            let name = network["if"]["properties"]["name"]["const"].as_str().unwrap_or_default();
            let keys = network["then"]["properties"]["set"]["properties"].as_object();
            let line = |(key, value): (&String, &Value)| match &value["default"] {
                Value::Null => format!("- `{key}`: default none\n"),
                default => format!("- `{key}`: default `{}`\n", toml_of(default)),
            };
            let keys: String = keys.into_iter().flatten().map(line).collect();
            match groups.iter_mut().find(|(known, _)| *known == keys) {
                Some((_, names)) => names.push(name),
                None => groups.push((keys, vec![name])),
            }
        }
        self.page.push_str(
            "\n## Settings of networks\n\n`networks.set` has these keys. Sizes of inputs and the number of classes come from \
             the data.\n`taxel zoo` lists the networks, and their files say what a setting means.\n",
        );
        for (keys, names) in groups {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            let _ = write!(self.page, "\n{}:\n\n{keys}", names.join(", "));
        }
    }
}

/// Returns the kinds of a table that has several.
fn kinds(table: &Value) -> Option<&Vec<Value>> {
    let all = table["oneOf"].as_array().or(table["anyOf"].as_array())?;
    all.iter().all(|kind| kind["properties"].is_object()).then_some(all)
}

/// Checks whether a value is a table with keys of its own.
fn is_table(schema: &Value) -> bool {
    schema["properties"].is_object() || kinds(schema).is_some_and(|kinds| !kinds.is_empty())
}

/// Returns the key that tells a kind, with its value.
fn tag(kind: &Value) -> Option<(String, String)> {
    let keys: &Map<String, Value> = kind["properties"].as_object()?;
    let constant =
        |(key, value): (&String, &Value)| Some((key.clone(), value["const"].as_str()?.to_string()));
    keys.iter().find_map(constant)
}

fn names(list: &Value) -> Vec<&str> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Checks whether a default says something on one line.
fn is_plain(value: &Value) -> bool {
    match value {
        Value::Object(_) | Value::Null => false,
        Value::Array(all) => !all.is_empty(),
        _ => true,
    }
}

/// Returns a value as TOML writes it.
fn toml_of(value: &Value) -> String {
    toml::Value::try_from(value).map_or_else(|_| value.to_string(), |value| value.to_string())
}

/// Returns a text that ends as a sentence does.
fn sentence(text: &str) -> String {
    let text = text.trim();
    if text.is_empty() || text.ends_with(['.', ':', ')']) { text.into() } else { format!("{text}.") }
}
