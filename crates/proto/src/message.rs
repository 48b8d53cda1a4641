//! A message read from a frame, or about to become one.

use std::collections::BTreeMap;

use bytes::Bytes;
use mavlink::Message as _;

use crate::checksum::checksum;
use crate::dialect::MavMessage;
use crate::fields::{FieldError, FieldValue, decode_fields, encode_fields, has_field};
use crate::frame::{
    CHECKSUM_LEN, DecodeError, Frame, HEADER_LEN_V1, HEADER_LEN_V2, Header, MavVersion, STX_V1, STX_V2, Target,
};
use crate::ids::{Address, ComponentId, SystemId};
use crate::info::{info, message_id_of, message_name};
use crate::wire::{
    CommandAck, CommandInt, CommandLong, Heartbeat, MissionAck, MissionItemFloat, MissionItemInt, StatusText, Wire,
    Writer,
};

/// A MAVLink message.
///
/// The messages whose enums a newer autopilot may extend keep raw numbers ([`crate::wire`]); all others are the
/// dialect's.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "moved once from the decoder to its reader; a box would allocate for every frame"
)]
pub enum Message {
    /// HEARTBEAT (0).
    Heartbeat(Heartbeat),
    /// COMMAND_LONG (76).
    CommandLong(CommandLong),
    /// COMMAND_INT (75).
    CommandInt(CommandInt),
    /// COMMAND_ACK (77).
    CommandAck(CommandAck),
    /// MISSION_ITEM (39).
    MissionItemFloat(MissionItemFloat),
    /// MISSION_ITEM_INT (73).
    MissionItemInt(MissionItemInt),
    /// MISSION_ACK (47).
    MissionAck(MissionAck),
    /// STATUSTEXT (253).
    StatusText(StatusText),
    /// Any other message of the dialect. Never one of the messages above.
    Dialect(MavMessage),
}

impl Frame {
    /// Reads the message.
    ///
    /// # Errors
    /// [`DecodeError`] when the dialect does not have the id, or a field holds a value that it does not allow.
    #[inline]
    pub fn decode(&self) -> Result<Message, DecodeError> {
        Message::from_payload(self.version(), self.message_id(), self.payload())
    }
}

impl Message {
    /// Reads a message from its payload; bytes missing at the end read as zero.
    ///
    /// # Errors
    /// [`DecodeError`] when the dialect does not have the id, or a field holds a value that it does not allow.
    pub fn from_payload(version: MavVersion, id: u32, payload: &[u8]) -> Result<Self, DecodeError> {
        Ok(match id {
            Heartbeat::ID => Self::Heartbeat(Heartbeat::read(payload)),
            CommandLong::ID => Self::CommandLong(CommandLong::read(payload)),
            CommandInt::ID => Self::CommandInt(CommandInt::read(payload)),
            CommandAck::ID => Self::CommandAck(CommandAck::read(payload)),
            MissionItemFloat::ID => Self::MissionItemFloat(MissionItemFloat::read(payload)),
            MissionItemInt::ID => Self::MissionItemInt(MissionItemInt::read(payload)),
            MissionAck::ID => Self::MissionAck(MissionAck::read(payload)),
            StatusText::ID => Self::StatusText(StatusText::read(payload)),
            _ => Self::Dialect(MavMessage::parse(version.into(), id, payload).map_err(|error| {
                match message_name(id) {
                    None => DecodeError::UnknownMessage { id },
                    Some(name) => DecodeError::BadPayload { id, name, reason: error.to_string() },
                }
            })?),
        })
    }

    /// Builds a message from its fields by their names, in the units of the wire; those not given are zero, and the
    /// target is `target` where the message has one.
    ///
    /// # Errors
    /// [`FieldError`] for a message or field that does not exist, or a value that does not fit.
    pub fn from_fields(
        name: &str,
        mut fields: BTreeMap<String, FieldValue>,
        target: Address,
    ) -> Result<Self, FieldError> {
        if let Some(id) = message_id_of(name) {
            for (field, number) in [("target_system", target.system.0), ("target_component", target.component.0)] {
                if has_field(id, field) {
                    fields.entry(field.to_owned()).or_insert(FieldValue::Unsigned(number.into()));
                }
            }
        }
        let (id, payload) = encode_fields(name, &fields)?;
        Ok(Self::from_payload(MavVersion::V2, id, &payload)?)
    }

