//! One vehicle: its telemetry, the state of its plans, and every request to it, as one state machine.
//!
//! | file | owns |
//! |---|---|
//! | `listen` | received messages: telemetry, events, restarts, other stations |
//! | `steps` | the steps of a request; the checks of its values |
//! | `sent` | the commands of a request, determined without a vehicle |
//! | `raw` | checks of the numbers in raw commands and messages |
//! | `operation` | a request in progress, and the state of its present step |
//! | `ops` | running requests: commands, the effects that prove them, results |
//! | `transfers` | requests that move plans and parameters |
//! | `board` | knowledge of the plans on board beyond their states |
//! | `identity` | which aircraft it is, and whose record its mission is kept in |
//! | `onboard` | the doubt whether a mission is mixed, reading back |
//! | `others` | changes of plans by other stations, also during our own transfers |
//! | `guard` | messages refused while the mission may be mixed or leads out of reach |
//! | `judged` | a PX4's own checks: of arming, and of a mission that it has stored |
//! | `landing` | messages refused while an ArduPlane lands |
//! | `target` | whether the plane's target is that of its plan |
//! | `lane` | the running transfer |
//! | `hearing` | whether it hears us: which messages are answers, and what ends without any |
//! | `hosted` | reports of a station on board about a remote vehicle |
//! | `tell` | messages without COMMAND_ACK in place of commands, for old firmware |
//! | `age` | limits of old firmware |

mod age;
mod board;
mod guard;
mod hearing;
mod hosted;
mod identity;
mod judged;
mod landing;
mod lane;
mod listen;
mod onboard;
mod operation;
mod ops;
mod others;
mod raw;
mod sent;
mod steps;
mod target;
mod tell;
#[cfg(test)]
mod tests;
mod transfers;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::checks::CheckContext;
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::plan::{Home, Mission, PlanKind};
use vencejo_flight::progress::ProgressOptions;
use vencejo_flight::rehearsal::Learner;
use vencejo_proto::param::{ParamName, ShownEncodings};
use vencejo_proto::{Address, MavVersion, MonoTime};

use crate::autopilot::AutopilotType;
use crate::command::{CommandConfig, Commands};
use crate::conduct::Conduct;
use crate::events::Events;
use crate::kind::VehicleKind;
use crate::modes::{FlightMode, ModeFamily};
use crate::plan_state::{PlanState, PlanStates};
use crate::preparation::FlightPreparation;
use crate::progress::{MissionProgress, ProgressTracker};
use crate::reach::Reach;
use crate::request::{Output, VehicleEvent};
use crate::streams::{StreamConfig, Streams};
use crate::telemetry::{BootClock, LOST_AFTER, LandedState, StatusLog, Telemetry};
use crate::timesync::TimeSync;
use crate::transfer::FtpSessions;
use board::OnBoard;
pub(crate) use hearing::is_answer;
use lane::{Lane, Written};
use operation::{Op, State};
pub(crate) use sent::commands_of;
#[cfg(all(test, feature = "describe"))]
pub(crate) use sent::refusal_of;
use steps::Context;

/// Settings of a vehicle.
#[derive(Debug, Clone)]
pub struct VehicleConfig {
    /// Waiting for and repeating commands.
    pub commands: CommandConfig,
    /// Which messages to request.
    pub streams: StreamConfig,
    /// Items sent ahead of the vehicle's requests in an item-by-item upload to ArduPilot, 1 to 64. Default 1.
    pub item_window: u16,
    /// Where MAVFTP session numbers begin; a different one each time the program starts. Default 0.
    pub seed: u32,
    /// Whether unknown plans, and the [`FlightParameters`] of an ArduPlane, are read without a request. Default no.
    pub reads_back: bool,
    /// Whether it is remote: the states of its plans are those that its station on board reports
    /// ([`Vehicle::on_plan_told`]), whatever its own messages imply. Default no.
    pub is_hosted: bool,
    /// Whether nothing is sent to it, not even TIMESYNC or the answer to one, before the first request: whether it
    /// hears us and the round trip stay unknown until then. Default no.
    pub only_listens: bool,
    /// Whether the owner stores the records of [`Output::Keep`], and answers with [`Vehicle::on_kept`]. Default no.
    pub keeps_records: bool,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self {
            commands: CommandConfig::default(),
            streams: StreamConfig::default(),
            item_window: 1,
            seed: 0,
            reads_back: false,
            is_hosted: false,
            only_listens: false,
            keeps_records: false,
        }
    }
}

