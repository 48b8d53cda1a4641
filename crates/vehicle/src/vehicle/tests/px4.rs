//! What a PX4 takes otherwise than an ArduPilot: read in its source and its issues, not tried on one. And what is asked
//! of an autopilot that is neither.

use vencejo_flight::plan::{MavFrame, plan_changes};
use vencejo_proto::dialect::{
    CURRENT_EVENT_SEQUENCE_DATA, MISSION_REQUEST_INT_DATA, MavEventCurrentSequenceFlags, REQUEST_EVENT_DATA,
    SYSTEM_TIME_DATA,
};
use vencejo_proto::param::ParamEncoding;

use super::*;
use crate::command::CommandMessage;
use crate::transfer::TransferError;
use crate::vehicle::guard::Act;

/// `MAV_AUTOPILOT_PX4`.
const PX4: u8 = 12;
/// AUTO.LOITER: main mode 4, sub mode 3.
const AUTO_LOITER: u32 = (4 << 16) | (3 << 24);
/// AUTO.RTL: main mode 4, sub mode 5.
const AUTO_RTL: u32 = (4 << 16) | (5 << 24);
/// AUTO.MISSION: main mode 4, sub mode 4.
pub(super) const AUTO_MISSION: u32 = (4 << 16) | (4 << 24);

fn px4() -> Plane {
    let mut plane = Plane::new();
    (plane.autopilot, plane.mode, plane.is_armed) = (PX4, AUTO_LOITER, true);
    plane.services.param_encoding = ParamEncoding::Bytewise;
    (plane.services.is_px4, plane.services.keeps_home) = (true, false);
    plane
}

impl Plane {
    /// It flies to every position, answers that it does not know the command without the leave to change its mode, and
    /// leaves a position outside of its fence to a text (v1.17.0, `Commander.cpp`, `navigator_main.cpp`).
    pub(super) fn reposition_px4(&mut self, changes_mode: bool) -> u8 {
        if !changes_mode {
            return 3;
        }
        self.circle_px4("Reposition")
    }

    pub(super) fn circle_px4(&mut self, what: &str) -> u8 {
        self.mode = AUTO_LOITER;
        if self.is_outside_fence {
            self.text(2, &format!("{what} is outside geofence"));
        }
        0
    }
}

/// Its events, as recorded of v1.17.0: their ids, and what its checks report of a mode without a mission.
const NO_MISSION: u32 = 0x0105_c2d9;
const TOO_STEEP: u32 = 0x0148_d925;
const CORRECT_SLOPE: u32 = 0x01b0_9425;

impl Plane {
    fn event(&mut self, id: u32, log_levels: u8, arguments: &[u8]) {
        let mut event = EVENT_DATA { id, sequence: self.events.len() as u16, log_levels, ..Default::default() };
        event.arguments[..arguments.len()].copy_from_slice(arguments);
        self.events.push(event.clone());
        self.out.push_back(Message::Dialect(MavMessage::EVENT(event)));
    }

    fn check(&mut self, id: u32, level: u8, modes: u32, arguments: &[u8]) {
        self.event(id, level, &[&modes.to_le_bytes()[..], &[20], arguments].concat());
    }

    /// Reports all checks that fail.
    fn report_checks(&mut self, can_arm: u32, checks: &[(u32, u8, u32, &[u8])]) {
        self.event(0x01a8_93e0, 0x88, &[&[0; 9][..], &can_arm.to_le_bytes(), &can_arm.to_le_bytes()].concat());
        for (id, level, modes, arguments) in checks {
            self.check(*id, *level, *modes, arguments);
        }
        self.event(0x011d_3727, 0x88, &[0; 13]);
    }

    pub(super) fn on_request_event(&mut self, request: &REQUEST_EVENT_DATA) {
        self.events_asked += 1;
        let asked = request.last_sequence.wrapping_sub(request.first_sequence);
        for sequence in (0..=asked).map(|at| request.first_sequence.wrapping_add(at)) {
            if let Some(event) = self.events.get(usize::from(sequence)) {
                self.out.push_back(Message::Dialect(MavMessage::EVENT(event.clone())));
            }
        }
    }

    fn tell_newest_event(&mut self) {
        let sequence = self.events.len().wrapping_sub(1) as u16;
        let flags = MavEventCurrentSequenceFlags::empty();
        let told = CURRENT_EVENT_SEQUENCE_DATA { sequence, flags };
        self.out.push_back(Message::Dialect(MavMessage::CURRENT_EVENT_SEQUENCE(told)));
    }
}

fn flying(config: VehicleConfig) -> Pair {
    let mut world = World::new(Station::with(config), px4(), Faults::default(), 1);
    wait(&mut world, 3_000);
    world
}

/// One that is asked for nothing by itself.
fn unasked() -> VehicleConfig {
    VehicleConfig { streams: StreamConfig::listen_only(), ..VehicleConfig::default() }
}

fn go_to(alt_m: f64, alt_frame: AltFrame) -> Request {
    circling(alt_m, alt_frame, None, Turn::Clockwise, None)
}

fn circling(alt_m: f64, alt_frame: AltFrame, radius_m: Option<f64>, turn: Turn, speed_m_s: Option<f64>) -> Request {
    Request::Reposition {
        lat_deg: 40.334,
        lon_deg: -3.79,
        alt_m,
        alt_frame,
        radius_m,
        turn,
        speed_m_s,
        change_mode: true,
        below_home: false,
    }
}

