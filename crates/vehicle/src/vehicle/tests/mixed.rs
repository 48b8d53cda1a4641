//! A mission that may be a mixture of two: it is known as one after an upload was cut off wherever it was, by us or by another
//! station, through restarts of the vehicle and of the program, and nothing flies it; what is not known is read by itself; and
//! a plane that flies to somewhere else is told.

use std::sync::Arc;

use vencejo_flight::checks::CheckContext;
use vencejo_flight::plan::{Mission, items_to_wire};
use vencejo_proto::dialect::{
    MISSION_CLEAR_ALL_DATA, MISSION_SET_CURRENT_DATA, MavMissionType, MavModeFlag, SET_MODE_DATA,
};
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};
use vencejo_proto::plan_file::decode_plan_file;
use vencejo_proto::{ComponentId, MissionItemInt, SystemId};

use super::*;
use crate::plan_record::{Doubt, PlanRecord, StoredRecord, VehicleKey, Writer};
use crate::plan_state::hash_items;
use crate::transfer::testing::seeds;
use crate::vehicle::FlightParameters;

pub(super) const MISSION: PlanKind = PlanKind::Mission;

pub(super) fn route(count: usize, north_deg: f64) -> Vec<MissionItem> {
    (0..count).map(|index| MissionItem::waypoint(40.33 + north_deg, -3.8 + index as f64 * 1e-3, 80.0)).collect()
}

pub(super) fn send(items: Vec<MissionItem>) -> Request {
    Request::UploadPlan { kind: MISSION, items, home: None, despite_findings: false }
}

pub(super) fn reading() -> VehicleConfig {
    VehicleConfig { reads_back: true, ..VehicleConfig::default() }
}

pub(super) fn world(config: VehicleConfig) -> Pair {
    let mut plane = Plane::new();
    plane.services.has_ftp = false;
    let mut world = World::new(Station::with(config), plane, Faults::default(), 1);
    wait(&mut world, 2_000);
    world
}

pub(super) fn state(world: &Pair) -> PlanState {
    world.station.vehicle.plan_state(MISSION)
}

fn long(command: u16, params: [f32; 2]) -> CommandLong {
    let [p1, p2] = params;
    CommandLong { target: Address::new(0, 0), command, confirmation: 0, params: [p1, p2, 0.0, 0.0, 0.0, 0.0, 0.0] }
}

/// Every request and message that arms, follows the mission or jumps in it.
fn acts() -> (Vec<Request>, Vec<Message>) {
    let raw = [(400, [1.0, 21_196.0]), (176, [1.0, 10.0]), (300, [0.0; 2]), (224, [2.0, 0.0]), (189, [0.0; 2])];
    let int = |command, [p1, p2]: [f32; 2]| CommandInt {
        target: Address::new(0, 0),
        frame: 0,
        command,
        current: 0,
        autocontinue: 0,
        params: [p1, p2, 0.0, 0.0],
        x: 0,
        y: 0,
        z: 0.0,
    };
    let mut requests = vec![
        ARM,
        Request::Arm { force: true },
        mode("auto"),
        Request::SetMode { mode: ModeChoice::Custom(10) },
        Request::MissionStart { from_item: None },
        Request::MissionStart { from_item: Some(2) },
        Request::MissionResume,
        Request::SetCurrentItem { item: 2 },
    ];
    let mut messages = vec![
        Message::Dialect(MavMessage::SET_MODE(SET_MODE_DATA {
            custom_mode: 10,
            target_system: 1,
            base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        })),
        Message::Dialect(MavMessage::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA {
            seq: 2,
            target_system: 1,
            target_component: 1,
        })),
    ];
    for (command, params) in raw {
        requests.push(Request::RawCommandLong(long(command, params)));
        requests.push(Request::RawCommandInt(int(command, params)));
        messages.push(Message::CommandLong(CommandLong { target: PLANE, ..long(command, params) }));
    }
    (requests, messages)
}

/// Whether all of them are refused, with the reason.
pub(super) fn assert_blocked(vehicle: &mut Vehicle, now: MonoTime, when: &str) {
    let (requests, messages) = acts();
    while vehicle.poll_output().is_some() {}
    let is_known = vehicle.telemetry().autopilot_type().is_some();
    for request in requests {
        // Before its first heartbeat neither modes nor numbers of items are known, and requests that need them are refused for that.
        if !is_known && !matches!(request, Request::Arm { .. } | Request::RawCommandLong(_)) {
            continue;
        }
        let id = vehicle.request(request.clone(), now);
        let outputs: Vec<_> = std::iter::from_fn(|| vehicle.poll_output()).collect();
        let [Output::Finished { id: ended, result: Err(VehicleError::PlanUnknown { state, .. }) }] = &outputs[..]
        else {
            panic!("{when}: {request:?}: {outputs:?}");
        };
        assert!(*ended == id && state.may_be_mixed(), "{when}: {request:?}");
    }
    for message in messages {
        let error = vehicle.on_sending(&message, false, now).expect_err("held back");
        assert!(error.to_string().contains("despite_mixed_plan"), "{when}: {error}");
    }
    // What makes it safe stays possible.
    for request in [mode("rtl"), Request::Disarm { force: false }] {
        let id = vehicle.request(request.clone(), now);
        let outputs: Vec<_> = std::iter::from_fn(|| vehicle.poll_output()).collect();
        vehicle.cancel(id, now);
        while vehicle.poll_output().is_some() {}
        let sent = outputs.iter().any(|output| matches!(output, Output::Send(_)));
        assert!(sent || !is_known, "{when}: {request:?}: {outputs:?}");
    }
}

/// The same vehicle in a new run of the program, which remembers `stored`.
fn again(world: &Pair, stored: &[StoredRecord], config: VehicleConfig) -> Vehicle {
    let mut vehicle = Vehicle::new(PLANE, STATION, config, world.now);
    vehicle.on_records(stored.to_vec(), world.now);
    vehicle
}

// fault 17: cut after each of 0 to 50 items: arming, AUTO and jumps refused in all their forms, also after restarts of the vehicle and of ours
#[test]
fn an_upload_cut_at_any_item_blocks_until_a_whole_mission_is_there() {
    let (old, new) = (route(30, 0.0), route(50, 0.02));
    let mut outcomes = BTreeMap::new();
    for k in 0..=50 {
        let mut world = world(VehicleConfig { keeps_records: true, ..reading() });
        ask(&mut world, send(old.clone())).expect("the mission before");
        let before = state(&world);
        wait(&mut world, 6_000);
        // MISSION_COUNT, then k items, reach it.
        world.log = Some(Vec::new());
        world.faults.cut_after = Some(world.station_frames + 1 + k);
        ask(&mut world, send(new.clone())).expect_err("cut off");
        assert!(state(&world).may_be_mixed(), "{k}");
        let now = world.now;
        assert_blocked(&mut world.station.vehicle, now, "cut off");
        // Another run of the program knows it from the first moment on, before anything was heard.
        let kept: Vec<_> = world.station.kept.values().cloned().collect();
        let mut next = again(&world, &kept, reading());
        assert_blocked(&mut next, now, "next run");
        // The vehicle restarts, and is reached again: what is there is read by itself.
        world.plane.reboot(now);
        world.faults.cut_after = None;
        world.run(now + Duration::from_secs(5), |station, _| station.events.contains(&VehicleEvent::Rebooted));
        assert!(state(&world).may_be_mixed(), "{k}: {} after its restart", state(&world));
        let now = world.now;
        let is_read = |station: &mut Station, _: &mut Plane| {
            !matches!(station.vehicle.plan_state(MISSION), PlanState::Unknown(_))
        };
        assert!(world.run(now + Duration::from_secs(60), is_read), "{k}: read by itself");
        let on_board = &world.plane.services.plans[0][1..];
        let hash = hash_items(on_board);
        let is_whole =
            Some(hash) == before.hash() || on_board.len() == 50 && on_board.iter().all(|item| item.x > 403_400_000);
        let expected = match is_whole {
            true => PlanState::Verified { count: on_board.len() as u16, hash },
            false => PlanState::Differs { count: on_board.len() as u16, hash },
        };
        assert_eq!(state(&world), expected, "{k}");
        *outcomes.entry(is_whole).or_insert(0) += 1;
        let now = world.now;
        if is_whole {
            assert!(ask(&mut world, ARM).is_ok());
            continue;
        }
        assert_blocked(&mut world.station.vehicle, now, "read, and neither");
        wait(&mut world, 2_000);
        ask(&mut world, Request::DownloadPlan { kind: MISSION }).expect("read");
        let now = world.now;
        assert_blocked(&mut world.station.vehicle, now, "looked at");
        ask(&mut world, send(new.clone())).expect("sent whole");
        assert!(ask(&mut world, ARM).is_ok(), "{k}");
    }
    assert!(outcomes[&false] >= 48, "{outcomes:?}");
}