/// What was told by events.
#[derive(Debug, Default)]
struct Told {
    mode: Option<FlightMode>,
    is_armed: Option<bool>,
    landed: Option<LandedState>,
    home: Option<Home>,
    /// The item that a PX4 reached last.
    reached: Option<Reached>,
}

/// An item that a PX4 told as reached.
#[derive(Debug, Clone, Copy)]
struct Reached {
    /// Which one.
    seq: u16,
    /// When it was first told.
    at: MonoTime,
    /// Whether it has become the current item again since.
    is_current_again: bool,
}

/// Where a PX4 left its mission to return: RTL_TYPE 1, the default of a fixed wing, makes the mission's landing the current
/// item, and the mission would go on there.
#[derive(Debug, Default)]
struct Interrupted {
    /// The last current item that was not of the landing.
    before_landing: Option<u16>,
    /// Since when an item of the landing has been the current one.
    landing_since: Option<MonoTime>,
    /// The item that was current when the return changed it to the landing.
    left_at: Option<u16>,
}

/// Parameters of an ArduPlane's flight. `None`: not read. They are read without a request where plans are
/// ([`VehicleConfig::reads_back`]), and updated by requests that read or set parameters and by what the vehicle tells of
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct FlightParameters {
    /// Default radius of circles, metres; negative for anticlockwise (`WP_LOITER_RAD`).
    pub loiter_radius_m: Option<f64>,
    /// Cruise airspeed, m/s (`AIRSPEED_CRUISE`, before 4.5 `TRIM_ARSPD_CM`).
    pub airspeed_m_s: Option<f64>,
    /// Whether a return uses the mission's landing (`RTL_AUTOLAND` is not 0); if not, an ArduPlane does not arm with a
    /// `DO_LAND_START` in its mission.
    pub finds_landing: Option<bool>,
}

/// State of the check of the plane's target; see `target`.
#[derive(Debug, Default)]
struct TargetWatch {
    /// When POSITION_TARGET_GLOBAL_INT came last.
    told_at: Option<MonoTime>,
    /// The item that the reports below are about.
    seq: Option<u16>,
    /// Since when, and in how many reports, the target has differed.
    elsewhere: Option<(MonoTime, u32)>,
    /// The item whose alarm was given, and how far from it the target is.
    alarmed: Option<(u16, f64)>,
}

/// One vehicle: a state machine that takes messages and times in and puts [`Output`]s out. See the [crate].
#[derive(Debug)]
pub struct Vehicle {
    address: Address,
    our: Address,
    config: VehicleConfig,
    /// Its protocol version.
    protocol: MavVersion,
    telemetry: Telemetry,
    texts: StatusLog,
    events: Events,
    boot: BootClock,
    timesync: TimeSync,
    reach: Reach,
    commands: Commands,
    streams: Streams,
    tracker: ProgressTracker,
    plans: PlanStates,
    on_board: OnBoard,
    target: TargetWatch,
    /// The plans on board by kind, while they are known and not empty.
    copies: [Option<Arc<Mission>>; 3],
    /// The vehicle's ids of its plans by kind, from the last MISSION_CURRENT; `None` before the first.
    mission_ids: Option<[Option<u32>; 3]>,
    flight_parameters: FlightParameters,
    /// Its recent flight, for learning its performance.
    learner: Learner,
    /// Every parameter that was read or set, by name, as the vehicle told it last.
    parameters: Arc<BTreeMap<ParamName, f64>>,
    /// The encodings of received parameter values, requested by any station.
    shown_encodings: ShownEncodings,
    /// Its limits by its other parameters, as far as they were received.
    limits: CheckContext,
    ops: Vec<Op>,
    /// Plans and the list of parameters: one at a time.
    transfer: Option<Lane>,
    /// Our last writing of each kind of plan.
    written: [Option<Written>; 3],
    /// Single parameters: one at a time, the others wait.
    param: Option<Lane>,
    ftp_sessions: FtpSessions,
    told: Told,
    interrupted: Interrupted,
    has_asked: bool,
    /// Whether its owner has made a request.
    has_requested: bool,
    heard_at: MonoTime,
    /// When its last heartbeat came; before the first, when anything was received.
    heartbeat_at: MonoTime,
    is_lost: bool,
    restarted_at: Option<MonoTime>,
    next_request: u64,
    /// Drained by the owner after each call. The outputs of one call are bounded by the machines' own bounds (requests,
    /// attempts, windows).
    outputs: VecDeque<Output>,
}
impl Vehicle {
    /// A vehicle at `address` (its autopilot) as seen by us at `our`.
    pub fn new(address: Address, our: Address, config: VehicleConfig, now: MonoTime) -> Self {
        Self {
            telemetry: Telemetry::new(),
            texts: StatusLog::default(),
            events: Events::new(address),
            boot: BootClock::default(),
            timesync: TimeSync::new(our, address, now),
            reach: Reach::default(),
            commands: Commands::new(our, config.commands),
            streams: Streams::new(address, config.streams.clone()),
            tracker: ProgressTracker::default(),
            plans: PlanStates::new(),
            on_board: OnBoard::new(now),
            target: TargetWatch::default(),
            copies: Default::default(),
            mission_ids: None,
            flight_parameters: FlightParameters::default(),
            learner: Learner::default(),
            parameters: Arc::default(),
            shown_encodings: ShownEncodings::default(),
            limits: CheckContext::default(),
            ops: Vec::new(),
            transfer: None,
            written: [None; 3],
            param: None,
            ftp_sessions: FtpSessions::new(config.seed),
            told: Told::default(),
            interrupted: Interrupted::default(),
            has_asked: false,
            has_requested: false,
            heard_at: now,
            heartbeat_at: now,
            is_lost: false,
            restarted_at: None,
            next_request: 0,
            outputs: VecDeque::new(),
            address,
            our,
            config,
            protocol: MavVersion::V2,
        }
    }