// Its MAVLink receiver drops the frame of a COMMAND_INT, and its navigator takes the height as one above mean sea level
// (PX4 issues 8502, 10246, 28257).
#[test]
fn it_is_sent_heights_above_mean_sea_level() {
    let mut world = flying(VehicleConfig::default());
    let home_m = world.station.vehicle.telemetry().home.expect("home").value.alt_amsl_m;
    assert!((home_m - 600.09).abs() < 1e-6);
    for (alt_m, alt_frame, sent_m) in
        [(100.0, AltFrame::RelHome, 700.09), (0.0, AltFrame::RelHome, 600.09), (750.0, AltFrame::Amsl, 750.0)]
    {
        assert_eq!(ask(&mut world, go_to(alt_m, alt_frame)), Ok(Reply::Done));
        let sent = world.plane.ints.last().expect("a go-to");
        assert_eq!((sent.command, sent.frame, sent.z), (Command::DO_REPOSITION.0, 0, sent_m));
        assert_eq!(ask(&mut world, Request::ChangeAltitude { alt_m, alt_frame, below_home: false }), Ok(Reply::Done));
        let sent = world.plane.commands.last().expect("a change of height");
        assert_eq!((sent.command, sent.params[0], sent.params[1]), (Command::DO_CHANGE_ALTITUDE.0, sent_m, 0.0));
    }
}

// Each of these makes it leave the mode that its pilot has chosen meanwhile.
#[test]
fn what_is_repeated_takes_it_from_no_pilot() {
    const POSITION: u32 = 3 << 16;
    let circle = circling(100.0, AltFrame::RelHome, Some(80.0), Turn::Clockwise, None);
    let height = Request::ChangeAltitude { alt_m: 100.0, alt_frame: AltFrame::RelHome, below_home: false };
    for request in [go_to(100.0, AltFrame::RelHome), circle, height] {
        let mut world = flying(VehicleConfig::default());
        let before = world.plane.commands.len() + world.plane.ints.len();
        world.plane.mute = 9;
        let id = start(&mut world, request.clone());
        wait(&mut world, 300);
        world.plane.mode = POSITION;
        let ended = end(&mut world, id, 60);
        assert!(matches!(ended, Err(VehicleError::NotConfirmed { .. })), "{request:?}: {ended:?}");
        assert_eq!(world.plane.mode, POSITION, "{request:?}");
        let sent = world.plane.commands.len() + world.plane.ints.len() - before;
        assert_eq!(sent, 1, "{request:?}");
        // What did not arrive is repeated while nobody has changed the mode.
        let mut world = flying(VehicleConfig::default());
        world.plane.deaf = 1;
        assert_eq!(ask(&mut world, request), Ok(Reply::Done));
    }
}

#[test]
fn a_height_that_cannot_be_counted_from_there_is_not_sent() {
    let (mut world, mut homeless) = (flying(VehicleConfig::default()), flying(unasked()));
    let before = world.plane.commands.len();
    for terrain in [
        go_to(80.0, AltFrame::Terrain),
        Request::ChangeAltitude { alt_m: 80.0, alt_frame: AltFrame::Terrain, below_home: false },
    ] {
        let error = ask(&mut world, terrain).expect_err("it knows no such frame");
        assert!(matches!(error, VehicleError::InvalidValue { field: "alt_frame", .. }), "{error}");
    }
    for (alt_m, alt_frame) in [(1e9, AltFrame::RelHome), (f64::NAN, AltFrame::RelHome), (f64::NAN, AltFrame::Amsl)] {
        for request in [go_to(alt_m, alt_frame), Request::ChangeAltitude { alt_m, alt_frame, below_home: false }] {
            assert!(matches!(ask(&mut world, request), Err(VehicleError::InvalidValue { field: "alt_m", .. })));
        }
    }
    for request in [
        go_to(80.0, AltFrame::RelHome),
        Request::ChangeAltitude { alt_m: 80.0, alt_frame: AltFrame::RelHome, below_home: false },
    ] {
        assert_eq!(ask(&mut homeless, request), Err(VehicleError::HomeUnknown));
    }
    assert_eq!((world.plane.commands.len(), homeless.plane.commands.len()), (before, 0));
    assert!(world.plane.ints.is_empty() && homeless.plane.ints.is_empty());
}

