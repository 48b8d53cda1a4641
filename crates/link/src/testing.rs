//! What tests share: frames, a hub that tells what it hears, folders.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use tokio::sync::mpsc;
use vencejo_proto::{Address, CommandLong, Frame, FrameDecoder, Header, Heartbeat, MavVersion, Message, dialect};

use crate::{Hub, LinkHandle, LinkId, LinkOptions, LinkState, Origin, Route, SinkScope, SystemClock};

fn header(system: u8, component: u8, sequence: u8) -> Header {
    Header { sequence, source: Address::new(system, component), version: MavVersion::V2 }
}

pub(crate) fn heartbeat(system: u8, component: u8, sequence: u8) -> Frame {
    Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() })
        .encode(header(system, component, sequence))
}

pub(crate) fn radio_status(sequence: u8) -> Frame {
    Message::Dialect(dialect::MavMessage::RADIO_STATUS(dialect::RADIO_STATUS_DATA::default()))
        .encode(header(51, 68, sequence))
}

pub(crate) fn setup_signing(source: (u8, u8), target: (u8, u8), sequence: u8) -> Frame {
    let data =
        dialect::SETUP_SIGNING_DATA { target_system: target.0, target_component: target.1, ..Default::default() };
    Message::Dialect(dialect::MavMessage::SETUP_SIGNING(data)).encode(header(source.0, source.1, sequence))
}

/// A MAVLink 2 frame of a message that no dialect has.
pub(crate) fn unknown(system: u8, component: u8, sequence: u8) -> Frame {
    let mut decoder = FrameDecoder::new();
    decoder.push_datagram(&[0xfd, 3, 0, 0, sequence, system, component, 0x10, 0xf0, 0xf0, 1, 2, 3, sequence, 0xab]);
    decoder.next_frame().expect("an unknown message is a frame")
}

/// The same frame with a signature (of zeros) and the checksum that belongs to it.
pub(crate) fn signed(frame: &Frame) -> Frame {
    let mut bytes = frame.bytes().to_vec();
    bytes[2] |= 1;
    let end = bytes.len() - 2;
    let known = frame.is_known();
    let mut found = None;
    for checksum in 0..=u16::MAX {
        bytes[end..].copy_from_slice(&checksum.to_le_bytes());
        let mut decoder = FrameDecoder::new();
        decoder.push(&bytes);
        decoder.push(&[0; 13]);
        found = decoder.next_frame();
        if found.is_some() || !known {
            break;
        }
    }
    found.expect("one checksum fits")
}

/// A hub of the address 255/190 with everything that it hears.
pub(crate) struct Listening {
    pub(crate) hub: Hub,
    heard: mpsc::UnboundedReceiver<(LinkId, Frame)>,
}

impl Listening {
    pub(crate) fn new() -> Self {
        let hub = Hub::new(vec![US], Arc::new(SystemClock::new()));
        let (sender, heard) = mpsc::unbounded_channel();
        hub.add_sink(
            SinkScope::All,
            Arc::new(move |origin: Origin, frame: &Frame, _| {
                // A test that has seen enough does not listen any more.
                let _ = sender.send((origin.link, frame.clone()));
            }),
        );
        Self { hub, heard }
    }

    /// Opens a link and waits until it is up.
    pub(crate) async fn open(&self, text: &str) -> LinkHandle {
        let mut link = self.hub.open(text.parse().unwrap(), LinkOptions::default()).unwrap();
        in_time(link.wait_for(LinkState::is_up)).await;
        link
    }

    /// The next frame that is heard.
    pub(crate) async fn next(&mut self) -> Frame {
        in_time(self.heard.recv()).await.expect("the hub lives").1
    }
}

pub(crate) const US: Address = Address::new(255, 190);

/// Waits, but not for ever: a test that hangs should say where.
pub(crate) async fn in_time<T>(future: impl Future<Output = T>) -> T {
    tokio::time::timeout(Duration::from_secs(20), future).await.expect("it happens within 20 s")
}

/// Sends our heartbeat on all links; tells how many took it.
pub(crate) fn say_something(hub: &Hub) -> u32 {
    hub.send_message(&Message::Heartbeat(Heartbeat::default()), US, MavVersion::V2, Route::All).accepted
}

/// A command to a system, to be told from others by `command`.
pub(crate) fn command_to(system: u8, command: u16) -> Message {
    let target = Address::new(system, 1);
    Message::CommandLong(CommandLong { target, command, confirmation: 0, params: [0.0; 7] })
}

/// Time as a busy machine lets it pass: short sleeps, each counted as it was asked for. Who takes long by it has waited
/// for something, and was not kept from running.
pub(crate) struct Metronome {
    ticks: Arc<AtomicU32>,
}

impl Metronome {
    const TICK: Duration = Duration::from_millis(5);

    pub(crate) fn start() -> Self {
        let ticks = Arc::new(AtomicU32::new(0));
        let counted = Arc::downgrade(&ticks);
        std::thread::spawn(move || {
            while let Some(ticks) = counted.upgrade() {
                ticks.fetch_add(1, Ordering::Relaxed);
                drop(ticks);
                std::thread::sleep(Self::TICK);
            }
        });
        Self { ticks }
    }

    /// Time since it began.
    pub(crate) fn now(&self) -> Duration {
        Self::TICK * self.ticks.load(Ordering::Relaxed)
    }
}

/// A folder of its own, gone afterwards.
pub(crate) struct TempDir(pub(crate) PathBuf);

impl TempDir {
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("vencejo-link-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for TempDir {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
