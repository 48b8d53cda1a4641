//! Transfers against what a real ArduPlane said when it was recorded (`tests/fixtures/captures`).

use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::MavMessage;
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};
use vencejo_proto::param::{ParamName, ParamType, ParamValue, decode_packed_params};
use vencejo_proto::plan_file::{decode_plan_file, encode_plan_file};
use vencejo_proto::{Header, MavVersion, Message, MissionItemInt, MonoTime};

use super::{LIMIT, by_ftp, by_items};
use crate::transfer::items::{ItemDownload, ItemUpload, ItemsSent};
use crate::transfer::testing::{
    Endpoint, Faults, MockPlane, PLANE, Recording, Running, STATION, World, recorded, run, tlog,
};
use crate::transfer::{
    ItemForm, ParamList, ParamRead, ParamSet, PlanClear, PlanRoute, PlanUpload, Transfer, TransferError,
};

/// `mission.dat` as it was uploaded.
const MISSION_FILE: &[u8] = include_bytes!("../../../../../tests/fixtures/captures/mission.dat");

/// The items that the recorded station sent, each once, in order.
fn items_sent(recording: &str, kind: PlanKind) -> Vec<MissionItemInt> {
    let mut items: Vec<MissionItemInt> = recorded(recording, STATION)
        .into_iter()
        .filter_map(|(_, message)| match message {
            Message::MissionItemInt(item) if item.mission_type == kind.mission_type() => Some(item),
            _ => None,
        })
        .collect();
    items.sort_by_key(|item| item.seq);
    items.dedup_by_key(|item| item.seq);
    items
}

/// What the recorded station sent of the mission protocol, as payload bytes.
fn station_said(recording: &str) -> Vec<(u32, Vec<u8>)> {
    let plan = |id: &u32| matches!(id, 39..=47 | 51 | 73);
    tlog(recording)
        .iter()
        .filter(|(_, frame)| frame.source() == STATION && plan(&frame.message_id()))
        .map(|(_, frame)| (frame.message_id(), frame.payload().to_vec()))
        .collect()
}

fn payload(message: &Message) -> (u32, Vec<u8>) {
    let frame = message.encode(Header { sequence: 0, source: STATION, version: MavVersion::V2 });
    (frame.message_id(), frame.payload().to_vec())
}

/// Runs a transfer against recordings, one after the other; its result and what it sent.
fn replay<T: Transfer>(transfer: T, recordings: &[&str]) -> (Result<T::Value, TransferError>, Vec<Message>) {
    let instant = Faults { delay: Duration::ZERO, ..Faults::default() };
    let mut world = World::new(Running::new(transfer), Recording::new(recordings), instant, 1);
    world.log = Some(Vec::new());
    let (result, _) = run(&mut world, LIMIT);
    (result, world.log.take().expect("logged").into_iter().map(|(_, message)| message).collect())
}

#[test]
fn an_upload_by_items_says_what_the_recorded_one_said() {
    let items = items_sent("mission-upload-items", PlanKind::Mission);
    assert_eq!(items.len(), 12);
    let upload =
        ItemUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, items, ItemForm::Integer, MonoTime::ZERO);
    let (result, said) = replay(upload, &["mission-upload-items"]);
    assert_eq!(result, Ok(ItemsSent { acknowledged: true, plan_id: None }));
    let said: Vec<_> = said.iter().map(payload).collect();
    assert_eq!(said.len(), 13);
    assert_eq!(said, station_said("mission-upload-items"));
}

#[test]
fn a_download_by_items_reads_what_was_recorded() {
    let one_by_one = crate::transfer::TransferConfig { is_ardupilot: false, ..by_items(Duration::ZERO) };
    let download = ItemDownload::new(&one_by_one, PlanKind::Mission, ItemForm::Integer, MonoTime::ZERO);
    let (result, said) = replay(download, &["mission-download-items"]);
    let items = result.expect("read");
    assert_eq!(items.len(), 12);
    assert_eq!((items[0].z, items[7].params, items[11].command), (600.089_97, [1.0, 0.0, 80.0, 1.0], 21));
    let said: Vec<_> = said.iter().map(payload).collect();
    assert_eq!(said.len(), 14);
    assert_eq!(said, station_said("mission-download-items"));
}

