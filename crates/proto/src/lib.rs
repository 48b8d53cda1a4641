//! MAVLink as Vencejo speaks it: ids, monotonic time, frames, messages and payload codecs. No I/O, no clock.
//!
//! A byte stream becomes [`Frame`]s through a [`FrameDecoder`]; a frame becomes a [`Message`] with
//! [`Frame::decode`], and a message becomes a frame again with [`Message::encode`].
//!
//! ```
//! use vencejo_proto::{Address, FrameDecoder, Header, Heartbeat, MavVersion, Message};
//!
//! let header = Header { sequence: 7, source: Address::new(255, 190), version: MavVersion::V2 };
//! let frame = Message::Heartbeat(Heartbeat::default()).encode(header);
//!
//! let mut decoder = FrameDecoder::new();
//! decoder.push(b"noise");
//! decoder.push(frame.bytes());
//! let received = decoder.next_frame().expect("one frame");
//! assert_eq!(received.source(), Address::new(255, 190));
//! assert!(matches!(received.decode(), Ok(Message::Heartbeat(_))));
//! assert_eq!(decoder.stats().garbage_bytes, 5);
//! ```
//!
//! What this crate never does: trust a length, an enum value or a text that came over a link. Frames with an
//! unknown message id are kept as they are, so that they can be forwarded and recorded.

mod checksum;
mod decoder;
pub mod dialect;
mod english;
mod fields;
mod frame;
pub mod ftp;
mod ids;
mod info;
mod layouts;
mod message;
pub mod param;
pub mod plan_file;
mod signing;
mod text;
mod time;
pub mod wire;

pub use decoder::{DecoderStats, FrameDecoder};
pub use english::{Counted, Seconds};
pub use fields::{FieldError, FieldValue, decode_fields, encode_fields};
pub use frame::{DecodeError, Frame, Header, MavVersion, Target};
pub use ids::{Address, ComponentId, MissionSeq, SystemId};
pub use info::{message_id_of, message_name};
pub use message::Message;
pub use signing::{KeyUse, Signature, SignatureFault, SigningKey, SigningTime, TimeExhausted};
pub use text::{is_plain, plain};
pub use time::MonoTime;
pub use wire::{
    CommandAck, CommandInt, CommandLong, Heartbeat, MissionAck, MissionItemFloat, MissionItemInt, StatusText,
};
