//! Reads the numbers of a JSON message with the keys that lead to them.

use crate::formats::bag::numbers::Numbers;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// Keys whose numbers are no values of a sensor.
const ABOUT: [&str; 4] = ["header", "stamp", "timestamp", "layout"];

/// Reads the numbers of a message below the `wanted` keys (`["wrench", "force"]`), or all of them. True is 1, null is NaN, texts
/// are passed over.
pub(crate) fn read(data: &[u8], wanted: &[String], out: &mut Numbers) -> serde_json::Result<()> {
    let mut reader = serde_json::Deserializer::from_slice(data);
    JsonValue { out, wanted }.deserialize(&mut reader)?;
    reader.end()
}

/// A value below the path of `out`.
struct JsonValue<'a> {
    out: &'a mut Numbers,
    wanted: &'a [String],
}

impl JsonValue<'_> {
    fn add<E>(self, value: f64) -> Result<(), E> {
        if self.wanted.is_empty() {
            self.out.push(value);
        }
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for JsonValue<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for JsonValue<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, a list, an object or a text")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.add(u8::from(value).into())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.add(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.add(value as f64)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.add(value)
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.add(f64::NAN)
    }

    fn visit_str<E>(self, text: &str) -> Result<(), E> {
        self.out.push_text(text);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let Self { out, wanted } = self;
        for place in 0.. {
            let before = out.enter_place(place);
            let one = list.next_element_seed(JsonValue { out: &mut *out, wanted })?;
            out.leave(before);
            if one.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self { out, wanted } = self;
        while let Some(key) = map.next_key::<Cow<str>>()? {
            let is_wanted = wanted.first().is_none_or(|name| *name == key);
            let names_joints = out.is_at_top() && key == "name";
            if !(is_wanted || names_joints) || ABOUT.contains(&key.as_ref()) {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let before = out.enter(&key);
            // Of names that are not wanted no number is.
            let below = if is_wanted { wanted.get(1..).unwrap_or_default() } else { wanted };
            map.next_value_seed(JsonValue { out: &mut *out, wanted: below })?;
            out.leave(before);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str, wanted: &[&str]) -> serde_json::Result<Numbers> {
        let wanted: Vec<String> = wanted.iter().map(ToString::to_string).collect();
        let mut out = Numbers::default();
        out.begin(true);
        read(text.as_bytes(), &wanted, &mut out).map(|()| out)
    }

    #[test]
    fn numbers_come_with_their_keys() {
        let text =
            r#"{"z": [1, [2.5, -3]], "header": {"stamp": 7}, "name": "left", "a": {"z": true, "x": null}}"#;
        let all = numbers(text, &[]).unwrap();
        assert_eq!(all.names, ["z[0]", "z[1][0]", "z[1][1]", "a.z", "a.x"]);
        assert_eq!(all.values[..4], [1.0, 2.5, -3.0, 1.0]);
        assert!(all.values[4].is_nan());
        let some = |wanted: &[&str]| numbers(text, wanted).unwrap().values;
        assert_eq!(
            (some(&["a", "z"]), some(&["z"]), some(&["b"])),
            (vec![1.0], vec![1.0, 2.5, -3.0], vec![])
        );
        assert_eq!(numbers("[5, 6]", &[]).unwrap().names, ["[0]", "[1]"]);
    }

    #[test]
    fn what_is_no_json_is_refused() {
        for broken in ["", "{", "[1", "1 2", "{\"a\": 1,}"] {
            assert!(numbers(broken, &[]).is_err(), "{broken}");
        }
    }
}
