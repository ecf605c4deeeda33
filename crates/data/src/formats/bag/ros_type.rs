//! Parses the types of ROS 2 messages from the definitions in a bag (`ros2msg`).
//!
//! After the ROS 2 documentation, "Interfaces": a line `type name`, of arrays `type[3]`, `type[]` or `type[<=3]`;
//! lines with `=` are constants. The types that a message uses follow it, each after a line of `=` and `MSG: name`.
//!
//! `re_ros_msg` 0.36 will not do: it bounds neither the number of fields nor the memory of a line, refuses definitions for
//! defaults and names of constants that do not matter for the bytes, and needs Rust 1.95.

use std::collections::HashMap;

/// Most fields of all types of a definition that is not damaged.
const MAX_FIELDS: usize = 1 << 16;

/// Types whose numbers are no values of a sensor: times, frames, layouts of arrays.
const ABOUT: [&str; 5] = [
    "std_msgs/Header",
    "builtin_interfaces/Time",
    "builtin_interfaces/Duration",
    "std_msgs/MultiArrayLayout",
    "std_msgs/MultiArrayDimension",
];

/// A number as it is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    /// Signed, of so many bytes.
    Int(usize),
    Uint(usize),
    F32,
    F64,
}

impl Number {
    pub fn size(self) -> usize {
        match self {
            Self::Int(size) | Self::Uint(size) => size,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "bool" | "byte" | "char" | "uint8" => Self::Uint(1),
            "int8" => Self::Int(1),
            "int16" => Self::Int(2),
            "uint16" => Self::Uint(2),
            "int32" => Self::Int(4),
            "uint32" => Self::Uint(4),
            "int64" => Self::Int(8),
            "uint64" => Self::Uint(8),
            "float32" => Self::F32,
            "float64" => Self::F64,
            _ => return None,
        })
    }
}

/// The type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FieldType {
    Number(Number),
    Text,
    /// Another type, by its place in [`MessageType::types`].
    Of(usize),
}

/// The number of values in a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Many {
    One,
    Exactly(usize),
    Any,
}

#[derive(Debug, PartialEq)]
pub(crate) struct MessageField {
    pub name: String,
    pub of: FieldType,
    pub many: Many,
}

#[derive(Debug, Default, PartialEq)]
pub(crate) struct RosType {
    pub fields: Vec<MessageField>,
    /// Its numbers describe the values and are none.
    pub is_about: bool,
}

/// The type of a message: itself first, then the types that it uses.
#[derive(Debug, PartialEq)]
pub(crate) struct MessageType {
    pub types: Vec<RosType>,
}

impl MessageType {
    /// Parses the definition of the type `name`, such as `sensor_msgs/msg/JointState`, or says why it cannot.
    pub fn parse(name: &str, definition: &str) -> Result<Self, String> {
        let mut parts = vec![(short(name), vec![])];
        for line in definition.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                parts.push((short(name.trim()), vec![]));
            } else if !line.is_empty()
                && !line.starts_with("===")
                && let Some((_, lines)) = parts.last_mut()
            {
                lines.push(line);
            }
        }
        let places: HashMap<&str, usize> =
            parts.iter().enumerate().rev().map(|(at, (name, _))| (name.as_str(), at)).collect();
        let mut count = 0;
        let mut types = vec![];
        for (name, lines) in &parts {
            let package = name.split('/').next().unwrap_or_default();
            let mut fields = vec![];
            for line in lines {
                fields.extend(field(line, package, &places)?);
                count += 1;
                if count > MAX_FIELDS {
                    return Err(format!("has more than {MAX_FIELDS} fields"));
                }
            }
            types.push(RosType { fields, is_about: ABOUT.contains(&name.as_str()) });
        }
        Ok(Self { types })
    }
}

/// Shortens `sensor_msgs/msg/JointState` to `sensor_msgs/JointState`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// Parses the field of a line; none of a constant.
fn field(line: &str, package: &str, places: &HashMap<&str, usize>) -> Result<Option<MessageField>, String> {
    let refuse = || format!("has a line {:?}", line.chars().take(40).collect::<String>());
    let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(refuse)?;
    let rest = rest.trim();
    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (kind, many) = match kind.split_once('[') {
        None => (kind, Many::One),
        Some((kind, many)) => {
            let many = many.strip_suffix(']').ok_or_else(refuse)?;
            let many = match many.parse() {
                Ok(0) => return Err(refuse()),
                Ok(count) => Many::Exactly(count),
                Err(_) if many.is_empty() || many.starts_with("<=") => Many::Any,
                Err(_) => return Err(refuse()),
            };
            (kind, many)
        }
    };
    let of = match Number::named(kind) {
        Some(number) => FieldType::Number(number),
        None if kind == "string" || kind.starts_with("string<=") => FieldType::Text,
        None => {
            let name = short(kind);
            let beside = format!("{package}/{name}");
            let header = if name == "Header" { "std_msgs/Header" } else { &name };
            let place = [name.as_str(), &beside, header].into_iter().find_map(|name| places.get(name));
            FieldType::Of(*place.ok_or_else(|| format!("uses {kind}, which it does not define"))?)
        }
    };
    Ok(Some(MessageField { name, of, many }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_brings_the_types_that_it_uses() {
        let text = "# A press.\nuint8 LOUD=3\nstring<=9 unit \"N\"\nForce[<=4] forces\nHeader header\nfloat64[2] bias [0.5, 1]\n\
                    ===\nMSG: own/Force\nint16 x  # newtons\nbool is_on\n\
                    ===\nMSG: std_msgs/Header\nuint32 seq\n";
        let message = MessageType::parse("own/msg/Press", text).unwrap();
        let field = |name: &str, of, many| MessageField { name: name.into(), of, many };
        assert_eq!(
            message.types[0].fields,
            [
                field("unit", FieldType::Text, Many::One),
                field("forces", FieldType::Of(1), Many::Any),
                field("header", FieldType::Of(2), Many::One),
                field("bias", FieldType::Number(Number::F64), Many::Exactly(2)),
            ]
        );
        assert_eq!(message.types[1].fields[0].of, FieldType::Number(Number::Int(2)));
        assert_eq!(
            message.types.iter().map(|ros_type| ros_type.is_about).collect::<Vec<_>>(),
            [false, false, true]
        );
    }

    #[test]
    fn what_is_no_definition_is_refused() {
        for (text, why) in [
            ("Force force", "uses Force, which it does not define"),
            ("float64", "has a line \"float64\""),
            ("float64[x] a", "has a line \"float64[x] a\""),
            ("float64[0] a", "has a line \"float64[0] a\""),
            ("wstring a", "uses wstring, which it does not define"),
        ] {
            assert_eq!(MessageType::parse("own/msg/Press", text).unwrap_err(), why);
        }
    }
}
