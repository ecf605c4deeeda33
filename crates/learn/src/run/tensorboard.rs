//! TensorBoard event files: `tensorboard/<network>.r<repetition>.f<fold>/events.out.tfevents.0`.
//!
//! # Reference
//! TensorFlow's `TFRecord` framing (length, masked CRC-32C, payload, masked CRC-32C) around protocol buffers
//! `Event { double wall_time = 1; int64 step = 2; string file_version = 3; Summary summary = 5 }`.
//!
//! Written out here: the crates for it want a protocol buffer compiler at build time. The wall time is the
//! step, so that equal runs write equal bytes.

use crate::run::records::FoldRecord;

/// The file of one fold: one event per epoch with its losses and accuracies.
pub(crate) fn events(record: &FoldRecord) -> Vec<u8> {
    let mut file = vec![];
    let mut version = vec![];
    double(&mut version, 1, 0.0);
    bytes(&mut version, 3, b"brain.Event:2");
    frame(&mut file, &version);
    for epoch in &record.epochs {
        let scalars = [
            ("lr", Some(epoch.lr)),
            ("loss/train", Some(epoch.train_loss)),
            ("score/train", Some(epoch.train_score)),
            ("loss/validation", epoch.validation_loss),
            ("score/validation", epoch.validation_score),
        ];
        let mut summary = vec![];
        for (tag, value) in scalars.into_iter().filter_map(|(tag, value)| Some((tag, value?))) {
            let mut own = vec![];
            bytes(&mut own, 1, tag.as_bytes());
            // simple_value, a 32-bit float.
            key(&mut own, 2, 5);
            own.extend((value as f32).to_le_bytes());
            bytes(&mut summary, 1, &own);
        }
        let mut event = vec![];
        double(&mut event, 1, epoch.epoch as f64);
        key(&mut event, 2, 0);
        varint(&mut event, epoch.epoch as u64);
        bytes(&mut event, 5, &summary);
        frame(&mut file, &event);
    }
    file
}

fn frame(file: &mut Vec<u8>, payload: &[u8]) {
    let length = (payload.len() as u64).to_le_bytes();
    file.extend(length);
    file.extend(masked(&length).to_le_bytes());
    file.extend(payload);
    file.extend(masked(payload).to_le_bytes());
}

fn masked(data: &[u8]) -> u32 {
    crc32c(data).rotate_right(15).wrapping_add(0xa282_ead8)
}

/// CRC-32C (Castagnoli), bit by bit: the files are small.
fn crc32c(data: &[u8]) -> u32 {
    let mut crc = !0u32;
    for byte in data {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0x82f6_3b78 } else { crc >> 1 };
        }
    }
    !crc
}

fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn key(out: &mut Vec<u8>, field: u64, wire: u64) {
    varint(out, field << 3 | wire);
}

fn double(out: &mut Vec<u8>, field: u64, value: f64) {
    key(out, field, 1);
    out.extend(value.to_le_bytes());
}

fn bytes(out: &mut Vec<u8>, field: u64, value: &[u8]) {
    key(out, field, 2);
    varint(out, value.len() as u64);
    out.extend(value);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_castagnolis() {
        // RFC 3720, appendix B.4.
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(masked(&[0; 32]), 0x8a91_36aau32.rotate_right(15).wrapping_add(0xa282_ead8));
    }

    #[test]
    fn varints_carry_seven_bits_a_byte() {
        let mut out = vec![];
        varint(&mut out, 300);
        assert_eq!(out, [0xac, 0x02]);
    }
}
