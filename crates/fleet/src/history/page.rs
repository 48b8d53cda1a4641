//! A history file, read in any condition: as far as it was written, without what is damaged.

use std::collections::HashMap;

use thiserror::Error;

use super::mcap::{Cursor, MAGIC, RECORD_START, chunk, op};
use super::pen::{ABOUT, stream_of};
use super::record::{Audit, Record, Stream};
use crate::payload::{Event, State};

/// Longest record: more than any chunk of ours has.
const MAX_RECORD: u64 = 64 << 20;

/// A file that is no history.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BadPage {
    /// It begins differently.
    #[error("it is no MCAP file: one begins with its name")]
    Magic,
    /// Chunks are packed in a way that this build does not read.
    #[error("its chunks are packed ({0}): unpack it first, as with `mcap convert --compression none`")]
    Packed(String),
}

/// Records that stand together in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Where in the file.
    pub offset: u64,
    /// How long.
    pub len: u64,
    /// What is in it.
    pub records: Vec<Record>,
}

/// Reads a file from its beginning, in as many pieces as it comes in, also while it grows.
#[derive(Debug, Clone, Default)]
pub struct PageReader {
    at: u64,
    streams: HashMap<u16, Stream>,
    aircraft: Option<String>,
    is_over: bool,
    /// Bytes of damaged chunks.
    damaged: u64,
}

impl PageReader {
    /// How far it has read.
    pub fn at(&self) -> u64 {
        self.at
    }

    /// Bytes that were passed over because they are damaged.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// The aircraft that the file says it is of.
    pub fn aircraft(&self) -> Option<&str> {
        self.aircraft.as_deref()
    }

    /// Takes in the file's bytes from [`at`](Self::at) on, and gives what they hold. What is not there as a whole is
    /// left for the next time.
    ///
    /// # Errors
    /// [`BadPage`].
    pub fn read(&mut self, bytes: &[u8]) -> Result<Vec<Block>, BadPage> {
        let (mut blocks, mut rest) = (Vec::new(), bytes);
        if self.at == 0 {
            let Some((magic, behind)) = rest.split_at_checked(MAGIC.len()) else { return Ok(blocks) };
            if magic != MAGIC {
                return Err(BadPage::Magic);
            }
            (self.at, rest) = (MAGIC.len() as u64, behind);
        }
        while !self.is_over
            && let Some((start, behind)) = rest.split_at_checked(RECORD_START)
        {
            let len = u64::from_le_bytes(start[1..].try_into().expect("invariant: eight bytes"));
            if start[0] == 0 || len > MAX_RECORD {
                // A torn end: nothing behind it can be found.
                self.is_over = true;
                break;
            }
            let Some((body, behind)) = behind.split_at_checked(len as usize) else { break };
            let (offset, len) = (self.at, RECORD_START as u64 + len);
            match self.records(start[0], body)? {
                Some(records) if !records.is_empty() => blocks.push(Block { offset, len, records }),
                Some(_) => {}
                None => self.damaged += len,
            }
            (self.at, rest) = (self.at + len, behind);
        }
        if self.is_over && rest == MAGIC {
            self.at += MAGIC.len() as u64;
        }
        Ok(blocks)
    }

    /// The records of a block that was read before.
    ///
    /// # Errors
    /// [`BadPage`].
    pub fn block(&mut self, bytes: &[u8]) -> Result<Vec<Record>, BadPage> {
        let Some((start, body)) = bytes.split_at_checked(RECORD_START) else { return Ok(Vec::new()) };
        Ok(self.records(start[0], body)?.unwrap_or_default())
    }

    /// What a record of the file holds; `None`: it is damaged.
    fn records(&mut self, op: u8, body: &[u8]) -> Result<Option<Vec<Record>>, BadPage> {
        let mut found = Vec::new();
        if op == op::CHUNK {
            let Some((packed, records)) = chunk(body) else { return Ok(None) };
            if !packed.is_empty() {
                return Err(BadPage::Packed(vencejo_proto::plain(packed, 20)));
            }
            let mut records = Cursor(records);
            while let Some((op, body)) = records.record() {
                self.on_record(op, body, &mut found);
            }
        } else {
            self.on_record(op, body, &mut found);
        }
        Ok(Some(found))
    }

    /// Takes in a record, where it is of use and can be read.
    fn on_record(&mut self, op: u8, body: &[u8], found: &mut Vec<Record>) -> Option<()> {
        let mut cursor = Cursor(body);
        match op {
            op::CHANNEL => {
                let (channel, _) = (cursor.u16()?, cursor.u16()?);
                let stream = stream_of(cursor.text()?)?;
                self.streams.insert(channel, stream);
            }
            op::MESSAGE => {
                let (channel, _, unix_ns, publish_ns) = (cursor.u16()?, cursor.u32()?, cursor.u64()?, cursor.u64()?);
                let stream = *self.streams.get(&channel)?;
                found.push(record_of(stream, unix_ns, publish_ns / 1_000_000, cursor.0)?);
            }
            op::METADATA if cursor.text()? == ABOUT => {
                let mut facts = Cursor(cursor.bytes()?);
                while let (Some(name), Some(value)) = (facts.text(), facts.text()) {
                    if name == "aircraft" {
                        self.aircraft = Some(vencejo_proto::plain(value, 64));
                    }
                }
            }
            op::FOOTER => self.is_over = true,
            _ => {}
        }
        Some(())
    }
}

