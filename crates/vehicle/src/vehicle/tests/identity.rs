//! Which aircraft answers under a system id, and what its autopilot is: what a restart, a silence and an exchange make
//! unknown, and what then belongs to which aircraft.

use std::sync::Arc;

use vencejo_flight::plan::Mission;
use vencejo_proto::{MissionItemInt, SystemId};

use super::mixed::{MISSION, assert_blocked, reading, rival_count, rival_wire, route, send, state, world};
use super::*;
use crate::plan_record::{Doubt, PlanRecord, VehicleKey, Writer};
use crate::plan_state::hash_items;

fn key(uid: u64) -> VehicleKey {
    VehicleKey::parse(&format!("uid-{uid:016x}")).expect("a key")
}

fn keeping() -> VehicleConfig {
    VehicleConfig { keeps_records: true, ..reading() }
}

fn at(ms: u64) -> MonoTime {
    MonoTime::from_millis(ms)
}

fn version(uid: u64) -> Message {
    let capabilities = MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT;
    Message::Dialect(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA { uid, capabilities, ..Default::default() }))
}

fn heartbeat(autopilot: u8, mav_type: u8) -> Message {
    Message::Heartbeat(Heartbeat { mav_type, autopilot, base_mode: 1, mavlink_version: 3, ..Heartbeat::default() })
}

fn hear(vehicle: &mut Vehicle, message: &Message, now: MonoTime) {
    vehicle.on_message(PLANE.component, message, now);
}

/// Tells `world`'s vehicle the id of its hardware.
fn identify(world: &mut Pair, uid: u64) {
    world.inject(world.now, true, PLANE, &version(uid));
    wait(world, 100);
}

/// The record that was written last for an aircraft.
fn record(world: &Pair, uid: u64) -> PlanRecord {
    let mut of_it = world.station.kept.values().filter(|stored| stored.key == key(uid));
    of_it.next_back().map(|stored| stored.record.clone()).expect("a record")
}

/// Whether each record that is written has a doubt, by key, in order.
fn written(vehicle: &mut Vehicle) -> Vec<(VehicleKey, bool)> {
    let outputs = std::iter::from_fn(|| vehicle.poll_output());
    let kept = outputs.filter_map(|output| match output {
        Output::Keep { stored, .. } => Some((stored.key, stored.record.doubt.is_some())),
        _ => None,
    });
    kept.collect()
}

fn doubted(uid: u64, sent: &[MissionItemInt]) -> StoredRecord {
    let doubt = Doubt { writer: Writer::Us, sent: Some(Arc::new(sent.to_vec())), before: Some(7) };
    StoredRecord {
        key: key(uid),
        system: Some(SystemId(1)),
        record: PlanRecord { verified: Some((3, 7)), doubt: Some(doubt) },
    }
}

/// Another aircraft, or the same one, is switched on in the place of the one that was there. It does not answer
/// requests for its version.
fn restart(world: &mut Pair, holds: Option<&[MissionItem]>) {
    if let Some(items) = holds {
        world.plane.services.store(MISSION, &rival_wire(items));
    }
    world.plane.unknown.extend([Command::REQUEST_MESSAGE]);
    let now = world.now;
    world.station.events.clear();
    world.plane.reboot(now);
    let is_back = |station: &mut Station, _: &mut Plane| {
        station.events.contains(&VehicleEvent::Rebooted) && station.vehicle.telemetry().heartbeat.is_some()
    };
    assert!(world.run(now + Duration::from_secs(10), is_back), "back");
}

