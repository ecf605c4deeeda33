//! One of `baselines`: a name, or a table with settings.

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use taxel_baselines::Method;

/// `"k-nn"`, or `{ name = "k-nn", k = 3 }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Baseline(pub Method);

impl Serialize for Baseline {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

// Written out because an untagged enum forgets where in the file the mistake is.
impl<'de> Deserialize<'de> for Baseline {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BaselineVisitor)
    }
}

struct BaselineVisitor;

impl<'de> Visitor<'de> for BaselineVisitor {
    type Value = Baseline;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the name of a baseline, or a table such as { name = \"k-nn\", k = 3 }")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Baseline, E> {
        let known = Method::all();
        match known.iter().find(|method| method.name() == word) {
            Some(method) => Ok(Baseline(*method)),
            None => {
                let names: Vec<&str> = known.iter().map(Method::name).collect();
                Err(E::custom(format!("no baseline is called `{word}`; known: {}", names.join(", "))))
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Baseline, A::Error> {
        Method::deserialize(MapAccessDeserializer::new(map)).map(Baseline)
    }
}