#[test]
fn a_recorded_upload_and_download_make_a_verified_plan() {
    let items = items_sent("mission-upload-items", PlanKind::Mission);
    let upload = PlanUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, items.clone(), MonoTime::ZERO);
    let (result, _) = replay(upload, &["mission-upload-items", "mission-download-items"]);
    let plan = result.expect("verified");
    assert_eq!((plan.items.len(), plan.route), (12, PlanRoute::Items));

    // The same, but one value on its way to the vehicle was another one.
    let mut other = items;
    other[5].z += 1.0;
    let upload = PlanUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, other, MonoTime::ZERO);
    let (result, _) = replay(upload, &["mission-upload-items", "mission-download-items"]);
    let Err(TransferError::NotAsSent { differences, .. }) = result else { panic!("{result:?}") };
    assert_eq!(differences.len(), 1);
    assert_eq!((differences[0].seq, differences[0].sent, differences[0].kept), (5, Some(91.0), Some(90.0)));
}

#[test]
fn fence_and_rally_are_sent_and_verified_as_recorded() {
    for (kind, count) in [(PlanKind::Fence, 4), (PlanKind::Rally, 1)] {
        let items = items_sent("fence-and-rally-upload", kind);
        assert_eq!(items.len(), count);
        let instant = Faults { delay: Duration::ZERO, ..Faults::default() };
        let upload = PlanUpload::new(&by_items(Duration::ZERO), kind, items, MonoTime::ZERO);
        let mut world = World::new(Running::new(upload), Recording::new(&["fence-and-rally-upload"]), instant, 1);
        let (result, _) = run(&mut world, LIMIT);
        assert_eq!(result.map(|plan| plan.items.len()), Ok(count), "{kind}");
    }
}

#[test]
fn a_refused_item_is_named_as_recorded() {
    let mut items = items_sent("mission-upload-unsupported-command", PlanKind::Mission);
    assert_eq!(items.len(), 6, "the recorded station was stopped at item 5");
    for seq in 6..12 {
        items.push(MissionItemInt { seq, ..items[4] });
    }
    let upload = PlanUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, items, MonoTime::ZERO);
    let (result, _) = replay(upload, &["mission-upload-unsupported-command"]);
    let error = result.expect_err("refused");
    let text = error.to_string();
    assert_eq!(
        text,
        "the vehicle refused the mission at item 5: an item's command is not supported (MAV_MISSION_UNSUPPORTED, 3)"
    );
}

#[test]
fn an_item_out_of_order_does_not_end_the_upload() {
    // Recorded: a stray item, MISSION_ACK 13, then the vehicle asks for item 4 all the same, and again after a second.
    let mut items = items_sent("mission-upload-out-of-sequence-item", PlanKind::Mission);
    let template = items[3];
    items.extend((items.len() as u16..12).map(|seq| MissionItemInt { seq, ..template }));
    let upload =
        ItemUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, items, ItemForm::Integer, MonoTime::ZERO);
    let (result, said) = replay(upload, &["mission-upload-out-of-sequence-item"]);
    let sent: Vec<u16> = said
        .iter()
        .filter_map(|message| if let Message::MissionItemInt(item) = message { Some(item.seq) } else { None })
        .collect();
    assert_eq!(sent, [0, 1, 2, 3, 4, 4], "only what was asked for");
    // The recording ends there; the vehicle is silent from then on.
    assert!(matches!(result, Err(TransferError::Timeout { .. })), "{result:?}");
}

#[test]
fn a_list_that_is_too_long_is_refused_as_recorded() {
    let item = items_sent("mission-upload-items", PlanKind::Mission)[2];
    let items: Vec<_> = (0..10_000).map(|seq| MissionItemInt { seq, ..item }).collect();
    let upload = PlanUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, items, MonoTime::ZERO);
    let (result, said) = replay(upload, &["mission-upload-too-many"]);
    assert!(matches!(result, Err(TransferError::Refused { item: None, result, .. }) if result.0 == 4), "{result:?}");
    assert_eq!(said.iter().map(payload).collect::<Vec<_>>(), station_said("mission-upload-too-many"));
}

#[test]
fn a_vehicle_that_gives_up_is_begun_with_anew() {
    // Recorded: eight requests for item 0, a second apart, then MISSION_ACK 15 "cancelled".
    let items = items_sent("mission-upload-items", PlanKind::Mission);
    let upload =
        ItemUpload::new(&by_items(Duration::ZERO), PlanKind::Mission, items, ItemForm::Integer, MonoTime::ZERO);
    let (result, said) = replay(upload, &["mission-upload-abandoned"]);
    let counts = said.iter().filter(|message| message.name() == "MISSION_COUNT").count();
    let firsts =
        said.iter().filter(|message| matches!(message, Message::MissionItemInt(item) if item.seq == 0)).count();
    assert_eq!(firsts, 8, "each time that it was asked for");
    assert!(counts >= 2, "{counts}");
    assert!(matches!(result, Err(TransferError::Timeout { .. })), "{result:?}");
}