// 5 was written as the bits of 5.0, which are 1084227584, and told as set: the vehicle gives back the bits that it got.
#[test]
fn an_integer_is_set_as_one_before_it_has_told_its_capabilities() {
    let mut world = flying(unasked());
    let name = ParamName::new("COM_FLTMODE1").expect("a name");
    world.plane.services.params.push(Param::new(name, ParamValue::I32(0)));
    assert_eq!(world.station.vehicle.telemetry().version, None);
    let set = Request::ParamSet { name: "COM_FLTMODE1".into(), value: 5.0 };
    let kept = Param::new(name, ParamValue::I32(5));
    assert_eq!(ask(&mut world, set.clone()), Ok(Reply::Parameter(kept)));
    assert_eq!(world.plane.services.params.last(), Some(&kept));
    assert_eq!(ask(&mut world, Request::ParamRead { name: "COM_FLTMODE1".into() }), Ok(Reply::Parameter(kept)));
    // It is the same thing after a restart, before its next heartbeat.
    let now = world.now;
    world.station.vehicle.on_restart(now, now);
    let prepare = world.station.vehicle.request(Request::PrepareFlight, now);
    let kept = Param::new(name, ParamValue::I32(6));
    let again = Request::ParamSet { name: "COM_FLTMODE1".into(), value: 6.0 };
    assert_eq!(ask(&mut world, again), Ok(Reply::Parameter(kept)));
    let Err(VehicleError::NotHeard { age }) = world.station.results[&prepare] else { panic!("it waits for one") };
    assert!(age <= Duration::from_secs(1), "{age:?}");
    // What it is is not known before its first heartbeat.
    let mut unheard = World::new(Station::with(unasked()), px4(), Faults::default(), 1);
    assert!(matches!(ask(&mut unheard, set), Err(VehicleError::NotHeard { .. })));
}

// 5 went to it as the number 5.0, whatever it takes: to one that takes bytes as 1084227584.
#[test]
fn an_integer_is_set_as_the_values_of_an_unknown_autopilot_show() {
    let param = |name: &str, value| Param::new(ParamName::new(name).expect("a name"), value);
    let set = |name: &str, value| Request::ParamSet { name: name.into(), value };
    for encoding in [ParamEncoding::CCast, ParamEncoding::Bytewise] {
        let unknown = || {
            let mut plane = px4();
            plane.autopilot = 0;
            plane.services.param_encoding = encoding;
            let values = [ParamValue::I32(-7), ParamValue::I32(0), ParamValue::F32(1.5)];
            plane.services.params =
                ["SEVEN", "ZERO", "FLOAT"].into_iter().zip(values).map(|(n, v)| param(n, v)).collect();
            let mut world = World::new(Station::with(unasked()), plane, Faults::default(), 1);
            wait(&mut world, 3_000);
            world
        };
        // The value that is there shows it.
        assert_eq!(ask(&mut unknown(), set("SEVEN", 5.0)), Ok(Reply::Parameter(param("SEVEN", ParamValue::I32(5)))));
        let mut world = unknown();
        let error = ask(&mut world, set("ZERO", 5.0)).expect_err("it may be both");
        assert!(error.to_string().contains("read all of its parameters"), "{error}");
        assert_eq!(world.plane.services.sets, 0);
        assert_eq!(ask(&mut world, set("FLOAT", 2.5)), Ok(Reply::Parameter(param("FLOAT", ParamValue::F32(2.5)))));
        // Another one does.
        let Ok(Reply::Parameters(all)) = ask(&mut world, Request::ParamList) else { panic!("listed") };
        assert_eq!(all[..2], [param("SEVEN", ParamValue::I32(-7)), param("ZERO", ParamValue::I32(0))], "{encoding:?}");
        assert_eq!(ask(&mut world, set("ZERO", 5.0)), Ok(Reply::Parameter(param("ZERO", ParamValue::I32(5)))));
    }
}

#[test]
fn a_mission_that_is_called_otherwise_while_it_is_read_back_is_read_again() {
    let mut vehicle = Vehicle::new(PLANE, STATION, unasked(), MonoTime::ZERO);
    let now = MonoTime::from_millis(10);
    let items = vec![MissionItem::waypoint(40.33, -3.8, 80.0)];
    let wire = |target| items[0].to_wire(MissionSeq(0), target, PlanKind::Mission, false);
    let current = |mission_id| {
        Message::Dialect(MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA {
            total: 1,
            mission_id,
            ..Default::default()
        }))
    };
    let count = |count| {
        let (target_system, target_component) = (STATION.system.0, STATION.component.0);
        let data = MISSION_COUNT_DATA { count, target_system, target_component, ..Default::default() };
        Message::Dialect(MavMessage::MISSION_COUNT(data))
    };
    let asks = Message::Dialect(MavMessage::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
        target_system: STATION.system.0,
        target_component: STATION.component.0,
        ..Default::default()
    }));
    let ack = Message::MissionAck(MissionAck { target: STATION, result: 0, mission_type: 0, opaque_id: 7 });
    let heartbeat = Heartbeat { mav_type: 1, autopilot: PX4, mavlink_version: 3, ..Heartbeat::default() };
    vehicle.on_message(PLANE.component, &Message::Heartbeat(heartbeat), now);
    let request =
        Request::UploadPlan { kind: PlanKind::Mission, items: items.clone(), home: None, despite_findings: false };
    vehicle.request(request, now);
    let mut told = |messages: &[Message]| {
        for message in messages {
            vehicle.on_message(PLANE.component, message, now);
        }
        let outputs: Vec<_> = std::iter::from_fn(|| vehicle.poll_output()).collect();
        let lists = outputs
            .iter()
            .filter(|output| matches!(output, Output::Send(Message::Dialect(MavMessage::MISSION_REQUEST_LIST(_)))));
        let ends = outputs.iter().filter(|output| matches!(output, Output::Finished { result: Ok(_), .. }));
        (lists.count(), ends.count())
    };
    let item = Message::MissionItemInt(wire(STATION));
    assert_eq!(told(&[current(3), asks, ack]), (1, 0));
    assert_eq!(told(&[count(1), current(7)]), (0, 0), "ours");
    assert_eq!(told(&[current(9), item.clone()]), (1, 0), "another one");
    assert_eq!(told(&[count(1), item]), (0, 1));
    // What it called ours tells an echo of it from another's, just after it too.
    assert_eq!(told(&[current(7)]), (0, 0));
    assert!(matches!(vehicle.plan_state(PlanKind::Mission), PlanState::Verified { count: 1, .. }));
    vehicle.on_message(PLANE.component, &current(11), now);
    assert_eq!(vehicle.plan_state(PlanKind::Mission), PlanState::Unknown(Unknown::ChangedElsewhere));
}

