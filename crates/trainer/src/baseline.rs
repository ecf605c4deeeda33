//! One of an experiment's baselines.

use std::borrow::Cow;
use std::collections::BTreeSet;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use taxel_baselines::Method;
use toml::{Table, Value};

use crate::misread::Misread;
use crate::read::read;

/// A method of `taxel-baselines`: its name, or a table such as `{ name = "k-nn", k = 3 }`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Baseline(pub Method);

impl JsonSchema for Baseline {
    fn schema_name() -> Cow<'static, str> {
        "Baseline".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let all = Method::all().into_iter().chain(Method::of_values());
        let names: BTreeSet<&str> = all.map(|method| method.name()).collect();
        json_schema!({
            "description": "The name of a baseline, or a table such as { name = \"k-nn\", k = 3 }.",
            "anyOf": [{ "type": "string", "enum": names }, generator.subschema_for::<Method>()],
        })
    }
}

impl Baseline {
    /// Reads the baseline at position `i` of the list.
    pub(crate) fn read(i: usize, value: Value) -> Result<Self, Misread> {
        let key = format!("baselines.{i}");
        let table = match value {
            Value::String(name) => Table::from_iter([("name".to_string(), Value::String(name))]),
            Value::Table(table) => table,
            other => {
                let message = "the name of a baseline, or a table such as { name = \"k-nn\", k = 3 }";
                return Err(Misread::new(key, format!("{other} is not {message}")));
            }
        };
        let name = table.get("name").and_then(Value::as_str).unwrap_or_default();
        let is_new = |method: &Method| Method::all().iter().all(|other| other.name() != method.name());
        let known: Vec<Method> =
            Method::all().into_iter().chain(Method::of_values().into_iter().filter(is_new)).collect();
        if !known.iter().any(|method| method.name() == name) {
            let hint = taxel_base::names::hint(name, known.iter().map(Method::name));
            return Err(Misread::new(key, format!("no baseline is called `{name}`; {hint}")));
        }
        read(&key, Value::Table(table)).map(Baseline)
    }
}
