//! The aggregate against an imitated ArduPlane over a bad link, and against what a real one was recorded to answer.

mod bounds;
mod faults;
mod guided;
mod identity;
mod landing;
mod mixed;
mod old_firmware;
mod px4;

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use vencejo_flight::geodesy::{GeoPoint, direct};
use vencejo_flight::plan::{Command, Home, Mission, MissionItem, PlanKind};
use vencejo_proto::dialect::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, EVENT_DATA, EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA,
    HOME_POSITION_DATA, MISSION_COUNT_DATA, MISSION_CURRENT_DATA, MISSION_ITEM_REACHED_DATA, MavLandedState,
    MavMessage, MavParamType, MavProtocolCapability, MissionState, PARAM_VALUE_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA, TIMESYNC_DATA,
};
use vencejo_proto::param::{Param, ParamName, ParamType, ParamValue};
use vencejo_proto::{
    Address, CommandAck, CommandInt, CommandLong, FieldValue, Heartbeat, MavVersion, Message, MissionAck, MissionSeq,
    MonoTime, StatusText, encode_fields,
};

use super::ops::MAX_REQUESTS;
use super::{Vehicle, VehicleConfig};
use crate::choice::{AltFrame, MessageId, MessageRate, ModeChoice, SpeedKind, Turn};
use crate::command::CommandResult;
use crate::error::VehicleError;
use crate::modes::ModeFamily;
use crate::plan_record::StoredRecord;
use crate::plan_state::{PlanState, Unknown};
use crate::request::{Output, Reply, Request, RequestId, VehicleEvent};
use crate::streams::StreamConfig;
use crate::transfer::TransferError;
use crate::transfer::testing::{Endpoint, Faults, MockPlane, PLANE, RIVAL, STATION, World, recorded};

/// A vehicle as one end of a link; keeps results and events.
struct Station {
    now: MonoTime,
    vehicle: Vehicle,
    results: BTreeMap<RequestId, Result<Reply, VehicleError>>,
    progress: Vec<(RequestId, u32, u32)>,
    events: Vec<VehicleEvent>,
    /// What was to be written down, by ticket.
    kept: BTreeMap<u64, StoredRecord>,
    /// Whether the disk answers.
    answers_keep: bool,
}

impl Station {
    fn new() -> Self {
        Self::with(VehicleConfig::default())
    }

    fn with(config: VehicleConfig) -> Self {
        Self {
            now: MonoTime::ZERO,
            vehicle: Vehicle::new(PLANE, STATION, config, MonoTime::ZERO),
            results: BTreeMap::new(),
            progress: Vec::new(),
            events: Vec::new(),
            kept: BTreeMap::new(),
            answers_keep: true,
        }
    }
}

impl Endpoint for Station {
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime) {
        self.now = now;
        if from.system == PLANE.system {
            self.vehicle.on_message(from.component, message, now);
        } else {
            self.vehicle.on_foreign(from, message, now);
        }
    }

    fn tick(&mut self, now: MonoTime) {
        self.now = now;
        self.vehicle.on_time(now);
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        self.vehicle.deadline()
    }

    fn next_output(&mut self) -> Option<Message> {
        loop {
            match self.vehicle.poll_output()? {
                Output::Keep { ticket, stored } => {
                    self.kept.insert(ticket, stored);
                    if self.answers_keep {
                        self.vehicle.on_kept(ticket, self.now);
                    }
                }
                Output::Send(message) => return Some(message),
                Output::Progress { id, done, total } => self.progress.push((id, done, total)),
                Output::Finished { id, result } => {
                    assert!(self.results.insert(id, result).is_none(), "{id} has one result");
                }
                Output::Event(event) => self.events.push(event),
            }
        }
    }
}

/// An ArduPlane as far as requests see it: heartbeat, streams, commands; plans and parameters by [`MockPlane`].
struct Plane {
    services: MockPlane,
    out: VecDeque<Message>,
    booted: MonoTime,
    next_heartbeat: MonoTime,
    next_stream: MonoTime,
    is_streaming: bool,
    is_armed: bool,
    mode: u32,
    current: u16,
    /// MIS_RESTART 1: its mission begins anew with each change to AUTO.
    restarts_mission: bool,
    mission_state: MissionState,
    landed: MavLandedState,
    /// Commands that came, repetitions included.
    commands: Vec<CommandLong>,
    ints: Vec<CommandInt>,
    velocities: Vec<SET_POSITION_TARGET_LOCAL_NED_DATA>,
    /// `MAV_STATE` of its heartbeats.
    system_status: u8,
    /// MAV_TYPE: a plane, when nobody says otherwise.
    mav_type: u8,
    autopilot: u8,
    streams_asked: usize,
    /// Arming is refused, with these texts.
    refuses: Option<Vec<&'static str>>,
    /// Changes of mode are refused, with this notice.
    denies_modes: Option<&'static str>,
    denies_positions: bool,
    /// A go-to leads out of its fence.
    is_outside_fence: bool,
    /// Acknowledges, but does nothing.
    is_lazy: bool,
    /// Answers that the next command does not get.
    mute: usize,
    /// A command whose answers get lost.
    unanswered: Option<Command>,
    /// Commands that the next ones do not reach.
    deaf: usize,
    /// Commands that it does not know.
    unknown: Vec<Command>,
    /// Knows nothing of plans.
    deaf_to_missions: bool,
    uid: u64,
    /// Answers to requests for its version that get lost, though they are acknowledged.
    loses: usize,
    /// Those of a PX4, by their numbers, and how often it was asked for some.
    events: Vec<EVENT_DATA>,
    events_asked: usize,
}

impl Plane {
    fn new() -> Self {
        let mut services = MockPlane::new();
        let param = |name: &str, value| {
            let value = ParamValue::new(ParamType::F32, value).expect("a value");
            Param::new(ParamName::new(name).expect("a name"), value)
        };
        services.params = vec![param("TKOFF_ALT", 50.0), param("WP_LOITER_RAD", 80.0)];
        Self {
            services,
            out: VecDeque::new(),
            booted: MonoTime::ZERO,
            next_heartbeat: MonoTime::from_millis(3),
            next_stream: MonoTime::from_millis(5),
            is_streaming: false,
            is_armed: false,
            mode: 5,
            current: 0,
            restarts_mission: false,
            mission_state: MissionState::MISSION_STATE_ACTIVE,
            landed: MavLandedState::MAV_LANDED_STATE_ON_GROUND,
            commands: Vec::new(),
            ints: Vec::new(),
            velocities: Vec::new(),
            system_status: 3,
            mav_type: 1,
            autopilot: 3,
            streams_asked: 0,
            refuses: None,
            denies_modes: None,
            denies_positions: false,
            is_outside_fence: false,
            is_lazy: false,
            mute: 0,
            unanswered: None,
            deaf: 0,
            unknown: Vec::new(),
            deaf_to_missions: false,
            uid: 0,
            loses: 0,
            events: Vec::new(),
            events_asked: 0,
        }
    }

    fn reboot(&mut self, now: MonoTime) {
        self.services.reboot();
        self.out.clear();
        self.booted = now;
        (self.is_streaming, self.is_armed, self.mode, self.current) = (false, false, 5, 0);
        self.next_heartbeat = now + Duration::from_millis(1_500);
    }

    fn heartbeat(&mut self) {
        let armed = if self.is_armed { Heartbeat::ARMED } else { 0 };
        self.out.push_back(Message::Heartbeat(Heartbeat {
            custom_mode: self.mode,
            mav_type: self.mav_type,
            autopilot: self.autopilot,
            base_mode: armed | Heartbeat::CUSTOM_MODE,
            system_status: self.system_status,
            mavlink_version: 3,
        }));
    }

    /// Sends a parameter that nobody has asked for, or with its index in the list.
    fn tell_param(&mut self, name: &str, param_value: f32, param_index: u16) {
        let param_id = ParamName::new(name).expect("a name").to_field().into();
        let param_type = MavParamType::MAV_PARAM_TYPE_REAL32;
        let told = PARAM_VALUE_DATA { param_value, param_count: 0, param_index, param_id, param_type };
        self.out.push_back(Message::Dialect(MavMessage::PARAM_VALUE(told)));
    }

    fn text(&mut self, severity: u8, text: &str) {
        self.out.push_back(Message::StatusText(StatusText { severity, text: text.into(), id: 0, chunk_seq: 0 }));
    }

