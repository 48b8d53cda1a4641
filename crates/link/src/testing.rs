//! Frames for tests.

use vencejo_proto::{Address, Frame, FrameDecoder, Header, Heartbeat, MavVersion, Message, dialect};

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
    decoder.push(&[0xfd, 3, 0, 0, sequence, system, component, 0x10, 0xf0, 0xf0, 1, 2, 3, sequence, 0xab]);
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
