//! Frames against recordings of a real ArduPlane, against noise, and there and back.

use std::collections::BTreeSet;

use proptest::prelude::*;
use rand::{Rng, SeedableRng, rngs::SmallRng};
use vencejo_proto::{
    Address, CommandAck, CommandInt, CommandLong, DecodeError, FrameDecoder, Header, Heartbeat, MavVersion, Message,
    MissionAck, MissionItemInt, StatusText, dialect,
};

const CAPTURE: &[u8] = include_bytes!("../../../tests/fixtures/captures/arduplane-50hz-20s.mavlink");

fn header(version: MavVersion) -> Header {
    Header { sequence: 42, source: Address::new(1, 1), version }
}

fn frames(bytes: &[u8]) -> (Vec<vencejo_proto::Frame>, FrameDecoder) {
    let mut decoder = FrameDecoder::new();
    decoder.push(bytes);
    (std::iter::from_fn(|| decoder.next_frame()).collect(), decoder)
}

#[test]
fn a_recorded_stream_decodes_whole() {
    let (frames, decoder) = frames(CAPTURE);
    assert_eq!(frames.len(), 20_511);
    assert_eq!((decoder.stats().bad_crc, decoder.stats().garbage_bytes, decoder.stats().unknown_id), (0, 0, 0));
    let names: BTreeSet<_> = frames.iter().map(|frame| frame.decode().expect("readable").name()).collect();
    assert_eq!(names.len(), 34);
}

// fault 54: 20,511 recorded frames decoded and encoded: the same bytes
#[test]
fn encoding_a_decoded_message_gives_the_recorded_bytes() {
    for frame in frames(CAPTURE).0 {
        let header = Header { sequence: frame.sequence(), source: frame.source(), version: frame.version() };
        let again = frame.decode().expect("readable").encode(header);
        // NaN payload bits and text after the first zero need not survive; nothing of the sort is in this recording.
        assert_eq!(again.bytes(), frame.bytes(), "{}", frame.message_id());
    }
}

#[test]
fn the_split_into_pieces_does_not_matter() {
    let bytes = &CAPTURE[..20_000];
    let whole = frames(bytes).0;
    assert!(whole.len() > 500);
    for piece in [1, 2, 7, 64, 281, 1000] {
        let mut decoder = FrameDecoder::new();
        let mut found = Vec::new();
        for chunk in bytes.chunks(piece) {
            decoder.push(chunk);
            found.extend(std::iter::from_fn(|| decoder.next_frame()));
        }
        assert_eq!(found, whole, "pieces of {piece}");
    }
}

// fault 6 (1 seeds): 2,000 of 2,000 frames between noise and torn ones
#[test]
fn every_intact_frame_is_found_between_noise_and_torn_frames() {
    let mut rng = SmallRng::seed_from_u64(1);
    let sent: Vec<_> = frames(CAPTURE).0.into_iter().take(2_000).collect();
    let mut stream = Vec::new();
    for frame in &sent {
        if rng.random_bool(0.3) {
            stream.extend((0..rng.random_range(1..60)).map(|_| rng.random::<u8>()));
        }
        if rng.random_bool(0.3) {
            stream.extend_from_slice(&frame.bytes()[..rng.random_range(1..frame.bytes().len())]);
        }
        stream.extend_from_slice(frame.bytes());
    }
    stream.extend([0u8; 300]);
    let (found, decoder) = frames(&stream);
    let known: Vec<_> = found.iter().filter(|frame| frame.is_known()).cloned().collect();
    assert_eq!(known.len(), sent.len());
    assert!(known == sent, "the same frames in the same order");
    assert!(decoder.stats().garbage_bytes > 1_000 && decoder.stats().bad_crc > 100);
}

