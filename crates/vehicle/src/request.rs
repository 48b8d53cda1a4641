//! Requests to a vehicle, and their results. With the feature `describe` the requests describe themselves: names,
//! values and ranges, from which the front ends are generated.

use std::fmt;

use vencejo_flight::plan::{Home, MissionItem, PlanKind};
use vencejo_proto::{CommandInt, CommandLong, Message, MissionSeq};

use crate::choice::{AltFrame, MessageId, MessageRate, ModeChoice, SpeedKind, Turn};
#[cfg(feature = "describe")]
use crate::choice::{MessageChoice, RateChoice};
#[cfg(feature = "describe")]
use crate::described::given;
use crate::error::VehicleError;
use crate::modes::FlightMode;
use crate::plan_record::StoredRecord;
use crate::plan_state::PlanState;
use crate::telemetry::{LandedState, Severity, Text};
use crate::transfer::Param;

/// Identifies a request of one [`crate::Vehicle`], to cancel it and to match its result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RequestId(pub u64);

impl fmt::Display for RequestId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A request. Every value is checked before anything is sent.
///
/// Upload, arm, mode and start are separate acts: no request does another as a side effect. Each variant documents
/// which messages it sends and when it counts as done (`vehicle/steps.rs`). Variants without `serde(skip)` are also, by
/// their names, paths of the HTTP API, requests of Python's native module, and orders to remote vehicles, with the
/// documentation here.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "describe",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "kebab-case", rename_all_fields = "snake_case", deny_unknown_fields)
)]
#[non_exhaustive]
pub enum Request {
    /// Arms. Done when a HEARTBEAT shows it; refused with the vehicle's reasons when its checks fail.
    Arm {
        /// In spite of the vehicle's own checks (magic number 21196). A PX4 runs them all the same.
        #[cfg_attr(feature = "describe", serde(default))]
        force: bool,
    },
    /// Disarms. Done when a HEARTBEAT shows it.
    Disarm {
        /// Even while flying.
        #[cfg_attr(feature = "describe", serde(default))]
        force: bool,
    },
    /// Changes the flight mode. Done when a HEARTBEAT shows it.
    #[cfg_attr(feature = "describe", serde(rename = "mode"))]
    SetMode {
        /// Which: its name, one of the vehicle's `mode_names`, or its number on the wire.
        mode: ModeChoice,
    },
    /// Takes off. A fixed-wing ArduPilot: sets parameter `TKOFF_ALT`, then mode TAKEOFF; it starts to roll when it is
    /// armed (or at once when it already is). Others: MAV_CMD_NAV_TAKEOFF, for which they must be armed.
    Takeoff {
        /// Height to climb to, metres above home, 1 to 10,000.
        #[cfg_attr(feature = "describe", schema(minimum = 1, maximum = 10_000))]
        alt_rel_home_m: f64,
    },
    /// Flies to a position, at most 200 km from home or the vehicle, and circles there: MAV_CMD_DO_REPOSITION by
    /// COMMAND_INT. An ArduPlane from before COMMAND_INT gets MISSION_ITEM with `current` = 2 instead, which enters
    /// GUIDED by itself and knows neither radius nor sense nor speed. A fixed wing with PX4 gets MAV_CMD_DO_ORBIT for a
    /// radius or sense of its own. For a speed a plane gets MAV_CMD_DO_CHANGE_SPEED afterwards; if it refuses that, it
    /// flies to the position all the same.
    #[cfg_attr(feature = "describe", serde(rename = "goto"))]
    Reposition {
        /// WGS-84 latitude.
        #[cfg_attr(feature = "describe", schema(minimum = -90, maximum = 90))]
        lat_deg: f64,
        /// WGS-84 longitude.
        #[cfg_attr(feature = "describe", schema(minimum = -180, maximum = 180))]
        lon_deg: f64,
        /// Height, counted as `alt_frame` says; above home or terrain not 0, which ArduPilot takes for none.
        #[cfg_attr(feature = "describe", schema(minimum = -1_000, maximum = 100_000))]
        alt_m: f64,
        /// Reference of `alt_m`.
        alt_frame: AltFrame,
        /// Radius of the circle, 1 to 30,000. When absent the vehicle's own, or with an ArduPlane in GUIDED that of the
        /// go-to before.
        #[cfg_attr(feature = "describe", schema(minimum = 1, maximum = 30_000))]
        radius_m: Option<f64>,
        /// Sense of the circle; clockwise when absent.
        #[cfg_attr(feature = "describe", serde(rename = "clockwise", default), schema(value_type = bool))]
        turn: Turn,
        /// Speed, 0.1 to 200: of a plane an airspeed, of others over ground. When absent the vehicle's own, or with an
        /// ArduPlane in GUIDED that of the go-to before.
        #[cfg_attr(feature = "describe", schema(minimum = 0.1, maximum = 200))]
        speed_m_s: Option<f64>,
        /// Whether to enter GUIDED for it, which it does when absent; without it a vehicle in another mode refuses.
        #[cfg_attr(feature = "describe", serde(default = "given::yes"))]
        change_mode: bool,
        /// Whether an altitude more than 20 m below home is meant, or below the ground that the vehicle reports
        /// (TERRAIN_REPORT; for a position up to 500 m away); refused when absent. A plane that flies into a valley.
        #[cfg_attr(feature = "describe", serde(default))]
        below_home: bool,
    },
    /// Changes the speed: MAV_CMD_DO_CHANGE_SPEED.
    #[cfg_attr(feature = "describe", serde(rename = "speed"))]
    ChangeSpeed {
        /// Which speed.
        kind: SpeedKind,
        /// How fast, 0.1 to 200.
        #[cfg_attr(feature = "describe", schema(minimum = 0.1, maximum = 200))]
        speed_m_s: f64,
    },
    /// Changes the altitude of the present target: MAV_CMD_DO_CHANGE_ALTITUDE. For an ArduPlane; in AUTO it holds until
    /// the next item. One from before COMMAND_INT gets MISSION_ITEM with `current` = 3. Refused while the plane lands,
    /// or may do so in a mission that was not read: it would flare and stop its motor where it is.
    #[cfg_attr(feature = "describe", serde(rename = "altitude"))]
    ChangeAltitude {
        /// Height, counted as `alt_frame` says; not 0, which ArduPlane takes for none.
        #[cfg_attr(feature = "describe", schema(minimum = -1_000, maximum = 100_000))]
        alt_m: f64,
        /// What `alt_m` is counted from.
        alt_frame: AltFrame,
        /// As for `goto`.
        #[cfg_attr(feature = "describe", serde(default))]
        below_home: bool,
    },
    /// Turns to a course over ground and stays on it: MAV_CMD_GUIDED_CHANGE_HEADING. Only for an ArduPlane in GUIDED,
    /// which no request enters for it.
    #[cfg_attr(feature = "describe", serde(rename = "course"))]
    GuidedCourse {
        /// Course over ground, degrees from true north, 0 to below 360.
        #[cfg_attr(feature = "describe", schema(minimum = 0, exclusive_maximum = 360))]
        course_deg: f64,
        /// Centripetal acceleration of the turn at most, 0.05 to 20; 5, a bank of 27 degrees, when absent.
        #[cfg_attr(feature = "describe", serde(default = "given::accel_m_s2"), schema(minimum = 0.05, maximum = 20))]
        accel_m_s2: f64,
    },
    /// Climbs or sinks to a height: MAV_CMD_GUIDED_CHANGE_ALTITUDE. Only for an ArduPlane in GUIDED.
    #[cfg_attr(feature = "describe", serde(rename = "climb"))]
    GuidedClimb {
        /// Height, counted as `alt_frame` says; ArduPlane takes neither 0 nor −1.
        #[cfg_attr(feature = "describe", schema(minimum = -1_000, maximum = 100_000))]
        alt_m: f64,
        /// What `alt_m` is counted from.
        alt_frame: AltFrame,
        /// How fast, up or down, 0.01 to 50; as fast as it can when absent. Since 4.7 an ArduPlane hardly climbs at a
        /// rate: its target is its present height and the climb of a tenth of a second
        /// (`ModeGuided::update_target_altitude`).
        #[cfg_attr(feature = "describe", schema(minimum = 0.01, maximum = 50))]
        rate_m_s: Option<f64>,
        /// As for `goto`.
        #[cfg_attr(feature = "describe", serde(default))]
        below_home: bool,
    },
    /// Flies at a velocity: SET_POSITION_TARGET_LOCAL_NED, relative to the heading. Only for an ArduCopter in GUIDED or
    /// a PX4 in OFFBOARD, which no request enters for it. It has no answer: done when it is sent. The vehicle stops by
    /// itself when it is not repeated (ArduCopter after GUID_TIMEOUT, 3 s; PX4 after 0.5 s).
    Velocity {
        /// Forward, −50 to 50.
        #[cfg_attr(feature = "describe", serde(default), schema(minimum = -50, maximum = 50))]
        forward_m_s: f64,
        /// To the right, −50 to 50.
        #[cfg_attr(feature = "describe", serde(default), schema(minimum = -50, maximum = 50))]
        right_m_s: f64,
        /// Down, −50 to 50.
        #[cfg_attr(feature = "describe", serde(default), schema(minimum = -50, maximum = 50))]
        down_m_s: f64,
        /// Clockwise seen from above, −10 to 10.
        #[cfg_attr(feature = "describe", serde(default), schema(minimum = -10, maximum = 10))]
        yaw_rate_rad_s: f64,
    },
    /// Circles (or hovers) here: mode LOITER.
    #[cfg_attr(feature = "describe", serde(rename = "loiter"))]
    LoiterHere,
    /// Returns to launch: mode RTL.
    ReturnToLaunch,
    /// Lands. A fixed wing, and any ArduPlane: jumps to the landing sequence of its mission (MAV_CMD_DO_LAND_START), an
    /// ArduPlane in AUTO to the beginning of a landing that is known to have no such mark; nothing is sent to one that
    /// flies its landing already, because it would begin it anew and turn away without climbing. Refused while it is
    /// disarmed, and for a PX4 on the ground. Others: mode LAND.
    Land,
    /// Aborts a landing and climbs: MAV_CMD_DO_GO_AROUND.
    AbortLanding {
        /// Height to climb to, metres above home, 1 to 10,000; the vehicle's own when absent, as it has to be for a PX4.
        #[cfg_attr(feature = "describe", schema(minimum = 1, maximum = 10_000))]
        alt_rel_home_m: Option<f64>,
    },
    /// Prepares a flight, on the ground and disarmed: changes to a mode that arms where the present one does not, and
    /// sets the mission, when there is one, back to its beginning, its jump counters too. A text of ours says so
    /// before. Refused when armed or in the air. It neither arms nor starts; what is known of the vehicle
    /// (`progress.preparation`) tells before what it does.
    PrepareFlight,
    /// Starts the mission: mode AUTO, after setting the current item when one is given. Never arms. Item 1 is the
    /// mission's beginning: its jump counters are set back too. An ArduPlane has to show a mission that runs, and is
    /// set to the item once more where it began anew (`MIS_RESTART` 1).
    #[cfg_attr(feature = "describe", serde(rename = "mission/start"))]
    MissionStart {
        /// Item to begin with, counted from 1; where the vehicle stands in the mission when absent, with `MIS_RESTART`
        /// 1 its beginning.
        #[cfg_attr(feature = "describe", schema(minimum = 1, maximum = 65_534))]
        from_item: Option<u16>,
    },
    /// Interrupts the mission: mode LOITER.
    #[cfg_attr(feature = "describe", serde(rename = "mission/pause"))]
    MissionPause,
    /// Goes on with the mission where it stands: mode AUTO. An ArduPlane that begins it anew (`MIS_RESTART` 1) is set
    /// to where it stood, and a PX4 that left it to return to the item that it left.
    #[cfg_attr(feature = "describe", serde(rename = "mission/resume"))]
    MissionResume,
    /// Makes an item the current one: MAV_CMD_DO_SET_MISSION_CURRENT, or MISSION_SET_CURRENT for an older vehicle.
    /// Refused while an ArduPlane flies to its landing point: it would turn away without climbing first.
    #[cfg_attr(feature = "describe", serde(rename = "mission/current"))]
    SetCurrentItem {
        /// The item, counted from 1.
        #[cfg_attr(feature = "describe", schema(minimum = 1, maximum = 65_534))]
        item: u16,
    },
    /// Moves home to a position, at most 200 km from the old one or the vehicle, or to where the vehicle is when none of
    /// its values is given: MAV_CMD_DO_SET_HOME. In flight it has to be confirmed.
    #[cfg_attr(feature = "describe", serde(rename = "home"))]
    SetHome {
        /// WGS-84 latitude.
        #[cfg_attr(feature = "describe", schema(minimum = -90, maximum = 90))]
        lat_deg: Option<f64>,
        /// WGS-84 longitude.
        #[cfg_attr(feature = "describe", schema(minimum = -180, maximum = 180))]
        lon_deg: Option<f64>,
        /// Height above mean sea level.
        #[cfg_attr(feature = "describe", schema(minimum = -1_000, maximum = 100_000))]
        alt_amsl_m: Option<f64>,
    },
    /// Any command by COMMAND_LONG. Its `target` is replaced by the vehicle when it is 0/0. Not repeated when it gets
    /// no answer, unless it is known to be safe to do twice ([`crate::command::is_idempotent`]).
    #[cfg_attr(feature = "describe", serde(skip))]
    RawCommandLong(CommandLong),
    /// Any command by COMMAND_INT, likewise.
    #[cfg_attr(feature = "describe", serde(skip))]
    RawCommandInt(CommandInt),
    /// Asks for one message once, and brings it: MAV_CMD_REQUEST_MESSAGE. Done when the message arrives.
    RequestMessage {
        /// Which: its name in the dialect, such as `"HOME_POSITION"`, or its number.
        #[cfg_attr(feature = "describe", schema(value_type = MessageChoice))]
        message: MessageId,
    },
    /// Sets how often the vehicle sends a message, now and after each of its restarts: MAV_CMD_SET_MESSAGE_INTERVAL. It
    /// overrides other stations.
    SetMessageRate {
        /// Which: its name in the dialect, such as `"ATTITUDE"`, or its number.
        #[cfg_attr(feature = "describe", schema(value_type = MessageChoice))]
        message: MessageId,
        /// Messages per second, 0.0005 (one in 2,000 s) to 50; `"default"`, or 0, for the vehicle's own rate; `"stop"`
        /// for none.
        #[cfg_attr(feature = "describe", schema(value_type = RateChoice))]
        rate_hz: MessageRate,
    },
    /// Replaces a plan and reads it back: done when the vehicle has it. For an ArduPilot mission `items` does not hold
    /// home; it is put in front as item 0.
    #[cfg_attr(feature = "describe", serde(skip))]
    UploadPlan {
        /// What to replace.
        kind: PlanKind,
        /// The new list. Empty: clears it.
        items: Vec<MissionItem>,
        /// Home to send with a mission; `None`: the vehicle's own.
        home: Option<Home>,
        /// Whether it is sent in spite of errors found by the checks. The caller has checked it; a station on
        /// board, which knows more of its vehicle, checks remote uploads again.
        despite_findings: bool,
    },
    /// Reads a plan.
    #[cfg_attr(feature = "describe", serde(skip))]
    DownloadPlan {
        /// What to read.
        kind: PlanKind,
    },
    /// Removes a plan and checks that it is gone.
    #[cfg_attr(feature = "describe", serde(skip))]
    ClearPlan {
        /// What to remove.
        kind: PlanKind,
    },
    /// Reads all parameters.
    #[cfg_attr(feature = "describe", serde(skip))]
    ParamList,
    /// Reads one parameter.
    #[cfg_attr(feature = "describe", serde(skip))]
    ParamRead {
        /// Name, up to 16 characters.
        name: String,
    },
    /// Writes one parameter. Done when the vehicle says that it has the value.
    #[cfg_attr(feature = "describe", serde(skip))]
    ParamSet {
        /// Name, up to 16 characters.
        name: String,
        /// Value; must be finite.
        value: f64,
    },
    /// Adds a text of ours to those of the vehicle, shown to all clients of this station. Nothing is sent.
    #[cfg_attr(feature = "describe", serde(rename = "texts"))]
    Note {
        /// `MAV_SEVERITY`: 0 emergency to 7 debug; 6, info, when absent.
        #[cfg_attr(feature = "describe", serde(default = "given::info"), schema(value_type = u8, maximum = 7))]
        severity: Severity,
        /// The text; cut to 500 characters.
        text: String,
    },
    /// Switches the fence on board on or off, until its parameters or a restart do: MAV_CMD_DO_FENCE_ENABLE. Done when
    /// it is acknowledged; an ArduPlane without a fence refuses to switch it on. A PX4 has parameter GF_ACTION instead.
    SwitchFence {
        /// Whether it is to be on.
        on: bool,
    },
    /// Reboots the autopilot. Only when a fresh HEARTBEAT shows it disarmed.
    Reboot,
    /// Does what is asked although the mission on board may be a mixture ([`PlanState::may_be_mixed`]), in which case
    /// arming, following the mission and jumping in it are refused otherwise, or although it leads out of reach, or
    /// perhaps out of reach, in which case following it is. It is written among the vehicle's texts and in the log.
    #[cfg_attr(feature = "describe", serde(skip))]
    DespiteMixedPlan(Box<Request>),
}

