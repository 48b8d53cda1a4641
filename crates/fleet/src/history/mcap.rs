//! The MCAP format (<https://mcap.dev/spec>), as far as our files need it: chunks without compression, with indexes and
//! a summary.
//!
//! Written by hand: Foxglove's crate brings thirteen others, and changes features of `syn` and `proc-macro2` that all
//! macros are compiled with. Foxglove's own reader of Python holds it, in `tests/fleet`.

use std::collections::BTreeMap;

use crc::{CRC_32_ISO_HDLC, Crc};

/// What a file begins and ends with.
pub(super) const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// Operation code and length of a record.
pub(super) const RECORD_START: usize = 9;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Operation codes.
pub(super) mod op {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const STATISTICS: u8 = 0x0b;
    pub const METADATA: u8 = 0x0c;
    pub const METADATA_INDEX: u8 = 0x0d;
    pub const DATA_END: u8 = 0x0f;
}

/// Puts a record's content together.
#[derive(Default)]
struct Body(Vec<u8>);

impl Body {
    fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u64(mut self, value: u64) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    /// With its length before it.
    fn bytes(self, value: &[u8]) -> Self {
        let mut body = self.u32(len_u32(value.len()));
        body.0.extend(value);
        body
    }

    fn text(self, value: &str) -> Self {
        self.bytes(value.as_bytes())
    }

    fn texts(self, map: &[(&str, &str)]) -> Self {
        let inner = map.iter().fold(Self::default(), |body, (name, value)| body.text(name).text(value));
        self.bytes(&inner.0)
    }

    fn numbers(self, map: impl Iterator<Item = (u16, u64)>) -> Self {
        let inner = map.fold(Self::default(), |body, (key, value)| body.u16(key).u64(value));
        self.bytes(&inner.0)
    }

    fn record(self, op: u8) -> Vec<u8> {
        let mut record = vec![op];
        record.extend((self.0.len() as u64).to_le_bytes());
        record.extend(self.0);
        record
    }
}

fn len_u32(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}

/// A chunk that is being filled.
#[derive(Default)]
struct Chunk {
    records: Vec<u8>,
    times: Option<(u64, u64)>,
    /// Time and place of each message, by channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
}

/// Writes one file, in whole chunks.
pub(super) struct Writer {
    /// What was not taken yet.
    out: Vec<u8>,
    /// Bytes that were taken.
    taken: u64,
    chunk: Chunk,
    /// Schemas and channels, for the summary.
    schemas: Vec<Vec<u8>>,
    channels: Vec<Vec<u8>>,
    chunk_indexes: Vec<Vec<u8>>,
    metadata_indexes: Vec<Vec<u8>>,
    messages: BTreeMap<u16, u64>,
    times: Option<(u64, u64)>,
}

impl Writer {
    /// Begins a file.
    pub(super) fn new(library: &str, about: &str, facts: &[(&str, &str)]) -> Self {
        let mut out = MAGIC.to_vec();
        out.extend(Body::default().text("").text(library).record(op::HEADER));
        let (offset, metadata) = (out.len() as u64, Body::default().text(about).texts(facts).record(op::METADATA));
        let index = Body::default().u64(offset).u64(metadata.len() as u64).text(about).record(op::METADATA_INDEX);
        out.extend(metadata);
        Self {
            out,
            taken: 0,
            chunk: Chunk::default(),
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk_indexes: Vec::new(),
            metadata_indexes: vec![index],
            messages: BTreeMap::new(),
            times: None,
        }
    }

    /// Adds a channel of Protocol Buffers with a schema of its own; gives its number.
    pub(super) fn add_channel(&mut self, topic: &str, schema: &str, descriptors: &[u8]) -> u16 {
        let id = u16::try_from(self.channels.len() + 1).unwrap_or(u16::MAX);
        let schema = Body::default().u16(id).text(schema).text("protobuf").bytes(descriptors).record(op::SCHEMA);
        let channel = Body::default().u16(id).u16(id).text(topic).text("protobuf").texts(&[]).record(op::CHANNEL);
        self.chunk.records.extend(schema.iter().chain(&channel));
        self.schemas.push(schema);
        self.channels.push(channel);
        id
    }

    /// Adds a message.
    pub(super) fn put(&mut self, channel: u16, sequence: u32, log_ns: u64, publish_ns: u64, data: &[u8]) {
        let mut body = Body::default().u16(channel).u32(sequence).u64(log_ns).u64(publish_ns);
        body.0.extend(data);
        let at = self.chunk.records.len() as u64;
        self.chunk.records.extend(body.record(op::MESSAGE));
        self.chunk.index.entry(channel).or_default().push((log_ns, at));
        let wider = |times: Option<(u64, u64)>| {
            let (first, last) = times.unwrap_or((log_ns, log_ns));
            Some((first.min(log_ns), last.max(log_ns)))
        };
        (self.chunk.times, self.times) = (wider(self.chunk.times), wider(self.times));
        *self.messages.entry(channel).or_default() += 1;
    }

