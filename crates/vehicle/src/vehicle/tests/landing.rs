//! What is not sent to a plane that lands, and what is proved of one that begins or goes on with its mission.

use vencejo_proto::MissionItemFloat;
use vencejo_proto::dialect::MISSION_SET_CURRENT_DATA;

use super::*;

const AUTO: u32 = 10;

/// A plane that flies the mission below in AUTO, known to us, at an item.
fn in_auto(seq: u16) -> Pair {
    let mut world = connected();
    let items = vec![
        MissionItem::takeoff(40.3332, -3.7990, 50.0, 12.0),
        MissionItem::waypoint(40.3340, -3.8030, 80.0),
        MissionItem::action(Command::DO_LAND_START, [0.0; 4]),
        MissionItem::waypoint(40.3345, -3.8000, 40.0),
        MissionItem::land(40.3332, -3.7978, 0.0),
    ];
    let plan = Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false };
    ask(&mut world, plan).expect("uploaded");
    fly(&mut world, AUTO, seq);
    world
}

/// The same without DO_LAND_START.
fn unmarked(seq: u16) -> Pair {
    let mut world = in_auto(1);
    let items = vec![
        MissionItem::takeoff(40.3332, -3.7990, 50.0, 12.0),
        MissionItem::waypoint(40.3340, -3.8030, 80.0),
        MissionItem::waypoint(40.3345, -3.8000, 40.0),
        MissionItem::change_airspeed(14.0),
        MissionItem::land(40.3332, -3.7978, 0.0),
    ];
    let plan = Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false };
    ask(&mut world, plan).expect("uploaded");
    fly(&mut world, AUTO, seq);
    world
}

fn fly(world: &mut Pair, mode: u32, seq: u16) {
    (world.plane.is_armed, world.plane.mode, world.plane.current) = (true, mode, seq);
    world.plane.landed = MavLandedState::MAV_LANDED_STATE_IN_AIR;
    wait(world, 1_500);
}

fn higher() -> Request {
    Request::ChangeAltitude { alt_m: 60.0, alt_frame: AltFrame::RelHome, below_home: false }
}

