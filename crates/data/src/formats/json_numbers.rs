//! Reads the numbers of a line of JSON, one after the other.

use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;

/// Adds the numbers of a JSON value to `out`, in the order of the text. True is 1, null is NaN, texts are passed over, objects
/// are refused.
pub(crate) struct JsonNumbers<'a> {
    pub out: &'a mut Vec<f64>,
    /// More numbers in `out` are refused.
    pub most: usize,
}

impl JsonNumbers<'_> {
    fn add<E: Error>(self, value: f64) -> Result<(), E> {
        if self.out.len() >= self.most {
            return Err(E::custom(format!("more than {} numbers", self.most)));
        }
        self.out.push(value);
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for JsonNumbers<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for JsonNumbers<'_> {
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
        let Self { out, most } = self;
        while list.next_element_seed(JsonNumbers { out: &mut *out, most })?.is_some() {}
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> serde_json::Result<Vec<f64>> {
        let mut out = vec![];
        let mut reader = serde_json::Deserializer::from_str(text);
        JsonNumbers { out: &mut out, most: 9 }.deserialize(&mut reader).and_then(|()| reader.end())?;
        Ok(out)
    }

    #[test]
    fn numbers_come_in_the_order_of_the_text() {
        let all = read(r#"[1, [2.5, -3], "left", true, null]"#).unwrap();
        assert_eq!(all[..4], [1.0, 2.5, -3.0, 1.0]);
        assert!(all[4].is_nan());
    }

    #[test]
    fn what_is_no_list_of_numbers_is_refused() {
        for broken in ["", "{", "[1", "1 2", "{\"a\": 1}", "[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]"] {
            assert!(read(broken).is_err(), "{broken}");
        }
    }
}
