//! One of `rivals`: a name, or a table with settings.

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use taxel_rivals::Method;

/// `"k-nn"`, or `{ name = "k-nn", k = 3 }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rival(pub Method);

impl Serialize for Rival {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

// Written out because an untagged enum forgets where in the file the mistake is.
impl<'de> Deserialize<'de> for Rival {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RivalVisitor)
    }
}

struct RivalVisitor;

impl<'de> Visitor<'de> for RivalVisitor {
    type Value = Rival;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the name of a rival, or a table such as { name = \"k-nn\", k = 3 }")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Rival, E> {
        let known = Method::all();
        match known.iter().find(|method| method.name() == word) {
            Some(method) => Ok(Rival(*method)),
            None => {
                let names: Vec<&str> = known.iter().map(Method::name).collect();
                Err(E::custom(format!("no rival is called `{word}`; known: {}", names.join(", "))))
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Rival, A::Error> {
        Method::deserialize(MapAccessDeserializer::new(map)).map(Rival)
    }
}