    fn stream(&mut self, now: MonoTime) {
        let time_boot_ms = now.since(self.booted).as_millis() as u32;
        let home = usize::from(self.autopilot == 3);
        let total = self.services.plans[0].len().saturating_sub(home) as u16;
        for message in [
            MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..Default::default() }),
            MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
                time_boot_ms,
                lat: 403_332_000,
                lon: -37_978_000,
                alt: 600_090,
                ..Default::default()
            }),
            MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA { landed_state: self.landed, ..Default::default() }),
            MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA {
                seq: self.current,
                total,
                mission_state: self.mission_state,
                mission_mode: u8::from(self.mode == 10),
                ..Default::default()
            }),
        ] {
            self.out.push_back(Message::Dialect(message));
        }
    }

    /// Executes a command; its `MAV_RESULT`.
    fn execute(&mut self, command: Command, p: [f32; 4]) -> u8 {
        if self.unknown.contains(&command) {
            return 3;
        }
        match command {
            Command::COMPONENT_ARM_DISARM => {
                if p[0] == 1.0
                    && let Some(reasons) = self.refuses.clone()
                {
                    for reason in reasons {
                        self.text(2, reason);
                    }
                    return 4;
                }
                if !self.is_lazy {
                    self.is_armed = p[0] == 1.0;
                }
                0
            }
            Command::DO_SET_MODE if self.denies_modes.is_some() => {
                self.text(5, self.denies_modes.unwrap_or_default());
                4
            }
            Command::DO_SET_MODE if p[1] > 26.0 => {
                self.text(4, "No such mode 99");
                4
            }
            Command::DO_SET_MODE => {
                if !self.is_lazy {
                    if self.restarts_mission && (self.mode != 10 && p[1] == 10.0) {
                        self.current = 1;
                    }
                    self.mode =
                        if self.autopilot == 12 { (p[1] as u32) << 16 | (p[2] as u32) << 24 } else { p[1] as u32 };
                }
                0
            }
            // As ArduPilot: in GUIDED, or with the leave to enter it.
            Command::DO_REPOSITION => {
                if self.denies_positions {
                    return 2;
                }
                if self.autopilot == 12 {
                    return self.reposition_px4(p[1] == 1.0);
                }
                let guided = if self.mav_type == 2 { 4 } else { 15 };
                if p[1] != 1.0 && self.mode != guided {
                    return 4;
                }
                if !self.is_lazy {
                    self.mode = guided;
                }
                0
            }
            Command::SET_MESSAGE_INTERVAL => {
                self.streams_asked += 1;
                self.is_streaming = true;
                0
            }
            Command::REQUEST_MESSAGE => {
                match p[0] as u32 {
                    148 if self.loses > 0 => self.loses -= 1,
                    148 => {
                        self.out.push_back(Message::Dialect(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
                            capabilities: if self.services.has_ftp {
                                MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_FTP
                            } else {
                                MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_INT
                                    | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
                            },
                            flight_sw_version: 0x0408_0000,
                            uid: self.uid,
                            ..Default::default()
                        })))
                    }
                    242 => self.out.push_back(Message::Dialect(MavMessage::HOME_POSITION(HOME_POSITION_DATA {
                        latitude: 403_332_001,
                        longitude: -37_977_996,
                        altitude: 600_090,
                        ..Default::default()
                    }))),
                    // Agreed to, and never sent.
                    253 => {}
                    _ => return 2,
                }
                0
            }
            Command::DO_SET_MISSION_CURRENT => {
                // 0 is the beginning, as ArduPilot takes it.
                self.current = (p[0] as u16).max(1);
                0
            }
            Command::DO_LAND_START => {
                if self.autopilot == 12 {
                    self.mode = px4::AUTO_MISSION;
                }
                self.current = 9;
                0
            }
            Command::DO_ORBIT if self.autopilot == 12 => self.circle_px4("Orbit"),
            Command::NAV_TAKEOFF if self.autopilot == 12 => 0,
            // In other modes an ArduPlane answers FAILED.
            Command::DO_CHANGE_SPEED if self.autopilot == 3 && self.mav_type == 1 && ![10, 15].contains(&self.mode) => {
                4
            }
            Command::DO_CHANGE_SPEED | Command::DO_CHANGE_ALTITUDE | Command::DO_SET_HOME | Command::DO_GO_AROUND => 0,
            // Only in GUIDED; FAILED elsewhere.
            Command::GUIDED_CHANGE_ALTITUDE | Command::GUIDED_CHANGE_HEADING => {
                if self.mode == 15 {
                    0
                } else {
                    4
                }
            }
            Command::PREFLIGHT_REBOOT_SHUTDOWN => 0,
            _ => 3,
        }
    }

    fn command(&mut self, from: Address, command: u16, params: [f32; 4]) {
        let result = self.execute(Command(command), params);
        if self.mute > 0 {
            self.mute -= 1;
            return;
        }
        if self.unanswered == Some(Command(command)) {
            return;
        }
        self.out.push_back(Message::CommandAck(CommandAck {
            command,
            result,
            progress: 0,
            result_param2: 0,
            target: from,
        }));
    }
}

impl Endpoint for Plane {
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime) {
        let is_tuning =
            |command: u16| matches!(Command(command), Command::SET_MESSAGE_INTERVAL | Command::REQUEST_MESSAGE);
        match message {
            Message::CommandLong(long) => {
                if self.deaf > 0 && !is_tuning(long.command) {
                    self.deaf -= 1;
                    return;
                }
                self.commands.push(*long);
                let [p1, p2, p3, p4, ..] = long.params;
                self.command(from, long.command, [p1, p2, p3, p4]);
            }
            Message::CommandInt(_) if self.deaf > 0 => self.deaf -= 1,
            Message::CommandInt(int) => {
                self.ints.push(*int);
                self.command(from, int.command, int.params);
            }
            Message::Dialect(MavMessage::SET_MODE(_)) if self.is_lazy => {}
            Message::Dialect(MavMessage::SET_MODE(mode)) => self.mode = mode.custom_mode,
            Message::Dialect(MavMessage::SET_POSITION_TARGET_LOCAL_NED(target)) => self.velocities.push(target.clone()),
            Message::Dialect(MavMessage::TIMESYNC(sync)) if sync.tc1 == 0 => {
                self.out.push_back(Message::Dialect(MavMessage::TIMESYNC(TIMESYNC_DATA {
                    tc1: now.since(self.booted).as_nanos() as i64,
                    ts1: sync.ts1,
                    target_system: from.system.0,
                    target_component: from.component.0,
                })));
            }
            Message::Dialect(MavMessage::REQUEST_EVENT(request)) => self.on_request_event(request),
            _ if self.deaf_to_missions => {}
            _ => self.services.receive(from, message, now),
        }
    }

    fn tick(&mut self, now: MonoTime) {
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + Duration::from_secs(1);
            self.heartbeat();
        }
        if now >= self.next_stream {
            self.next_stream = now + Duration::from_millis(100);
            if self.is_streaming {
                self.stream(now);
            }
        }
        if self.services.wakes_at().is_some_and(|at| now >= at) {
            self.services.tick(now);
        }
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        [Some(self.next_heartbeat), Some(self.next_stream), self.services.wakes_at()].into_iter().flatten().min()
    }

    fn next_output(&mut self) -> Option<Message> {
        self.out.pop_front().or_else(|| self.services.next_output())
    }
}

type Pair = World<Station, Plane>;

/// A vehicle that has been heard for two seconds over a good link.
fn connected() -> Pair {
    let mut world = World::new(Station::new(), Plane::new(), Faults::default(), 1);
    wait(&mut world, 2_000);
    assert!(world.station.vehicle.telemetry().heartbeat.is_some());
    world
}

fn wait(world: &mut Pair, ms: u64) {
    let until = world.now + Duration::from_millis(ms);
    world.run(until, |_, _| false);
}

fn start(world: &mut Pair, request: Request) -> RequestId {
    let now = world.now;
    world.station.vehicle.request(request, now)
}

/// Runs until a request has its result.
fn end(world: &mut Pair, id: RequestId, within_s: u64) -> Result<Reply, VehicleError> {
    let until = world.now + Duration::from_secs(within_s);
    let is_over = world.run(until, |station, _| station.results.contains_key(&id));
    assert!(is_over, "no result within {within_s} s");
    world.station.results[&id].clone()
}

fn ask(world: &mut Pair, request: Request) -> Result<Reply, VehicleError> {
    let id = start(world, request);
    end(world, id, 60)
}

fn mode(name: &str) -> Request {
    Request::SetMode { mode: ModeChoice::Name(name.into()) }
}

const ARM: Request = Request::Arm { force: false };

fn mission() -> Vec<MissionItem> {
    vec![
        MissionItem::takeoff(40.3332, -3.7990, 50.0, 12.0),
        MissionItem::waypoint(40.3340, -3.8030, 80.0),
        MissionItem::loiter_turns(40.3350, -3.8000, 80.0, 2.0, 60.0),
        MissionItem::land(40.3332, -3.7978, 0.0),
    ]
}

fn upload() -> Request {
    Request::UploadPlan { kind: PlanKind::Mission, items: mission(), home: None, despite_findings: false }
}

fn count(world: &Pair, command: Command) -> usize {
    world.plane.commands.iter().filter(|long| long.command == command.0).count()
}

// ── arm and mode ─────────────────────────────────────────────────────────────────────────────────────────────────────

#[test]
fn a_new_vehicle_is_asked_for_its_streams_and_introduces_itself() {
    let mut world = connected();
    wait(&mut world, 20_000);
    let vehicle = &world.station.vehicle;
    assert!(vehicle.telemetry().attitude.is_some() && vehicle.telemetry().home.is_some());
    assert!(vehicle.telemetry().version.expect("version").value.has_ftp());
    assert!(vehicle.round_trip().is_some() && vehicle.is_heard(world.now));
    assert_eq!(world.plane.streams_asked, 23, "once each");
    assert!(world.station.events.contains(&VehicleEvent::ArmedChanged { is_armed: false }));
    assert!(!world.station.events.contains(&VehicleEvent::Rebooted));
}

#[test]
fn armed_is_when_the_heartbeat_says_so() {
    let mut world = connected();
    assert_eq!(ask(&mut world, ARM), Ok(Reply::Done));
    assert!(world.plane.is_armed && world.station.vehicle.telemetry().is_armed() == Some(true));
    assert_eq!(ask(&mut world, Request::Disarm { force: false }), Ok(Reply::Done));
    assert_eq!(world.station.vehicle.telemetry().is_armed(), Some(false));
    assert!(world.station.events.contains(&VehicleEvent::ArmedChanged { is_armed: true }));
    // Accepted and not done is not done.
    world.plane.is_lazy = true;
    let error = ask(&mut world, ARM).expect_err("not armed");
    assert!(matches!(error, VehicleError::NotConfirmed { .. }), "{error}");
    let error = ask(&mut world, mode("AUTO")).expect_err("not in AUTO");
    assert_eq!(
        error.to_string(),
        "vehicle accepted DO_SET_MODE (176) but within 5 s does not show mode AUTO; it shows mode FBWA"
    );
}

#[test]
fn a_refusal_carries_what_the_vehicle_wrote() {
    let mut world = connected();
    world.plane.text(6, "EKF3 IMU0 is using GPS");
    world.plane.refuses =
        Some(vec!["Arm: Throttle too high", "PreArm: Battery 1 low voltage", "Arm: Throttle too high"]);
    let error = ask(&mut world, ARM).expect_err("refused");
    let VehicleError::CommandRefused { result, ref reasons, .. } = error else { panic!("{error}") };
    assert_eq!(result, CommandResult::FAILED);
    assert_eq!(*reasons, ["Arm: Throttle too high", "PreArm: Battery 1 low voltage"]);
    assert!(error.to_string().contains("COMPONENT_ARM_DISARM (400)") && error.to_string().contains("low voltage"));

    // Silent at the refusal: what it repeats every 30 s is the reason.
    wait(&mut world, 40_000);
    world.plane.text(2, "PreArm: Compass not calibrated");
    world.plane.refuses = Some(vec![]);
    wait(&mut world, 20_000);
    let error = ask(&mut world, ARM).expect_err("refused");
    assert!(error.to_string().ends_with(": PreArm: Compass not calibrated"), "{error}");

    let error = ask(&mut world, Request::SetMode { mode: ModeChoice::Custom(99) }).expect_err("refused");
    assert!(error.to_string().ends_with("No such mode 99"), "{error}");

    // Why it refuses a mode ArduPlane says as a notice, beside others that are about other things.
    world.plane.denies_modes = Some("Mode change to LOITER denied, in fence recovery");
    world.plane.text(5, "Throttle armed");
    let error = ask(&mut world, Request::LoiterHere).expect_err("refused");
    let VehicleError::CommandRefused { ref reasons, .. } = error else { panic!("{error}") };
    assert_eq!(*reasons, ["Mode change to LOITER denied, in fence recovery"]);

    // Of the rates that a station asks for itself the plane says meanwhile which messages it has not.
    world.plane.denies_modes = Some("No ap_message for mavlink id (225)");
    world.plane.text(4, "Requested rate for message ID 27 too fast. Increase SCHED_LOOP_RATE");
    let error = ask(&mut world, Request::LoiterHere).expect_err("refused");
    assert!(matches!(&error, VehicleError::CommandRefused { reasons, .. } if reasons.is_empty()), "{error}");
}