// AUTO_LAND brings a fixed wing down in circles where it is (PX4 v1.17.0, `control_auto_landing_circular`).
#[test]
fn a_plane_lands_on_the_landing_of_its_mission() {
    let landing = |world: &mut Pair| {
        let before = world.plane.commands.len();
        let result = ask(world, Request::Land);
        (result, acts(world, before))
    };
    let to_landing = vec![(Command::DO_LAND_START.0, 0.0, 0.0)];
    let mut world = flying(VehicleConfig::default());
    world.plane.landed = MavLandedState::MAV_LANDED_STATE_IN_AIR;
    wait(&mut world, 1_500);
    // It knows whether there is one while we do not.
    assert_eq!(landing(&mut world), (Ok(Reply::Done), to_landing.clone()));
    assert_eq!(world.plane.mode, AUTO_MISSION);

    let send = |world: &mut Pair, items: Vec<MissionItem>| {
        ask(world, Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false })
            .expect("uploaded");
    };
    send(&mut world, vec![MissionItem::waypoint(40.334, -3.803, 80.0), MissionItem::land(40.3332, -3.7978, 0.0)]);
    (world.plane.mode, world.plane.current) = (AUTO_LOITER, 0);
    wait(&mut world, 1_500);
    assert_eq!(landing(&mut world), (Ok(Reply::Done), to_landing));
    assert_eq!(world.plane.mode, AUTO_MISSION);
    world.plane.current = 1;
    wait(&mut world, 1_500);
    assert_eq!(landing(&mut world), (Ok(Reply::Done), vec![]), "on final");

    send(&mut world, vec![MissionItem::waypoint(40.334, -3.803, 80.0)]);
    let (result, sent) = landing(&mut world);
    let error = result.expect_err("nowhere to land").to_string();
    assert!(error.contains("return to launch") && error.contains("AUTO_LAND"), "{error}");
    assert_eq!(sent, []);

    // On the ground it would arm and take off.
    for (is_armed, landed) in
        [(false, MavLandedState::MAV_LANDED_STATE_ON_GROUND), (true, MavLandedState::MAV_LANDED_STATE_ON_GROUND)]
    {
        (world.plane.is_armed, world.plane.landed, world.plane.mode) = (is_armed, landed, AUTO_LOITER);
        wait(&mut world, 1_500);
        let (result, sent) = landing(&mut world);
        assert!(result.expect_err("on the ground").to_string().contains("would arm and take off"));
        assert_eq!(sent, []);
    }

    let mut copter = px4();
    copter.mav_type = 2;
    let mut world = World::new(Station::with(VehicleConfig::default()), copter, Faults::default(), 1);
    wait(&mut world, 3_000);
    assert_eq!(landing(&mut world), (Ok(Reply::Done), vec![(Command::DO_SET_MODE.0, 1.0, 4.0)]));
}

// It stays in AUTO_MISSION when a flight has ended, and takes off when it is armed there.
#[test]
fn a_flight_is_prepared_in_a_mode_that_does_not_take_off() {
    let mut plane = px4();
    (plane.mode, plane.is_armed) = (AUTO_MISSION, false);
    let mut world = World::new(Station::with(VehicleConfig::default()), plane, Faults::default(), 1);
    wait(&mut world, 3_000);
    assert_eq!(ask(&mut world, Request::PrepareFlight), Ok(Reply::Done));
    assert_eq!((world.plane.mode, world.plane.is_armed), (AUTO_LOITER, false));
}

