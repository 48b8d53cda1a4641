//! What all payloads share: their version and limits, why one cannot be used, and one message of an autopilot.

use thiserror::Error;
use vencejo_proto::{Address, Frame, Header, MavVersion, Message};

/// The version of these payloads.
pub const VERSION: u32 = 1;
/// Bytes of a sample, an order or an answer at most; more is not even looked at.
pub const MAX_BYTES: usize = 16 * 1024;
/// Messages in one state at most.
pub const MAX_MESSAGES: usize = 64;
/// Bytes of a text at most.
pub const MAX_TEXT: usize = 500;

/// A payload that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BadPayload {
    /// More bytes than there may be.
    #[error("{0} bytes are too many: at most {MAX_BYTES}")]
    TooLarge(usize),
    /// No Protocol Buffers, or not this message.
    #[error("not to be decoded: {0}")]
    Undecodable(String),
    /// From another version of Vencejo.
    #[error(
        "its version is {0}, this program's is {VERSION}: use the same version of Vencejo on board and on the ground"
    )]
    Version(u32),
    /// A field that cannot be.
    #[error("field {0} is missing or out of range")]
    Field(&'static str),
    /// A list that is not the one that was named.
    #[error("{0}; send it again")]
    Content(&'static str),
}

/// One message of the autopilot.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Said {
    /// Its MAVLink message id.
    #[prost(uint32, tag = "1")]
    pub message_id: u32,
    /// Its MAVLink 2 payload, without the zeros at its end.
    #[prost(bytes = "vec", tag = "2")]
    pub payload: Vec<u8>,
    /// How long before the sample was made it came, ms.
    #[prost(uint32, tag = "3")]
    pub age_ms: u32,
}

impl Said {
    /// A message, now.
    pub fn of_message(message: &Message) -> Self {
        let header = Header { sequence: 0, source: Address::new(0, 0), version: MavVersion::V2 };
        Self::of(&message.encode(header), 0)
    }

    /// A message as it came, `age_ms` ago. A payload that came by MAVLink 1 is told by the 2 as well: it has the same
    /// fields first.
    pub fn of(frame: &Frame, age_ms: u32) -> Self {
        let payload = frame.payload();
        let used = payload.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        Self { message_id: frame.message_id(), payload: payload[..used].to_vec(), age_ms }
    }

    /// The message, if it can be decoded.
    pub fn message(&self) -> Option<Message> {
        Message::from_payload(MavVersion::V2, self.message_id, &self.payload).ok()
    }
}