    /// Its autopilot.
    pub fn address(&self) -> Address {
        self.address
    }

    /// The protocol version of its last frame; MAVLink 2 until [`Self::on_protocol_version`] is told otherwise.
    pub fn protocol_version(&self) -> MavVersion {
        self.protocol
    }

    /// Notes the protocol version of the autopilot's frames. MAVLink 1 has no plan kinds, and an ArduPilot that uses it
    /// without sending AUTOPILOT_VERSION has old firmware.
    pub fn on_protocol_version(&mut self, version: MavVersion) {
        self.protocol = version;
    }

    /// Its telemetry.
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// Its STATUSTEXT messages.
    pub fn texts(&self) -> &StatusLog {
        &self.texts
    }

    /// The state of a plan on board.
    pub fn plan_state(&self, kind: PlanKind) -> PlanState {
        self.plans.get(kind)
    }

    /// The items of a plan on board as they were read, also of the fence and rally points; `None` while they are
    /// unknown, and when there are none. Sends nothing.
    pub fn plan_on_board(&self, kind: PlanKind) -> Option<&Arc<Mission>> {
        self.copies[kind as usize].as_ref()
    }

    /// The mission on board, while it is known.
    pub fn mission(&self) -> Option<&Arc<Mission>> {
        self.plan_on_board(PlanKind::Mission)
    }

    /// Its progress in the mission.
    pub fn progress(&self) -> MissionProgress {
        let options = self.progress_options();
        let progress =
            self.tracker.progress(&self.telemetry, self.mission().map(Arc::as_ref), self.first_seq(), &options);
        MissionProgress { target_off_m: self.target_off_m(), ..progress }
    }

    /// Its present conduct.
    pub fn conduct(&self) -> Conduct {
        let current = self.telemetry.mission.and_then(|mission| mission.value.seq.checked_sub(self.first_seq()));
        Conduct::of(&self.telemetry, self.mission().map(Arc::as_ref), current.map(usize::from))
    }

    /// The terms of its progress: its airspeed, and the options.
    pub fn progress_terms(&self) -> (f64, ProgressOptions) {
        (self.check_context().airspeed_m_s, self.progress_options())
    }

    fn progress_options(&self) -> ProgressOptions {
        let default = ProgressOptions::default();
        let loiter_radius_m = self.flight_parameters.loiter_radius_m.unwrap_or(default.loiter_radius_m);
        let own_speed_m_s = self.flight_parameters.airspeed_m_s;
        let CheckContext { airspeed_min_m_s, airspeed_max_m_s, .. } = self.limits;
        let flies_arcs = self.flies_arcs();
        ProgressOptions { loiter_radius_m, flies_arcs, own_speed_m_s, airspeed_min_m_s, airspeed_max_m_s, ..default }
    }

    /// Its flight parameters, as far as they were read.
    pub fn flight_parameters(&self) -> FlightParameters {
        self.flight_parameters
    }