#[test]
fn how_a_plane_flies_is_read_once_and_again_after_its_restart() {
    let mut world = world(reading());
    let asked = |world: &mut Pair| {
        let log = world.log.replace(Vec::new()).unwrap_or_default();
        let names = log.into_iter().filter_map(|(_, message)| match message {
            Message::Dialect(MavMessage::PARAM_REQUEST_READ(request)) => {
                request.param_id.to_str().ok().map(str::to_owned)
            }
            _ => None,
        });
        names.collect::<Vec<_>>()
    };
    wait(&mut world, 60_000);
    let known = world.station.vehicle.flight_parameters();
    assert_eq!((known.loiter_radius_m, known.airspeed_m_s, known.finds_landing), (Some(80.0), None, None));
    asked(&mut world);
    wait(&mut world, 60_000);
    assert_eq!(asked(&mut world), [""; 0], "what it does not answer is left alone");

    world.plane.services.params[1].value = ParamValue::F32(-95.0);
    let now = world.now;
    world.plane.reboot(now);
    wait(&mut world, 60_000);
    assert_eq!(world.station.vehicle.flight_parameters().loiter_radius_m, Some(-95.0), "anticlockwise");
    let mut read_m = |value| {
        let name = ParamName::new("WP_LOITER_RAD").expect("a name");
        world.station.vehicle.learn(&Param::new(name, ParamValue::F32(value)));
        world.station.vehicle.flight_parameters().loiter_radius_m
    };
    assert_eq!([read_m(-1.0), read_m(0.0), read_m(-2.0)], [Some(-60.0), Some(60.0), Some(-2.0)], "as it flies them");
    let names = asked(&mut world);
    assert_eq!(names.iter().filter(|name| *name == "WP_LOITER_RAD").count(), 1, "{names:?}");
    assert!(names.iter().any(|name| name == "RTL_AUTOLAND"), "{names:?}");
}

#[test]
fn a_computer_on_board_reads_whose_heartbeats_are_counted() {
    let mut plane = Plane::new();
    plane.services.has_ftp = false;
    let name = ParamName::new("SYSID_MYGCS").expect("a name");
    plane.services.params.push(Param::new(name, ParamValue::F32(252.0)));
    let us = Address { component: ComponentId::ONBOARD_COMPUTER, ..PLANE };
    let vehicle = Vehicle::new(PLANE, us, reading(), MonoTime::ZERO);
    let mut world = World::new(Station { vehicle, ..Station::with(reading()) }, plane, Faults::default(), 1);
    wait(&mut world, 60_000);
    assert_eq!(world.station.vehicle.counted_station(), Some(SystemId(252)), "by its name of before 4.7");
    assert_eq!(world.station.vehicle.flight_parameters().loiter_radius_m, Some(80.0), "and then the others");
}

#[test]
fn an_override_goes_through_and_is_written_down() {
    let mut world = world(VehicleConfig::default());
    world.faults.cut_after = Some(world.station_frames + 4);
    ask(&mut world, upload()).expect_err("cut off");
    world.faults.cut_after = None;
    wait(&mut world, 9_000);
    assert!(ask(&mut world, ARM).is_err());
    ask(&mut world, Request::DespiteMixedPlan(Box::new(ARM))).expect("armed");
    let texts: Vec<_> = world.station.vehicle.texts().iter().map(|text| text.text.clone()).collect();
    assert!(
        texts.iter().any(|text| text.starts_with("arming by override, although the mission on board is")),
        "{texts:?}"
    );
    let jump = acts().1[1].clone();
    let now = world.now;
    assert!(world.station.vehicle.on_sending(&jump, true, now).is_ok());
    assert!(world.station.vehicle.on_sending(&jump, false, now).is_err(), "each by itself");
}

#[test]
fn no_flight_is_prepared_with_a_mission_that_may_be_mixed() {
    let mut world = world(VehicleConfig::default());
    ask(&mut world, upload()).expect("the flight before");
    (world.plane.mode, world.plane.current) = (10, 4);
    world.faults.cut_after = Some(world.station_frames + 4);
    ask(&mut world, upload()).expect_err("cut off");
    world.faults.cut_after = None;
    wait(&mut world, 9_000);
    let before = world.plane.commands.len();
    let error = ask(&mut world, Request::PrepareFlight).expect_err("its steps end at the beginning of a mission");
    assert!(matches!(error, VehicleError::PlanUnknown { state, .. } if state.may_be_mixed()), "{error}");
    assert_eq!(super::acts(&world, before), [], "not a part of it either");
    ask(&mut world, Request::DespiteMixedPlan(Box::new(Request::PrepareFlight))).expect("by override");
    assert_eq!((world.plane.mode, world.plane.current, world.plane.is_armed), (0, 1, false));
    // It opens nothing: what comes after it is held back as before.
    assert!(matches!(ask(&mut world, ARM), Err(VehicleError::PlanUnknown { .. })));
}

#[test]
fn nothing_of_an_upload_goes_out_before_it_is_written_down() {
    let mut world = world(VehicleConfig { keeps_records: true, ..VehicleConfig::default() });
    world.station.answers_keep = false;
    world.log = Some(Vec::new());
    let id = start(&mut world, upload());
    wait(&mut world, 1_000);
    let is_upload = |message: &Message| matches!(message, Message::Dialect(MavMessage::MISSION_COUNT(_)));
    let sent =
        |world: &Pair| world.log.as_ref().expect("logged").iter().filter(|(_, message)| is_upload(message)).count();
    assert_eq!(sent(&world), 0);
    assert!(state(&world).may_be_mixed());
    let busy = ask(&mut world, Request::DownloadPlan { kind: MISSION }).expect_err("busy");
    assert_eq!(busy, VehicleError::TransferBusy { running: "plan upload" });
    let (now, ticket) = (world.now, *world.station.kept.keys().max().expect("kept"));
    world.station.vehicle.on_kept(ticket, now);
    end(&mut world, id, 30).expect("uploaded");
    assert_eq!(sent(&world), 1);
    // The record of its end, and a disk that answers no more: it goes on by itself.
    let record = world.station.kept.last_key_value().expect("kept").1.record.clone();
    assert!(record.doubt.is_none() && record.verified.is_some_and(|(count, _)| count == 4), "{record:?}");
    ask(&mut world, upload()).expect("uploaded without the disk");
    // Given up before it began: as it was.
    let known = state(&world);
    let id = start(&mut world, send(route(7, 0.1)));
    let now = world.now;
    world.station.vehicle.cancel(id, now);
    assert_eq!(end(&mut world, id, 5), Err(VehicleError::Cancelled));
    wait(&mut world, 100);
    assert!(!state(&world).may_be_mixed(), "{} was {known}", state(&world));
}