// fault 7: a whole frame waits for no rest of garbage
#[test]
fn a_whole_frame_in_a_datagram_does_not_wait_for_the_rest_of_garbage() {
    let heartbeat = Message::Heartbeat(Heartbeat::default()).encode(header(MavVersion::V2));
    let torn = [0xfd, 200, 0, 0, 1, 1, 1, 0, 0, 0, 1, 2, 3];
    let mut decoder = FrameDecoder::new();
    decoder.push_datagram(&torn);
    assert_eq!(decoder.next_frame(), None);
    decoder.push_datagram(heartbeat.bytes());
    assert_eq!(decoder.next_frame(), Some(heartbeat.clone()));
    assert_eq!(decoder.stats().garbage_bytes, torn.len() as u64);
    // A frame that does come in two datagrams is still put together.
    let (head, tail) = heartbeat.bytes().split_at(7);
    decoder.push_datagram(head);
    decoder.push_datagram(tail);
    assert_eq!(decoder.next_frame(), Some(heartbeat));
}

// fault 8 (1 seeds): 1 MiB of noise: at most 1 frame that seems to be one
#[test]
fn noise_alone_gives_no_known_frame() {
    let mut rng = SmallRng::seed_from_u64(2);
    let noise: Vec<u8> = (0..1 << 20).map(|_| rng.random()).collect();
    let (found, decoder) = frames(&noise);
    // A checksum of 16 bits lets one candidate in 65,536 through.
    assert!(found.iter().filter(|frame| frame.is_known()).count() <= 1);
    assert!(decoder.stats().garbage_bytes > 1_000_000);
}