#[test]
fn a_lost_acknowledgement_is_made_good_by_the_heartbeat() {
    let mut world = connected();
    world.plane.mute = 1;
    assert_eq!(ask(&mut world, ARM), Ok(Reply::Done));
    assert_eq!(count(&world, Command::COMPONENT_ARM_DISARM), 1, "sent once");
}

#[test]
fn a_lost_command_is_repeated_after_the_heartbeat_denies_it() {
    let mut world = connected();
    world.plane.deaf = 2;
    assert_eq!(ask(&mut world, ARM), Ok(Reply::Done));
    let sent: Vec<_> =
        world.plane.commands.iter().filter(|long| long.command == Command::COMPONENT_ARM_DISARM.0).collect();
    assert_eq!(sent.len(), 1, "two were lost");
    assert_eq!(sent[0].confirmation, 2);
}

#[test]
fn a_mode_that_the_pilot_changed_meanwhile_is_not_changed_back() {
    let mut world = connected();
    world.plane.deaf = 1;
    let id = start(&mut world, mode("AUTO"));
    wait(&mut world, 100);
    world.plane.mode = 0;
    let error = end(&mut world, id, 30).expect_err("overtaken");
    assert!(matches!(&error, VehicleError::NotConfirmed { observed, .. } if observed == "mode MANUAL"), "{error}");
    assert_eq!(count(&world, Command::DO_SET_MODE), 0, "not repeated");
}

#[test]
fn a_go_to_has_entered_guided_and_takes_it_from_nobody() {
    let go = || reposition(40.34, -3.79, 80.0);
    let leaves = |world: &Pair| world.plane.ints.iter().map(|int| int.params[1] == 1.0).collect::<Vec<_>>();
    let mut world = connected();
    assert_eq!(ask(&mut world, go()), Ok(Reply::Done));
    assert_eq!(world.station.vehicle.telemetry().mode().and_then(|mode| mode.name()), Some("GUIDED"), "it shows it");
    // In GUIDED it needs no leave; so what is repeated cannot take the plane back from a pilot.
    world.plane.deaf = 1;
    assert_eq!(ask(&mut world, go()), Ok(Reply::Done));
    assert_eq!(leaves(&world), [true, false]);
    world.plane.deaf = 1;
    let id = start(&mut world, go());
    wait(&mut world, 100);
    world.plane.mode = 0;
    let refused = end(&mut world, id, 30);
    assert!(matches!(refused, Err(VehicleError::CommandRefused { .. })), "{refused:?}");
    assert_eq!(world.plane.mode, 0);
    // Nor does one that is to enter it.
    wait(&mut world, 2_000);
    world.plane.deaf = 1;
    let id = start(&mut world, go());
    wait(&mut world, 100);
    world.plane.mode = 5;
    assert!(matches!(end(&mut world, id, 30), Err(VehicleError::NotConfirmed { .. })));
    assert_eq!((leaves(&world), world.plane.mode), (vec![true, false, false], 5));
    // Accepted and not done is not done.
    world.plane.is_lazy = true;
    wait(&mut world, 2_000);
    let error = ask(&mut world, go()).expect_err("not done");
    assert!(matches!(error, VehicleError::NotConfirmed { .. }));
    assert!(error.to_string().contains("mode FBWA; it may fly there all the same"), "{error}");
}

#[test]
fn a_go_to_that_is_denied_without_a_word_has_a_remedy() {
    let mut world = connected();
    world.plane.denies_positions = true;
    let error = ask(&mut world, reposition(40.34, -3.79, 80.0)).expect_err("denied");
    let [remedy] = error.remedies()[..] else { panic!("{error}") };
    assert!(remedy.contains("inside the fence") && remedy.contains("FENCE_ALT_MAX"), "{remedy}");
    // 0 above home is no height to ArduPilot: it is not sent.
    let error = ask(&mut world, reposition(40.34, -3.79, 0.0)).expect_err("refused");
    assert!(matches!(&error, VehicleError::InvalidValue { field: "alt_m", .. }), "{error}");
    assert_eq!(world.plane.ints.len(), 1);
}

/// Whose heartbeats fail to come says nothing against what it accepted, or was told by a message that it does not
/// answer: the next one decides, and without one nothing is known.
#[test]
fn an_effect_is_missing_when_the_vehicle_says_so() {
    let unheard_for = |request: Request, ms: u64, is_lazy: bool| {
        let mut world = connected();
        // Its mode is set by a message.
        world.plane.unknown = vec![Command::DO_SET_MODE];
        world.plane.is_lazy = is_lazy;
        let id = start(&mut world, request);
        world.plane.next_heartbeat = world.now + Duration::from_millis(ms);
        let before = world.now;
        let result = end(&mut world, id, 30);
        (result, world.now.since(before).as_secs())
    };
    let shown = |result| match result {
        (Err(VehicleError::NotConfirmed { observed, within, .. }), after_s) => {
            assert_eq!(within.as_secs(), after_s);
            (observed, after_s)
        }
        other => panic!("{other:?}"),
    };
    for (request, before) in [(ARM, "disarmed"), (mode("RTL"), "mode FBWA")] {
        assert_eq!(unheard_for(request.clone(), 7_000, false), (Ok(Reply::Done), 7));
        // However the heartbeats lie beside what is told again each second.
        for phase_ms in [100, 300, 500, 700, 900] {
            assert_eq!(shown(unheard_for(request.clone(), phase_ms, true)), (before.to_owned(), 5), "{phase_ms} ms");
        }
        assert_eq!(shown(unheard_for(request.clone(), 2_000, true)), (before.to_owned(), 5));
        assert_eq!(shown(unheard_for(request.clone(), 7_000, true)), (before.to_owned(), 7));
        assert_eq!(shown(unheard_for(request, 60_000, true)), ("nothing".to_owned(), 10));
    }
}

// fault 22: 1 of 10 sent, 9 told that it is under way
#[test]
fn one_at_a_time_and_ten_clicks_are_one() {
    let mut world = connected();
    let ids: Vec<_> = (0..10).map(|_| start(&mut world, ARM)).collect();
    let results: Vec<_> = ids.into_iter().map(|id| end(&mut world, id, 30)).collect();
    assert_eq!(results.iter().filter(|result| result.is_ok()).count(), 1);
    assert!(results[1..].iter().all(|result| matches!(result, Err(VehicleError::CommandBusy { .. }))));
    assert_eq!(count(&world, Command::COMPONENT_ARM_DISARM), 1);
}

// Each one begins the item anew.
#[test]
fn a_jump_whose_answer_is_lost_is_made_once() {
    let mut world = connected();
    for (item, sent) in [(2, 1), (3, 2)] {
        world.plane.mute = 1;
        assert_eq!(ask(&mut world, Request::SetCurrentItem { item }), Ok(Reply::Done));
        assert_eq!((count(&world, Command::DO_SET_MISSION_CURRENT), world.plane.current), (sent, item));
    }
    world.plane.deaf = 1;
    assert_eq!(ask(&mut world, Request::SetCurrentItem { item: 2 }), Ok(Reply::Done));
    assert_eq!(world.plane.current, 2, "what did not arrive is repeated");
    // It goes on by itself meanwhile: that is no jump.
    world.plane.deaf = 9;
    let id = start(&mut world, Request::SetCurrentItem { item: 5 });
    wait(&mut world, 300);
    world.plane.current = 3;
    assert!(matches!(end(&mut world, id, 30), Err(VehicleError::CommandTimeout { .. })));
}

#[test]
fn an_old_vehicle_takes_the_older_messages() {
    let mut world = connected();
    world.plane.unknown = vec![Command::DO_SET_MODE, Command::DO_SET_MISSION_CURRENT, Command::DO_CHANGE_ALTITUDE];
    assert_eq!(ask(&mut world, mode("RTL")), Ok(Reply::Done));
    assert_eq!(world.plane.mode, 11);
    // The mission has no item 3: it shows where it stands, and that is said.
    let error = ask(&mut world, Request::SetCurrentItem { item: 0 }).expect_err("home is no item");
    assert_eq!(error.to_string(), "item is 0, should be 1 to 65,534; the items of a mission are counted from 1");
    let error = ask(&mut world, Request::SetCurrentItem { item: 3 }).expect_err("not shown");
    assert!(matches!(&error, VehicleError::NotConfirmed { observed, .. } if observed == "item 0"), "{error}");
    let higher = Request::ChangeAltitude { alt_m: 90.0, alt_frame: AltFrame::RelHome, below_home: false };
    assert!(ask(&mut world, higher).is_err());
    let older = world.plane.ints.last().expect("the older command");
    assert_eq!((older.command, older.frame, older.z), (Command::GUIDED_CHANGE_ALTITUDE.0, 3, 90.0));
}

/// Set to the circle that it flies, an autopilot begins it once more. What stands in for the command is shown to have
/// come.
#[test]
fn a_circle_that_it_is_set_to_again_counts_anew() {
    for is_old in [false, true] {
        let mut world = connected();
        let items =
            vec![MissionItem::waypoint(40.33, -3.79, 80.0), MissionItem::loiter_turns(40.34, -3.79, 80.0, 3.0, 80.0)];
        let plan = Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false };
        ask(&mut world, plan).expect("uploaded");
        (world.plane.mode, world.plane.is_streaming) = (10, false);
        wait(&mut world, 1_500);
        let stands_at = |world: &mut Pair, seq| {
            let data = MISSION_CURRENT_DATA { seq, total: 2, ..Default::default() };
            let (vehicle, now) = (&mut world.station.vehicle, world.now);
            vehicle.on_message(PLANE.component, &Message::Dialect(MavMessage::MISSION_CURRENT(data)), now);
        };
        let circles = |world: &mut Pair, from_ms: u32| {
            let centre = GeoPoint::new(40.34, -3.79).expect("a place");
            for step in 0..20 {
                // 20 m/s around 80 m, each half second
                let angle_rad = f64::from(step) * 0.125;
                let point = direct(centre, angle_rad.to_degrees(), 80.0);
                let data = GLOBAL_POSITION_INT_DATA {
                    time_boot_ms: from_ms + step * 500,
                    lat: (point.lat_deg() * 1e7) as i32,
                    lon: (point.lon_deg() * 1e7) as i32,
                    vx: (-2_000.0 * angle_rad.sin()) as i16,
                    vy: (2_000.0 * angle_rad.cos()) as i16,
                    ..Default::default()
                };
                let (vehicle, now) = (&mut world.station.vehicle, world.now);
                vehicle.on_message(PLANE.component, &Message::Dialect(MavMessage::GLOBAL_POSITION_INT(data)), now);
            }
            let circled = world.station.vehicle.progress().circled;
            circled.flown().map(|(_, time_s)| time_s.round())
        };
        stands_at(&mut world, 1);
        circles(&mut world, 500_000);
        stands_at(&mut world, 2);
        assert_eq!(circles(&mut world, 510_000), Some(10.0));
        assert_eq!(circles(&mut world, 520_000), Some(20.0));
        world.plane.unknown = if is_old { vec![Command::DO_SET_MISSION_CURRENT] } else { Vec::new() };
        let id = start(&mut world, Request::SetCurrentItem { item: 2 });
        wait(&mut world, 500);
        stands_at(&mut world, 2);
        assert_eq!(world.station.results.get(&id), Some(&Ok(Reply::Done)));
        assert_eq!(circles(&mut world, 530_000), Some(10.0), "old: {is_old}");
    }
}

