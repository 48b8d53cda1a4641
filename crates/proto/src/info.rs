//! What the dialect knows of each message id without decoding it: checksum seed, name and where its target fields lie.

use std::sync::OnceLock;

use mavlink::{MavlinkVersion, Message as _};

use crate::dialect::MavMessage;

/// Marks "this message has no such field".
const ABSENT: u8 = u8::MAX;
/// One more than the largest id of the dialect's table; the protocol allows 24 bits, the dialects stay below this.
const TABLE_LEN: usize = 1 << 16;

/// Facts about one message of the dialect.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MessageInfo {
    /// The `CRC_EXTRA` seed of the message definition.
    pub(crate) extra_crc: u8,
    /// The message's name, as in the dialect.
    pub(crate) name: &'static str,
    target_system: u8,
    target_component: u8,
}

impl MessageInfo {
    /// Offset of `target_system` in the payload.
    pub(crate) fn target_system_offset(&self) -> Option<usize> {
        (self.target_system != ABSENT).then_some(usize::from(self.target_system))
    }

    /// Offset of `target_component` in the payload.
    pub(crate) fn target_component_offset(&self) -> Option<usize> {
        (self.target_component != ABSENT).then_some(usize::from(self.target_component))
    }
}

struct Table {
    /// `slot[id]` is one more than the index into `infos`; 0 marks an unknown id, so untouched pages stay unmapped.
    slot: Vec<u16>,
    infos: Vec<MessageInfo>,
}

#[inline]
fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut slot = vec![0u16; TABLE_LEN];
        let mut infos = Vec::new();
        for &id in MavMessage::all_ids() {
            let Some(place) = slot.get_mut(id as usize) else { continue };
            let Some(message) = MavMessage::default_message_from_id(id) else { continue };
            infos.push(MessageInfo {
                extra_crc: MavMessage::extra_crc(id),
                name: message.message_name(),
                target_system: offset_of(&message, |m, v| m.target_system_id_mut().map(|field| *field = v)),
                target_component: offset_of(&message, |m, v| m.target_component_id_mut().map(|field| *field = v)),
            });
            *place = infos.len() as u16;
        }
        Table { slot, infos }
    })
}

/// Finds a field's place in the payload by writing two values into it and comparing what comes out.
fn offset_of(message: &MavMessage, set: impl Fn(&mut MavMessage, u8) -> Option<()>) -> u8 {
    let serialised = |value: u8| {
        let mut message = message.clone();
        set(&mut message, value)?;
        let mut payload = [0u8; 255];
        message.ser(MavlinkVersion::V2, &mut payload);
        Some(payload)
    };
    match (serialised(0x5a), serialised(0xa5)) {
        (Some(a), Some(b)) => a.iter().zip(&b).position(|(a, b)| a != b).map_or(ABSENT, |at| at as u8),
        _ => ABSENT,
    }
}

/// Looks a message id up; `None` when the dialect does not have it.
#[inline]
pub(crate) fn info(id: u32) -> Option<&'static MessageInfo> {
    let table = table();
    let slot = *table.slot.get(id as usize)?;
    table.infos.get(usize::from(slot).checked_sub(1)?)
}

/// The name of a message id in the dialect, such as `"HEARTBEAT"` for 0.
pub fn message_name(id: u32) -> Option<&'static str> {
    info(id).map(|info| info.name)
}

/// The id of a message by its name in the dialect (upper case), such as 0 for `"HEARTBEAT"`.
pub fn message_id_of(name: &str) -> Option<u32> {
    MavMessage::message_id_from_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_targets_where_the_definitions_put_them() {
        // COMMAND_LONG: seven floats and a u16 come first. Offsets by the field ordering of the MAVLink serialisation
        // guide.
        let command_long = info(76).expect("COMMAND_LONG");
        assert_eq!((command_long.target_system_offset(), command_long.target_component_offset()), (Some(30), Some(31)));
        assert_eq!((command_long.name, command_long.extra_crc), ("COMMAND_LONG", 152));
        let heartbeat = info(0).expect("HEARTBEAT");
        assert_eq!((heartbeat.target_system_offset(), heartbeat.target_component_offset()), (None, None));
        // SET_MODE has a target system but no target component; COMMAND_ACK's targets are extension fields.
        let set_mode = info(11).expect("SET_MODE");
        assert_eq!((set_mode.target_system_offset(), set_mode.target_component_offset()), (Some(4), None));
        let command_ack = info(77).expect("COMMAND_ACK");
        assert_eq!((command_ack.target_system_offset(), command_ack.target_component_offset()), (Some(8), Some(9)));
    }

    #[test]
    fn names_and_ids_agree() {
        assert!(MavMessage::all_ids().len() > 250);
        for &id in MavMessage::all_ids() {
            let name = message_name(id).expect("every id of the dialect has a name");
            assert_eq!(message_id_of(name), Some(id));
        }
        assert_eq!(message_name(u32::MAX), None);
        assert_eq!(message_id_of("NO_SUCH_MESSAGE"), None);
    }
}