// PX4 v1.17.0 takes an item without a position in MAV_FRAME_MISSION alone, and gives 0 back for what it does not use.
#[test]
fn a_mission_is_verified_by_what_it_keeps() {
    let mut world = flying(VehicleConfig::default());
    let with = |item: MissionItem, params: [f64; 4]| {
        let place = [item.params[4], item.params[5], item.params[6]];
        let [x, y, z] = place;
        let [p1, p2, p3, p4] = params.map(Some);
        MissionItem { params: [p1, p2, p3, p4, x, y, z], ..item }
    };
    let in_frame_3 = |item: MissionItem| MissionItem { frame: MavFrame::GlobalRelativeAlt, ..item };
    let items = vec![
        MissionItem::takeoff(40.3332, -3.799, 50.0, 12.0),
        in_frame_3(MissionItem::change_airspeed(14.0)),
        with(MissionItem::waypoint(40.334, -3.803, 80.0), [2.0, 30.0, 5.0, -90.0]),
        MissionItem::loiter_time(40.335, -3.8, 80.0, 60.0, false),
        with(MissionItem::loiter_to_alt(40.336, -3.8, 60.0, -60.0), [2.0, -60.0, 7.0, 1.0]),
        MissionItem::loiter_unlimited(40.337, -3.8, 60.0, 60.0),
        MissionItem::jump(MissionSeq(3), 1),
        MissionItem::land_start(40.3332, -3.7912, 40.0),
        with(MissionItem::land(40.3332, -3.7978, 0.0), [30.0, 0.0, 0.0, 0.0]),
        in_frame_3(MissionItem::return_to_launch()),
    ];
    let send = |items: &[MissionItem]| Request::UploadPlan {
        kind: PlanKind::Mission,
        items: items.to_vec(),
        home: None,
        despite_findings: false,
    };
    ask(&mut world, send(&items)).expect("verified");
    assert!(matches!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Verified { count: 10, .. }));
    let keeping = world.station.vehicle.keeping();
    let changes = |world: &Pair| {
        let read = world.plane.services.plans[0].clone();
        plan_changes(&items, &Mission::from_wire(&read, false).expect("a mission").items, keeping).len()
    };
    assert_eq!(changes(&world), 0);
    // It knows no turns; items are counted from 1.
    let turns =
        [MissionItem::takeoff(40.3332, -3.799, 50.0, 0.0), MissionItem::loiter_turns(40.335, -3.8, 80.0, 2.0, 60.0)];
    let error = ask(&mut world, send(&turns)).expect_err("unknown to it").to_string();
    assert!(error.contains("at item 2"), "{error}");
    ask(&mut world, send(&items)).expect("verified");
    // What it does use counts.
    world.plane.services.plans[0][2].params[1] = 31.0;
    assert_eq!(changes(&world), 1);
}

// It acknowledges and stores what it then does not fly (PX4 v1.17.0, `FeasibilityChecker`).
#[test]
fn a_mission_that_its_checks_reject_is_not_told_as_sent() {
    const REASON: &str = "Mission rejected: Takeoff waypoint required.";
    let upload = || {
        let items = vec![MissionItem::waypoint(40.334, -3.803, 80.0), MissionItem::land(40.3332, -3.7978, 0.0)];
        Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false }
    };
    let mut world = flying(VehicleConfig::default());
    world.plane.mission_state = MissionState::MISSION_STATE_NOT_STARTED;
    ask(&mut world, upload()).expect("flyable");
    let id = start(&mut world, upload());
    world.plane.mission_state = MissionState::MISSION_STATE_NO_MISSION;
    world.plane.text(2, REASON);
    let error = end(&mut world, id, 10).expect_err("rejected").to_string();
    assert!(error.contains(REASON), "{error}");
    assert!(matches!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Verified { count: 2, .. }));
    // As the first thing after it was heard.
    let mut plane = px4();
    plane.mission_state = MissionState::MISSION_STATE_NO_MISSION;
    let mut new = World::new(Station::new(), plane, Faults::default(), 1);
    new.run(MonoTime::from_millis(200), |station, _| station.vehicle.telemetry().heartbeat.is_some());
    assert!(new.station.vehicle.telemetry().mission.is_none());
    let id = start(&mut new, upload());
    new.plane.text(2, REASON);
    assert!(end(&mut new, id, 10).expect_err("rejected").to_string().contains(REASON));
    // The reason as an event alone, a moment after that.
    let id = start(&mut world, upload());
    wait(&mut world, 1_500);
    world.plane.event(TOO_STEEP, 0x63, &[5, 0]);
    world.plane.event(CORRECT_SLOPE, 0x63, &[0x13, 0, 0, 0, 0xf1, 3, 0, 0]);
    let error = end(&mut world, id, 10).expect_err("rejected");
    let VehicleError::Transfer(TransferError::Rejected { reasons }) = &error else { panic!("{error}") };
    assert_eq!(reasons[0], "the landing is steeper than 5.0 degrees (FW_LND_ANG)");
    // One that tells nothing more of its mission is believed.
    let id = start(&mut world, upload());
    world.plane.is_streaming = false;
    end(&mut world, id, 10).expect("on board");
}

// It says "Arming denied: Resolve system health failures first" whatever is wrong, and that only when it begins.
#[test]
fn a_refusal_to_arm_names_what_it_said_before() {
    let mut plane = px4();
    (plane.mode, plane.is_armed) = (AUTO_MISSION, false);
    plane.refuses = Some(vec!["Arming denied: Resolve system health failures"]);
    plane.mission_state = MissionState::MISSION_STATE_NO_MISSION;
    let mut world = World::new(Station::with(VehicleConfig::default()), plane, Faults::default(), 1);
    wait(&mut world, 3_000);
    world.plane.text(2, "Preflight Fail: Accel 0 uncalibrated");
    wait(&mut world, 10_000);
    let Err(VehicleError::CommandRefused { reasons, .. }) = ask(&mut world, ARM) else { panic!("refused") };
    assert_eq!(
        reasons,
        [
            "Preflight Fail: Accel 0 uncalibrated",
            "Arming denied: Resolve system health failures",
            "mode AUTO_MISSION, and no mission on board that it can fly",
        ]
    );
}

