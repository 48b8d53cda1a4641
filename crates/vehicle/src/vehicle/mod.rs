//! One vehicle: its telemetry, the state of its plans, and every request to it, as one state machine.

mod lane;
mod steps;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::plan::{Command, Home, Mission, PlanKind, items_from_wire};
use vencejo_flight::progress::ProgressOptions;
use vencejo_proto::dialect::{MavMessage, MavMissionType};
use vencejo_proto::param::ParamEncoding;
use vencejo_proto::{Address, ComponentId, Message, MissionAck, MissionItemInt, MissionSeq, MonoTime, StatusText};

use crate::command::{
    CommandConfig, CommandId, CommandMessage, CommandName, CommandOutcome, CommandOutput, CommandResult, Commands,
    Unanswered, WhenBusy,
};
use crate::error::VehicleError;
use crate::modes::FlightMode;
use crate::plan_state::{PlanState, PlanStates, Unknown, hash_items};
use crate::progress::{MissionProgress, ProgressTracker};
use crate::request::{ModeChoice, Output, Reply, Request, RequestId, VehicleEvent};
use crate::streams::{StreamConfig, Streams};
use crate::telemetry::{
    BootClock, BootEvent, Group, LOST_AFTER, LandedState, Severity, StatusLog, Telemetry, Text, boot_ms_of,
};
use crate::timesync::{TimeSync, TimeSyncEvent};
use crate::transfer::{
    FtpSessions, Param, ParamList, ParamRead, ParamSet, PlanClear, PlanDownload, PlanUpload, TransferConfig,
    TransferError, TransferOutput,
};
use lane::{Lane, Machine, Yield};
use steps::{Context, Effect, Fallback, Step};

/// Requests that may be under way or waiting at once. More are refused.
const MAX_REQUESTS: usize = 64;
/// How long an effect may take to show after the command was accepted: several heartbeats.
const EFFECT_WITHIN: Duration = Duration::from_secs(5);
/// How long a message that was asked for may take.
const MESSAGE_WITHIN: Duration = Duration::from_secs(2);
/// How long to wait for what the vehicle writes about a refusal; arming fails with a list.
const REASONS_AFTER: Duration = Duration::from_millis(400);
const ARM_REASONS_AFTER: Duration = Duration::from_millis(1_000);
/// ArduPilot repeats failing pre-arm checks every 30 s; those are taken when it is silent at the refusal.
const PREARM_REPEATED: Duration = Duration::from_secs(35);
/// Most reasons that an error carries.
const MAX_REASONS: usize = 16;
/// After one of our transfers ended, messages about it may still be on their way.
const TRANSFER_ECHO: Duration = Duration::from_secs(5);
/// Two restarts within this are one.
const RESTART_ONCE: Duration = Duration::from_secs(3);
/// Capability bit: integers are put into PARAM_VALUE byte by byte (`MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE`).
const PARAM_BYTEWISE: u64 = 16;

/// Settings of a vehicle.
#[derive(Debug, Clone)]
pub struct VehicleConfig {
    /// Waiting for and repeating commands.
    pub commands: CommandConfig,
    /// Which messages to ask for.
    pub streams: StreamConfig,
    /// Items sent ahead of the vehicle's requests in an item-by-item upload to ArduPilot, 1 to 64. Default 1.
    pub item_window: u16,
    /// Where MAVFTP session numbers begin; a different one each time the program starts. Default 0.
    pub seed: u32,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self { commands: CommandConfig::default(), streams: StreamConfig::default(), item_window: 1, seed: 0 }
    }
}

/// A request under way.
#[derive(Debug)]
struct Op {
    id: RequestId,
    steps: VecDeque<Step>,
    state: State,
    /// `result_param2` of the last command's acknowledgement, for the requests that return it.
    acknowledged: Option<i32>,
    wants_acknowledgement: bool,
}

#[derive(Debug)]
enum State {
    /// The next step is to begin.
    Ready,
    /// A command is under way.
    Commanding { command: Commanding, id: CommandId, asked: bool },
    /// It was refused; the vehicle may write why.
    Refused { command: Commanding, result: CommandResult, until: MonoTime },
    /// It was accepted; its effect has to show.
    Awaiting { command: Commanding, until: MonoTime },
    /// A transfer runs in a lane.
    Transferring,
    /// A parameter waits for the lane.
    WaitingForLane(Step),
}

/// A command and what proves it.
#[derive(Debug, Clone)]
struct Commanding {
    message: CommandMessage,
    effect: Effect,
    fallback: Option<Fallback>,
    first_sent: MonoTime,
    last_sent: MonoTime,
    mode_before: Option<FlightMode>,
}

impl Commanding {
    fn name(&self) -> CommandName {
        CommandName(self.message.command())
    }
}

/// How an effect looks from here.
#[derive(Debug, PartialEq)]
enum Seen {
    /// It is there.
    Shown,
    /// The vehicle has said since that it is not.
    NotShown,
    /// Somebody else did something else.
    Overtaken(String),
    /// Nothing has been said since.
    NotYet,
}

/// What was told by events.
#[derive(Debug, Default)]
struct Told {
    mode: Option<FlightMode>,
    is_armed: Option<bool>,
    landed: Option<LandedState>,
    home: Option<Home>,
}

