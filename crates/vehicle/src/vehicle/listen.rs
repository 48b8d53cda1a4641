//! Received messages: telemetry into its groups, changes into events, protocol messages to their machines.

use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::guidance::l1::L1Params;
use vencejo_flight::plan::{Command, PlanKind};
use vencejo_proto::dialect::{MavMessage, TIMESYNC_DATA};
use vencejo_proto::param::{ParamName, ParamType, ShownEncodings};
use vencejo_proto::{Address, ComponentId, Message, MissionAck, MissionSeq, MonoTime, StatusText};

use super::lane::Written;
use super::operation::State;
use super::steps::Effect;
use super::{Interrupted, Reached, Told, Vehicle};
use crate::conduct::leads_to_landing;
use crate::error::VehicleError;
use crate::modes::{Action, ModeFamily};
use crate::plan_state::{PlanState, Unknown};
use crate::reach::Reach;
use crate::request::{Output, Reply, VehicleEvent};
use crate::streams::HOME_POSITION;
use crate::telemetry::{BootEvent, Group, boot_ms_of};
use crate::timesync::TimeSyncEvent;
use crate::transfer::TransferOutput;

/// After we wrote a plan, messages about it may still be on their way.
const TRANSFER_ECHO: Duration = Duration::from_secs(5);
/// How long before the mode the landing may be shown as the current item; heartbeats come each second.
const JUMPED_WITHIN: Duration = Duration::from_millis(2_500);
/// A plan file that an upload left open has been closed by then: ArduPilot closes a session that is idle for 20 s
/// (`GCS_FTP.h`), and up to 4.7 it does so when another file is opened.
const FILE_LEFT_OPEN: Duration = Duration::from_secs(30);
/// PX4 v1.17 repeats that it has reached an item ten times, once a second (`MavlinkMissionManager::send`), also where it has
/// been set back to that item meanwhile.
const REACHED_REPEATED: Duration = Duration::from_secs(12);
/// Two restarts within this are one.
const RESTART_ONCE: Duration = Duration::from_secs(3);

impl Vehicle {
    /// A message from component `from` of the vehicle. Returns the telemetry group that it changed.
    pub fn on_message(&mut self, from: ComponentId, message: &Message, now: MonoTime) -> Option<Group> {
        if from != self.address.component {
            return self.on_other_component(from, message, now);
        }
        self.hear(now);
        self.note_answer(message, now);
        match boot_ms_of(message).and_then(|boot_ms| self.boot.observe(boot_ms, now)) {
            Some(BootEvent::Rebooted { since }) => {
                self.timesync.forget_clock();
                self.on_restart(since, now);
                self.pump(now);
            }
            Some(BootEvent::RanAhead) => self.ask_who_it_is(now),
            None => {}
        }
        // Not from another link, which may be late.
        if let Message::Dialect(MavMessage::PARAM_VALUE(told)) = message {
            self.on_param_told(told, now);
        }
        self.take(message, now)
    }

    /// A message of the autopilot over another link than the followed one. That link may be seconds late, so the time
    /// since boot does not indicate a restart.
    pub fn on_beside(&mut self, message: &Message, now: MonoTime) -> Option<Group> {
        self.hear(now);
        self.note_answer(message, now);
        self.take(message, now)
    }

