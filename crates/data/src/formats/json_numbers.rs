//! Reads the numbers of a JSON text, one after the other.

use serde::de::{
    DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor,
};
use std::borrow::Cow;
use std::fmt;

/// Fields whose numbers are no values of a sensor.
const ABOUT: [&str; 4] = ["header", "stamp", "timestamp", "layout"];

/// Adds the numbers of a JSON value to `out`, in the order of the text. True is 1, null is NaN, texts are passed over.
pub(crate) struct JsonNumbers<'a, T> {
    pub out: &'a mut Vec<T>,
    /// Makes a value of a number.
    pub convert: fn(f64) -> T,
    /// Fields below which numbers are read (`["wrench", "force"]`), all where it is empty; none where objects are refused.
    pub wanted: Option<&'a [String]>,
    /// More numbers in `out` are refused.
    pub most: usize,
}

impl<T> JsonNumbers<'_, T> {
    fn add<E: Error>(self, value: f64) -> Result<(), E> {
        if self.out.len() >= self.most {
            return Err(E::custom(format!("more than {} numbers", self.most)));
        }
        if self.wanted.is_none_or(<[String]>::is_empty) {
            self.out.push((self.convert)(value));
        }
        Ok(())
    }
}

impl<'de, T> DeserializeSeed<'de> for JsonNumbers<'_, T> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de, T> Visitor<'de> for JsonNumbers<'_, T> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, a list of numbers or a text")
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

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        while list.next_element_seed(JsonNumbers { out: self.out, ..self })?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Some(wanted) = self.wanted else {
            return Err(Error::invalid_type(Unexpected::Map, &self));
        };
        while let Some(key) = map.next_key::<Cow<str>>()? {
            let is_wanted = wanted.first().is_none_or(|name| *name == key);
            if !is_wanted || ABOUT.contains(&key.as_ref()) {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let below = Some(wanted.get(1..).unwrap_or_default());
            map.next_value_seed(JsonNumbers { out: self.out, wanted: below, ..self })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8], wanted: &[&str]) -> serde_json::Result<Vec<f64>> {
        let wanted: Vec<String> = wanted.iter().map(ToString::to_string).collect();
        let mut out = vec![];
        let mut reader = serde_json::Deserializer::from_slice(text);
        let numbers = JsonNumbers { out: &mut out, convert: |value| value, wanted: Some(&wanted), most: 9 };
        numbers.deserialize(&mut reader).and_then(|()| reader.end())?;
        Ok(out)
    }

    #[test]
    fn numbers_come_in_the_order_of_the_text() {
        let text =
            br#"{"z": [1, [2.5, -3]], "header": {"stamp": 7}, "name": "left", "a": {"z": true, "x": null}}"#;
        let read = |wanted: &[&str]| read(text, wanted).unwrap();
        assert_eq!(read(&[])[..4], [1.0, 2.5, -3.0, 1.0]);
        assert!(read(&[])[4].is_nan());
        assert_eq!((read(&["a", "z"]), read(&["z"])), (vec![1.0], vec![1.0, 2.5, -3.0]));
        assert_eq!(read(&["b"]), [0f64; 0]);
    }

    #[test]
    fn what_is_no_json_is_refused() {
        for broken in ["", "{", "[1", "1 2", "{\"a\": 1,}", "[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]"] {
            assert!(read(broken.as_bytes(), &[]).is_err(), "{broken}");
        }
    }
}
