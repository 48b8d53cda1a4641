//! Records as a file in the MCAP format, which Foxglove and others open without us: the descriptors of the payloads are
//! in it.
//!
//! Bytes come out in whole chunks, to be appended. A file without its end is read as far as it goes.

use std::collections::BTreeMap;

use prost::Message;

use super::location::LocationFix;
use super::mcap::Writer;
use super::record::{MavlinkFrame, Record, Stream};
use crate::payload::State;

/// Descriptors of our payloads, made by `scripts/fleet_schema.py`.
const OURS: &[u8] = include_bytes!("vencejo.binpb");
/// The same of Foxglove's position.
const FIX: &[u8] = include_bytes!("location_fix.binpb");
/// The name of what a file says of itself.
pub(super) const ABOUT: &str = "vencejo";
/// A chunk is closed when it has grown to this, and whenever what there is goes to the disk.
const CHUNK_BYTES: usize = 64 * 1024;
/// The shortest time between two positions for the map.
const FIX_EVERY_MS: u64 = 1000;

/// Whose history it is, and where it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// The organisation.
    pub org: String,
    /// The aircraft.
    pub aircraft: String,
    /// `board` or `ground`.
    pub side: &'static str,
}

/// What a channel has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Topic {
    Of(Stream),
    Location,
    Mavlink,
}

impl Topic {
    /// Topic, schema and its descriptors.
    fn facts(self) -> (&'static str, &'static str, &'static [u8]) {
        match self {
            Self::Of(Stream::State) => ("/state", "vencejo.v1.State", OURS),
            Self::Of(Stream::Event) => ("/event", "vencejo.v1.Event", OURS),
            Self::Of(Stream::Audit) => ("/audit", "vencejo.v1.Audit", OURS),
            Self::Location => ("/location", "foxglove.LocationFix", FIX),
            Self::Mavlink => ("/mavlink", "vencejo.v1.MavlinkFrame", OURS),
        }
    }
}

/// The stream of a topic.
pub(super) fn stream_of(topic: &str) -> Option<Stream> {
    Stream::ALL.into_iter().find(|stream| Topic::Of(*stream).facts().0 == topic)
}

/// Writes one file.
pub struct Pen {
    writer: Writer,
    channels: BTreeMap<Topic, u16>,
    aircraft: String,
    /// Boot and clock of the last position.
    fixed_at: Option<(u64, u64)>,
}

impl Pen {
    /// Begins a file.
    pub fn new(about: &About) -> Self {
        let facts = [("org", about.org.as_str()), ("aircraft", &about.aircraft), ("side", about.side)];
        let writer = Writer::new(concat!("vencejo ", env!("CARGO_PKG_VERSION")), ABOUT, &facts);
        Self { writer, channels: BTreeMap::new(), aircraft: about.aircraft.clone(), fixed_at: None }
    }

    fn put_on(&mut self, topic: Topic, number: u64, clock_ms: u64, unix_ns: u64, data: &[u8]) {
        if self.writer.chunk_bytes() >= CHUNK_BYTES {
            self.writer.flush();
        }
        let channel = *self.channels.entry(topic).or_insert_with(|| {
            let (topic, schema, descriptors) = topic.facts();
            self.writer.add_channel(topic, schema, descriptors)
        });
        self.writer.put(channel, number as u32, unix_ns, clock_ms.saturating_mul(1_000_000), data);
    }

    /// Writes a record; of a state its position besides, once a second at most.
    pub fn put(&mut self, record: &Record) {
        let Record { stream, boot, number, clock_ms, unix_ns, ref data } = *record;
        self.put_on(Topic::Of(stream), number, clock_ms, unix_ns, data);
        let is_due = self.fixed_at.is_none_or(|(of, at)| of != boot || clock_ms.abs_diff(at) >= FIX_EVERY_MS);
        if stream == Stream::State
            && is_due
            && let Ok(state) = State::read(data)
            && let Some(fix) = LocationFix::of(&state, unix_ns, &self.aircraft)
        {
            self.fixed_at = Some((boot, clock_ms));
            self.put_on(Topic::Location, number, clock_ms, unix_ns, &fix.encode_to_vec());
        }
    }

    /// Writes a frame of a link.
    pub fn put_frame(&mut self, boot: u64, clock_ms: u64, unix_ns: u64, frame: &[u8]) {
        let data = MavlinkFrame { boot, clock_ms, frame: frame.to_vec() }.encode_to_vec();
        self.put_on(Topic::Mavlink, 0, clock_ms, unix_ns, &data);
    }

    /// Closes the chunk.
    pub fn flush(&mut self) {
        self.writer.flush();
    }

    /// Writes the end.
    pub fn finish(&mut self) {
        self.writer.finish();
    }

    /// The bytes since the last time, which belong behind those.
    pub fn take(&mut self) -> Vec<u8> {
        self.writer.take()
    }
}
