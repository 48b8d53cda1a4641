//! One MAVLink frame: validated bytes that are forwarded untouched, with views of its header.
//!
//! Layout: mavlink.io, "Packet Serialization" (MAVLink 1 and MAVLink 2 packet formats, checksum, signature).

use bytes::Bytes;
use mavlink::MavlinkVersion;

use crate::ids::{Address, ComponentId, SystemId};
use crate::info::info;

/// First byte of a MAVLink 1 frame.
pub(crate) const STX_V1: u8 = 0xfe;
/// First byte of a MAVLink 2 frame.
pub(crate) const STX_V2: u8 = 0xfd;
/// Bytes before the payload, start mark included.
pub(crate) const HEADER_LEN_V1: usize = 6;
pub(crate) const HEADER_LEN_V2: usize = 10;
pub(crate) const CHECKSUM_LEN: usize = 2;
pub(crate) const SIGNATURE_LEN: usize = 13;
/// `MAVLINK_IFLAG_SIGNED`: the frame carries a signature.
pub(crate) const IFLAG_SIGNED: u8 = 0x01;

/// The version of the protocol that a frame is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum MavVersion {
    /// MAVLink 1: message ids up to 255, no extension fields, no signatures.
    V1,
    /// MAVLink 2.
    #[default]
    V2,
}

impl From<MavVersion> for MavlinkVersion {
    fn from(version: MavVersion) -> Self {
        match version {
            MavVersion::V1 => Self::V1,
            MavVersion::V2 => Self::V2,
        }
    }
}

/// What a sender puts around a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Counts the frames of one sender on one link, modulo 256.
    pub sequence: u8,
    /// The sender.
    pub source: Address,
    /// The version to write the frame in.
    pub version: MavVersion,
}

/// To whom a message is addressed. A field is `None` when the message has no such field, and 0 means everyone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Target {
    /// `target_system`.
    pub system: Option<SystemId>,
    /// `target_component`.
    pub component: Option<ComponentId>,
}

impl Target {
    /// The addressed system, if the message names one.
    pub fn named_system(self) -> Option<SystemId> {
        self.system.filter(|system| *system != SystemId::BROADCAST)
    }

    /// The addressed component, if the message names one.
    pub fn named_component(self) -> Option<ComponentId> {
        self.component.filter(|component| *component != ComponentId::BROADCAST)
    }

    /// Whether a message with this target is meant for `address`: targets that are absent or 0 are meant for everyone.
    pub fn includes(self, address: Address) -> bool {
        self.named_system().is_none_or(|system| system == address.system)
            && self.named_component().is_none_or(|component| component == address.component)
    }
}

/// Why a frame could not be read as a message. The frame itself can still be forwarded and recorded.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The dialect has no such message.
    #[error("message id {id} is not in the dialect; forward it raw or update the dialect")]
    UnknownMessage {
        /// The message id.
        id: u32,
    },
    /// A field holds a value that the dialect does not allow, such as a new enum value.
    #[error("message {name} ({id}) cannot be read: {reason}")]
    BadPayload {
        /// The message id.
        id: u32,
        /// The message's name in the dialect.
        name: &'static str,
        /// What the decoder said.
        reason: String,
    },
}

/// One whole MAVLink frame whose checksum was right (or could not be checked, because the dialect does not know the
/// id).
///
/// Cloning is cheap: clones share the bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame(Bytes);

impl Frame {
    /// Wraps bytes that the decoder or the encoder has checked.
    pub(crate) fn from_checked(bytes: Bytes) -> Self {
        debug_assert!(bytes.len() >= HEADER_LEN_V1 + CHECKSUM_LEN);
        Self(bytes)
    }

    /// The version of the protocol that this frame is written in.
    #[inline]
    pub fn version(&self) -> MavVersion {
        if self.0[0] == STX_V1 { MavVersion::V1 } else { MavVersion::V2 }
    }

    /// The sender's frame counter.
    #[inline]
    pub fn sequence(&self) -> u8 {
        self.at(2, 4)
    }

    /// The sender.
    #[inline]
    pub fn source(&self) -> Address {
        Address::new(self.at(3, 5), self.at(4, 6))
    }

    /// The message id.
    #[inline]
    pub fn message_id(&self) -> u32 {
        match self.version() {
            MavVersion::V1 => u32::from(self.0[5]),
            MavVersion::V2 => u32::from_le_bytes([self.0[7], self.0[8], self.0[9], 0]),
        }
    }

    /// The payload as it came: MAVLink 2 cuts zeros off its end.
    #[inline]
    pub fn payload(&self) -> &[u8] {
        let start = match self.version() {
            MavVersion::V1 => HEADER_LEN_V1,
            MavVersion::V2 => HEADER_LEN_V2,
        };
        &self.0[start..start + usize::from(self.0[1])]
    }

    /// The whole frame, as it goes over a link.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Whether the frame carries a MAVLink 2 signature.
    #[inline]
    pub fn is_signed(&self) -> bool {
        self.version() == MavVersion::V2 && self.0[2] & IFLAG_SIGNED != 0
    }

    /// Whether the dialect has this message id. The checksum of an unknown one cannot be checked.
    #[inline]
    pub fn is_known(&self) -> bool {
        info(self.message_id()).is_some()
    }

    /// The message's target; broadcast when the dialect does not know the message.
    #[inline]
    pub fn target(&self) -> Target {
        let Some(info) = info(self.message_id()) else { return Target::default() };
        // Zeros cut off the end of the payload are still zeros.
        let field = |offset: usize| self.payload().get(offset).copied().unwrap_or(0);
        Target {
            system: info.target_system_offset().map(|at| SystemId(field(at))),
            component: info.target_component_offset().map(|at| ComponentId(field(at))),
        }
    }

    #[inline]
    fn at(&self, v1: usize, v2: usize) -> u8 {
        match self.version() {
            MavVersion::V1 => self.0[v1],
            MavVersion::V2 => self.0[v2],
        }
    }
}