#[test]
fn a_plane_that_lands_takes_no_new_altitude() {
    let mut world = in_auto(5);
    let long = CommandLong {
        target: Address::new(0, 0),
        command: Command::DO_CHANGE_ALTITUDE.0,
        confirmation: 0,
        params: [60.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    };
    let item = MissionItemFloat {
        target: PLANE,
        seq: 0,
        frame: 3,
        command: 16,
        current: 3,
        autocontinue: 0,
        params: [0.0; 4],
        x: 0.0,
        y: 0.0,
        z: 60.0,
        mission_type: 0,
    };
    for request in [higher(), Request::RawCommandLong(long), Request::DespiteMixedPlan(Box::new(higher()))] {
        let error = ask(&mut world, request).expect_err("refused");
        assert!(matches!(error, VehicleError::Landing { is_known: true, .. }), "{error}");
        assert!(error.to_string().contains("abort the landing before changing its altitude"), "{error}");
    }
    for raw in [Message::CommandLong(CommandLong { target: PLANE, ..long }), Message::MissionItemFloat(item)] {
        let sent = world.station.vehicle.on_sending(&raw, true, world.now);
        assert!(matches!(sent, Err(VehicleError::Landing { .. })), "{raw:?}");
    }
    // A target elsewhere, or on the way to the landing, is no flare.
    let item = Message::MissionItemFloat(MissionItemFloat { current: 2, x: 40.33, y: -3.8, ..item });
    assert_eq!(world.station.vehicle.on_sending(&item, true, world.now), Ok(()));
    for (mode, seq) in [(AUTO, 4), (12, 5), (11, 5)] {
        fly(&mut world, mode, seq);
        assert_eq!(ask(&mut world, higher()), Ok(Reply::Done), "mode {mode}, item {seq}");
    }
    assert_eq!(count(&world, Command::DO_CHANGE_ALTITUDE), 3);
    // In a mission that nobody has read any item may be a landing.
    let mut unread = connected();
    fly(&mut unread, AUTO, 5);
    let error = ask(&mut unread, higher()).expect_err("refused");
    assert!(matches!(error, VehicleError::Landing { is_known: false, .. }), "{error}");
    fly(&mut unread, 12, 5);
    assert_eq!(ask(&mut unread, higher()), Ok(Reply::Done));
}

#[test]
fn a_plane_on_final_is_turned_away_by_an_abort_or_another_mode_only() {
    let to = |seq: f32, command: Command| CommandLong {
        target: PLANE,
        command: command.0,
        confirmation: 0,
        params: [seq, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    };
    let set_current = MISSION_SET_CURRENT_DATA { seq: 2, target_system: 1, target_component: 1 };
    let jumps = [
        Message::Dialect(MavMessage::MISSION_SET_CURRENT(set_current)),
        Message::CommandLong(to(2.0, Command::DO_SET_MISSION_CURRENT)),
        Message::CommandLong(to(1.0, Command::DO_JUMP_TAG)),
        Message::CommandLong(to(0.0, Command::DO_RETURN_PATH_START)),
    ];
    let restart = Message::CommandLong(to(0.0, Command::DO_LAND_START));
    let refuses = |world: &mut Pair, raw: &Message| match world.station.vehicle.on_sending(raw, true, world.now) {
        Ok(()) => false,
        Err(VehicleError::Landing { is_known, .. }) => is_known,
        Err(error) => panic!("{error}"),
    };
    for (mode, seq, on_approach, on_final) in [(AUTO, 5, true, true), (AUTO, 4, true, false), (AUTO, 2, false, false)] {
        let mut world = in_auto(seq);
        assert_eq!(refuses(&mut world, &restart), on_approach, "mode {mode}, item {seq}");
        assert!(jumps.iter().all(|jump| refuses(&mut world, jump) == on_final), "mode {mode}, item {seq}");
    }
    let mut world = in_auto(5);
    let raw = Request::RawCommandLong(to(0.0, Command::DO_LAND_START));
    for request in [raw, Request::SetCurrentItem { item: 2 }, Request::MissionStart { from_item: Some(1) }] {
        let error = ask(&mut world, request).expect_err("refused").to_string();
        assert!(error.contains("abort the landing before"), "{error}");
    }
    assert_eq!(ask(&mut world, Request::AbortLanding { alt_rel_home_m: None }), Ok(Reply::Done));
    assert_eq!(ask(&mut world, mode("LOITER")), Ok(Reply::Done));
    assert!(!refuses(&mut world, &restart) && jumps.iter().all(|jump| !refuses(&mut world, jump)));
    // An old report does not show that it still lands.
    let mut world = in_auto(5);
    world.plane.is_streaming = false;
    wait(&mut world, 8_000);
    assert!(!refuses(&mut world, &restart) && jumps.iter().all(|jump| !refuses(&mut world, jump)));
}

#[test]
fn a_landing_that_goes_on_is_not_begun_anew() {
    for (seq, sent) in [(5, 0), (4, 0), (2, 1)] {
        let mut world = in_auto(seq);
        assert_eq!(ask(&mut world, Request::Land), Ok(Reply::Done));
        assert_eq!(count(&world, Command::DO_LAND_START), sent, "at item {seq}");
        let says_so = |text: &crate::telemetry::Text| text.text == "It is landing already: nothing was sent";
        assert_eq!(world.station.vehicle.texts().iter().any(says_so), sent == 0);
        // In another mode it has left its landing.
        fly(&mut world, 12, 5);
        assert_eq!(ask(&mut world, Request::Land), Ok(Reply::Done));
        assert_eq!(count(&world, Command::DO_LAND_START), sent + 1);
    }
}

#[test]
fn a_mission_goes_on_where_it_was_to_though_the_vehicle_begins_it_anew() {
    let start_from = |item| Request::MissionStart { from_item: Some(item) };
    for (request, stands, set) in
        [(start_from(4), 1, vec![4.0, 4.0]), (Request::MissionResume, 2, vec![2.0]), (start_from(1), 4, vec![0.0])]
    {
        let mut world = in_auto(stands);
        fly(&mut world, 12, stands);
        world.plane.restarts_mission = true;
        assert_eq!(ask(&mut world, request.clone()), Ok(Reply::Done));
        let sent = world.plane.commands.iter().filter(|long| long.command == Command::DO_SET_MISSION_CURRENT.0);
        assert_eq!(sent.map(|long| long.params[0]).collect::<Vec<_>>(), set, "{request:?}");
        assert_eq!(f32::from(world.plane.current), set[0].max(1.0));
        // One that does not begin anew is set to nothing more.
        fly(&mut world, 12, stands);
        world.plane.restarts_mission = false;
        let before = count(&world, Command::DO_SET_MISSION_CURRENT);
        assert_eq!(ask(&mut world, request.clone()), Ok(Reply::Done));
        assert_eq!(count(&world, Command::DO_SET_MISSION_CURRENT) - before, set.len() / 2 + usize::from(set[0] == 0.0));
    }
    // That it cannot be set to where it stood is no success.
    let mut world = in_auto(2);
    fly(&mut world, 12, 2);
    (world.plane.restarts_mission, world.plane.unknown) = (true, vec![Command::DO_SET_MISSION_CURRENT]);
    let error = ask(&mut world, Request::MissionResume).expect_err("it flies the first item");
    assert!(matches!(&error, VehicleError::NotConfirmed { observed, .. } if observed == "item 1"), "{error}");
}

#[test]
fn a_mission_that_goes_on_elsewhere_by_itself_is_left_there() {
    let resumed = |world: &mut Pair, to: u16| {
        world.plane.current = to;
        assert_eq!(ask(world, Request::MissionResume), Ok(Reply::Done));
        (count(world, Command::DO_SET_MISSION_CURRENT), world.plane.current)
    };
    // In AUTO it flies on, here around a jump back.
    assert_eq!(resumed(&mut in_auto(4), 2), (0, 2));
    // Leaving AUTO sets a landing back to its beginning, of which nothing has been reported yet.
    let mut world = in_auto(5);
    world.plane.is_streaming = false;
    world.plane.mode = 12;
    wait(&mut world, 1_200);
    world.plane.is_streaming = true;
    assert_eq!(resumed(&mut world, 4), (0, 4));
    // Without a state, what was reached last tells that it was complete: it begins anew.
    let mut world = in_auto(5);
    world.plane.mission_state = MissionState::MISSION_STATE_UNKNOWN;
    fly(&mut world, 11, 5);
    world.station.vehicle.tracker.on_reached(5, Some(5), None, 1);
    assert_eq!(resumed(&mut world, 1), (0, 1));
    // After an interruption a part of the way is repeated.
    let mut world = connected();
    let items = vec![
        MissionItem::takeoff(40.3332, -3.7990, 50.0, 12.0),
        MissionItem::action(Command::DO_SET_RESUME_REPEAT_DIST, [100.0, 0.0, 0.0, 0.0]),
        MissionItem::waypoint(40.3340, -3.8030, 80.0),
        MissionItem::waypoint(40.3345, -3.8000, 40.0),
    ];
    let plan = Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: true };
    ask(&mut world, plan).expect("uploaded");
    fly(&mut world, 12, 4);
    assert_eq!(resumed(&mut world, 3), (0, 3));
}

#[test]
fn auto_is_entered_when_a_mission_runs() {
    let mut world = connected();
    // As the newest firmware without a mission: it shows AUTO once, and returns.
    world.plane.mission_state = MissionState::MISSION_STATE_NO_MISSION;
    let id = start(&mut world, mode("AUTO"));
    wait(&mut world, 200);
    world.plane.heartbeat();
    world.plane.mode = 11;
    let error = end(&mut world, id, 30).expect_err("it returns");
    assert!(matches!(&error, VehicleError::NotConfirmed { observed, .. } if observed == "mode RTL"), "{error}");
    let error = ask(&mut world, mode("AUTO")).expect_err("no mission runs");
    let idle = "mode AUTO without a running mission";
    assert!(matches!(&error, VehicleError::NotConfirmed { observed, .. } if observed == idle), "{error}");
    world.plane.mission_state = MissionState::MISSION_STATE_ACTIVE;
    assert_eq!(ask(&mut world, mode("AUTO")), Ok(Reply::Done));
    // Of one that says nothing of its mission the mode is all there is.
    world.plane.is_streaming = false;
    world.plane.mode = 5;
    wait(&mut world, 8_000);
    assert_eq!(ask(&mut world, mode("AUTO")), Ok(Reply::Done));
}

// ArduPlane changes to AUTO at the landing also while it is disarmed, and flies it when it is armed.
#[test]
fn a_disarmed_plane_is_not_sent_to_its_landing() {
    for mut world in [in_auto(2), unmarked(2)] {
        (world.plane.is_armed, world.plane.mode) = (false, 0);
        world.plane.landed = MavLandedState::MAV_LANDED_STATE_ON_GROUND;
        wait(&mut world, 1_500);
        let before = world.plane.commands.len();
        let error = ask(&mut world, Request::Land).expect_err("refused");
        assert!(matches!(error, VehicleError::NotFlying { action: "landing", .. }), "{error}");
        let sent = |command: Command| world.plane.commands[before..].iter().any(|long| long.command == command.0);
        assert!(world.plane.mode == 0 && !sent(Command::DO_LAND_START) && !sent(Command::DO_SET_MISSION_CURRENT));
    }
}

#[test]
fn a_landing_without_its_mark_is_flown_from_its_last_leg() {
    let mut world = unmarked(2);
    fly(&mut world, 11, 2);
    assert_eq!(ask(&mut world, Request::Land), Ok(Reply::Done));
    assert_eq!((world.plane.mode, world.plane.current), (AUTO, 3));
    assert_eq!(count(&world, Command::DO_LAND_START), 0, "it would be refused");
    // On final nothing is sent.
    fly(&mut world, AUTO, 5);
    let before = count(&world, Command::DO_SET_MISSION_CURRENT);
    assert_eq!(ask(&mut world, Request::Land), Ok(Reply::Done));
    assert_eq!(count(&world, Command::DO_SET_MISSION_CURRENT), before);
}
