//! Reads the numbers of a ROS 2 message in CDR, the encoding of DDS.
//!
//! After OMG, "DDS Interoperability Wire Protocol" 2.2, 10, and "DDS-XTypes" 1.3, 7.4: four bytes say the encoding,
//! then field after field, each number at a multiple of its own size. Plain CDR of version 1 only, which ROS 2 writes.
//!
//! Crates for CDR need types that are known at compile time; these come with the bag.

use crate::formats::bag::numbers::Numbers;
use crate::formats::bag::ros_type::{FieldType, Many, MessageField, MessageType, Number, RosType};

/// Most types within types of a definition that does not go in circles.
const MAX_DEPTH: usize = 24;

/// A stream of bytes that must be numbers and texts of known types.
pub(crate) struct Cdr<'d> {
    data: &'d [u8],
    at: usize,
    is_big: bool,
}

/// The reason why a message cannot be read.
pub(crate) type Broken = &'static str;

const SHORT: Broken = "ends before its fields do";

impl<'d> Cdr<'d> {
    /// Reads the head of a message.
    pub fn new(message: &'d [u8]) -> Result<Self, Broken> {
        match message {
            [0, order @ (0 | 1), _, _, data @ ..] => Ok(Self { data, at: 0, is_big: *order == 0 }),
            [_, _, _, _, ..] => Err("is not in plain CDR of version 1"),
            _ => Err(SHORT),
        }
    }

    /// Adds all numbers of a message to `out`, field after field, or only those below the field `wanted`
    /// (`["wrench", "force"]`). Texts, times and layouts are passed over.
    pub fn numbers(
        &mut self,
        message: &MessageType,
        wanted: &[&str],
        out: &mut Numbers,
    ) -> Result<(), Broken> {
        self.of_type(message, &message.types[0], wanted, Some(out), 0)
    }

    fn of_type(
        &mut self,
        message: &MessageType,
        ros_type: &RosType,
        wanted: &[&str],
        mut out: Option<&mut Numbers>,
        depth: usize,
    ) -> Result<(), Broken> {
        if depth > MAX_DEPTH {
            return Err("is of a type within itself");
        }
        if ros_type.fields.is_empty() {
            // A type without fields is encoded as one byte.
            return self.take(1).map(|_| ());
        }
        for field in &ros_type.fields {
            let is_wanted = wanted.first().is_none_or(|name| *name == field.name);
            let wanted = if is_wanted { wanted.get(1..).unwrap_or_default() } else { &[] };
            let count = match field.many {
                Many::One => 1,
                Many::Exactly(count) => count,
                Many::Any => self.word()? as usize,
            };
            // Each takes a byte at least: a count that is damaged costs nothing.
            if count > self.data.len() - self.at {
                return Err(SHORT);
            }
            let outside = out.as_deref_mut().map_or(0, |out| out.enter(&field.name));
            for place in 0..count {
                let before = out.as_deref_mut().map_or(0, |out| match field.many {
                    Many::One => out.here(),
                    _ => out.enter_place(place),
                });
                self.value(message, field, (is_wanted, wanted), out.as_deref_mut(), depth)?;
                if let Some(out) = &mut out {
                    out.leave(before);
                }
            }
            if let Some(out) = &mut out {
                out.leave(outside);
            }
        }
        Ok(())
    }

    /// Reads one value of a field, which is wanted or not, and of it what is below the wanted fields.
    fn value(
        &mut self,
        message: &MessageType,
        field: &MessageField,
        (is_wanted, wanted): (bool, &[&str]),
        out: Option<&mut Numbers>,
        depth: usize,
    ) -> Result<(), Broken> {
        match field.of {
            FieldType::Number(number) => {
                let value = self.number(number)?;
                if let Some(out) = out.filter(|_| is_wanted && wanted.is_empty()) {
                    out.push(value);
                }
            }
            FieldType::Text => {
                let text = self.text()?;
                let is_label = depth == 0 && field.name == "name" && field.many != Many::One;
                if let Some(out) = out.filter(|_| is_label) {
                    out.labels.push(String::from_utf8_lossy(text).into());
                }
            }
            FieldType::Of(place) => {
                let next = &message.types[place];
                let out = out.filter(|_| is_wanted && !next.is_about);
                self.of_type(message, next, wanted, out, depth + 1)?;
            }
        }
        Ok(())
    }