    /// Bytes in the chunk that is being filled.
    pub(super) fn chunk_bytes(&self) -> usize {
        self.chunk.records.len()
    }

    /// Closes the chunk.
    pub(super) fn flush(&mut self) {
        let Chunk { records, times, index } = std::mem::take(&mut self.chunk);
        if records.is_empty() {
            return;
        }
        let (first, last) = times.unwrap_or_default();
        let (offset, size) = (self.taken + self.out.len() as u64, records.len() as u64);
        let mut body = Body::default().u64(first).u64(last).u64(size).u32(CRC.checksum(&records)).text("").u64(size);
        body.0.extend(records);
        let chunk = body.record(op::CHUNK);
        let len = chunk.len() as u64;
        self.out.extend(chunk);
        let (indexes_at, mut places) = (self.out.len(), Vec::new());
        for (channel, entries) in index {
            places.push((channel, self.taken + self.out.len() as u64));
            let inner = entries.into_iter().fold(Body::default(), |body, (time, at)| body.u64(time).u64(at));
            self.out.extend(Body::default().u16(channel).bytes(&inner.0).record(op::MESSAGE_INDEX));
        }
        let indexes_len = (self.out.len() - indexes_at) as u64;
        let summary = Body::default().u64(first).u64(last).u64(offset).u64(len).numbers(places.into_iter());
        let summary = summary.u64(indexes_len).text("").u64(size).u64(size);
        self.chunk_indexes.push(summary.record(op::CHUNK_INDEX));
    }

    /// Writes the end.
    pub(super) fn finish(&mut self) {
        self.flush();
        self.out.extend(Body::default().u32(0).record(op::DATA_END));
        let (start, at) = (self.taken + self.out.len() as u64, self.out.len());
        let (first, last) = self.times.unwrap_or_default();
        let statistics = Body::default()
            .u64(self.messages.values().sum())
            .u16(u16::try_from(self.schemas.len()).unwrap_or(u16::MAX))
            .u32(len_u32(self.channels.len()))
            .u32(0)
            .u32(len_u32(self.metadata_indexes.len()))
            .u32(len_u32(self.chunk_indexes.len()))
            .u64(first)
            .u64(last)
            .numbers(self.messages.iter().map(|(channel, count)| (*channel, *count)))
            .record(op::STATISTICS);
        let groups = [&self.schemas, &self.channels, &vec![statistics], &self.chunk_indexes, &self.metadata_indexes];
        for record in groups.into_iter().flatten() {
            self.out.extend(record);
        }
        // The footer's own check covers the summary and the footer up to itself.
        let mut footer = Body::default().u64(start).u64(0).u32(0).record(op::FOOTER);
        footer.truncate(footer.len() - 4);
        self.out.extend(footer);
        let check = CRC.checksum(&self.out[at..]);
        self.out.extend(check.to_le_bytes());
        self.out.extend(MAGIC);
    }

    /// The bytes since the last time, which belong behind those.
    pub(super) fn take(&mut self) -> Vec<u8> {
        self.taken += self.out.len() as u64;
        std::mem::take(&mut self.out)
    }
}

/// Reads what stands in a row; `None` where it ends too soon.
pub(super) struct Cursor<'a>(pub(super) &'a [u8]);

impl<'a> Cursor<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn part(&mut self, len: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(len)?;
        self.0 = rest;
        Some(taken)
    }

    /// With its length before it.
    pub(super) fn bytes(&mut self) -> Option<&'a [u8]> {
        let len = self.u32()?;
        self.part(len as usize)
    }

    pub(super) fn text(&mut self) -> Option<&'a str> {
        str::from_utf8(self.bytes()?).ok()
    }

    /// Operation code and content of the next record.
    pub(super) fn record(&mut self) -> Option<(u8, &'a [u8])> {
        let [op] = self.take()?;
        let len = self.u64()?;
        Some((op, self.part(usize::try_from(len).ok()?)?))
    }
}

/// The records of a chunk, and how they are packed; `None`: it is damaged.
pub(super) fn chunk(body: &[u8]) -> Option<(&str, &[u8])> {
    let mut cursor = Cursor(body);
    let (_, _, size, check) = (cursor.u64()?, cursor.u64()?, cursor.u64()?, cursor.u32()?);
    let packed = cursor.text()?;
    let len = cursor.u64()?;
    let records = cursor.part(usize::try_from(len).ok()?)?;
    // 0: whoever wrote it has not computed it.
    let is_whole = !packed.is_empty() || (size == len && (check == 0 || check == CRC.checksum(records)));
    is_whole.then_some((packed, records))
}
