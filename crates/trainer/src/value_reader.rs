//! TOML values as a source for serde, which remembers the key at which reading stopped.

use serde::de::value::{MapAccessDeserializer, StringDeserializer};
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer, MapAccess, SeqAccess, VariantAccess,
    Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Value;

use crate::misread::Misread;

/// A TOML value that is read with [`Misread`] as its error.
pub(crate) struct ValueReader(pub Value);

impl<'de> Deserializer<'de> for ValueReader {
    type Error = Misread;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        match self.0 {
            Value::String(text) => visitor.visit_string(text),
            Value::Integer(number) => visitor.visit_i64(number),
            Value::Float(number) => visitor.visit_f64(number),
            Value::Boolean(flag) => visitor.visit_bool(flag),
            Value::Array(items) => {
                let count = items.len();
                let mut items = Items { items: items.into_iter(), position: 0 };
                let value = visitor.visit_seq(&mut items)?;
                let all_read = items.position == count;
                if all_read {
                    Ok(value)
                } else {
                    Err(Misread::invalid_length(count, &"fewer elements in array"))
                }
            }
            Value::Table(table) => visitor.visit_map(Entries { entries: table.into_iter(), value: None }),
            date @ Value::Datetime(_) => date.deserialize_any(visitor).map_err(Misread::custom),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misread> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misread> {
        match self.0 {
            Value::String(name) => visitor.visit_enum(name.into_deserializer()),
            Value::Table(table) if table.len() == 1 => {
                let mut entries = table.into_iter();
                let Some((name, content)) = entries.next() else { return Err(Misread::custom("is empty")) };
                visitor.visit_enum(TableVariant { name, content })
            }
            Value::Table(_) => Err(Misread::custom("expected a table with one key, or a name")),
            other => Err(Misread::custom(format!("{other} is neither a name nor a table with one key"))),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

/// Elements of an array, with the position of the one that is read.
struct Items {
    items: std::vec::IntoIter<Value>,
    position: usize,
}

impl<'de> SeqAccess<'de> for &mut Items {
    type Error = Misread;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misread> {
        let Some(item) = self.items.next() else { return Ok(None) };
        let key = self.position.to_string();
        self.position += 1;
        seed.deserialize(ValueReader(item)).map(Some).map_err(|misread| misread.below(&key))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len())
    }
}

/// Entries of a table, with the one whose key was read.
struct Entries {
    entries: toml::map::IntoIter<String, Value>,
    value: Option<(String, Value)>,
}

impl<'de> MapAccess<'de> for Entries {
    type Error = Misread;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Misread> {
        let Some((key, value)) = self.entries.next() else { return Ok(None) };
        let name: StringDeserializer<Misread> = key.clone().into_deserializer();
        self.value = Some((key, value));
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Misread> {
        let Some((key, value)) = self.value.take() else {
            return Err(Misread::custom("a value without a key"));
        };
        seed.deserialize(ValueReader(value)).map_err(|misread| misread.below(&key))
    }
}

/// A variant with content: a table with its name as the only key.
struct TableVariant {
    name: String,
    content: Value,
}

impl<'de> EnumAccess<'de> for TableVariant {
    type Error = Misread;
    type Variant = Content;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Content), Misread> {
        let name: StringDeserializer<Misread> = self.name.clone().into_deserializer();
        Ok((seed.deserialize(name)?, Content { name: self.name, content: self.content }))
    }
}

/// The content of a variant.
struct Content {
    name: String,
    content: Value,
}

impl<'de> VariantAccess<'de> for Content {
    type Error = Misread;

    fn unit_variant(self) -> Result<(), Misread> {
        Err(Misread::custom(format!("`{}` takes no values; write \"{0}\"", self.name)))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Misread> {
        seed.deserialize(ValueReader(self.content)).map_err(|misread| misread.below(&self.name))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misread> {
        ValueReader(self.content).deserialize_seq(visitor).map_err(|misread| misread.below(&self.name))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misread> {
        let name = self.name;
        match self.content {
            Value::Table(table) => {
                let entries = MapAccessDeserializer::new(Entries { entries: table.into_iter(), value: None });
                entries.deserialize_any(visitor).map_err(|misread| misread.below(&name))
            }
            other => ValueReader(other).deserialize_any(visitor).map_err(|misread| misread.below(&name)),
        }
    }
}
