//! What can be asked of a vehicle, and what comes back.

use std::fmt;

use vencejo_flight::plan::{Home, MissionItem, PlanKind};
use vencejo_proto::{CommandInt, CommandLong, Message, MissionSeq};

use crate::error::VehicleError;
use crate::modes::FlightMode;
use crate::plan_record::StoredRecord;
use crate::plan_state::PlanState;
use crate::telemetry::{LandedState, Severity, Text};
use crate::transfer::Param;

/// Names a request of one [`crate::Vehicle`], to cancel it and to know its result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RequestId(pub u64);

impl fmt::Display for RequestId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A flight mode as a caller names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModeChoice {
    /// By name: `"AUTO"`, `"fbwa"`, `"Avoid ADSB"`, `"mode 42"`.
    Name(String),
    /// By the number of HEARTBEAT's `custom_mode`.
    Custom(u32),
}

/// What a height in a request is counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AltFrame {
    /// Above mean sea level (`MAV_FRAME_GLOBAL`).
    Amsl,
    /// Above home (`MAV_FRAME_GLOBAL_RELATIVE_ALT`).
    RelHome,
    /// Above the terrain below (`MAV_FRAME_GLOBAL_TERRAIN_ALT`).
    Terrain,
}

impl AltFrame {
    /// The number on the wire (`MAV_FRAME`).
    #[must_use]
    pub const fn mav_frame(self) -> u8 {
        match self {
            Self::Amsl => 0,
            Self::RelHome => 3,
            Self::Terrain => 10,
        }
    }
}

/// Which speed DO_CHANGE_SPEED sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SpeedKind {
    /// Through the air.
    Airspeed,
    /// Over ground.
    Groundspeed,
}

/// Which way to circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Turn {
    /// Clockwise seen from above.
    #[default]
    Clockwise,
    /// Counter-clockwise seen from above.
    CounterClockwise,
}