/// One vehicle: a state machine that takes messages and moments in and puts [`Output`]s out. See the [crate](crate).
#[derive(Debug)]
pub struct Vehicle {
    address: Address,
    our: Address,
    config: VehicleConfig,
    telemetry: Telemetry,
    texts: StatusLog,
    boot: BootClock,
    timesync: TimeSync,
    commands: Commands,
    streams: Streams,
    tracker: ProgressTracker,
    plans: PlanStates,
    /// The mission on board, while it is known.
    mission: Option<Arc<Mission>>,
    mission_ids: [Option<u32>; 3],
    progress_options: ProgressOptions,
    ops: Vec<Op>,
    /// Plans and the list of parameters: one at a time.
    transfer: Option<Lane>,
    transfer_ended: Option<MonoTime>,
    /// Single parameters: one at a time, the others wait.
    param: Option<Lane>,
    ftp_sessions: FtpSessions,
    told: Told,
    has_asked: bool,
    heard_at: MonoTime,
    is_lost: bool,
    restarted_at: Option<MonoTime>,
    next_request: u64,
    /// Grows only between two calls; the owner drains it after each. What one call puts in is bounded by the machines'
    /// own bounds (requests, attempts, windows).
    outputs: VecDeque<Output>,
}

impl Vehicle {
    /// A vehicle at `address` (its autopilot) as seen by us at `our`.
    #[must_use]
    pub fn new(address: Address, our: Address, config: VehicleConfig, now: MonoTime) -> Self {
        Self {
            telemetry: Telemetry::new(),
            texts: StatusLog::default(),
            boot: BootClock::default(),
            timesync: TimeSync::new(our, address, now),
            commands: Commands::new(our, config.commands),
            streams: Streams::new(address, config.streams.clone()),
            tracker: ProgressTracker::default(),
            plans: PlanStates::new(),
            mission: None,
            mission_ids: [None; 3],
            progress_options: ProgressOptions::default(),
            ops: Vec::new(),
            transfer: None,
            transfer_ended: None,
            param: None,
            ftp_sessions: FtpSessions::new(config.seed),
            told: Told::default(),
            has_asked: false,
            heard_at: now,
            is_lost: false,
            restarted_at: None,
            next_request: 0,
            outputs: VecDeque::new(),
            address,
            our,
            config,
        }
    }

    /// Its autopilot.
    #[must_use]
    pub fn address(&self) -> Address {
        self.address
    }

    /// What it says about itself.
    #[must_use]
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// What it wrote.
    #[must_use]
    pub fn texts(&self) -> &StatusLog {
        &self.texts
    }

    /// What is known of a plan on board.
    #[must_use]
    pub fn plan_state(&self, kind: PlanKind) -> PlanState {
        self.plans.get(kind)
    }

    /// The mission on board, while it is known.
    #[must_use]
    pub fn mission(&self) -> Option<&Arc<Mission>> {
        self.mission.as_ref()
    }

    /// Where it stands in its mission.
    #[must_use]
    pub fn progress(&self) -> MissionProgress {
        self.tracker.progress(&self.telemetry, self.mission.as_deref(), self.first_seq(), &self.progress_options)
    }

    /// When anything of its autopilot was heard last.
    #[must_use]
    pub fn heard_at(&self) -> MonoTime {
        self.heard_at
    }

    /// Whether it is heard: anything within 5 s.
    #[must_use]
    pub fn is_heard(&self, now: MonoTime) -> bool {
        now.since(self.heard_at) <= LOST_AFTER
    }

    /// Round trip by TIMESYNC, smoothed; `None` before the first answer.
    #[must_use]
    pub fn round_trip(&self) -> Option<Duration> {
        self.timesync.round_trip()
    }

    /// What to add to our monotonic clock to have the vehicle's (TIMESYNC), ns; `None` before the first answer.
    #[must_use]
    pub fn clock_offset_ns(&self) -> Option<i64> {
        self.timesync.offset_ns()
    }

    /// Requests that are not finished.
    #[must_use]
    pub fn pending(&self) -> usize {
        self.ops.len()
    }

    /// The next thing that the owner must do. Drain it after every call.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When [`Self::on_time`] is wanted.
    #[must_use]
    pub fn deadline(&self) -> Option<MonoTime> {
        let ops = self.ops.iter().filter_map(|op| match &op.state {
            State::Refused { until, .. } | State::Awaiting { until, .. } => Some(*until),
            _ => None,
        });
        let lanes = [&self.transfer, &self.param].into_iter().flatten().filter_map(|lane| lane.machine.deadline());
        let lost = (!self.is_lost).then(|| self.lost_at());
        [self.commands.deadline(), self.streams.deadline(), self.texts.deadline(), Some(self.timesync.deadline()), lost]
            .into_iter()
            .flatten()
            .chain(ops)
            .chain(lanes)
            .min()
    }

    fn lost_at(&self) -> MonoTime {
        // A value that is exactly this old is not lost yet.
        self.heard_at + LOST_AFTER + Duration::from_micros(1)
    }

    fn is_ardupilot(&self) -> bool {
        self.telemetry.is_ardupilot()
    }

    /// Seq of a mission's first item: on ArduPilot item 0 is home.
    fn first_seq(&self) -> u16 {
        u16::from(self.is_ardupilot())
    }

    /// Seq of the last item to which the vehicle flies; what follows it are actions.
    fn last_destination(&self) -> Option<u16> {
        let Some(mission) = &self.mission else {
            let total = self.telemetry.mission?.value.total?;
            return (total + self.first_seq()).checked_sub(1);
        };
        let is_destination = |command: Command| command.0 < Command::NAV_GUIDED_ENABLE.0;
        let index = mission.items.iter().rposition(|item| is_destination(item.command))?;
        u16::try_from(index).ok()?.checked_add(self.first_seq())
    }