    /// The message id.
    pub fn id(&self) -> u32 {
        match self {
            Self::Heartbeat(_) => Heartbeat::ID,
            Self::CommandLong(_) => CommandLong::ID,
            Self::CommandInt(_) => CommandInt::ID,
            Self::CommandAck(_) => CommandAck::ID,
            Self::MissionItemFloat(_) => MissionItemFloat::ID,
            Self::MissionItemInt(_) => MissionItemInt::ID,
            Self::MissionAck(_) => MissionAck::ID,
            Self::StatusText(_) => StatusText::ID,
            Self::Dialect(message) => message.message_id(),
        }
    }

    /// The message's name in the dialect, such as `"HEARTBEAT"`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Heartbeat(_) => Heartbeat::NAME,
            Self::CommandLong(_) => CommandLong::NAME,
            Self::CommandInt(_) => CommandInt::NAME,
            Self::CommandAck(_) => CommandAck::NAME,
            Self::MissionItemFloat(_) => MissionItemFloat::NAME,
            Self::MissionItemInt(_) => MissionItemInt::NAME,
            Self::MissionAck(_) => MissionAck::NAME,
            Self::StatusText(_) => StatusText::NAME,
            Self::Dialect(message) => message.message_name(),
        }
    }

    /// The message's target.
    pub fn target(&self) -> Target {
        let address = match self {
            Self::Heartbeat(_) | Self::StatusText(_) => return Target::default(),
            Self::CommandLong(message) => message.target,
            Self::CommandInt(message) => message.target,
            Self::CommandAck(message) => message.target,
            Self::MissionItemFloat(message) => message.target,
            Self::MissionItemInt(message) => message.target,
            Self::MissionAck(message) => message.target,
            Self::Dialect(message) => {
                return Target {
                    system: message.target_system_id().map(SystemId),
                    component: message.target_component_id().map(ComponentId),
                };
            }
        };
        Target { system: Some(address.system), component: Some(address.component) }
    }

    /// Its fields by their names, in the order of the wire.
    pub fn fields(&self) -> Vec<(&'static str, FieldValue)> {
        let header = Header { sequence: 0, source: Address::new(0, 0), version: MavVersion::V2 };
        decode_fields(self.id(), self.encode(header).payload()).unwrap_or_default()
    }

    /// Writes the message as a frame, checksum included, unsigned.
    ///
    /// A message whose id is above 255 does not exist in MAVLink 1: it is written in MAVLink 2 whatever the header
    /// says.
    pub fn encode(&self, header: Header) -> Frame {
        let id = self.id();
        let version = if id > 0xff { MavVersion::V2 } else { header.version };
        let mut payload = [0u8; 255];
        let len = match self {
            Self::Heartbeat(message) => write(message, version, &mut payload),
            Self::CommandLong(message) => write(message, version, &mut payload),
            Self::CommandInt(message) => write(message, version, &mut payload),
            Self::CommandAck(message) => write(message, version, &mut payload),
            Self::MissionItemFloat(message) => write(message, version, &mut payload),
            Self::MissionItemInt(message) => write(message, version, &mut payload),
            Self::MissionAck(message) => write(message, version, &mut payload),
            Self::StatusText(message) => write(message, version, &mut payload),
            Self::Dialect(message) => message.ser(version.into(), &mut payload),
        };
        let mut bytes = Vec::with_capacity(HEADER_LEN_V2 + len + CHECKSUM_LEN);
        let (system, component) = (header.source.system.0, header.source.component.0);
        match version {
            MavVersion::V1 => {
                bytes.extend_from_slice(&[STX_V1, len as u8, header.sequence, system, component, id as u8]);
                debug_assert_eq!(bytes.len(), HEADER_LEN_V1);
            }
            MavVersion::V2 => {
                let [id0, id1, id2, _] = id.to_le_bytes();
                bytes.extend_from_slice(&[STX_V2, len as u8, 0, 0, header.sequence, system, component, id0, id1, id2]);
                debug_assert_eq!(bytes.len(), HEADER_LEN_V2);
            }
        }
        bytes.extend_from_slice(&payload[..len]);
        let extra_crc = info(id).expect("invariant: every message that can be built is in the dialect").extra_crc;
        let sum = checksum(&bytes[1..], extra_crc);
        bytes.extend_from_slice(&sum.to_le_bytes());
        Frame::from_checked(Bytes::from(bytes))
    }
}

/// Writes a raw-number message; MAVLink 1 has no extension fields, MAVLink 2 cuts zeros off the end but keeps one byte.
fn write<W: Wire>(message: &W, version: MavVersion, payload: &mut [u8; 255]) -> usize {
    let mut writer = Writer::new(payload);
    message.write(&mut writer);
    let full = writer.len();
    match version {
        MavVersion::V1 => W::BASE_LEN,
        MavVersion::V2 => payload[..full].iter().rposition(|byte| *byte != 0).map_or(1, |last| last + 1),
    }
}