/// Something to do. Every value is checked before anything is sent.
///
/// Upload, arm, mode and start are separate acts: no request does another as a side effect. Each one says below which
/// messages it sends and when it counts as done.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Request {
    /// Arms. Done when a HEARTBEAT shows it. `force` skips the vehicle's own checks (magic number 21196).
    Arm {
        /// Arm in spite of failing pre-arm checks.
        force: bool,
    },
    /// Disarms. Done when a HEARTBEAT shows it. `force` disarms in the air.
    Disarm {
        /// Disarm even while flying.
        force: bool,
    },
    /// Changes the mode. Done when a HEARTBEAT shows it.
    SetMode(ModeChoice),
    /// Takes off. A fixed-wing ArduPilot: sets parameter `TKOFF_ALT`, then mode TAKEOFF; it starts to roll when it is
    /// armed (or at once when it already is). Others: MAV_CMD_NAV_TAKEOFF, for which they must be armed.
    Takeoff {
        /// Height to climb to, metres above home, 1 to 10,000.
        alt_rel_home_m: f64,
    },
    /// Flies to a position and loiters there: MAV_CMD_DO_REPOSITION by COMMAND_INT. An ArduPlane from before COMMAND_INT gets
    /// MISSION_ITEM with `current` = 2 instead, which enters GUIDED by itself and knows neither radius nor sense nor speed
    /// ([`VehicleError::TooOld`]).
    Reposition {
        /// WGS-84 latitude.
        lat_deg: f64,
        /// WGS-84 longitude.
        lon_deg: f64,
        /// Height, counted as `alt_frame` says.
        alt_m: f64,
        /// What `alt_m` is counted from.
        alt_frame: AltFrame,
        /// Radius of the loiter, metres; `None`: the vehicle's own.
        radius_m: Option<f64>,
        /// Sense of the loiter.
        turn: Turn,
        /// Ground speed; `None`: the vehicle's own.
        speed_m_s: Option<f64>,
        /// Whether to enter GUIDED for it; without it a vehicle in another mode refuses.
        change_mode: bool,
    },
    /// Changes the speed: MAV_CMD_DO_CHANGE_SPEED.
    ChangeSpeed {
        /// Which speed.
        kind: SpeedKind,
        /// How fast, above 0 to 200.
        speed_m_s: f64,
    },
    /// Changes the height of the present target: MAV_CMD_DO_CHANGE_ALTITUDE. For ArduPlane in GUIDED or LOITER. One from before
    /// COMMAND_INT gets MISSION_ITEM with `current` = 3.
    ChangeAltitude {
        /// Height, counted as `alt_frame` says; not 0, which ArduPlane takes for none.
        alt_m: f64,
        /// What `alt_m` is counted from.
        alt_frame: AltFrame,
    },
    /// Turns to a course over ground and stays on it: MAV_CMD_GUIDED_CHANGE_HEADING. Only for an ArduPlane in GUIDED, which
    /// no request enters for it.
    GuidedCourse {
        /// Course over ground, degrees from true north, 0 to below 360.
        course_deg: f64,
        /// Centripetal acceleration of the turn at most, m/s², 0.05 to 20; 5 is a bank of 27 degrees.
        accel_m_s2: f64,
    },
    /// Climbs or sinks to a height at a rate: MAV_CMD_GUIDED_CHANGE_ALTITUDE. Only for an ArduPlane in GUIDED.
    GuidedClimb {
        /// Height, counted as `alt_frame` says; ArduPlane takes neither 0 nor −1.
        alt_m: f64,
        /// What `alt_m` is counted from.
        alt_frame: AltFrame,
        /// How fast, up or down, m/s, above 0 to 50.
        rate_m_s: f64,
    },
    /// Flies at a velocity: SET_POSITION_TARGET_LOCAL_NED, relative to the heading. Only for an ArduCopter in GUIDED or a PX4 in
    /// OFFBOARD, which no request enters for it. It has no answer: done when it is sent. The vehicle stops by itself when it is
    /// not repeated (ArduCopter after GUID_TIMEOUT, 3 s; PX4 after 0.5 s).
    Velocity {
        /// Forward, m/s, −50 to 50.
        forward_m_s: f64,
        /// To the right, m/s, −50 to 50.
        right_m_s: f64,
        /// Down, m/s, −50 to 50.
        down_m_s: f64,
        /// Clockwise seen from above, rad/s, −10 to 10.
        yaw_rate_rad_s: f64,
    },
    /// Circles (or hovers) here: mode LOITER.
    LoiterHere,
    /// Returns to launch: mode RTL.
    ReturnToLaunch,
    /// Lands. A fixed-wing ArduPilot: jumps to the landing sequence of its mission (MAV_CMD_DO_LAND_START). Others: mode LAND.
    Land,
    /// Aborts a landing and climbs: MAV_CMD_DO_GO_AROUND.
    AbortLanding {
        /// Height to climb to, metres above home; `None`: the vehicle's own.
        alt_rel_home_m: Option<f64>,
    },
    /// Prepares a flight, on the ground and disarmed: changes to a mode that arms where the present one does not
    /// ([`FlightMode::to_arm_in`]), and sets the mission, when there is one, back to its beginning, its jump counters too. A text
    /// ([`Request::Note`]) says so before. Refused when armed or in the air. It neither arms nor starts;
    /// [`crate::Vehicle::flight_preparation`] tells before what it does.
    PrepareFlight,
    /// Starts the mission: mode AUTO, after setting the current item when `from` is given. Never arms. The first item is the
    /// mission's beginning: its jump counters are set back too.
    MissionStart {
        /// Item to begin with; `None`: where the vehicle stands in the mission.
        from: Option<MissionSeq>,
    },
    /// Interrupts the mission: mode LOITER.
    MissionPause,
    /// Goes on with the mission where it stands: mode AUTO.
    MissionResume,
    /// Makes an item the current one: MAV_CMD_DO_SET_MISSION_CURRENT, or MISSION_SET_CURRENT for an older vehicle.
    SetCurrentItem(MissionSeq),
    /// Moves home to a position, or to where the vehicle is: MAV_CMD_DO_SET_HOME.
    SetHome(Option<Home>),
    /// Any command by COMMAND_LONG. Its `target` is replaced by the vehicle when it is 0/0. Not repeated when it gets no
    /// answer, unless it is known to be safe to do twice ([`crate::command::is_idempotent`]).
    RawCommandLong(CommandLong),
    /// Any command by COMMAND_INT, likewise.
    RawCommandInt(CommandInt),
    /// Asks for one message once: MAV_CMD_REQUEST_MESSAGE. Done when the message arrives.
    RequestMessage {
        /// Message id.
        message_id: u32,
    },
    /// Sets the rate of a message, now and after every reboot: MAV_CMD_SET_MESSAGE_INTERVAL.
    SetMessageRate {
        /// Message id.
        message_id: u32,
        /// Messages per second, above 0 to 50; `None` stops it.
        rate_hz: Option<f64>,
    },
    /// Replaces a plan and reads it back: done when the vehicle has it. For an ArduPilot mission `items` does not hold home;
    /// it is put in front as item 0.
    UploadPlan {
        /// What to replace.
        kind: PlanKind,
        /// The new list. Empty: clears it.
        items: Vec<MissionItem>,
        /// Home to send with a mission; `None`: the vehicle's own.
        home: Option<Home>,
        /// Whether a mission is sent in spite of errors that the checks find. Whoever asks has checked it; a station on board, which knows
        /// more of its vehicle, checks once more what comes to it from far away.
        despite_findings: bool,
    },
    /// Reads a plan.
    DownloadPlan {
        /// What to read.
        kind: PlanKind,
    },
    /// Removes a plan and checks that it is gone.
    ClearPlan {
        /// What to remove.
        kind: PlanKind,
    },
    /// Reads all parameters.
    ParamList,
    /// Reads one parameter.
    ParamRead {
        /// Name, up to 16 characters.
        name: String,
    },
    /// Writes one parameter. Done when the vehicle says that it has the value.
    ParamSet {
        /// Name, up to 16 characters.
        name: String,
        /// Value; must be finite.
        value: f64,
    },
    /// Puts a text of ours beside those of the vehicle, as component 190: for whoever watches this vehicle through this station.
    /// Nothing is sent.
    Note {
        /// How serious it is.
        severity: Severity,
        /// The text; cut to 500 characters.
        text: String,
    },
    /// Reboots the autopilot. Only when a fresh HEARTBEAT shows it disarmed.
    Reboot,
    /// Does what is asked although the mission on board may be a mixture ([`PlanState::may_be_mixed`]), in which case arming,
    /// following the mission and jumping in it are refused otherwise. It is written among the vehicle's texts and in the log.
    DespiteMixedPlan(Box<Request>),
}