#[test]
fn clearing_says_what_the_recorded_station_said_and_then_checks() {
    let clear = PlanClear::new(&by_items(Duration::ZERO), PlanKind::Mission, MonoTime::ZERO);
    let (result, said) = replay(clear, &["mission-clear"]);
    assert_eq!(payload(&said[0]), station_said("mission-clear")[0]);
    assert_eq!(said[1].name(), "MISSION_REQUEST_LIST");
    // Nobody answers the check in the recording: cleared, but not verified.
    assert!(matches!(result, Err(TransferError::Unverified { .. })), "{result:?}");
}

/// The bytes that a station wrote by MAVFTP, put together.
fn written<'a>(messages: impl IntoIterator<Item = &'a Message>) -> Vec<u8> {
    let mut file = Vec::new();
    for message in messages {
        let Some((_, request)) = FtpPayload::from_message(message) else { continue };
        if request.opcode == FtpOpcode::WRITE_FILE {
            let start = request.offset as usize;
            file.resize(file.len().max(start + request.data.len()), 0);
            file[start..start + request.data.len()].copy_from_slice(&request.data);
        }
    }
    file
}

#[test]
fn the_file_that_is_written_is_the_recorded_one_byte_for_byte() {
    let sent: Vec<_> = recorded("mission-upload-ftp", STATION).into_iter().map(|(_, message)| message).collect();
    assert_eq!(written(&sent), MISSION_FILE);
    let (_, items) = decode_plan_file(MISSION_FILE).expect("a plan file");
    let upload = PlanUpload::new(&by_ftp(Duration::ZERO, 1), PlanKind::Mission, items, MonoTime::ZERO);
    let mut world = World::new(Running::new(upload), MockPlane::new(), Faults::default(), 1);
    world.log = Some(Vec::new());
    let (result, _) = run(&mut world, LIMIT);
    assert_eq!(result.expect("sent").route, PlanRoute::Ftp);
    let ours: Vec<_> = world.log.take().expect("logged").into_iter().map(|(_, message)| message).collect();
    assert_eq!(written(&ours), MISSION_FILE);
    // Whole items in every write: a write that is lost leaves zeros, which ArduPilot refuses.
    let writes: Vec<_> = ours
        .iter()
        .filter_map(|message| FtpPayload::from_message(message).map(|(_, request)| request))
        .filter(|request| request.opcode == FtpOpcode::WRITE_FILE)
        .collect();
    assert!(writes.len() >= 2);
    for write in &writes {
        let end = write.offset as usize + write.data.len();
        assert!(write.offset == 0 || (write.offset as usize - 10).is_multiple_of(38), "{}", write.offset);
        assert!((end - 10).is_multiple_of(38), "{end}");
    }
}

#[test]
fn the_imitation_answers_a_recorded_station_as_the_real_one_did() {
    // The real one lost requests that came too fast; those the recorded station sent again. Compare what is answered.
    for (recording, reads) in [("mission-upload-ftp", false), ("mission-download-ftp", true)] {
        let mut plane = MockPlane::new();
        plane.leaves_garbage = false;
        let (_, items) = decode_plan_file(MISSION_FILE).expect("a plan file");
        if reads {
            plane.store(PlanKind::Mission, &items);
        }
        let mut answers = Vec::new();
        for (at, message) in recorded(recording, STATION) {
            plane.receive(STATION, &message, at);
            plane.tick(at);
            while let Some(answer) = plane.next_output() {
                answers.push(answer);
            }
        }
        let gist = |message: &Message| {
            let (_, answer) = FtpPayload::from_message(message)?;
            (answer.opcode == FtpOpcode::ACK).then(|| {
                // The size of a plan file is made up, and home is where the plane stands.
                let data = if answer.offset >= 80 { answer.data.clone() } else { Vec::new() };
                (answer.req_opcode.0, answer.session, answer.sequence, answer.offset, data)
            })
        };
        let mut ours: Vec<_> = answers.iter().filter_map(gist).collect();
        let mut theirs: Vec<_> = recorded(recording, PLANE).iter().filter_map(|(_, message)| gist(message)).collect();
        for list in [&mut ours, &mut theirs] {
            list.sort();
            list.dedup();
        }
        assert!(theirs.len() >= 8, "{}", theirs.len());
        assert_eq!(ours, theirs, "{recording}");
        if !reads {
            assert!(super::has(&plane.plans[0], &items));
        }
    }
}