#[test]
fn whether_one_that_is_not_heard_has_a_parameter_is_not_known() {
    let mut world = connected();
    let read = || Request::ParamRead { name: "NO_SUCH".into() };
    let error = ask(&mut world, read()).expect_err("it has none");
    assert!(matches!(error, VehicleError::Transfer(TransferError::UnknownParam { .. })), "{error}");
    world.faults.loss = 1.0;
    let error = ask(&mut world, read()).expect_err("nothing comes");
    assert!(matches!(error, VehicleError::Transfer(TransferError::Timeout { .. })), "{error}");
}

/// Success means that the vehicle shows it; failure comes in time; and there is one of them.
#[test]
fn on_a_bad_link_success_is_never_false() {
    let (mut done, mut failed) = (0, 0);
    for seed in 0..60 {
        let share = [0.05, 0.2, 0.3][seed as usize % 3];
        let faults = Faults {
            loss: share,
            duplicates: 0.1,
            reorder: 0.1,
            jitter: Duration::from_millis(150),
            ..Faults::default()
        };
        let mut world = World::new(Station::new(), Plane::new(), faults, seed);
        wait(&mut world, 6_000);
        if world.station.vehicle.telemetry().heartbeat.is_none() {
            continue;
        }
        for (request, shows) in [
            (ARM, (|plane: &Plane| plane.is_armed) as fn(&Plane) -> bool),
            (mode("AUTO"), |plane| plane.mode == 10),
            (Request::Disarm { force: true }, |plane| !plane.is_armed),
            (Request::ReturnToLaunch, |plane| plane.mode == 11),
        ] {
            match ask(&mut world, request) {
                Ok(_) => {
                    assert!(shows(&world.plane), "seed {seed}: false success");
                    done += 1;
                }
                Err(VehicleError::CommandTimeout { .. } | VehicleError::NotConfirmed { .. }) => failed += 1,
                Err(error) => panic!("seed {seed}: {error}"),
            }
        }
        assert!(!world.station.events.contains(&VehicleEvent::Rebooted), "seed {seed}: no restart");
    }
    assert!(done > 200 && failed < done / 20, "{done} done, {failed} failed");
}

// ── plans ────────────────────────────────────────────────────────────────────────────────────────────────────────────

#[test]
fn an_upload_is_known_only_when_it_was_read_back() {
    let mut world = connected();
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Unknown(Unknown::NeverRead));
    let id = start(&mut world, upload());
    assert!(world.station.vehicle.plan_state(PlanKind::Mission).may_be_mixed());
    assert!(world.station.vehicle.plan_on_board(PlanKind::Mission).is_none());
    let reply = end(&mut world, id, 30).expect("uploaded");
    let Reply::Plan { items, home: Some(home), state, .. } = reply else { panic!("{reply:?}") };
    assert_eq!(items.len(), 4);
    assert_eq!(world.station.vehicle.plan_on_board(PlanKind::Mission).map(|list| &list.items), Some(&items));
    assert!((home.alt_amsl_m - 600.09).abs() < 0.01, "the vehicle's own");
    let PlanState::Verified { count: 4, hash } = state else { panic!("{state}") };
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), state);
    assert!(world.station.progress.iter().any(|(of, done, total)| *of == id && done == total));
    // Reading it gives the same fingerprint.
    let reply = ask(&mut world, Request::DownloadPlan { kind: PlanKind::Mission }).expect("read");
    assert!(matches!(reply, Reply::Plan { state: PlanState::Verified { hash: again, .. }, .. } if again == hash));
    // And the progress knows the way.
    wait(&mut world, 500);
    let progress = world.station.vehicle.progress();
    assert!(progress.distance_to_go_m.expect("known") > 500.0, "{progress:?}");

    assert!(ask(&mut world, Request::ClearPlan { kind: PlanKind::Mission }).is_ok());
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Empty);
    assert!(world.station.vehicle.plan_on_board(PlanKind::Mission).is_none());
    // The other kinds are kept too.
    let rally =
        vec![MissionItem { command: Command::NAV_RALLY_POINT, ..MissionItem::waypoint(40.3432, -3.7978, 80.0) }];
    let request = Request::UploadPlan { kind: PlanKind::Rally, items: rally, home: None, despite_findings: false };
    let Ok(Reply::Plan { items, .. }) = ask(&mut world, request) else { panic!("not uploaded") };
    assert_eq!(world.station.vehicle.plan_on_board(PlanKind::Rally).map(|list| &list.items), Some(&items));
    // An empty upload is the same.
    let empty = Request::UploadPlan { kind: PlanKind::Rally, items: vec![], home: None, despite_findings: false };
    assert!(ask(&mut world, empty).is_ok());
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Rally), PlanState::Empty);
}

#[test]
fn an_arc_counts_where_it_is_flown() {
    let arc = MissionItem {
        command: Command::NAV_ARC_WAYPOINT,
        params: [Some(180.0), None, None, None, Some(40.3432), Some(-3.8078), Some(80.0)],
        ..MissionItem::waypoint(40.3432, -3.8078, 80.0)
    };
    let items = vec![MissionItem::waypoint(40.3432, -3.7978, 80.0), arc];
    // 1,110 m north to the waypoint; from there the arc over a chord of 849 m, which ArduPlane passes over.
    for (mav_type, distance_m) in [(1, 1_110.0), (2, 1_110.0 + std::f64::consts::PI / 2.0 * 849.4)] {
        let mut plane = Plane::new();
        plane.mav_type = mav_type;
        let mut world = World::new(Station::new(), plane, Faults::default(), 1);
        wait(&mut world, 2_000);
        let request =
            Request::UploadPlan { kind: PlanKind::Mission, items: items.clone(), home: None, despite_findings: false };
        assert!(ask(&mut world, request).is_ok());
        wait(&mut world, 500);
        let to_go_m = world.station.vehicle.progress().distance_to_go_m.expect("known");
        assert!((to_go_m - distance_m).abs() < 2.0, "{mav_type}: {to_go_m}");
    }
}

#[test]
fn the_checks_know_the_vehicle_that_a_plan_is_for() {
    let mut world = connected();
    wait(&mut world, 2_000);
    let vehicle = &mut world.station.vehicle;
    let known = vehicle.check_context();
    assert_eq!(known.home, vehicle.telemetry.home.map(|home| home.value));
    assert!(known.home.is_some() && known.position.is_some());
    assert_eq!((known.on_ground, known.can_hover, known.max_items), (Some(true), false, 650));

    // A quadplane that calls itself a fixed wing tells a VTOL state.
    let vtol_state = vencejo_proto::dialect::MavVtolState::MAV_VTOL_STATE_FW;
    let extended = EXTENDED_SYS_STATE_DATA { vtol_state, ..Default::default() };
    vehicle.on_message(PLANE.component, &Message::Dialect(MavMessage::EXTENDED_SYS_STATE(extended)), world.now);
    assert!(vehicle.check_context().can_hover);

    for (name, value) in [("AIRSPEED_CRUISE", 14.0), ("ROLL_LIMIT_DEG", 55.0), ("BRD_SD_MISSION", 64.0)] {
        let name = ParamName::new(name).expect("a name");
        vehicle.learn(&Param::new(name, ParamValue::F32(value)));
    }
    let read = vehicle.check_context();
    assert_eq!((read.airspeed_m_s, read.bank_deg, read.max_items), (14.0, 55.0, 4_368));
}

#[test]
fn a_mission_stands_at_what_the_table_calls_navigation() {
    let mut world = connected();
    assert_eq!(Vehicle::new(PLANE, STATION, VehicleConfig::default(), MonoTime::ZERO).first_seq(), 0, "not known yet");
    let items = vec![
        MissionItem::action(Command::DO_SET_SERVO, [7.0, 1_500.0, 0.0, 0.0]),
        MissionItem::waypoint(40.3432, -3.7978, 80.0),
        MissionItem::action(Command::NAV_SCRIPT_TIME, [1.0, 5.0, 0.0, 0.0]),
        MissionItem::action(Command::DO_SET_SERVO, [7.0, 1_100.0, 0.0, 0.0]),
    ];
    ask(&mut world, Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false })
        .expect("uploaded");
    assert_eq!((world.station.vehicle.first_nav(), world.station.vehicle.last_nav()), (2, Some(3)));
}

#[test]
fn another_stations_plan_makes_ours_unknown() {
    let (changed, half) = (Unknown::ChangedElsewhere, Unknown::SentElsewhere);
    let by_total = |world: &mut Pair| {
        world.plane.services.plans[0].pop();
    };
    let by_ack = |world: &mut Pair| {
        let ack = MissionAck { target: RIVAL, result: 0, mission_type: 0, opaque_id: 0 };
        world.plane.out.push_back(Message::MissionAck(ack));
    };
    let by_count = |world: &mut Pair| {
        let count = MISSION_COUNT_DATA { count: 3, target_system: 1, target_component: 1, ..Default::default() };
        let at = world.now + Duration::from_millis(10);
        world.inject(at, true, RIVAL, &Message::Dialect(MavMessage::MISSION_COUNT(count)));
    };
    // A number of items that moves is an upload under way until it rests, and MISSION_COUNT is one until its end is
    // heard.
    for (change, told) in [(by_total as fn(&mut Pair), half), (by_ack, changed), (by_count, half)] {
        let told = PlanState::Unknown(told);
        let mut world = connected();
        ask(&mut world, upload()).expect("uploaded");
        wait(&mut world, 6_000);
        assert!(matches!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Verified { .. }));
        change(&mut world);
        wait(&mut world, 1_000);
        assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), told);
        assert!(world.station.vehicle.mission().is_none());
        let told = VehicleEvent::PlanStateChanged { kind: PlanKind::Mission, state: told };
        assert_eq!(world.station.events.iter().filter(|event| **event == told).count(), 1);
    }
}

