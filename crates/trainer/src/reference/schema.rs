//! The JSON schema of a config: made of the types that a config is read as.

use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};
use taxel_zoo::{Entry, Registry};

use super::texts::plain;
use crate::config::Config;

/// Tables that are merged key by key into the ones below ([`crate::merge`]): the kind may be left out.
const MERGED: [&str; 3] = ["Optimizer", "Protocol", "Schedule"];

/// Keys of a schema that hold schemas by name, whose names are not keywords.
const BY_NAME: [&str; 2] = ["properties", "definitions"];

/// Returns the JSON schema (draft 7, which editors of TOML know) of a config whose networks are those of `registry`.
///
/// It accepts every config that taxel accepts, apart from old spellings with hyphens. It does not know ranges of numbers and keys
/// that exclude each other: `taxel run` says these.
pub fn schema(registry: &Registry) -> Value {
    let generator = SchemaSettings::draft07().into_generator();
    let mut schema = generator.into_root_schema_for::<Config>().to_value();
    simplify(&mut schema);
    schema["title"] = "taxel config".into();
    let quick = json!({
        "description": "Values of `--quick` in place of the full ones: the same keys, also dotted, as `train.epochs = 3`.",
        "type": "object",
    });
    schema["properties"]["quick"] = quick;
    for name in MERGED {
        relax(&mut schema["definitions"][name]);
    }
    let networks: Vec<Value> = registry.entries().filter_map(settings).collect();
    schema["definitions"]["Network"]["allOf"] = networks.into();
    schema
}

/// Makes a schema as a config writes it: no nulls, which TOML does not have, no formats of numbers, texts without links.
fn simplify(schema: &mut Value) {
    match schema {
        Value::Array(all) => all.iter_mut().for_each(simplify),
        Value::Object(keys) => {
            keys.remove("format");
            keys.retain(|key, value| !(key == "default" && value.is_null()));
            if let Some(Value::String(text)) = keys.get_mut("description") {
                *text = plain(text);
            }
            without_null(keys);
            for (key, value) in keys.iter_mut().filter(|(key, _)| *key != "default") {
                if BY_NAME.contains(&key.as_str()) {
                    value.as_object_mut().into_iter().flatten().for_each(|(_, below)| simplify(below));
                } else {
                    simplify(value);
                }
            }
        }
        _ => {}
    }
}

/// Takes null out of the types and alternatives of a schema.
fn without_null(keys: &mut Map<String, Value>) {
    if let Some(Value::Array(types)) = keys.get_mut("type") {
        types.retain(|name| name != "null");
        if let [one] = &types[..] {
            let one = one.clone();
            keys.insert("type".into(), one);
        }
    }
    if let Some(Value::Array(any)) = keys.get_mut("anyOf") {
        any.retain(|schema| schema["type"] != "null");
        if let [one] = &any[..] {
            let one = one.clone();
            keys.shift_remove("anyOf");
            // A reference has no neighbours in draft 7.
            keys.insert("allOf".into(), json!([one]));
        }
    }
}

/// Lets a table say only some of its keys: the others are those of the table below.
fn relax(definition: &mut Value) {
    let Some(keys) = definition.as_object_mut() else { return };
    if let Some(kinds) = keys.shift_remove("oneOf") {
        keys.insert("anyOf".into(), kinds);
    }
    for kind in keys.get_mut("anyOf").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(kind) = kind.as_object_mut() {
            kind.shift_remove("required");
        }
    }
}

/// Returns what `set` may say of a network of the zoo; none of one that says nothing of its settings.
fn settings(entry: &Entry) -> Option<Value> {
    let settings = entry.settings();
    let keys: Map<String, Value> =
        settings.into_iter().map(|(key, value)| (key, json!({ "default": value }))).collect();
    (!keys.is_empty()).then(|| {
        json!({
            "if": { "properties": { "name": { "const": entry.name } }, "required": ["name"] },
            "then": { "properties": { "set": { "properties": keys, "additionalProperties": false } } },
        })
    })
}
