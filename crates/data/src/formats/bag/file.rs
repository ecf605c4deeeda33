//! Reads the messages of an MCAP file, one after the other.
//!
//! After "MCAP Format Specification" (mcap.dev/spec). Only the current record and the topics of a file are in memory.

use crate::{Error, Result};
use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use taxel_base::quiet::caught;

/// Most bytes of a record in a smaller file: chunks are compressed.
const RECORD: u64 = 4 << 20;
/// Most bytes of all names and definitions.
const MAX_TEXTS: usize = 16 << 20;

/// A named stream of messages of one type.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Topic {
    pub name: String,
    /// Name of the type of its messages.
    pub kind: String,
    /// How messages are encoded: `cdr`, `json`, ...
    pub encoding: String,
    /// The language of `definition`: `ros2msg`, `jsonschema`, ...
    pub language: String,
    pub definition: String,
}

/// A message of a topic.
pub(crate) struct BagMessage<'m> {
    /// Place of its topic among those read so far.
    pub topic: usize,
    /// Time at which it was recorded, in nanoseconds.
    pub time: u64,
    pub data: &'m [u8],
}

/// Hands every message of a file to `take`, with the topics so far.
pub(crate) fn each(
    path: &Path,
    topics: &mut Vec<Topic>,
    mut take: impl FnMut(&[Topic], BagMessage) -> Result<()>,
) -> Result<()> {
    let mut records = Records::open(path)?;
    let mut known = Known::new(&records.file, topics);
    while let Some((opcode, data)) = records.next()? {
        let is_message = opcode == op::MESSAGE;
        if !is_message && !matches!(opcode, op::SCHEMA | op::CHANNEL) {
            continue;
        }
        if !texts_fit(opcode, data) {
            return Err(damaged(&known.file, "has a record whose texts are longer than itself"));
        }
        match mcap::parse_record(opcode, data).map_err(|e| unread(&known.file, &e))? {
            Record::Schema { header, data } => {
                let text = String::from_utf8_lossy(&data).into_owned();
                known.schema(header.id, [header.name, header.encoding, text])?;
            }
            Record::Channel(channel) => {
                known.channel(channel.id, channel.schema_id, channel.topic, channel.message_encoding)?;
            }
            Record::Message { header, data } => {
                let Some(topic) = known.channels.get(&header.channel_id).copied() else {
                    let why =
                        format!("has a message on channel {}, which it does not say", header.channel_id);
                    return Err(damaged(&known.file, &why));
                };
                take(known.topics, BagMessage { topic, time: header.log_time, data: &data })?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// The topics of the file so far.
struct Known<'t> {
    file: String,
    topics: &'t mut Vec<Topic>,
    places: HashMap<String, usize>,
    /// Name, language and definition.
    schemas: HashMap<u16, [String; 3]>,
    channels: HashMap<u16, usize>,
    texts: usize,
}

impl<'t> Known<'t> {
    fn new(file: &str, topics: &'t mut Vec<Topic>) -> Self {
        let places = topics.iter().enumerate().map(|(at, topic)| (topic.name.clone(), at)).collect();
        let (schemas, channels) = (HashMap::new(), HashMap::new());
        Self { file: file.into(), topics, places, schemas, channels, texts: 0 }
    }

    fn schema(&mut self, id: u16, texts: [String; 3]) -> Result<()> {
        self.claim(texts.iter().map(String::len).sum())?;
        self.schemas.insert(id, texts);
        Ok(())
    }

    fn channel(&mut self, id: u16, schema: u16, name: String, encoding: String) -> Result<()> {
        if self.channels.get(&id).is_some_and(|at| self.topics[*at].name == name) {
            return Ok(());
        }
        let [kind, language, definition] = match (schema, self.schemas.get(&schema)) {
            (_, Some(texts)) => texts.clone(),
            (0, None) => Default::default(),
            (_, None) => {
                let why = format!("has topic {name} of schema {schema}, which it does not say");
                return Err(damaged(&self.file, &why));
            }
        };
        self.claim(name.len() + kind.len() + definition.len())?;
        let at = match self.places.get(&name) {
            Some(at) if self.topics[*at].kind == kind && self.topics[*at].encoding == encoding => *at,
            Some(at) => {
                let why = format!("topic {name} is {} and {kind}", self.topics[*at].kind);
                return Err(Error::file(&self.file, why));
            }
            None => {
                self.places.insert(name.clone(), self.topics.len());
                self.topics.push(Topic { name, kind, encoding, language, definition });
                self.topics.len() - 1
            }
        };
        self.channels.insert(id, at);
        Ok(())
    }

    fn claim(&mut self, texts: usize) -> Result<()> {
        self.texts += texts;
        if self.texts > MAX_TEXTS {
            return Err(damaged(&self.file, "says more of its topics than of what was recorded"));
        }
        Ok(())
    }
}

/// The records of a file, those of its chunks among them.
struct Records {
    file: String,
    stream: BufReader<File>,
    /// Bytes that are not read yet.
    left: u64,
    reader: LinearReader,
    record: Vec<u8>,
}

impl Records {
    fn open(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let io = Error::io(path);
        let handle = File::open(path).map_err(&io)?;
        let left = handle.metadata().map_err(&io)?.len();
        if left == 0 {
            return Err(Error::EmptyFile { file });
        }
        let most = left.max(RECORD) as usize;
        let options =
            LinearReaderOptions::default().with_validate_chunk_crcs(true).with_record_length_limit(most);
        let reader = LinearReader::new_with_options(options);
        Ok(Self { file, stream: BufReader::new(handle), left, reader, record: vec![] })
    }

    /// Reads opcode and content of the next record.
    fn next(&mut self) -> Result<Option<(u8, &[u8])>> {
        loop {
            let (reader, record) = (&mut self.reader, &mut self.record);
            let event = caught(|| match reader.next_event() {
                None => Ok(ReaderEvent::End),
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => Ok(ReaderEvent::Read(bytes)),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    record.clear();
                    record.extend_from_slice(data);
                    Ok(ReaderEvent::Record(opcode))
                }
                Some(Err(e)) => Err(e),
            });
            match event {
                None => return Err(damaged(&self.file, "cannot be taken apart")),
                Some(Err(e)) => return Err(unread(&self.file, &e)),
                Some(Ok(ReaderEvent::End)) => return Ok(None),
                Some(Ok(ReaderEvent::Record(opcode))) => return Ok(Some((opcode, &self.record))),
                Some(Ok(ReaderEvent::Read(bytes))) => self.read(bytes)?,
            }
        }
    }

    /// Gives the reader the bytes that it asks for, which the file has.
    fn read(&mut self, bytes: usize) -> Result<()> {
        let wanted = bytes as u64;
        if wanted > self.left {
            return Err(damaged(&self.file, "is cut short"));
        }
        self.stream.read_exact(self.reader.insert(bytes)).map_err(Error::io(&self.file))?;
        self.reader.notify_read(bytes);
        self.left -= wanted;
        Ok(())
    }
}

/// The next thing that the reader wants or has.
enum ReaderEvent {
    Read(usize),
    Record(u8),
    End,
}

/// Checks whether the texts of a record lie within it: the library claims memory on their word.
fn texts_fit(opcode: u8, data: &[u8]) -> bool {
    let size = |at: usize| {
        let size: [u8; 4] = data.get(at..)?.get(..4)?.try_into().ok()?;
        Some(at + 4 + u32::from_le_bytes(size) as usize).filter(|end| *end <= data.len())
    };
    let texts = || {
        let mut at = size(size(if opcode == op::SCHEMA { 2 } else { 4 })?)?;
        if opcode == op::CHANNEL {
            // A map of texts, after the number of its bytes.
            let end = size(at)?;
            at += 4;
            while at < end {
                at = size(at)?;
            }
        }
        Some(())
    };
    !matches!(opcode, op::SCHEMA | op::CHANNEL) || texts().is_some()
}

fn damaged(file: &str, why: &str) -> Error {
    Error::file(file, format!("{why}; copy it again, or mend it with mcap recover"))
}

fn unread(file: &str, error: &McapError) -> Error {
    match error {
        McapError::BadMagic => Error::file(
            file,
            "is no MCAP file; record bags with ros2 bag record --storage mcap, or convert them",
        ),
        McapError::UnexpectedEof | McapError::UnexpectedEoc => damaged(file, "is cut short"),
        other => damaged(file, &format!("is damaged ({})", other.to_string().to_lowercase())),
    }
}