// Its doubt was dropped after 5 s, the mixture called verified, and the doubt erased on the disk.
#[test]
fn an_aircraft_that_does_not_tell_its_id_may_be_the_one_whose_mission_is_doubted() {
    let mixture = route(9, 0.07);
    for (uid, is_doubted) in [(0x2a, true), (0x2b, false)] {
        let mut plane = Plane::new();
        plane.services.has_ftp = false;
        plane.services.store(MISSION, &rival_wire(&mixture));
        plane.unknown.push(Command::REQUEST_MESSAGE);
        let mut world = World::new(Station::with(keeping()), plane, Faults::default(), 1);
        world.station.vehicle.on_records(vec![doubted(0x2a, &rival_wire(&route(14, 0.02)))], MonoTime::ZERO);
        wait(&mut world, 4_000);
        assert_eq!(state(&world), PlanState::Unknown(Unknown::TransferFailed));
        wait(&mut world, 16_000);
        assert!(matches!(state(&world), PlanState::Differs { count: 9, .. }), "{}", state(&world));
        let now = world.now;
        assert_blocked(&mut world.station.vehicle, now, "it has not told who it is");
        identify(&mut world, uid);
        wait(&mut world, 20_000);
        assert_eq!(state(&world).may_be_mixed(), is_doubted, "{uid:x}: {}", state(&world));
        let of_first = world.station.kept.values().filter(|stored| stored.key == key(0x2a));
        assert!(of_first.into_iter().all(|stored| stored.record.doubt.is_some()), "its doubt is kept");
    }
    // An upload that is verified ends the doubt, whoever it turns out to be.
    let mut plane = Plane::new();
    plane.unknown.push(Command::REQUEST_MESSAGE);
    let mut world = World::new(Station::with(keeping()), plane, Faults::default(), 1);
    world.station.vehicle.on_records(vec![doubted(0x2a, &[])], MonoTime::ZERO);
    wait(&mut world, 7_000);
    ask(&mut world, send(route(5, 0.0))).expect("uploaded");
    identify(&mut world, 0x2a);
    assert!(matches!(state(&world), PlanState::Verified { count: 5, .. }), "{}", state(&world));
    assert_eq!(record(&world, 0x2a).doubt, None);
}

// Until the heartbeat after a restart an ArduPilot counted as another autopilot: missions went without home, items one
// too low.
#[test]
fn what_the_autopilot_is_outlives_a_restart_and_is_asked_anew_after_an_exchange() {
    let mut plane = Plane::new();
    (plane.services.has_ftp, plane.uid) = (false, 0x2a);
    let name = ParamName::new("RTL_AUTOLAND").expect("a name");
    plane.services.params.push(Param::new(name, ParamValue::I32(0)));
    let mut world = World::new(Station::with(reading()), plane, Faults::default(), 1);
    wait(&mut world, 2_000);
    ask(&mut world, send(route(6, 0.0))).expect("uploaded");
    let requests = [
        send(route(5, 0.02)),
        Request::SetCurrentItem { item: 3 },
        Request::MissionStart { from_item: Some(2) },
        Request::ParamSet { name: "RTL_AUTOLAND".into(), value: 1.0 },
        Request::Takeoff { alt_rel_home_m: 60.0 },
    ];
    let number = |world: &Pair| {
        let jumps = world.plane.commands.iter().filter(|long| long.command == Command::DO_SET_MISSION_CURRENT.0);
        jumps.map(|long| long.params[0]).next_back()
    };
    for request in &requests {
        wait(&mut world, 4_050);
        let now = world.now;
        world.station.vehicle.on_restart(now, now);
        assert_eq!(world.station.vehicle.telemetry().heartbeat, None);
        let reply = ask(&mut world, request.clone());
        assert!(reply.is_ok(), "{request:?}: {reply:?}");
        match request {
            Request::UploadPlan { .. } => assert_eq!(world.plane.services.plans[0].len(), 6, "home and 5 items"),
            Request::SetCurrentItem { .. } => assert_eq!(number(&world), Some(3.0)),
            Request::MissionStart { .. } => assert_eq!(number(&world), Some(2.0)),
            Request::Takeoff { .. } => {
                assert_eq!(count(&world, Command::NAV_TAKEOFF), 0, "a fixed wing takes off by a mode")
            }
            _ => assert_eq!(world.plane.services.params[2].value, ParamValue::I32(1)),
        }
    }
    // Of another aircraft it is not known what it is before its heartbeat.
    for request in &requests {
        wait(&mut world, 4_050);
        world.plane.uid += 1;
        let (now, uid) = (world.now, world.plane.uid);
        hear(&mut world.station.vehicle, &version(uid), now);
        let reply = ask(&mut world, request.clone());
        assert!(matches!(reply, Err(VehicleError::NotHeard { .. })), "{request:?}: {reply:?}");
    }
    // One that was heard since the silence in which it came has told.
    let now = world.now;
    world.faults.blackouts = vec![(now, now + Duration::from_secs(8))];
    world.plane.uid += 1;
    wait(&mut world, 8_000);
    let is_exchanged = |station: &mut Station, _: &mut Plane| {
        station.vehicle.plan_state(MISSION) == PlanState::Unknown(Unknown::NeverRead)
    };
    assert!(world.run(now + Duration::from_secs(20), is_exchanged), "{}", state(&world));
    if world.station.vehicle.telemetry().heartbeat.is_none() {
        wait(&mut world, 1_000);
    }
    ask(&mut world, send(route(4, 0.0))).expect("uploaded");
    assert_eq!(world.plane.services.plans[0].len(), 5);
}