/// How often something is tried: so often in the suite, another number in a soak.
fn tries(usual: usize) -> usize {
    std::env::var("VENCEJO_TEST_FRAMES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Sends the recorded stream again and again through something that damages it; the share of the intact frames that come out, and
/// how many frames come out as known that were not sent so.
fn damaged(count: usize, mut damage: impl FnMut(&mut Vec<u8>) -> bool) -> (f64, usize, usize) {
    let recorded = frames(CAPTURE).0;
    let mut decoder = FrameDecoder::new();
    let (mut intact, mut kept, mut slipped, mut hit) = (0_usize, 0_usize, 0_usize, 0_usize);
    let mut waiting = std::collections::VecDeque::new();
    for sent in 0..count {
        let frame = &recorded[sent % recorded.len()];
        let mut bytes = frame.bytes().to_vec();
        if damage(&mut bytes) {
            hit += 1;
        } else {
            intact += 1;
            waiting.push_back(frame);
        }
        decoder.push(&bytes);
        while let Some(found) = decoder.next_frame() {
            if !found.is_known() {
                continue;
            }
            // What comes out has the checksum that it should have, by a calculation that is not the decoder's.
            let extra_crc = <dialect::MavMessage as mavlink::Message>::extra_crc(found.message_id());
            let bytes = found.bytes();
            let end = bytes.len() - if found.is_signed() { 15 } else { 2 };
            let crc = u16::from_le_bytes([bytes[end], bytes[end + 1]]);
            assert_eq!(mavlink::calculate_crc(&bytes[1..end], extra_crc), crc);
            match waiting.iter().position(|sent| **sent == found) {
                Some(at) => {
                    waiting.drain(..=at);
                    kept += 1;
                }
                None => slipped += 1,
            }
        }
    }
    // What still waits for its end is not lost.
    let held = waiting.len().min(40);
    ((kept + held) as f64 / intact as f64, slipped, hit)
}

// fault 6: of 205,110 frames with bit errors at 1e-4, and with 1 % of all bytes changed, ≥ 99.9 % of the intact ones are found, none with a wrong checksum
#[test]
fn intact_frames_between_damaged_ones_are_found() {
    let count = tries(205_110);
    let mut rng = SmallRng::seed_from_u64(6);
    let (kept, slipped, hit) = damaged(count, |bytes| {
        let mut is_hit = false;
        for at in 0..bytes.len() * 8 {
            if rng.random_bool(1e-4) {
                bytes[at / 8] ^= 1 << (at % 8);
                is_hit = true;
            }
        }
        is_hit
    });
    println!("bit errors: {:.5} of the intact frames, {slipped} slipped of {hit} hit", kept);
    assert!(kept >= 0.999, "{kept}");
    assert!(slipped <= 3 + hit / 10_000, "{slipped} of {hit}");
    let (kept, slipped, hit) = damaged(count, |bytes| {
        let before = bytes.clone();
        for byte in bytes.iter_mut() {
            if rng.random_bool(0.01) {
                *byte = rng.random();
            }
        }
        *bytes != before
    });
    println!("bytes: {:.5} of the intact frames, {slipped} slipped of {hit} hit", kept);
    assert!(kept >= 0.999, "{kept}");
    assert!(slipped <= 3 + hit / 10_000, "{slipped} of {hit}");
}

// fault 7: every whole frame of 100,000 datagrams is parsed, whatever is cut off at any place or packed together
#[test]
fn every_whole_frame_of_cut_and_packed_datagrams_is_found() {
    let recorded = frames(CAPTURE).0;
    let mut rng = SmallRng::seed_from_u64(7);
    let mut decoder = FrameDecoder::new();
    let (mut whole, mut cuts) = (0_usize, BTreeSet::new());
    let count = tries(100_000);
    for number in 0..count {
        let mut datagram = Vec::new();
        let mut expected = Vec::new();
        for _ in 0..rng.random_range(1..=3) {
            let frame = &recorded[rng.random_range(0..recorded.len())];
            datagram.extend_from_slice(frame.bytes());
            expected.push(frame);
        }
        if number % 2 == 0 {
            // The last one ends too early: at each of its places in turn.
            let last = expected.pop().expect("one").bytes().len();
            let keep = 1 + number / 2 % (last - 1);
            cuts.insert(keep);
            datagram.truncate(datagram.len() - last + keep);
        }
        decoder.push_datagram(&datagram);
        let found: Vec<_> = std::iter::from_fn(|| decoder.next_frame()).filter(|frame| frame.is_known()).collect();
        assert!(found.iter().eq(expected.iter().copied()), "datagram {number}: {} of {}", found.len(), expected.len());
        whole += found.len();
    }
    println!("{whole} frames in {count} datagrams, cut at {} places", cuts.len());
    assert!(whole >= count && cuts.len() > 50, "{whole} {}", cuts.len());
}

// fault 54: a frame whose beginning noise claims is found, wherever a piece of the stream ends
#[test]
fn what_may_be_an_unknown_frame_hides_none_that_can_be_checked() {
    let heartbeat = Message::Heartbeat(Heartbeat::default()).encode(header(MavVersion::V2));
    for covered in 1..heartbeat.bytes().len() {
        // A header whose payload and checksum reach into the heartbeat.
        let mut bytes = vec![0xfd, u8::try_from(covered).expect("small"), 0, 0, 9, 1, 1, 0x39, 0x30, 0, 7, 7];
        bytes.extend_from_slice(heartbeat.bytes());
        for end in 0..=bytes.len() {
            let mut decoder = FrameDecoder::new();
            let mut found = Vec::new();
            for piece in [&bytes[..end], &bytes[end..]] {
                decoder.push(piece);
                found.extend(std::iter::from_fn(|| decoder.next_frame()));
            }
            assert_eq!(
                found.iter().filter(|frame| frame.is_known()).count(),
                1,
                "{covered} covered, a piece ends at {end}"
            );
        }
    }
}

#[test]
fn an_unknown_message_is_kept_for_forwarding() {
    let mut bytes = vec![0xfd, 3, 0, 0, 9, 1, 1, 0x39, 0x30, 0, 1, 2, 3, 0xaa, 0xbb];
    assert_eq!(bytes.len(), 15);
    bytes.extend_from_slice(Message::Heartbeat(Heartbeat::default()).encode(header(MavVersion::V2)).bytes());
    let (found, decoder) = frames(&bytes);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].message_id(), found[0].is_known(), found[0].payload()), (12_345, false, &[1u8, 2, 3][..]));
    assert_eq!(found[0].bytes(), &bytes[..15]);
    assert_eq!(found[0].decode(), Err(DecodeError::UnknownMessage { id: 12_345 }));
    assert_eq!(decoder.stats().unknown_id, 1);
}