#[test]
fn a_recorded_plan_file_is_the_plan_as_stored() {
    let mut file = Vec::new();
    for (_, message) in recorded("mission-download-ftp", PLANE) {
        let Some((_, answer)) = FtpPayload::from_message(&message) else { continue };
        if answer.opcode == FtpOpcode::ACK && answer.req_opcode == FtpOpcode::BURST_READ_FILE {
            file.resize(file.len().max(answer.offset as usize + answer.data.len()), 0);
            file[answer.offset as usize..][..answer.data.len()].copy_from_slice(&answer.data);
        }
    }
    let (header, stored) = decode_plan_file(&file).expect("a plan file");
    assert_eq!((header.count, stored.len()), (12, 12));
    let (_, sent) = decode_plan_file(MISSION_FILE).expect("a plan file");
    assert!(super::has(&stored, &sent));
    assert_eq!(encode_plan_file(0, &stored), file);
}

/// `arduplane-params.parm`: name, value, `MAV_PARAM_TYPE`.
fn parm() -> Vec<(String, f64, u8)> {
    include_str!("../../../../../tests/fixtures/captures/arduplane-params.parm")
        .lines()
        .map(|line| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            let [name, value, kind] = fields[..] else { panic!("{line:?}") };
            (name.to_owned(), value.parse().expect("a number"), kind.parse().expect("a type"))
        })
        .collect()
}

#[test]
fn the_recorded_parameter_list_is_read_whole() {
    let list = ParamList::new(&by_items(Duration::ZERO), MonoTime::ZERO);
    let (result, said) = replay(list, &["param-list"]);
    let mut read = result.expect("read");
    assert_eq!(said.len(), 1, "nothing was lost, so nothing is asked for again");
    assert_eq!(read.len(), 1399);
    read.sort_by_key(|param| param.name);
    let mut expected = parm();
    expected.sort_by(|a, b| a.0.cmp(&b.0));
    for (param, (name, value, kind)) in read.iter().zip(&expected) {
        assert_eq!((param.name.as_str(), param.value.param_type().to_mav() as u8), (name.as_str(), *kind));
        assert!((param.value.as_f64() - value).abs() <= 1e-5 * value.abs().max(1.0), "{name}");
    }
}

#[test]
fn the_recorded_parameter_file_is_read_whole() {
    let mut file = Vec::new();
    for (_, message) in recorded("param-ftp", PLANE) {
        let Some((_, answer)) = FtpPayload::from_message(&message) else { continue };
        if answer.opcode == FtpOpcode::ACK && answer.req_opcode == FtpOpcode::BURST_READ_FILE {
            file.resize(file.len().max(answer.offset as usize + answer.data.len()), 0);
            file[answer.offset as usize..][..answer.data.len()].copy_from_slice(&answer.data);
        }
    }
    let params = decode_packed_params(&file).expect("a packed file");
    assert_eq!(params.len(), 1399);
    // And by our own reader, which reads in other portions, from an imitation that has these parameters.
    let mut plane = MockPlane::new();
    plane.params = params.clone();
    let list = ParamList::new(&by_ftp(Duration::ZERO, 1), MonoTime::ZERO);
    let mut world = World::new(Running::new(list), plane, Faults::loss(0.1), 1);
    assert_eq!(run(&mut world, LIMIT).0, Ok(params));
}

#[test]
fn a_parameter_is_set_and_an_unknown_one_named_as_recorded() {
    let name = |text| ParamName::new(text).expect("a name");
    let config = by_items(Duration::ZERO);
    let set = ParamSet::new(&config, name("RTL_AUTOLAND"), 2.0, MonoTime::ZERO);
    let (result, said) = replay(set, &["param-set"]);
    let param = result.expect("set");
    assert_eq!((param.value, param.value.param_type()), (ParamValue::I8(2), ParamType::I8));
    let sets: Vec<_> = said.iter().filter(|message| message.name() == "PARAM_SET").collect();
    assert!(!sets.is_empty());
    for message in sets {
        let Message::Dialect(MavMessage::PARAM_SET(set)) = message else { panic!("{message:?}") };
        assert_eq!((set.param_value, set.param_id.to_str()), (2.0, Ok("RTL_AUTOLAND")));
    }
    let (result, _) = replay(ParamRead::new(&config, name("NOT_A_PARAM"), MonoTime::ZERO), &["param-set"]);
    assert_eq!(result, Err(TransferError::UnknownParam { name: name("NOT_A_PARAM"), told: true }));
}