    /// The last ten minutes of its flight, for learning its performance. Learning takes milliseconds: copy it first if
    /// the vehicle is locked.
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// Its parameters by name, as far as they were read or set since it was first heard.
    pub fn parameters(&self) -> Arc<BTreeMap<ParamName, f64>> {
        Arc::clone(&self.parameters)
    }

    /// When its autopilot was last heard.
    pub fn heard_at(&self) -> MonoTime {
        self.heard_at
    }

    /// Whether it is heard: anything within 5 s.
    pub fn is_heard(&self, now: MonoTime) -> bool {
        now.since(self.heard_at) <= LOST_AFTER
    }

    /// Whether it hears us. `false`: it is heard, but has not answered for [`crate::UNREACHED_AFTER`]. `None`: unknown,
    /// because it is not heard, or was asked nothing that it answers.
    pub fn is_reached(&self, now: MonoTime) -> Option<bool> {
        self.reach.is_reached(now).filter(|_| self.is_heard(now))
    }

    /// Round trip by TIMESYNC, smoothed; `None` before the first answer.
    pub fn round_trip(&self) -> Option<Duration> {
        self.timesync.round_trip()
    }

    /// Requests that are not finished.
    pub fn pending(&self) -> usize {
        self.ops.iter().filter(|op| !self.on_board.is_own(op.id)).count()
    }

    /// The next thing that the owner must do. Drain it after every call.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When to call [`Self::on_time`] next.
    pub fn deadline(&self) -> Option<MonoTime> {
        let ops = self.ops.iter().filter_map(|op| match &op.state {
            State::Refused { until, .. } | State::Awaiting { until, .. } | State::Judging { until, .. } => Some(*until),
            State::Telling(telling) => Some(telling.deadline()),
            _ => None,
        });
        let lanes = [&self.transfer, &self.param].into_iter().flatten().filter_map(|lane| lane.machine.deadline());
        let lost = (!self.is_lost).then(|| self.lost_at());
        let machines =
            [self.commands.deadline(), self.streams.deadline(), self.texts.deadline(), self.events.deadline()];
        let asked = self.speaks().then(|| [Some(self.timesync.deadline()), self.reach_deadline()]);
        [lost, self.on_board_deadline()]
            .into_iter()
            .chain(asked.into_iter().flatten())
            .chain(machines)
            .flatten()
            .chain(ops)
            .chain(lanes)
            .min()
    }

    /// Whether we send to it without a request: if not, no answer is awaited.
    fn speaks(&self) -> bool {
        !self.config.is_hosted && (!self.config.only_listens || self.has_requested)
    }

    fn lost_at(&self) -> MonoTime {
        // A value that is exactly this old is not lost yet.
        self.heard_at + LOST_AFTER + Duration::from_micros(1)
    }

    fn is_arduplane(&self) -> bool {
        self.family() == Some(ModeFamily::ArduPlane)
    }

    fn family(&self) -> Option<ModeFamily> {
        self.telemetry.autopilot_type().map(AutopilotType::family)
    }

    fn is_ardupilot(&self) -> bool {
        self.telemetry.is_ardupilot()
    }

    /// Context for plan checks; unknown values default to ArduPlane's.
    pub fn check_context(&self) -> CheckContext {
        let position = self.telemetry.position.map(|position| position.value);
        let mav_type = self.telemetry.autopilot_type().map(|known| known.mav_type);
        // A quadplane may report itself as a fixed wing, but then reports a VTOL state.
        let tells_vtol = self.telemetry.extended.is_some_and(|extended| extended.value.vtol.is_some());
        CheckContext {
            home: self.telemetry.home.map(|home| home.value),
            position: position.and_then(|at| GeoPoint::new(at.lat_deg?, at.lon_deg?).ok()),
            on_ground: self.telemetry.is_on_ground(),
            can_hover: self.limits.can_hover
                || tells_vtol
                || mav_type.and_then(VehicleKind::of).is_some_and(VehicleKind::can_hover),
            flies_arcs: self.flies_arcs(),
            ..self.limits
        }
    }

    fn flies_arcs(&self) -> bool {
        self.family().is_some_and(ModeFamily::flies_arcs)
    }

    /// Seq of a mission's first item: on ArduPilot item 0 is home.
    pub(crate) fn first_seq(&self) -> u16 {
        u16::from(self.is_ardupilot())
    }

    /// Seq of the last navigation item; only actions follow it.
    fn last_nav(&self) -> Option<u16> {
        let Some(mission) = self.mission() else {
            // Without items there is no last one.
            let total = self.telemetry.mission?.value.total.filter(|total| *total > 0)?;
            return (total + self.first_seq()).checked_sub(1);
        };
        let index = mission.items.iter().rposition(|item| item.command.is_nav())?;
        u16::try_from(index).ok()?.checked_add(self.first_seq())
    }