#[test]
fn a_record_goes_with_the_hardware_and_not_with_the_system_id() {
    let doubted = |key: VehicleKey| {
        let doubt = Doubt { writer: Writer::Us, sent: None, before: None };
        StoredRecord { key, system: Some(SystemId(1)), record: PlanRecord { verified: None, doubt: Some(doubt) } }
    };
    let version = |vehicle: &mut Vehicle, uid, now| {
        let data = AUTOPILOT_VERSION_DATA { uid, ..Default::default() };
        vehicle.on_message(PLANE.component, &Message::Dialect(MavMessage::AUTOPILOT_VERSION(data)), now);
    };
    let now = MonoTime::from_millis(5);
    let key = VehicleKey::parse("uid-000000000000002a").expect("a key");
    for (uid, stays) in [(0x2a, true), (0x2b, false)] {
        let mut vehicle = Vehicle::new(PLANE, STATION, reading(), MonoTime::ZERO);
        vehicle.on_records(vec![doubted(key.clone())], MonoTime::ZERO);
        assert!(vehicle.plan_state(MISSION).may_be_mixed(), "until it is known who it is");
        version(&mut vehicle, uid, now);
        assert_eq!(vehicle.plan_state(MISSION).may_be_mixed(), stays, "{uid}");
    }
    // Another vehicle of the folder is nobody's business.
    let mut vehicle = Vehicle::new(PLANE, STATION, reading(), MonoTime::ZERO);
    vehicle.on_records(vec![StoredRecord { system: Some(SystemId(9)), ..doubted(key.clone()) }], MonoTime::ZERO);
    assert!(!vehicle.plan_state(MISSION).may_be_mixed());
    // What this run sees before it is known who it is stays, whoever that is.
    let mut vehicle = Vehicle::new(PLANE, STATION, reading(), MonoTime::ZERO);
    vehicle.on_records(vec![doubted(key.clone())], MonoTime::ZERO);
    vehicle.on_sending(&rival_count(9), false, now).expect("sent");
    version(&mut vehicle, 0x2b, now);
    assert!(vehicle.plan_state(MISSION).may_be_mixed(), "an upload that began in this run");
    // A PX4 tells both ids in MAVLink 2, and in MAVLink 1 the shorter alone.
    let config = VehicleConfig { keeps_records: true, ..reading() };
    let mut vehicle = Vehicle::new(PLANE, STATION, config, MonoTime::ZERO);
    vehicle.on_records(vec![], MonoTime::ZERO);
    let mut tell = |uid, first: Option<u8>, ms| {
        let mut uid2 = [0; 18];
        uid2[0] = first.unwrap_or_default();
        let data = AUTOPILOT_VERSION_DATA { uid, uid2, ..Default::default() };
        let message = Message::Dialect(MavMessage::AUTOPILOT_VERSION(data));
        vehicle.on_time(MonoTime::from_millis(ms));
        vehicle.on_message(PLANE.component, &message, MonoTime::from_millis(ms));
        if ms == 0 {
            vehicle.on_sending(&rival_count(9), false, now).expect("sent");
        }
        let (mut kept, mut restarts) = (Vec::new(), 0);
        while let Some(output) = vehicle.poll_output() {
            match output {
                Output::Keep { stored, .. } => {
                    kept.push(format!("{}: {}", stored.key, stored.record.doubt.is_some()));
                }
                Output::Event(VehicleEvent::Rebooted) => restarts += 1,
                _ => {}
            }
        }
        (kept, restarts, vehicle.plan_state(MISSION).may_be_mixed())
    };
    let short = "uid-0000000000000007";
    assert_eq!(tell(7, None, 0), (vec![format!("{short}: true")], 0, true));
    let renamed = vec![format!("{short}: false"), "uid2-09: true".to_owned()];
    assert_eq!(tell(7, Some(9), 10_000), (renamed, 0, true), "the same one");
    assert_eq!(tell(7, None, 20_000), (vec![], 0, true), "once more in MAVLink 1");
    assert_eq!(tell(7, Some(9), 30_000), (vec![], 0, true));
    assert_eq!(tell(7, Some(8), 40_000), (vec![], 1, false), "another of the same batch");
    assert_eq!(tell(6, None, 50_000), (vec![], 1, false), "and one more");
    // A damaged one may be anybody's until they tell who they are.
    for (uid, stays) in [(0x2a, true), (0x2b, false)] {
        let mut vehicle = Vehicle::new(PLANE, STATION, reading(), MonoTime::ZERO);
        let stored = StoredRecord { key: key.clone(), system: None, record: PlanRecord::damaged() };
        vehicle.on_records(vec![stored], MonoTime::ZERO);
        assert_eq!(vehicle.plan_state(MISSION), PlanState::Unknown(Unknown::RecordDamaged));
        assert_blocked(&mut vehicle, MonoTime::ZERO, "damaged record");
        version(&mut vehicle, uid, now);
        assert_eq!(vehicle.plan_state(MISSION).may_be_mixed(), stays, "{uid}");
    }
}

#[test]
fn another_vehicle_in_the_place_of_one_takes_over_nothing_of_it() {
    let version = |vehicle: &mut Vehicle, uid, now| {
        let data = AUTOPILOT_VERSION_DATA { uid, ..Default::default() };
        vehicle.on_message(PLANE.component, &Message::Dialect(MavMessage::AUTOPILOT_VERSION(data)), now);
    };
    let kept = |vehicle: &mut Vehicle| {
        let outputs = std::iter::from_fn(|| vehicle.poll_output());
        let kept = outputs.filter_map(|output| match output {
            Output::Keep { stored, .. } => Some((stored.key.as_str().to_owned(), stored.record.doubt.is_some())),
            _ => None,
        });
        kept.collect::<Vec<_>>()
    };
    let (one, other) = ("uid-000000000000002a".to_owned(), "uid-000000000000002b".to_owned());
    for keeps_records in [true, false] {
        let config = VehicleConfig { keeps_records, ..reading() };
        let mut vehicle = Vehicle::new(PLANE, STATION, config, MonoTime::ZERO);
        vehicle.on_records(vec![], MonoTime::ZERO);
        version(&mut vehicle, 0x2a, MonoTime::from_millis(5));
        for (name, value) in [("WP_LOITER_RAD", 95.0), ("ROLL_LIMIT_DEG", 55.0)] {
            let name = ParamName::new(name).expect("a name");
            vehicle.learn(&Param::new(name, ParamValue::F32(value)));
        }
        vehicle.on_sending(&rival_count(9), false, MonoTime::from_millis(6)).expect("sent");
        assert!(vehicle.plan_state(MISSION).may_be_mixed());
        assert_eq!(kept(&mut vehicle), if keeps_records { vec![(one.clone(), true)] } else { vec![] });

        // Its battery is taken out, and another one with the same system id is switched on.
        vehicle.on_restart(MonoTime::from_millis(20_000), MonoTime::from_millis(20_000));
        assert!(vehicle.plan_state(MISSION).may_be_mixed(), "it may be the same");
        version(&mut vehicle, 0x2b, MonoTime::from_millis(21_000));
        assert_eq!(vehicle.plan_state(MISSION), PlanState::Unknown(Unknown::NeverRead));
        assert_eq!(kept(&mut vehicle), [], "nothing of the other's is written down, and its doubt stays");
        assert_eq!(vehicle.flight_parameters(), FlightParameters::default());
        assert!(vehicle.parameters().is_empty());
        assert_eq!(vehicle.check_context().bank_deg, CheckContext::default().bank_deg);
        version(&mut vehicle, 0x2b, MonoTime::from_millis(22_000));
        version(&mut vehicle, 0, MonoTime::from_millis(22_000));
        assert_eq!(vehicle.plan_state(MISSION), PlanState::Unknown(Unknown::NeverRead), "still the same");

        // The first comes back, and restarts as itself.
        version(&mut vehicle, 0x2a, MonoTime::from_millis(40_000));
        assert!(vehicle.plan_state(MISSION).may_be_mixed(), "{}", vehicle.plan_state(MISSION));
        vehicle.on_restart(MonoTime::from_millis(60_000), MonoTime::from_millis(60_000));
        version(&mut vehicle, 0x2a, MonoTime::from_millis(61_000));
        assert!(vehicle.plan_state(MISSION).may_be_mixed(), "{}", vehicle.plan_state(MISSION));

        // What begins before the other tells who it is, is the other's, however late it tells that.
        for (now, third, late_ms) in [(80_000, 0x2c, 1_000), (180_000, 0x2d, 4_000)] {
            version(&mut vehicle, 0x2b, MonoTime::from_millis(now));
            let restarted = MonoTime::from_millis(now + 10_000);
            vehicle.on_restart(restarted, restarted);
            vehicle.on_sending(&rival_count(9), false, restarted).expect("sent");
            kept(&mut vehicle);
            version(&mut vehicle, third, restarted + Duration::from_millis(late_ms));
            assert!(vehicle.plan_state(MISSION).may_be_mixed(), "{}", vehicle.plan_state(MISSION));
            let third = other.replace("2b", &format!("{third:x}"));
            let expected = vec![(other.clone(), false), (third, true)];
            assert_eq!(kept(&mut vehicle), if keeps_records { expected } else { vec![] }, "and no more the first's");
        }
        // What ended before a silence is not, though no restart was noticed.
        vehicle.on_sending(&rival_count(9), false, MonoTime::from_millis(200_000)).expect("sent");
        vehicle.on_time(MonoTime::from_millis(220_000));
        version(&mut vehicle, 0x2e, MonoTime::from_millis(220_001));
        assert_eq!(vehicle.plan_state(MISSION), PlanState::Unknown(Unknown::NeverRead));
    }
}

