//! TensorBoard event files: `tensorboard/<network>.r<repetition>.f<fold>/events.out.tfevents.0`.
//!
//! # Reference
//! TensorFlow's `TFRecord` framing (length, masked CRC-32C, payload, masked CRC-32C) around the messages of its
//! `event.proto` and `summary.proto`. The wall time is the step, so that equal runs write equal bytes.

use crc::{CRC_32_ISCSI, Crc};
use prost::Message;

use taxel_data::Task;

use crate::error::{Error, Result};
use crate::json_file::write_atomic;
use crate::metrics::Metric;
use crate::run::folder::RunFolder;
use crate::run::records::FoldRecord;

/// CRC-32C, by Castagnoli's polynomial.
const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

// Every field is optional: TensorBoard is told zeros too.

#[derive(Clone, PartialEq, Message)]
struct Event {
    #[prost(double, optional, tag = "1")]
    wall_time: Option<f64>,
    #[prost(int64, optional, tag = "2")]
    step: Option<i64>,
    #[prost(string, optional, tag = "3")]
    file_version: Option<String>,
    #[prost(message, optional, tag = "5")]
    summary: Option<EventSummary>,
}

#[derive(Clone, PartialEq, Message)]
struct EventSummary {
    #[prost(message, repeated, tag = "1")]
    values: Vec<Scalar>,
}

#[derive(Clone, PartialEq, Message)]
struct Scalar {
    #[prost(string, optional, tag = "1")]
    tag: Option<String>,
    #[prost(float, optional, tag = "2")]
    simple_value: Option<f32>,
}

/// Writes the events of a fold into the run folder, where it has epochs.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(folder: &RunFolder, record: &FoldRecord, task: &Task) -> Result<()> {
    if record.epochs.is_empty() {
        return Ok(());
    }
    let at = folder.events_path(&record.key);
    std::fs::create_dir_all(&at).map_err(|e| Error::io(&at, "created", e))?;
    write_atomic(&at.join("events.out.tfevents.0"), &events(record, Metric::primary(task)))
}

/// Returns the file of one fold: one event per epoch with its losses and its values of the `primary` metric.
fn events(record: &FoldRecord, primary: &Metric) -> Vec<u8> {
    let [of_training, of_validation] = ["train", "validation"].map(|part| format!("{}/{part}", primary.name));
    let version =
        Event { wall_time: Some(0.0), file_version: Some("brain.Event:2".into()), ..Event::default() };
    let mut file = framed(&version);
    for epoch in &record.epochs {
        let scalars = [
            ("lr", Some(epoch.lr)),
            ("loss/train", Some(epoch.train_loss)),
            (of_training.as_str(), Some(epoch.train_score)),
            ("loss/validation", epoch.validation_loss),
            (of_validation.as_str(), epoch.validation_score),
        ];
        file.extend(framed(&event(epoch.epoch, &scalars)));
    }
    file
}

/// Makes the event of one epoch; scalars without a value are left out.
fn event(epoch: usize, scalars: &[(&str, Option<f64>)]) -> Event {
    let scalar = |(tag, value): &(&str, Option<f64>)| {
        Some(Scalar { tag: Some((*tag).into()), simple_value: Some((*value)? as f32) })
    };
    Event {
        wall_time: Some(epoch as f64),
        step: Some(epoch as i64),
        summary: Some(EventSummary { values: scalars.iter().filter_map(scalar).collect() }),
        ..Event::default()
    }
}

fn framed(event: &Event) -> Vec<u8> {
    let payload = event.encode_to_vec();
    let length = (payload.len() as u64).to_le_bytes();
    [&length[..], &masked(&length).to_le_bytes(), &payload, &masked(&payload).to_le_bytes()].concat()
}

fn masked(data: &[u8]) -> u32 {
    CHECKSUM.checksum(data).rotate_right(15).wrapping_add(0xa282_ead8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_castagnolis() {
        // RFC 3720, appendix B.4.
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0xe306_9283);
        assert_eq!(CHECKSUM.checksum(&[0; 32]), 0x8a91_36aa);
        assert_eq!(masked(&[0; 32]), 0x8a91_36aau32.rotate_right(15).wrapping_add(0xa282_ead8));
    }

    /// Bytes of version 0.1.0, which wrote them by hand.
    #[test]
    fn an_event_has_the_bytes_that_it_always_had() {
        let hex: String =
            framed(&event(300, &[("lr", Some(0.0)), ("loss/train", Some(0.5)), ("loss/validation", None)]))
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect();
        assert_eq!(
            hex,
            "2c00000000000000f4aecc45090000000000c0724010ac022a1e0a090a026c7215000000000a110a0a6c6f73732f747261696e150000003f42aa2d1c"
        );
    }
}