#[test]
fn a_list_that_a_vehicle_names_otherwise_is_another() {
    let changed = PlanState::Unknown(Unknown::ChangedElsewhere);
    let verified = PlanState::Verified { count: 3, hash: 1 };
    let mut vehicle = Vehicle::new(PLANE, STATION, VehicleConfig::default(), MonoTime::ZERO);
    let mut hear = |total, [mission_id, fence_id, rally_points_id]: [u32; 3]| {
        for kind in PlanKind::ALL {
            vehicle.set_plan(kind, verified);
        }
        let current = MISSION_CURRENT_DATA { total, mission_id, fence_id, rally_points_id, ..Default::default() };
        let current = Message::Dialect(MavMessage::MISSION_CURRENT(current));
        vehicle.on_message(PLANE.component, &current, MonoTime::from_millis(10_000));
        PlanKind::ALL.map(|kind| vehicle.plan_state(kind))
    };
    assert_eq!(hear(3, [7, 8, 0]), [verified; 3], "the names that they have");
    assert_eq!(hear(3, [7, 8, 0]), [verified; 3], "the same");
    assert_eq!(hear(0, [0; 3]), [verified; 3], "MAVLink 1 does not tell");
    assert_eq!(hear(3, [7, 9, 0]), [verified, changed, verified], "another fence");
    assert_eq!(hear(3, [7, 0, 0]), [verified, changed, verified], "none any more");
    assert_eq!(hear(3, [7, 0, 4]), [verified, verified, changed], "rally points where there were none");
    // Of one without names the number tells it, until it rests as an upload under way.
    let moving = PlanState::Unknown(Unknown::SentElsewhere);
    assert_eq!(hear(u16::MAX, [7, 0, 4]), [moving, verified, verified], "no mission any more");
    assert_eq!(hear(3, [7, 0, 4]), [moving, verified, verified], "one of the same length");
}

#[test]
fn who_flies_without_a_mission_completes_none() {
    for (seq, total, mission_state, has_completed) in
        [(0, u16::MAX, MissionState::MISSION_STATE_NO_MISSION, false), (2, 2, MissionState::MISSION_STATE_ACTIVE, true)]
    {
        let mut world = connected();
        let current = MISSION_CURRENT_DATA { seq, total, mission_state, ..Default::default() };
        let current = Message::Dialect(MavMessage::MISSION_CURRENT(current));
        let now = world.now;
        world.station.vehicle.on_message(PLANE.component, &current, now);
        for is_armed in [true, false] {
            world.plane.is_armed = is_armed;
            world.plane.heartbeat();
            let message = world.plane.out.pop_back().expect("a heartbeat");
            world.station.vehicle.on_message(PLANE.component, &message, now);
        }
        let mut outputs = std::iter::from_fn(|| world.station.vehicle.poll_output());
        let is_told = outputs.any(|output| output == Output::Event(VehicleEvent::MissionComplete));
        assert_eq!(is_told, has_completed, "{total} items");
    }
}

#[test]
fn what_was_reached_before_the_mission_is_read_stays_reached() {
    let reaches = |world: &mut Pair, seq: u16| {
        let reached = MISSION_ITEM_REACHED_DATA { seq };
        world.plane.out.push_back(Message::Dialect(MavMessage::MISSION_ITEM_REACHED(reached)));
        wait(world, 500);
        world.station.vehicle.progress().reached.iter().map(|seq| seq.0).collect::<Vec<_>>()
    };
    let is_replaced = |world: &mut Pair| {
        wait(world, 6_000);
        let ack = MissionAck { target: RIVAL, result: 0, mission_type: 0, opaque_id: 0 };
        world.plane.out.push_back(Message::MissionAck(ack));
        wait(world, 500);
    };
    let read = Request::DownloadPlan { kind: PlanKind::Mission };
    let mut world = connected();
    ask(&mut world, Request::ClearPlan { kind: PlanKind::Mission }).expect("cleared");
    let mut sender = connected();
    ask(&mut sender, upload()).expect("uploaded");
    world.plane.services.plans.clone_from(&sender.plane.services.plans);
    is_replaced(&mut world);
    assert_eq!(reaches(&mut world, 1), [1]);
    ask(&mut world, read.clone()).expect("read");
    assert_eq!(reaches(&mut world, 2), [1, 2], "to learn what it flies is no other flight");
    world.plane.services.plans[0].pop();
    is_replaced(&mut world);
    ask(&mut world, read).expect("read");
    assert_eq!(reaches(&mut world, 3), [3], "of another mission");
    ask(&mut world, upload()).expect("uploaded");
    assert_eq!(reaches(&mut world, 1), [1]);
}

#[test]
fn a_plan_that_changes_while_it_is_read_is_not_known() {
    let mut world = connected();
    ask(&mut world, upload()).expect("uploaded");
    let id = start(&mut world, Request::DownloadPlan { kind: PlanKind::Mission });
    let ack = MissionAck { target: RIVAL, result: 0, mission_type: 0, opaque_id: 0 };
    world.plane.out.push_back(Message::MissionAck(ack));
    let reply = end(&mut world, id, 30).expect("read");
    let changed = PlanState::Unknown(Unknown::ChangedElsewhere);
    assert!(matches!(reply, Reply::Plan { state, .. } if state == changed), "{reply:?}");
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), changed);
    assert!(world.station.vehicle.mission().is_none());
}

#[test]
fn a_half_written_mission_is_not_flown() {
    let mut world = connected();
    world.plane.services.has_ftp = false;
    world.faults.cut_after = Some(world.station_frames + 4);
    let error = ask(&mut world, upload()).expect_err("cut");
    assert!(matches!(error, VehicleError::Transfer(_)), "{error}");
    world.faults.cut_after = None;
    wait(&mut world, 8_000);
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Unknown(Unknown::TransferFailed));
    for request in [ARM, mode("auto"), Request::MissionResume, Request::MissionStart { from_item: None }] {
        let error = ask(&mut world, request).expect_err("blocked");
        assert!(matches!(error, VehicleError::PlanUnknown { .. }), "{error}");
    }
    assert!(ask(&mut world, mode("FBWA")).is_ok() && ask(&mut world, Request::Disarm { force: false }).is_ok());
    assert_eq!(count(&world, Command::COMPONENT_ARM_DISARM), 1, "the disarming");
    ask(&mut world, upload()).expect("uploaded");
    assert!(ask(&mut world, ARM).is_ok());
}

#[test]
fn two_transfers_never_mix_and_a_failed_reading_forgets_nothing() {
    let mut world = connected();
    ask(&mut world, upload()).expect("uploaded");
    let known = world.station.vehicle.plan_state(PlanKind::Mission);
    let first = start(&mut world, Request::DownloadPlan { kind: PlanKind::Mission });
    for request in [upload(), Request::ClearPlan { kind: PlanKind::Rally }, Request::ParamList] {
        let error = ask(&mut world, request).expect_err("busy");
        assert_eq!(error, VehicleError::TransferBusy { running: "plan download" });
    }
    let now = world.now;
    world.station.vehicle.cancel(first, now);
    assert_eq!(end(&mut world, first, 5), Err(VehicleError::Cancelled));
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), known, "reading changes nothing");

    let second = start(&mut world, upload());
    wait(&mut world, 5);
    let now = world.now;
    world.station.vehicle.cancel(second, now);
    assert_eq!(end(&mut world, second, 5), Err(VehicleError::Cancelled));
    assert!(world.station.vehicle.plan_state(PlanKind::Mission).may_be_mixed());
    assert_eq!(world.station.vehicle.pending(), 0);
}

#[test]
fn parameters_are_read_and_written_one_after_the_other() {
    let mut world = connected();
    let set = |value| Request::ParamSet { name: "TKOFF_ALT".into(), value };
    let ids = [
        start(&mut world, Request::ParamList),
        start(&mut world, set(60.0)),
        start(&mut world, set(70.0)),
        start(&mut world, Request::ParamRead { name: "TKOFF_ALT".into() }),
    ];
    let results = ids.map(|id| end(&mut world, id, 30).expect("done"));
    assert!(matches!(&results[0], Reply::Parameters(all) if all.len() == 2));
    let Reply::Parameter(param) = results[3] else { panic!("{results:?}") };
    assert_eq!(param.value.as_f64(), 70.0);
    for bad in [set(f64::NAN), Request::ParamSet { name: "TOO_LONG_A_NAME_FOR_IT".into(), value: 1.0 }] {
        assert!(ask(&mut world, bad).is_err());
    }
}

#[test]
fn a_parameter_that_is_known_follows_what_the_vehicle_tells_of_it() {
    let mut world = connected();
    let tell = |world: &mut Pair, name: &str, value| {
        world.plane.tell_param(name, value, u16::MAX);
        wait(world, 500);
        let vehicle = &world.station.vehicle;
        (vehicle.flight_parameters().loiter_radius_m, vehicle.parameters().len())
    };
    assert_eq!(tell(&mut world, "WP_LOITER_RAD", 120.0), (None, 0), "nobody has read it");
    ask(&mut world, Request::ParamRead { name: "WP_LOITER_RAD".into() }).expect("read");
    // As an ArduPilot does to all when another station has set it.
    assert_eq!(tell(&mut world, "WP_LOITER_RAD", 120.0), (Some(120.0), 1));
    assert_eq!(tell(&mut world, "OTHER", 1.0), (Some(120.0), 1));
    assert_eq!(tell(&mut world, "WP_LOITER_RAD", 120.0), (Some(120.0), 1));
    let set = Request::ParamSet { name: "WP_LOITER_RAD".into(), value: 90.0 };
    ask(&mut world, set).expect("set");
    let changes = world.station.events.iter().filter_map(|event| match event {
        VehicleEvent::ParamChanged(param) => Some((param.name.to_string(), param.value.as_f64())),
        _ => None,
    });
    // Told by others, still what it was when it was read before it was set, and set: each once.
    let expected = [120.0, 80.0, 90.0].map(|value| ("WP_LOITER_RAD".to_owned(), value));
    assert_eq!(changes.collect::<Vec<_>>(), expected);
}

// ── restart and loss ─────────────────────────────────────────────────────────────────────────────────────────────────

#[test]
fn a_restart_ends_everything_and_begins_anew() {
    let mut world = connected();
    ask(&mut world, upload()).expect("uploaded");
    wait(&mut world, 60_000);
    let asked = world.plane.streams_asked;
    let now = world.now;
    world.plane.services.has_ftp = false;
    world.plane.reboot(now);
    let id = start(&mut world, Request::DownloadPlan { kind: PlanKind::Fence });
    // It answers nothing while it boots.
    world.faults.blackouts = vec![(now, now + Duration::from_millis(1_400))];
    let restarted = world.now;
    let noticed =
        world.run(restarted + Duration::from_secs(20), |station, _| station.events.contains(&VehicleEvent::Rebooted));
    assert!(noticed);
    assert!(world.now.since(restarted) < Duration::from_secs(4), "by TIMESYNC: nothing streams");
    wait(&mut world, 5_000);
    assert_eq!(world.station.events.iter().filter(|event| **event == VehicleEvent::Rebooted).count(), 1);
    assert_eq!(world.station.results[&id], Err(VehicleError::Rebooted));
    let vehicle = &world.station.vehicle;
    assert_eq!(vehicle.plan_state(PlanKind::Mission), PlanState::Unknown(Unknown::Rebooted));
    assert_eq!(world.plane.streams_asked, 2 * asked, "asked again, once");
    assert!(vehicle.telemetry().attitude.is_some());
    assert_eq!(vehicle.pending(), 0);
}