impl Request {
    /// Whether it changes something on the vehicle. What only reads, or sends nothing, does not.
    #[must_use]
    pub const fn is_act(&self) -> bool {
        !matches!(
            self,
            Self::RequestMessage { .. }
                | Self::DownloadPlan { .. }
                | Self::ParamList
                | Self::ParamRead { .. }
                | Self::Note { .. }
        )
    }
}

/// The result of a request that succeeded.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Reply {
    /// The vehicle did it (and shows it, where the request says so).
    Done,
    /// A command's acknowledgement with its `result_param2`.
    Acknowledged {
        /// `result_param2` of COMMAND_ACK; what it means depends on the command.
        result_param2: i32,
    },
    /// The message that was requested.
    Message(Box<Message>),
    /// The plan on board, as sent or as read.
    Plan {
        /// Which.
        kind: PlanKind,
        /// Its items, without home.
        items: Vec<MissionItem>,
        /// Item 0 of an ArduPilot mission.
        home: Option<Home>,
        /// What is known of it now.
        state: PlanState,
        /// After an upload to a vehicle that holds positions as 32-bit floats: how far the farthest is from where it was sent to
        /// be, metres. `None`: exact.
        position_error_m: Option<f64>,
    },
    /// All parameters, by name.
    Parameters(Vec<Param>),
    /// One parameter as the vehicle has it.
    Parameter(Param),
}

/// What a vehicle's state machines want of their owner. Drain with [`crate::Vehicle::poll_output`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
#[allow(clippy::large_enum_variant, reason = "moved once, from the queue to the link")]
pub enum Output {
    /// Send this to the vehicle.
    Send(Message),
    /// A request goes on.
    Progress {
        /// Which.
        id: RequestId,
        /// How much is done, in units of `total`.
        done: u32,
        /// How much there is; 0 when not known yet.
        total: u32,
    },
    /// A request ended. Comes exactly once for each.
    Finished {
        /// Which.
        id: RequestId,
        /// How.
        result: Result<Reply, VehicleError>,
    },
    /// Something happened.
    Event(VehicleEvent),
    /// Write this down so that it survives the end of the program, then call [`crate::Vehicle::on_kept`]. An empty record is
    /// to be removed. Only with [`crate::VehicleConfig::keeps_records`].
    Keep {
        /// Grows with each.
        ticket: u64,
        /// What, and whose.
        stored: StoredRecord,
    },
}

/// Something worth telling, apart from new telemetry.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum VehicleEvent {
    /// The vehicle was lost (nothing heard for 5 s).
    Lost,
    /// The vehicle is heard again.
    Regained,
    /// The vehicle is heard, but has answered nothing of ours for 4.5 s, asked again and again: the uplink is dead.
    Unreached,
    /// The vehicle answers again.
    Reached,
    /// The autopilot restarted; telemetry from before is forgotten, plans are unknown, rates are asked again.
    Rebooted,
    /// The mode changed (or was heard for the first time).
    ModeChanged {
        /// Before.
        from: Option<FlightMode>,
        /// Now.
        to: FlightMode,
    },
    /// Armed or disarmed (or heard for the first time).
    ArmedChanged {
        /// Now.
        is_armed: bool,
    },
    /// Landed, flying or between changed.
    LandedChanged {
        /// Now.
        landed: LandedState,
    },
    /// A text from the vehicle, its chunks joined.
    Text(Text),
    /// The current mission item changed.
    CurrentItemChanged {
        /// Now.
        seq: MissionSeq,
    },
    /// A mission item was reached.
    ItemReached {
        /// Which.
        seq: MissionSeq,
    },
    /// The mission was flown to its end.
    MissionComplete,
    /// What is known of a plan on board changed.
    PlanStateChanged {
        /// Which.
        kind: PlanKind,
        /// Now.
        state: PlanState,
    },
    /// In AUTO it flies to somewhere else than the current item of the plan that was read from it: an alarm.
    TargetElsewhere {
        /// The current item.
        seq: MissionSeq,
        /// From the item's position to where it flies, metres.
        distance_m: f64,
    },
    /// It flies to where its plan says again.
    TargetAsPlanned {
        /// The current item.
        seq: MissionSeq,
    },
    /// The vehicle moved its home.
    HomeChanged,
    /// The vehicle does not know SET_MESSAGE_INTERVAL; its data streams were asked for instead.
    StreamsFellBack,
    /// Another vehicle uses the same system id: it is not followed, and nothing is sent to it.
    Contested,
    /// The other is not heard any more.
    Uncontested,
    /// It asks for the ground's heights at places that no map here knows.
    TerrainUnknown,
    /// All the heights that it asked for are known again.
    TerrainKnown,
}