#[test]
fn a_new_enum_value_is_refused_with_its_name_but_kept_where_flight_depends_on_it() {
    let ack =
        CommandAck { command: 64_999, result: 200, progress: 0, result_param2: 0, target: Address::new(255, 190) };
    let frame = Message::CommandAck(ack).encode(header(MavVersion::V2));
    assert_eq!(frame.decode(), Ok(Message::CommandAck(ack)));

    let gps = Message::Dialect(dialect::MavMessage::GPS_RAW_INT(dialect::GPS_RAW_INT_DATA {
        lat: 1,
        ..dialect::GPS_RAW_INT_DATA::DEFAULT
    }))
    .encode(header(MavVersion::V2));
    // fix_type (payload offset 28) becomes a value that no definition has; the checksum is made right again by the sender.
    let mut payload = gps.payload().to_vec();
    payload.resize(30, 0);
    payload[28] = 99;
    let bytes = resealed(gps.message_id(), 24, &payload);
    let (found, _) = frames(&bytes);
    let error = found[0].decode().expect_err("fix type 99");
    assert!(matches!(error, DecodeError::BadPayload { name: "GPS_RAW_INT", .. }), "{error}");
}

fn resealed(id: u32, extra_crc: u8, payload: &[u8]) -> Vec<u8> {
    let [id0, id1, id2, _] = id.to_le_bytes();
    let mut bytes = vec![0xfd, payload.len() as u8, 0, 0, 0, 1, 1, id0, id1, id2];
    bytes.extend_from_slice(payload);
    let crc = mavlink::calculate_crc(&bytes[1..], extra_crc);
    bytes.extend_from_slice(&crc.to_le_bytes());
    bytes
}

#[test]
fn targets_are_read_without_decoding() {
    let command = CommandLong { target: Address::new(3, 1), command: 400, confirmation: 0, params: [0.0; 7] };
    let frame = Message::CommandLong(command).encode(header(MavVersion::V2));
    let target = frame.target();
    assert_eq!(target, Message::CommandLong(command).target());
    assert!(target.includes(Address::new(3, 1)) && !target.includes(Address::new(4, 1)));
    let heartbeat = Message::Heartbeat(Heartbeat::default()).encode(header(MavVersion::V2));
    assert!(heartbeat.target().includes(Address::new(9, 9)));
}

#[test]
fn mavlink_1_frames_have_no_extension_fields() {
    let item = MissionItemInt {
        target: Address::new(1, 1),
        seq: 3,
        frame: 3,
        command: 16,
        current: 0,
        autocontinue: 1,
        params: [1.0, 2.0, 3.0, 4.0],
        x: 403_355_555,
        y: -37_966_666,
        z: 77.0,
        mission_type: 1,
    };
    let frame = Message::MissionItemInt(item).encode(header(MavVersion::V1));
    assert_eq!((frame.version(), frame.payload().len()), (MavVersion::V1, 37));
    assert_eq!(frame.decode(), Ok(Message::MissionItemInt(MissionItemInt { mission_type: 0, ..item })));
    assert_eq!(MissionItemInt::from_payload(&item.to_packed()), item);
}

#[test]
#[allow(deprecated, reason = "the autopilots that have only this message are older than its deprecation")]
fn the_float_item_is_laid_out_as_the_dialect_has_it() {
    use vencejo_proto::MissionItemFloat;
    use vencejo_proto::dialect::{MISSION_ITEM_DATA, MavCmd, MavFrame, MavMessage, MavMissionType};
    let item = MissionItemFloat {
        target: Address::new(1, 2),
        seq: 3,
        frame: 3,
        command: 16,
        current: 2,
        autocontinue: 1,
        params: [1.0, 2.0, 3.0, 4.0],
        x: 40.5,
        y: -3.75,
        z: 77.0,
        mission_type: 1,
    };
    let theirs = MavMessage::MISSION_ITEM(MISSION_ITEM_DATA {
        param1: 1.0,
        param2: 2.0,
        param3: 3.0,
        param4: 4.0,
        x: 40.5,
        y: -3.75,
        z: 77.0,
        seq: 3,
        command: MavCmd::MAV_CMD_NAV_WAYPOINT,
        target_system: 1,
        target_component: 2,
        frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
        current: 2,
        autocontinue: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_FENCE,
    });
    for version in [MavVersion::V1, MavVersion::V2] {
        let frame = Message::MissionItemFloat(item).encode(header(version));
        assert_eq!(frame.bytes(), Message::Dialect(theirs.clone()).encode(header(version)).bytes());
        let mission_type = if version == MavVersion::V1 { 0 } else { 1 };
        assert_eq!(frame.decode(), Ok(Message::MissionItemFloat(MissionItemFloat { mission_type, ..item })));
    }
    // A command that this dialect does not name is kept.
    let newer = Message::MissionItemFloat(MissionItemFloat { command: 65_000, ..item });
    assert_eq!(newer.encode(header(MavVersion::V1)).decode().map(|message| message.id()), Ok(39));
}