// What was numbered for the one was called whole on the other.
#[test]
fn what_was_written_for_another_autopilot_is_not_called_whole() {
    let mut world = world(reading());
    let now = world.now;
    world.station.vehicle.on_restart(now, now);
    // It is a PX4 that is there, which takes the home item for a waypoint.
    (world.plane.autopilot, world.plane.mode) = (12, 4 << 16);
    world.plane.next_heartbeat = now + Duration::from_secs(8);
    ask(&mut world, send(route(4, 0.0))).expect("numbered as before");
    assert!(!state(&world).may_be_mixed());
    wait(&mut world, 8_000);
    assert!(state(&world).may_be_mixed(), "{}", state(&world));
    wait(&mut world, 20_000);
    assert!(matches!(state(&world), PlanState::Differs { count: 5, .. }), "{}", state(&world));
}

// A PX4 or a copter was taken for an ArduPlane, and flew its mixed mission.
#[test]
fn a_mixed_mission_is_not_flown_before_the_heartbeat_after_a_restart() {
    for (autopilot, mav_type, name, number) in [(12, 1, "mission", (4 << 16) | (4 << 24)), (3, 2, "auto", 3)] {
        let mut vehicle = Vehicle::new(PLANE, STATION, VehicleConfig::default(), MonoTime::ZERO);
        hear(&mut vehicle, &heartbeat(autopilot, mav_type), at(10));
        vehicle.on_sending(&rival_count(9), false, at(20)).expect("sent");
        vehicle.on_restart(at(20_000), at(20_000));
        assert!(vehicle.plan_state(MISSION).may_be_mixed());
        while vehicle.poll_output().is_some() {}
        for request in [
            mode(name),
            Request::SetMode { mode: ModeChoice::Custom(number) },
            Request::MissionStart { from_item: None },
            Request::MissionResume,
        ] {
            vehicle.request(request.clone(), at(20_001));
            let outputs: Vec<_> = std::iter::from_fn(|| vehicle.poll_output()).collect();
            let is_refusal = |output: &Output| {
                matches!(output, Output::Finished { result: Err(VehicleError::PlanUnknown { .. }), .. })
            };
            let is_act = |output: &Output| matches!(output, Output::Send(message) if vehicle.act_of(message).is_some());
            let is_refused = outputs.iter().any(is_refusal) && !outputs.iter().any(is_act);
            assert!(is_refused, "{name}: {request:?}: {outputs:?}");
        }
    }
    // Before the first heartbeat each mode that is the mission's on any of them.
    let mut vehicle = Vehicle::new(PLANE, STATION, VehicleConfig::default(), MonoTime::ZERO);
    vehicle.on_sending(&rival_count(9), false, at(20)).expect("sent");
    for custom_mode in [3.0, 10.0] {
        let params = [1.0, custom_mode, 0.0, 0.0, 0.0, 0.0, 0.0];
        let long = CommandLong { target: PLANE, command: Command::DO_SET_MODE.0, confirmation: 0, params };
        assert!(vehicle.on_sending(&Message::CommandLong(long), false, at(30)).is_err(), "{custom_mode}");
    }
}

// It was given to the one alone, and the half mission on the other was called verified.
#[test]
fn a_doubt_that_began_before_it_told_its_id_goes_to_both_aircraft() {
    let vehicle = || {
        let mut vehicle = Vehicle::new(PLANE, STATION, keeping(), MonoTime::ZERO);
        vehicle.on_records(vec![], MonoTime::ZERO);
        hear(&mut vehicle, &version(0x2a), at(5));
        vehicle
    };
    let both = [(key(0x2a), true), (key(0x2b), true)];
    // Changed in a silence; its upload is cut by the next.
    let mut silent = vehicle();
    silent.on_time(at(10_000));
    hear(&mut silent, &heartbeat(3, 1), at(11_000));
    silent.on_sending(&rival_count(9), false, at(12_000)).expect("sent");
    silent.on_time(at(16_000));
    silent.on_time(at(30_000));
    hear(&mut silent, &version(0x2b), at(31_000));
    assert!(silent.plan_state(MISSION).may_be_mixed(), "{}", silent.plan_state(MISSION));
    assert_eq!(written(&mut silent), both);
    // Changed by one of two restarts, between which it did not tell.
    let mut restarted = vehicle();
    restarted.on_restart(at(20_000), at(20_000));
    restarted.on_time(at(26_000));
    restarted.on_sending(&rival_count(9), false, at(27_000)).expect("sent");
    restarted.on_time(at(32_000));
    restarted.on_restart(at(40_000), at(40_000));
    hear(&mut restarted, &version(0x2b), at(41_000));
    assert!(restarted.plan_state(MISSION).may_be_mixed(), "{}", restarted.plan_state(MISSION));
    assert_eq!(written(&mut restarted), both);
    hear(&mut restarted, &version(0x2a), at(50_000));
    assert!(restarted.plan_state(MISSION).may_be_mixed(), "and the first has it when it is back");
}