// It was taken for the one before: nothing went back, and nothing was missing.
#[test]
fn another_vehicle_that_has_been_on_for_longer_is_asked_who_it_is() {
    for (silence_s, is_older) in [(3, true), (8, false)] {
        let mut plane = Plane::new();
        (plane.services.has_ftp, plane.uid) = (false, 0x2a);
        let mut world = World::new(Station::with(reading()), plane, Faults::default(), 1);
        wait(&mut world, 2_000);
        ask(&mut world, send(route(8, 0.0))).expect("uploaded");
        wait(&mut world, 20_000);
        let now = world.now;
        world.plane.reboot(now);
        wait(&mut world, 20_000);
        let before = state(&world);
        assert!(matches!(before, PlanState::Verified { count: 8, .. }), "{before}");

        // Its cable goes to another one with the same system id and as many items.
        let now = world.now;
        world.faults.blackouts = vec![(now, now + Duration::from_secs(silence_s))];
        world.plane.uid = 0x2b;
        if is_older {
            world.plane.booted = MonoTime::ZERO;
        }
        world.plane.services.plans[0].iter_mut().for_each(|item| item.x += 10_000);
        wait(&mut world, silence_s * 1_000 + 20_000);
        let hash = hash_items(&world.plane.services.plans[0][1..]);
        assert_eq!(state(&world), PlanState::Verified { count: 8, hash }, "after {silence_s} s");
    }
}

// Another aircraft on the same radio, whose mission was whole, was called mixed, and the doubt about the first one's ended.
#[test]
fn a_mission_that_is_read_is_judged_for_the_aircraft_that_it_is_of() {
    let version = |world: &mut Pair, uid| {
        let data = AUTOPILOT_VERSION_DATA { uid, ..Default::default() };
        world.inject(world.now, true, PLANE, &Message::Dialect(MavMessage::AUTOPILOT_VERSION(data)));
        wait(world, 100);
    };
    let sent = route(30, 0.02);
    let last_kept = |world: &Pair, uid: &str| {
        let mut of_it = world.station.kept.values().filter(|stored| stored.key.as_str().ends_with(uid));
        of_it.next_back().map(|stored| stored.record.clone()).expect("kept")
    };
    // What the other one has: a mission of its own, or the same that was sent to the first.
    for (theirs, tells) in [(route(8, 0.1), true), (sent.clone(), true), (route(8, 0.1), false)] {
        let case = format!("{} items, it tells who it is: {tells}", theirs.len());
        let config = VehicleConfig { keeps_records: true, ..VehicleConfig::default() };
        let mut world = world(config);
        version(&mut world, 0x2a);
        world.faults.cut_after = Some(world.station_frames + 9);
        ask(&mut world, send(sent.clone())).expect_err("cut off");
        world.faults.cut_after = None;
        let doubt = last_kept(&world, "2a").doubt;
        assert!(doubt.is_some());
        // It is switched off, and the other one on. It does not tell by itself who it is.
        world.plane.services.store(MISSION, &rival_wire(&theirs));
        world.plane.unknown.push(Command::REQUEST_MESSAGE);
        let now = world.now;
        world.plane.reboot(now);
        let is_back = |station: &mut Station, _: &mut Plane| {
            station.events.contains(&VehicleEvent::Rebooted) && station.vehicle.telemetry().heartbeat.is_some()
        };
        assert!(world.run(now + Duration::from_secs(10), is_back), "{case}");
        let id = start(&mut world, Request::DownloadPlan { kind: MISSION });
        wait(&mut world, 1_000);
        assert_eq!(world.station.results.get(&id), None, "{case}: not known whose it is");
        if tells {
            version(&mut world, 0x2b);
        }
        let reply = end(&mut world, id, 5);
        let Ok(Reply::Plan { state: told, .. }) = reply else { panic!("{case}: {reply:?}") };
        // One that does not tell may be the first.
        assert_eq!(told.may_be_mixed(), !tells, "{case}: {told}");
        assert_eq!(state(&world), told, "{case}");
        assert_eq!(last_kept(&world, "2a").doubt, doubt, "{case}: it is still the first one's");
        let now = world.now + Duration::from_secs(5);
        world.station.vehicle.on_restart(now, now);
        version(&mut world, 0x2a);
        assert!(state(&world).may_be_mixed(), "{case}: it comes back");
    }
}

#[test]
fn a_damaged_record_is_a_doubt_that_an_upload_ends_and_a_reading_does_not() {
    let mut world = world(VehicleConfig { keeps_records: true, ..reading() });
    ask(&mut world, send(route(8, 0.0))).expect("a mission");
    let key = world.station.kept.values().next_back().expect("kept").key.clone();
    let config = VehicleConfig { keeps_records: true, ..reading() };
    let plane = std::mem::replace(&mut world.plane, Plane::new());
    let mut world = World::new(Station::with(config), plane, Faults::default(), 1);
    let damaged = StoredRecord { system: key.system(), key, record: PlanRecord::damaged() };
    world.station.vehicle.on_records(vec![damaged], MonoTime::ZERO);
    assert_eq!(state(&world), PlanState::Unknown(Unknown::RecordDamaged));
    wait(&mut world, 20_000);
    assert!(matches!(state(&world), PlanState::Differs { count: 8, .. }), "{}", state(&world));
    ask(&mut world, Request::DownloadPlan { kind: MISSION }).expect("read");
    let now = world.now;
    assert_blocked(&mut world.station.vehicle, now, "read");
    ask(&mut world, send(route(8, 0.0))).expect("sent anew");
    assert!(ask(&mut world, ARM).is_ok());
    let record = world.station.kept.last_key_value().expect("kept").1.record.clone();
    assert!(record.doubt.is_none() && record.verified.is_some_and(|(count, _)| count == 8), "{record:?}");
}

