//! A checker of JSON schemas for tests. The crate `jsonschema` would bring 60 more; this one knows the keywords that taxel's
//! schema has, and panics at any other, so that none goes unchecked.

use serde_json::Value;

/// Keywords that say nothing of a value.
const NOTES: [&str; 6] = ["$schema", "title", "description", "default", "definitions", "format"];

/// Lists what is wrong with a value, each by its path; nothing of one that the schema accepts.
pub fn problems(root: &Value, value: &Value) -> Vec<String> {
    let mut found = vec![];
    check(root, root, value, "", &mut found);
    found
}

fn accepts(root: &Value, schema: &Value, value: &Value) -> bool {
    let mut found = vec![];
    check(root, schema, value, "", &mut found);
    found.is_empty()
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    if let Some(allowed) = schema.as_bool() {
        if !allowed {
            found.push(format!("{at}: nothing is allowed"));
        }
        return;
    }
    for (keyword, wanted) in schema.as_object().unwrap() {
        match keyword.as_str() {
            "$ref" => {
                let path = wanted.as_str().unwrap().trim_start_matches('#');
                check(root, root.pointer(path).unwrap(), value, at, found);
            }
            "allOf" => wanted.as_array().unwrap().iter().for_each(|one| check(root, one, value, at, found)),
            "anyOf" | "oneOf" => {
                let count = wanted.as_array().unwrap().iter().filter(|one| accepts(root, one, value)).count();
                if count == 0 || keyword == "oneOf" && count > 1 {
                    found.push(format!("{at}: {value} is {count} of {keyword}"));
                }
            }
            "if" => {
                let branch = if accepts(root, wanted, value) { "then" } else { "else" };
                schema.get(branch).into_iter().for_each(|one| check(root, one, value, at, found));
            }
            "then" | "else" => {}
            "type" if !has_type(wanted, value) => found.push(format!("{at}: {value} is no {wanted}")),
            "enum" if !wanted.as_array().unwrap().contains(value) => {
                found.push(format!("{at}: {value} is none of {wanted}"));
            }
            "const" if wanted != value => found.push(format!("{at}: {value} is not {wanted}")),
            "type" | "enum" | "const" => {}
            "minimum" | "maximum" => number(keyword, wanted, value, at, found),
            "items" | "minItems" | "maxItems" => list(root, keyword, wanted, value, at, found),
            "properties" | "required" | "additionalProperties" => {
                table(root, schema, keyword, value, at, found);
            }
            note => assert!(NOTES.contains(&note), "this checker does not know `{note}`"),
        }
    }
}

fn has_type(wanted: &Value, value: &Value) -> bool {
    if let Some(any) = wanted.as_array() {
        return any.iter().any(|one| has_type(one, value));
    }
    match wanted.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        other => panic!("this checker does not know the type {other}"),
    }
}

fn number(keyword: &str, wanted: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let (Some(limit), Some(number)) = (wanted.as_f64(), value.as_f64()) else { return };
    if keyword == "minimum" && number < limit || keyword == "maximum" && number > limit {
        found.push(format!("{at}: {value} is beyond the {keyword} {wanted}"));
    }
}

fn list(root: &Value, keyword: &str, wanted: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let Some(all) = value.as_array() else { return };
    match keyword {
        "items" => {
            for (i, one) in all.iter().enumerate() {
                check(root, wanted, one, &format!("{at}.{i}"), found);
            }
        }
        "minItems" if (all.len() as u64) < wanted.as_u64().unwrap() => {
            found.push(format!("{at}: {value} is too short"));
        }
        "maxItems" if (all.len() as u64) > wanted.as_u64().unwrap() => {
            found.push(format!("{at}: {value} is too long"));
        }
        _ => {}
    }
}

fn table(root: &Value, schema: &Value, keyword: &str, value: &Value, at: &str, found: &mut Vec<String>) {
    let Some(keys) = value.as_object() else { return };
    let known = &schema["properties"];
    match keyword {
        "properties" => {
            for (key, below) in keys {
                if let Some(one) = known.get(key) {
                    check(root, one, below, &format!("{at}.{key}"), found);
                }
            }
        }
        "required" => {
            for key in schema["required"].as_array().unwrap() {
                if !keys.contains_key(key.as_str().unwrap()) {
                    found.push(format!("{at}: has no {key}"));
                }
            }
        }
        _ => {
            for (key, below) in keys.iter().filter(|(key, _)| known.get(key).is_none()) {
                check(root, &schema["additionalProperties"], below, &format!("{at}.{key}"), found);
            }
        }
    }
}