// What another aircraft held ended the doubt about the first one's mission, on the disk too.
#[test]
fn a_mission_that_is_read_after_a_silence_waits_for_the_id() {
    let sent = route(30, 0.02);
    for (theirs, uid) in [(sent.clone(), Some(0x2b)), (route(8, 0.1), Some(0x2b)), (sent.clone(), None)] {
        let case = format!("{} items, {uid:x?}", theirs.len());
        let mut world = world(VehicleConfig { keeps_records: true, ..VehicleConfig::default() });
        identify(&mut world, 0x2a);
        world.faults.cut_after = Some(world.station_frames + 9);
        ask(&mut world, send(sent.clone())).expect_err("cut off");
        world.faults.cut_after = None;
        let doubt = record(&world, 0x2a).doubt;
        assert!(doubt.is_some(), "{case}");
        world.plane.services.store(MISSION, &rival_wire(&theirs));
        world.plane.unknown.push(Command::REQUEST_MESSAGE);
        let now = world.now;
        world.faults.blackouts = vec![(now, now + Duration::from_secs(8))];
        world.station.events.clear();
        let is_back = |station: &mut Station, _: &mut Plane| station.events.contains(&VehicleEvent::Regained);
        assert!(world.run(now + Duration::from_secs(20), is_back), "{case}");
        let id = start(&mut world, Request::DownloadPlan { kind: MISSION });
        wait(&mut world, 1_000);
        assert_eq!(world.station.results.get(&id), None, "{case}: not known whose it is");
        if let Some(uid) = uid {
            identify(&mut world, uid);
        }
        // An exchange ends what was asked of the one before, and a number of items that has changed voids what was
        // read.
        let reply = end(&mut world, id, 6);
        assert!(matches!(reply, Ok(_) | Err(VehicleError::Rebooted)), "{case}: {reply:?}");
        ask(&mut world, Request::DownloadPlan { kind: MISSION }).expect("read");
        assert!(matches!(state(&world), PlanState::Verified { .. }), "{case}: {}", state(&world));
        assert_eq!(record(&world, 0x2a).doubt, doubt, "{case}: it is still the first one's");
        // It is back, and the doubt with it, whether it tells or not.
        world.plane.services.store(MISSION, &rival_wire(&route(11, 0.2)));
        let now = world.now;
        world.faults.blackouts = vec![(now, now + Duration::from_secs(8))];
        wait(&mut world, 10_000);
        if uid.is_some() {
            identify(&mut world, 0x2a);
        }
        assert!(state(&world).may_be_mixed(), "{case}: {}", state(&world));
    }
}

// Its doubt from an earlier run came back over a mission that had just been verified on it.
#[test]
fn a_mission_that_was_verified_before_the_id_came_is_not_doubted() {
    let mut world = world(keeping());
    world.station.vehicle.on_records(vec![doubted(0x2b, &rival_wire(&route(14, 0.02)))], MonoTime::ZERO);
    identify(&mut world, 0x2a);
    wait(&mut world, 10_000);
    restart(&mut world, None);
    ask(&mut world, send(route(6, 0.0))).expect("uploaded");
    identify(&mut world, 0x2b);
    assert!(!state(&world).may_be_mixed(), "{}", state(&world));
    assert_eq!(record(&world, 0x2b).doubt, None);
    wait(&mut world, 20_000);
    let hash = hash_items(&world.plane.services.plans[0][1..]);
    assert_eq!(state(&world), PlanState::Verified { count: 6, hash });
}