    fn context(&self, now: MonoTime) -> Context<'_> {
        Context { vehicle: self.address, telemetry: &self.telemetry, now }
    }

    fn event(&mut self, event: VehicleEvent) {
        self.outputs.push_back(Output::Event(event));
    }

    // ── messages in ──────────────────────────────────────────────────────────────────────────────────────────────

    /// A message from component `from` of the vehicle. Returns the telemetry group that it changed.
    pub fn on_message(&mut self, from: ComponentId, message: &Message, now: MonoTime) -> Option<Group> {
        if from != self.address.component {
            return self.on_other_component(from, message, now);
        }
        self.hear(now);
        if let Some(boot_ms) = boot_ms_of(message)
            && let Some(BootEvent::Rebooted { since }) = self.boot.observe(boot_ms, now)
        {
            self.timesync.forget_clock();
            self.on_restart(since, now);
        }
        let group = self.telemetry.apply(message, now);
        match group {
            Some(Group::Heartbeat) => self.on_heartbeat(now),
            Some(group) => {
                self.streams.on_telemetry();
                match group {
                    Group::Mission => self.on_mission_current(now),
                    Group::ItemReached => self.on_item_reached(),
                    Group::Extended => self.on_extended(),
                    Group::Home => self.on_home(),
                    _ => {}
                }
            }
            None => self.on_protocol(message, now),
        }
        if !self.ops.is_empty() {
            self.on_awaited(message, now);
            self.check_effects(now);
            self.pump(now);
        }
        group
    }

    fn hear(&mut self, now: MonoTime) {
        self.heard_at = now;
        if self.is_lost {
            self.is_lost = false;
            self.streams.on_regained(now);
            self.event(VehicleEvent::Regained);
        }
    }

    /// Gimbals, radios, batteries, on-board computers: they share the system's id, but only the autopilot is the vehicle.
    fn on_other_component(&mut self, from: ComponentId, message: &Message, now: MonoTime) -> Option<Group> {
        match message {
            Message::StatusText(text) => {
                self.on_text(from, text, now);
                None
            }
            Message::CommandAck(ack) => {
                let from = Address { system: self.address.system, component: from };
                self.commands.on_ack(from, ack, now);
                self.pump(now);
                None
            }
            Message::Dialect(MavMessage::RADIO_STATUS(_) | MavMessage::RADIO(_) | MavMessage::BATTERY_STATUS(_)) => {
                self.telemetry.apply(message, now)
            }
            _ => None,
        }
    }

    /// The state of the radio that this vehicle is reached by; radios speak under a system id of their own.
    pub fn on_radio(&mut self, message: &Message, now: MonoTime) -> Option<Group> {
        match message {
            Message::Dialect(MavMessage::RADIO_STATUS(_) | MavMessage::RADIO(_)) => self.telemetry.apply(message, now),
            _ => None,
        }
    }

    /// A message that another system sent to the vehicle and that passed by us: it may change a plan.
    pub fn on_foreign(&mut self, from: Address, message: &Message, now: MonoTime) {
        if from == self.our || from.system == self.address.system && from.component == self.address.component {
            return;
        }
        let kind = match message {
            Message::Dialect(MavMessage::MISSION_COUNT(count)) => count.mission_type,
            Message::Dialect(MavMessage::MISSION_CLEAR_ALL(clear)) => clear.mission_type,
            Message::Dialect(MavMessage::MISSION_WRITE_PARTIAL_LIST(part)) => part.mission_type,
            _ => return,
        };
        for plan in PlanKind::ALL {
            let is_meant = kind == MavMissionType::MAV_MISSION_TYPE_ALL || kind as u8 == plan.mission_type();
            if is_meant {
                self.changed_elsewhere(plan, now);
            }
        }
    }

    fn on_protocol(&mut self, message: &Message, now: MonoTime) {
        match message {
            Message::StatusText(text) => self.on_text(self.address.component, text, now),
            Message::CommandAck(ack) => {
                self.commands.on_ack(self.address, ack, now);
                self.pump(now);
                return;
            }
            Message::Dialect(MavMessage::TIMESYNC(timesync)) => {
                self.on_timesync(timesync, now);
                return;
            }
            Message::MissionAck(ack) => self.on_mission_ack(ack, now),
            _ => {}
        }
        for lane in [&mut self.transfer, &mut self.param].into_iter().flatten() {
            lane.machine.on_message(self.address, message, now);
        }
        self.pump(now);
    }

    fn on_timesync(&mut self, message: &vencejo_proto::dialect::TIMESYNC_DATA, now: MonoTime) {
        match self.timesync.on_message(message, now) {
            Some(TimeSyncEvent::Answer(answer)) => self.outputs.push_back(Output::Send(answer)),
            Some(TimeSyncEvent::Measured { has_gone_back, .. }) => {
                self.commands.set_round_trip(self.timesync.round_trip());
                if has_gone_back {
                    self.boot.reset();
                    self.on_restart(now, now);
                    self.pump(now);
                }
            }
            None => {}
        }
    }

    fn on_text(&mut self, from: ComponentId, text: &StatusText, now: MonoTime) {
        if let Some(text) = self.texts.push(from, text, now) {
            let text = text.clone();
            self.event(VehicleEvent::Text(text));
        }
    }

    fn on_heartbeat(&mut self, now: MonoTime) {
        let Some(heartbeat) = self.telemetry.heartbeat.map(|heartbeat| heartbeat.value) else { return };
        if self.told.mode != Some(heartbeat.mode) {
            let from = self.told.mode.replace(heartbeat.mode);
            self.event(VehicleEvent::ModeChanged { from, to: heartbeat.mode });
        }
        if self.told.is_armed != Some(heartbeat.is_armed) {
            self.told.is_armed = Some(heartbeat.is_armed);
            self.event(VehicleEvent::ArmedChanged { is_armed: heartbeat.is_armed });
            let last = self.last_destination();
            if self.tracker.on_armed(heartbeat.is_armed, last).has_completed {
                self.event(VehicleEvent::MissionComplete);
            }
        }
        if !self.has_asked {
            self.has_asked = true;
            self.streams.ask(&mut self.commands, now);
            self.pump(now);
        }
    }

    fn on_extended(&mut self) {
        let Some(landed) = self.telemetry.extended.map(|extended| extended.value.landed) else { return };
        if self.told.landed != Some(landed) {
            self.told.landed = Some(landed);
            self.event(VehicleEvent::LandedChanged { landed });
        }
    }

    fn on_home(&mut self) {
        let Some(home) = self.telemetry.home.map(|home| home.value) else { return };
        if self.told.home != Some(home) {
            self.told.home = Some(home);
            self.event(VehicleEvent::HomeChanged);
        }
    }

    fn on_mission_current(&mut self, now: MonoTime) {
        let Some(current) = self.telemetry.mission.map(|mission| mission.value) else { return };
        let changes = self.tracker.on_current(&current);
        if let Some(seq) = changes.current {
            self.event(VehicleEvent::CurrentItemChanged { seq });
        }
        if changes.has_completed {
            self.event(VehicleEvent::MissionComplete);
        }
        // PX4 names its plans; another name is another plan.
        let ids = [current.mission_id, current.fence_id, current.rally_points_id];
        for (kind, (before, id)) in PlanKind::ALL.into_iter().zip(self.mission_ids.into_iter().zip(ids)) {
            if before.is_some() && id.is_some() && before != id {
                self.changed_elsewhere(kind, now);
            }
        }
        self.mission_ids = ids;
        let known = match self.plans.get(PlanKind::Mission) {
            PlanState::Empty => Some(0),
            PlanState::Verified { count, .. } => Some(count),
            PlanState::Unknown(_) => None,
        };
        if let (Some(known), Some(total)) = (known, current.total)
            && known != total
        {
            self.changed_elsewhere(PlanKind::Mission, now);
        }
    }

    fn on_item_reached(&mut self) {
        let Some(seq) = self.telemetry.item_reached.map(|reached| reached.value) else { return };
        let last = self.last_destination();
        self.event(VehicleEvent::ItemReached { seq: MissionSeq(seq) });
        if self.tracker.on_reached(seq, last).has_completed {
            self.event(VehicleEvent::MissionComplete);
        }
    }

    /// The vehicle took a plan from somebody else (or from another station that uses our address).
    fn on_mission_ack(&mut self, ack: &MissionAck, now: MonoTime) {
        if ack.result == 0
            && let Ok(kind) = PlanKind::try_from(ack.mission_type)
        {
            self.changed_elsewhere(kind, now);
        }
    }

    /// What is known of a plan is void, unless it is our own transfer that is talked about.
    fn changed_elsewhere(&mut self, kind: PlanKind, now: MonoTime) {
        let is_echo =
            self.transfer.is_some() || self.transfer_ended.is_some_and(|ended| now.since(ended) < TRANSFER_ECHO);
        if !is_echo && !matches!(self.plans.get(kind), PlanState::Unknown(_)) {
            self.set_plan(kind, PlanState::Unknown(Unknown::ChangedElsewhere));
        }
    }

    fn set_plan(&mut self, kind: PlanKind, state: PlanState) {
        if kind == PlanKind::Mission && !matches!(state, PlanState::Verified { .. }) {
            self.mission = None;
        }
        if self.plans.set(kind, state) {
            self.event(VehicleEvent::PlanStateChanged { kind, state });
        }
    }

    fn on_restart(&mut self, since: MonoTime, now: MonoTime) {
        if self.restarted_at.is_some_and(|restarted| now.since(restarted) < RESTART_ONCE) {
            return;
        }
        self.restarted_at = Some(now);
        self.telemetry.forget_before(since);
        self.told = Told { mode: self.told.mode, is_armed: self.told.is_armed, ..Told::default() };
        self.tracker.reset();
        self.mission_ids = [None; 3];
        self.event(VehicleEvent::Rebooted);
        for mut lane in [self.transfer.take(), self.param.take()].into_iter().flatten() {
            lane.machine.cancel(now);
            while let Some(output) = lane.machine.poll_output() {
                if let TransferOutput::Send(message) = output {
                    self.outputs.push_back(Output::Send(message));
                }
            }
        }
        for op in std::mem::take(&mut self.ops) {
            let is_wanted = match op.state {
                State::Commanding { ref command, id, .. } => {
                    self.commands.forget(id, now);
                    command.effect == Effect::Restarted
                }
                State::Awaiting { ref command, .. } => command.effect == Effect::Restarted,
                _ => false,
            };
            let result = if is_wanted { Ok(Reply::Done) } else { Err(VehicleError::Rebooted) };
            self.outputs.push_back(Output::Finished { id: op.id, result });
        }
        for kind in PlanKind::ALL {
            self.set_plan(kind, PlanState::Unknown(Unknown::Rebooted));
        }
        self.streams.ask(&mut self.commands, now);
    }

    // ── time ─────────────────────────────────────────────────────────────────────────────────────────────────────

    /// Lets time pass; call it at [`Self::deadline`] or later.
    pub fn on_time(&mut self, now: MonoTime) {
        if !self.is_lost && now >= self.lost_at() {
            self.is_lost = true;
            self.event(VehicleEvent::Lost);
        }
        while let Some(text) = self.texts.release(now) {
            let text = text.clone();
            self.event(VehicleEvent::Text(text));
        }
        // A lost vehicle is asked too: its answer is the first sign of life on a silent link.
        if let Some(request) = self.timesync.on_time(now) {
            self.outputs.push_back(Output::Send(request));
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
        self.end_waits(now);
        self.pump(now);
    }

    /// Ends the waits whose time is over.
    fn end_waits(&mut self, now: MonoTime) {
        let mut index = 0;
        while index < self.ops.len() {
            let error = match &self.ops[index].state {
                State::Refused { command, result, until } if now >= *until => Some(VehicleError::CommandRefused {
                    target: command.message.target(),
                    command: command.name(),
                    result: *result,
                    reasons: self.reasons(command, now),
                }),
                State::Awaiting { command, until } if now >= *until => Some(self.not_confirmed(command, now)),
                _ => None,
            };
            match error {
                Some(error) => self.finish(index, Err(error)),
                None => index += 1,
            }
        }
    }

    fn not_confirmed(&self, command: &Commanding, now: MonoTime) -> VehicleError {
        let heartbeat = self.telemetry.heartbeat;
        let shown = |text: Option<String>| text.unwrap_or_else(|| "nothing".to_owned());
        let armed = |is_armed: bool| if is_armed { "armed" } else { "disarmed" }.to_owned();
        let (wanted, observed) = match command.effect {
            Effect::Received(message_id) => return VehicleError::MessageNotReceived { message_id },
            Effect::Armed(is_armed) => (armed(is_armed), shown(heartbeat.map(|h| armed(h.value.is_armed)))),
            Effect::Mode(mode) => (format!("mode {mode}"), shown(heartbeat.map(|h| format!("mode {}", h.value.mode)))),
            Effect::Current(seq) => {
                (format!("item {seq}"), shown(self.telemetry.mission.map(|m| format!("item {}", m.value.seq))))
            }
            Effect::Acknowledged | Effect::Airborne | Effect::JumpedFrom(_) | Effect::Restarted => {
                ("its effect".to_owned(), shown(None))
            }
        };
        VehicleError::NotConfirmed {
            command: command.name(),
            wanted,
            observed,
            within: now.since(command.last_sent),
            reasons: self.reasons(command, now),
        }
    }

    /// What the vehicle wrote about a command: failing checks for arming, else warnings and worse since it was sent.
    fn reasons(&self, command: &Commanding, now: MonoTime) -> Vec<String> {
        let is_check = |text: &&Text| text.text.starts_with("PreArm: ") || text.text.starts_with("Arm: ");
        let is_warning = |text: &&Text| text.severity <= Severity::WARNING;
        let since = |moment: MonoTime| {
            let texts = self.texts.iter().rev();
            texts.take_while(move |text| text.at >= moment).filter(|text| text.component == self.address.component)
        };
        let is_arming = command.effect == Effect::Armed(true);
        let mut found: Vec<&Text> =
            if is_arming { since(command.first_sent).filter(is_check).collect() } else { Vec::new() };
        if found.is_empty() {
            found = since(command.first_sent).filter(is_warning).collect();
        }
        if found.is_empty() && is_arming {
            let age = now.as_duration().saturating_sub(PREARM_REPEATED);
            found = since(MonoTime::from_origin(age)).filter(is_check).collect();
        }
        let mut reasons: Vec<String> = Vec::new();
        for text in found.into_iter().rev() {
            if !reasons.contains(&text.text) && reasons.len() < MAX_REASONS {
                reasons.push(text.text.clone());
            }
        }
        reasons
    }

    // ── requests ─────────────────────────────────────────────────────────────────────────────────────────────────

    /// Starts a request. Its result comes as [`Output::Finished`], also when it is refused at once.
    pub fn request(&mut self, request: Request, now: MonoTime) -> RequestId {
        let id = RequestId(self.next_request);
        self.next_request += 1;
        if let Err(error) = self.begin(id, request, now) {
            self.outputs.push_back(Output::Finished { id, result: Err(error) });
        }
        self.pump(now);
        id
    }

    fn begin(&mut self, id: RequestId, request: Request, now: MonoTime) -> Result<(), VehicleError> {
        if self.ops.len() >= MAX_REQUESTS {
            return Err(VehicleError::TooManyRequests { limit: MAX_REQUESTS });
        }
        self.refuse_mixed_mission(&request)?;
        if let Request::SetMessageRate { message_id, rate_hz } = request {
            self.streams.config_mut().set_rate(message_id, rate_hz)?;
        }
        let wants_acknowledgement = matches!(request, Request::RawCommandLong(_) | Request::RawCommandInt(_));
        let steps = self.context(now).steps(request)?;
        let is_transfer =
            |step: &Step| matches!(step, Step::Upload(..) | Step::Download(_) | Step::Clear(_) | Step::ParamList);
        if steps.iter().any(is_transfer)
            && let Some(running) = &self.transfer
        {
            return Err(VehicleError::TransferBusy { running: running.machine.name() });
        }
        self.ops.push(Op { id, steps, state: State::Ready, acknowledged: None, wants_acknowledgement });
        self.advance(id, now);
        Ok(())
    }

    /// A mission that one of our transfers left half-written is neither flown nor armed for.
    fn refuse_mixed_mission(&self, request: &Request) -> Result<(), VehicleError> {
        let state = self.plans.get(PlanKind::Mission);
        if !state.may_be_mixed() {
            return Ok(());
        }
        let starts = match request {
            Request::Arm { .. } | Request::MissionStart { .. } | Request::MissionResume => true,
            Request::SetMode(choice) => self.telemetry.mode().is_some_and(|mode| match choice {
                ModeChoice::Name(name) => mode.family.parse(name).is_ok_and(FlightMode::follows_mission),
                ModeChoice::Custom(custom_mode) => FlightMode { custom_mode: *custom_mode, ..mode }.follows_mission(),
            }),
            _ => false,
        };
        if starts { Err(VehicleError::PlanUnknown { kind: PlanKind::Mission, state }) } else { Ok(()) }
    }

    /// Gives a request up; its result is [`VehicleError::Cancelled`]. A command that was sent may still be executed.
    pub fn cancel(&mut self, id: RequestId, now: MonoTime) {
        let Some(index) = self.ops.iter().position(|op| op.id == id) else { return };
        match &self.ops[index].state {
            State::Transferring => {
                for lane in [&mut self.transfer, &mut self.param].into_iter().flatten() {
                    if lane.id == id {
                        lane.machine.cancel(now);
                    }
                }
                // The lane ends the request.
                self.pump(now);
                return;
            }
            State::Commanding { id: command, .. } => self.commands.forget(*command, now),
            _ => {}
        }
        self.finish(index, Err(VehicleError::Cancelled));
        self.pump(now);
    }

    /// Gives all requests up: the vehicle or its owner goes away. Each result still comes as [`Output::Finished`].
    pub fn close(&mut self, now: MonoTime) {
        let ids: Vec<_> = self.ops.iter().map(|op| op.id).collect();
        for id in ids {
            self.cancel(id, now);
        }
    }

    /// Begins the next step of a request, or ends it.
    fn advance(&mut self, id: RequestId, now: MonoTime) {
        let Some(index) = self.ops.iter().position(|op| op.id == id) else { return };
        let Some(step) = self.ops[index].steps.pop_front() else {
            let op = &self.ops[index];
            let reply = match op.acknowledged {
                Some(result_param2) if op.wants_acknowledgement => Reply::Acknowledged { result_param2 },
                _ => Reply::Done,
            };
            self.finish(index, Ok(reply));
            return;
        };
        match step {
            Step::Command { message, unanswered, when_busy, effect, fallback } => {
                let command = Commanding {
                    message,
                    effect,
                    fallback,
                    first_sent: now,
                    last_sent: now,
                    mode_before: self.telemetry.mode(),
                };
                self.send_command(index, command, unanswered, when_busy, now);
            }
            Step::ParamRead(_) | Step::ParamSet(..) if self.param_lane_is_busy() => {
                self.ops[index].state = State::WaitingForLane(step);
            }
            step => self.start_transfer(index, step, now),
        }
    }

    fn send_command(
        &mut self,
        index: usize,
        command: Commanding,
        unanswered: Unanswered,
        when_busy: WhenBusy,
        now: MonoTime,
    ) {
        match self.commands.submit(command.message, unanswered, when_busy, now) {
            Ok(id) => self.ops[index].state = State::Commanding { command, id, asked: false },
            Err(_) => self.finish(index, Err(VehicleError::CommandBusy { command: command.name() })),
        }
    }

    fn param_lane_is_busy(&self) -> bool {
        // A list of parameters would be taken for the answer to a single one.
        let is_listing = self.transfer.as_ref().is_some_and(|lane| matches!(lane.machine, Machine::List(_)));
        self.param.is_some() || is_listing
    }

    fn transfer_config(&self) -> TransferConfig {
        let is_ardupilot = self.is_ardupilot();
        let version = self.telemetry.version.map(|version| version.value);
        let is_bytewise = version.is_some_and(|version| version.capabilities & PARAM_BYTEWISE != 0);
        TransferConfig {
            vehicle: self.address,
            station: self.our,
            is_ardupilot,
            // Every ArduPilot since 2021 has it; one that does not answer is served item by item.
            has_ftp: version.map_or(is_ardupilot, |version| version.has_ftp()),
            param_encoding: if is_bytewise { ParamEncoding::Bytewise } else { ParamEncoding::CCast },
            round_trip: self.timesync.round_trip(),
            item_window: self.config.item_window,
            ftp_sessions: self.ftp_sessions.clone(),
        }
    }

    fn start_transfer(&mut self, index: usize, step: Step, now: MonoTime) {
        let config = self.transfer_config();
        let id = self.ops[index].id;
        self.ops[index].state = State::Transferring;
        let before = |kind: PlanKind| Some((kind, self.plans.get(kind)));
        let (plan_before, machine) = match step {
            Step::Upload(kind, items) => {
                (before(kind), Machine::Upload(Box::new(PlanUpload::new(&config, kind, items, now))))
            }
            Step::Download(kind) => (before(kind), Machine::Download(Box::new(PlanDownload::new(&config, kind, now)))),
            Step::Clear(kind) => (before(kind), Machine::Clear(Box::new(PlanClear::new(&config, kind, now)), kind)),
            Step::ParamList => (None, Machine::List(Box::new(ParamList::new(&config, now)))),
            Step::ParamRead(name) => (None, Machine::Read(Box::new(ParamRead::new(&config, name, now)))),
            Step::ParamSet(name, value) => (None, Machine::Set(Box::new(ParamSet::new(&config, name, value, now)))),
            Step::Command { .. } => unreachable!("invariant: commands do not go by a lane"),
        };
        if let (Some((kind, _)), true) = (plan_before, machine.writes_plan()) {
            self.set_plan(kind, PlanState::Unknown(Unknown::Transferring));
        }
        let is_single = matches!(machine, Machine::Read(_) | Machine::Set(_));
        let lane = Some(Lane { id, machine, plan_before });
        if is_single { self.param = lane } else { self.transfer = lane }
    }

    fn finish(&mut self, index: usize, result: Result<Reply, VehicleError>) {
        let op = self.ops.remove(index);
        self.outputs.push_back(Output::Finished { id: op.id, result });
    }

    // ── machines ─────────────────────────────────────────────────────────────────────────────────────────────────

    /// Moves what the machines put out, until they rest.
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
    }

    fn on_command_output(&mut self, output: CommandOutput, now: MonoTime) {
        match output {
            CommandOutput::Send(message) => self.outputs.push_back(Output::Send(message)),
            CommandOutput::Progress { id, percent } => {
                if let Some(op) = self.op_commanding(id) {
                    let id = self.ops[op].id;
                    let done = u32::from(percent.unwrap_or(0));
                    self.outputs.push_back(Output::Progress {
                        id,
                        done,
                        total: if percent.is_some() { 100 } else { 0 },
                    });
                }
            }
            CommandOutput::Unanswered { id } => {
                if let Some(index) = self.op_commanding(id) {
                    if let State::Commanding { asked, .. } = &mut self.ops[index].state {
                        *asked = true;
                    }
                    self.check_effect(index, now);
                }
            }
            CommandOutput::Finished { id, outcome } => match self.op_commanding(id) {
                Some(index) => self.on_command_finished(index, outcome, now),
                None => {
                    self.streams.on_finished(id, outcome, &mut self.commands, now);
                }
            },
        }
    }

    fn op_commanding(&self, command: CommandId) -> Option<usize> {
        self.ops.iter().position(|op| matches!(op.state, State::Commanding { id, .. } if id == command))
    }

    fn on_command_finished(&mut self, index: usize, outcome: CommandOutcome, now: MonoTime) {
        let State::Commanding { command, .. } = std::mem::replace(&mut self.ops[index].state, State::Ready) else {
            return;
        };
        match outcome {
            CommandOutcome::TimedOut { attempts } => {
                let error = VehicleError::CommandTimeout {
                    target: command.message.target(),
                    command: command.name(),
                    attempts,
                };
                self.finish(index, Err(error));
            }
            CommandOutcome::Answered { result: CommandResult::ACCEPTED, result_param2 } => {
                self.ops[index].acknowledged = Some(result_param2);
                let within = match command.effect {
                    Effect::Acknowledged | Effect::Airborne | Effect::JumpedFrom(_) | Effect::Restarted => None,
                    Effect::Received(_) => Some(MESSAGE_WITHIN.max(self.round_trip().unwrap_or_default() * 2)),
                    Effect::Armed(_) | Effect::Mode(_) | Effect::Current(_) => Some(EFFECT_WITHIN),
                };
                match within {
                    Some(within) => {
                        self.ops[index].state = State::Awaiting { command, until: now + within };
                        self.check_effect(index, now);
                    }
                    None => {
                        let id = self.ops[index].id;
                        self.advance(id, now);
                    }
                }
            }
            CommandOutcome::Answered { result: CommandResult::UNSUPPORTED, .. } if command.fallback.is_some() => {
                self.fall_back(index, command, now);
            }
            CommandOutcome::Answered { result, .. } => {
                let wait = if matches!(command.effect, Effect::Armed(_)) { ARM_REASONS_AFTER } else { REASONS_AFTER };
                self.ops[index].state = State::Refused { command, result, until: now + wait };
            }
        }
    }

    fn fall_back(&mut self, index: usize, mut command: Commanding, now: MonoTime) {
        command.last_sent = now;
        match command.fallback.take() {
            Some(Fallback::Command(message)) => {
                command.message = message;
                let unanswered = Unanswered::for_command(message.command());
                self.send_command(index, command, unanswered, WhenBusy::Refuse, now);
            }
            Some(Fallback::Message(message, effect)) => {
                command.effect = effect;
                self.outputs.push_back(Output::Send(message));
                self.ops[index].state = State::Awaiting { command, until: now + EFFECT_WITHIN };
            }
            None => {}
        }
    }

    /// Looks whether the effects that are waited for show.
    fn check_effects(&mut self, now: MonoTime) {
        let mut index = 0;
        while index < self.ops.len() {
            let id = self.ops[index].id;
            self.check_effect(index, now);
            if self.ops.get(index).is_some_and(|op| op.id == id) {
                index += 1;
            }
        }
    }

    fn check_effect(&mut self, index: usize, now: MonoTime) {
        let (command, under_way) = match &self.ops[index].state {
            State::Commanding { command, id, asked } => (command, Some((*id, *asked))),
            State::Awaiting { command, .. } => (command, None),
            _ => return,
        };
        let seen = self.seen(command);
        let op = self.ops[index].id;
        match (seen, under_way) {
            (Seen::Shown, Some((id, asked))) => {
                // Without an answer only what the vehicle reports in as many words counts, or what follows a silence.
                let is_proof = matches!(command.effect, Effect::Armed(_) | Effect::Mode(_)) || asked;
                if is_proof {
                    self.commands.forget(id, now);
                    self.ops[index].state = State::Ready;
                    self.advance(op, now);
                }
            }
            (Seen::Shown, None) => {
                self.ops[index].state = State::Ready;
                self.advance(op, now);
            }
            (Seen::NotShown, Some((id, true))) => {
                self.commands.repeat(id, now);
                if let State::Commanding { command, asked, .. } = &mut self.ops[index].state {
                    command.last_sent = now;
                    *asked = false;
                }
            }
            (Seen::Overtaken(observed), Some((id, true))) => {
                let error = VehicleError::NotConfirmed {
                    command: command.name(),
                    wanted: match command.effect {
                        Effect::Mode(mode) => format!("mode {mode}"),
                        _ => "its effect".to_owned(),
                    },
                    observed,
                    within: now.since(command.last_sent),
                    reasons: self.reasons(command, now),
                };
                self.commands.forget(id, now);
                self.finish(index, Err(error));
            }
            _ => {}
        }
    }

    /// How the effect of a command looks by what the vehicle has said since it was sent.
    fn seen(&self, command: &Commanding) -> Seen {
        // What was on its way when the command was sent proves nothing against it.
        let fresh = command.last_sent + self.config.commands.timeout / 2;
        let by_heartbeat = |is_shown: bool, at: MonoTime| {
            if is_shown && at >= command.first_sent {
                Seen::Shown
            } else if !is_shown && at >= fresh {
                Seen::NotShown
            } else {
                Seen::NotYet
            }
        };
        match command.effect {
            Effect::Armed(is_armed) => self
                .telemetry
                .heartbeat
                .map_or(Seen::NotYet, |heartbeat| by_heartbeat(heartbeat.value.is_armed == is_armed, heartbeat.at)),
            Effect::Mode(mode) => self.telemetry.heartbeat.map_or(Seen::NotYet, |heartbeat| {
                let shown = heartbeat.value.mode;
                match by_heartbeat(shown == mode, heartbeat.at) {
                    Seen::NotShown if command.mode_before.is_some_and(|before| before != shown) => {
                        Seen::Overtaken(format!("mode {shown}"))
                    }
                    seen => seen,
                }
            }),
            Effect::Airborne => self.telemetry.extended.map_or(Seen::NotYet, |extended| match extended.value.landed {
                LandedState::InAir | LandedState::TakingOff => by_heartbeat(true, extended.at),
                LandedState::OnGround => by_heartbeat(false, extended.at),
                LandedState::Undefined | LandedState::Landing => Seen::NotYet,
            }),
            Effect::JumpedFrom(before) => self.telemetry.mission.map_or(Seen::NotYet, |mission| {
                by_heartbeat(before.is_some_and(|before| before != mission.value.seq), mission.at)
            }),
            Effect::Current(seq) => self
                .telemetry
                .mission
                .map_or(Seen::NotYet, |mission| by_heartbeat(mission.value.seq == seq, mission.at)),
            Effect::Acknowledged | Effect::Received(_) | Effect::Restarted => Seen::NotYet,
        }
    }

    /// Hands a message to the request that asked for it.
    fn on_awaited(&mut self, message: &Message, now: MonoTime) {
        let wants = |command: &Commanding| command.effect == Effect::Received(message.id());
        let mut index = 0;
        while index < self.ops.len() {
            match &self.ops[index].state {
                State::Commanding { command, id, .. } if wants(command) => {
                    // It may overtake the acknowledgement; it is what was wanted.
                    self.commands.forget(*id, now);
                }
                State::Awaiting { command, .. } if wants(command) => {}
                _ => {
                    index += 1;
                    continue;
                }
            }
            self.finish(index, Ok(Reply::Message(Box::new(message.clone()))));
        }
    }

    fn drain_lanes(&mut self, now: MonoTime) {
        for slot in [LaneName::Transfer, LaneName::Param] {
            let lane = match slot {
                LaneName::Transfer => &mut self.transfer,
                LaneName::Param => &mut self.param,
            };
            let Some(running) = lane else { continue };
            while let Some(output) = running.machine.poll_output() {
                self.outputs.push_back(match output {
                    TransferOutput::Send(message) => Output::Send(message),
                    TransferOutput::Progress { done, total } => Output::Progress { id: running.id, done, total },
                });
            }
            if let Some(result) = running.machine.result()
                && let Some(ended) = lane.take()
            {
                self.on_transfer_ended(ended, result, now);
            }
        }
    }

    fn on_transfer_ended(&mut self, lane: Lane, result: Result<Yield, TransferError>, now: MonoTime) {
        if lane.plan_before.is_some() {
            self.transfer_ended = Some(now);
        }
        let result = match result {
            Ok(Yield::Plan(kind, wire)) => self.on_plan(kind, &wire),
            Ok(Yield::Parameters(params)) => {
                params.iter().for_each(|param| self.learn(param));
                Ok(Reply::Parameters(params))
            }
            Ok(Yield::Parameter(param)) => {
                self.learn(&param);
                Ok(Reply::Parameter(param))
            }
            Err(error) => {
                if let Some((kind, _)) = lane.plan_before
                    && lane.machine.writes_plan()
                {
                    self.set_plan(kind, PlanState::Unknown(Unknown::TransferFailed));
                }
                Err(match error {
                    TransferError::Cancelled => VehicleError::Cancelled,
                    error => VehicleError::Transfer(error),
                })
            }
        };
        let Some(index) = self.ops.iter().position(|op| op.id == lane.id) else { return };
        if result.is_ok() && !self.ops[index].steps.is_empty() {
            self.ops[index].state = State::Ready;
            self.advance(lane.id, now);
        } else {
            self.finish(index, result);
        }
    }

    /// Parameters that our own reckoning needs.
    fn learn(&mut self, param: &Param) {
        let value = param.value.as_f64().abs();
        if param.name.as_str() == "WP_LOITER_RAD" && value >= 1.0 {
            self.progress_options.loiter_radius_m = value;
        }
    }

    /// A plan was read from the vehicle: now it is known.
    fn on_plan(&mut self, kind: PlanKind, wire: &[MissionItemInt]) -> Result<Reply, VehicleError> {
        let has_home = kind == PlanKind::Mission && self.is_ardupilot();
        let mission = match kind {
            PlanKind::Mission => Mission::from_wire(wire, has_home)?,
            PlanKind::Fence | PlanKind::Rally => Mission { home: None, items: items_from_wire(wire, kind)? },
        };
        let items = &mission.items;
        let state = if items.is_empty() {
            PlanState::Empty
        } else {
            let count = u16::try_from(items.len()).unwrap_or(u16::MAX);
            PlanState::Verified { count, hash: hash_items(&wire[usize::from(has_home)..]) }
        };
        if kind == PlanKind::Mission {
            if self.plans.get(kind) != state {
                self.tracker.reset();
            }
            self.mission = (!items.is_empty()).then(|| Arc::new(mission.clone()));
        }
        self.set_plan(kind, state);
        Ok(Reply::Plan { kind, items: mission.items, home: mission.home, state })
    }
}

#[derive(Clone, Copy)]
enum LaneName {
    Transfer,
    Param,
}
