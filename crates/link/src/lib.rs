//! Links of Vencejo: endpoints that connect again by themselves, the hub that routes between them, and the recorder.
//!
//! # How a frame is processed
//!
//! Each link has one task. It drains its socket, decodes frames and hands each to the [`Hub`], which in that same task,
//! without blocking,
//!
//! 1. verifies its signature, where one is required, counts it ([`LinkStats`]) and learns the route to its sender,
//! 2. puts it into the [`Recorder`]'s queue,
//! 3. calls the listeners ([`FrameSink`]), and
//! 4. forwards the raw frame to the links that the MAVLink routing rules name: straight into the socket for UDP, into a
//!    bounded queue in front of a writer for TCP and serial. Frames that were read together are forwarded together.
//!
//! ```
//! use std::sync::Arc;
//!
//! use vencejo_link::{Hub, LinkAddress, LinkOptions, Route, SinkScope, SystemClock};
//! use vencejo_proto::{Address, Heartbeat, MavVersion, Message};
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let us = Address::new(255, 190);
//! let hub = Hub::new(vec![us], Arc::new(SystemClock::new()));
//! hub.add_sink(SinkScope::All, Arc::new(|origin, frame, _now| {
//!     println!("{}: message {} from {}", origin.link, frame.message_id(), frame.source());
//! }));
//!
//! let address: LinkAddress = "udpin:127.0.0.1:0".parse()?;
//! let mut link = hub.open(address, LinkOptions::default())?;
//! link.wait_for(|state| state.is_up()).await;
//!
//! let heartbeat = Message::Heartbeat(Heartbeat::default());
//! let report = hub.send_message(&heartbeat, us, MavVersion::V2, Route::All);
//! assert!(!report.is_sent(), "nobody has spoken to us yet");
//!
//! link.close().await;
//! # Ok(())
//! # }
//! ```
//!
//! # Links
//!
//! [`LinkAddress`] reads every link string of the MAVLink family. [`Hub::open`] returns at once; the [`LinkHandle`]
//! reports the [`LinkState`] and closes the link. A broken link is reopened for ever, after 0.25 s at first and at most
//! 1.5 s. Garbage is counted and skipped.
//!
//! A tee for other ground stations is a link opened with [`LinkOptions::tee`].
//!
//! # Time
//!
//! Everything measured or awaited follows the injected [`Clock`] and tokio's timer; wall time is used for the names and
//! time stamps of recordings only.
//!
//! # What this crate never does
//!
//! It decodes no payload and knows no vehicle: it looks at headers, signatures and target fields. It does not modify
//! the frames that it forwards. It never waits for a slow link, listeners must not block, and a slow disk costs
//! recorded frames only.

mod address;
mod address_index;
mod clock;
mod endpoint;
mod fault;
mod hub;
mod onward;
mod outlet;
mod pace;
mod played;
mod port;
mod recorder;
mod router;
mod serial_port;
mod signing;
mod stats;
mod systems;
#[cfg(test)]
mod testing;
mod tlog;

pub use address::{
    AddressError, DEFAULT_BAUD, DEFAULT_TCP_PORT, DEFAULT_UDP_PORT, DEFAULT_USB_BAUD, HostPort, LinkAddress,
};
pub use clock::{Clock, SystemClock};
pub use endpoint::LinkHandle;
pub use fault::{FaultKind, LinkFault};
pub use hub::{FrameSink, Hub, LinkError, LinkInfo, OpenSink, Origin, ReadSink, Route, SendReport, SinkScope};
pub use outlet::PeerId;
pub use pace::Pace;
pub use played::{PlayedFrame, TlogFile};
pub use port::{LinkId, LinkOptions, LinkState};
pub use recorder::{
    Folder, Format, Frames, Line, Names, Noted, Recorder, RecorderConfig, RecorderHandle, RecorderState,
    RecorderStatus, Recorders, Storage, StorageFile, StoredFile, Syncing, is_kept_recording, keep_recording,
};
pub use router::MAX_LINKS;
pub use serial_port::{COMPANION_BAUD, SerialPort, serial_ports};
pub use signing::{KeyId, SigningCounts, SigningState, UnsignedPolicy, VehicleKeys};
pub use stats::{LinkStats, MAX_SOURCES_PER_LINK, Rates, RoundTrip, SourceStats, Traffic};
pub use tlog::{SkippedBytes, TlogDecoder, TlogEntry, TlogReader, write_entry};