// The old, whole mission was called perhaps mixed.
#[test]
fn a_mission_that_was_verified_before_a_restart_is_whole_when_an_upload_wrote_nothing() {
    for is_next_run in [false, true] {
        let mut world = world(keeping());
        ask(&mut world, send(route(6, 0.0))).expect("uploaded");
        let before = state(&world);
        wait(&mut world, 6_000);
        if is_next_run {
            let stored = world.station.kept.values().next_back().cloned().expect("a record");
            let plane = std::mem::replace(&mut world.plane, Plane::new());
            world = World::new(Station::with(keeping()), plane, Faults::default(), 1);
            world.station.vehicle.on_records(vec![stored], MonoTime::ZERO);
            (world.plane.next_heartbeat, world.plane.next_stream) = (at(3), at(5));
            wait(&mut world, 1_200);
        } else {
            let now = world.now;
            world.station.vehicle.on_restart(now, now);
        }
        world.plane.deaf_to_missions = true;
        ask(&mut world, send(route(9, 0.05))).expect_err("nothing answers");
        world.plane.deaf_to_missions = false;
        assert!(state(&world).may_be_mixed(), "{is_next_run} {}", state(&world));
        wait(&mut world, 90_000);
        assert_eq!(state(&world), before, "next run: {is_next_run}");
        assert!(ask(&mut world, ARM).is_ok());
    }
}

#[test]
fn a_lost_answer_to_who_it_is_is_asked_for_again() {
    let mut plane = Plane::new();
    (plane.services.has_ftp, plane.uid) = (false, 0x2a);
    let mut world = World::new(Station::with(keeping()), plane, Faults::default(), 1);
    world.plane.loses = 2;
    wait(&mut world, 15_000);
    assert!(world.station.vehicle.telemetry().version.is_some());
    ask(&mut world, send(route(4, 0.0))).expect("uploaded");
    assert!(record(&world, 0x2a).verified.is_some());
    assert!(Mission::from_wire(&world.plane.services.plans[0], true).is_ok());
}

// It was dropped when the vehicle told the id of its hardware, which it had not told in the run before.
#[test]
fn a_doubt_that_was_recorded_by_the_system_id_goes_to_the_aircraft_that_tells() {
    let mut vehicle = Vehicle::new(PLANE, STATION, keeping(), MonoTime::ZERO);
    let by_system = VehicleKey::of_system(SystemId(1));
    vehicle.on_records(vec![StoredRecord { key: by_system.clone(), ..doubted(0, &[]) }], MonoTime::ZERO);
    assert!(vehicle.plan_state(MISSION).may_be_mixed());
    hear(&mut vehicle, &version(0x2a), at(5));
    assert!(vehicle.plan_state(MISSION).may_be_mixed(), "{}", vehicle.plan_state(MISSION));
    assert_eq!(written(&mut vehicle), [(by_system, false), (key(0x2a), true)]);
}

#[test]
fn an_exchange_ends_the_uploads_to_the_aircraft_before() {
    let mut vehicle = Vehicle::new(PLANE, STATION, keeping(), MonoTime::ZERO);
    vehicle.on_records(vec![], MonoTime::ZERO);
    hear(&mut vehicle, &heartbeat(3, 1), at(5));
    hear(&mut vehicle, &version(0x2a), at(5));
    let rally = MissionItem { command: Command::NAV_RALLY_POINT, ..MissionItem::waypoint(40.3432, -3.7978, 80.0) };
    let rally = Request::UploadPlan { kind: PlanKind::Rally, items: vec![rally], home: None, despite_findings: false };
    for (request, kind) in [(rally, PlanKind::Rally), (send(route(4, 0.0)), MISSION)] {
        vehicle.request(request, at(10));
        assert_eq!(vehicle.plan_state(kind), PlanState::Unknown(Unknown::Transferring));
        let uid = if kind == MISSION { 0x2c } else { 0x2b };
        hear(&mut vehicle, &version(uid), at(20));
        let results: Vec<_> = std::iter::from_fn(|| vehicle.poll_output()).collect();
        let is_ended = |output: &Output| matches!(output, Output::Finished { result: Err(VehicleError::Rebooted), .. });
        assert!(results.iter().any(is_ended), "{results:?}");
        hear(&mut vehicle, &heartbeat(3, 1), at(30));
        // A half mission may be on either of them.
        let left = if kind == MISSION { Unknown::TransferFailed } else { Unknown::NeverRead };
        assert_eq!(vehicle.plan_state(kind), PlanState::Unknown(left));
    }
}