#[test]
fn a_reboot_that_was_asked_for_succeeds_by_its_acknowledgement_or_by_happening() {
    let mut world = connected();
    assert_eq!(ask(&mut world, Request::Reboot), Ok(Reply::Done));
    ask(&mut world, ARM).expect("armed");
    let error = ask(&mut world, Request::Reboot).expect_err("armed");
    assert_eq!(error.to_string(), "the vehicle is armed; disarm it before rebooting it");
    ask(&mut world, Request::Disarm { force: false }).expect("disarmed");
    // Restarted before it could answer.
    world.plane.mute = 1;
    let id = start(&mut world, Request::Reboot);
    wait(&mut world, 50);
    let now = world.now;
    world.plane.reboot(now);
    assert_eq!(end(&mut world, id, 20), Ok(Reply::Done));
    assert_eq!(count(&world, Command::PREFLIGHT_REBOOT_SHUTDOWN), 2, "never repeated");
    // Unheard, it is not rebooted.
    let now = world.now;
    world.faults.blackouts = vec![(now, now + Duration::from_secs(100))];
    wait(&mut world, 5_000);
    assert!(matches!(ask(&mut world, Request::Reboot), Err(VehicleError::NotHeard { .. })));
}

#[test]
fn loss_and_return_are_told_and_streams_asked_only_when_needed() {
    let mut world = connected();
    let asked = world.plane.streams_asked;
    let now = world.now;
    world.faults.blackouts = vec![(now, now + Duration::from_secs(10))];
    wait(&mut world, 5_900);
    assert!(world.station.events.contains(&VehicleEvent::Lost));
    assert!(!world.station.vehicle.is_heard(world.now));
    wait(&mut world, 10_000);
    assert!(world.station.events.contains(&VehicleEvent::Regained));
    assert_eq!(world.plane.streams_asked, asked, "it went on streaming");
    assert!(!world.station.events.contains(&VehicleEvent::Rebooted));
    // Back with heartbeats alone.
    let now = world.now;
    world.faults.blackouts = vec![(now, now + Duration::from_secs(10))];
    world.plane.is_streaming = false;
    wait(&mut world, 20_000);
    assert_eq!(world.plane.streams_asked, 2 * asked);
}

// ── requests in general ──────────────────────────────────────────────────────────────────────────────────────────────

fn every_request() -> Vec<Request> {
    let kind = PlanKind::Mission;
    let long = CommandLong { target: Address::new(0, 0), command: 183, confirmation: 0, params: [1.0; 7] };
    let int = CommandInt {
        target: Address::new(0, 0),
        frame: 0,
        command: 16,
        current: 0,
        autocontinue: 0,
        params: [0.0; 4],
        x: 1,
        y: 2,
        z: 3.0,
    };
    vec![
        ARM,
        Request::Disarm { force: true },
        mode("LOITER"),
        Request::Takeoff { alt_rel_home_m: 60.0 },
        reposition(40.334, -3.79, 80.0),
        Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: 18.0 },
        Request::ChangeAltitude { alt_m: 690.0, alt_frame: AltFrame::Amsl, below_home: false },
        Request::LoiterHere,
        Request::ReturnToLaunch,
        Request::Land,
        Request::AbortLanding { alt_rel_home_m: Some(40.0) },
        Request::PrepareFlight,
        Request::MissionStart { from_item: Some(1) },
        Request::MissionPause,
        Request::MissionResume,
        Request::SetCurrentItem { item: 2 },
        Request::SetHome { lat_deg: Some(40.0), lon_deg: Some(-3.0), alt_amsl_m: Some(600.0) },
        Request::SetHome { lat_deg: None, lon_deg: None, alt_amsl_m: None },
        Request::RawCommandLong(long),
        Request::RawCommandInt(int),
        Request::RequestMessage { message: MessageId(242) },
        Request::SetMessageRate { message: MessageId(30), rate_hz: MessageRate::Hz(20.0) },
        upload(),
        Request::DownloadPlan { kind },
        Request::ClearPlan { kind },
        Request::ParamList,
        Request::ParamRead { name: "TKOFF_ALT".into() },
        Request::ParamSet { name: "TKOFF_ALT".into(), value: 55.0 },
        Request::Reboot,
        Request::SwitchFence { on: true },
    ]
}

fn reposition(lat_deg: f64, lon_deg: f64, alt_m: f64) -> Request {
    Request::Reposition {
        lat_deg,
        lon_deg,
        alt_m,
        alt_frame: AltFrame::RelHome,
        radius_m: Some(80.0),
        turn: Turn::CounterClockwise,
        speed_m_s: None,
        change_mode: true,
        below_home: false,
    }
}

#[test]
fn every_request_ends_in_time_when_nobody_answers() {
    for request in every_request() {
        let mut world = connected();
        // A disarmed plane is not asked to land.
        (world.plane.mode, world.plane.is_armed) = (11, request == Request::Land);
        wait(&mut world, 1_500);
        let now = world.now;
        world.faults.blackouts = vec![(now, now + Duration::from_secs(1_000))];
        let result = ask(&mut world, request.clone());
        assert!(result.is_err(), "{request:?} cannot succeed: {result:?}");
        assert!(world.now.since(now) < Duration::from_secs(45), "{request:?} took {:?}", world.now.since(now));
        assert_eq!(world.station.vehicle.pending(), 0);
    }
}

#[test]
fn every_request_can_be_cancelled() {
    for request in every_request() {
        let mut world = connected();
        // A disarmed plane is not asked to land.
        (world.plane.mode, world.plane.is_armed) = (11, request == Request::Land);
        wait(&mut world, 1_500);
        let now = world.now;
        world.faults.blackouts = vec![(now, now + Duration::from_secs(1_000))];
        let id = start(&mut world, request.clone());
        wait(&mut world, 300);
        let now = world.now;
        world.station.vehicle.cancel(id, now);
        assert_eq!(end(&mut world, id, 1), Err(VehicleError::Cancelled), "{request:?}");
        assert_eq!(world.station.vehicle.pending(), 0);
        world.station.vehicle.cancel(id, now);
        wait(&mut world, 5_000);
    }
}

// fault 27 (20 seeds): 800 requests with losses, restarts and cancels: 0 commands that arm, start or change mode
/// Arms, changes the mode or starts only what was asked to: uploads, parameters, streams, restarts and losses do not.
#[test]
fn nothing_arms_or_starts_as_a_side_effect() {
    let harmless: Vec<_> = every_request()
        .into_iter()
        .filter(|request| {
            matches!(
                request,
                Request::UploadPlan { .. }
                    | Request::DownloadPlan { .. }
                    | Request::ClearPlan { .. }
                    | Request::ParamList
                    | Request::ParamRead { .. }
                    | Request::ParamSet { .. }
                    | Request::SetCurrentItem { .. }
                    | Request::ChangeSpeed { .. }
                    | Request::SetHome { .. }
                    | Request::RequestMessage { .. }
                    | Request::SetMessageRate { .. }
            )
        })
        .collect();
    assert_eq!(harmless.len(), 12);
    let mut asked = 0;
    for seed in 0..20 {
        let mut rng = SmallRng::seed_from_u64(seed);
        let mut world = World::new(Station::new(), Plane::new(), Faults::loss(0.1), seed);
        wait(&mut world, 3_000);
        for _ in 0..40 {
            let now = world.now;
            match rng.random_range(0..20) {
                0 => world.plane.reboot(now),
                1 => {
                    let id = RequestId(rng.random_range(0..40));
                    world.station.vehicle.cancel(id, now);
                }
                _ => {
                    start(&mut world, harmless[rng.random_range(0..harmless.len())].clone());
                    asked += 1;
                }
            }
            wait(&mut world, rng.random_range(0..800));
        }
        let dangerous = [
            Command::COMPONENT_ARM_DISARM,
            Command::DO_SET_MODE,
            Command::NAV_TAKEOFF,
            Command::MISSION_START,
            Command::DO_REPOSITION,
            Command::DO_LAND_START,
            Command::PREFLIGHT_REBOOT_SHUTDOWN,
        ];
        let sent =
            world.plane.commands.iter().map(|long| long.command).chain(world.plane.ints.iter().map(|int| int.command));
        assert!(sent.into_iter().all(|command| !dangerous.contains(&Command(command))));
        assert!(!world.plane.is_armed && world.plane.mode == 5);
    }
    assert!(asked > 500);
}

// fault 30 (1 seeds): 400 wild calls: what is refused sends nothing, what is sent is finite and in range
#[test]
fn what_is_sent_is_finite_and_in_range() {
    let mut rng = SmallRng::seed_from_u64(5);
    let wild = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        -1e300,
        1e-30,
        0.0,
        -0.0,
        91.0,
        -181.0,
        1e7,
        2_147_483_648.0,
    ];
    let (mut refused, mut accepted) = (0, 0);
    let rounds: usize = std::env::var("VENCEJO_TEST_CALLS").ok().and_then(|text| text.parse().ok()).unwrap_or(400);
    for round in 0..rounds {
        let mut world = connected();
        let mut number = |tame: f64| {
            if rng.random_bool(0.4) { wild[rng.random_range(0..wild.len())] } else { tame }
        };
        let request = match round % 9 {
            0 => Request::Takeoff { alt_rel_home_m: number(60.0) },
            1 => Request::Reposition {
                lat_deg: number(40.3),
                lon_deg: number(-3.8),
                alt_m: number(80.0),
                alt_frame: AltFrame::Terrain,
                radius_m: Some(number(60.0)),
                turn: Turn::Clockwise,
                speed_m_s: Some(number(15.0)),
                change_mode: false,
                below_home: false,
            },
            2 => Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s: number(15.0) },
            3 => Request::ChangeAltitude { alt_m: number(80.0), alt_frame: AltFrame::RelHome, below_home: false },
            4 => Request::AbortLanding { alt_rel_home_m: Some(number(30.0)) },
            5 => Request::SetHome {
                lat_deg: Some(number(40.3)),
                lon_deg: Some(number(-3.8)),
                alt_amsl_m: Some(number(600.0)),
            },
            6 => Request::SetMessageRate { message: MessageId(30), rate_hz: MessageRate::Hz(number(10.0)) },
            7 => {
                let params = std::array::from_fn(|_| number(1.0) as f32);
                let command = [Command::NAV_LOITER_UNLIM.0, Command::DO_SET_HOME.0][round % 2];
                Request::RawCommandLong(CommandLong { target: Address::new(0, 0), command, confirmation: 0, params })
            }
            _ => {
                let params = std::array::from_fn(|_| number(1.0) as f32);
                let (x, y, z) = (number(40e7) as i32, number(-3e7) as i32, number(80.0) as f32);
                let (target, command, frame) = (Address::new(0, 0), Command::DO_REPOSITION.0, 3);
                Request::RawCommandInt(CommandInt {
                    target,
                    frame,
                    command,
                    current: 0,
                    autocontinue: 0,
                    params,
                    x,
                    y,
                    z,
                })
            }
        };
        // The escape hatch lets NaN through, which means "as the vehicle likes".
        let is_raw = matches!(request, Request::RawCommandLong(_) | Request::RawCommandInt(_));
        let is_fit = |param: &f32| (is_raw && param.is_nan()) || param.abs() < 2_147_483_648.0;
        let before = (world.plane.commands.len(), world.plane.ints.len());
        match ask(&mut world, request.clone()) {
            Err(VehicleError::InvalidValue { .. }) => {
                refused += 1;
                let after = (world.plane.commands.len(), world.plane.ints.len());
                assert_eq!(before, after, "{request:?} was refused and sent");
            }
            _ => accepted += 1,
        }
        assert!(world.plane.commands.iter().all(|long| long.params.iter().all(is_fit)), "{request:?}");
        for int in &world.plane.ints {
            assert!(int.params.iter().chain([&int.z]).all(is_fit), "{request:?}");
            let is_place = |scaled: i32, limit| scaled == i32::MAX || scaled.abs() <= limit;
            assert!(is_place(int.x, 900_000_000) && is_place(int.y, 1_800_000_000), "{request:?}");
        }
    }
    assert!(refused > 100 && accepted > 100, "{refused} refused, {accepted} accepted");
}

