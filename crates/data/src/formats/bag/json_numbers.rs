//! The numbers of a JSON text, one after the other.

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// Fields whose numbers are no readings.
const ABOUT: [&str; 4] = ["header", "stamp", "timestamp", "layout"];

/// Adds all numbers of a text to `out`, in the order of the text, or only those below the fields `wanted`
/// (`["wrench", "force"]`). True is 1, null is NaN; texts and what is said of times are passed over.
pub(crate) fn read(text: &[u8], wanted: &[String], out: &mut Vec<f32>) -> Result<(), Cow<'static, str>> {
    let mut reader = serde_json::Deserializer::from_slice(text);
    let read = Numbers { wanted, out }.deserialize(&mut reader).and_then(|()| reader.end());
    read.map_err(|e| Cow::Owned(format!("is no JSON ({e})")))
}

struct Numbers<'a> {
    wanted: &'a [String],
    out: &'a mut Vec<f32>,
}

impl Numbers<'_> {
    fn add(self, value: f32) {
        if self.wanted.is_empty() {
            self.out.push(value);
        }
    }
}

impl<'de> DeserializeSeed<'de> for Numbers<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Numbers<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.add(value.into());
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.add(value as f32);
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.add(value as f32);
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.add(value as f32);
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.add(f32::NAN);
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        while seq.next_element_seed(Numbers { wanted: self.wanted, out: self.out })?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<Cow<str>>()? {
            let is_wanted = self.wanted.first().is_none_or(|name| *name == key);
            if !is_wanted || ABOUT.contains(&key.as_ref()) {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let wanted = self.wanted.get(1..).unwrap_or_default();
            map.next_value_seed(Numbers { wanted, out: self.out })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_in_the_order_of_the_text() {
        let text =
            br#"{"z": [1, [2.5, -3]], "header": {"stamp": 7}, "name": "left", "a": {"z": true, "x": null}}"#;
        let read = |wanted: &[&str]| {
            let wanted: Vec<String> = wanted.iter().map(ToString::to_string).collect();
            let mut out = vec![];
            read(text, &wanted, &mut out).unwrap();
            out
        };
        assert_eq!(read(&[])[..4], [1.0, 2.5, -3.0, 1.0]);
        assert!(read(&[])[4].is_nan());
        assert_eq!((read(&["a", "z"]), read(&["z"])), (vec![1.0], vec![1.0, 2.5, -3.0]));
        assert_eq!(read(&["b"]), [0f32; 0]);
        for broken in ["", "{", "[1", "1 2", "{\"a\": 1,}"] {
            assert!(super::read(broken.as_bytes(), &[], &mut vec![]).is_err(), "{broken}");
        }
    }
}