fn address() -> impl Strategy<Value = Address> {
    any::<(u8, u8)>().prop_map(|(system, component)| Address::new(system, component))
}

fn raw_messages() -> impl Strategy<Value = Message> {
    let finite = -1.0e6f32..1.0e6;
    prop_oneof![
        any::<(u32, u8, u8, u8, u8)>().prop_map(|(custom_mode, mav_type, autopilot, base_mode, system_status)| {
            Message::Heartbeat(Heartbeat {
                custom_mode,
                mav_type,
                autopilot,
                base_mode,
                system_status,
                mavlink_version: 3,
            })
        }),
        (address(), any::<u16>(), any::<u8>(), prop::array::uniform7(finite.clone())).prop_map(
            |(target, command, confirmation, params)| {
                Message::CommandLong(CommandLong { target, command, confirmation, params })
            }
        ),
        (address(), any::<(u8, u16, i32, i32)>(), finite.clone(), prop::array::uniform4(finite.clone())).prop_map(
            |(target, (frame, command, x, y), z, params)| {
                Message::CommandInt(CommandInt { target, frame, command, current: 0, autocontinue: 0, params, x, y, z })
            }
        ),
        (address(), any::<(u16, u8, u8, i32)>()).prop_map(|(target, (command, result, progress, result_param2))| {
            Message::CommandAck(CommandAck { command, result, progress, result_param2, target })
        }),
        (address(), any::<(u16, u8, u16, u8, i32, i32, u8)>(), finite.clone(), prop::array::uniform4(finite)).prop_map(
            |(target, (seq, frame, command, current, x, y, mission_type), z, params)| {
                let autocontinue = 1;
                Message::MissionItemInt(MissionItemInt {
                    target,
                    seq,
                    frame,
                    command,
                    current,
                    autocontinue,
                    params,
                    x,
                    y,
                    z,
                    mission_type,
                })
            }
        ),
        (address(), any::<(u8, u8, u32)>()).prop_map(|(target, (result, mission_type, opaque_id))| {
            Message::MissionAck(MissionAck { target, result, mission_type, opaque_id })
        }),
        ("[a-zA-Z0-9 :#]{0,50}", any::<(u8, u16, u8)>()).prop_map(|(text, (severity, id, chunk_seq))| {
            Message::StatusText(StatusText { severity, text, id, chunk_seq })
        }),
    ]
}

proptest! {
    #[test]
    fn raw_number_messages_survive_the_wire_as_the_dialect_has_them(message in raw_messages()) {
        let frame = message.encode(header(MavVersion::V2));
        prop_assert_eq!(frame.decode(), Ok(message.clone()));
        let (found, _) = frames(frame.bytes());
        prop_assert_eq!(&found[..], &[frame.clone()][..]);
        prop_assert_eq!(frame.target(), message.target());
        // The generated decoder reads the same bytes, unless an enum value is new to it.
        let generated = <dialect::MavMessage as mavlink::Message>::parse(
            mavlink::MavlinkVersion::V2, frame.message_id(), frame.payload());
        if let Ok(generated) = generated {
            let again = Message::Dialect(generated).encode(header(MavVersion::V2));
            prop_assert_eq!(again.bytes(), frame.bytes());
        }
    }

    // fault 53 (256 cases): any bytes as frames
    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        for frame in frames(&bytes).0 {
            let _ = (frame.decode(), frame.target(), frame.source(), frame.sequence(), frame.is_signed());
        }
    }

    // fault 53 (256 cases): any payload of any message
    #[test]
    fn no_payload_panics(id in prop::sample::select(dialect::MavMessage::all_ids()), payload in prop::collection::vec(any::<u8>(), 0..255)) {
        let extra_crc = <dialect::MavMessage as mavlink::Message>::extra_crc(id);
        for frame in frames(&resealed(id, extra_crc, &payload)).0 {
            let _ = (frame.decode(), frame.target());
        }
    }
}
