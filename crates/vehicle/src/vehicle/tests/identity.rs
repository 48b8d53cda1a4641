//! Which aircraft answers under a system id, and what its autopilot is: what a restart, a silence and an exchange make unknown.

use super::mixed::{MISSION, reading, rival_count, route, send, state, world};
use super::*;

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

// Until the heartbeat after a restart an ArduPilot counted as another autopilot: missions went without home, items one
// too low.
#[test]
fn what_the_autopilot_is_outlives_a_restart_and_is_asked_anew_after_an_exchange() {
    let mut plane = Plane::new();
    (plane.services.has_ftp, plane.uid) = (false, 0x2a);
    let name = ParamName::new("RTL_AUTOLAND").expect("a name");
    plane.services.params.push(Param { name, value: ParamValue::I32(0) });
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
        let jumps = world.plane.commands.iter().filter(|long| long.command == cmd::DO_SET_MISSION_CURRENT);
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
                assert_eq!(count(&world, cmd::NAV_TAKEOFF), 0, "a fixed wing takes off by a mode")
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
        let long = CommandLong { target: PLANE, command: cmd::DO_SET_MODE, confirmation: 0, params };
        assert!(vehicle.on_sending(&Message::CommandLong(long), false, at(30)).is_err(), "{custom_mode}");
    }
}