    fn take(&mut self, size: usize) -> Result<&'d [u8], Broken> {
        let part = self.data.get(self.at..).and_then(|rest| rest.get(..size)).ok_or(SHORT)?;
        self.at += size;
        Ok(part)
    }

    /// Reads an unsigned number of `size` bytes at the next multiple of it.
    fn bits(&mut self, size: usize) -> Result<u64, Broken> {
        self.at = self.at.next_multiple_of(size);
        let (is_big, bytes) = (self.is_big, self.take(size)?);
        let add = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
        Ok(if is_big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) })
    }

    pub fn word(&mut self) -> Result<u32, Broken> {
        self.bits(4).map(|bits| bits as u32)
    }

    pub fn byte(&mut self) -> Result<u8, Broken> {
        self.bits(1).map(|bits| bits as u8)
    }

    fn number(&mut self, number: Number) -> Result<f64, Broken> {
        let bits = self.bits(number.size())?;
        Ok(match number {
            Number::Uint(_) => bits as f64,
            Number::Int(size) => {
                let unused = 64 - 8 * size as u32;
                ((bits << unused) as i64 >> unused) as f64
            }
            Number::F32 => f32::from_bits(bits as u32).into(),
            Number::F64 => f64::from_bits(bits),
        })
    }

    /// Reads a text, which ends with a zero byte.
    pub fn text(&mut self) -> Result<&'d [u8], Broken> {
        let size = self.word()? as usize;
        let bytes = self.take(size)?;
        Ok(bytes.strip_suffix(&[0]).unwrap_or(bytes))
    }

    /// Reads a row of bytes after their number.
    pub fn bytes(&mut self) -> Result<&'d [u8], Broken> {
        let size = self.word()? as usize;
        self.take(size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str, wanted: &[&str], bytes: &[u8]) -> Result<Vec<f64>, Broken> {
        let message = MessageType::parse("own/msg/Press", text).unwrap();
        let mut out = Numbers::default();
        Cdr::new(bytes)?.numbers(&message, wanted, &mut out)?;
        Ok(out.values)
    }

    #[test]
    fn numbers_stand_at_multiples_of_their_size() {
        let text = "int8 a\nuint16 b\nstring s\nfloat64[] c\nEmpty e\nbool d\n===\nMSG: own/Empty\n";
        let texts = [2, 0, 0, 0, b'x', 0, 9, 9, 1, 0, 0, 0];
        let little = [&[0, 1, 0, 0, 0xFE, 9, 2, 1][..], &texts, &1.5f64.to_le_bytes(), &[0, 1]].concat();
        assert_eq!(numbers(text, &[], &little).unwrap(), [-2.0, 258.0, 1.5, 1.0]);
        assert_eq!(numbers(text, &["c"], &little).unwrap(), [1.5]);
        let big = [0, 0, 0, 0, 1, 9, 1, 2, 0, 0, 0, 1, 0, 9, 9, 9, 0, 0, 0, 0, 7, 1];
        assert_eq!(numbers(text, &[], &big).unwrap(), [1.0, 258.0, 1.0]);
        for cut in 0..little.len() {
            assert_eq!(numbers(text, &[], &little[..cut]), Err(SHORT), "{cut}");
        }
    }

    #[test]
    fn damage_costs_no_time() {
        let many = [&[0, 1, 0, 0][..], &[0xFF; 40]].concat();
        assert_eq!(numbers("Self[] a\n===\nMSG: own/Self\nfloat64[3] b", &[], &many), Err(SHORT));
        let within = MessageType::parse("own/msg/A", "B b\n===\nMSG: own/B\nB b").unwrap();
        let broken = Cdr::new(&many).unwrap().numbers(&within, &[], &mut Numbers::default());
        assert_eq!(broken, Err("is of a type within itself"));
        assert!(Cdr::new(&[0, 7, 0, 0, 1]).is_err_and(|why| why.contains("version 1")));
    }
}