impl Request {
    /// Whether it changes something on the vehicle. What only reads, or sends nothing, does not.
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
        /// After an upload to a vehicle that holds positions as 32-bit floats: how far the farthest is from where it
        /// was sent to be, metres. `None`: exact.
        position_error_m: Option<f64>,
    },
    /// All parameters, by name.
    Parameters(Vec<Param>),
    /// One parameter as the vehicle has it.
    Parameter(Param),
}

/// Outputs of a vehicle's state machines for their owner. Drain with [`crate::Vehicle::poll_output`].
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
        /// Amount done, in units of `total`.
        done: u32,
        /// Total amount; 0 when not known yet.
        total: u32,
    },
    /// A request ended. Comes exactly once for each.
    Finished {
        /// Which.
        id: RequestId,
        /// How.
        result: Result<Reply, VehicleError>,
    },
    /// An event.
    Event(VehicleEvent),
    /// Store this so that it survives the end of the program, then call [`crate::Vehicle::on_kept`]. An empty record is
    /// to be removed. Only with [`crate::VehicleConfig::keeps_records`].
    Keep {
        /// Grows with each.
        ticket: u64,
        /// What, and whose.
        stored: StoredRecord,
    },
}

/// An event, apart from new telemetry.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum VehicleEvent {
    /// The vehicle was lost (nothing heard for 5 s).
    Lost,
    /// The vehicle is heard again.
    Regained,
    /// The vehicle is heard, but has not answered repeated questions for 4.5 s: the uplink is dead.
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
    /// A mission item was reached. ArduPilot reports the last alone of those that it reaches in one moment: the
    /// waypoint before an action is taken for reached with that, where the mission is known.
    ItemReached {
        /// Which.
        seq: MissionSeq,
    },
    /// The mission was flown to its end.
    MissionComplete,
    /// The state of a plan on board changed.
    PlanStateChanged {
        /// Which.
        kind: PlanKind,
        /// Now.
        state: PlanState,
    },
    /// An alarm: in AUTO its target is not the current item of the plan read from it.
    TargetElsewhere {
        /// The current item.
        seq: MissionSeq,
        /// From the item's position to where it flies, metres.
        distance_m: f64,
    },
    /// Its target is that of its plan again.
    TargetAsPlanned {
        /// The current item.
        seq: MissionSeq,
    },
    /// A known parameter has another value than before. Values read in a list are not reported.
    ParamChanged(Param),
    /// The vehicle moved its home.
    HomeChanged,
    /// The vehicle does not know SET_MESSAGE_INTERVAL; its data streams were asked for instead.
    StreamsFellBack,
    /// Another vehicle uses the same system id, or another remote computer the same name: it is not followed, and nothing
    /// is sent to it.
    Contested,
    /// The other is not heard any more.
    Uncontested,
    /// It asks for terrain that no map here has.
    TerrainUnknown,
    /// All terrain that it asked for is known again.
    TerrainKnown,
}