// Why it does not arm comes as events alone; "No valid mission available" even as an information.
#[test]
fn what_keeps_it_from_arming_is_told_by_its_events() {
    const MISSION_BIT: u32 = 1 << 3;
    let texts =
        |world: &Pair| -> Vec<String> { world.station.vehicle.texts().iter().map(|text| text.text.clone()).collect() };
    let count = |world: &Pair, text: &str| texts(world).iter().filter(|told| *told == text).count();
    let mut plane = px4();
    (plane.mode, plane.is_armed) = (AUTO_MISSION, false);
    plane.refuses = Some(vec!["Arming denied: Resolve system health failures"]);
    plane.mission_state = MissionState::MISSION_STATE_NO_MISSION;
    // Reported before it was connected. The compass is optional in this one.
    let optional: (u32, u8, u32, &[u8]) = (0x0167_c97b, 0x44, u32::MAX, &[]);
    plane.report_checks(!MISSION_BIT, &[optional, (NO_MISSION, 0x66, MISSION_BIT, &[])]);
    plane.out.clear();
    let mut world = World::new(Station::with(VehicleConfig::default()), plane, Faults::default(), 1);
    wait(&mut world, 2_500);
    world.plane.tell_newest_event();
    wait(&mut world, 2_000);
    const NONE: &str = "Preflight Fail: No mission on board that it can fly";
    assert_eq!((world.plane.events_asked, count(&world, NONE)), (1, 1), "{:?}", texts(&world));
    let Err(VehicleError::CommandRefused { reasons, .. }) = ask(&mut world, ARM) else { panic!("refused") };
    assert_eq!(reasons, ["Arming denied: Resolve system health failures", NONE]);
    // As long as it fails it is repeated, as an ArduPilot repeats its own.
    wait(&mut world, 62_000);
    assert_eq!(count(&world, NONE), 3);

    // Another one begins to fail, of which a part is lost; its text is one with the event's, an unknown one is named.
    let compass: (u32, u8, u32, &[u8]) = (crate::events::id("check_mag_not_calibrated"), 0x33, u32::MAX, &[2]);
    world.plane.report_checks(0, &[compass, (0x0112_3456, 0x33, u32::MAX, &[])]);
    world.plane.out.remove(1);
    world.plane.text(2, "Preflight Fail: Compass 2 uncalibrated\t");
    wait(&mut world, 2_000);
    assert_eq!(world.plane.events_asked, 2);
    assert_eq!(count(&world, "Preflight Fail: Compass 2 uncalibrated"), 1);
    assert_eq!(count(&world, "Preflight Fail: a check that is not known here (event 0x01123456)"), 1);
    // In a mode flown by stick the mission is not needed, and armed it is no matter.
    world.plane.mode = AUTO_LOITER;
    wait(&mut world, 1_500);
    world.plane.report_checks(!MISSION_BIT, &[(NO_MISSION, 0x66, MISSION_BIT, &[])]);
    wait(&mut world, 40_000);
    assert_eq!(count(&world, NONE), 3);
    world.plane.refuses = None;
    assert_eq!(ask(&mut world, ARM), Ok(Reply::Done));
}

#[test]
fn a_go_to_outside_of_its_fence_is_refused() {
    let mut world = flying(VehicleConfig::default());
    let go = || go_to(80.0, AltFrame::RelHome);
    assert_eq!(ask(&mut world, go()), Ok(Reply::Done));
    world.plane.is_outside_fence = true;
    let Err(VehicleError::CommandRefused { reasons, .. }) = ask(&mut world, go()) else { panic!("outside") };
    assert_eq!(reasons, ["Reposition is outside geofence"]);
}

// Without its flag it answers that it does not know the command, and flies there; and a change of altitude changes the
// mode.
#[test]
fn what_would_leave_the_mode_is_not_sent() {
    let mut world = flying(VehicleConfig::default());
    let stay = || match go_to(80.0, AltFrame::RelHome) {
        Request::Reposition { lat_deg, lon_deg, alt_m, alt_frame, radius_m, turn, speed_m_s, below_home, .. } => {
            Request::Reposition {
                lat_deg,
                lon_deg,
                alt_m,
                alt_frame,
                radius_m,
                turn,
                speed_m_s,
                change_mode: false,
                below_home,
            }
        }
        other => other,
    };
    let climb = || Request::ChangeAltitude { alt_m: 90.0, alt_frame: AltFrame::RelHome, below_home: false };
    assert_eq!(ask(&mut world, stay()), Ok(Reply::Done));
    assert_eq!(world.plane.ints.last().map(|int| int.params[1]), Some(1.0));
    assert_eq!(ask(&mut world, climb()), Ok(Reply::Done));
    world.plane.mode = AUTO_MISSION;
    wait(&mut world, 1_500);
    let before = (world.plane.commands.len(), world.plane.ints.len());
    for request in [stay(), climb()] {
        let error = ask(&mut world, request).expect_err("it would circle").to_string();
        assert!(error.contains("AUTO_LOITER"), "{error}");
    }
    assert_eq!((world.plane.commands.len(), world.plane.ints.len()), before);
}

