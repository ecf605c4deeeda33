//! How much memory a file's messages would take, before any of it is taken.
//!
//! A message of two bytes becomes a structure of some hundred. So the file is walked first, without allocating, and one
//! that would become more than any network needs is refused. Values of tensors are not counted: they take no more
//! memory than they take in the file.

/// Bytes that the messages of a file may take. The largest networks of torchvision stay below a tenth of it.
const MOST: usize = 24 << 20;

/// Bytes that are charged for a message, a text and a number.
const MESSAGE: usize = 256;
const TEXT: usize = 48;
const NUMBER: usize = 16;

/// A message of [`crate::proto`], by the fields that repeat or lead to such.
#[derive(Clone, Copy)]
enum MessageKind {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    ValueInfo,
    Type,
    TensorType,
    Shape,
    Leaf,
}

/// The type of a field of a message.
enum FieldType {
    Message(MessageKind),
    Text,
    Numbers,
    Other,
}

impl MessageKind {
    fn field(self, number: u64) -> FieldType {
        use FieldType::{Message, Numbers, Other, Text};
        match (self, number) {
            (MessageKind::Model, 7) => Message(MessageKind::Graph),
            (MessageKind::Model, 8 | 14) | (MessageKind::Tensor, 13) | (MessageKind::Shape, 1) => {
                Message(MessageKind::Leaf)
            }
            (MessageKind::Graph, 1) => Message(MessageKind::Node),
            (MessageKind::Graph, 5) | (MessageKind::Attribute, 5) => Message(MessageKind::Tensor),
            (MessageKind::Graph, 11 | 12) => Message(MessageKind::ValueInfo),
            (MessageKind::Node, 1 | 2) | (MessageKind::Attribute, 9) => Text,
            (MessageKind::Node, 5) => Message(MessageKind::Attribute),
            (MessageKind::Attribute, 7 | 8) | (MessageKind::Tensor, 1 | 5 | 7) => Numbers,
            (MessageKind::ValueInfo, 2) => Message(MessageKind::Type),
            (MessageKind::Type, 1) => Message(MessageKind::TensorType),
            (MessageKind::TensorType, 2) => Message(MessageKind::Shape),
            _ => Other,
        }
    }
}

/// Checks that the bytes hold a model, and that its messages would not become too large.
///
/// # Errors
/// Why the bytes are no model, or one that is too large.
pub fn check(bytes: &[u8]) -> Result<(), String> {
    let mut left = MOST;
    walk(MessageKind::Model, bytes, &mut left)
}

/// Walks the fields of a message; messages nest as deep as the kinds do.
fn walk(kind: MessageKind, mut bytes: &[u8], left: &mut usize) -> Result<(), String> {
    let cut = || "a field is longer than the file".to_string();
    while !bytes.is_empty() {
        let key = varint(&mut bytes).ok_or_else(cut)?;
        let field = kind.field(key >> 3);
        let content = match key & 7 {
            0 => {
                varint(&mut bytes).ok_or_else(cut)?;
                &[][..]
            }
            1 => bytes.split_off(..8).ok_or_else(cut)?,
            2 => {
                let length = usize::try_from(varint(&mut bytes).ok_or_else(cut)?).map_err(|_| cut())?;
                bytes.split_off(..length).ok_or_else(cut)?
            }
            5 => bytes.split_off(..4).ok_or_else(cut)?,
            other => return Err(format!("field {} has the unknown wire type {other}", key >> 3)),
        };
        let charge = match field {
            FieldType::Message(_) => MESSAGE,
            FieldType::Text => TEXT,
            FieldType::Numbers => NUMBER * content.len().max(1),
            FieldType::Other => 0,
        };
        let too_large = "its messages would take more memory than any network needs";
        *left = left.checked_sub(charge).ok_or(too_large)?;
        if let FieldType::Message(inner) = field {
            walk(inner, content, left)?;
        }
    }
    Ok(())
}

/// Reads a number in protobuf's variable length.
fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = *bytes.split_off_first()?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}