// fault 30: raw messages: numbers that do not fit 32 bits, places off the Earth and heights of 0 are refused
#[test]
fn a_raw_message_with_a_number_that_an_autopilot_does_not_survive_is_refused() {
    let mut world = connected();
    let mut goes = |name: &str, fields: &[(&str, f64)]| {
        let value = |number: f64| {
            if number.fract() == 0.0 && number.abs() < 1e10 {
                FieldValue::Signed(number as i64)
            } else {
                FieldValue::Float(number)
            }
        };
        let fields = fields.iter().map(|(field, number)| ((*field).to_owned(), value(*number))).collect();
        let (id, payload) = encode_fields(name, &fields).expect("a message");
        let message = Message::from_payload(MavVersion::V2, id, &payload).expect("a message");
        match world.station.vehicle.on_sending(&message, false, world.now) {
            Ok(()) => true,
            Err(VehicleError::InvalidValue { .. }) => false,
            Err(other) => panic!("{name}: {other}"),
        }
    };
    let target = "SET_POSITION_TARGET_GLOBAL_INT";
    // A real ArduPlane in its simulator ended at the first of them (4.6.3, in GUIDED), and lived through the next.
    assert!(!goes(target, &[]));
    assert!(goes(target, &[("alt", 50.0), ("coordinate_frame", 6.0)]));
    assert!(goes(target, &[("type_mask", 4.0)]), "no height is told");
    for (field, number) in [("alt", 0.004), ("alt", 3e7), ("vx", 1e30), ("lat_int", 1e9), ("lon_int", -1.9e9)] {
        assert!(!goes(target, &[("alt", 50.0), (field, number)]), "{field} {number}");
    }
    assert!(!goes("SET_POSITION_TARGET_LOCAL_NED", &[("z", 1e8)]));
    assert!(!goes("SET_ATTITUDE_TARGET", &[("thrust", -1e20)]));
    assert!(!goes("SET_HOME_POSITION", &[("latitude", 2e9)]));
    assert!(!goes("GPS_INPUT", &[("hdop", 1e20)]));
    let waypoint = [("command", 16.0), ("frame", 3.0)];
    for (name, field, number) in
        [("MISSION_ITEM", "x", 91.0), ("MISSION_ITEM_INT", "y", 1.9e9), ("MISSION_ITEM_INT", "z", 1e8)]
    {
        assert!(goes(name, &waypoint));
        assert!(!goes(name, &[waypoint[0], waypoint[1], (field, number)]), "{name} {field}");
    }
    for command in ["COMMAND_LONG", "COMMAND_INT"] {
        let change = ("command", f64::from(Command::DO_CHANGE_ALTITUDE.0));
        assert!(!goes(command, &[change]) && !goes(command, &[change, ("param1", 3e7)]), "{command}");
        assert!(goes(command, &[change, ("param1", 80.0)]), "{command}");
        assert!(!goes(command, &[("command", f64::from(Command::DO_SET_MODE.0)), ("param3", 1e12)]), "{command}");
    }
    // ArduPlane 4.7 in its simulator ended at these: no number, and a time that is counted in milliseconds.
    for (command, field, number) in [(212.0, "param1", f64::NAN), (224.0, "param2", f64::NAN), (184.0, "param4", 2.2e6)]
    {
        assert!(!goes("COMMAND_LONG", &[("command", command), (field, number)]), "{command} {field}");
    }
    let reposition = [("command", f64::from(Command::DO_REPOSITION.0)), ("z", 80.0), ("param4", f64::NAN)];
    assert!(goes("COMMAND_INT", &reposition), "which way to circle is asked for");
    // Any number may be a parameter's: with PX4 the bytes of a whole one.
    assert!(
        goes("PARAM_SET", &[("param_type", 9.0), ("param_value", 1e30)])
            && goes("NAMED_VALUE_FLOAT", &[("value", 1e30)])
    );
    let level = Request::ChangeAltitude { alt_m: 0.0, alt_frame: AltFrame::RelHome, below_home: false };
    assert!(matches!(ask(&mut world, level), Err(VehicleError::InvalidValue { .. })));
}

#[test]
fn a_fixed_wing_takes_off_by_its_mode_and_never_arms_for_it() {
    let mut world = connected();
    assert_eq!(ask(&mut world, Request::Takeoff { alt_rel_home_m: 65.0 }), Ok(Reply::Done));
    assert_eq!((world.plane.mode, world.plane.is_armed), (13, false));
    assert_eq!(world.plane.services.params[0].value.as_f64(), 65.0);
    assert_eq!(ModeFamily::ArduPlane.parse("takeoff").expect("known").custom_mode, 13);
}

#[test]
fn commands_are_sent_as_a_real_plane_was_seen_to_take_them() {
    let mut world = connected();
    ask(&mut world, reposition(40.3340, -3.7900, 80.0)).expect("accepted");
    let int = world.plane.ints.last().expect("sent");
    assert_eq!(
        (int.frame, int.params, int.x, int.y, int.z),
        (3, [-1.0, 1.0, 80.0, 1.0], 403_340_000, -37_900_000, 80.0)
    );
    ask(&mut world, Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: 18.0 }).expect("accepted");
    assert_eq!(world.plane.commands.last().expect("sent").params, [0.0, 18.0, -1.0, 0.0, 0.0, 0.0, 0.0]);
    ask(&mut world, Request::MissionStart { from_item: Some(1) }).expect("started");
    assert_eq!((world.plane.current, world.plane.mode, world.plane.is_armed), (1, 10, false));
    let sent: Vec<f32> =
        world.plane.commands.iter().filter(|long| long.command == 224).map(|long| long.params[0]).collect();
    assert_eq!(sent, [0.0], "its beginning: the jump counters go back too");
    let reply = ask(&mut world, Request::RequestMessage { message: MessageId(148) }).expect("sent");
    assert!(matches!(reply, Reply::Message(message) if message.id() == 148));
    let error = ask(&mut world, Request::RequestMessage { message: MessageId(253) }).expect_err("never sent");
    assert_eq!(error, VehicleError::MessageNotReceived { message_id: 253 });
    assert!(ask(&mut world, Request::RequestMessage { message: MessageId(1 << 24) }).is_err());
    // A raw command reaches the vehicle though it names nobody.
    let raw =
        CommandLong { target: Address::new(0, 0), command: Command::DO_GO_AROUND.0, confirmation: 0, params: [0.0; 7] };
    assert_eq!(ask(&mut world, Request::RawCommandLong(raw)), Ok(Reply::Acknowledged { result_param2: 0 }));
    assert_eq!(world.plane.commands.last().expect("sent").target, PLANE);
}

// ── before a flight ──────────────────────────────────────────────────────────────────────────────────────────────────

/// What was sent that changes the vehicle: command and first parameters.
fn acts(world: &Pair, from: usize) -> Vec<(u16, f32, f32)> {
    let sent = world.plane.commands[from..].iter();
    let tuning = [Command::SET_MESSAGE_INTERVAL.0, Command::REQUEST_MESSAGE.0];
    sent.filter(|long| !tuning.contains(&long.command))
        .map(|long| (long.command, long.params[0], long.params[1]))
        .collect()
}

#[test]
fn a_flight_is_prepared_from_where_the_last_one_ended() {
    // The mode after a landing, after the mission was replaced there, and the pilot's own.
    for (mode, arms) in [(10, false), (11, false), (13, false), (5, true)] {
        let mut world = connected();
        ask(&mut world, upload()).expect("uploaded");
        (world.plane.mode, world.plane.current) = (mode, 4);
        wait(&mut world, 1_500);
        let needed = world.station.vehicle.flight_preparation().expect("heard");
        assert!(needed.is_needed() && needed.rewinds_mission);
        assert_eq!(needed.mode.map(|mode| mode.to_string()), (!arms).then(|| "MANUAL".to_owned()));
        let before = world.plane.commands.len();
        assert_eq!(ask(&mut world, Request::PrepareFlight), Ok(Reply::Done));
        let rewind = (Command::DO_SET_MISSION_CURRENT.0, 0.0, 0.0);
        let to_manual = (Command::DO_SET_MODE.0, 1.0, 0.0);
        assert_eq!(acts(&world, before), if arms { vec![rewind] } else { vec![to_manual, rewind] });
        assert!(!world.plane.is_armed, "it does not arm");
        let said: Vec<_> = world.station.vehicle.texts().iter().map(|text| text.text.clone()).collect();
        assert_eq!(said.last(), Some(&format!("Preparing a flight: {needed}")), "said");
        wait(&mut world, 1_500);
        let done = world.station.vehicle.flight_preparation().expect("heard");
        assert!(!done.is_needed(), "{done:?}");
        // Again it does no harm.
        assert_eq!(ask(&mut world, Request::PrepareFlight), Ok(Reply::Done));
    }
}