// ArduPlane takes a file that was left open when its session has been idle for 20 s.
#[test]
fn what_our_failed_upload_leaves_behind_is_not_said_to_be_another_stations() {
    let is_of_another = |event: &VehicleEvent| {
        let VehicleEvent::PlanStateChanged { state, .. } = event else { return false };
        matches!(state, PlanState::Unknown(Unknown::ChangedElsewhere | Unknown::SentElsewhere))
    };
    let mut taken_late = 0;
    // The link is lost after each frame of the upload in turn.
    for frames in 0.. {
        let mut plane = Plane::new();
        plane.services = MockPlane::with_several_sessions();
        let mut world = World::new(Station::with(reading()), plane, Faults::default(), 1);
        wait(&mut world, 2_000);
        ask(&mut world, send(route(8, 0.0))).expect("a mission");
        wait(&mut world, 6_000);
        world.faults.cut_after = Some(world.station_frames + frames);
        if ask(&mut world, send(route(12, 0.03))).is_ok() {
            break;
        }
        assert_eq!(state(&world), PlanState::Unknown(Unknown::TransferFailed), "{frames}");
        world.faults.cut_after = None;
        let changes = world.plane.services.changes;
        wait(&mut world, 40_000);
        assert!(!world.station.events.iter().any(is_of_another), "{frames}: {:?}", world.station.events);
        assert!(matches!(state(&world), PlanState::Verified { count: 8 | 12, .. }), "{frames}: {}", state(&world));
        taken_late += usize::from(world.plane.services.changes > changes);
    }
    assert!(taken_late > 0, "the file that was left open was taken");
}

fn from_rival(world: &mut Pair, message: &Message) {
    let at = world.now + Duration::from_millis(5);
    for to_station in [true, false] {
        world.inject(at, to_station, RIVAL, message);
    }
    wait(world, 100);
}

pub(super) fn rival_wire(items: &[MissionItem]) -> Vec<MissionItemInt> {
    let home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };
    Mission { home: Some(home), items: items.to_vec() }.to_wire(PLANE, true).expect("sendable")
}

pub(super) fn rival_count(count: usize) -> Message {
    let count = count as u16;
    let data = MISSION_COUNT_DATA { count, target_system: 1, target_component: 1, ..Default::default() };
    Message::Dialect(MavMessage::MISSION_COUNT(data))
}

// fault 17: so is one of another station
#[test]
fn a_half_upload_of_another_station_blocks_and_its_end_unblocks() {
    let mut world = world(reading());
    ask(&mut world, send(route(8, 0.0))).expect("ours");
    wait(&mut world, 6_000);
    let wire = rival_wire(&route(12, 0.03));
    from_rival(&mut world, &rival_count(wire.len()));
    assert_eq!(state(&world), PlanState::Unknown(Unknown::SentElsewhere));
    let now = world.now;
    assert_blocked(&mut world.station.vehicle, now, "it begins");
    world.plane.is_armed = true;
    wait(&mut world, 1_500);
    assert!(
        matches!(ask(&mut world, Request::Land), Err(VehicleError::PlanUnknown { .. })),
        "nor is it flown to its landing"
    );
    world.plane.is_armed = false;
    for item in &wire[..5] {
        from_rival(&mut world, &Message::MissionItemInt(*item));
    }
    // It is gone. Its upload rests; what is on board is read, and is neither.
    world.plane.services.reboot();
    wait(&mut world, 20_000);
    assert!(matches!(state(&world), PlanState::Differs { .. }), "{}", state(&world));
    let now = world.now;
    assert_blocked(&mut world.station.vehicle, now, "left half-way");
    // It comes back and ends it.
    from_rival(&mut world, &rival_count(wire.len()));
    for item in &wire {
        from_rival(&mut world, &Message::MissionItemInt(*item));
    }
    wait(&mut world, 8_000);
    assert!(matches!(state(&world), PlanState::Verified { count: 12, .. }), "{}", state(&world));
    assert!(ask(&mut world, ARM).is_ok());
    // One that the vehicle refuses changes nothing.
    from_rival(&mut world, &rival_count(700));
    wait(&mut world, 5_000);
    assert!(matches!(state(&world), PlanState::Verified { count: 12, .. }), "{}", state(&world));
}

#[test]
fn what_others_do_just_after_our_upload_is_no_echo_of_it() {
    let kind = PlanKind::Rally;
    let clear = |mission_type| {
        let data = MISSION_CLEAR_ALL_DATA { target_system: 1, target_component: 1, mission_type };
        vec![Message::Dialect(MavMessage::MISSION_CLEAR_ALL(data))]
    };
    let count = MISSION_COUNT_DATA {
        count: 3,
        target_system: 1,
        target_component: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_RALLY,
        ..Default::default()
    };
    let file = |opcode, path: &[u8]| FtpPayload::request(opcode, 1, 1, 0, path).to_message(PLANE);
    let ack = |target| vec![Message::MissionAck(MissionAck { target, result: 0, mission_type: 2, opaque_id: 0 })];
    let writings = [
        clear(MavMissionType::MAV_MISSION_TYPE_RALLY),
        clear(MavMissionType::MAV_MISSION_TYPE_ALL),
        vec![Message::Dialect(MavMessage::MISSION_COUNT(count))],
        vec![file(FtpOpcode::CREATE_FILE, b"@MISSION/rally.dat"), file(FtpOpcode::TERMINATE_SESSION, b"")],
    ];
    let mut world = world(VehicleConfig::default());
    let rally = MissionItem { command: Command::NAV_RALLY_POINT, ..MissionItem::waypoint(40.3432, -3.7978, 80.0) };
    let upload = Request::UploadPlan { kind, items: vec![rally], home: None, despite_findings: false };
    for messages in writings {
        ask(&mut world, upload.clone()).expect("uploaded");
        let now = world.now;
        let vehicle = &mut world.station.vehicle;
        for message in ack(STATION) {
            vehicle.on_message(PLANE.component, &message, now);
        }
        assert!(matches!(vehicle.plan_state(kind), PlanState::Verified { .. }), "an echo");
        for message in &messages {
            vehicle.on_foreign(RIVAL, message, now);
        }
        assert_eq!(vehicle.plan_state(kind), PlanState::Unknown(Unknown::ChangedElsewhere), "{messages:?}");
        assert!(vehicle.plan_on_board(kind).is_none(), "{messages:?}");
    }
    // Its word to another alone may be one from before: the list is read once more when no echo can come any more.
    let mut quiet = self::world(reading());
    ask(&mut quiet, upload.clone()).expect("uploaded");
    let now = quiet.now;
    for message in ack(RIVAL) {
        quiet.station.vehicle.on_message(PLANE.component, &message, now);
    }
    quiet.plane.services.plans[kind as usize].clear();
    wait(&mut quiet, 4_000);
    assert!(matches!(quiet.station.vehicle.plan_state(kind), PlanState::Verified { .. }), "as it was");
    wait(&mut quiet, 4_000);
    assert_eq!(quiet.station.vehicle.plan_state(kind), PlanState::Empty);
    // Also where that reading makes room for a request.
    ask(&mut quiet, upload.clone()).expect("uploaded");
    let now = quiet.now;
    for message in ack(RIVAL) {
        quiet.station.vehicle.on_message(PLANE.component, &message, now);
    }
    quiet.plane.services.plans[kind as usize].clear();
    let is_read = |station: &mut Station, _: &mut Plane| station.vehicle.transfer.is_some();
    assert!(quiet.run(now + Duration::from_secs(10), is_read), "it is read once more");
    ask(&mut quiet, Request::ParamList).expect("listed");
    assert!(matches!(quiet.station.vehicle.plan_state(kind), PlanState::Verified { .. }), "not read yet");
    wait(&mut quiet, 4_000);
    assert_eq!(quiet.station.vehicle.plan_state(kind), PlanState::Empty);
    // And where the other's upload ends while ours is read back.
    let id = start(&mut quiet, upload.clone());
    let is_written = |station: &mut Station, _: &mut Plane| {
        station.vehicle.transfer.as_ref().is_some_and(|lane| lane.machine.written(0).is_some())
    };
    let now = quiet.now;
    assert!(quiet.run(now + Duration::from_secs(10), is_written), "written");
    let now = quiet.now;
    for message in ack(RIVAL) {
        quiet.station.vehicle.on_message(PLANE.component, &message, now);
    }
    end(&mut quiet, id, 10).expect("as sent");
    quiet.plane.services.plans[kind as usize].clear();
    wait(&mut quiet, 9_000);
    assert_eq!(quiet.station.vehicle.plan_state(kind), PlanState::Empty);
    // Nor is what the vehicle says of it afterwards.
    ask(&mut world, upload).expect("uploaded");
    let now = world.now;
    let vehicle = &mut world.station.vehicle;
    for message in clear(MavMissionType::MAV_MISSION_TYPE_RALLY) {
        vehicle.on_sending(&message, false, now).expect("sent");
    }
    vehicle.set_plan(kind, PlanState::Empty);
    for message in ack(STATION) {
        vehicle.on_message(PLANE.component, &message, now);
    }
    assert_eq!(vehicle.plan_state(kind), PlanState::Unknown(Unknown::ChangedElsewhere));
}

