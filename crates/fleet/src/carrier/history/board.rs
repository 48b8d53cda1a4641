//! The history on board: states, events and orders are stored, and ground stations fetch what they missed.

use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use prost::Message;
use tokio::task::JoinHandle;
use vencejo_link::{Clock, Recorder, RecorderHandle, SystemClock};
use vencejo_proto::MonoTime;
use zenoh::Session;
use zenoh::query::Query;

use super::shelf::Shelf;
use super::{HistoryConfig, Item, Journal, prefix};
use crate::carrier::network;
use crate::error::FleetError;
use crate::history::Stream;
use crate::history::pen::About;
use crate::history::record::{Audit, IndexWanted, MAX_PIECE_BYTES, Wanted};
use crate::key::{Kind, Name, key_of};
use crate::payload::{Answer, Event, Order, State, VERSION};
use crate::state_source::millis;

/// Most time that a piece may occupy a known uplink, s.
const PIECE_S: f64 = 0.1;

/// An entry of the history.
pub(in crate::carrier) enum Entry<'a> {
    State(&'a State),
    Event(&'a Event),
    /// An order's sender, the order if authenticated, and its answer.
    Order(&'a [u8], Option<&'a Order>, &'a Answer),
    /// A frame of the autopilot.
    Frame(&'a [u8]),
}

/// The history on board.
pub(in crate::carrier) struct Board {
    recorder: Recorder<Journal>,
    handle: RecorderHandle<Journal>,
    clock: Arc<SystemClock>,
    boot: u64,
    audits: AtomicU64,
    shelf: Arc<Mutex<Shelf>>,
    piece_bytes: u32,
    keys: [String; 2],
    /// Whether frames are kept as well.
    pub(in crate::carrier) has_frames: bool,
}

impl Board {
    /// Starts the thread that writes it.
    pub(in crate::carrier) fn start(
        org: &Name,
        name: &Name,
        boot: u64,
        uplink_bit_s: Option<f64>,
        config: &HistoryConfig,
    ) -> io::Result<Self> {
        let clock = Arc::new(SystemClock::new());
        let about = About { org: org.to_string(), aircraft: name.to_string(), side: "board" };
        let recorder = Journal::recorder(about, config, clock.clone())?;
        let shelf = Shelf::new(config.folder.clone(), prefix(name.as_str()));
        let piece_bytes = uplink_bit_s.map_or(MAX_PIECE_BYTES, |bit_s| (bit_s / 8.0 * PIECE_S) as u32);
        Ok(Self {
            handle: recorder.handle(),
            recorder,
            clock,
            boot,
            audits: AtomicU64::new(0),
            shelf: Arc::new(Mutex::new(shelf)),
            piece_bytes,
            keys: [Kind::HistoryIndex, Kind::HistoryChunk].map(|kind| key_of(org, name, kind)),
            has_frames: config.with_frames,
        })
    }

    /// Stores an entry; `now` is the station's time. Never waits.
    pub(in crate::carrier) fn keep(&self, told: &Entry<'_>, now: MonoTime) {
        let (stream, number, clock_ms, data) = match told {
            Entry::State(state) => (Some(Stream::State), state.sequence, state.clock_ms, state.encode_to_vec()),
            Entry::Event(event) => (Some(Stream::Event), event.number, event.clock_ms, event.encode_to_vec()),
            Entry::Order(key, order, answer) => {
                let number = self.audits.fetch_add(1, Ordering::Relaxed) + 1;
                let (order, answer) = (order.cloned(), Some((*answer).clone()));
                let clock_ms = millis(now.as_duration());
                let audit =
                    Audit { version: VERSION, boot: self.boot, number, clock_ms, key: key.to_vec(), order, answer };
                (Some(Stream::Audit), number, clock_ms, audit.encode_to_vec())
            }
            Entry::Frame(frame) => (None, 0, millis(now.as_duration()), frame.to_vec()),
        };
        self.handle.put(Item { at: self.clock.now(), unix_ns: None, stream, boot: self.boot, number, clock_ms, data });
    }

    /// Why nothing is written; `None` while it works.
    pub(in crate::carrier) fn problem(&self) -> Option<String> {
        self.recorder.status().state.problem().map(|problem| format!("its history is not written: {problem}"))
    }

    /// Answers requests of ground stations until the returned guard is dropped.
    pub(in crate::carrier) async fn answer(&self, session: &Session) -> Result<Answering, FleetError> {
        let [index_key, chunk_key] = self.keys.clone();
        let declared = network::failed;
        let indices = session.declare_queryable(index_key.clone()).complete(true).await.map_err(declared)?;
        let chunks = session.declare_queryable(chunk_key.clone()).complete(true).await.map_err(declared)?;
        let (shelf, boot, most) = (self.shelf.clone(), self.boot, self.piece_bytes);
        // One after the other: none is urgent.
        Ok(Answering(tokio::spawn(async move {
            loop {
                tokio::select! {
                    Ok(query) = indices.recv_async() => {
                        let asked = IndexWanted::decode(network::bytes_of(query.payload()).as_slice());
                        let nonce = asked.map_or(0, |asked| asked.nonce);
                        let index = move |shelf: &mut Shelf| Ok(shelf.index(nonce, boot)?.encode_to_vec());
                        reply(query, &index_key, &shelf, index).await;
                    }
                    Ok(query) = chunks.recv_async() => {
                        let Ok(wanted) = Wanted::read(&network::bytes_of(query.payload())) else { continue };
                        let piece = move |shelf: &mut Shelf| Ok(shelf.piece(&wanted, most)?.encode_to_vec());
                        reply(query, &chunk_key, &shelf, piece).await;
                    }
                    else => return,
                }
            }
        })))
    }

    /// Writes what is queued and ends the file.
    pub(in crate::carrier) async fn close(self) {
        // A join error is a panic, which has been reported.
        let _ = tokio::task::spawn_blocking(move || self.recorder.close()).await;
    }
}

/// Ground stations are answered while this lives.
pub(in crate::carrier) struct Answering(JoinHandle<()>);

impl Drop for Answering {
    fn drop(&mut self) {
        self.0.abort();
    }
}

async fn reply(
    query: Query,
    key: &str,
    shelf: &Arc<Mutex<Shelf>>,
    read: impl FnOnce(&mut Shelf) -> io::Result<Vec<u8>> + Send + 'static,
) {
    let shelf = shelf.clone();
    let read = move || read(&mut shelf.lock().unwrap_or_else(PoisonError::into_inner));
    let bytes = match tokio::task::spawn_blocking(read).await {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(error)) => return tracing::warn!(%error, "the history cannot be read"),
        Err(_) => return,
    };
    // With the query's own priority: the lowest.
    if let Err(error) = query.reply(key, bytes).await {
        // The ground station asks again.
        tracing::debug!(%error, key, "not answered");
    }
}