    /// What a flight needs first in the vehicle's present state; `None` before its first heartbeat. Whether it is
    /// possible now is checked by [`crate::Request::PrepareFlight`].
    pub fn flight_preparation(&self) -> Option<FlightPreparation> {
        let plan = self.plan_state(PlanKind::Mission);
        FlightPreparation::of(self.telemetry(), plan, self.first_nav())
    }

    /// Seq of the first navigation item, after any leading actions.
    pub(crate) fn first_nav(&self) -> u16 {
        let index = self.mission().and_then(|mission| mission.items.iter().position(|item| item.command.is_nav()));
        u16::try_from(index.unwrap_or_default()).unwrap_or(u16::MAX).saturating_add(self.first_seq())
    }

    fn context(&self, now: MonoTime) -> Context<'_> {
        Context {
            vehicle: self.address,
            telemetry: &self.telemetry,
            heartbeat_at: self.heartbeat_at,
            preparation: self.flight_preparation(),
            first_nav: self.first_nav(),
            is_landing: self.is_landing_already(now),
            unmarked_landing: self.unmarked_landing(),
            has_landing: self.mission().map(|mission| mission.items.iter().any(|item| item.command.is_landing())),
            lands: self.conduct().is_landing,
            is_complete: self.tracker.is_complete(),
            left_at: self.interrupted.left_at,
            has_command_int: self.has_command_int(),
            now,
        }
    }

    fn event(&mut self, event: VehicleEvent) {
        self.outputs.push_back(Output::Event(event));
    }

    fn set_plan(&mut self, kind: PlanKind, state: PlanState) {
        if self.config.is_hosted {
            return;
        }
        if !matches!(state, PlanState::Verified { .. } | PlanState::Differs { .. }) {
            self.copies[kind as usize] = None;
        }
        self.tell_plan(kind, state);
    }

    fn tell_plan(&mut self, kind: PlanKind, state: PlanState) {
        if self.plans.set(kind, state) {
            if kind == PlanKind::Mission {
                self.interrupted = Interrupted::default();
            }
            self.on_board.on_state(kind, state);
            self.event(VehicleEvent::PlanStateChanged { kind, state });
        }
    }

    /// Advances time; call it at [`Self::deadline`] or later.
    pub fn on_time(&mut self, now: MonoTime) {
        if !self.is_lost && now >= self.lost_at() {
            self.is_lost = true;
            self.reach.on_lost();
            self.event(VehicleEvent::Lost);
        }
        while let Some(text) = self.texts.release(now) {
            let text = text.clone();
            self.event(VehicleEvent::Text(text));
        }
        self.tell_checks(now);
        if self.speaks() {
            // A lost vehicle is asked too: its answer may be the first sign of life on a silent link.
            if let Some(request) = self.timesync.on_time(now) {
                self.reach.on_timesync_asked(now);
                self.outputs.push_back(Output::Send(request));
            }
            self.look_whether_reached(now);
        }
        if let Some(request) = self.streams.on_time(&mut self.commands, now) {
            self.outputs.push_back(Output::Send(request));
        }
        if self.streams.take_fell_back() {
            self.event(VehicleEvent::StreamsFellBack);
        }
        self.commands.on_time(now);
        for lane in [&mut self.transfer, &mut self.param].into_iter().flatten() {
            if lane.machine.deadline().is_some_and(|deadline| now >= deadline) {
                lane.machine.on_time(now);
            }
        }
        self.pump(now);
        self.end_unreached(now);
        self.end_waits(now);
        self.on_board_time(now);
        self.pump(now);
    }

    /// Processes the outputs of the machines until there are none.
    fn pump(&mut self, now: MonoTime) {
        loop {
            while let Some(output) = self.commands.poll_output() {
                self.on_command_output(output, now);
            }
            self.drain_lanes(now);
            let waits = |op: &&Op| matches!(op.state, State::WaitingForLane(_));
            if !self.param_lane_is_busy()
                && let Some(index) = self.ops.iter().position(|op| waits(&op))
                && let State::WaitingForLane(step) = std::mem::replace(&mut self.ops[index].state, State::Ready)
            {
                self.start_transfer(index, step, now);
                continue;
            }
            break;
        }
        self.stay_quiet(now);
    }
}