// The first MISSION_CURRENT after it was taken for another station's upload.
#[test]
fn the_number_of_items_that_was_just_verified_is_no_other_upload() {
    let config = VehicleConfig { streams: StreamConfig::listen_only(), ..VehicleConfig::default() };
    let mut world = world(config);
    let told = |world: &mut Pair, total| {
        let mission_state = MissionState::MISSION_STATE_ACTIVE;
        let current = MISSION_CURRENT_DATA { total, mission_state, ..Default::default() };
        world.inject(world.now, true, PLANE, &Message::Dialect(MavMessage::MISSION_CURRENT(current)));
        wait(world, 100);
    };
    told(&mut world, 0);
    ask(&mut world, send(route(8, 0.0))).expect("ours");
    let ours = state(&world);
    wait(&mut world, 6_000);
    told(&mut world, 8);
    assert_eq!(state(&world), ours);
    told(&mut world, 7);
    assert!(state(&world).may_be_mixed(), "{}", state(&world));
}

#[test]
fn the_same_number_of_items_on_board_that_moves_is_an_upload() {
    let mut world = world(reading());
    ask(&mut world, send(route(8, 0.0))).expect("ours");
    wait(&mut world, 6_000);
    // Over a link that we do not hear: only the number of items moves.
    for item in rival_wire(&route(20, 0.05)).into_iter().skip(9) {
        world.plane.services.plans[0].push(item);
        wait(&mut world, 300);
        assert_eq!(state(&world), PlanState::Unknown(Unknown::SentElsewhere));
    }
    let now = world.now;
    assert_blocked(&mut world.station.vehicle, now, "it moves");
    wait(&mut world, 8_000);
    assert!(matches!(state(&world), PlanState::Verified { count: 20, .. }), "{}", state(&world));
}

#[test]
fn what_is_not_known_is_read_by_itself_and_gives_way() {
    let mut world = world(reading());
    world.plane.services.store(MISSION, &rival_wire(&route(60, 0.0)));
    wait(&mut world, 12_000);
    let known = state(&world);
    assert!(matches!(known, PlanState::Verified { count: 60, .. }), "{known}");
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Fence), PlanState::Empty);
    assert!(world.station.results.is_empty(), "nobody asked");
    world.log = Some(Vec::new());
    wait(&mut world, 60_000);
    let asks =
        |(_, message): &(MonoTime, Message)| matches!(message, Message::Dialect(MavMessage::MISSION_REQUEST_LIST(_)));
    assert_eq!(world.log.as_ref().expect("logged").iter().filter(|entry| asks(entry)).count(), 0, "once");

    // A restart; who asks for the mission while it is read joins, and who wants another transfer goes before.
    let restart = |world: &mut Pair| {
        // Two restarts within a few seconds are one.
        wait(world, 6_000);
        let now = world.now;
        world.plane.reboot(now);
        world.station.events.clear();
        world.faults.bytes_per_s = Some(6_000.0);
        let is_reading = |station: &mut Station, _: &mut Plane| {
            station.events.contains(&VehicleEvent::Rebooted) && station.vehicle.transfer.is_some()
        };
        assert!(world.run(now + Duration::from_secs(60), is_reading), "it is read again");
    };
    restart(&mut world);
    let reply = ask(&mut world, Request::DownloadPlan { kind: MISSION }).expect("joined");
    assert!(matches!(reply, Reply::Plan { ref items, state, .. } if items.len() == 60 && state == known), "{reply:?}");
    restart(&mut world);
    let reply = ask(&mut world, Request::ParamRead { name: "WP_LOITER_RAD".into() });
    assert!(reply.is_ok(), "{reply:?}");
    let began = world.now;
    ask(&mut world, Request::UploadPlan { kind: PlanKind::Rally, items: vec![], home: None, despite_findings: false })
        .expect("before it");
    assert!(world.now.since(began) < Duration::from_secs(5), "{:?}", world.now.since(began));
    world.faults.bytes_per_s = None;
    wait(&mut world, 20_000);
    assert_eq!(state(&world), known, "read in the end");
    assert_eq!(world.station.results.len(), 3, "one for each that asked");
}

#[test]
fn a_fence_and_rally_points_sent_over_another_link_are_read() {
    for (kind, total, item) in [
        (PlanKind::Fence, "FENCE_TOTAL", Command::NAV_FENCE_CIRCLE_INCLUSION),
        (PlanKind::Rally, "RALLY_TOTAL", Command::NAV_RALLY_POINT),
    ] {
        let mut world = world(reading());
        let known = |world: &Pair| world.station.vehicle.plan_state(kind);
        wait(&mut world, 12_000);
        assert_eq!(known(&world), PlanState::Empty);
        let at = |lat_deg| MissionItem::at(item, [90.0, 0.0, 0.0, 0.0], lat_deg, -4.0, 50.0);
        let items = [at(40.0), at(40.1)];
        world.plane.services.plans[kind as usize] = items_to_wire(&items, PLANE, kind).expect("sendable");
        world.plane.tell_param(total, 2.0, 7);
        wait(&mut world, 12_000);
        assert_eq!(known(&world), PlanState::Empty, "its place in the list of parameters is no news");
        world.plane.tell_param(total, 2.0, u16::MAX);
        wait(&mut world, 1_000);
        assert_eq!(known(&world), PlanState::Unknown(Unknown::ChangedElsewhere));
        wait(&mut world, 6_000);
        assert!(matches!(known(&world), PlanState::Verified { count: 2, .. }), "{}", known(&world));
        // Ours is told too.
        let ours = Request::UploadPlan { kind, items: vec![at(40.2)], home: None, despite_findings: true };
        ask(&mut world, ours).expect("sent");
        world.plane.tell_param(total, 1.0, u16::MAX);
        wait(&mut world, 500);
        assert!(matches!(known(&world), PlanState::Verified { count: 1, .. }), "{}", known(&world));
    }
}

#[test]
fn a_mission_of_the_same_length_sent_over_another_link_is_read() {
    let mut world = world(reading());
    world.plane.services.store(MISSION, &rival_wire(&route(9, 0.0)));
    wait(&mut world, 12_000);
    let before = state(&world);
    assert!(matches!(before, PlanState::Verified { count: 9, .. }), "{before}");
    world.plane.services.store(MISSION, &rival_wire(&route(9, 0.1)));
    wait(&mut world, 12_000);
    assert_eq!(state(&world), before, "nothing tells of it");
    // As ArduPlane 4.6 when a plan file becomes the mission: the list is emptied and filled (`finish_upload_mission`).
    for total in [1.0, 10.0] {
        world.plane.tell_param("MIS_TOTAL", total, u16::MAX);
    }
    wait(&mut world, 1_000);
    assert_eq!(state(&world), PlanState::Unknown(Unknown::ChangedElsewhere));
    wait(&mut world, 10_000);
    assert!(matches!(state(&world), PlanState::Verified { count: 9, .. }), "{}", state(&world));
    assert_ne!(state(&world), before);
}

