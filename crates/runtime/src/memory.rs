//! Memory of one value: floats, or bytes.

use taxel_kernels::Buffer;
use taxel_kernels::frozen::bytes::{Bytes, Target};

use crate::places::Room;

/// A buffer.
pub(crate) enum ProgramBuffer {
    Floats(Buffer),
    Bytes(Bytes),
}

impl Default for ProgramBuffer {
    fn default() -> Self {
        ProgramBuffer::Floats(Buffer::default())
    }
}

impl ProgramBuffer {
    /// Makes a buffer whose margins hold zeros.
    pub fn new(room: &Room) -> Self {
        match room.zero {
            None => ProgramBuffer::Floats(Buffer::zeros(room.len)),
            Some(zero) => ProgramBuffer::Bytes(Bytes::filled(room.len + Bytes::SPARE, zero)),
        }
    }

    /// Returns the values of a buffer of floats.
    pub fn floats(&self) -> &[f32] {
        match self {
            ProgramBuffer::Floats(values) => values,
            ProgramBuffer::Bytes(_) => unreachable!("the program reads floats where floats were written"),
        }
    }

    /// Returns the values of a buffer of bytes.
    pub fn bytes(&self) -> &[u8] {
        match self {
            ProgramBuffer::Bytes(values) => values,
            ProgramBuffer::Floats(_) => unreachable!("the program reads bytes where bytes were written"),
        }
    }

    pub fn target(&mut self) -> Target<'_> {
        match self {
            ProgramBuffer::Floats(values) => Target::Floats(values),
            ProgramBuffer::Bytes(values) => Target::Bytes(values),
        }
    }
}
