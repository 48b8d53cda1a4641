//! Transfers fed with arbitrary messages from their own vehicle: they neither panic nor flood, and they end.

use std::time::Duration;

use proptest::prelude::*;
use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::{
    MISSION_COUNT_DATA, MISSION_REQUEST_INT_DATA, MavMessage, MavMissionType, MavParamType, PARAM_VALUE_DATA,
};
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};
use vencejo_proto::param::ParamName;
use vencejo_proto::{Message, MissionAck, MissionItemFloat, MissionItemInt, MonoTime};

use super::{LIMIT, by_ftp, by_items, mission};
use crate::transfer::testing::{PLANE, STATION};
use crate::transfer::{
    FtpGet, ItemForm, ParamList, ParamSet, PlanClear, PlanDownload, PlanUpload, Transfer, TransferConfig,
    TransferOutput,
};

/// Most messages that one call may put out: a window of items, or of requests, and a good-bye.
const BURST: usize = 80;

fn message() -> impl Strategy<Value = Message> {
    let small = 0u16..14;
    let number = prop_oneof![small.clone(), small, any::<u16>()];
    let to_us = |message| Message::Dialect(message);
    let kind = MavMissionType::MAV_MISSION_TYPE_MISSION;
    let count = number.clone().prop_map(move |count| {
        to_us(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count,
            target_system: 255,
            target_component: 190,
            mission_type: kind,
            ..Default::default()
        }))
    });
    let request = number.clone().prop_map(move |seq| {
        to_us(MavMessage::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
            seq,
            target_system: 255,
            target_component: 190,
            mission_type: kind,
        }))
    });
    let item = (number.clone(), any::<[u8; 32]>()).prop_map(|(seq, bytes)| {
        let item = MissionItemInt::from_payload(&bytes);
        Message::MissionItemInt(MissionItemInt { target: STATION, seq, mission_type: 0, ..item })
    });
    let float = (number.clone(), any::<[u8; 32]>()).prop_map(|(seq, bytes)| {
        let f = |at: usize| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        Message::MissionItemFloat(MissionItemFloat {
            target: STATION,
            seq,
            frame: bytes[0],
            command: u16::from(bytes[1]),
            current: bytes[2],
            autocontinue: bytes[3],
            params: [f(4), f(8), f(12), f(16)],
            x: f(20),
            y: f(24),
            z: f(28),
            mission_type: 0,
        })
    });
    let ack = (0u8..17)
        .prop_map(|result| Message::MissionAck(MissionAck { target: STATION, result, mission_type: 0, opaque_id: 0 }));
    let param = (number.clone(), number.clone(), any::<u32>()).prop_map(move |(index, count, bits)| {
        to_us(MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: f32::from_bits(bits),
            param_count: count,
            param_index: index,
            param_id: "P".into(),
            param_type: if bits % 2 == 0 {
                MavParamType::MAV_PARAM_TYPE_INT16
            } else {
                MavParamType::MAV_PARAM_TYPE_REAL32
            },
        }))
    });
    let answer = (
        prop_oneof![Just(128u8), Just(128), Just(129), any::<u8>()],
        prop_oneof![Just(1u8), Just(4), Just(5), Just(6), Just(7), Just(15), any::<u8>()],
        // The numbers of the first sessions, and others.
        prop_oneof![2030u16..2100, 4070u16..4120, any::<u16>()],
        prop_oneof![1u8..6, any::<u8>()],
        prop_oneof![Just(0u32), (0u32..8).prop_map(|chunk| chunk * 239), any::<u32>()],
        prop_oneof![
            Just(vec![0x3d, 0x76, 0, 0, 0, 0, 0, 0, 4, 0]),
            Just(vec![10]),
            proptest::collection::vec(any::<u8>(), 0..239),
            Just(vec![7; 239]),
        ],
        any::<bool>(),
    )
        .prop_map(|(opcode, request, sequence, session, offset, data, burst_complete)| {
            let mut answer = FtpPayload::request(FtpOpcode(opcode), session, sequence, offset, &data);
            answer.req_opcode = FtpOpcode(request);
            answer.burst_complete = burst_complete;
            answer.to_message(STATION)
        });
    prop_oneof![count, request.clone(), request, item, float, ack, param, answer.clone(), answer]
}