#[test]
fn what_a_plane_answers_before_it_is_up_is_read_once_more() {
    let fence = |world: &Pair| world.station.vehicle.plan_state(PlanKind::Fence);
    let corner = |lat_deg, lon_deg| {
        MissionItem::at(Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION, [3.0, 0.0, 0.0, 0.0], lat_deg, lon_deg, 0.0)
    };
    let items = [corner(40.0, -4.0), corner(40.1, -4.0), corner(40.1, -3.9)];
    let wire = items_to_wire(&items, PLANE, PlanKind::Fence).expect("sendable");
    let mut plane = Plane::new();
    (plane.services.has_ftp, plane.system_status) = (false, 2);
    let mut world = World::new(Station::with(reading()), plane, Faults::default(), 1);
    wait(&mut world, 15_000);
    assert_eq!(fence(&world), PlanState::Unknown(Unknown::NeverRead), "it calibrates");
    ask(&mut world, Request::DownloadPlan { kind: PlanKind::Fence }).expect("read");
    assert_eq!(fence(&world), PlanState::Empty, "by its own word");
    (world.plane.system_status, world.plane.services.plans[PlanKind::Fence as usize]) = (3, wire);
    wait(&mut world, 5_000);
    assert!(matches!(fence(&world), PlanState::Verified { count: 3, .. }), "{}", fence(&world));
}

#[test]
fn a_request_at_any_moment_of_what_is_read_by_itself_goes_before_it() {
    for has_ftp in [true, false] {
        for step in 0..120 {
            let mut plane = Plane::new();
            plane.services.has_ftp = has_ftp;
            let mut world = World::new(Station::with(reading()), plane, Faults::default(), 1);
            wait(&mut world, 1_500 + 25 * step);
            let sent = ask(&mut world, send(route(12, 0.0)));
            assert!(sent.is_ok(), "MAVFTP {has_ftp}, {} ms: {sent:?}", 1_500 + 25 * step);
        }
    }
}

#[test]
fn a_vehicle_without_missions_is_left_alone() {
    // It has no MAVFTP and answers no mission message at all.
    let mut plane = Plane::new();
    plane.services.has_ftp = false;
    let plane = Plane { deaf_to_missions: true, ..plane };
    let mut world = World::new(Station::with(reading()), plane, Faults::default(), 1);
    world.log = Some(Vec::new());
    wait(&mut world, 600_000);
    let asked = world.log.as_ref().expect("logged").iter();
    let asked = asked.filter(|(_, message)| matches!(message, Message::Dialect(MavMessage::MISSION_REQUEST_LIST(_))));
    let count = asked.count();
    assert!((3..=120).contains(&count), "{count}");
    assert_eq!(state(&world), PlanState::Unknown(Unknown::NeverRead));
    assert!(ask(&mut world, ARM).is_ok(), "nothing says that it is mixed");
}

/// When another station begins beside an upload of ours, and what it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rival {
    /// Before it, and it takes longer than we are ready to wait.
    Before,
    /// Before it, and it is soon done.
    JustBefore,
    /// While it runs, and answers what is not asked of it.
    During,
    /// When the last item has arrived and is not read back yet; it may leave its own half-way.
    Behind,
}

// fault 32 (500 uploads): 500 uploads beside a rival, before, during and behind ours, item by item and by file: one that fails is told, what is said to be verified is what is on board, and a mixture is never said to be whole
#[test]
fn uploads_beside_a_rival_are_never_contaminated() {
    use rand::Rng as _;
    let (ours_north_deg, theirs_north_deg) = (0.01, 0.05);
    let mut outcomes: BTreeMap<(Rival, &str), u32> = BTreeMap::new();
    let mut rng = SmallRng::seed_from_u64(32);
    let mut worlds = [world(reading()), world(reading())];
    worlds[1].plane.services.has_ftp = true;
    let rounds = u32::try_from(5 * seeds(100)).expect("not so many");
    for round in 0..rounds {
        let world = &mut worlds[(round % 2) as usize];
        let rival = [Rival::Before, Rival::JustBefore, Rival::During, Rival::Behind][(round / 2 % 4) as usize];
        // None is a part of one before.
        let moved_deg = f64::from(round) * 1e-6;
        let ours = route(6 + (round % 7) as usize, ours_north_deg + moved_deg);
        let theirs = rival_wire(&route(9, theirs_north_deg + moved_deg));
        let mut messages = vec![rival_count(theirs.len())];
        let (begins_ms, step_ms) = match rival {
            Rival::Before | Rival::JustBefore => (0, if rival == Rival::Before { 1_200..2_000 } else { 20..60 }),
            Rival::During => (rng.random_range(0..60), 1..25),
            Rival::Behind => (0, 20..60),
        };
        let count = if rival == Rival::During { rng.random_range(0..10) } else { theirs.len() };
        let count = if rival == Rival::Behind && round % 3 == 0 { rng.random_range(1..count) } else { count };
        messages.extend(theirs.iter().take(count).map(|item| Message::MissionItemInt(*item)));
        if rival == Rival::During {
            messages.push(Message::MissionAck(MissionAck { target: PLANE, result: 0, mission_type: 0, opaque_id: 0 }));
        }
        let mut speak = |world: &mut Pair| {
            let mut at = world.now + Duration::from_millis(begins_ms);
            for message in &messages {
                for to_station in [true, false] {
                    world.inject(at, to_station, RIVAL, message);
                }
                at += Duration::from_millis(rng.random_range(step_ms.clone()));
            }
            at
        };
        let (id, over) = match rival {
            Rival::Before | Rival::JustBefore => {
                let over = speak(world);
                wait(world, 50);
                (start(world, send(ours.clone())), over)
            }
            Rival::During => {
                let id = start(world, send(ours.clone()));
                (id, speak(world))
            }
            Rival::Behind => {
                let id = start(world, send(ours.clone()));
                let whole = hash_items(&stored(&ours));
                let until = world.now + Duration::from_secs(60);
                let is_there = |_: &mut Station, plane: &mut Plane| hash_items(&plane.services.plans[0][1..]) == whole;
                assert!(world.run(until, is_there), "round {round}: all items arrived");
                (id, speak(world))
            }
        };
        let outcome = match end(world, id, 120) {
            Ok(Reply::Plan { items, state: told, .. }) => {
                assert_eq!(items.len(), ours.len(), "round {round}");
                assert!(matches!(told, PlanState::Verified { .. }), "round {round}");
                "verified"
            }
            Ok(other) => panic!("round {round}: {other:?}"),
            Err(error) => {
                assert!(state(world).may_be_mixed(), "round {round}: {error}, {}", state(world));
                "told as failed"
            }
        };
        *outcomes.entry((rival, outcome)).or_default() += 1;
        // Until both are at rest, and what is not known has been read.
        let rest = over.max(world.now).since(world.now) + Duration::from_secs(25);
        wait(world, rest.as_millis() as u64);
        let on_board = &world.plane.services.plans[0][1..];
        let north = |item: &MissionItemInt| (f64::from(item.x) / 1e7 - 40.33 - ours_north_deg).abs() < 0.01;
        let of_us = on_board.iter().filter(|item| north(item)).count();
        let is_mixed = of_us != 0 && of_us != on_board.len();
        let known = state(world);
        assert!(!is_mixed || known.may_be_mixed(), "round {round}: {of_us} of {} are ours: {known}", on_board.len());
        // Never a plan that is said to be whole and is not what is on board.
        if let PlanState::Verified { hash, .. } = known {
            assert_eq!(hash, hash_items(on_board), "round {round}");
            assert!(on_board.len() == ours.len() || of_us == 0, "round {round}: a part of ours is called whole");
        }
    }
    println!("uploads beside a rival: {outcomes:?}");
    let seen = |outcome| outcomes.iter().filter(|((_, is), _)| *is == outcome).map(|(_, count)| count).sum::<u32>();
    let (verified, failed) = (seen("verified"), seen("told as failed"));
    assert!(verified >= rounds / 3 && failed >= rounds / 5, "{outcomes:?}");
}