// DO_REPOSITION has no circle, and the speed is lost with the change of mode (v1.17.0, `navigator_main.cpp`).
#[test]
fn a_circle_of_its_own_is_flown_by_an_orbit_and_the_speed_set_after_it() {
    let mut world = flying(VehicleConfig::default());
    let with = |radius_m, turn, speed_m_s| circling(80.0, AltFrame::RelHome, radius_m, turn, speed_m_s);
    for (radius_m, turn, command, radius) in [
        (None, Turn::Clockwise, Command::DO_REPOSITION, -1.0),
        (Some(150.0), Turn::Clockwise, Command::DO_ORBIT, 150.0),
        (Some(150.0), Turn::CounterClockwise, Command::DO_ORBIT, -150.0),
    ] {
        assert_eq!(ask(&mut world, with(radius_m, turn, Some(14.0))), Ok(Reply::Done));
        let sent = world.plane.ints.last().expect("a go-to");
        assert_eq!((sent.command, sent.params[0], sent.z), (command.0, radius, 680.09));
        let speed = world.plane.commands.last().expect("a speed");
        assert_eq!((speed.command, speed.params[0], speed.params[1]), (Command::DO_CHANGE_SPEED.0, 0.0, 14.0));
    }
    // Its answer may be lost.
    world.plane.mute = 1;
    assert_eq!(ask(&mut world, with(Some(150.0), Turn::Clockwise, None)), Ok(Reply::Done));
    let error = ask(&mut world, with(None, Turn::CounterClockwise, None)).expect_err("no radius");
    assert!(matches!(error, VehicleError::InvalidValue { field: "radius_m", .. }), "{error}");
    world.plane.is_outside_fence = true;
    let Err(VehicleError::CommandRefused { reasons, .. }) = ask(&mut world, with(Some(80.0), Turn::Clockwise, None))
    else {
        panic!("outside")
    };
    assert_eq!(reasons, ["Orbit is outside geofence"]);
}

// RTL_TYPE 1 makes the landing the current item, before the mode is shown or after.
#[test]
fn a_mission_left_to_return_goes_on_where_it_was_left() {
    let waypoint = || MissionItem::waypoint(40.334, -3.803, 80.0);
    let items = vec![
        MissionItem::takeoff(40.3332, -3.799, 50.0, 0.0),
        waypoint(),
        waypoint(),
        MissionItem::land_start(40.3332, -3.7912, 40.0),
        waypoint(),
        MissionItem::land(40.3332, -3.7978, 0.0),
    ];
    let upload = Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false };
    let mut world = flying(VehicleConfig::default());
    ask(&mut world, upload).expect("uploaded");
    let mission = (Command::DO_SET_MODE.0, 1.0, 4.0);
    let to = |seq| (Command::DO_SET_MISSION_CURRENT.0, seq, 0.0);
    // A failsafe holds for 5 s (COM_FAIL_ACT_T), a pilot for as long as he likes.
    for (from, holds_ms, jumps_first, sent) in [
        (2, 0, false, vec![mission, to(2.0)]),
        (2, 0, true, vec![mission, to(2.0)]),
        (2, 5_000, false, vec![mission, to(2.0)]),
        (2, 60_000, true, vec![mission, to(2.0)]),
        (4, 0, false, vec![mission]),
        (4, 5_000, false, vec![mission]),
    ] {
        fly_and_return(&mut world, from, holds_ms, jumps_first);
        let before = world.plane.commands.len();
        assert_eq!(ask(&mut world, Request::MissionResume), Ok(Reply::Done));
        assert_eq!(acts(&world, before), sent, "from {from}, {holds_ms} ms in AUTO_LOITER, {jumps_first}");
    }
    // Set to another item meanwhile, by this station or another, it goes on there.
    for (chosen, by_us) in [(1, true), (1, false), (5, true)] {
        fly_and_return(&mut world, 2, 5_000, false);
        if by_us {
            assert_eq!(ask(&mut world, Request::SetCurrentItem { item: chosen + 1 }), Ok(Reply::Done));
        }
        world.plane.current = chosen;
        wait(&mut world, 1_500);
        let before = world.plane.commands.len();
        assert_eq!(ask(&mut world, Request::MissionResume), Ok(Reply::Done));
        assert_eq!((acts(&world, before), world.plane.current), (vec![mission], chosen), "by us: {by_us}");
    }
}

/// Flies item `from` of its mission, and returns, perhaps after a while in AUTO_LOITER.
fn fly_and_return(world: &mut Pair, from: u16, holds_ms: u64, jumps_first: bool) {
    (world.plane.mode, world.plane.current) = (AUTO_MISSION, from);
    wait(world, 6_000);
    if holds_ms > 0 {
        world.plane.mode = AUTO_LOITER;
        wait(world, holds_ms);
    }
    if jumps_first {
        world.plane.current = 4;
        wait(world, 500);
    }
    world.plane.mode = AUTO_RTL;
    wait(world, 1_500);
    world.plane.current = 4;
    wait(world, 3_000);
}

#[test]
fn what_it_does_not_take_is_not_sent() {
    let mut world = flying(VehicleConfig::default());
    let before = world.plane.commands.len();
    for (request, word) in [
        (Request::SwitchFence { on: true }, "GF_ACTION"),
        (Request::AbortLanding { alt_rel_home_m: Some(60.0) }, "MIS_LND_ABRT_ALT"),
    ] {
        let error = ask(&mut world, request).expect_err("not taken").to_string();
        assert!(error.contains(word), "{error}");
    }
    assert_eq!(acts(&world, before), []);
    world.plane.is_armed = false;
    world.plane.refuses = Some(vec![]);
    wait(&mut world, 1_500);
    let error = ask(&mut world, Request::Arm { force: true }).expect_err("its checks fail").to_string();
    assert!(error.contains("runs its checks also when it is to be armed by force"), "{error}");
}

