//! Memory of one value: floats, or bytes.

use taxel_kernels::Buffer;
use taxel_kernels::frozen::bytes::{Bytes, Target};

use crate::places::Room;

/// A buffer.
pub(crate) enum Memory {
    Floats(Buffer),
    Bytes(Bytes),
}

impl Default for Memory {
    fn default() -> Self {
        Memory::Floats(Buffer::default())
    }
}

impl Memory {
    /// A buffer whose margins hold zeros.
    pub fn new(room: &Room) -> Self {
        match room.zero {
            None => Memory::Floats(Buffer::zeros(room.len)),
            Some(zero) => Memory::Bytes(Bytes::filled(room.len + Bytes::SPARE, zero)),
        }
    }

    /// Returns the values of a buffer of floats.
    pub fn floats(&self) -> &[f32] {
        match self {
            Memory::Floats(values) => values,
            Memory::Bytes(_) => unreachable!("the program reads floats where floats were written"),
        }
    }

    /// Returns the values of a buffer of bytes.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Memory::Bytes(values) => values,
            Memory::Floats(_) => unreachable!("the program reads bytes where bytes were written"),
        }
    }

    pub fn target(&mut self) -> Target<'_> {
        match self {
            Memory::Floats(values) => Target::Floats(values),
            Memory::Bytes(values) => Target::Bytes(values),
        }
    }
}