// Read back while another station wrote, ours was called verified and the other's upload forgotten, or theirs a mixture.
#[test]
fn a_read_back_beside_another_upload_begins_anew_after_it() {
    let (ours, theirs) = (route(12, 0.0), rival_wire(&route(9, 0.05)));
    let all = theirs.len();
    for has_ftp in [false, true] {
        // How much later than we the vehicle hears the other, how many items it announces and sends, and whose mission is there then.
        for (later_ms, announced, sent, whose) in
            [(0, all, all, "theirs"), (0, all, 4, "nobody's"), (400, all, 4, "nobody's"), (0, 700, 0, "ours")]
        {
            let case = format!("MAVFTP {has_ftp}, {sent} of {announced} items, {later_ms} ms later");
            let mut plane = Plane::new();
            plane.services.has_ftp = has_ftp;
            let faults = Faults::round_trip(Duration::from_millis(60));
            let mut world = World::new(Station::with(reading()), plane, faults, 1);
            wait(&mut world, 12_000);
            let id = start(&mut world, send(ours.clone()));
            let (whole, until) = (hash_items(&stored(&ours)), world.now + Duration::from_secs(60));
            let is_there = |_: &mut Station, plane: &mut Plane| hash_items(&plane.services.plans[0][1..]) == whole;
            assert!(world.run(until, is_there), "{case}: all of ours arrived");
            let mut at = world.now + Duration::from_millis(3);
            for message in
                [rival_count(announced)].into_iter().chain(theirs[..sent].iter().copied().map(Message::MissionItemInt))
            {
                world.inject(at, true, RIVAL, &message);
                world.inject(at + Duration::from_millis(later_ms), false, RIVAL, &message);
                at += Duration::from_millis(30);
            }
            let (outcome, told) = (end(&mut world, id, 60), state(&world));
            assert_eq!(outcome.is_ok(), whose == "ours", "{case}: {outcome:?}");
            assert_eq!(told.may_be_mixed(), whose != "ours", "{case}: {told}");
            wait(&mut world, 25_000);
            let told = state(&world);
            let is_told = match whose {
                "theirs" => matches!(told, PlanState::Verified { count: 9, .. }),
                "ours" => matches!(told, PlanState::Verified { count: 12, .. }),
                _ => matches!(told, PlanState::Differs { .. }),
            };
            assert!(is_told, "{case}: {told}");
        }
    }
}

/// As the vehicle keeps them.
fn stored(items: &[MissionItem]) -> Vec<MissionItemInt> {
    let mut services = Plane::new().services;
    services.store(MISSION, &rival_wire(items));
    services.plans[0][1..].to_vec()
}

// ── the flown target ─────────────────────────────────────────────────────────────────────────────────────────────────

/// A recorded flight with the mission that was flown, changed by `change`. Returns the alarms: item, time since that item began,
/// and how often the target was as planned again.
fn flown(
    name: &str,
    change: impl Fn(&mut Vec<MissionItem>),
    keeps: impl Fn(&Message) -> bool,
) -> (Vec<(u16, Duration)>, usize) {
    let ground: Vec<MissionItemInt> = match name {
        "arduplane-wind-flight" => recorded(name, STATION)
            .into_iter()
            .filter_map(|(_, message)| match message {
                Message::MissionItemInt(item) => Some(item),
                _ => None,
            })
            .collect(),
        _ => decode_plan_file(include_bytes!("../../../../../tests/fixtures/captures/mission.dat")).expect("a plan").1,
    };
    let mut mission = Mission::from_wire(&ground, true).expect("a mission");
    change(&mut mission.items);
    let config = VehicleConfig { streams: StreamConfig::listen_only(), ..VehicleConfig::default() };
    let mut station = Station::with(config);
    let count = mission.items.len() as u16;
    let (mut begun, mut alarms, mut told) = (MonoTime::ZERO, Vec::new(), 0);
    for (at, message) in recorded(name, PLANE) {
        // The flights were recorded with the mission already there, or from before it was.
        if station.vehicle.telemetry().is_armed() == Some(true) && station.vehicle.mission().is_none() {
            station.vehicle.set_plan(MISSION, PlanState::Verified { count, hash: 1 });
            station.vehicle.copies[MISSION as usize] = Some(Arc::new(mission.clone()));
        }
        if keeps(&message) {
            station.receive(PLANE, &message, at);
        }
        while station.next_output().is_some() {}
        for event in station.events.drain(..) {
            match event {
                VehicleEvent::CurrentItemChanged { .. } => begun = at,
                VehicleEvent::TargetElsewhere { seq, distance_m } => {
                    assert_eq!(station.vehicle.progress().target_off_m, Some(distance_m), "{name}: it stands");
                    alarms.push((seq.0, at.since(begun)));
                }
                VehicleEvent::TargetAsPlanned { .. } => {
                    assert_eq!(station.vehicle.progress().target_off_m, None, "{name}: it ended");
                    told += 1;
                }
                _ => {}
            }
        }
    }
    assert!(station.vehicle.mission().is_some(), "{name} was compared");
    assert_eq!(station.vehicle.progress().target_off_m, None, "{name}: flown");
    (alarms, told)
}

const FLIGHTS: [&str; 2] = ["arduplane-takeoff-to-landing", "arduplane-wind-flight"];

fn is_target(message: &Message) -> bool {
    matches!(message, Message::Dialect(MavMessage::POSITION_TARGET_GLOBAL_INT(_)))
}

// fault 18: 0 alarms on flights as planned
#[test]
fn a_flight_as_planned_gives_no_alarm() {
    for name in FLIGHTS {
        assert_eq!(flown(name, |_| (), |_| true), (vec![], 0), "{name}");
        assert_eq!(flown(name, |_| (), |message| !is_target(message)), (vec![], 0), "{name}, by bearing and distance");
    }
}

// fault 18: 60 m off is told within 3 s on two recorded flights, 40 m is not
#[test]
fn a_target_that_is_elsewhere_is_told_within_three_seconds() {
    for name in FLIGHTS {
        // 60 m north of where it flies, and 40 m, which is not told.
        for (off_deg, is_told) in [(60.0 / 111_040.0, true), (40.0 / 111_040.0, false)] {
            let shift = |items: &mut Vec<MissionItem>| {
                items[2].params[4] = items[2].params[4].map(|lat_deg| lat_deg + off_deg);
            };
            let (alarms, ends) = flown(name, shift, |_| true);
            assert_eq!(
                alarms.iter().map(|(seq, _)| *seq).collect::<Vec<_>>(),
                if is_told { vec![3] } else { vec![] },
                "{name}"
            );
            assert!(alarms.iter().all(|(_, after)| *after <= Duration::from_secs(3)), "{name}: {alarms:?}");
            assert_eq!(ends, alarms.len(), "{name}: the next item is as planned");
        }
        // By bearing and distance alone what is far off is told.
        let far = |items: &mut Vec<MissionItem>| items[2].params[4] = items[2].params[4].map(|lat_deg| lat_deg + 0.01);
        let (alarms, _) = flown(name, far, |message| !is_target(message));
        assert_eq!(alarms.len(), 1, "{name}: {alarms:?}");
        assert!(alarms[0].1 <= Duration::from_secs(3), "{name}: {alarms:?}");
    }
}
