//! Any payload with any id: decoded or refused, equally by the message types and by the field tables.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_proto::{MavVersion, Message, decode_fields, encode_fields, message_name};

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let Some((id, payload)) = data.split_first_chunk::<2>() else { return };
    let payload = &payload[..payload.len().min(255)];
    let id = u32::from(u16::from_le_bytes(*id));
    let message = Message::from_payload(MavVersion::V2, id, payload);
    if let Some(fields) = decode_fields(id, payload) {
        let name = message_name(id).expect("what has fields has a name");
        let values = fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        if let Ok((same, _)) = encode_fields(name, &values) {
            assert_eq!(same, id);
        }
    }
    if let Ok(message) = message {
        assert_eq!(message.id(), id);
    }
}));