/// Feeds messages a few milliseconds apart, then silence; checks that little comes out at once and that it ends.
fn feed<T: Transfer>(mut transfer: T, messages: &[(u16, Message)]) {
    let mut now = MonoTime::ZERO;
    let mut is_over = false;
    let mut drain = |transfer: &mut T| {
        let mut sent = 0;
        while let Some(output) = transfer.poll_output() {
            sent += usize::from(matches!(output, TransferOutput::Send(_)));
        }
        assert!(sent <= BURST, "{sent} messages at once");
        if transfer.result().is_some() {
            assert!(!is_over, "ended twice");
            is_over = true;
        }
        is_over
    };
    for (after_ms, message) in messages {
        let until = now + Duration::from_millis(u64::from(*after_ms));
        while let Some(at) = transfer.deadline().filter(|at| *at <= until) {
            now = now.max(at);
            transfer.on_time(now);
            drain(&mut transfer);
        }
        now = until;
        transfer.on_message(PLANE, message, now);
        drain(&mut transfer);
    }
    let mut calls = 0;
    while !drain(&mut transfer) {
        let at = transfer.deadline().expect("what is not over has a deadline");
        now = now.max(at);
        transfer.on_time(now);
        calls += 1;
        assert!(calls < 20_000 && now.as_duration() < LIMIT, "it does not end ({calls} calls, {now})");
    }
    assert_eq!(transfer.deadline(), None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    // fault 20 (400 cases): any refusals, offsets and sizes fault 16 (400 cases): any messages to 8 transfers, also of
    // a vehicle that is no ArduPilot: each ends, never more than 80 messages at once
    #[test]
    fn no_message_upsets_a_transfer(
        messages in proptest::collection::vec((0u16..400, message()), 0..120),
        by_file: bool,
    ) {
        let ahead = TransferConfig { item_window: 64, ..by_items(Duration::ZERO) };
        let config = if by_file { by_ftp(Duration::ZERO, 1) } else { ahead };
        let kind = PlanKind::Mission;
        feed(PlanUpload::new(&config, kind, mission(9), MonoTime::ZERO), &messages);
        feed(PlanDownload::new(&config, kind, MonoTime::ZERO), &messages);
        feed(PlanClear::new(&config, kind, MonoTime::ZERO), &messages);
        let old = TransferConfig::old_ardupilot(config.vehicle, config.station);
        for config in [&old, &TransferConfig { item_form: ItemForm::Unknown, ..old.clone() }] {
            feed(PlanUpload::new(config, kind, mission(9), MonoTime::ZERO), &messages);
            feed(PlanDownload::new(config, kind, MonoTime::ZERO), &messages);
        }
        feed(ParamList::new(&config, MonoTime::ZERO), &messages);
        let name = ParamName::new("P").expect("a name");
        feed(ParamSet::new(&config, name, 3.0, MonoTime::ZERO), &messages);
        let other = TransferConfig { is_ardupilot: false, ..config };
        for config in [by_ftp(Duration::ZERO, 1), other] {
            feed(FtpGet::new(&config, "@SYS/x.txt", 5000, MonoTime::ZERO).expect("a path"), &messages);
        }
    }
}

// fault 20: paths that no message holds are refused
#[test]
fn paths_and_sizes_of_files_are_checked() {
    let config = by_ftp(Duration::ZERO, 1);
    assert!(FtpGet::new(&config, "", 10, MonoTime::ZERO).is_err());
    assert!(FtpGet::new(&config, &"x".repeat(240), 10, MonoTime::ZERO).is_err());
}