// It arms and flies the mission, which may be a mixture or lead out of reach.
#[test]
fn a_raw_start_of_its_mission_is_guarded() {
    let mut world = flying(unasked());
    let act = |world: &Pair, command: Command| {
        world.station.vehicle.act_of(&CommandMessage::long(PLANE, command, [0.0; 7]).to_message())
    };
    assert_eq!(act(&world, Command::DO_LAND_START), Some(Act::Jump));
    world.plane.is_armed = false;
    wait(&mut world, 1_500);
    assert_eq!(act(&world, Command::DO_LAND_START), Some(Act::FollowMission));
    assert_eq!(act(&world, Command::MISSION_START), Some(Act::FollowMission));
}

// It stores a list beside the other, and changes over.
#[test]
fn another_station_s_mission_is_no_mixture() {
    let mut world = flying(unasked());
    let now = world.now;
    let vehicle = &mut world.station.vehicle;
    for (total, mission_id) in [(3, 7), (5, 9), (0, 0)] {
        let current = MISSION_CURRENT_DATA { total, mission_id, ..Default::default() };
        vehicle.on_message(PLANE.component, &Message::Dialect(MavMessage::MISSION_CURRENT(current)), now);
        assert!(!vehicle.plan_state(PlanKind::Mission).may_be_mixed(), "{total} items");
    }
}

// Its height control may begin at 0 m and climb by 3 m/s (v1.17.0).
#[test]
fn a_flight_soon_after_it_was_switched_on_is_warned_of() {
    let warned = |boot_ms, flight_sw_version| {
        let mut plane = px4();
        plane.is_armed = false;
        let mut world = World::new(Station::with(VehicleConfig::default()), plane, Faults::default(), 1);
        wait(&mut world, 3_000);
        let now = world.now;
        let version = AUTOPILOT_VERSION_DATA { flight_sw_version, ..Default::default() };
        let time = SYSTEM_TIME_DATA { time_unix_usec: 0, time_boot_ms: boot_ms };
        for told in [MavMessage::AUTOPILOT_VERSION(version), MavMessage::SYSTEM_TIME(time)] {
            world.station.vehicle.on_beside(&Message::Dialect(told), now);
        }
        ask(&mut world, Request::PrepareFlight).expect("prepared");
        world.station.vehicle.texts().iter().any(|text| text.text.contains("height control"))
    };
    const V1_17: u32 = 0x0111_00ff;
    assert!(warned(60_000, V1_17));
    assert!(!warned(201_000, V1_17), "600 m at 3 m/s");
    assert!(!warned(60_000, 0x0112_00ff));
}

#[test]
fn a_plane_takes_airspeeds_alone() {
    let mut world = flying(VehicleConfig::default());
    let change = |kind| Request::ChangeSpeed { kind, speed_m_s: 15.0 };
    assert_eq!(ask(&mut world, change(SpeedKind::Airspeed)), Ok(Reply::Done));
    let error = ask(&mut world, change(SpeedKind::Groundspeed)).expect_err("not taken");
    assert!(matches!(error, VehicleError::InvalidValue { field: "kind", .. }), "{error}");
}

// It tells each ten times more, once a second, while it flies to the next one.
#[test]
fn an_item_is_reached_once_each_time() {
    let mut world = flying(VehicleConfig::default());
    let mut reached_after = |seq: u16, set_back_after: usize| {
        world.plane.current = seq;
        wait(&mut world, 1_500);
        for told in 0..11 {
            let reached = MISSION_ITEM_REACHED_DATA { seq };
            world.plane.out.push_back(Message::Dialect(MavMessage::MISSION_ITEM_REACHED(reached)));
            world.plane.current = if told < set_back_after { seq + 1 } else { seq };
            wait(&mut world, 1_000);
        }
        wait(&mut world, 1_500);
        let reached = world.station.events.iter().filter_map(|event| match event {
            VehicleEvent::ItemReached { seq } => Some(seq.0),
            _ => None,
        });
        reached.collect::<Vec<_>>()
    };
    assert_eq!(reached_after(1, 11), [1]);
    assert_eq!(reached_after(2, 11), [1, 2]);
    assert_eq!(reached_after(1, 11), [1, 2, 1], "a jump leads back to it");
    assert_eq!(reached_after(2, 3), [1, 2, 1, 2], "set back to it while that is told");
    assert_eq!(reached_after(2, 11), [1, 2, 1, 2, 2]);
}

// It acknowledges both, and says nothing more.
#[test]
fn what_is_acknowledged_without_an_effect_is_noted() {
    let mut world = flying(VehicleConfig::default());
    let said = |world: &Pair| world.station.vehicle.texts().iter().last().map(|text| text.text.clone());
    assert_eq!(ask(&mut world, Request::AbortLanding { alt_rel_home_m: None }), Ok(Reply::Done));
    assert_eq!(said(&world).as_deref(), Some("It was not landing: there was nothing to abort"));
    world.plane.is_armed = false;
    wait(&mut world, 1_500);
    assert_eq!(ask(&mut world, Request::Takeoff { alt_rel_home_m: 50.0 }), Ok(Reply::Done));
    assert_eq!(said(&world).as_deref(), Some("It takes off as soon as it is armed"));
}