#[test]
fn a_flight_is_prepared_only_on_the_ground_and_disarmed() {
    let mut world = connected();
    // Without a mission there is nothing to set back.
    world.plane.mode = 11;
    wait(&mut world, 1_500);
    let needed = world.station.vehicle.flight_preparation().expect("heard");
    assert_eq!((needed.to_string().as_str(), needed.rewinds_mission), ("mode RTL to MANUAL", false));
    world.plane.landed = MavLandedState::MAV_LANDED_STATE_IN_AIR;
    wait(&mut world, 1_500);
    let before = world.plane.commands.len();
    let error = ask(&mut world, Request::PrepareFlight).expect_err("in the air, disarmed by force");
    assert_eq!(error, VehicleError::InTheAir { action: "preparing a flight" });
    world.plane.landed = MavLandedState::MAV_LANDED_STATE_ON_GROUND;
    world.plane.is_armed = true;
    wait(&mut world, 1_500);
    let error = ask(&mut world, Request::PrepareFlight).expect_err("armed");
    assert_eq!(error, VehicleError::Armed { action: "preparing a flight" });
    assert_eq!(acts(&world, before), []);
}

#[test]
fn a_refusal_to_arm_names_the_mode_that_cures_it() {
    let mut world = connected();
    world.plane.mode = 10;
    world.plane.refuses = Some(vec!["Arm: In landing sequence"]);
    wait(&mut world, 1_500);
    let error = ask(&mut world, ARM).expect_err("refused");
    assert!(error.to_string().ends_with("; prepare the flight, or change to mode MANUAL, then arm"), "{error}");
    world.plane.refuses = Some(vec!["Arm: GPS 1: Bad fix"]);
    let error = ask(&mut world, ARM).expect_err("refused");
    assert!(matches!(&error, VehicleError::CommandRefused { cure: None, .. }), "{error}");
}

#[test]
fn who_only_listens_sends_nothing_until_something_is_asked() {
    let config = VehicleConfig { streams: StreamConfig::listen_only(), only_listens: true, ..VehicleConfig::default() };
    let mut station = Station::with(config);
    let heartbeat = Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() });
    let asks = Message::Dialect(MavMessage::TIMESYNC(TIMESYNC_DATA { ts1: 5, ..TIMESYNC_DATA::default() }));
    let pass = |station: &mut Station, ms| {
        station.receive(PLANE, &heartbeat, MonoTime::from_millis(ms));
        station.receive(PLANE, &asks, MonoTime::from_millis(ms));
        station.tick(MonoTime::from_millis(ms));
    };
    for ms in (0..20_000).step_by(500) {
        pass(&mut station, ms);
        assert_eq!(station.next_output(), None, "at {ms} ms");
        assert!(station.vehicle.deadline().is_some_and(|due| due > station.now), "and does not wake for nothing");
        assert_eq!(station.vehicle.is_reached(station.now), None);
    }
    station.vehicle.request(Request::ReturnToLaunch, station.now);
    pass(&mut station, 19_500);
    let sent: Vec<_> = std::iter::from_fn(|| station.next_output()).collect();
    let questions = sent.iter().filter(|message| matches!(message, Message::Dialect(MavMessage::TIMESYNC(_))));
    assert_eq!((sent.len(), questions.count()), (3, 2), "the act, an answer and a question: {sent:?}");
}

#[test]
fn requests_are_bounded() {
    let mut world = connected();
    let now = world.now;
    world.faults.blackouts = vec![(now, now + Duration::from_secs(1_000))];
    let read = || Request::ParamRead { name: "TKOFF_ALT".into() };
    let ids: Vec<_> = (0..MAX_REQUESTS + 5).map(|_| start(&mut world, read())).collect();
    let error = end(&mut world, ids[MAX_REQUESTS], 1).expect_err("too many");
    assert_eq!(error, VehicleError::TooManyRequests { limit: MAX_REQUESTS });
}

// ── what a real plane was recorded to say ────────────────────────────────────────────────────────────────────────────

/// Plays a recording to a vehicle, asking at the moments at which the recording's station asked.
fn play(name: &str, requests: &[(u64, Request)]) -> Station {
    play_with(name, requests, |_, _| ())
}

/// The same; `before` each message something may be done.
fn play_with(name: &str, requests: &[(u64, Request)], mut before: impl FnMut(&mut Vehicle, MonoTime)) -> Station {
    let config = VehicleConfig { streams: StreamConfig::listen_only(), ..VehicleConfig::default() };
    let mut station = Station::with(config);
    let mut requests = requests.iter();
    let mut next = requests.next();
    let mut now = MonoTime::ZERO;
    let drain = |station: &mut Station| while station.next_output().is_some() {};
    for (at, message) in recorded(name, PLANE) {
        while let Some((ms, request)) = next
            && MonoTime::from_millis(*ms) <= at
        {
            station.vehicle.request(request.clone(), MonoTime::from_millis(*ms));
            next = requests.next();
        }
        while let Some(due) = station.vehicle.deadline().filter(|due| *due <= at) {
            station.tick(due);
            drain(&mut station);
        }
        now = at;
        before(&mut station.vehicle, at);
        station.receive(PLANE, &message, at);
        drain(&mut station);
    }
    for _ in 0..1_000 {
        let Some(due) = station.vehicle.deadline() else { break };
        if due > now + Duration::from_secs(60) {
            break;
        }
        station.tick(due);
        drain(&mut station);
    }
    assert!(next.is_none(), "all were asked");
    station
}

#[test]
fn modes_and_refusals_of_a_recorded_plane() {
    let takeoff = CommandLong { target: PLANE, command: Command::NAV_TAKEOFF.0, confirmation: 0, params: [0.0; 7] };
    // The first heartbeat of the recording is the one that shows AUTO, so the mode is asked for by number.
    let station = play(
        "arm-refused-and-modes",
        &[
            (1_003, ARM),
            (2_101, Request::SetMode { mode: ModeChoice::Custom(99) }),
            (3_104, Request::RawCommandLong(takeoff)),
        ],
    );
    let results: Vec<_> = station.results.values().collect();
    assert_eq!(results.len(), 3);
    assert_eq!(*results[0], Ok(Reply::Done));
    let error = results[1].as_ref().expect_err("no such mode").to_string();
    assert_eq!(error, "vehicle 1/1 refused DO_SET_MODE (176): failed (MAV_RESULT_FAILED, 4): No such mode 99");
    let error = results[2].as_ref().expect_err("a plane");
    assert!(matches!(error, VehicleError::CommandRefused { result: CommandResult::FAILED, .. }), "{error}");
}

#[test]
fn a_recorded_plane_that_has_landed_needs_another_mode() {
    // The same mission sent again to a plane that has landed in AUTO: it falls to RTL.
    let station = play("second-flight-refused", &[]);
    let texts: Vec<_> = station.vehicle.texts().iter().map(|text| text.text.as_str()).collect();
    assert!(texts.contains(&"Aircraft in auto without a running mission"));
    assert!(texts.contains(&"PreArm: RTL mode not armable"));
    let needed = station.vehicle.flight_preparation().expect("heard");
    assert_eq!(needed.to_string(), "mode RTL to MANUAL, the mission back to its beginning");
    assert!(needed.is_needed() && !needed.has_moved_on);
}

#[test]
fn a_recorded_guided_flight_confirms_what_was_asked() {
    let station = play(
        "guided-flight",
        &[
            (577, ARM),
            (31_882, reposition(40.334, -3.79, 80.0)),
            (57_883, Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: 18.0 }),
            (59_982, Request::LoiterHere),
        ],
    );
    assert_eq!(station.results.len(), 4);
    for (id, result) in &station.results {
        assert_eq!(*result, Ok(Reply::Done), "{id}");
    }
    let modes: Vec<_> = station
        .events
        .iter()
        .filter_map(|event| match event {
            VehicleEvent::ModeChanged { to, .. } => to.name(),
            _ => None,
        })
        .collect();
    // A command of the recording's station made the last two.
    assert_eq!(modes, ["TAKEOFF", "GUIDED", "LOITER", "RTL", "AUTO"]);
}

#[test]
fn a_recorded_flight_is_followed_from_boot_to_landing() {
    // Commands of the missions, as their texts name them: "Mission: 7 LoitTurns".
    let first = [22, 16, 16, 16, 16, 16, 18, 178, 189, 16, 21];
    let second = [22, 16, 16, 16, 16, 16, 31, 16, 16, 16, 177, 189, 16, 21];
    for (name, commands, actions, times_of_10) in [
        ("arduplane-takeoff-to-landing", &first[..], vec![8, 9], 1),
        ("arduplane-wind-flight", &second[..], vec![12], 2),
    ] {
        let last = commands.len() as u16;
        let items: Vec<_> = commands.iter().map(|command| MissionItem::action(Command(*command), [0.0; 4])).collect();
        let home = Some(Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 });
        let mut plan = Some(Mission { home, items }.to_wire(PLANE, true).expect("a plan"));
        let station = play_with(name, &[], |vehicle, at| {
            // The flight begins with a plan that is known.
            if let Some(wire) = plan.take_if(|_| at > MonoTime::from_millis(25_000)) {
                vehicle.on_plan(PlanKind::Mission, &wire, None, false, false, at).expect("known");
            }
        });
        let vehicle = &station.vehicle;
        let told = |wanted: &VehicleEvent| station.events.iter().filter(|event| *event == wanted).count();
        assert_eq!(told(&VehicleEvent::Rebooted), 0, "{name}");
        assert_eq!(told(&VehicleEvent::ArmedChanged { is_armed: true }), 1, "{name}");
        assert_eq!(told(&VehicleEvent::MissionComplete), 1, "{name}: it landed and disarmed");
        let progress = vehicle.progress();
        assert!(progress.is_complete);
        assert_eq!((progress.current, progress.total), (Some(MissionSeq(last)), Some(last)));
        let seqs: Vec<_> = progress.reached.iter().map(|seq| seq.0).collect();
        let is_nav = |seq: &u16| Command(commands[usize::from(*seq) - 1]).is_nav();
        // The landing ends with the flight; the actions that were told.
        assert_eq!(seqs, (1..last).filter(|seq| is_nav(seq) || actions.contains(seq)).collect::<Vec<_>>(), "{name}");
        assert_eq!(told(&VehicleEvent::ItemReached { seq: MissionSeq(7) }), 1, "{name}");
        assert_eq!(told(&VehicleEvent::ItemReached { seq: MissionSeq(10) }), times_of_10, "{name}");
        let texts: Vec<_> = vehicle.texts().iter().map(|text| text.text.as_str()).collect();
        assert!(texts.contains(&"Reached waypoint #2 dist 38m") || name != "arduplane-takeoff-to-landing");
        assert_eq!(vehicle.telemetry().invalid_values, 0);
        let complete = station.events.iter().position(|event| *event == VehicleEvent::MissionComplete);
        let disarmed =
            station.events.iter().rposition(|event| *event == VehicleEvent::ArmedChanged { is_armed: false });
        assert!(complete > disarmed, "{name}");
    }
}