fn record_of(stream: Stream, unix_ns: u64, clock_ms: u64, data: &[u8]) -> Option<Record> {
    let (boot, number) = match stream {
        Stream::State => State::read(data).ok().map(|state| (state.boot, state.sequence)),
        Stream::Event => Event::read(data).ok().map(|event| (event.boot, event.number)),
        Stream::Audit => <Audit as prost::Message>::decode(data).ok().map(|audit| (audit.boot, audit.number)),
    }?;
    Some(Record { stream, boot, number, clock_ms, unix_ns, data: data.to_vec() })
}

#[cfg(test)]
mod tests {
    use prost::Message as _;
    use vencejo_proto::{Address, Header, Heartbeat, MavVersion, Message, MonoTime};

    use super::super::pen::{About, Pen};
    use super::*;
    use crate::payload::Held;
    use crate::state_source::StateSource;

    fn states(count: u64) -> Vec<Record> {
        let plane = Address::new(7, 1);
        let mut source = StateSource::new(5, plane, crate::stamp::Stamper::new(&[7; 32]));
        let state = |number: u64| {
            let now = MonoTime::from_millis(number * 100);
            let heartbeat = Message::Heartbeat(Heartbeat { custom_mode: number as u32, ..Heartbeat::default() });
            source.on_frame(&heartbeat.encode(Header { sequence: 0, source: plane, version: MavVersion::V2 }), now);
            let data = source.sample(Held::default(), now).encode_to_vec();
            // A clock that was set back in the middle, as of a computer that has none of its own.
            let unix_ns = if number < 50 { 1_800_000_000_000_000_000 } else { 7 } + number;
            Record { stream: Stream::State, boot: 5, number, clock_ms: number * 100, unix_ns, data }
        };
        (1..=count).map(state).collect()
    }

    fn file(records: &[Record], is_finished: bool) -> Vec<u8> {
        let about = About { org: "acme".into(), aircraft: "plane7".into(), side: "board" };
        let mut pen = Pen::new(&about);
        for (number, record) in records.iter().enumerate() {
            pen.put(record);
            pen.put_frame(5, record.clock_ms, record.unix_ns, b"a frame");
            if number % 10 == 9 {
                pen.flush();
            }
        }
        if is_finished {
            pen.finish();
        }
        pen.take()
    }

    fn read(bytes: &[u8]) -> Vec<Record> {
        let blocks = PageReader::default().read(bytes).expect("a history");
        blocks.into_iter().flat_map(|block| block.records).collect()
    }

    #[test]
    fn what_was_written_is_read_and_a_file_is_readable_wherever_it_was_cut_off() {
        let records = states(100);
        let whole = file(&records, true);
        assert_eq!(read(&whole), records);
        let mut reader = PageReader::default();
        reader.read(&whole).expect("a history");
        assert_eq!((reader.at(), reader.damaged()), (whole.len() as u64, 0), "to its very end");
        let unfinished = file(&records, false);
        assert!(whole.starts_with(&unfinished), "an end is appended, and nothing else");
        let mut most = 0;
        for end in 0..unfinished.len() {
            let found = read(&unfinished[..end]);
            assert_eq!(found[..], records[..found.len()], "cut off at {end}");
            assert!(found.len() >= most && found.len().is_multiple_of(10), "cut off at {end}: {} records", found.len());
            most = found.len();
        }
        // What a disk leaves behind the last byte that it was given.
        assert_eq!(read(&[&unfinished[..], &[0; 4096]].concat()), records);
        assert_eq!(PageReader::default().read(b"something else"), Err(BadPage::Magic));
    }

    #[test]
    fn a_damaged_chunk_costs_itself_and_a_growing_file_is_read_on() {
        let records = states(100);
        let bytes = file(&records, false);
        let mut reader = PageReader::default();
        let blocks = reader.read(&bytes).expect("a history");
        assert_eq!(blocks.len(), 10);
        for block in &blocks {
            let (from, to) = (block.offset as usize, (block.offset + block.len) as usize);
            assert_eq!(reader.clone().block(&bytes[from..to]).as_ref(), Ok(&block.records));
        }
        let mut damaged = bytes.clone();
        damaged[(blocks[4].offset + blocks[4].len - 40) as usize] ^= 0xff;
        let mut without = records.clone();
        without.drain(40..50);
        assert_eq!(read(&damaged), without);
        let (mut reader, mut found, mut end) = (PageReader::default(), Vec::new(), 0);
        while end < bytes.len() {
            end = (end + 777).min(bytes.len());
            let at = reader.at() as usize;
            found.extend(reader.read(&bytes[at..end]).expect("a history").into_iter().flat_map(|block| block.records));
        }
        assert_eq!(found, records);
    }
}
