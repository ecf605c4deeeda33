//! The JSON schema of the `[data]` table, whose keys are those of two origins.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use taxel_scenes::{Fingertip, Gel, Gripper, Hand, Imprint, Palpation, Vision};

use crate::data::{Data, RecordingsOrigin, SceneOrigin};

/// The `[data]` table as it is written: the keys of a scene or of recordings, and those of both.
pub(crate) struct WholeData;

impl JsonSchema for WholeData {
    fn schema_name() -> Cow<'static, str> {
        "Data".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = Map::new();
        for part in [
            Data::json_schema(generator),
            SceneOrigin::json_schema(generator),
            RecordingsOrigin::json_schema(generator),
        ] {
            let Some(Value::Object(keys)) = part.get("properties") else { continue };
            for (key, value) in keys {
                match properties.get_mut(key) {
                    // Names of targets: both origins have them.
                    Some(known) if key == "y" => join(known, value),
                    Some(_) => {}
                    None => drop(properties.insert(key.clone(), value.clone())),
                }
            }
        }
        let scenes: Vec<Value> = scenes(generator)
            .into_iter()
            .map(|(name, set)| {
                json!({
                    "if": { "properties": { "scene": { "const": name } }, "required": ["scene"] },
                    "then": { "properties": { "set": set } },
                })
            })
            .collect();
        json_schema!({
            "description": "Where the samples come from: `scene`, a simulated world, or `path`, recordings.",
            "type": "object",
            "properties": properties,
            "additionalProperties": false,
            "oneOf": [{ "required": ["scene"] }, { "required": ["path"] }],
            "allOf": scenes,
        })
    }
}

/// Says of a key what it means for a scene and for recordings.
fn join(of_scene: &mut Value, of_recordings: &Value) {
    let text = |value: &Value| value["description"].as_str().unwrap_or_default().to_string();
    let both = format!("Of recordings: {} Of a scene: {}", text(of_recordings), text(of_scene));
    of_scene["description"] = both.into();
}

/// Lists the settings of every scene by its name.
fn scenes(generator: &mut SchemaGenerator) -> [(&'static str, Schema); 7] {
    [
        ("fingertip", generator.subschema_for::<Fingertip>()),
        ("palpation", generator.subschema_for::<Palpation>()),
        ("gripper", generator.subschema_for::<Gripper>()),
        ("imprint", generator.subschema_for::<Imprint>()),
        ("gel", generator.subschema_for::<Gel>()),
        ("hand", generator.subschema_for::<Hand>()),
        ("vision", generator.subschema_for::<Vision>()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_its_settings() {
        let found = scenes(&mut SchemaGenerator::default()).map(|(name, _)| name);
        assert_eq!(found, taxel_scenes::names());
    }
}
