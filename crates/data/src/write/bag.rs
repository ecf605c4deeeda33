//! Writes a recording as a bag.

use crate::{Error, Result};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::Cursor;

/// Topic of the bags that are written.
pub const BAG_TOPIC: &str = "/recording";
/// Name of the type of its messages.
const KIND: &str = "taxel.Recording";

/// Returns an MCAP file of one topic: a JSON object of the `channels` for each time step of `values` `[times, channels]`, with the
/// schema of it. Messages lie `times` (s) after `began`, in nanoseconds since 1970.
///
/// # Errors
/// Values that are not as many as times and channels, or not finite; channels of one name.
pub fn bag_bytes(channels: &[String], times: &[f64], values: &[f32], began: u64) -> Result<Vec<u8>> {
    let refuse = |why: String| Error::file(BAG_TOPIC, why);
    if values.len() != times.len() * channels.len() {
        let (values, times, channels) = (values.len(), times.len(), channels.len());
        return Err(refuse(format!("{values} values are not those of {times} times of {channels} channels")));
    }
    let number = json!({ "type": "number" });
    let properties: Map<String, Value> = channels.iter().map(|name| (name.clone(), number.clone())).collect();
    if properties.len() < channels.len() {
        return Err(refuse("two channels have one name".into()));
    }
    let schema = json!({ "title": KIND, "type": "object", "properties": properties, "required": channels });
    let write = || -> mcap::McapResult<Vec<u8>> {
        let mut writer = WriteOptions::new().library("taxel").create(Cursor::new(vec![]))?;
        let schema = writer.add_schema(KIND, "jsonschema", schema.to_string().as_bytes())?;
        let channel_id = writer.add_channel(schema, BAG_TOPIC, "json", &BTreeMap::new())?;
        for ((sequence, time), row) in (0..).zip(times).zip(values.chunks_exact(channels.len().max(1))) {
            let log_time = began + (time * 1e9).round() as u64;
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, message(channels, row).as_bytes())?;
        }
        writer.finish()?;
        Ok(writer.into_inner().into_inner())
    };
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        return Err(refuse(format!("value {at} is {}, which JSON cannot hold", values[at])));
    }
    write().map_err(|error| refuse(error.to_string()))
}

/// Writes an object in the order of the channels, each number in the fewest digits that give it again.
fn message(channels: &[String], row: &[f32]) -> String {
    let pairs = channels.iter().zip(row);
    let pairs: Vec<String> =
        pairs.map(|(name, value)| format!("{}:{value}", Value::String(name.clone()))).collect();
    format!("{{{}}}", pairs.join(","))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::ReadOptions;
    use crate::formats::bag::messages::bag_messages;

    #[test]
    fn a_bag_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("press.mcap");
        let channels = ["thumb", "índex [N]", "a \"b\""].map(String::from);
        let times: Vec<f64> = (0..40).map(|i| f64::from(i) / 3e3).collect();
        let extremes = [f32::MIN_POSITIVE, -0.0, 1.0 / 3.0, f32::MAX, 16_777_217.0];
        let values: Vec<f32> = (0..120).map(|i| extremes[i % 5] / (1 + i / 5) as f32).collect();
        let began = 1_700_000_000_123_000_000;
        std::fs::write(&path, bag_bytes(&channels, &times, &values, began).unwrap()).unwrap();
        let read = bag_messages(&path, &ReadOptions::default()).unwrap();
        assert_eq!((read.topic.as_str(), read.channels.as_slice()), (BAG_TOPIC, &channels[..]));
        assert_eq!(read.values, values);
        assert!(read.times.iter().zip(&times).all(|(read, time)| (read - time).abs() < 1e-9));
    }

    #[test]
    fn what_a_bag_cannot_hold_is_refused() {
        let names = ["a", "b"].map(String::from);
        for (names, values, word) in [
            (&names[..], vec![1.0], "1 values"),
            (&names, vec![1.0, f32::NAN], "NaN"),
            (&["a".into(), "a".into()], vec![1.0, 2.0], "one name"),
        ] {
            let error = bag_bytes(names, &[0.0], &values, 0).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