    fn take(&mut self, message: &Message, now: MonoTime) -> Option<Group> {
        let family = self.family();
        let group = self.telemetry.apply(message, now);
        match group {
            Some(Group::Heartbeat) => {
                if family.is_some() && family != self.family() {
                    self.on_other_autopilot(now);
                }
                self.on_heartbeat(now);
            }
            Some(group) => {
                // These come on request.
                if !matches!(group, Group::Version | Group::Home) {
                    self.streams.on_telemetry();
                }
                match group {
                    Group::Mission => self.on_mission_current(now),
                    Group::ItemReached => self.on_item_reached(now),
                    Group::Extended => self.on_extended(),
                    Group::Home => self.on_home(),
                    Group::Version => self.on_version(now),
                    Group::Nav => self.on_nav(now),
                    Group::Position => {
                        self.on_position();
                        if let Some(moment) = self.telemetry.recorded(now) {
                            self.learner.note(moment);
                        }
                    }
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

    pub(super) fn hear(&mut self, now: MonoTime) {
        self.heard_at = now;
        self.reach.on_heard(now);
        if self.is_lost {
            self.is_lost = false;
            self.streams.on_regained(now);
            self.events.on_mode(now);
            self.event(VehicleEvent::Regained);
            self.ask_who_it_is(now);
        }
    }

    /// After a silence: another aircraft with the same system id may have come to the link, which [`Self::on_version`]
    /// finds out.
    fn ask_who_it_is(&mut self, now: MonoTime) {
        self.doubt_identity(now, false, now);
        self.streams.ask_version(&mut self.commands, now);
        self.pump(now);
    }

    /// Messages of gimbals, radios, batteries, on-board computers: they share the system's id, but only the autopilot
    /// is the vehicle.
    pub(super) fn on_other_component(&mut self, from: ComponentId, message: &Message, now: MonoTime) -> Option<Group> {
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

    /// The state of the radio to this vehicle; radios have a system id of their own.
    pub fn on_radio(&mut self, message: &Message, now: MonoTime) -> Option<Group> {
        match message {
            Message::Dialect(MavMessage::RADIO_STATUS(_) | MavMessage::RADIO(_)) => self.telemetry.apply(message, now),
            _ => None,
        }
    }

    /// A message of another system to the vehicle, overheard by us: it may change a plan.
    pub fn on_foreign(&mut self, from: Address, message: &Message, now: MonoTime) {
        if from == self.our || from.system == self.address.system && from.component == self.address.component {
            return;
        }
        self.on_written(from, message, now);
        self.pump(now);
    }

    pub(super) fn on_protocol(&mut self, message: &Message, now: MonoTime) {
        match message {
            Message::StatusText(text) => self.on_text(self.address.component, text, now),
            Message::CommandAck(ack) => {
                // From any station.
                match Command(ack.command) {
                    _ if ack.result != 0 => {}
                    Command::DO_GO_AROUND => self.tracker.on_set_current(),
                    Command::DO_SET_MISSION_CURRENT
                    | Command::DO_LAND_START
                    | Command::DO_RETURN_PATH_START
                    | Command::DO_JUMP_TAG => self.on_jump(),
                    _ => {}
                }
                self.commands.on_ack(self.address, ack, now);
                self.pump(now);
                return;
            }
            Message::Dialect(MavMessage::TIMESYNC(timesync)) => {
                self.on_timesync(timesync, now);
                return;
            }
            Message::Dialect(MavMessage::POSITION_TARGET_GLOBAL_INT(target)) => {
                self.on_target(target, now);
                return;
            }
            Message::Dialect(MavMessage::MISSION_REQUEST_INT(_) | MavMessage::MISSION_REQUEST(_)) => {
                self.on_asks(message, now);
            }
            Message::Dialect(
                MavMessage::EVENT(_) | MavMessage::CURRENT_EVENT_SEQUENCE(_) | MavMessage::RESPONSE_EVENT_ERROR(_),
            ) => {
                self.on_event_message(message, now);
                return;
            }
            Message::MissionAck(ack) => self.on_mission_ack(ack, now),
            Message::Dialect(MavMessage::PARAM_VALUE(told)) => {
                if let Some(param_type) = ParamType::from_mav(told.param_type) {
                    self.shown_encodings.note(told.param_value, param_type);
                }
            }
            _ => {}
        }
        for lane in [&mut self.transfer, &mut self.param].into_iter().flatten() {
            lane.machine.on_message(self.address, message, now);
        }
        self.pump(now);
    }

    pub(super) fn on_timesync(&mut self, message: &TIMESYNC_DATA, now: MonoTime) {
        match self.timesync.on_message(message, now) {
            Some(TimeSyncEvent::Answer(answer)) if self.speaks() => self.outputs.push_back(Output::Send(answer)),
            Some(TimeSyncEvent::Measured { has_gone_back, .. }) => {
                self.commands.set_round_trip(self.timesync.round_trip());
                let is_news = self.reach.on_timesync(self.timesync.round_trip(), now);
                self.tell_reached(is_news);
                if has_gone_back {
                    self.boot.reset();
                    self.on_restart(now, now);
                    self.pump(now);
                }
            }
            Some(TimeSyncEvent::Answer(_)) | None => {}
        }
    }

    pub(super) fn on_text(&mut self, from: ComponentId, text: &StatusText, now: MonoTime) {
        self.on_text_of(from, text, now, now);
    }

    /// A text written at an earlier time.
    pub(super) fn on_text_of(&mut self, from: ComponentId, text: &StatusText, at: MonoTime, now: MonoTime) {
        let known = self.texts.total();
        self.texts.push(from, text, at, now);
        let new: Vec<_> = self.texts.after(known).cloned().collect();
        for text in new {
            self.event(VehicleEvent::Text(text));
        }
    }

    pub(super) fn on_heartbeat(&mut self, now: MonoTime) {
        let Some(heartbeat) = self.telemetry.heartbeat.map(|heartbeat| heartbeat.value) else { return };
        self.heartbeat_at = now;
        if self.told.mode != Some(heartbeat.mode) {
            let from = self.told.mode.replace(heartbeat.mode);
            self.event(VehicleEvent::ModeChanged { from, to: heartbeat.mode });
            self.events.on_mode(now);
        }
        self.tracker.on_mode(heartbeat.mode.follows_mission());
        self.note_interruption(now);
        if self.told.is_armed != Some(heartbeat.is_armed) {
            self.told.is_armed = Some(heartbeat.is_armed);
            self.event(VehicleEvent::ArmedChanged { is_armed: heartbeat.is_armed });
            self.events.on_mode(now);
            let last = self.last_nav();
            if self.tracker.on_armed(heartbeat.is_armed, last).has_completed {
                self.event(VehicleEvent::MissionComplete);
            }
        }
        if !(heartbeat.is_armed && heartbeat.mode.follows_mission()) {
            self.forget_target();
        }
        if !self.has_asked {
            self.has_asked = true;
            self.streams.ask(&mut self.commands, now);
            self.pump(now);
        }
    }

    /// Notes where a PX4 leaves its mission to return. A failsafe holds first (COM_FAIL_ACT_T), as a pilot may, and the
    /// landing may become the current item just before the mode is shown.
    fn note_interruption(&mut self, now: MonoTime) {
        let (Some(mode), Some(current)) = (self.telemetry.mode(), self.telemetry.mission) else { return };
        let is_flying = self.telemetry.is_armed() == Some(true);
        if mode.family != ModeFamily::Px4 || !is_flying {
            self.interrupted = Interrupted::default();
            return;
        }
        let seq = current.value.seq;
        let lands = self.mission().map(|mission| leads_to_landing(mission, usize::from(seq)));
        let (flies_mission, returns) = (mode.follows_mission(), Action::ReturnToLaunch.mode(mode.family) == Some(mode));
        let noted = &mut self.interrupted;
        if lands == Some(false) || lands.is_none() && flies_mission {
            *noted = Interrupted { before_landing: Some(seq), ..Interrupted::default() };
        } else if lands == Some(true) || returns {
            let since = *noted.landing_since.get_or_insert(now);
            if flies_mission {
                noted.left_at = None;
            } else if returns && now.since(since) <= JUMPED_WITHIN {
                noted.left_at = noted.left_at.or(noted.before_landing);
            }
        }
    }

    /// The mission was set to an item, by any station: it goes on there.
    pub(super) fn on_jump(&mut self) {
        self.tracker.on_set_current();
        self.interrupted = Interrupted::default();
    }

    fn on_position(&mut self) {
        let parameter = |name| ParamName::new(name).ok().and_then(|name| self.parameters.get(&name).copied());
        let default = L1Params::default();
        let law = L1Params {
            period_s: parameter("NAVL1_PERIOD").unwrap_or(default.period_s),
            damping: parameter("NAVL1_DAMPING").unwrap_or(default.damping),
            ..default
        };
        let (mission, options) = (self.mission().map(Arc::clone), self.progress_options());
        self.tracker.on_position(&self.telemetry, mission.as_deref(), self.first_seq(), &options, &law);
    }

    pub(super) fn on_extended(&mut self) {
        let Some(landed) = self.telemetry.extended.map(|extended| extended.value.landed) else { return };
        if self.told.landed != Some(landed) {
            self.told.landed = Some(landed);
            self.event(VehicleEvent::LandedChanged { landed });
        }
    }

    pub(super) fn on_home(&mut self) {
        self.streams.on_received(HOME_POSITION);
        let Some(home) = self.telemetry.home.map(|home| home.value) else { return };
        if self.told.home != Some(home) {
            self.told.home = Some(home);
            self.event(VehicleEvent::HomeChanged);
        }
    }

    pub(super) fn on_mission_current(&mut self, now: MonoTime) {
        let Some(current) = self.telemetry.mission.map(|mission| mission.value) else { return };
        self.end_judging();
        let changes = self.tracker.on_current(&current);
        self.note_interruption(now);
        if let Some(seq) = changes.current {
            if let Some(reached) = self.told.reached.as_mut().filter(|reached| reached.seq == seq.0) {
                reached.is_current_again = true;
            }
            self.event(VehicleEvent::CurrentItemChanged { seq });
        }
        if changes.has_completed {
            self.event(VehicleEvent::MissionComplete);
        }
        // Without the number of items it is an old message, which has no room for names either.
        let Some(total) = current.total else { return };
        // PX4 gives its plans ids, and none to a missing one; another id is another plan.
        let ids = [current.mission_id, current.fence_id, current.rally_points_id];
        let before = self.mission_ids.replace(ids).unwrap_or(ids);
        for (kind, (before, id)) in PlanKind::ALL.into_iter().zip(before.into_iter().zip(ids)) {
            if before != id {
                self.on_renamed(kind, id, now);
            }
        }
        self.on_total(total, now);
    }

    pub(super) fn on_item_reached(&mut self, now: MonoTime) {
        let Some(seq) = self.telemetry.item_reached.map(|reached| reached.value) else { return };
        if self.family() == Some(ModeFamily::Px4) {
            let is_repeated = |told: Reached| !told.is_current_again || now.since(told.at) < REACHED_REPEATED;
            if self.told.reached.is_some_and(|told| told.seq == seq && is_repeated(told)) {
                return;
            }
            self.told.reached = Some(Reached { seq, at: now, is_current_again: false });
        }
        let (last, first, mission) = (self.last_nav(), self.first_seq(), self.mission().map(Arc::clone));
        let changes = self.tracker.on_reached(seq, last, mission.as_deref(), first);
        for seq in changes.passed.into_iter().chain([MissionSeq(seq)]) {
            self.event(VehicleEvent::ItemReached { seq });
        }
        if changes.has_completed {
            self.event(VehicleEvent::MissionComplete);
        }
    }

    /// The vehicle took a plan from somebody else (or from another station that uses our address).
    pub(super) fn on_mission_ack(&mut self, ack: &MissionAck, now: MonoTime) {
        if self.on_guided_ack(ack, now) || self.on_ack_to_another(ack, now) {
            return;
        }
        if ack.result == 0
            && let Ok(kind) = PlanKind::try_from(ack.mission_type)
        {
            self.told_changed(kind, now);
            let until = if self.writes(kind) { Some(now + TRANSFER_ECHO) } else { self.echo_until(kind, now) };
            if let Some(until) = until
                && !Message::MissionAck(*ack).target().includes(self.our)
            {
                // It is about what another station sent before ours, or about what it sent since and we did not hear.
                self.doubt_copy(kind, until);
            }
        }
    }

    /// The vehicle says that a plan is another one: what is known of it is void, unless our own writing may be meant.
    pub(super) fn told_changed(&mut self, kind: PlanKind, now: MonoTime) {
        let is_moving = self.transfer.as_ref().is_some_and(|lane| lane.is_about(kind));
        if is_moving || !self.is_echo(kind, now) {
            self.void(kind, now);
        }
    }

    /// Why a plan that has changed is unknown: an upload of ours that failed may have become the plan since.
    pub(super) fn why_changed(&self, kind: PlanKind, now: MonoTime) -> Unknown {
        let is_ours = |written: Written| written.is_unfinished && now < written.at + FILE_LEFT_OPEN;
        if self.written[kind as usize].is_some_and(is_ours) {
            Unknown::TransferFailed
        } else {
            Unknown::ChangedElsewhere
        }
    }

    pub(super) fn void(&mut self, kind: PlanKind, now: MonoTime) {
        if let Some(lane) = &mut self.transfer
            && lane.is_about(kind)
        {
            // A plan that is being written is unknown anyway; one that is being read may come out mixed.
            lane.is_disturbed = !lane.machine.writes_plan();
            return;
        }
        let is_settled = !matches!(self.plans.get(kind), PlanState::Unknown(_) | PlanState::Differs { .. });
        if is_settled {
            self.set_plan(kind, PlanState::Unknown(self.why_changed(kind, now)));
        }
    }

    /// Another vehicle has taken this one's place: nothing that is known holds any more. Of the mission of the one
    /// before it is remembered what is known, should it come back, unless that `was_recording`: then it is not what the
    /// aircraft holds.
    pub fn on_replaced(&mut self, was_recording: bool, now: MonoTime) {
        self.boot.reset();
        self.timesync.forget_clock();
        self.reach = Reach::default();
        self.restarted_at = None;
        self.on_restart(now, now);
        if was_recording {
            self.on_board.identity.key = None;
        }
        self.on_board_replaced(None, false, now);
        self.pump(now);
    }

    /// Whether what is said of a plan now may be about our own writing of it.
    pub(super) fn is_echo(&self, kind: PlanKind, now: MonoTime) -> bool {
        self.echo(kind, now).is_some()
    }

    /// Until when that is so; `None` when it is over.
    fn echo_until(&self, kind: PlanKind, now: MonoTime) -> Option<MonoTime> {
        self.echo(kind, now).map(|written| written.at + TRANSFER_ECHO)
    }

    /// Our last writing of a plan, while what is said of the plan may be about that.
    pub(super) fn echo(&self, kind: PlanKind, now: MonoTime) -> Option<Written> {
        self.written[kind as usize].filter(|written| !written.is_unfinished && now < written.at + TRANSFER_ECHO)
    }

    pub(super) fn on_restart(&mut self, since: MonoTime, now: MonoTime) {
        if self.restarted_at.is_some_and(|restarted| now.since(restarted) < RESTART_ONCE) {
            return;
        }
        self.end_life(since, now);
        self.on_board_restarted(since, now);
    }

    /// Everything from before `since` is of a former life, or of another aircraft: telemetry is forgotten, requests under way end.
    pub(super) fn end_life(&mut self, since: MonoTime, now: MonoTime) {
        self.restarted_at = Some(now);
        self.telemetry.forget_before(since);
        self.told = Told { mode: self.told.mode, is_armed: self.told.is_armed, ..Told::default() };
        self.tracker.reset();
        self.mission_ids = None;
        self.events.reset();
        // It may come back with another firmware.
        self.shown_encodings = ShownEncodings::default();
        self.event(VehicleEvent::Rebooted);
        for mut lane in [self.transfer.take(), self.param.take()].into_iter().flatten() {
            lane.machine.cancel(now);
            while let Some(output) = lane.machine.poll_output() {
                if let TransferOutput::Send(message) = output {
                    self.outputs.push_back(Output::Send(message));
                }
            }
        }
        let asked = std::mem::take(&mut self.ops).into_iter().filter(|op| !self.on_board.is_own(op.id));
        for op in asked.collect::<Vec<_>>() {
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
        self.on_board.own = None;
        self.streams.ask(&mut self.commands, now);
    }
}
